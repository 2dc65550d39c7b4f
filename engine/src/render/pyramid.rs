//! The min-max pyramid of a height map, built by compute: a table of level offsets, then the nodes of all levels.
//! `shaders/shell/pyramid.glsl` defines nodes and levels; the sizes here are the same formulas.

use bytemuck::{Pod, Zeroable};

use super::variant::wrap_defines;
use crate::error::Result;
use crate::gpu::{
    Access, Binding, Buffer, BufferDesc, Context, DescriptorSet, Image, MemoryLocation, Pipeline, Sampler,
    ShaderCompiler, ShaderStage, Uploader, read_buffer, run_once, vk,
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

/// Nodes of each level from 0 to the top, along both axes, for a map of `size` texels.
pub fn level_sizes(size: [u32; 2], wrap: [Wrap; 2]) -> Vec<[u32; 2]> {
    let cells = [0, 1].map(|axis| match wrap[axis] {
        Wrap::Repeat => size[axis],
        Wrap::Mirror => 2 * size[axis],
        // The constant cell before the first texel.
        Wrap::Clamp => size[axis] + 1,
    });
    let top = cells[0].max(cells[1]).next_power_of_two().trailing_zeros().max(1);
    (0..=top).map(|level| cells.map(|n| n.div_ceil(1 << level) + 1)).collect()
}

/// Bytes of a map's pyramid.
pub fn bytes(size: [u32; 2], wrap: [Wrap; 2]) -> usize {
    size_of::<u32>() * offsets(&level_sizes(size, wrap)).1 as usize
}

/// One level, as a file shall have it.
pub struct Level {
    /// Nodes along both axes.
    pub size: [u32; 2],
    /// Least and greatest height, 16 bits each, row by row.
    pub bounds: Vec<[u16; 2]>,
}

/// All levels of the pyramid of `map`.
pub fn levels(
    ctx: &Context,
    compiler: &ShaderCompiler,
    map: &Image,
    sampler: &Sampler,
    wrap: [Wrap; 2],
) -> Result<Vec<Level>> {
    let (nodes, sizes) = nodes(ctx, compiler, map, sampler, wrap)?;
    let items: Vec<u32> = read_buffer(ctx, &nodes, Access::COMPUTE_WRITE)?;
    let level = |(level, size): (usize, [u32; 2])| {
        let first = items[level] as usize;
        let bounds = items[first..first + (size[0] * size[1]) as usize].iter();
        Level { size, bounds: bounds.map(|node| [*node as u16, (node >> 16) as u16]).collect() }
    };
    Ok(sizes.into_iter().enumerate().map(level).collect())
}

/// Builds the pyramid of `map`, two dispatches a level, and waits for it: each node with its successors.
pub fn build(
    ctx: &Context,
    compiler: &ShaderCompiler,
    map: &Image,
    sampler: &Sampler,
    wrap: [Wrap; 2],
) -> Result<Buffer> {
    let (nodes, sizes) = nodes(ctx, compiler, map, sampler, wrap)?;
    let pairs = room(ctx, &format!("{} pyramid", map.name()), &sizes)?;
    let shader = compiler.compile("render/pyramid_pairs.comp", ShaderStage::Compute, &wrap_defines(wrap))?;
    let pipeline = Pipeline::compute(ctx, "pyramid pairs", &shader)?;
    let bindings = [
        ("height_map", Binding::Image(map, sampler)),
        ("pyramid", Binding::Buffer(&nodes)),
        ("pairs", Binding::Buffer(&pairs)),
    ];
    let set = DescriptorSet::new(ctx, &pipeline, 0, &bindings)?;
    run_once(ctx, |cmd| {
        cmd.region("pyramid pairs", |cmd| {
            cmd.buffer_barrier(&nodes, Access::COMPUTE_WRITE, Access::COMPUTE_WRITE);
            cmd.bind_pipeline(&pipeline);
            cmd.bind_set(&pipeline, 0, &set);
            for (level, [width, height]) in (0..).zip(&sizes) {
                cmd.push(&pipeline, &LevelBlock { level });
                cmd.dispatch(width.div_ceil(GROUP), height.div_ceil(GROUP), 1);
            }
            cmd.buffer_barrier(&pairs, Access::COMPUTE_WRITE, Access::FRAGMENT_READ);
        });
        Ok(())
    })?;
    Ok(pairs)
}

/// The transfer is for those who read it back.
const USAGE: vk::BufferUsageFlags = vk::BufferUsageFlags::from_raw(
    vk::BufferUsageFlags::STORAGE_BUFFER.as_raw() | vk::BufferUsageFlags::TRANSFER_SRC.as_raw(),
);

/// The table of offsets, and where the last level ends.
fn offsets(sizes: &[[u32; 2]]) -> ([u32; LEVELS], u32) {
    let mut table = [0; LEVELS];
    let mut end = LEVELS as u32;
    for (offset, [width, height]) in table.iter_mut().zip(sizes) {
        *offset = end;
        end += width * height;
    }
    (table, end)
}

/// A buffer with the table, and room for the nodes: these are not uploaded, as a large map has more than texels.
fn room(ctx: &Context, name: &str, sizes: &[[u32; 2]]) -> Result<Buffer> {
    let (offsets, end) = offsets(sizes);
    let size = u64::from(end) * size_of::<u32>() as u64;
    let usage = USAGE | vk::BufferUsageFlags::TRANSFER_DST;
    let buffer = Buffer::new(ctx, &BufferDesc { name, size, usage, location: MemoryLocation::GpuOnly })?;
    let mut uploader = Uploader::new(ctx)?;
    let table = uploader.buffer("pyramid offsets", vk::BufferUsageFlags::TRANSFER_SRC, &offsets)?;
    uploader.finish()?;
    run_once(ctx, |cmd| {
        cmd.copy_buffer(&table, 0, &buffer, 0, table.size());
        cmd.buffer_barrier(&buffer, Access::TRANSFER_DST, Access::COMPUTE_WRITE);
        Ok(())
    })?;
    Ok(buffer)
}

/// The nodes of all levels, each for itself, and the levels' sizes.
fn nodes(
    ctx: &Context,
    compiler: &ShaderCompiler,
    map: &Image,
    sampler: &Sampler,
    wrap: [Wrap; 2],
) -> Result<(Buffer, Vec<[u32; 2]>)> {
    let sizes = level_sizes(map.extent(), wrap);
    let nodes = room(ctx, &format!("{} nodes", map.name()), &sizes)?;
    let shader = compiler.compile("render/pyramid.comp", ShaderStage::Compute, &wrap_defines(wrap))?;
    let pipeline = Pipeline::compute(ctx, "pyramid", &shader)?;
    let bindings = [("height_map", Binding::Image(map, sampler)), ("pyramid", Binding::Buffer(&nodes))];
    let set = DescriptorSet::new(ctx, &pipeline, 0, &bindings)?;
    run_once(ctx, |cmd| {
        cmd.region("pyramid", |cmd| {
            cmd.bind_pipeline(&pipeline);
            cmd.bind_set(&pipeline, 0, &set);
            for (level, [width, height]) in (0..).zip(&sizes) {
                cmd.push(&pipeline, &LevelBlock { level });
                cmd.dispatch(width.div_ceil(GROUP), height.div_ceil(GROUP), 1);
                cmd.buffer_barrier(&nodes, Access::COMPUTE_WRITE, Access::COMPUTE_WRITE);
            }
        });
        Ok(())
    })?;
    Ok((nodes, sizes))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::{ContextDesc, ImageDesc};
    use crate::render::resources::height_sampler;
    use crate::render::shader_compiler;
    use crate::settings::Validation;

    /// Least and greatest texel from `first` to `last`, both included, wrapped one by one.
    fn bounds(texels: &[u16], size: [i64; 2], wrap: [Wrap; 2], first: [i64; 2], last: [i64; 2]) -> [u16; 2] {
        let wrapped = |i: i64, axis: usize| match wrap[axis] {
            Wrap::Repeat => i.rem_euclid(size[axis]),
            Wrap::Clamp => i.clamp(0, size[axis] - 1),
            Wrap::Mirror => {
                let at = i.rem_euclid(2 * size[axis]);
                if at < size[axis] { at } else { 2 * size[axis] - 1 - at }
            }
        };
        let mut found = [u16::MAX, 0];
        for y in first[1]..=last[1] {
            for x in first[0]..=last[0] {
                let texel = texels[(wrapped(y, 1) * size[0] + wrapped(x, 0)) as usize];
                found = [found[0].min(texel), found[1].max(texel)];
            }
        }
        found
    }

    /// Every pair of nodes bounds its texels; exactly so where its children do not lie past the end of the map.
    #[test]
    fn every_pair_of_nodes_bounds_its_texels() {
        let ctx = Context::new(&ContextDesc { validation: Validation::Sync, ..ContextDesc::default() }).unwrap();
        let compiler = shader_compiler(None).unwrap();
        let mut state = 1u32;
        for (size, wrap) in [
            ([16, 16], [Wrap::Repeat, Wrap::Repeat]),
            ([13, 7], [Wrap::Repeat, Wrap::Mirror]),
            ([9, 21], [Wrap::Clamp, Wrap::Repeat]),
            ([6, 11], [Wrap::Mirror, Wrap::Clamp]),
            ([1, 1], [Wrap::Repeat, Wrap::Clamp]),
        ] {
            let texels: Vec<u16> = (0..size[0] * size[1])
                .map(|_| {
                    state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                    (state >> 16) as u16
                })
                .collect();
            let mut uploader = Uploader::new(&ctx).unwrap();
            let desc = ImageDesc {
                name: "random heights",
                extent: size,
                format: vk::Format::R16_UNORM,
                usage: vk::ImageUsageFlags::SAMPLED,
                ..ImageDesc::default()
            };
            let map = uploader.image(&desc, bytemuck::cast_slice(&texels)).unwrap();
            uploader.finish().unwrap();
            let sampler = height_sampler(&ctx, wrap).unwrap();
            let pyramid = build(&ctx, &compiler, &map, &sampler, wrap).unwrap();
            let items: Vec<u32> = read_buffer(&ctx, &pyramid, Access::COMPUTE_WRITE).unwrap();

            let shift = wrap.map(|w| i64::from(w == Wrap::Clamp));
            let size = size.map(i64::from);
            for (level, [columns, rows]) in (0..).zip(level_sizes(size.map(|n| n as u32), wrap)) {
                for (y, x) in (0..rows).flat_map(|y| (0..columns).map(move |x| (y, x))) {
                    let node = items[(items[level] + y * columns + x) as usize];
                    let (low, high) = (node as u16, (node >> 16) as u16);
                    let first = [i64::from(x), i64::from(y)].map(|k| k << level);
                    let first = [first[0] - shift[0], first[1] - shift[1]];
                    // With its successors, where it has any.
                    let reach = [x + 1 < columns, y + 1 < rows].map(|more| if more { 2 << level } else { 1 << level });
                    let last = [first[0] + reach[0], first[1] + reach[1]];
                    let [least, greatest] = bounds(&texels, size, wrap, first, last);
                    let place = format!("{size:?} {wrap:?} level {level} node {x},{y}");
                    assert!(low <= least && high >= greatest, "{place}: {low}..{high}, texels {least}..{greatest}");
                    let inside = last[0] < size[0] && last[1] < size[1];
                    assert!(!inside || (low, high) == (least, greatest), "{place}: loose");
                }
            }
        }
        ctx.check_validation().unwrap();
    }
}
