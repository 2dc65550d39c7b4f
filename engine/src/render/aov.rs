//! The images behind [`crate::aov::Aov`], and how they are read back.

use glam::DVec3;

use crate::aov::Aov;
use crate::error::Result;
use crate::gpu::{Access, Attachment, CommandEncoder, Context, Image, ImageDesc, Load, read_image, vk};

/// Colour targets 1 to 4 of a frame with AOVs; the order of `shaders/render/output.glsl`.
pub struct AovTargets {
    images: Vec<Image>,
}

/// Name, clear value. A missed pixel has depth +∞ and shadow 1, all else 0.
const TARGETS: [(&str, [f32; 4]); 4] = [
    ("aov linear", [0.0, 0.0, 0.0, 1.0]),
    ("aov position", [0.0, 0.0, 0.0, f32::INFINITY]),
    ("aov normal", [0.0; 4]),
    ("aov uv", [0.0; 4]),
];

impl AovTargets {
    /// Their formats.
    pub const FORMATS: [vk::Format; 4] = [
        vk::Format::R32G32B32A32_SFLOAT,
        vk::Format::R32G32B32A32_SFLOAT,
        vk::Format::R32G32B32A32_SFLOAT,
        vk::Format::R32G32_SFLOAT,
    ];

    /// Their names and formats.
    pub fn targets() -> impl Iterator<Item = (&'static str, vk::Format)> {
        TARGETS.iter().map(|(name, _)| *name).zip(Self::FORMATS)
    }

    /// Creates them.
    pub fn new(ctx: &Context, extent: [u32; 2]) -> Result<Self> {
        let images = Self::targets()
            .map(|(name, format)| {
                Image::new(
                    ctx,
                    &ImageDesc {
                        name,
                        extent,
                        format,
                        mips: 1,
                        samples: vk::SampleCountFlags::TYPE_1,
                        usage: vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::TRANSFER_SRC,
                    },
                )
            })
            .collect::<Result<_>>()?;
        Ok(AovTargets { images })
    }

    /// Makes them ready to be drawn to.
    pub fn begin(&self, cmd: &mut CommandEncoder) {
        for image in &self.images {
            cmd.image_barrier(image, Access::COLOR_WRITE.discarded(), Access::COLOR_WRITE);
        }
    }

    /// Cleared to a missed pixel, or drawn on.
    pub fn attachments(&self, clear: bool) -> impl Iterator<Item = Attachment<'_>> {
        self.images.iter().zip(TARGETS).map(move |(image, (_, missed))| Attachment {
            image,
            load: if clear { Load::Clear(missed) } else { Load::Keep },
            store: true,
            resolve: None,
        })
    }

    /// Reads them back; `camera` is added to the positions in f64, which f32 could not hold far from the origin.
    pub fn read(&self, ctx: &Context, camera: DVec3) -> Result<Aov> {
        let floats = self
            .images
            .iter()
            .map(|image| Ok(bytemuck::pod_collect_to_vec(&read_image(ctx, image, Access::COLOR_WRITE)?)))
            .collect::<Result<Vec<Vec<f32>>>>()?;
        let [width, height] = self.images[0].extent();
        let mut aov = Aov::missed(width, height);
        for i in 0..aov.depth.len() {
            let texel = |target: usize| -> [f32; 4] { std::array::from_fn(|c| floats[target][4 * i + c]) };
            let ([r, g, b, shadow], [x, y, z, depth], [nx, ny, nz, h]) = (texel(0), texel(1), texel(2));
            if depth == f32::INFINITY {
                continue;
            }
            let position = DVec3::new(x.into(), y.into(), z.into()) + camera;
            aov.depth[i] = depth;
            aov.position[i] = position.as_vec3().to_array();
            aov.normal[i] = [nx, ny, nz];
            aov.uv[i] = [floats[3][2 * i], floats[3][2 * i + 1]];
            aov.height_at_hit[i] = h;
            aov.shadow[i] = shadow;
            aov.color[i] = [r, g, b];
        }
        Ok(aov)
    }
}
