//! Buffers.

use std::sync::Mutex;

use ash::vk;
use bytemuck::Pod;
use gpu_allocator::{
    MemoryLocation,
    vulkan::{Allocation, AllocationCreateDesc, AllocationScheme},
};

use crate::{
    error::{Error, Result},
    gpu::{
        device::{Context, lock},
        retire::Retired,
    },
};

/// What a buffer is for.
#[derive(Clone, Copy, Debug)]
pub struct BufferDesc<'a> {
    /// Debug name, also of its memory.
    pub name: &'a str,
    /// Bytes; 0 becomes the smallest buffer Vulkan allows, so that empty lists need no special case.
    pub size: u64,
    /// How it may be used.
    pub usage: vk::BufferUsageFlags,
    /// Where it lives: `CpuToGpu` can be written, `GpuToCpu` can be read by the CPU.
    pub location: MemoryLocation,
}

/// A buffer with its memory.
pub struct Buffer {
    ctx: Context,
    raw: vk::Buffer,
    /// Taken on drop. The lock makes CPU writes through a shared reference safe.
    allocation: Mutex<Option<Allocation>>,
    size: u64,
    usage: vk::BufferUsageFlags,
    name: String,
}

impl Buffer {
    /// Makes a buffer; its content is undefined.
    pub fn new(ctx: &Context, desc: &BufferDesc<'_>) -> Result<Self> {
        let fail = |e: String| Error::gpu(format!("creating buffer '{}' of {} bytes", desc.name, desc.size), e);
        let size = desc.size.max(4);
        let info = vk::BufferCreateInfo::default().size(size).usage(desc.usage);
        // SAFETY: the info is complete; sharing is exclusive to the only queue.
        let raw = unsafe { ctx.device().create_buffer(&info, None) }.map_err(|e| fail(e.to_string()))?;
        // SAFETY: the buffer was just made by this device.
        let requirements = unsafe { ctx.device().get_buffer_memory_requirements(raw) };
        let allocation = ctx.allocator().allocate(&AllocationCreateDesc {
            name: desc.name,
            requirements,
            location: desc.location,
            linear: true,
            allocation_scheme: AllocationScheme::GpuAllocatorManaged,
        });
        let allocation = match allocation {
            Ok(allocation) => allocation,
            Err(e) => {
                // SAFETY: nothing uses the new buffer.
                unsafe { ctx.device().destroy_buffer(raw, None) };
                return Err(fail(e.to_string()));
            }
        };
        ctx.set_name(raw, desc.name);
        // SAFETY: the allocation meets the buffer's requirements and is bound to nothing else.
        let bound = unsafe { ctx.device().bind_buffer_memory(raw, allocation.memory(), allocation.offset()) };
        let allocation = Mutex::new(Some(allocation));
        let buffer = Buffer { ctx: ctx.clone(), raw, allocation, size, usage: desc.usage, name: desc.name.to_owned() };
        bound.map_err(|e| fail(e.to_string()))?;
        Ok(buffer)
    }

    /// Copies `data` to byte `offset`. The GPU must not be reading there.
    ///
    /// # Errors
    /// Past the end, or not `CpuToGpu` memory.
    pub fn write<T: Pod>(&self, offset: u64, data: &[T]) -> Result<()> {
        let bytes: &[u8] = bytemuck::cast_slice(data);
        let mut allocation = lock(&self.allocation);
        let mapped = allocation.as_mut().and_then(|a| a.mapped_slice_mut());
        let mapped = mapped.ok_or_else(|| self.misuse("writing", "its memory cannot be mapped"))?;
        let range = self.range(offset, bytes.len()).ok_or_else(|| self.misuse("writing", "past its end"))?;
        mapped[range].copy_from_slice(bytes);
        Ok(())
    }

    /// The whole content as values of `T`; bytes that do not fill one are left out. The GPU must be done writing, and
    /// a barrier to [`Access::HOST_READ`](crate::gpu::Access::HOST_READ) must stand after its writes.
    ///
    /// # Errors
    /// Not memory that the CPU can read.
    pub fn read<T: Pod>(&self) -> Result<Vec<T>> {
        let allocation = lock(&self.allocation);
        let mapped = allocation.as_ref().and_then(|a| a.mapped_slice());
        let mapped = mapped.ok_or_else(|| self.misuse("reading", "its memory cannot be mapped"))?;
        let count = self.size as usize / size_of::<T>().max(1);
        let mut values = vec![T::zeroed(); count];
        let bytes: &mut [u8] = bytemuck::cast_slice_mut(&mut values);
        bytes.copy_from_slice(&mapped[..bytes.len()]);
        Ok(values)
    }

    fn range(&self, offset: u64, len: usize) -> Option<std::ops::Range<usize>> {
        let end = offset.checked_add(len as u64).filter(|end| *end <= self.size)?;
        Some(offset as usize..end as usize)
    }

    fn misuse(&self, doing: &str, cause: &str) -> Error {
        Error::gpu(format!("{doing} buffer '{}' of {} bytes", self.name, self.size), cause)
    }

    /// The Vulkan handle.
    pub fn handle(&self) -> vk::Buffer {
        self.raw
    }

    /// Bytes.
    pub fn size(&self) -> u64 {
        self.size
    }

    /// Debug name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// How it may be used.
    pub fn usage(&self) -> vk::BufferUsageFlags {
        self.usage
    }
}

impl Drop for Buffer {
    fn drop(&mut self) {
        if let Some(allocation) = lock(&self.allocation).take() {
            self.ctx.retire(Retired::Buffer(self.raw, allocation));
        }
    }
}
