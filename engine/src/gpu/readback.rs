//! Images and buffers back to the CPU.

use ash::vk;
use bytemuck::Pod;

use super::{
    access::Access,
    device::Context,
    frame::run_once,
    memory::{Buffer, BufferDesc, Image, MemoryLocation, format_bytes},
};
use crate::error::{Error, Result};

/// A buffer that holds mip 0 of `image`, tightly packed, and can be read by the CPU.
pub fn readback_buffer(ctx: &Context, image: &Image) -> Result<Buffer> {
    let [width, height] = image.extent();
    let texel = format_bytes(image.format()).ok_or_else(|| {
        Error::gpu(format!("reading image '{}'", image.name()), format!("{:?} is not known", image.format()))
    })?;
    Buffer::new(
        ctx,
        &BufferDesc {
            name: &format!("readback of {}", image.name()),
            size: u64::from(width) * u64::from(height) * texel,
            usage: vk::BufferUsageFlags::TRANSFER_DST,
            location: MemoryLocation::GpuToCpu,
        },
    )
}

/// The texels of mip 0, row 0 first, tightly packed in the image's format. Waits for the GPU.
///
/// `current` is the image's last access, to which it returns. The image needs `TRANSFER_SRC` usage.
pub fn read_image(ctx: &Context, image: &Image, current: Access) -> Result<Vec<u8>> {
    let buffer = readback_buffer(ctx, image)?;
    run_once(ctx, |cmd| {
        cmd.region("readback", |cmd| {
            cmd.image_barrier(image, current, Access::TRANSFER_SRC);
            cmd.copy_image_to_buffer(image, &buffer);
            cmd.buffer_barrier(&buffer, Access::TRANSFER_DST, Access::HOST_READ);
            cmd.image_barrier(image, Access::TRANSFER_SRC, current);
        });
        Ok(())
    })?;
    let mut bytes: Vec<u8> = buffer.read()?;
    let [width, height] = image.extent();
    let texel = format_bytes(image.format()).unwrap_or_default();
    // Tiny images have a buffer of Vulkan's least size.
    bytes.truncate((u64::from(width) * u64::from(height) * texel) as usize);
    Ok(bytes)
}

/// The content of a buffer with `TRANSFER_SRC` usage. Waits for the GPU. `current` is the buffer's last access.
pub fn read_buffer<T: Pod>(ctx: &Context, buffer: &Buffer, current: Access) -> Result<Vec<T>> {
    let copy = Buffer::new(
        ctx,
        &BufferDesc {
            name: &format!("readback of {}", buffer.name()),
            size: buffer.size(),
            usage: vk::BufferUsageFlags::TRANSFER_DST,
            location: MemoryLocation::GpuToCpu,
        },
    )?;
    run_once(ctx, |cmd| {
        cmd.buffer_barrier(buffer, current, Access::TRANSFER_SRC);
        cmd.copy_buffer(buffer, 0, &copy, 0, buffer.size());
        cmd.buffer_barrier(&copy, Access::TRANSFER_DST, Access::HOST_READ);
        Ok(())
    })?;
    copy.read()
}
