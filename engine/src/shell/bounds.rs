//! Conservative bounds of a height field over a box of texture coordinates (DESIGN section 5: tight bounds thin the
//! shell). A procedure brings its own.
//!
//! A bilinear surface lies between the least and the greatest texel that it reads. A box of UV reads the texels from
//! `floor(u n - 1/2)` to `floor(u n - 1/2) + 1`, wrapped one by one, so the bounds come from an exact range query over
//! texels, answered by a min-max pyramid over blocks of the map as it is stored: the border texels that bilinear
//! filtering adds are part of the query, not of the nodes.

use std::ops::{Range, RangeInclusive};

use glam::{DAffine2, DVec2, Vec2};
use rayon::prelude::*;

use crate::scene::{Displacement, HeightMap, HeightSource, HeightTexels, Procedure, Scene, Wrap};

/// Bounds grow by this share of themselves: f32 conversion and lerp of a shader may leave the texels' hull by 2 ulp.
const VALUE_PAD: f32 = 3e-7;

/// The UV box grows by this share of its largest coordinate: f32 interpolation and transform of UVs.
const UV_PAD: f64 = 1e-6;

/// The UV box grows by this much of a texel: fixed-point sampling positions of texture units (8 fractional bits).
const TEXEL_PAD: f64 = 1.0 / 256.0;

/// Room for the rounding of a procedure in f32, beyond that of its UVs.
const PROCEDURE_PAD: f64 = 2e-6;

/// A procedure's bounds are sought over so many parts of a box, along both axes: bounds of small boxes are tighter.
const PARTS: u32 = 8;

/// The bounds of whatever gives a displacement its heights.
#[derive(Clone, Debug)]
pub enum FieldBounds<'a> {
    /// Of a map.
    Map(HeightBounds<'a>),
    /// Of a function.
    Procedure(Procedure),
}

impl<'a> FieldBounds<'a> {
    /// Those of `displacement`.
    pub fn new(scene: &'a Scene, displacement: &Displacement) -> Self {
        match displacement.source {
            HeightSource::Map(map) => FieldBounds::Map(HeightBounds::new(&scene.height_maps[map], displacement.wrap)),
            HeightSource::Procedure(procedure) => FieldBounds::Procedure(procedure),
        }
    }

    /// Least and greatest height over a box of UV, padded for the rounding of f32 shaders.
    pub fn over(&self, uv_min: DVec2, uv_max: DVec2) -> (f32, f32) {
        match self {
            FieldBounds::Map(bounds) => bounds.over(uv_min, uv_max),
            FieldBounds::Procedure(procedure) => procedure_over(*procedure, uv_min, uv_max),
        }
    }
}

fn procedure_over(procedure: Procedure, uv_min: DVec2, uv_max: DVec2) -> (f32, f32) {
    let pad = UV_PAD * uv_min.abs().max(uv_max.abs()).max(DVec2::ONE);
    let part = (uv_max - uv_min + 2.0 * pad) / f64::from(PARTS);
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for (i, j) in (0..PARTS).flat_map(|i| (0..PARTS).map(move |j| (i, j))) {
        let corner = |i: u32, j: u32| uv_min - pad + part * DVec2::new(f64::from(i), f64::from(j));
        let [least, greatest] = procedure.bounds(corner(i, j), corner(i + 1, j + 1));
        (low, high) = (low.min(least), high.max(greatest));
    }
    ((low - PROCEDURE_PAD) as f32, (high + PROCEDURE_PAD) as f32)
}

/// A min-max pyramid of one height map under one pair of wrap modes.
#[derive(Clone, Debug)]
pub struct HeightBounds<'a> {
    texels: &'a HeightTexels,
    size: [usize; 2],
    wrap: [Wrap; 2],
    /// A node of level L covers [`BLOCK`] · 2^L texels a side.
    levels: Vec<Level>,
}

/// Texels a side of the smallest nodes. Whatever covers but a part of one is looked at texel by texel: a large map's own
/// pyramid would be many times as large as the map.
const BLOCK: usize = 8;

#[derive(Clone, Debug)]
struct Level {
    size: [usize; 2],
    /// (min, max), row-major.
    nodes: Vec<(f32, f32)>,
}

impl<'a> HeightBounds<'a> {
    /// Builds the pyramid of `map`, read with `wrap` in u and v.
    pub fn new(map: &'a HeightMap, wrap: [Wrap; 2]) -> Self {
        let size = [map.width as usize, map.height as usize];
        let mut bounds = HeightBounds { texels: &map.texels, size, wrap, levels: Vec::new() };
        let blocks = size.map(|n| n.div_ceil(BLOCK));
        let block = |i: usize| {
            let first = [i % blocks[0], i / blocks[0]].map(|k| k * BLOCK);
            let end = [0, 1].map(|axis| (first[axis] + BLOCK).min(size[axis]));
            bounds.of_texels([first[0]..end[0], first[1]..end[1]])
        };
        let nodes = (0..blocks[0] * blocks[1]).into_par_iter().map(block).collect();
        let mut levels = vec![Level { size: blocks, nodes }];
        while let Some(last) = levels.last().filter(|last| last.size != [1, 1]) {
            levels.push(last.halved());
        }
        bounds.levels = levels;
        bounds
    }

    /// Least and greatest of some texels, of these columns and rows.
    fn of_texels(&self, [columns, rows]: [Range<usize>; 2]) -> (f32, f32) {
        let in_row = |y: usize| {
            let row = y * self.size[0];
            extremes(self.texels, row + columns.start..row + columns.end)
        };
        rows.map(in_row).fold((f32::INFINITY, f32::NEG_INFINITY), |(lo, hi), (min, max)| (lo.min(min), hi.max(max)))
    }

    /// Least and greatest height over the box `uv_min..=uv_max` (height map coordinates, after any
    /// `KHR_texture_transform`, not wrapped), padded for the rounding of f32 shaders.
    pub fn over(&self, uv_min: DVec2, uv_max: DVec2) -> (f32, f32) {
        let texels = |axis: usize| texels_read(self.size[axis], self.wrap[axis], uv_min[axis], uv_max[axis]);
        let (mut lo, mut hi) = (f32::INFINITY, f32::NEG_INFINITY);
        for rows in texels(1).into_iter().flatten() {
            for columns in texels(0).into_iter().flatten() {
                self.extend(self.levels.len() - 1, [0, 0], [&columns, &rows], &mut lo, &mut hi);
            }
        }
        (lo * (1.0 - VALUE_PAD), hi * (1.0 + VALUE_PAD))
    }

    /// [`HeightBounds::over`] for the UV bounding box of a triangle: `uvs` as stored in the primitive, `transform` the
    /// displacement's `KHR_texture_transform`.
    pub fn over_triangle(&self, transform: &DAffine2, uvs: [Vec2; 3]) -> (f32, f32) {
        let [a, b, c] = uvs.map(|uv| transform.transform_point2(uv.as_dvec2()));
        self.over(a.min(b).min(c), a.max(b).max(c))
    }

    /// Extends `lo..hi` by the texels of `query` (columns, rows) below node `at` of `level`.
    fn extend(&self, level: usize, at: [usize; 2], query: [&RangeInclusive<usize>; 2], lo: &mut f32, hi: &mut f32) {
        let Level { size, nodes } = &self.levels[level];
        let (min, max) = nodes[at[1] * size[0] + at[0]];
        if min >= *lo && max <= *hi {
            return;
        }
        let side = BLOCK << level;
        let first = at.map(|i| i * side);
        let last = [0, 1].map(|a| (first[a] + side - 1).min(self.size[a] - 1));
        if (0..2).any(|a| last[a] < *query[a].start() || first[a] > *query[a].end()) {
            return;
        }
        if (0..2).all(|a| query[a].contains(&first[a]) && query[a].contains(&last[a])) {
            (*lo, *hi) = (lo.min(min), hi.max(max));
            return;
        }
        if level == 0 {
            let part = [0, 1].map(|a| first[a].max(*query[a].start())..last[a].min(*query[a].end()) + 1);
            let (min, max) = self.of_texels(part);
            (*lo, *hi) = (lo.min(min), hi.max(max));
            return;
        }
        let below = self.levels[level - 1].size;
        for y in (2 * at[1]..2 * at[1] + 2).filter(|y| *y < below[1]) {
            for x in (2 * at[0]..2 * at[0] + 2).filter(|x| *x < below[0]) {
                self.extend(level - 1, [x, y], query, lo, hi);
            }
        }
    }
}

impl Level {
    fn halved(&self) -> Level {
        let size = self.size.map(|n| n.div_ceil(2));
        let mut nodes = vec![(f32::INFINITY, f32::NEG_INFINITY); size[0] * size[1]];
        for (i, (min, max)) in self.nodes.iter().enumerate() {
            let node = &mut nodes[i / self.size[0] / 2 * size[0] + i % self.size[0] / 2];
            *node = (node.0.min(*min), node.1.max(*max));
        }
        Level { size, nodes }
    }
}

/// Least and greatest height of neighbouring texels.
fn extremes(texels: &HeightTexels, range: Range<usize>) -> (f32, f32) {
    fn of<T: Copy + Ord>(texels: &[T], height: impl Fn(T) -> f32) -> (f32, f32) {
        let (low, high) = (texels.iter().copied().min(), texels.iter().copied().max());
        (low.map_or(f32::INFINITY, &height), high.map_or(f32::NEG_INFINITY, &height))
    }
    match texels {
        HeightTexels::U8(texels) => of(&texels[range], |v| f32::from(v) / 255.0),
        HeightTexels::U16(texels) => of(&texels[range], |v| f32::from(v) / 65535.0),
        HeightTexels::F16(texels) => {
            let heights = texels[range].iter().map(|v| v.to_f32());
            heights.fold((f32::INFINITY, f32::NEG_INFINITY), |(lo, hi), h| (lo.min(h), hi.max(h)))
        }
    }
}

/// The one height that a map has wherever its field is read over a box of UV, if there is one.
pub fn constant_over(map: &HeightMap, wrap: [Wrap; 2], uv_min: DVec2, uv_max: DVec2) -> Option<f64> {
    let size = [map.width, map.height];
    let texels = |axis: usize| texels_read(size[axis] as usize, wrap[axis], uv_min[axis], uv_max[axis]);
    let (rows, columns) = (texels(1).into_iter().flatten().flatten(), texels(0).into_iter().flatten().flatten());
    let columns: Vec<usize> = columns.collect();
    let mut heights = rows.flat_map(|y| columns.iter().map(move |x| map.height(*x as u32, y as u32)));
    let first = heights.next()?;
    heights.all(|height| height == first).then_some(first)
}

/// The texels of an axis of `n` that a bilinear field reads between two coordinates.
fn texels_read(n: usize, wrap: Wrap, lo: f64, hi: f64) -> [Option<RangeInclusive<usize>>; 2] {
    let texels = n as f64;
    let pad = UV_PAD * lo.abs().max(hi.abs()).max(1.0) * texels + TEXEL_PAD;
    let [first, last] = [lo * texels - 0.5 - pad, hi * texels - 0.5 + pad].map(|at| at.floor() as i64);
    wrapped_range(first, last + 1, n, wrap)
}

/// The texels of an axis of `n` that the unwrapped texels `first..=last` fold onto: one or two ranges. Where a
/// mirrored range turns inside, the whole axis up to the turn's far end is taken, which is what it covers.
pub(super) fn wrapped_range(first: i64, last: i64, n: usize, wrap: Wrap) -> [Option<RangeInclusive<usize>>; 2] {
    let len = n as i64;
    let all = [Some(0..=n - 1), None];
    if wrap == Wrap::Clamp {
        return [Some(first.clamp(0, len - 1) as usize..=last.clamp(0, len - 1) as usize), None];
    }
    if last - first + 1 >= len {
        return all;
    }
    // Shorter than one period from here on, so at most one seam lies inside.
    let (a, b) = (first.rem_euclid(len), last.rem_euclid(len));
    let period_of = |i: i64| i.div_euclid(len);
    match (wrap, period_of(first) == period_of(last)) {
        (Wrap::Repeat, true) => [Some(a as usize..=b as usize), None],
        (Wrap::Repeat, false) => [Some(a as usize..=n - 1), Some(0..=b as usize)],
        (_, true) if period_of(first) % 2 == 0 => [Some(a as usize..=b as usize), None],
        (_, true) => [Some((len - 1 - b) as usize..=(len - 1 - a) as usize), None],
        // From an even period into an odd one the turn is at n - 1, else at 0.
        (_, false) if period_of(first) % 2 == 0 => [Some(a.min(len - 1 - b) as usize..=n - 1), None],
        (_, false) => [Some(0..=(len - 1 - a).max(b) as usize), None],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noise(width: u32, height: u32, seed: u32) -> HeightMap {
        let texel = |i: u32| (i.wrapping_add(seed).wrapping_mul(2654435761) >> 13) as u16;
        HeightMap {
            name: "noise".into(),
            width,
            height,
            texels: HeightTexels::U16((0..width * height).map(texel).collect()),
        }
    }

    fn wrapped(i: i64, n: i64, wrap: Wrap) -> i64 {
        match wrap {
            Wrap::Repeat => i.rem_euclid(n),
            Wrap::Clamp => i.clamp(0, n - 1),
            Wrap::Mirror => {
                let i = i.rem_euclid(2 * n);
                i.min(2 * n - 1 - i)
            }
        }
    }

    /// The bilinear surface, texel by texel.
    fn sample(map: &HeightMap, wrap: [Wrap; 2], uv: DVec2) -> f64 {
        let (w, h) = (i64::from(map.width), i64::from(map.height));
        let (x, y) = (uv.x * w as f64 - 0.5, uv.y * h as f64 - 0.5);
        let HeightTexels::U16(texels) = &map.texels else { unreachable!("16-bit maps only") };
        let at = |dx: i64, dy: i64| {
            let i = wrapped(x.floor() as i64 + dx, w, wrap[0]) + w * wrapped(y.floor() as i64 + dy, h, wrap[1]);
            f64::from(texels[i as usize]) / 65535.0
        };
        let (a, b) = (x - x.floor(), y - y.floor());
        (at(0, 0) * (1.0 - a) + at(1, 0) * a) * (1.0 - b) + (at(0, 1) * (1.0 - a) + at(1, 1) * a) * b
    }

    #[test]
    fn bounds_contain_the_dense_samples_in_every_wrap_mode() {
        let mut seed = 7u64;
        let mut next = || {
            seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (seed >> 11) as f64 / (1u64 << 53) as f64
        };
        for (width, height) in [(1, 1), (7, 5), (16, 16), (33, 2)] {
            for wrap in [[Wrap::Repeat; 2], [Wrap::Mirror; 2], [Wrap::Clamp; 2], [Wrap::Mirror, Wrap::Repeat]] {
                let map = noise(width, height, 11 * width);
                let bounds = HeightBounds::new(&map, wrap);
                for _ in 0..300 {
                    let min = DVec2::new(next(), next()) * 8.0 - 4.0;
                    let extent = DVec2::new(next().powi(3), next().powi(3)) * 1.5;
                    let (lo, hi) = bounds.over(min, min + extent);
                    let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
                    for i in 0..=24 {
                        for j in 0..=24 {
                            let uv = min + extent * DVec2::new(f64::from(i), f64::from(j)) / 24.0;
                            let h = sample(&map, wrap, uv);
                            (least, most) = (least.min(h), most.max(h));
                        }
                    }
                    assert!(
                        f64::from(lo) <= least && f64::from(hi) >= most,
                        "{width}×{height} {wrap:?} {min} {extent}"
                    );
                }
            }
        }
    }

    #[test]
    fn bounds_are_the_texels_that_the_box_reads() {
        let mut map = noise(8, 8, 0);
        map.texels = HeightTexels::U8((0..64).map(|i| if i == 27 { 255 } else { 51 }).collect());
        let bounds = HeightBounds::new(&map, [Wrap::Repeat; 2]);
        // Texel (3, 3) has its centre at 3.5 / 8 and is read from 2.5 / 8 to 4.5 / 8.
        let near = |x: f64| DVec2::splat(x / 8.0);
        assert!(bounds.over(near(2.6), near(2.7)).1 >= 1.0);
        assert!(bounds.over(near(4.6), near(5.9)).1 < 0.21);
        assert!(bounds.over(near(4.6) + 3.0, near(5.9) + 3.0).1 < 0.21);
        assert!(bounds.over(near(4.6), near(10.6)).1 >= 1.0, "the next tile's peak");
        assert!(bounds.over(near(0.0), near(8.0)).0 > 0.19);
    }

    #[test]
    fn a_procedure_s_bounds_contain_it_and_thin_the_shell() {
        let mut seed = 11u64;
        let mut next = || {
            seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (seed >> 11) as f64 / (1u64 << 53) as f64
        };
        for procedure in Procedure::ALL {
            let bounds = FieldBounds::Procedure(procedure);
            let (mut loose, mut tight) = (0.0, 0.0);
            for _ in 0..300 {
                let min = DVec2::new(next(), next()) * 8.0 - 4.0;
                let extent = DVec2::new(next(), next()) * 0.2;
                let (lo, hi) = bounds.over(min, min + extent);
                let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
                for (i, j) in (0..=64).flat_map(|i| (0..=64).map(move |j| (i, j))) {
                    let h = procedure.height(min + extent * DVec2::new(f64::from(i), f64::from(j)) / 64.0);
                    (least, most) = (least.min(h), most.max(h));
                }
                assert!(f64::from(lo) <= least && f64::from(hi) >= most, "{procedure:?} {min} {extent}");
                loose += f64::from(hi - lo);
                tight += most - least;
            }
            assert!(loose < 1.25 * tight, "{procedure:?}: {loose} for {tight}");
        }
    }

    #[test]
    fn the_transform_applies_before_the_box() {
        let map = noise(16, 16, 3);
        let bounds = HeightBounds::new(&map, [Wrap::Repeat; 2]);
        let turn = DAffine2::from_angle_translation(0.7, DVec2::new(0.3, -2.0));
        let uvs = [Vec2::new(0.1, 0.1), Vec2::new(0.2, 0.1), Vec2::new(0.1, 0.3)];
        let (lo, hi) = bounds.over_triangle(&turn, uvs);
        for i in 0..=20 {
            for j in 0..=20 - i {
                let (a, b) = (f64::from(i) / 20.0, f64::from(j) / 20.0);
                let uv = uvs[0].as_dvec2() * (1.0 - a - b) + uvs[1].as_dvec2() * a + uvs[2].as_dvec2() * b;
                let h = sample(&map, [Wrap::Repeat; 2], turn.transform_point2(uv));
                assert!(f64::from(lo) <= h && h <= f64::from(hi));
            }
        }
    }
}
