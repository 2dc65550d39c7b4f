//! One ray against one facet: the exact intervals inside a prism, the curved path in texture space, and its crossings
//! of the bilinear patches (DESIGN section 4), all in f64.

use std::ops::ControlFlow;

use glam::{DVec2, DVec3};

use super::{
    bezier::{Quadratic, SignSweep, blossom, product, quadratic_roots, restrict},
    height::{HeightField, Texels},
    procedural,
    surface::{Facet, Relief},
};

/// Facets reach this far (in λ) past their edges. Neighbours so overlap by more than f64 rounding and a ray along a
/// shared edge cannot slip between them.
pub(super) const OVERLAP: f64 = 1e-9;

/// Below this share of the prism's size an interval of t is too short to hold the path: the ray lies in a level, and
/// the straight chord is exact to the same share.
const CHORD: f64 = 1e-8;

/// A ray in mesh space with the two axes it is projected along.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ray {
    pub(super) origin: DVec3,
    /// Any length; distances are in units of it.
    pub(super) direction: DVec3,
    /// Unit, with `e0 × e1` along the direction.
    e0: DVec3,
    e1: DVec3,
    inverse_square: f64,
}

/// Which hits count.
#[derive(Clone, Copy, Debug)]
pub(super) struct Accept {
    /// Distances, in units of the ray's direction, ends excluded.
    pub(super) range: [f64; 2],
    /// Hits from behind count whatever the material says.
    pub(super) both_sides: bool,
}

/// A crossing of the surface, in mesh space.
#[derive(Clone, Copy, Debug)]
pub(super) struct Found {
    pub(super) distance: f64,
    pub(super) facet: usize,
    pub(super) lambda: [f64; 3],
    pub(super) t: f64,
    /// On the surface's front, not unit.
    pub(super) normal: DVec3,
    pub(super) on_wall: bool,
}

impl Ray {
    pub(super) fn new(origin: DVec3, direction: DVec3) -> Self {
        let unit = direction.normalize();
        let e0 = unit.any_orthonormal_vector();
        Ray { origin, direction, e0, e1: unit.cross(e0), inverse_square: direction.length_squared().recip() }
    }

    /// A point, projected along the ray.
    pub(super) fn project(&self, point: DVec3) -> DVec2 {
        self.project_vector(point - self.origin)
    }

    /// A direction, projected along the ray.
    pub(super) fn project_vector(&self, v: DVec3) -> DVec2 {
        DVec2::new(self.e0.dot(v), self.e1.dot(v))
    }

    /// How far along the ray a point is.
    pub(super) fn distance(&self, point: DVec3) -> f64 {
        (point - self.origin).dot(self.direction) * self.inverse_square
    }
}

impl Accept {
    /// Whether a hit counts.
    pub(super) fn takes(&self, distance: f64, front: bool, double_sided: bool) -> bool {
        distance > self.range[0] && distance < self.range[1] && (front || double_sided || self.both_sides)
    }
}

/// The first hit of a ray with a facet.
pub(super) fn hit(
    ray: &Ray,
    facets: &[Facet],
    index: usize,
    fields: &[HeightField],
    mut accept: Accept,
) -> Option<Found> {
    let facet = &facets[index];
    let Some(relief) = &facet.relief else { return plain(ray, facet, index, accept) };
    let mut best = None;
    for path in paths(ray, facet, relief) {
        let search = Search { ray, facet, relief, accept, path };
        let found = match &fields[relief.field] {
            HeightField::Map(map) => search.first_hit(map),
            HeightField::Procedure(procedure) => procedural::first_hit(&search, *procedure),
        };
        if let Some(found) = found {
            accept.range[1] = found.distance;
            best = Some(Found { facet: index, ..found });
        }
    }
    best
}

fn plain(ray: &Ray, facet: &Facet, index: usize, accept: Accept) -> Option<Found> {
    let p = facet.positions.map(|p| ray.project(p));
    let s = [p[1].perp_dot(p[2]), p[2].perp_dot(p[0]), p[0].perp_dot(p[1])];
    let sum: f64 = s.iter().sum();
    let lambda = s.map(|s| s / sum);
    // A sum of zero gives infinities or NaN, and no comparison below holds for all three.
    if !lambda.iter().all(|l| *l >= -OVERLAP && *l <= 1.0 + 2.0 * OVERLAP) {
        return None;
    }
    let point = facet.point(lambda, 0.0);
    let distance = ray.distance(point);
    let normal = facet.normal(lambda, 0.0, [0.0; 2]);
    accept.takes(distance, sum < 0.0, facet.double_sided).then_some(Found {
        distance,
        facet: index,
        lambda,
        t: 0.0,
        normal,
        on_wall: false,
    })
}

/// A stretch of a ray inside a prism, from its near to its far end, over [0, 1].
#[derive(Clone, Copy, Debug)]
pub(super) struct Path {
    /// s_k, whose shares of their sum are the λ_k.
    pub(super) s: [Quadratic; 3],
    /// t at both ends; linear between.
    pub(super) t: [f64; 2],
}

/// All stretches of a ray inside a prism.
pub(super) fn paths(ray: &Ray, facet: &Facet, relief: &Relief) -> Vec<Path> {
    let p = facet.positions.map(|p| ray.project(p));
    let q = facet.lifts.map(|n| ray.project_vector(n));
    let level = |t: f64| -> [DVec2; 3] { std::array::from_fn(|k| p[k] + t * q[k]) };
    let side_walls = |a: f64, b: f64| -> [Quadratic; 3] {
        let (x, y) = (level(a), level(b));
        std::array::from_fn(|k| {
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            [x[i].perp_dot(x[j]), 0.5 * (x[i].perp_dot(y[j]) + y[i].perp_dot(x[j])), y[i].perp_dot(y[j])]
        })
    };
    let [lo, hi] = relief.t_range;
    let exact = side_walls(lo, hi);
    let sum = total(&exact);
    let wide = exact.map(|s| -> Quadratic { std::array::from_fn(|i| s[i] + OVERLAP * sum[i]) });
    // Most prisms whose box the ray meets are missed, on the same side of two walls throughout.
    let all = |positive: bool| wide.iter().any(|s| s.iter().all(|v| (*v > 0.0) == positive && *v != 0.0));
    if all(true) && all(false) {
        return Vec::new();
    }
    let mut cuts: Vec<f64> = wide.iter().flat_map(|s| quadratic_roots(*s)).chain([0.0, 1.0]).collect();
    cuts.sort_unstable_by(f64::total_cmp);
    let mut inside: Vec<[f64; 2]> = Vec::new();
    for (a, b) in cuts.iter().zip(&cuts[1..]) {
        let middle = 0.5 * (a + b);
        let values = wide.map(|s| blossom(s, middle, middle));
        let same = values.iter().all(|v| *v > 0.0) || values.iter().all(|v| *v < 0.0);
        match inside.last_mut() {
            Some(last) if same && last[1] == *a => last[1] = *b,
            _ if same => inside.push([*a, *b]),
            _ => {}
        }
    }
    let size = level(lo).iter().chain(&level(hi)).map(|p| p.length()).fold(0.0, f64::max);
    let mut paths = chords(ray, facet, [lo, hi], &wide, size);
    for [a, b] in inside {
        let [a, b] = [lo + (hi - lo) * a, lo + (hi - lo) * b];
        if b - a > CHORD * size {
            let s = side_walls(a, b);
            // t climbs away from the eye iff the levels are seen from below.
            let climbs = blossom(total(&s), 0.5, 0.5) > 0.0;
            paths.push(if climbs {
                Path { s, t: [a, b] }
            } else {
                Path { s: s.map(|[x, y, z]| [-z, -y, -x]), t: [b, a] }
            });
        }
    }
    paths
}

/// The stretches between two wall crossings on (nearly) one level: there t says nothing about the place, but the
/// point where the level's edge passes the ray does.
fn chords(ray: &Ray, facet: &Facet, [lo, hi]: [f64; 2], wide: &[Quadratic; 3], size: f64) -> Vec<Path> {
    let mut crossings: Vec<(f64, [f64; 3], f64)> = Vec::new();
    for (k, s) in wide.iter().enumerate() {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        for root in quadratic_roots(*s) {
            let t = lo + (hi - lo) * root;
            let [a, b] = [i, j].map(|v| ray.project(facet.positions[v] + t * facet.lifts[v]));
            let edge = b - a;
            let along = -a.dot(edge) / edge.length_squared();
            if edge.length() > 1e-12 * size && (-OVERLAP..=1.0 + OVERLAP).contains(&along) {
                let mut lambda = [0.0; 3];
                (lambda[i], lambda[j]) = (1.0 - along, along);
                crossings.push((ray.distance(facet.point(lambda, t)), lambda, t));
            }
        }
    }
    crossings.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    let pairs = crossings.iter().zip(crossings.iter().skip(1));
    pairs
        .filter(|(a, b)| (a.2 - b.2).abs() <= CHORD * size)
        .map(|(a, b)| Path { s: std::array::from_fn(|k| [a.1[k], 0.5 * (a.1[k] + b.1[k]), b.1[k]]), t: [a.2, b.2] })
        .collect()
}

pub(super) fn total(s: &[Quadratic; 3]) -> Quadratic {
    std::array::from_fn(|i| s[0][i] + s[1][i] + s[2][i])
}

impl Path {
    /// λ, t at a parameter.
    pub(super) fn at(&self, x: f64) -> ([f64; 3], f64) {
        let s = self.s.map(|s| blossom(s, x, x));
        let sum: f64 = s.iter().sum();
        (s.map(|s| s / sum), self.t[0] + (self.t[1] - self.t[0]) * x)
    }
}

/// One stretch of a ray and the height field it may cross.
pub(super) struct Search<'a> {
    pub(super) ray: &'a Ray,
    pub(super) facet: &'a Facet,
    pub(super) relief: &'a Relief,
    pub(super) accept: Accept,
    pub(super) path: Path,
}

impl Search<'_> {
    /// The first crossing that counts.
    fn first_hit(&self, map: &Texels) -> Option<Found> {
        let s = &self.path.s;
        let along =
            |values: [f64; 3]| -> Quadratic { std::array::from_fn(|i| (0..3).map(|k| s[k][i] * values[k]).sum()) };
        let [columns, rows] = [0, 1].map(|axis| self.relief.texel.map(|x| x[axis]));
        let (u, v, w) = (along(columns), along(rows), total(s));
        let mut cuts = vec![0.0, 1.0];
        cell_borders(u, w, columns, &mut cuts);
        cell_borders(v, w, rows, &mut cuts);
        cuts.sort_unstable_by(f64::total_cmp);
        let mut sweep = SignSweep::default();
        let mut pieces = cuts.iter().zip(&cuts[1..]).filter(|(a, b)| a < b);
        pieces.find_map(|(a, b)| self.cell_hit(map, [u, v, w], [*a, *b], &mut sweep))
    }

    /// The first crossing that counts within `[a, b]`, where the path `u / w`, `v / w` stays in one cell.
    fn cell_hit(
        &self,
        map: &Texels,
        [u, v, w]: [Quadratic; 3],
        [a, b]: [f64; 2],
        sweep: &mut SignSweep,
    ) -> Option<Found> {
        let &Search { ray, facet, relief, accept, ref path } = self;
        let value = |c: Quadratic| blossom(c, 0.5 * (a + b), 0.5 * (a + b));
        let (i, j) = ((value(u) / value(w)).floor(), (value(v) / value(w)).floor());
        let cell = map.cell(i as i64 + relief.base[0], j as i64 + relief.base[1], relief.wrap);
        let surface = |h: f64| (h - relief.midlevel) * relief.scale;
        let mut result = None;
        let mut found = |x: f64, above: bool| {
            let (lambda, t) = path.at(x);
            let distance = ray.distance(facet.point(lambda, t));
            if !accept.takes(distance, !above, facet.double_sided) {
                return ControlFlow::Continue(());
            }
            let at: DVec2 = (0..3).map(|k| lambda[k] * relief.texel[k]).sum();
            let slope = cell.at(at.x - i, at.y - j).1.map(|d| d * relief.scale);
            let normal = facet.normal(lambda, t, slope);
            result = Some(Found { distance, facet: 0, lambda, t, normal, on_wall: false });
            ControlFlow::Break(())
        };
        let [t0, t1] = [a, b].map(|x| path.at(x).1);
        let _ = if t0.min(t1) > surface(cell.extent[1]) {
            sweep.constant(true, a, &mut found)
        } else if t0.max(t1) < surface(cell.extent[0]) {
            sweep.constant(false, a, &mut found)
        } else {
            let [u, v, w] = [u, v, w].map(|c| restrict(c, a, b));
            let local = |c: Quadratic, k: f64| -> Quadratic { std::array::from_fn(|n| c[n] - k * w[n]) };
            let (x, y) = (local(u, i), local(v, j));
            let [ww, xw, yw, xy] = [product(w, w), product(x, w), product(y, w), product(x, y)];
            let [c00, c10, c01, c11] = cell.c;
            let height = |n: usize| surface(c00) * ww[n] + relief.scale * (c10 * xw[n] + c01 * yw[n] + c11 * xy[n]);
            // W²(t - S), of degree 5: the product with the linear t, and S raised by one degree.
            let quintic = std::array::from_fn(|n| {
                let share = n as f64 / 5.0;
                let left = if n > 0 { share * (ww[n - 1] * t1 - height(n - 1)) } else { 0.0 };
                let right = if n < 5 { (1.0 - share) * (ww[n] * t0 - height(n)) } else { 0.0 };
                left + right
            });
            sweep.quintic(quintic, [a, b], &mut found)
        };
        result
    }
}

/// Adds every parameter at which `u / w` is a whole number; `corners` bound the quotient.
pub(super) fn cell_borders(u: Quadratic, w: Quadratic, corners: [f64; 3], cuts: &mut Vec<f64>) {
    let bounds = |values: [f64; 3]| {
        values.into_iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], v| [a.min(v), b.max(v)])
    };
    let [mut lo, mut hi] = bounds(corners);
    let pad = 2.0 * OVERLAP * (hi - lo);
    if w.iter().all(|w| *w > 0.0) || w.iter().all(|w| *w < 0.0) {
        let [from, to] = bounds(std::array::from_fn(|i| u[i] / w[i]));
        (lo, hi) = (lo.max(from), hi.min(to));
    }
    for k in (lo - pad).ceil() as i64..=(hi + pad).floor() as i64 {
        cuts.extend(quadratic_roots(std::array::from_fn(|i| u[i] - k as f64 * w[i])));
    }
}
