//! The images of the picture's size that a frame is drawn into.

use glam::DVec3;

use super::aov::AovTargets;
use super::depth_tiles::DepthTiles;
use super::resolve::Samples;
use super::visibility::{Named, Visibility};
use super::{DEPTH_FORMAT, Renderer};
use crate::error::Result;
use crate::gpu::{Image, ImageDesc, vk};

/// Images of the picture's size.
pub struct Targets {
    pub depth: Image,
    /// Of `depth`, where hidden prisms are found.
    pub tiles: Option<DepthTiles>,
    /// Resolved to the caller's image, where a pixel has several samples.
    pub samples: Option<Samples>,
    pub aov: Option<AovTargets>,
    /// Depth of [`super::plan::Plan::aov_draws`].
    pub aov_depth: Option<Image>,
    /// Where walks begin at the lids that it names.
    pub visibility: Option<Visibility>,
    /// Camera of the last recorded frame: AOV positions are relative to it.
    pub camera: DVec3,
}

impl Renderer {
    /// Makes them for a picture of this size, unless they are there.
    pub(super) fn resize(&mut self, extent: [u32; 2]) -> Result<()> {
        if self.targets.as_ref().is_some_and(|t| t.depth.extent() == extent) {
            return Ok(());
        }
        let samples = vk::SampleCountFlags::from_raw(self.settings.msaa);
        let image = |name, format, samples, usage| {
            Image::new(&self.ctx, &ImageDesc { name, extent, format, mips: 1, samples, usage })
        };
        let one = vk::SampleCountFlags::TYPE_1;
        let depth_usage = vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT;
        let read = if self.tile_pass.is_some() { vk::ImageUsageFlags::SAMPLED } else { vk::ImageUsageFlags::empty() };
        let named = self.plan.named();
        let copied =
            if named == Some(Named::Lids) { vk::ImageUsageFlags::TRANSFER_SRC } else { vk::ImageUsageFlags::empty() };
        let depth = image("depth", DEPTH_FORMAT, samples, depth_usage | read | copied)?;
        let visibility = named.map(|named| Visibility::new(&self.ctx, extent, named)).transpose()?;
        let tiles = self.tile_pass.as_ref().map(|pass| pass.tiles(&self.ctx, &depth)).transpose()?;
        if tiles.is_some() || visibility.is_some() {
            // Their sets name the old ones.
            self.slots.clear();
        }
        let format = self.output.color_format;
        let resolved = self.resolve.as_ref().map(|resolve| resolve.target(&self.ctx, extent, format, samples));
        let samples = resolved.transpose()?;
        let aov = self.output.aov.then(|| AovTargets::new(&self.ctx, extent)).transpose()?;
        let aov_depth = || image("depth of AOVs", DEPTH_FORMAT, one, depth_usage);
        let aov_depth = (samples.is_some() && self.output.aov).then(aov_depth).transpose()?;
        self.targets = Some(Targets { depth, tiles, samples, aov, aov_depth, visibility, camera: DVec3::ZERO });
        Ok(())
    }
}
