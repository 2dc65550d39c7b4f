//! The visibility buffer (Burns and Hunt 2013, "The Visibility Buffer"): which lid a pixel's ray meets first. Walks begin
//! there in a pass over the picture, in which every pixel of a quad has one to trace; rasterised, most quads of small
//! triangles lie across an edge and run once for each side, and once for each lid behind.
//!
//! A ray that leaves the shell unhit, or that enters another one nearer than its hit, is drawn by the lid where that
//! happens: a last pass rasterises all lids once more, and traces where the lid is not the one named and not behind the
//! depth so far. So the picture is the same to the bit.

use super::passes::Part;
use crate::error::Result;
use crate::gpu::{
    Access, Attachment, Binding, CommandEncoder, Context, DepthAttachment, Image, ImageDesc, Load, RenderingDesc,
    Sampler, SamplerDesc, vk,
};

/// Name of the pass that writes it, as in `--stats`.
pub const PASS: &str = "visibility";

/// Name of the pass that draws what the walks from it have not.
pub const REST: &str = "shell rest";

/// Draws that it can name, and prisms of each: see `shaders/render/nearest_lid.glsl`.
pub const MAX_DRAWS: usize = 255;
/// See [`MAX_DRAWS`].
pub const MAX_PRISMS: usize = 1 << 24;

/// Lids are named by draw and prism, and by the bits of the level that the ray meets them at.
pub const FORMAT: vk::Format = vk::Format::R32G32_UINT;

/// Its images: the nearest lids; and the depth, of those while they are drawn, then a copy of the picture's, which its
/// own pass cannot read.
pub const IMAGES: [(&str, vk::Format); 2] = [("nearest lids", FORMAT), ("depth so far", super::DEPTH_FORMAT)];

/// The buffer of one picture.
pub struct Visibility {
    lids: Image,
    depth: Image,
    sampler: Sampler,
}

impl Visibility {
    /// For a picture of this size.
    pub fn new(ctx: &Context, extent: [u32; 2]) -> Result<Self> {
        use vk::ImageUsageFlags as U;
        let image = |(name, format), usage| {
            let samples = vk::SampleCountFlags::TYPE_1;
            Image::new(ctx, &ImageDesc { name, extent, format, mips: 1, samples, usage: usage | U::SAMPLED })
        };
        let [lids, depth] = IMAGES;
        Ok(Visibility {
            lids: image(lids, U::COLOR_ATTACHMENT)?,
            depth: image(depth, U::DEPTH_STENCIL_ATTACHMENT | U::TRANSFER_DST)?,
            sampler: Sampler::new(ctx, &SamplerDesc::nearest())?,
        })
    }

    /// What walks read of it, by the names in the shaders.
    pub fn bindings(&self) -> [(&'static str, Binding<'_>); 2] {
        [
            ("nearest_lids", Binding::Image(&self.lids, &self.sampler)),
            ("depth_so_far", Binding::Image(&self.depth, &self.sampler)),
        ]
    }

    /// Before a pass. `depth`: the picture's, if something is drawn already.
    pub fn before(&self, cmd: &mut CommandEncoder, part: Part, depth: Option<&Image>) {
        match part {
            Part::None => {}
            Part::Write => {
                cmd.image_barrier(&self.lids, Access::FRAGMENT_READ.discarded(), Access::COLOR_WRITE);
                // Lids behind plain surfaces have nothing to trace.
                match depth {
                    Some(depth) => self.copy(cmd, depth, Access::DEPTH_WRITE),
                    None => cmd.image_barrier(&self.depth, Access::FRAGMENT_READ.discarded(), Access::DEPTH_WRITE),
                }
            }
            Part::Resolve => {
                cmd.image_barrier(&self.lids, Access::COLOR_WRITE, Access::FRAGMENT_READ);
                // The same code as the last pass: bound, not read.
                cmd.image_barrier(&self.depth, Access::DEPTH_WRITE, Access::FRAGMENT_READ);
            }
            Part::Rest => {
                if let Some(depth) = depth {
                    self.copy(cmd, depth, Access::FRAGMENT_READ);
                }
            }
        }
    }

    /// The picture's depth, which is in the layout of [`Access::DEPTH_WRITE`] before and after.
    fn copy(&self, cmd: &mut CommandEncoder, depth: &Image, reader: Access) {
        cmd.image_barrier(depth, Access::DEPTH_WRITE, Access::TRANSFER_SRC);
        cmd.image_barrier(&self.depth, Access::FRAGMENT_READ.discarded(), Access::TRANSFER_DST);
        cmd.copy_right(depth, &self.depth, 0);
        cmd.image_barrier(depth, Access::TRANSFER_SRC, Access::DEPTH_WRITE);
        cmd.image_barrier(&self.depth, Access::TRANSFER_DST, reader);
    }

    /// Begins the pass that writes it. `clear`: nothing is drawn yet.
    pub fn begin_pass(&self, cmd: &mut CommandEncoder, clear: bool) {
        let color = [Attachment { image: &self.lids, load: Load::Clear([0.0; 4]), store: true, resolve: None }];
        let depth = DepthAttachment { image: &self.depth, clear: clear.then_some(0.0), store: false };
        let extent = self.lids.extent();
        cmd.begin_rendering(&RenderingDesc { name: PASS, color: &color, depth: Some(depth), extent });
    }
}
