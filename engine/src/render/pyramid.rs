//! The min-max pyramid of a height map, built by compute: a table of level offsets, then the nodes of levels 1 and up.
//! `shaders/shell/pyramid.glsl` defines nodes and levels; the sizes here are the same formulas.

use bytemuck::{Pod, Zeroable};

use super::variant::wrap_defines;
use crate::error::Result;
use crate::gpu::{
    Access, Binding, Buffer, Context, DescriptorSet, Image, Pipeline, Sampler, ShaderCompiler, ShaderStage, Uploader,
    run_once, vk,
};
use crate::scene::Wrap;

/// Entries of the offset table; `PYRAMID_LEVELS` of the shader.
const LEVELS: usize = 16;

/// Invocations of a workgroup along each axis; those of `render/pyramid.comp`.
const GROUP: u32 = 8;

/// Push constants of one level.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct LevelBlock {
    level: u32,
}

/// Nodes of each level from 1 to the top, along both axes, for a map of `size` texels.
pub fn level_sizes(size: [u32; 2], wrap: [Wrap; 2]) -> Vec<[u32; 2]> {
    let cells = [0, 1].map(|axis| match wrap[axis] {
        Wrap::Repeat => size[axis],
        Wrap::Mirror => 2 * size[axis],
        // The constant cell before the first texel.
        Wrap::Clamp => size[axis] + 1,
    });
    let top = cells[0].max(cells[1]).next_power_of_two().trailing_zeros().max(1);
    (1..=top).map(|level| cells.map(|n| n.div_ceil(1 << level) + 1)).collect()
}

/// Builds the pyramid of `map`, one dispatch a level, and waits for it.
pub fn build(
    ctx: &Context,
    compiler: &ShaderCompiler,
    map: &Image,
    sampler: &Sampler,
    wrap: [Wrap; 2],
) -> Result<Buffer> {
    let sizes = level_sizes(map.extent(), wrap);
    let mut content = vec![0u32; LEVELS];
    let mut end = LEVELS as u32;
    for (i, [width, height]) in sizes.iter().enumerate() {
        content[i + 1] = end;
        end += width * height;
    }
    content.resize(end as usize, 0);
    let mut uploader = Uploader::new(ctx)?;
    let buffer = uploader.buffer(&format!("{} pyramid", map.name()), vk::BufferUsageFlags::STORAGE_BUFFER, &content)?;
    uploader.finish()?;

    let shader = compiler.compile("render/pyramid.comp", ShaderStage::Compute, &wrap_defines(wrap))?;
    let pipeline = Pipeline::compute(ctx, "pyramid", &shader)?;
    let bindings = [("height_map", Binding::Image(map, sampler)), ("pyramid", Binding::Buffer(&buffer))];
    let set = DescriptorSet::new(ctx, &pipeline, 0, &bindings)?;
    run_once(ctx, |cmd| {
        cmd.region("pyramid", |cmd| {
            cmd.bind_pipeline(&pipeline);
            cmd.bind_set(&pipeline, 0, &set);
            for (level, [width, height]) in (1..).zip(&sizes) {
                cmd.push(&pipeline, &LevelBlock { level });
                cmd.dispatch(width.div_ceil(GROUP), height.div_ceil(GROUP), 1);
                cmd.buffer_barrier(&buffer, Access::COMPUTE_WRITE, Access::COMPUTE_WRITE);
            }
            cmd.buffer_barrier(&buffer, Access::COMPUTE_WRITE, Access::FRAGMENT_READ);
        });
        Ok(())
    })?;
    Ok(buffer)
}
