//! The reference's own welding, shell normals and fold rule (DESIGN section 1), from raw positions and normals.

use std::collections::HashMap;

use glam::DVec3;

use crate::scene::Mesh;

/// Below this share of its summed weights a shell normal counts as zero: f32 normals cancel no better.
const ZERO_NORMAL: f64 = 1e-6;

/// What a Bernstein coefficient of n(t)·N must exceed, per squared sum of the level's edge lengths: rounding.
const POSITIVE: f64 = 1e-12;

/// Welded vertices of one mesh.
pub(super) struct Weld {
    /// Primitive, vertex → welded vertex.
    pub(super) ids: Vec<Vec<usize>>,
    /// Shell normal of each welded vertex: unit or zero.
    pub(super) normals: Vec<DVec3>,
}

impl Weld {
    /// Vertices at bit-equal positions become one, whose normal is the mean of its corners' vertex normals, weighted by
    /// the corners' angles.
    pub(super) fn new(mesh: &Mesh) -> Self {
        let mut known = HashMap::new();
        let mut id_at = |p: glam::Vec3| {
            let next = known.len();
            // -0 and 0 are one position.
            *known.entry(p.to_array().map(|x| (x + 0.0).to_bits())).or_insert(next)
        };
        let ids: Vec<Vec<usize>> =
            mesh.primitives.iter().map(|p| p.positions.iter().map(|x| id_at(*x)).collect()).collect();
        let mut sums = vec![(DVec3::ZERO, 0.0); known.len()];
        for (primitive, ids) in mesh.primitives.iter().zip(&ids) {
            for triangle in &primitive.triangles {
                let corner = |k: usize| triangle[k % 3] as usize;
                for k in 0..3 {
                    let at = |k: usize| primitive.positions[corner(k)].as_dvec3();
                    let (a, b) = (at(k + 1) - at(k), at(k + 2) - at(k));
                    let angle = a.cross(b).length().atan2(a.dot(b));
                    let sum = &mut sums[ids[corner(k)]];
                    sum.0 += angle * primitive.normals[corner(k)].as_dvec3();
                    sum.1 += angle;
                }
            }
        }
        let unit = |(sum, weight): (DVec3, f64)| {
            if sum.length() > ZERO_NORMAL * weight { sum.normalize() } else { DVec3::ZERO }
        };
        Weld { ids, normals: sums.into_iter().map(unit).collect() }
    }
}

/// A displaced triangle before folding: welded vertices, positions, and its range of t with 0 included.
pub(super) struct Candidate {
    pub(super) weld: [usize; 3],
    pub(super) positions: [DVec3; 3],
    pub(super) t_range: [f64; 2],
}

/// r per welded vertex.
pub(super) fn factors(candidates: &[Candidate], normals: &[DVec3]) -> Vec<f64> {
    let mut r: Vec<f64> = normals.iter().map(|n| n.length().round()).collect();
    loop {
        let failing: Vec<&Candidate> = candidates.iter().filter(|c| folds(c, &r, normals)).collect();
        if failing.is_empty() {
            return r;
        }
        let mut hit: Vec<usize> = failing.iter().flat_map(|c| c.weld).collect();
        hit.sort_unstable();
        hit.dedup();
        for v in hit {
            r[v] = if r[v] > 1.0 / 64.0 { r[v] / 2.0 } else { 0.0 };
        }
    }
}

/// The greatest of 1, 1/2, 1/4, 1/8 and 0 by whose share of its range every prism may grow upward without a fold.
pub(super) fn headroom(candidates: &[Candidate], r: &[f64], normals: &[DVec3]) -> f64 {
    let folds_within = |share: f64| {
        candidates.iter().any(|c| {
            let [lo, hi] = c.t_range;
            let taller = Candidate { t_range: [lo, hi + share * (hi - lo)], weld: c.weld, positions: c.positions };
            folds(&taller, r, normals)
        })
    };
    (0..4).map(|halvings| 0.5f64.powi(halvings)).find(|share| !folds_within(*share)).unwrap_or(0.0)
}

fn folds(candidate: &Candidate, r: &[f64], normals: &[DVec3]) -> bool {
    let lift = candidate.weld.map(|v| r[v] * normals[v]);
    let p = candidate.positions;
    // Edges as base + slope t, then n(t) = n0 + n1 t + n2 t².
    let (a, b) = (p[1] - p[0], lift[1] - lift[0]);
    let (c, d) = (p[2] - p[0], lift[2] - lift[0]);
    let (n0, n1, n2) = (a.cross(c), a.cross(d) + b.cross(c), b.cross(d));
    let [lo, hi] = candidate.t_range;
    let span = |t: f64| (a + t * b).length() + (c + t * d).length();
    let floor = POSITIVE * span(lo).max(span(hi)).powi(2);
    candidate.weld.iter().any(|&v| {
        let n = normals[v];
        let value = |t: f64| n0.dot(n) + t * (n1.dot(n) + t * n2.dot(n));
        let slope = n1.dot(n) + 2.0 * lo * n2.dot(n);
        let middle = value(lo) + 0.5 * (hi - lo) * slope;
        r[v] > 0.0 && !(value(lo) > floor && middle > floor && value(hi) > floor)
    })
}
