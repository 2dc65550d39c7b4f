//! A user interface (egui) over a picture.

use ash::vk;
use egui::{ClippedPrimitive, TextureId, TexturesDelta};
use egui_ash_renderer::{DynamicRendering, Options, RenderMode, Renderer, RendererError, allocator::GpuAllocator};

use super::{
    access::Access,
    device::Context,
    encoder::{Attachment, CommandEncoder, Load, RenderingDesc},
    memory::Image,
};
use crate::error::{Error, Result};

/// Draws what egui has tessellated. Fields drop in this order: all of it before the device.
pub struct Overlay {
    renderer: Renderer<GpuAllocator>,
    pool: CommandPool,
    /// Textures that the last frame was the last to show.
    unused: Vec<TextureId>,
    ctx: Context,
}

/// For the uploads of textures.
struct CommandPool {
    raw: vk::CommandPool,
    ctx: Context,
}

impl Drop for CommandPool {
    fn drop(&mut self) {
        // SAFETY: uploads are waited for, so no command buffer of it is pending.
        unsafe { self.ctx.device().destroy_command_pool(self.raw, None) };
    }
}

impl Overlay {
    /// For pictures of `format`, with so many frames in flight.
    pub fn new(ctx: &Context, format: vk::Format, in_flight: usize) -> Result<Self> {
        let mode = DynamicRendering {
            color_attachment_format: format,
            depth_attachment_format: None,
            stencil_attachment_format: None,
        };
        let srgb_framebuffer = matches!(format, vk::Format::R8G8B8A8_SRGB | vk::Format::B8G8R8A8_SRGB);
        let options = Options { in_flight_frames: in_flight, srgb_framebuffer, ..Options::default() };
        let renderer = Renderer::with_gpu_allocator(
            ctx.shared_allocator(),
            ctx.device().clone(),
            RenderMode::DynamicRendering(mode),
            options,
        )
        .map_err(failed)?;
        let info = vk::CommandPoolCreateInfo::default()
            .flags(vk::CommandPoolCreateFlags::TRANSIENT)
            .queue_family_index(ctx.inner().queue_family);
        // SAFETY: the device is alive; the pool is destroyed before it.
        let raw = unsafe { ctx.device().create_command_pool(&info, None) };
        let raw = raw.map_err(|e| Error::gpu("creating the panel's command pool", e))?;
        Ok(Overlay { renderer, pool: CommandPool { raw, ctx: ctx.clone() }, unused: Vec::new(), ctx: ctx.clone() })
    }

    /// Brings the textures up to date: before the frame that shows them. Where any changes, the device is waited for: an
    /// earlier frame may still read it.
    pub fn update(&mut self, mut textures: TexturesDelta) -> Result<()> {
        if textures.set.is_empty() && textures.free.is_empty() && self.unused.is_empty() {
            return Ok(());
        }
        let (changed, freed) = (std::mem::take(&mut textures.set), std::mem::take(&mut textures.free));
        self.ctx.wait_idle()?;
        for id in self.unused.drain(..) {
            self.renderer.free_texture(id).map_err(failed)?;
        }
        let queue = self.ctx.queue();
        for (id, deltas) in &changed {
            for delta in deltas {
                self.renderer.set_texture(*queue, self.pool.raw, *id, delta).map_err(failed)?;
            }
        }
        self.unused.extend(freed);
        Ok(())
    }

    /// Draws over `target`, at [`Access::COLOR_WRITE`] before and after.
    pub fn record(
        &mut self,
        cmd: &mut CommandEncoder,
        target: &Image,
        pixels_per_point: f32,
        primitives: &[ClippedPrimitive],
    ) -> Result<()> {
        cmd.image_barrier(target, Access::COLOR_WRITE, Access::COLOR_WRITE);
        let extent = target.extent();
        cmd.begin_rendering(&RenderingDesc {
            name: "panel",
            color: &[Attachment { image: target, load: Load::Keep, store: true, resolve: None }],
            depth: None,
            extent,
        });
        let [width, height] = extent;
        let drawn = self.renderer.cmd_draw(cmd.raw(), vk::Extent2D { width, height }, pixels_per_point, primitives);
        cmd.end_rendering();
        drawn.map_err(failed)
    }
}

impl Drop for Overlay {
    fn drop(&mut self) {
        // Its buffers are destroyed at once, and a frame may still read them.
        let _ = self.ctx.wait_idle();
    }
}

fn failed(cause: RendererError) -> Error {
    Error::gpu("drawing the panel", cause)
}
