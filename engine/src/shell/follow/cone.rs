//! Cone steps along the chords of a path: `shaders/shell/cone.glsl` and the search of `shaders/shell/march.glsl` that
//! calls it.

use std::{collections::HashMap, sync::Arc};

use glam::{DVec2, IVec2};

use super::{Interval, Outcome};
use crate::{
    scene::{HeightMap, Wrap},
    settings::{March, Settings},
    shell::cones::{ConeKind, Heights},
};

/// No chord strays farther than this from the path, in texels, or is longer than this share of it where it does.
const MOST_BEND: f64 = 0.125;
const LEAST_PIECE: f64 = 1.0 / 64.0;

/// The cones of a height map, each made when it is first asked for: a ray passes few.
pub(super) struct ConeMap {
    heights: Arc<Heights>,
    wrap: [Wrap; 2],
    kind: ConeKind,
    steepness: HashMap<[i64; 2], f64>,
}

impl ConeMap {
    pub(super) fn new(map: &HeightMap, wrap: [Wrap; 2], kind: ConeKind) -> Self {
        ConeMap { heights: Arc::new(Heights::new(map, wrap)), wrap, kind, steepness: HashMap::new() }
    }

    /// The widest ratio of the four texels around a cell: each serves the whole cell.
    fn ratio(&mut self, cell: IVec2) -> f64 {
        let texels = [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[x, y]| [i64::from(cell.x) + x, i64::from(cell.y) + y]);
        let roots = texels.map(|at| self.root(at));
        let root = roots.into_iter().fold(0.0, f64::max);
        0.9999 * root * root
    }

    /// √ratio of a texel, in the 16 bits that a cone map keeps of it.
    fn root(&mut self, at: [i64; 2]) -> f64 {
        let size = self.heights.size();
        let [x, y] = [0, 1].map(|axis| self.wrap[axis].index(at[axis], size[axis]));
        let around = [[x - 1, y - 1], [x, y - 1], [x - 1, y], [x, y]];
        let steepest = around.map(|cell| self.steepness(cell)).into_iter().fold(0.0, f64::max);
        (65535.0 / steepest.sqrt()).floor() / 65535.0
    }

    fn steepness(&mut self, cell: [i64; 2]) -> f64 {
        *self.steepness.entry(cell).or_insert_with(|| self.heights.steepness(self.kind, cell))
    }
}

/// A straight ray through the map: texels and heights.
struct ConeRay<'m> {
    heights: &'m Heights,
    from: DVec2,
    way: DVec2,
    z: f64,
    climb: f64,
}

impl ConeRay<'_> {
    fn clearance(&self, at: f64) -> f64 {
        let p = self.from + at * self.way;
        let cell = p.floor();
        let f = p - cell;
        let h = self.heights.cell([cell.x as i64, cell.y as i64]).corners;
        let lerp = |a: f64, b: f64, x: f64| a + (b - a) * x;
        self.z + at * self.climb - lerp(lerp(h[0], h[1], f.x), lerp(h[2], h[3], f.x), f.y)
    }

    /// The crossing between two places on its two sides.
    fn bisected(&self, mut a: f64, mut b: f64, above: bool, steps: u32, visit: &mut impl FnMut(f64)) -> f64 {
        let (mut fa, mut fb) = (self.clearance(a), self.clearance(b));
        for _ in 0..steps {
            let m = 0.5 * (a + b);
            visit(m);
            let fm = self.clearance(m);
            if (fm >= 0.0) == above { (a, fa) = (m, fm) } else { (b, fb) = (m, fm) }
        }
        a + (b - a) * if fa == fb { 0.5 } else { (fa / (fa - fb)).clamp(0.0, 1.0) }
    }
}

/// Follows the march through one prism.
pub(super) fn search(
    interval: &Interval<'_, '_>,
    cones: &mut ConeMap,
    settings: &Settings,
    samples: &mut Vec<f64>,
) -> Outcome {
    let stretch = interval.stretch;
    let [scale, midlevel] = stretch.scale();
    let mut steps = settings.max_steps;
    let mut above = interval.clearance(0.0) >= 0.0;
    let (mut from, mut piece) = (0.0, 1.0);
    while from < 1.0 {
        let to = f64::min(from + piece, 1.0);
        let ends = [from, to].map(|at| interval.x(at));
        if piece > LEAST_PIECE && stretch.bend(ends[0], ends[1]) > MOST_BEND {
            piece *= 0.5;
            continue;
        }
        let [a, b] = ends.map(|x| stretch.at(x));
        let size = stretch.map_size();
        let [za, zb] = [a, b].map(|station| station.t / scale + midlevel);
        let heights = cones.heights.clone();
        let ray =
            ConeRay { heights: &heights, from: a.uv * size - 0.5, way: (b.uv - a.uv) * size, z: za, climb: zb - za };
        let mut visit = |at: f64| samples.push(from + (to - from) * at);
        if let Some(at) = cone_search(&ray, cones, settings, stretch.double_sided(), &mut above, &mut steps, &mut visit)
        {
            return Outcome::Hit(from + (to - from) * at);
        }
        from = to;
    }
    Outcome::Passed
}

/// Where along a chord the field is hit; `above` and `steps` go on from chord to chord.
fn cone_search(
    ray: &ConeRay<'_>,
    cones: &mut ConeMap,
    settings: &Settings,
    two_sided: bool,
    above: &mut bool,
    steps: &mut u32,
    visit: &mut impl FnMut(f64),
) -> Option<f64> {
    let relaxed = settings.march == March::RelaxedCone;
    let reach = (ray.way / DVec2::from(cones.heights.size().map(|n| n as f64))).length();
    let nudge = f64::max(1e-4 / ray.way.abs().max_element().max(1e-4), 2e-7);
    let mut at = 0.0;
    while at < 1.0 {
        visit(at);
        if *steps == 0 {
            let ends_above = ray.clearance(1.0) >= 0.0;
            let hit = ends_above != *above && (*above || two_sided);
            let found = hit.then(|| ray.bisected(at, 1.0, *above, settings.refine_steps, visit));
            *above = ends_above;
            return found;
        }
        *steps -= 1;
        let cell = (ray.from + (at + nudge) * ray.way).floor();
        let f = ray.from + at * ray.way - cell;
        let h = ray.heights.cell([cell.x as i64, cell.y as i64]).corners;
        let twist = h[0] - h[1] - h[2] + h[3];
        let slope = DVec2::new(h[1] - h[0] + twist * f.y, h[2] - h[0] + twist * f.x);
        let surface = h[0] + (h[1] - h[0]) * f.x + (h[2] - h[0]) * f.y + twist * f.x * f.y;
        let clearance = ray.z + at * ray.climb - surface;
        let wall = |axis: usize| {
            let (from, way) = (ray.from[axis], ray.way[axis]);
            let ahead = cell[axis] + if way > 0.0 { 1.0 } else { 0.0 };
            if way == 0.0 { 1.0 } else { (ahead - from) / way }
        };
        let wall = wall(0).min(wall(1)).clamp(f64::min(at + nudge, 1.0), 1.0);
        let in_cone = *above && (!relaxed || ray.climb <= 0.0);
        if in_cone && clearance > 0.0 {
            let ratio = cones.ratio(cell.as_ivec2());
            let closing = reach - ratio * ray.climb;
            let next = if closing * (1.0 - at) > ratio * clearance { at + ratio * clearance / closing } else { 1.0 };
            if next > wall {
                if relaxed && ray.clearance(next) < 0.0 {
                    *above = false;
                    return Some(ray.bisected(at, next, true, settings.refine_steps, visit));
                }
                at = next;
                continue;
            }
        }
        let side = if *above { 1.0 } else { -1.0 };
        let c = [clearance, ray.climb - slope.dot(ray.way), -twist * ray.way.x * ray.way.y].map(|c| side * c);
        let s = if c[0] < 0.0 { 0.0 } else { first_root(c) };
        if at + s > wall {
            at = wall;
            continue;
        }
        at += s;
        *above = !*above;
        if !*above || two_sided {
            return Some(at);
        }
        // Out of the field, from behind: on from here.
        at += nudge;
    }
    None
}

/// The least s ≥ 0 at which c0 + c1 s + c2 s², not negative at 0, becomes so; a large number if none.
fn first_root(c: [f64; 3]) -> f64 {
    let discriminant = c[1] * c[1] - 4.0 * c[0] * c[2];
    if discriminant < 0.0 {
        return 1e30;
    }
    let root = discriminant.sqrt();
    if c[1] < 0.0 {
        2.0 * c[0] / (root - c[1])
    } else if c[2] < 0.0 {
        -(c[1] + root) / (2.0 * c[2])
    } else {
        1e30
    }
}
