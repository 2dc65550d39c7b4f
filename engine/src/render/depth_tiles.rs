//! The farthest depth in tiles of the picture, by levels, for finding what is hidden: `shaders/render/depth_tiles.glsl`.

use bytemuck::{Pod, Zeroable};

use crate::error::Result;
use crate::gpu::{
    Access, Binding, Buffer, BufferDesc, CommandEncoder, Context, DescriptorSet, Image, MemoryLocation, Pipeline,
    Sampler, SamplerDesc, ShaderCompiler, ShaderStage, vk,
};

/// Name of the pass, as in `--stats`.
pub const PASS: &str = "depth tiles";

/// Name of the buffer.
pub const NAME: &str = "depth tiles";

/// Pixels along an edge of the smallest tile; that of the shader.
const TILE: u32 = 4;

/// Invocations of a workgroup along each axis; those of `render/depth_tiles.comp`.
const GROUP: u32 = 8;

/// Push constants of one level.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct LevelBlock {
    level: u32,
    first: u32,
    first_before: u32,
}

/// Tiles along both axes at each level, up to a single one.
fn levels(extent: [u32; 2]) -> Vec<[u32; 2]> {
    let top = extent[0].max(extent[1]).div_ceil(TILE).next_power_of_two().ilog2();
    (0..=top).map(|level| extent.map(|n| n.div_ceil(TILE << level))).collect()
}

/// Bytes of all levels for a picture of this size.
pub fn bytes(extent: [u32; 2]) -> usize {
    levels(extent).iter().map(|[w, h]| (w * h) as usize).sum::<usize>() * size_of::<f32>()
}

/// What finds them, whatever the picture.
pub struct TilePass {
    pipeline: Pipeline,
    sampler: Sampler,
}

/// The tiles of one depth image.
pub struct DepthTiles {
    /// Level by level.
    pub tiles: Buffer,
    set: DescriptorSet,
    extent: [u32; 2],
}

impl TilePass {
    /// Compiles it.
    pub fn new(ctx: &Context, compiler: &ShaderCompiler) -> Result<Self> {
        let shader = compiler.compile("render/depth_tiles.comp", ShaderStage::Compute, &[])?;
        let pipeline = Pipeline::compute(ctx, "depth tiles", &shader)?;
        let sampler = Sampler::new(ctx, &SamplerDesc::nearest())?;
        Ok(TilePass { pipeline, sampler })
    }

    /// Room for the tiles of a depth image.
    pub fn tiles(&self, ctx: &Context, depth: &Image) -> Result<DepthTiles> {
        let (usage, location) = (vk::BufferUsageFlags::STORAGE_BUFFER, MemoryLocation::GpuOnly);
        let extent = depth.extent();
        let tiles = Buffer::new(ctx, &BufferDesc { name: NAME, size: bytes(extent) as u64, usage, location })?;
        let bindings =
            [("picture_depth", Binding::Image(depth, &self.sampler)), ("depth_tiles", Binding::Buffer(&tiles))];
        let set = DescriptorSet::new(ctx, &self.pipeline, 0, &bindings)?;
        Ok(DepthTiles { tiles, set, extent })
    }

    /// Records the pass over `depth`, which is in the layout of [`Access::DEPTH_WRITE`] before and after.
    pub fn record(&self, cmd: &mut CommandEncoder, depth: &Image, tiles: &DepthTiles, reader: Access) {
        cmd.image_barrier(depth, Access::DEPTH_WRITE, Access::COMPUTE_READ);
        cmd.buffer_barrier(&tiles.tiles, reader, Access::COMPUTE_WRITE);
        cmd.bind_pipeline(&self.pipeline);
        cmd.bind_set(&self.pipeline, 0, &tiles.set);
        let (mut first, mut first_before) = (0, 0);
        for (level, [width, height]) in (0..).zip(levels(tiles.extent)) {
            if level > 0 {
                cmd.buffer_barrier(&tiles.tiles, Access::COMPUTE_WRITE, Access::COMPUTE_WRITE);
            }
            cmd.push(&self.pipeline, &LevelBlock { level, first, first_before });
            cmd.dispatch(width.div_ceil(GROUP), height.div_ceil(GROUP), 1);
            first_before = first;
            first += width * height;
        }
        cmd.buffer_barrier(&tiles.tiles, Access::COMPUTE_WRITE, reader);
        cmd.image_barrier(depth, Access::COMPUTE_READ, Access::DEPTH_WRITE);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_end_at_one_tile() {
        for (extent, count) in [([1, 1], 1), ([4, 5], 2), ([640, 360], 9), ([513, 4], 9)] {
            let levels = levels(extent);
            assert_eq!((levels.len(), levels[0], levels[count - 1]), (count, extent.map(|n| n.div_ceil(TILE)), [1, 1]));
        }
    }
}
