//! An image that a frame is drawn to when there is no window, or beside it for a screenshot.

use prism_engine::{
    error::Result,
    gpu::{self, Access, CommandEncoder, Context, Image, ImageDesc, vk},
};

use super::picture::Picture;

/// The format of headless pictures: every device can draw to it.
pub const FORMAT: vk::Format = vk::Format::R8G8B8A8_SRGB;

/// A colour image that can be drawn to and read back.
pub struct Offscreen {
    ctx: Context,
    image: Image,
}

impl Offscreen {
    /// Makes an image of so many pixels, in an 8-bit RGBA or BGRA format.
    ///
    /// # Errors
    /// `Unsupported` above the device's limit.
    pub fn new(ctx: &Context, extent: [u32; 2], format: vk::Format) -> Result<Offscreen> {
        let usage = vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::TRANSFER_SRC;
        let image = Image::new(ctx, &ImageDesc { name: "picture", extent, format, usage, ..ImageDesc::default() })?;
        Ok(Offscreen { ctx: ctx.clone(), image })
    }

    /// What a renderer draws to, after [`Self::prepare`].
    pub fn image(&self) -> &Image {
        &self.image
    }

    /// Makes the image ready for a frame, which overwrites what an earlier one drew.
    pub fn prepare(&self, cmd: &mut CommandEncoder) {
        cmd.image_barrier(&self.image, Access::COLOR_WRITE.discarded(), Access::COLOR_WRITE);
    }

    /// The last frame. Waits for the GPU.
    pub fn read(&self) -> Result<Picture> {
        let mut pixels = gpu::read_image(&self.ctx, &self.image, Access::COLOR_WRITE)?;
        if matches!(self.image.format(), vk::Format::B8G8R8A8_SRGB | vk::Format::B8G8R8A8_UNORM) {
            pixels.chunks_exact_mut(4).for_each(|pixel| pixel.swap(0, 2));
        }
        Ok(Picture::from_bytes(self.image.extent(), &pixels))
    }
}
