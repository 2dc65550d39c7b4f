//! The reference's own reading of heights: wrapped texels and bilinear cells, in f64, or a procedure.

use glam::DVec2;

use crate::scene::{HeightMap, HeightTexels, Procedure, Wrap};

/// What gives a relief its heights.
#[derive(Clone, Debug)]
pub(super) enum HeightField {
    Map(Texels),
    /// As a map of one texel that repeats: texel coordinates are UVs less a half, and whole ones make no difference.
    Procedure(Procedure),
}

/// Texels of a height map, row 0 on top.
#[derive(Clone, Debug)]
pub(super) struct Texels {
    size: [i64; 2],
    texels: Vec<f32>,
    /// The texel value that means height 1.
    one: f64,
    /// Least and greatest height of the map.
    extent: [f64; 2],
}

/// The bilinear height between four texel centres: `h = c00 + c10 a + c01 b + c11 a b`, with a, b ∈ [0, 1].
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell {
    /// Constant, a, b and a·b coefficients.
    pub(super) c: [f64; 4],
    /// Least and greatest height of the cell.
    pub(super) extent: [f64; 2],
}

impl HeightField {
    pub(super) fn new(map: &HeightMap) -> Self {
        let (texels, one): (Vec<f32>, f64) = match &map.texels {
            HeightTexels::U8(texels) => (texels.iter().map(|v| f32::from(*v)).collect(), 255.0),
            HeightTexels::U16(texels) => (texels.iter().map(|v| f32::from(*v)).collect(), 65535.0),
            HeightTexels::F16(texels) => (texels.iter().map(|v| v.to_f32()).collect(), 1.0),
        };
        let least = texels.iter().copied().reduce(f32::min).map_or(0.0, |v| f64::from(v) / one);
        let most = texels.iter().copied().reduce(f32::max).map_or(0.0, |v| f64::from(v) / one);
        let size = [i64::from(map.width), i64::from(map.height)];
        HeightField::Map(Texels { size, texels, one, extent: [least, most] })
    }

    /// Width and height in texels.
    pub(super) fn size(&self) -> [f64; 2] {
        match self {
            HeightField::Map(map) => map.size.map(|n| n as f64),
            HeightField::Procedure(_) => [1.0; 2],
        }
    }

    /// Least and greatest height of the whole field.
    pub(super) fn extent(&self) -> [f64; 2] {
        match self {
            HeightField::Map(map) => map.extent,
            HeightField::Procedure(procedure) => procedure.extent(),
        }
    }

    /// Height and its derivatives at texel coordinates `at + base`: texel (0, 0) has its centre at (0, 0).
    pub(super) fn sample(&self, at: DVec2, base: [i64; 2], wrap: [Wrap; 2]) -> (f64, [f64; 2]) {
        match self {
            HeightField::Map(map) => {
                let whole = at.floor();
                let cell = map.cell(whole.x as i64 + base[0], whole.y as i64 + base[1], wrap);
                cell.at(at.x - whole.x, at.y - whole.y)
            }
            HeightField::Procedure(procedure) => (procedure.height(at + 0.5), procedure.gradient(at + 0.5).to_array()),
        }
    }
}

impl Texels {
    /// The cell between the centres of texels (x, y) and (x + 1, y + 1), each wrapped by itself.
    pub(super) fn cell(&self, x: i64, y: i64, wrap: [Wrap; 2]) -> Cell {
        let columns = [wrapped(x, self.size[0], wrap[0]), wrapped(x + 1, self.size[0], wrap[0])];
        let rows = [wrapped(y, self.size[1], wrap[1]), wrapped(y + 1, self.size[1], wrap[1])];
        let at = |i: usize, j: usize| f64::from(self.texels[(columns[i] + rows[j] * self.size[0]) as usize]) / self.one;
        let (h00, h10, h01, h11) = (at(0, 0), at(1, 0), at(0, 1), at(1, 1));
        Cell {
            c: [h00, h10 - h00, h01 - h00, h11 - h10 - h01 + h00],
            extent: [h00.min(h10).min(h01.min(h11)), h00.max(h10).max(h01.max(h11))],
        }
    }
}

impl Cell {
    /// Height and its derivatives at (a, b).
    pub(super) fn at(&self, a: f64, b: f64) -> (f64, [f64; 2]) {
        let [c00, c10, c01, c11] = self.c;
        (c00 + c10 * a + c01 * b + c11 * a * b, [c10 + c11 * b, c01 + c11 * a])
    }
}

fn wrapped(i: i64, n: i64, wrap: Wrap) -> i64 {
    match wrap {
        Wrap::Repeat => i.rem_euclid(n),
        Wrap::Clamp => i.clamp(0, n - 1),
        Wrap::Mirror => {
            let i = i.rem_euclid(2 * n);
            if i < n { i } else { 2 * n - 1 - i }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texel_centres_interpolate_and_wrap() {
        let map = HeightMap { name: String::new(), width: 3, height: 1, texels: HeightTexels::U8(vec![0, 51, 255]) };
        let field = HeightField::new(&map);
        assert_eq!(field.extent(), [0.0, 1.0]);
        let at = |x: f64, wrap: Wrap| (field.sample(DVec2::new(x, 0.3), [0; 2], [wrap; 2]).0 * 5.0 * 1e6).round() / 1e6;
        assert_eq!(at(1.0, Wrap::Repeat), 1.0);
        assert_eq!(at(0.5, Wrap::Repeat), 0.5);
        assert_eq!([at(2.5, Wrap::Repeat), at(2.5, Wrap::Mirror), at(2.5, Wrap::Clamp)], [2.5, 5.0, 5.0]);
        assert_eq!([at(-1.0, Wrap::Repeat), at(-1.0, Wrap::Mirror), at(-1.0, Wrap::Clamp)], [5.0, 0.0, 0.0]);
        assert_eq!([at(4.0, Wrap::Repeat), at(4.0, Wrap::Mirror), at(4.0, Wrap::Clamp)], [1.0, 1.0, 5.0]);
    }
}
