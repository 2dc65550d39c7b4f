//! Cone maps by compute: what `shell::cones` defines by all pairs of cells, found by a hierarchical search.

use bytemuck::{Pod, Zeroable};

use super::variant::wrap_defines;
use crate::error::Result;
use crate::gpu::{
    Access, Binding, Buffer, BufferDesc, Context, DescriptorSet, Image, MemoryLocation, Pipeline, Sampler,
    ShaderCompiler, ShaderStage, Uploader, run_once, vk,
};
use crate::scene::{HeightMap, Wrap};
use crate::shell::cones::{Cell, ConeKind, Heights, quantise};

/// Levels that the shader's table has room for: maps up to 32,768 texels a side, or half where mirrored.
const LEVELS: usize = 16;

/// Invocations of a workgroup along each axis; those of `render/cones.comp`.
const GROUP: u32 = 8;

/// Cells of a tile along each axis. A tile is one submission, so that none runs long.
const TILE: u32 = 128;

/// What f32 may lose, with room to spare: the cones become so much narrower.
const ROUNDING: f64 = 1.0 + 1e-4;

/// Push constants of a tile.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct TileBlock {
    tile: [i32; 2],
    top: i32,
    side: i32,
    offset: [u32; LEVELS],
}

/// What the cells below a node can hold, rounded outward.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct Node {
    high: u32,
    slopes: [[i16; 2]; 2],
}

impl Node {
    fn of(cell: &Cell, size: [i64; 2]) -> Self {
        let slopes = [0, 1].map(|axis| {
            let [low, high] = cell.slopes[axis].map(|s| s / size[axis] as f64 * 32767.0);
            // Slopes of a map are multiples of 1 / 65535: no rounding of theirs reaches over a whole step.
            [(low - 1e-3).floor().max(-32767.0) as i16, (high + 1e-3).ceil().min(32767.0) as i16]
        });
        Node { high: (cell.range[1] * 65535.0 - 1e-3).ceil() as u32, slopes }
    }

    fn join(self, other: Node) -> Self {
        let slopes = [0, 1].map(|axis| {
            let ([a, b], [c, d]) = (self.slopes[axis], other.slopes[axis]);
            [a.min(c), b.max(d)]
        });
        Node { high: self.high.max(other.high), slopes }
    }
}

/// The nodes of all levels over one period of a map, and where each level begins.
fn hierarchy(heights: &Heights, wrap: [Wrap; 2]) -> (Vec<Node>, Vec<u32>) {
    let size = heights.size();
    let shift = wrap.map(|w| i64::from(w == Wrap::Clamp));
    let mut count = [0, 1].map(|axis| match wrap[axis] {
        Wrap::Mirror => 2 * size[axis],
        _ => size[axis] + shift[axis],
    });
    let cells = (0..count[1]).flat_map(|y| (0..count[0]).map(move |x| [x - shift[0], y - shift[1]]));
    let mut nodes: Vec<Node> = cells.map(|at| Node::of(&heights.cell(at), size)).collect();
    let mut offsets = vec![0];
    while count != [1, 1] {
        let below = offsets[offsets.len() - 1];
        let finer = count;
        count = finer.map(|n| (n + 1) / 2);
        offsets.push(nodes.len());
        for (y, x) in (0..count[1]).flat_map(|y| (0..count[0]).map(move |x| (y, x))) {
            let child = |i: i64, j: i64| {
                let [x, y] = [(2 * x + i).min(finer[0] - 1), (2 * y + j).min(finer[1] - 1)];
                nodes[below + (y * finer[0] + x) as usize]
            };
            nodes.push(child(0, 0).join(child(1, 0)).join(child(0, 1)).join(child(1, 1)));
        }
    }
    (nodes, offsets.into_iter().map(|n| n as u32).collect())
}

/// The cone map of `map`, which `image` holds: √ratio of each texel as 16 bits. No cone is wider than
/// [`crate::shell::cones::by_all_pairs`] has it. `progress` is told the share that is done, tile by tile.
pub fn build(
    ctx: &Context,
    compiler: &ShaderCompiler,
    map: &HeightMap,
    (image, sampler): (&Image, &Sampler),
    wrap: [Wrap; 2],
    kind: ConeKind,
    mut progress: impl FnMut(f64),
) -> Result<Vec<u16>> {
    let size = [map.width, map.height];
    let (nodes, offsets) = hierarchy(&Heights::new(map, wrap), wrap);
    let mut offset = [0; LEVELS];
    offset[..offsets.len()].copy_from_slice(&offsets);
    let mut uploader = Uploader::new(ctx)?;
    let nodes = uploader.buffer(&format!("{} cone nodes", map.name), vk::BufferUsageFlags::STORAGE_BUFFER, &nodes)?;
    uploader.finish()?;
    let grid = size.map(|n| n + 1);
    let cells = Buffer::new(
        ctx,
        &BufferDesc {
            name: &format!("{} cones", map.name),
            size: 4 * u64::from(grid[0]) * u64::from(grid[1]),
            usage: vk::BufferUsageFlags::STORAGE_BUFFER,
            location: MemoryLocation::GpuToCpu,
        },
    )?;

    let mut defines = wrap_defines(wrap).to_vec();
    if kind == ConeKind::Relaxed {
        defines.push(("CONE_RELAXED", String::new()));
    }
    let shader = compiler.compile("render/cones.comp", ShaderStage::Compute, &defines)?;
    let pipeline = Pipeline::compute(ctx, "cones", &shader)?;
    let bindings = [
        ("height_map", Binding::Image(image, sampler)),
        ("nodes", Binding::Buffer(&nodes)),
        ("cells", Binding::Buffer(&cells)),
    ];
    let set = DescriptorSet::new(ctx, &pipeline, 0, &bindings)?;
    let tiles = grid.map(|n| n.div_ceil(TILE));
    for (row, column) in (0..tiles[1]).flat_map(|y| (0..tiles[0]).map(move |x| (y, x))) {
        let tile = [column, row].map(|n| (n * TILE) as i32);
        let block = TileBlock { tile, top: offsets.len() as i32 - 1, side: TILE as i32, offset };
        run_once(ctx, |cmd| {
            cmd.region("cones", |cmd| {
                cmd.bind_pipeline(&pipeline);
                cmd.bind_set(&pipeline, 0, &set);
                cmd.push(&pipeline, &block);
                cmd.dispatch(TILE.div_ceil(GROUP), TILE.div_ceil(GROUP), 1);
                cmd.buffer_barrier(&cells, Access::COMPUTE_WRITE, Access::HOST_READ);
            });
            Ok(())
        })?;
        progress(f64::from(row * tiles[0] + column + 1) / f64::from(tiles[0] * tiles[1]));
    }
    let cells: Vec<f64> = cells.read::<f32>()?.into_iter().map(|k| f64::from(k) * ROUNDING).collect();
    Ok(quantise(size, &cells))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::{ContextDesc, ImageDesc};
    use crate::render::resources::height_sampler;
    use crate::render::shader_compiler;
    use crate::scene::HeightTexels;
    use crate::settings::Validation;
    use crate::shell::cones::by_all_pairs;

    fn bake(ctx: &Context, map: &HeightMap, wrap: [Wrap; 2], kind: ConeKind) -> Vec<u16> {
        let HeightTexels::U16(texels) = &map.texels else { unreachable!() };
        let mut uploader = Uploader::new(ctx).unwrap();
        let desc = ImageDesc {
            name: "heights",
            extent: [map.width, map.height],
            format: vk::Format::R16_UNORM,
            usage: vk::ImageUsageFlags::SAMPLED,
            ..ImageDesc::default()
        };
        let image = uploader.image(&desc, bytemuck::cast_slice(texels)).unwrap();
        uploader.finish().unwrap();
        let sampler = height_sampler(ctx, wrap).unwrap();
        let compiler = shader_compiler(None).unwrap();
        let mut told = Vec::new();
        let roots = build(ctx, &compiler, map, (&image, &sampler), wrap, kind, |done| told.push(done)).unwrap();
        assert!(told.is_sorted() && told.last() == Some(&1.0), "{told:?}");
        roots
    }

    fn map(size: [u32; 2], height: impl FnMut([u32; 2]) -> f64) -> HeightMap {
        let texels = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| [x, y])).map(height);
        let texels = texels.map(|h| (h.clamp(0.0, 1.0) * 65535.0) as u16).collect();
        HeightMap { name: "heights".into(), width: size[0], height: size[1], texels: HeightTexels::U16(texels) }
    }

    /// The search gives what all pairs of cells give, never wider and narrower by rounding only.
    #[test]
    fn the_search_finds_what_all_pairs_give() {
        let ctx = Context::new(&ContextDesc { validation: Validation::Sync, ..ContextDesc::default() }).unwrap();
        let mut state = 1u32;
        let mut random = |_| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state >> 16) / 65535.0
        };
        let wave = |[x, y]: [u32; 2]| 0.5 + 0.3 * (f64::from(x) * 0.4).sin() + 0.2 * (f64::from(x * y) * 0.05).cos();
        use Wrap::{Clamp, Mirror, Repeat};
        for (map, wrap) in [
            (map([21, 17], &mut random), [Repeat, Mirror]),
            (map([24, 24], wave), [Repeat, Repeat]),
            (map([19, 30], wave), [Clamp, Mirror]),
            (map([9, 26], |at| f64::from(u8::from(at[0] == 3 && at[1] % 13 == 5))), [Mirror, Clamp]),
            (map([14, 9], &mut random), [Clamp, Clamp]),
            (map([1, 1], |_| 0.5), [Repeat, Clamp]),
        ] {
            for kind in [ConeKind::Plain, ConeKind::Relaxed] {
                let (found, all) = (bake(&ctx, &map, wrap, kind), by_all_pairs(&map, wrap, kind));
                for (i, (&found, &all)) in found.iter().zip(&all).enumerate() {
                    let place = format!("{}x{} {wrap:?} {kind:?} texel {i}", map.width, map.height);
                    assert!(found <= all, "{place}: {found} is wider than {all}");
                    assert!(f64::from(found) >= f64::from(all) * (1.0 - 2e-4) - 2.0, "{place}: {found} of {all}");
                }
            }
        }
        ctx.check_validation().unwrap();
    }
}
