//! The fold certificate: how far each shell normal may reach before a prism turns inside out (DESIGN sections 1 and 4).
//!
//! The shell map `X(λ, t) = Σ λ_k (P_k + t r_k N_k)` has the volume element `n(t) · Σ λ_k r_k N_k`, with
//! `n(t) = (S1 - S0) × (S2 - S0)` and `S_k = P_k + t r_k N_k`. It is linear in λ, so it is positive on the whole prism
//! iff the three quadratics `n(t) · N_k` are positive on the range of t at the vertices with `r_k > 0`; their
//! Bernstein coefficients over that range bound them from below.

use glam::DVec3;

use crate::scene::{Mesh, Primitive, Scene};

/// The smallest factor other than 0.
pub const MIN_FACTOR: f64 = 1.0 / 64.0;

/// A Bernstein coefficient counts as positive above this share of `(|S1 - S0| + |S2 - S0|)²`: what lies below is
/// rounding, and two implementations would disagree about its sign.
const POSITIVE: f64 = 1e-12;

/// One displaced triangle as the certificate sees it.
#[derive(Clone, Copy, Debug)]
pub struct ShellTriangle {
    /// Welded vertex ids, counter-clockwise.
    pub weld: [usize; 3],
    /// Corners, mesh units.
    pub positions: [DVec3; 3],
    /// Shell normals: unit, or zero where the weld has none.
    pub normals: [DVec3; 3],
    /// Lowest and highest t, mesh units, map-wide and with 0 included.
    pub t_range: [f64; 2],
}

impl ShellTriangle {
    /// Whether the prism with factors `r` (of its three corners) is certified free of folds. True where all three are
    /// 0: such a triangle is plain.
    pub fn certified(&self, r: [f64; 3]) -> bool {
        let [lo, hi] = self.t_range;
        let lifts: [DVec3; 3] = std::array::from_fn(|k| r[k] * self.normals[k]);
        let edges = |t: f64| {
            let s: [DVec3; 3] = std::array::from_fn(|k| self.positions[k] + t * lifts[k]);
            (s[1] - s[0], s[2] - s[0])
        };
        let ((a1, a2), (b1, b2)) = (edges(lo), edges(hi));
        // The blossom of n(t) at (lo,lo), (lo,hi), (hi,hi): the Bernstein coefficients of every n(t)·N_k at once.
        let n = [a1.cross(a2), 0.5 * (a1.cross(b2) + b1.cross(a2)), b1.cross(b2)];
        let size = (a1.length() + a2.length()).max(b1.length() + b2.length());
        let floor = POSITIVE * size * size;
        (0..3)
            .filter(|&k| lifts[k] != DVec3::ZERO)
            .all(|k| n.iter().all(|coefficient| coefficient.dot(self.normals[k]) > floor))
    }

    /// Whether two corners are the same welded vertex. Such a triangle has no inside on any level, so there is nothing
    /// to fold; the poles of a UV sphere are full of them.
    fn is_collapsed(&self) -> bool {
        let [a, b, c] = self.weld;
        a == b || b == c || c == a
    }
}

/// The fold rule of DESIGN section 1 for one mesh.
///
/// `shell_normals` has one entry per welded vertex. Returns r per welded vertex: 1, 1/2, … 1/64 or 0.
pub fn fold_factors(triangles: &[ShellTriangle], shell_normals: &[DVec3]) -> Vec<f64> {
    let mut r: Vec<f64> = shell_normals.iter().map(|n| if *n == DVec3::ZERO { 0.0 } else { 1.0 }).collect();
    let mut open: Vec<&ShellTriangle> = triangles.iter().filter(|t| !t.is_collapsed()).collect();
    let mut halve = vec![false; r.len()];
    loop {
        halve.fill(false);
        let mut failed = false;
        for triangle in &open {
            if !triangle.certified(triangle.weld.map(|v| r[v])) {
                failed = true;
                for v in triangle.weld {
                    halve[v] = true;
                }
            }
        }
        if !failed {
            return r;
        }
        for (factor, _) in r.iter_mut().zip(&halve).filter(|(_, halve)| **halve) {
            *factor = if *factor * 0.5 < MIN_FACTOR { 0.0 } else { *factor * 0.5 };
        }
        // One that is plain by now passes for ever.
        open.retain(|t| t.weld.iter().any(|&v| r[v] > 0.0));
    }
}

/// What the fold rule did to one mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Folds {
    /// r per welded vertex of the mesh.
    pub factors: Vec<f64>,
    /// (welded vertex, r) of every vertex of a displaced triangle with r < 1: what `prism explain` lists.
    pub reduced: Vec<(u32, f64)>,
    /// (primitive, triangle) of every triangle that asked for displacement but is plain, all its r being 0.
    pub plain: Vec<(usize, usize)>,
}

/// The displaced triangles of `mesh`, and (primitive, triangle) of each.
fn shell_triangles(scene: &Scene, mesh: &Mesh) -> (Vec<ShellTriangle>, Vec<(usize, usize)>) {
    let mut triangles = Vec::new();
    let mut ids = Vec::new();
    for (p, primitive) in mesh.primitives.iter().enumerate() {
        let Some(t_range) = t_range(scene, primitive) else {
            continue;
        };
        for (i, triangle) in primitive.triangles.iter().enumerate() {
            let weld = triangle.map(|v| primitive.weld[v as usize] as usize);
            triangles.push(ShellTriangle {
                weld,
                positions: triangle.map(|v| primitive.positions[v as usize].as_dvec3()),
                normals: weld.map(|v| mesh.shell_normals[v]),
                t_range,
            });
            ids.push((p, i));
        }
    }
    (triangles, ids)
}

/// How far above its highest level every prism of `mesh` with these factors stays free of folds, as a share of the range
/// of its levels: 1, 1/2, 1/4, 1/8, or 0 where it is less.
pub fn headroom(scene: &Scene, mesh: &Mesh, factors: &[f64]) -> f64 {
    headroom_of(&shell_triangles(scene, mesh).0, factors)
}

fn headroom_of(triangles: &[ShellTriangle], factors: &[f64]) -> f64 {
    let clears = |share: &f64| {
        triangles.iter().filter(|triangle| !triangle.is_collapsed()).all(|triangle| {
            let [lo, hi] = triangle.t_range;
            let taller = ShellTriangle { t_range: [lo, hi + share * (hi - lo)], ..*triangle };
            taller.certified(triangle.weld.map(|v| factors[v]))
        })
    };
    [1.0, 0.5, 0.25, 0.125].into_iter().find(clears).unwrap_or(0.0)
}

/// Applies the fold rule to `mesh`, with the displacements of its primitives' materials.
pub fn mesh_folds(scene: &Scene, mesh: &Mesh) -> Folds {
    let (triangles, ids) = shell_triangles(scene, mesh);
    let factors = fold_factors(&triangles, &mesh.shell_normals);
    let mut seen = vec![false; factors.len()];
    for v in triangles.iter().flat_map(|t| t.weld) {
        seen[v] = true;
    }
    let reduced = (0..factors.len()).filter(|&v| seen[v] && factors[v] < 1.0).map(|v| (v as u32, factors[v])).collect();
    let is_plain = |t: &ShellTriangle| t.weld.iter().all(|&v| factors[v] == 0.0);
    let plain = triangles.iter().zip(&ids).filter(|(t, _)| is_plain(t)).map(|(_, id)| *id).collect();
    Folds { factors, reduced, plain }
}

/// Lowest and highest t of a primitive over its whole height map, mesh units, 0 included; `None` for a primitive
/// without displacement.
pub fn t_range(scene: &Scene, primitive: &Primitive) -> Option<[f64; 2]> {
    scene.materials[primitive.material].displacement.filter(|_| primitive.displacement_scale > 0.0)?;
    let (low, high) = scene.displacement_range(primitive);
    Some([low.min(0.0), high.max(0.0)])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sampled volume element: the least n(t)·N_k over 400 levels and the corners with r > 0.
    fn least_sampled(triangle: &ShellTriangle, r: [f64; 3]) -> f64 {
        let [lo, hi] = triangle.t_range;
        let mut least = f64::INFINITY;
        for i in 0..=400 {
            let t = lo + (hi - lo) * f64::from(i) / 400.0;
            let s: [DVec3; 3] = std::array::from_fn(|k| triangle.positions[k] + t * r[k] * triangle.normals[k]);
            let n = (s[1] - s[0]).cross(s[2] - s[0]);
            for k in (0..3).filter(|&k| r[k] > 0.0) {
                least = least.min(n.dot(triangle.normals[k]));
            }
        }
        least
    }

    /// A grid of `nu × nv` quads, closed in both directions, with exact surface normals.
    fn torus(nu: usize, nv: usize, major: f64, minor: f64, t_range: [f64; 2]) -> (Vec<ShellTriangle>, Vec<DVec3>) {
        let (mut positions, mut normals) = (Vec::new(), Vec::new());
        for i in 0..nu {
            for j in 0..nv {
                let (u, v) =
                    (i as f64 / nu as f64 * std::f64::consts::TAU, j as f64 / nv as f64 * std::f64::consts::TAU);
                let n = DVec3::new(v.cos() * u.cos(), v.cos() * u.sin(), v.sin());
                positions.push(DVec3::new(u.cos(), u.sin(), 0.0) * major + n * minor);
                normals.push(n);
            }
        }
        let id = |i: usize, j: usize| (i % nu) * nv + j % nv;
        let mut triangles = Vec::new();
        for i in 0..nu {
            for j in 0..nv {
                let (a, b, c, d) = (id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1));
                for weld in [[a, b, c], [a, c, d]] {
                    triangles.push(ShellTriangle {
                        weld,
                        positions: weld.map(|v| positions[v]),
                        normals: weld.map(|v| normals[v]),
                        t_range,
                    });
                }
            }
        }
        (triangles, normals)
    }

    /// A V-shaped valley along y, opened by `angle` from the horizontal, 1 unit wide on each side.
    fn crease(angle: f64, t_range: [f64; 2]) -> (Vec<ShellTriangle>, Vec<DVec3>) {
        let (c, s) = (angle.cos(), angle.sin());
        let (left, right) = (DVec3::new(s, 0.0, c), DVec3::new(-s, 0.0, c));
        let positions = [
            DVec3::new(-c, 0.0, s),
            DVec3::new(-c, 1.0, s),
            DVec3::ZERO,
            DVec3::Y,
            DVec3::new(c, 0.0, s),
            DVec3::new(c, 1.0, s),
        ];
        let normals = vec![left, left, DVec3::Z, DVec3::Z, right, right];
        let triangles = [[0, 2, 1], [1, 2, 3], [2, 4, 3], [3, 4, 5]].map(|weld: [usize; 3]| ShellTriangle {
            weld,
            positions: weld.map(|v| positions[v]),
            normals: weld.map(|v| normals[v]),
            t_range,
        });
        (triangles.to_vec(), normals)
    }

    #[test]
    fn an_unfolded_torus_keeps_its_normals() {
        let (triangles, normals) = torus(24, 12, 1.0, 0.4, [-0.1, 0.15]);
        assert!(fold_factors(&triangles, &normals).iter().all(|r| *r == 1.0));
    }

    #[test]
    fn a_torus_displaced_past_its_core_shrinks() {
        // Inward by more than the minor radius: every prism would meet its own core.
        let (triangles, normals) = torus(24, 12, 1.0, 0.4, [-0.5, 0.0]);
        let r = fold_factors(&triangles, &normals);
        assert!(r.iter().all(|r| *r == 0.5), "{r:?}");
    }

    #[test]
    fn a_deep_valley_shrinks_until_it_is_certified() {
        let (triangles, normals) = crease(1.2, [0.0, 4.0]);
        assert!(triangles.iter().any(|t| !t.certified([1.0; 3])));
        let r = fold_factors(&triangles, &normals);
        assert!(r.iter().all(|r| *r > 0.0 && *r < 1.0), "{r:?}");
        for t in &triangles {
            let of = t.weld.map(|v| r[v]);
            assert!(t.certified(of) && least_sampled(t, of) > 0.0);
        }
    }

    #[test]
    fn a_valley_has_less_headroom_the_steeper_it_is() {
        let share = |angle: f64| {
            let (triangles, normals) = crease(angle, [0.0, 1.0]);
            headroom_of(&triangles, &vec![1.0; normals.len()])
        };
        // Its sides are as wide as its levels reach up.
        assert_eq!([0.2, 0.52, 0.62, 0.7, 0.76].map(share), [1.0, 0.5, 0.25, 0.125, 0.0]);
    }

    #[test]
    fn a_normal_behind_its_triangle_goes_to_zero_at_once_with_its_neighbours() {
        let (mut triangles, mut normals) = crease(0.0, [0.0, 0.1]);
        normals[0] = -DVec3::Z;
        triangles.iter_mut().for_each(|t| t.normals = t.weld.map(|v| normals[v]));
        let r = fold_factors(&triangles, &normals);
        // Triangle 0 is (0, 2, 1) and fails for ever; the others never do by themselves.
        assert_eq!(r, [0.0, 0.0, 0.0, 1.0, 1.0, 1.0]);
    }

    #[test]
    fn a_zero_normal_has_no_say() {
        let (mut triangles, mut normals) = crease(0.0, [0.0, 0.1]);
        normals[2] = DVec3::ZERO;
        triangles.iter_mut().for_each(|t| t.normals = t.weld.map(|v| normals[v]));
        assert_eq!(fold_factors(&triangles, &normals), [1.0, 1.0, 0.0, 1.0, 1.0, 1.0]);
    }

    #[test]
    fn collapsed_triangles_do_not_pull_their_neighbours_down() {
        let (mut triangles, normals) = crease(0.0, [0.0, 0.1]);
        triangles[0].weld = [2, 2, 1];
        triangles[0].positions[0] = triangles[0].positions[1];
        assert!(fold_factors(&triangles, &normals).iter().all(|r| *r == 1.0));
    }

    #[test]
    fn certified_prisms_have_a_positive_volume_element_and_the_others_nearly_none() {
        let mut seed = 1u64;
        let mut next = || {
            seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (seed >> 11) as f64 / (1u64 << 53) as f64 - 0.5
        };
        let (mut certified, mut needless) = (0, 0);
        for _ in 0..20_000 {
            let mut v = || DVec3::new(next(), next(), next());
            let positions = [v(), v(), v()];
            let up = (positions[1] - positions[0]).cross(positions[2] - positions[0]).normalize();
            let normals = [v(), v(), v()].map(|w| (up + 1.5 * w).normalize());
            let triangle = ShellTriangle { weld: [0, 1, 2], positions, normals, t_range: [-0.2, 0.3] };
            let least = least_sampled(&triangle, [1.0; 3]);
            if triangle.certified([1.0; 3]) {
                certified += 1;
                assert!(least > 0.0, "{triangle:?}: {least}");
            } else if least > 0.0 {
                needless += 1;
            }
        }
        // Bernstein coefficients are sufficient, not necessary: a few good prisms are refused.
        assert!(certified > 1000 && needless * 10 < certified, "{certified} certified, {needless} refused needlessly");
    }
}
