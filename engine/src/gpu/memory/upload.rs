//! Data to the GPU, through staging memory of bounded size.

use ash::vk;
use bytemuck::Pod;
use gpu_allocator::MemoryLocation;

use super::{Buffer, BufferDesc, Image, ImageDesc, format_bytes, full_mip_count};
use crate::{
    error::{Error, Result},
    gpu::{
        access::Access,
        device::Context,
        encoder::CommandEncoder,
        frame::{Frame, Frames},
    },
};

/// Bytes staged before a submission; larger data go in several.
const CHUNK: u64 = 16 << 20;
/// Every texel size divides this, and Vulkan wants copies at multiples of texel size and of 4.
const ALIGN: u64 = 16;

/// Copies data into new buffers and images. Nothing is complete before [`Self::finish`].
pub struct Uploader {
    ctx: Context,
    frames: Frames,
    /// Made with the first data.
    staging: Option<Buffer>,
    used: u64,
    recording: Option<Frame>,
}

impl Uploader {
    /// An uploader with nothing staged.
    pub fn new(ctx: &Context) -> Result<Self> {
        Ok(Uploader { ctx: ctx.clone(), frames: Frames::new(ctx, 1)?, staging: None, used: 0, recording: None })
    }

    /// A buffer with this content; `usage` need not name the transfer. Ready for any shader or as indices.
    pub fn buffer<T: Pod>(&mut self, name: &str, usage: vk::BufferUsageFlags, data: &[T]) -> Result<Buffer> {
        let bytes: &[u8] = bytemuck::cast_slice(data);
        let buffer = Buffer::new(
            &self.ctx,
            &BufferDesc {
                name,
                size: bytes.len() as u64,
                usage: usage | vk::BufferUsageFlags::TRANSFER_DST,
                location: MemoryLocation::GpuOnly,
            },
        )?;
        let mut done = 0;
        while done < bytes.len() {
            let (at, room) = self.room(1)?;
            let part = &bytes[done..bytes.len().min(done + room as usize)];
            let (cmd, staging) = self.stage(at, part)?;
            cmd.copy_buffer(staging, at, &buffer, done as u64, part.len() as u64);
            done += part.len();
        }
        let any_read = Access::new(
            vk::PipelineStageFlags2::ALL_COMMANDS,
            vk::AccessFlags2::MEMORY_READ,
            vk::ImageLayout::UNDEFINED,
        );
        self.commands()?.buffer_barrier(&buffer, Access::TRANSFER_DST, any_read);
        Ok(buffer)
    }

    /// An image whose mip 0 holds `level0` (row 0 first, tightly packed); further mips stay undefined. `usage` need
    /// not name the transfer. Ends at [`Access::SHADER_READ`].
    pub fn image(&mut self, desc: &ImageDesc<'_>, level0: &[u8]) -> Result<Image> {
        let usage = desc.usage | vk::ImageUsageFlags::TRANSFER_DST;
        let image = Image::new(&self.ctx, &ImageDesc { usage, ..*desc })?;
        self.fill(&image, level0)?;
        self.commands()?.image_barrier(&image, Access::TRANSFER_DST, Access::SHADER_READ);
        Ok(image)
    }

    /// [`Self::image`] with all mips, each averaged from the one above (in linear light for sRGB formats); the
    /// description's mip count is ignored.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if the device cannot scale this format.
    pub fn image_with_mips(&mut self, desc: &ImageDesc<'_>, level0: &[u8]) -> Result<Image> {
        use vk::FormatFeatureFlags as F;
        if !self.ctx.supports_format(desc.format, F::BLIT_SRC | F::BLIT_DST | F::SAMPLED_IMAGE_FILTER_LINEAR) {
            return Err(Error::unsupported(
                format!("image '{}': {} cannot scale {:?}", desc.name, self.ctx.device_name(), desc.format),
                "choose another device with --gpu",
            ));
        }
        let usage = desc.usage | vk::ImageUsageFlags::TRANSFER_DST | vk::ImageUsageFlags::TRANSFER_SRC;
        let mips = full_mip_count(desc.extent);
        let image = Image::new(&self.ctx, &ImageDesc { usage, mips, ..*desc })?;
        self.fill(&image, level0)?;
        let cmd = self.commands()?;
        for mip in 1..mips {
            cmd.image_barrier_mips(&image, mip - 1, 1, Access::TRANSFER_DST, Access::TRANSFER_SRC);
            cmd.blit(&image, mip - 1, &image, mip, vk::Filter::LINEAR);
        }
        if mips > 1 {
            cmd.image_barrier_mips(&image, 0, mips - 1, Access::TRANSFER_SRC, Access::SHADER_READ);
        }
        cmd.image_barrier_mips(&image, mips - 1, 1, Access::TRANSFER_DST, Access::SHADER_READ);
        Ok(image)
    }

    /// Submits what is left and waits for it.
    pub fn finish(mut self) -> Result<()> {
        self.flush()
    }

    /// Mip 0 from `level0`; leaves all mips at `TRANSFER_DST`.
    fn fill(&mut self, image: &Image, level0: &[u8]) -> Result<()> {
        let [width, height] = image.extent();
        let fail = |cause: String| Error::gpu(format!("uploading image '{}'", image.name()), cause);
        let texel = format_bytes(image.format()).ok_or_else(|| fail(format!("{:?} is not known", image.format())))?;
        let row = u64::from(width) * texel;
        if level0.len() as u64 != row * u64::from(height) {
            let wanted = row * u64::from(height);
            return Err(fail(format!("{} bytes given, {width}x{height} needs {wanted}", level0.len())));
        }
        self.commands()?.image_barrier(image, Access::UNDEFINED, Access::TRANSFER_DST);
        let mut first = 0;
        while first < height {
            let (at, room) = self.room(row)?;
            let rows = (room / row).min(u64::from(height - first)) as u32;
            let bytes = &level0[(u64::from(first) * row) as usize..(u64::from(first + rows) * row) as usize];
            let (cmd, staging) = self.stage(at, bytes)?;
            cmd.copy_buffer_to_image(staging, at, image, first, rows);
            first += rows;
        }
        Ok(())
    }

    /// Offset and size of the free staging memory, at least `least` bytes; submits what is staged to get it.
    fn room(&mut self, least: u64) -> Result<(u64, u64)> {
        debug_assert!(least <= CHUNK, "one row of the largest image fits");
        if CHUNK - self.used < least {
            self.flush()?;
        }
        Ok((self.used, CHUNK - self.used))
    }

    /// Writes to staging memory that [`Self::room`] found.
    fn stage(&mut self, at: u64, bytes: &[u8]) -> Result<(&mut CommandEncoder, &Buffer)> {
        if self.staging.is_none() {
            let desc = BufferDesc {
                name: "upload staging",
                size: CHUNK,
                usage: vk::BufferUsageFlags::TRANSFER_SRC,
                location: MemoryLocation::CpuToGpu,
            };
            self.staging = Some(Buffer::new(&self.ctx, &desc)?);
        }
        self.commands()?;
        let (Some(frame), Some(staging)) = (&mut self.recording, &self.staging) else {
            unreachable!("both were just made");
        };
        staging.write(at, bytes)?;
        self.used = (at + bytes.len() as u64).next_multiple_of(ALIGN).min(CHUNK);
        Ok((&mut frame.cmd, staging))
    }

    fn commands(&mut self) -> Result<&mut CommandEncoder> {
        let frame = match self.recording.take() {
            Some(frame) => frame,
            None => self.frames.begin()?,
        };
        Ok(&mut self.recording.insert(frame).cmd)
    }

    fn flush(&mut self) -> Result<()> {
        if let Some(frame) = self.recording.take() {
            self.frames.submit_and_wait(frame)?;
        }
        self.used = 0;
        Ok(())
    }
}
