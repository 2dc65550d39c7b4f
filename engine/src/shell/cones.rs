//! Cone maps: how wide a cone over each texel a ray may cross in one step.
//!
//! A cone stands on the bilinear surface at p, its axis along the height; its ratio is its radius, in UV, at height 1
//! above its tip, and 1 at most. Two promises (Dummer, *Cone Step Mapping*, 2006; Policarpo and Oliveira, *Relaxed Cone
//! Stepping for Relief Mapping*, GPU Gems 3, chapter 18, 2007):
//!
//! - plain: no surface in the cone. Its steepness, 1 / ratio, is at least (h(q) - h(p)) / |q - p| for all q;
//! - relaxed: a ray that starts on the axis and does not climb crosses the surface at most once while in the cone. If it
//!   came out of the surface at q, the surface would fall at q more steeply than the ray, so away from p. So steepness
//!   need be at least that quotient only for those q where the surface falls away from p, ∇h(q)·(q - p) < 0; and as the
//!   ray may be as flat as it likes, no less will do.
//!
//! Published maps take p and q at texel centres, which holds neither promise between them (Bán, Valasek, Bálint and Vad,
//! *Robust Cone Step Mapping*, 2024). Here both range over whole bilinear cells: a cell's steepness is a bound over all p
//! in it, and a texel takes the widest cone that serves the four cells around its centre. So each of the four texels
//! around a point serves the point, and so does everything between their ratios: a map can be read nearest or bilinearly.
//!
//! For a pair of cells, p = Σ v_i p_i and q = Σ w_j q_j with bilinear weights over their corners. The bounds are:
//!
//! - (max h(q) - min h(p)) / distance of the cells;
//! - with a unit vector u from cell to cell, |q - p| ≥ Σ v_i w_j (q_j - p_i)·u, and h(q) - h(p) = Σ v_i w_j (h_j - h_i):
//!   the quotient is at most the greatest of (h_j - h_i) / ((q_j - p_i)·u);
//! - relaxed: ∇h(q)·(q - p) < 0 may be taken off h(q) - h(p), which leaves how far q's tangent plane lies over the
//!   surface at p. That is linear in each coordinate of p and of q, so again its corners bound it;
//! - cells that touch: no mean slope is above the steepest slope, in directions from p's cell to q's, of the cells in
//!   between. Relaxed: nor, since the slope at q is negative, above the greatest fall of the slope on the way.
//!
//! This module is the definition, by all pairs of cells in f64; `render::cones` finds the same by a hierarchical search.

use crate::scene::{HeightMap, Wrap};

#[cfg(test)]
mod tests;

/// What a cone promises.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ConeKind {
    /// No surface inside.
    Plain,
    /// A ray from the axis that does not climb crosses the surface at most once inside.
    Relaxed,
}

/// A height map, cell by cell.
#[derive(Clone, Debug)]
pub struct Heights {
    size: [i64; 2],
    texels: Vec<f64>,
    wrap: [Wrap; 2],
}

/// The bilinear patch between four texel centres.
#[derive(Clone, Copy, Debug)]
pub struct Cell {
    /// Heights of the corners, row by row.
    pub corners: [f64; 4],
    /// Least and greatest height.
    pub range: [f64; 2],
    /// Least and greatest slope along u and along v, heights per UV. Each changes along the other axis only.
    pub slopes: [[f64; 2]; 2],
}

impl Heights {
    /// The heights of `map`, wrapped so.
    pub fn new(map: &HeightMap, wrap: [Wrap; 2]) -> Self {
        let size = [map.width, map.height].map(i64::from);
        let texels = (0..map.height).flat_map(|y| (0..map.width).map(move |x| map.height(x, y))).collect();
        Heights { size, texels, wrap }
    }

    /// Columns and rows of texels.
    pub fn size(&self) -> [i64; 2] {
        self.size
    }

    fn texel(&self, at: [i64; 2]) -> f64 {
        let [x, y] = [0, 1].map(|axis| self.wrap[axis].index(at[axis], self.size[axis]));
        self.texels[(y * self.size[0] + x) as usize]
    }

    /// The cell between the centres of texels (x, y) and (x + 1, y + 1).
    pub fn cell(&self, [x, y]: [i64; 2]) -> Cell {
        let h = [[x, y], [x + 1, y], [x, y + 1], [x + 1, y + 1]].map(|at| self.texel(at));
        let range = [h.into_iter().fold(1.0, f64::min), h.into_iter().fold(0.0, f64::max)];
        let ordered = |axis: usize, a: f64, b: f64| [a.min(b), a.max(b)].map(|s| s * self.size[axis] as f64);
        Cell { corners: h, range, slopes: [ordered(0, h[1] - h[0], h[3] - h[2]), ordered(1, h[2] - h[0], h[3] - h[1])] }
    }

    /// The least steepness of a cone that keeps its promise over the whole of a cell: heights per UV, at least 1.
    pub fn steepness(&self, kind: ConeKind, at: [i64; 2]) -> f64 {
        let cell = self.cell(at);
        let mut steepest = self.near(kind, at).max(1.0);
        // Square by square around the cell. Beyond one period in UV no height can be out of reach of a cone of ratio 1.
        let reach = self.size.map(|n| n + 1);
        let texel = 1.0 / self.size[0].max(self.size[1]) as f64;
        for ring in 2..=reach[0].max(reach[1]) {
            // So far away nothing is steeper: no height is over 1.
            if steepest * (ring - 1) as f64 * texel > 1.0 - cell.range[0] {
                break;
            }
            for y in (-ring).max(-reach[1])..=ring.min(reach[1]) {
                let step = if y.abs() == ring { 1 } else { 2 * ring };
                for x in (-ring..=ring).step_by(step as usize).filter(|x| x.abs() <= reach[0]) {
                    let far = [at[0] + x, at[1] + y];
                    if self.counts(far) {
                        steepest = steepest.max(self.far(kind, &cell, &self.cell(far), [x, y]));
                    }
                }
            }
        }
        steepest
    }

    /// Whether a cell can ask for what no other asks for. Where the map is clamped, the cells beyond its outermost ones
    /// repeat them, and those are nearer.
    fn counts(&self, at: [i64; 2]) -> bool {
        (0..2).all(|axis| self.wrap[axis] != Wrap::Clamp || (-1..self.size[axis]).contains(&at[axis]))
    }

    /// Steepness over a cell and the eight around it.
    fn near(&self, kind: ConeKind, at: [i64; 2]) -> f64 {
        let cell = self.cell(at);
        let own = cell.steepest([0, 0]);
        let mut steepest = match kind {
            ConeKind::Plain => own,
            // From p to a q where h no longer climbs, a quadratic climbs by no more than half its second derivative.
            ConeKind::Relaxed => {
                let [a, b, c, d] = cell.corners;
                (a - b - c + d).abs() / (1.0 / self.size[0] as f64).hypot(1.0 / self.size[1] as f64)
            }
        };
        for toward in (-1..=1).flat_map(|y| (-1..=1).map(move |x| [x, y])).filter(|toward| *toward != [0, 0]) {
            let beyond = self.cell([at[0] + toward[0], at[1] + toward[1]]);
            if beyond.range[1] <= cell.range[0] {
                continue;
            }
            let sides = [self.cell([at[0] + toward[0], at[1]]), self.cell([at[0], at[1] + toward[1]])];
            let way = [cell, beyond, sides[0], sides[1]];
            let mut bound = way[1..].iter().map(|c| c.steepest(toward)).fold(own, f64::max);
            if kind == ConeKind::Relaxed {
                bound = bound.min(beyond.steepest_fall(&way, toward));
            }
            steepest = steepest.max(bound);
        }
        steepest
    }

    /// Steepness from a cell p to a cell q that does not touch it; q is `offset` cells from p.
    fn far(&self, kind: ConeKind, p: &Cell, q: &Cell, offset: [i64; 2]) -> f64 {
        let texel = self.size.map(|n| 1.0 / n as f64);
        let gap = [0, 1].map(|axis| (offset[axis].abs() - 1).max(0) as f64 * texel[axis]);
        let distance = gap[0].hypot(gap[1]);
        let mut rise = q.range[1] - p.range[0];
        if kind == ConeKind::Relaxed {
            // Less the least that the slope at q can add on the way.
            for axis in 0..2 {
                let way = [offset[axis] - 1, offset[axis] + 1].map(|n| n as f64 * texel[axis]);
                let products = way.into_iter().flat_map(|w| q.slopes[axis].map(|s| s * w));
                rise -= products.fold(f64::INFINITY, f64::min);
            }
            rise = rise.min(q.range[1] - p.range[0]);
        }
        if rise <= 0.0 {
            return 0.0;
        }
        let along = [0, 1].map(|axis| offset[axis] as f64 * texel[axis]);
        let length = along[0].hypot(along[1]);
        let (mut chord, mut tangent) = (0.0, 0.0);
        for (i, j) in (0..4).flat_map(|i| (0..4).map(move |j| (i, j))) {
            let way = [offset[0] + j % 2 - i % 2, offset[1] + j / 2 - i / 2];
            let way = [0, 1].map(|axis| way[axis] as f64 * texel[axis]);
            let away = (way[0] * along[0] + way[1] * along[1]) / length;
            let rise = q.corners[j as usize] - p.corners[i as usize];
            let slope = q.slope_at(j as usize, self.size);
            chord = f64::max(chord, rise / away);
            tangent = f64::max(tangent, (rise - slope[0] * way[0] - slope[1] * way[1]) / away);
        }
        let bound = chord.min(rise / distance);
        if kind == ConeKind::Relaxed { bound.min(tangent) } else { bound }
    }
}

impl Cell {
    /// The steepest slope in directions that do not lead away from `toward` along any axis; 0 stands for both ways.
    fn steepest(&self, toward: [i64; 2]) -> f64 {
        let [x, y] = [0, 1].map(|axis| climb(self.slopes[axis], toward[axis]));
        x.hypot(y)
    }

    /// The most that the slope in such directions falls from any of `way` to this cell.
    fn steepest_fall(&self, way: &[Cell], toward: [i64; 2]) -> f64 {
        let [x, y] = [0, 1].map(|axis| {
            let low = way.iter().map(|c| c.slopes[axis][0]).fold(f64::INFINITY, f64::min);
            let high = way.iter().map(|c| c.slopes[axis][1]).fold(f64::NEG_INFINITY, f64::max);
            climb([low - self.slopes[axis][1], high - self.slopes[axis][0]], toward[axis])
        });
        x.hypot(y)
    }

    /// Slope along u and v at a corner.
    fn slope_at(&self, corner: usize, size: [i64; 2]) -> [f64; 2] {
        let [a, b, c, d] = self.corners;
        let u = if corner >> 1 == 0 { b - a } else { d - c };
        let v = if corner & 1 == 0 { c - a } else { d - b };
        [u * size[0] as f64, v * size[1] as f64]
    }
}

/// The steepest climb among slopes along one axis, walked in one direction, or in both for 0.
fn climb([low, high]: [f64; 2], toward: i64) -> f64 {
    match toward {
        0 => high.abs().max(low.abs()),
        1 => high.max(0.0),
        _ => (-low).max(0.0),
    }
}

/// The cone map of a map of `size` texels from the steepness of its cells, from (-1, -1) to (n - 1, n - 1), row by row:
/// √ratio of each texel, as 16 bits rounded down, so that cones only become narrower.
pub fn quantise(size: [u32; 2], cells: &[f64]) -> Vec<u16> {
    let [width, height] = size.map(|n| n as usize);
    let root = |x: usize, y: usize| {
        let at = |i: usize, j: usize| cells[j * (width + 1) + i];
        let steepest = at(x, y).max(at(x + 1, y)).max(at(x, y + 1)).max(at(x + 1, y + 1));
        (65535.0 / steepest.sqrt()).floor() as u16
    };
    (0..height).flat_map(|y| (0..width).map(move |x| root(x, y))).collect()
}

/// The cone map by all pairs of cells: √ratio of each texel as [`quantise`] says. For small maps.
pub fn by_all_pairs(map: &HeightMap, wrap: [Wrap; 2], kind: ConeKind) -> Vec<u16> {
    let heights = Heights::new(map, wrap);
    let [width, height] = heights.size();
    let cells: Vec<f64> =
        (-1..height).flat_map(|y| (-1..width).map(move |x| [x, y])).map(|at| heights.steepness(kind, at)).collect();
    quantise([map.width, map.height], &cells)
}
