//! A displacement's heights on the CPU, point by point.

use std::sync::OnceLock;

use glam::DVec2;
use rayon::prelude::*;

use super::bounds::wrapped_range;
use crate::scene::{Displacement, HeightMap, HeightSource, Procedure, Scene, Wrap};

/// What a displacement reads its heights from.
pub struct Heights(Source);

enum Source {
    Map(MapHeights),
    Procedure(Procedure),
}

impl Heights {
    /// Of a displacement of `scene`.
    pub fn new(scene: &Scene, displacement: &Displacement) -> Self {
        Heights(match displacement.source {
            HeightSource::Map(map) => Source::Map(MapHeights::new(&scene.height_maps[map], displacement.wrap)),
            HeightSource::Procedure(procedure) => Source::Procedure(procedure),
        })
    }

    /// Texels of a map; none of a function.
    pub fn texels(&self) -> Option<DVec2> {
        match &self.0 {
            Source::Map(map) => Some(map.size()),
            Source::Procedure(_) => None,
        }
    }

    /// What the derivatives along u and v over a box of UV do not exceed, without sign; none of a function.
    pub fn steepest(&self, low: DVec2, high: DVec2) -> Option<DVec2> {
        match &self.0 {
            Source::Map(map) => Some(map.steepest(low, high)),
            Source::Procedure(_) => None,
        }
    }

    /// The height at `uv`, and its derivatives.
    pub fn at(&self, uv: DVec2) -> (f64, DVec2) {
        match &self.0 {
            Source::Map(map) => map.at(uv),
            Source::Procedure(procedure) => (procedure.height(uv), procedure.gradient(uv)),
        }
    }
}

/// Texels a side of the blocks whose steepest texel is known: a box of more than so many is made up of these.
const BLOCK: i64 = 16;

/// A height map in f32, at mip 0 and bilinear, as the shaders read it.
struct MapHeights {
    size: [i64; 2],
    texels: Vec<f32>,
    wrap: [Wrap; 2],
    /// The greatest steps from a texel of each block to the next one along u and v; found when they are asked for.
    steps: OnceLock<Vec<DVec2>>,
}

impl MapHeights {
    fn new(map: &HeightMap, wrap: [Wrap; 2]) -> Self {
        let size = [map.width, map.height].map(i64::from);
        MapHeights { size, texels: map.heights(), wrap, steps: OnceLock::new() }
    }

    fn texel(&self, at: [i64; 2]) -> f64 {
        let wrapped = |axis: usize| self.wrap[axis].index(at[axis], self.size[axis]);
        f64::from(self.texels[(wrapped(1) * self.size[0] + wrapped(0)) as usize])
    }

    fn size(&self) -> DVec2 {
        DVec2::new(self.size[0] as f64, self.size[1] as f64)
    }

    /// See [`Heights::steepest`].
    fn steepest(&self, low: DVec2, high: DVec2) -> DVec2 {
        // A side of a cell is that of its neighbour too.
        let [low, high] = [(low, 0), (high, 1)].map(|(uv, more)| {
            let cell = (uv * self.size() - 0.5).floor();
            [cell.x as i64 + more, cell.y as i64 + more]
        });
        if (0..2).all(|axis| high[axis] - low[axis] < BLOCK) {
            let texels = (low[1]..=high[1]).flat_map(|y| (low[0]..=high[0]).map(move |x| [x, y]));
            return texels.map(|at| self.step(at)).fold(DVec2::ZERO, DVec2::max) * self.size();
        }
        let steps = self.steps.get_or_init(|| self.block_steps());
        // In a mirror a texel's next one is the one before it.
        let blocks = |axis: usize| {
            let n = self.size[axis] as usize;
            let ranges = wrapped_range(low[axis] - 1, high[axis] + 1, n, self.wrap[axis]);
            let side = BLOCK as usize;
            ranges.into_iter().flatten().flat_map(move |range| range.start() / side..=range.end() / side)
        };
        let columns: Vec<usize> = blocks(0).collect();
        let row = self.blocks()[0];
        let of_row = |y: usize| columns.iter().map(move |x| steps[y * row + x]);
        blocks(1).flat_map(of_row).fold(DVec2::ZERO, DVec2::max) * self.size()
    }

    /// How far the next texels along u and v are above or below one, without sign.
    fn step(&self, [x, y]: [i64; 2]) -> DVec2 {
        let here = self.texel([x, y]);
        DVec2::new(self.texel([x + 1, y]) - here, self.texel([x, y + 1]) - here).abs()
    }

    /// Blocks along both axes.
    fn blocks(&self) -> [usize; 2] {
        self.size.map(|n| (n as usize).div_ceil(BLOCK as usize))
    }

    fn block_steps(&self) -> Vec<DVec2> {
        let [columns, rows] = self.blocks();
        let [side, width] = [BLOCK, self.size[0]].map(|n| n as usize);
        let next = |i: usize, axis: usize| self.wrap[axis].index(i as i64 + 1, self.size[axis]) as usize;
        let last = next(width - 1, 0);
        let block = |i: usize| {
            let first = [i % columns, i / columns].map(|k| k * side);
            let mut most = DVec2::ZERO;
            for y in first[1]..(first[1] + side).min(self.size[1] as usize) {
                let [here, below] = [y, next(y, 1)].map(|y| &self.texels[y * width..][..width]);
                for x in first[0]..(first[0] + side).min(width) {
                    let right = here[if x + 1 < width { x + 1 } else { last }];
                    let [h, right, below] = [here[x], right, below[x]].map(f64::from);
                    most = most.max(DVec2::new(right - h, below - h).abs());
                }
            }
            most
        };
        (0..columns * rows).into_par_iter().map(block).collect()
    }

    /// The height at `uv`, and its derivatives.
    fn at(&self, uv: DVec2) -> (f64, DVec2) {
        let size = self.size();
        let place = uv * size - 0.5;
        let (low, between) = (place.floor(), place - place.floor());
        let (x, y) = (low.x as i64, low.y as i64);
        let [a, b] = [self.texel([x, y]), self.texel([x + 1, y])];
        let [c, d] = [self.texel([x, y + 1]), self.texel([x + 1, y + 1])];
        let lerp = |a: f64, b: f64, s: f64| a + (b - a) * s;
        let height = lerp(lerp(a, b, between.x), lerp(c, d, between.x), between.y);
        let slope = DVec2::new(lerp(b - a, d - c, between.y), lerp(c - a, d - b, between.x));
        (height, slope * size)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::HeightTexels;

    /// Small boxes are looked at texel by texel, large ones by blocks; neither misses a step, and where the map repeats blocks
    /// see no farther than one of them beyond.
    #[test]
    fn no_step_in_a_box_is_missed() {
        let mut state = 1u32;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            state >> 16
        };
        let (width, height) = (53, 37);
        let texels = (0..width * height).map(|_| if next() % 97 == 0 { next() as u16 } else { 0 }).collect();
        let map = HeightMap { name: "peaks".into(), width, height, texels: HeightTexels::U16(texels) };
        for wrap in [[Wrap::Repeat; 2], [Wrap::Mirror, Wrap::Clamp], [Wrap::Clamp, Wrap::Mirror]] {
            let heights = MapHeights::new(&map, wrap);
            for _ in 0..200 {
                let mut share = |most: f64| f64::from(next()) / 65536.0 * most;
                let low = DVec2::new(share(3.0) - 1.0, share(3.0) - 1.0);
                let high = low + DVec2::new(share(1.2), share(1.2));
                let most = |more: i64| {
                    let [a, b] = [low, high].map(|uv| (uv * heights.size() - 0.5).floor());
                    let rows = a.y as i64 - more..=b.y as i64 + 1 + more;
                    let texels = rows.flat_map(|y| (a.x as i64 - more..=b.x as i64 + 1 + more).map(move |x| [x, y]));
                    texels.map(|at| heights.step(at)).fold(DVec2::ZERO, DVec2::max) * heights.size()
                };
                let found = heights.steepest(low, high);
                assert!(found.cmpge(most(0)).all(), "{wrap:?} {low} {high}: {found} < {}", most(0));
                let near = found.cmple(most(BLOCK + 1)).all();
                assert!(near || wrap != [Wrap::Repeat; 2], "{wrap:?} {low} {high}: {found}");
            }
        }
    }
}
