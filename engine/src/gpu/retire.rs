//! The deletion queue: a dropped resource is destroyed when no recording that could use it is left.

use std::{
    collections::{BTreeSet, VecDeque},
    sync::{Mutex, PoisonError},
};

use ash::vk;
use gpu_allocator::vulkan::{Allocation, Allocator};

use super::device::Context;

/// What a dropped owner leaves behind.
pub(super) enum Retired {
    Buffer(vk::Buffer, Allocation),
    View(vk::ImageView),
    Image(vk::Image, Allocation),
    Pipeline(vk::Pipeline, vk::PipelineLayout, Vec<vk::DescriptorSetLayout>),
    Set(vk::DescriptorPool, vk::DescriptorSet),
    QueryPool(vk::QueryPool),
    #[cfg(feature = "window")]
    Semaphore(vk::Semaphore),
    #[cfg(feature = "window")]
    Swapchain(ash::khr::swapchain::Device, vk::SwapchainKHR),
}

/// Commands that are being recorded, or that the GPU may still run. Nothing that was alive while it was is destroyed
/// before it is dropped. [`super::Frames`] holds one for each frame; a host that submits its own command buffers
/// takes one before recording and drops it after its fence.
pub struct Ticket {
    ctx: Context,
    id: u64,
}

impl Ticket {
    pub(super) fn new(ctx: &Context) -> Self {
        let mut queue = ctx.retirement();
        let id = queue.next;
        queue.next += 1;
        queue.live.insert(id);
        drop(queue);
        Ticket { ctx: ctx.clone(), id }
    }
}

impl Drop for Ticket {
    fn drop(&mut self) {
        self.ctx.retirement().live.remove(&self.id);
        self.ctx.collect();
    }
}

/// Retired objects in the order of their retirement, and the recordings that hold them back.
#[derive(Default)]
pub(super) struct Retirement {
    next: u64,
    live: BTreeSet<u64>,
    /// With the number of tickets issued when the object was dropped: later recordings cannot know it.
    queue: VecDeque<(u64, Retired)>,
}

impl Retirement {
    pub fn push(&mut self, object: Retired) {
        self.queue.push_back((self.next, object));
    }

    /// Takes what no live ticket is older than.
    pub fn take_free(&mut self) -> Vec<Retired> {
        let oldest = self.live.first().copied().unwrap_or(u64::MAX);
        let held = self.queue.iter().position(|(issued, _)| oldest < *issued);
        self.queue.drain(..held.unwrap_or(self.queue.len())).map(|(_, object)| object).collect()
    }

    /// Takes everything. The device must be idle.
    pub fn take_all(&mut self) -> Vec<Retired> {
        self.queue.drain(..).map(|(_, object)| object).collect()
    }
}

/// Destroys what was taken from the queue.
///
/// # Safety
/// The GPU no longer uses any of `objects`, all of them were made by `device` and `allocator`.
pub(super) unsafe fn destroy(device: &ash::Device, allocator: &Mutex<Allocator>, objects: Vec<Retired>) {
    let free = |allocation: Allocation, name: &str| {
        if let Err(e) = allocator.lock().unwrap_or_else(PoisonError::into_inner).free(allocation) {
            tracing::error!("freeing the memory of a {name}: {e}");
        }
    };
    for object in objects {
        // SAFETY: by this function's contract nothing uses the object, and its owner is gone.
        unsafe {
            match object {
                Retired::Buffer(buffer, allocation) => {
                    device.destroy_buffer(buffer, None);
                    free(allocation, "buffer");
                }
                Retired::View(view) => device.destroy_image_view(view, None),
                Retired::Image(image, allocation) => {
                    device.destroy_image(image, None);
                    free(allocation, "image");
                }
                Retired::Pipeline(pipeline, layout, sets) => {
                    device.destroy_pipeline(pipeline, None);
                    device.destroy_pipeline_layout(layout, None);
                    sets.into_iter().for_each(|set| device.destroy_descriptor_set_layout(set, None));
                }
                Retired::Set(pool, set) => {
                    // Cannot fail: the specification gives this call no error.
                    let _ = device.free_descriptor_sets(pool, &[set]);
                }
                Retired::QueryPool(pool) => device.destroy_query_pool(pool, None),
                #[cfg(feature = "window")]
                Retired::Semaphore(semaphore) => device.destroy_semaphore(semaphore, None),
                #[cfg(feature = "window")]
                Retired::Swapchain(fns, chain) => fns.destroy_swapchain(chain, None),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn objects_wait_for_older_recordings_only() {
        let mut r = Retirement { next: 2, live: BTreeSet::from([0, 1]), queue: VecDeque::new() };
        r.push(Retired::View(vk::ImageView::null()));
        r.live.insert(2);
        r.next = 3;
        r.push(Retired::View(vk::ImageView::null()));
        assert!(r.take_free().is_empty());
        r.live.remove(&0);
        assert!(r.take_free().is_empty());
        r.live.remove(&1);
        assert_eq!(r.take_free().len(), 1, "recording 2 began after the first was dropped");
        r.live.remove(&2);
        assert_eq!(r.take_free().len(), 1);
    }
}
