//! Frames in flight: a command buffer, a fence and a ticket each.

use std::sync::Arc;

use ash::vk;

use super::{device::Context, encoder::CommandEncoder, retire::Ticket};
use crate::error::{Error, Result};

/// A ring of frames. While the GPU runs one, the next is recorded.
pub struct Frames {
    ctx: Context,
    slots: Vec<Slot>,
    /// Frames begun so far.
    count: u64,
}

struct Slot {
    pool: vk::CommandPool,
    cmd: vk::CommandBuffer,
    fence: vk::Fence,
    /// Present while the GPU may run the slot's commands.
    submitted: Option<Ticket>,
    /// Shared with the slot's [`Frame`] while it is being recorded.
    lease: Arc<()>,
}

/// A frame that is being recorded. Dropped without being submitted, its commands are forgotten.
pub struct Frame {
    /// Records the frame.
    pub cmd: CommandEncoder,
    slot: usize,
    index: u64,
    ticket: Ticket,
    _lease: Arc<()>,
}

impl Frame {
    /// Which of the frames in flight this is.
    pub fn slot(&self) -> usize {
        self.slot
    }

    /// Frames begun before this one.
    pub fn index(&self) -> u64 {
        self.index
    }
}

impl Frames {
    /// `in_flight` frames, at least 1.
    pub fn new(ctx: &Context, in_flight: usize) -> Result<Self> {
        let mut frames = Frames { ctx: ctx.clone(), slots: Vec::new(), count: 0 };
        for index in 0..in_flight.max(1) {
            // Pushed one by one, so that those made are destroyed if the next fails.
            let slot = Slot::new(ctx, index).map_err(|e| Error::gpu(format!("creating frame slot {index}"), e))?;
            frames.slots.push(slot);
        }
        Ok(frames)
    }

    /// How many frames may be in flight.
    pub fn in_flight(&self) -> usize {
        self.slots.len()
    }

    /// Begins the next frame, after waiting for the one that had its slot. What that one held back is destroyed.
    ///
    /// # Errors
    /// Every frame in flight is still being recorded, or the device is lost.
    pub fn begin(&mut self) -> Result<Frame> {
        let index = self.count;
        let at = (index % self.slots.len() as u64) as usize;
        let fail = |e: vk::Result| self.ctx.failure(format!("beginning frame {index}"), e);
        let slot = &mut self.slots[at];
        if Arc::strong_count(&slot.lease) > 1 {
            return Err(Error::gpu(format!("beginning frame {index}"), "its slot is still being recorded"));
        }
        slot.wait(&self.ctx).map_err(fail)?;
        let device = self.ctx.device();
        // SAFETY: the GPU is done with the slot's commands, and no encoder for them is left.
        unsafe { device.reset_command_pool(slot.pool, vk::CommandPoolResetFlags::empty()) }.map_err(fail)?;
        let once = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: the command buffer was just reset.
        unsafe { device.begin_command_buffer(slot.cmd, &once) }.map_err(fail)?;
        self.count += 1;
        Ok(Frame {
            cmd: CommandEncoder::from_raw(&self.ctx, slot.cmd),
            slot: at,
            index,
            ticket: self.ctx.ticket(),
            _lease: slot.lease.clone(),
        })
    }

    /// Hands the frame to the GPU.
    pub fn submit(&mut self, frame: Frame) -> Result<()> {
        self.submit_with(frame, &[], &[])
    }

    /// Hands the frame to the GPU and waits until it has run; work submitted earlier has run then too.
    pub fn submit_and_wait(&mut self, frame: Frame) -> Result<()> {
        let (slot, index) = (frame.slot, frame.index);
        self.submit(frame)?;
        self.slots[slot].wait(&self.ctx).map_err(|e| self.ctx.failure(format!("waiting for frame {index}"), e))
    }

    /// [`Self::submit`], waiting for and signalling semaphores.
    pub fn submit_with(
        &mut self,
        frame: Frame,
        wait: &[vk::SemaphoreSubmitInfo<'_>],
        signal: &[vk::SemaphoreSubmitInfo<'_>],
    ) -> Result<()> {
        let slot = &mut self.slots[frame.slot];
        let fail = |e: vk::Result| self.ctx.failure(format!("submitting frame {}", frame.index), e);
        let device = self.ctx.device();
        // SAFETY: the command buffer is recording, and the frame, its only user, ends here.
        unsafe { device.end_command_buffer(slot.cmd) }.map_err(fail)?;
        // SAFETY: the fence's last submission was waited for when the frame began.
        unsafe { device.reset_fences(&[slot.fence]) }.map_err(fail)?;
        let commands = [vk::CommandBufferSubmitInfo::default().command_buffer(slot.cmd)];
        let submit = [vk::SubmitInfo2::default()
            .command_buffer_infos(&commands)
            .wait_semaphore_infos(wait)
            .signal_semaphore_infos(signal)];
        {
            let queue = self.ctx.queue();
            // SAFETY: the queue is locked; commands, semaphores and fence are alive and the fence is unsignalled.
            unsafe { device.queue_submit2(*queue, &submit, slot.fence) }.map_err(fail)?;
        }
        slot.submitted = Some(frame.ticket);
        Ok(())
    }

    /// Waits for all frames.
    pub fn wait(&mut self) -> Result<()> {
        for slot in &mut self.slots {
            slot.wait(&self.ctx).map_err(|e| self.ctx.failure("waiting for the frames in flight", e))?;
        }
        Ok(())
    }
}

impl Slot {
    fn new(ctx: &Context, index: usize) -> std::result::Result<Self, vk::Result> {
        let device = ctx.device();
        let info = vk::CommandPoolCreateInfo::default()
            .queue_family_index(ctx.inner().queue_family)
            .flags(vk::CommandPoolCreateFlags::TRANSIENT);
        // SAFETY: the family is the device's.
        let pool = unsafe { device.create_command_pool(&info, None) }?;
        let info = vk::CommandBufferAllocateInfo::default().command_pool(pool).command_buffer_count(1);
        // SAFETY: the pool was just made.
        let cmd = unsafe { device.allocate_command_buffers(&info) };
        // SAFETY: no requirements.
        let fence = unsafe { device.create_fence(&vk::FenceCreateInfo::default(), None) };
        match (cmd, fence) {
            (Ok(cmd), Ok(fence)) => {
                ctx.set_name(pool, &format!("frame slot {index}: pool"));
                ctx.set_name(cmd[0], &format!("frame slot {index}: commands"));
                ctx.set_name(fence, &format!("frame slot {index}: fence"));
                Ok(Slot { pool, cmd: cmd[0], fence, submitted: None, lease: Arc::new(()) })
            }
            (cmd, fence) => {
                let error = cmd.err().or(fence.err()).expect("one of them failed");
                // SAFETY: nothing uses the new objects; destroying a null fence is allowed.
                unsafe {
                    device.destroy_fence(fence.unwrap_or_default(), None);
                    device.destroy_command_pool(pool, None);
                }
                Err(error)
            }
        }
    }

    fn wait(&mut self, ctx: &Context) -> std::result::Result<(), vk::Result> {
        if self.submitted.is_some() {
            // SAFETY: the fence is alive and was submitted.
            unsafe { ctx.device().wait_for_fences(&[self.fence], true, u64::MAX) }?;
            self.submitted = None;
        }
        Ok(())
    }
}

impl Drop for Frames {
    fn drop(&mut self) {
        for slot in &mut self.slots {
            if let Err(e) = slot.wait(&self.ctx) {
                tracing::error!("waiting for a frame in flight: {e}");
            }
            // SAFETY: the GPU is done with the slot (a lost device never will run it). A `Frame` that outlives its
            // ring can only be dropped, which touches no Vulkan object of the slot.
            unsafe {
                self.ctx.device().destroy_fence(slot.fence, None);
                self.ctx.device().destroy_command_pool(slot.pool, None);
            }
        }
    }
}

/// Records commands, runs them and waits. For loading and readback, not for frames.
pub fn run_once<R>(ctx: &Context, body: impl FnOnce(&mut CommandEncoder) -> Result<R>) -> Result<R> {
    let mut frames = Frames::new(ctx, 1)?;
    let mut frame = frames.begin()?;
    let result = body(&mut frame.cmd)?;
    frames.submit_and_wait(frame)?;
    Ok(result)
}
