//! The visibility buffer (Burns and Hunt 2013, "The Visibility Buffer"): which lid a pixel's ray meets first. Walks begin
//! there in a pass over the picture, in which every pixel of a quad has one to trace; rasterised, most quads of small
//! triangles lie across an edge and run once for each side, and once for each lid behind.
//!
//! A ray that leaves the shell unhit, or that enters another one nearer than its hit, is drawn by the lid where that
//! happens: a last pass rasterises all lids once more, and traces where the lid is not the one named and not behind the
//! depth so far. So the picture is the same to the bit.
//!
//! A pre-tessellated mesh has one as well, for the same reason: it names the small triangle that each pixel sees, whose
//! depth is the picture's, and a pass over the picture shades it. There is no ray, so nothing is left for a last pass.

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

/// Name of the pass that shades the triangles of micro-meshes that it names.
pub const MESH: &str = "micro-mesh";

/// Draws that it can name, and prisms of each: see `shaders/render/nearest_lid.glsl`.
pub const MAX_DRAWS: usize = 255;
/// See [`MAX_DRAWS`].
pub const MAX_PRISMS: usize = 1 << 24;

/// Lids are named by draw and prism, and by the bits of the level that the ray meets them at; triangles of a micro-mesh by
/// draw and number.
pub const FORMAT: vk::Format = vk::Format::R32G32_UINT;

/// What it names: a frame has shells that are walked, or the meshes that stand in for them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Named {
    /// The lids of shells.
    Lids,
    /// The triangles of micro-meshes.
    Triangles,
}

/// Its images: the names; and of lids the depth, theirs while they are drawn, then a copy of the picture's, which its own
/// pass cannot read.
pub fn images(named: Named) -> &'static [(&'static str, vk::Format)] {
    match named {
        Named::Lids => &[("nearest lids", FORMAT), ("depth so far", super::DEPTH_FORMAT)],
        Named::Triangles => &[("nearest triangles", FORMAT)],
    }
}

/// The buffer of one picture.
pub struct Visibility {
    names: Image,
    /// Of lids.
    depth: Option<Image>,
    sampler: Sampler,
}

impl Visibility {
    /// For a picture of this size.
    pub fn new(ctx: &Context, extent: [u32; 2], named: Named) -> Result<Self> {
        use vk::ImageUsageFlags as U;
        let image = |&(name, format): &(&str, vk::Format), usage| {
            let samples = vk::SampleCountFlags::TYPE_1;
            Image::new(ctx, &ImageDesc { name, extent, format, mips: 1, samples, usage: usage | U::SAMPLED })
        };
        let images = images(named);
        let depth = images.get(1).map(|depth| image(depth, U::DEPTH_STENCIL_ATTACHMENT | U::TRANSFER_DST));
        Ok(Visibility {
            names: image(&images[0], U::COLOR_ATTACHMENT)?,
            depth: depth.transpose()?,
            sampler: Sampler::new(ctx, &SamplerDesc::nearest())?,
        })
    }

    /// What fragments read of it, by the names in the shaders.
    pub fn bindings(&self) -> Vec<(&'static str, Binding<'_>)> {
        let names = Binding::Image(&self.names, &self.sampler);
        match &self.depth {
            Some(depth) => {
                vec![("nearest_lids", names), ("depth_so_far", Binding::Image(depth, &self.sampler))]
            }
            None => vec![("nearest_triangles", names)],
        }
    }

    /// Before a pass. `depth`: the picture's, if something is drawn already.
    pub fn before(&self, cmd: &mut CommandEncoder, part: Part, depth: Option<&Image>) {
        match part {
            Part::None => {}
            Part::Write => {
                cmd.image_barrier(&self.names, Access::FRAGMENT_READ.discarded(), Access::COLOR_WRITE);
                // Lids behind plain surfaces have nothing to trace.
                match (&self.depth, depth) {
                    (None, _) => {}
                    (Some(own), Some(depth)) => copy(cmd, depth, own, Access::DEPTH_WRITE),
                    (Some(own), None) => {
                        cmd.image_barrier(own, Access::FRAGMENT_READ.discarded(), Access::DEPTH_WRITE);
                    }
                }
            }
            Part::Resolve => {
                cmd.image_barrier(&self.names, Access::COLOR_WRITE, Access::FRAGMENT_READ);
                // The same code as the last pass: bound, not read.
                if let Some(own) = &self.depth {
                    cmd.image_barrier(own, Access::DEPTH_WRITE, Access::FRAGMENT_READ);
                }
            }
            Part::Rest => {
                if let Some((own, depth)) = self.depth.as_ref().zip(depth) {
                    copy(cmd, depth, own, Access::FRAGMENT_READ);
                }
            }
        }
    }

    /// Begins the pass that writes it. `depth`: the picture's. `clear`: nothing is drawn yet.
    pub fn begin_pass(&self, cmd: &mut CommandEncoder, depth: &Image, clear: bool) {
        let color = [Attachment { image: &self.names, load: Load::Clear([0.0; 4]), store: true, resolve: None }];
        let store = self.depth.is_none();
        let image = self.depth.as_ref().unwrap_or(depth);
        let depth = DepthAttachment { image, clear: clear.then_some(0.0), store };
        let extent = self.names.extent();
        cmd.begin_rendering(&RenderingDesc { name: PASS, color: &color, depth: Some(depth), extent });
    }
}

/// Copies the picture's depth, which is in the layout of [`Access::DEPTH_WRITE`] before and after.
fn copy(cmd: &mut CommandEncoder, depth: &Image, own: &Image, reader: Access) {
    cmd.image_barrier(depth, Access::DEPTH_WRITE, Access::TRANSFER_SRC);
    cmd.image_barrier(own, Access::FRAGMENT_READ.discarded(), Access::TRANSFER_DST);
    cmd.copy_right(depth, own, 0);
    cmd.image_barrier(depth, Access::TRANSFER_SRC, Access::DEPTH_WRITE);
    cmd.image_barrier(own, Access::TRANSFER_DST, reader);
}
