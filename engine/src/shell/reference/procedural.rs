//! One stretch of a ray against a procedural height: the path is halved until the procedure's bounds over a piece's box
//! clear it, or nothing is left to tell apart.

use std::ops::ControlFlow;

use glam::DVec2;

use super::{
    bezier::{Quadratic, SignSweep, blossom, restrict},
    prism::{Found, Search, total},
};
use crate::scene::Procedure;

/// A piece whose levels and heights span less of the height range is not halved: the signs at its ends decide. A graze
/// that dips in by less can be missed.
const RESOLUTION: f64 = 4e-12;

/// Nor is a piece shorter than this share of the path.
const SHORTEST: f64 = 1e-14;

/// UV boxes grow by this much: the rounding of a path's UVs.
const UV_ROUNDING: f64 = 1e-15;

/// The first crossing that counts.
pub(super) fn first_hit(search: &Search, procedure: Procedure) -> Option<Found> {
    let &Search { ray, facet, relief, accept, ref path } = search;
    let s = &path.s;
    let along = |axis: usize| -> Quadratic {
        // A procedure's texel coordinates are its UVs less a half.
        std::array::from_fn(|i| (0..3).map(|k| s[k][i] * (relief.texel[k][axis] + 0.5)).sum())
    };
    let field = Field {
        procedure,
        scale: relief.scale,
        midlevel: relief.midlevel,
        path: [along(0), along(1), total(s)],
        t: path.t,
    };
    let mut result = None;
    let mut found = |x: f64, above: bool| {
        let (lambda, t) = path.at(x);
        let distance = ray.distance(facet.point(lambda, t));
        if !accept.takes(distance, !above, facet.double_sided) {
            return ControlFlow::Continue(());
        }
        let slope = procedure.gradient(field.uv(x)) * relief.scale;
        let normal = facet.normal(lambda, t, slope.to_array());
        result = Some(Found { distance, facet: 0, lambda, t, normal, on_wall: false });
        ControlFlow::Break(())
    };
    let _ = field.sweep([0.0, 1.0], &mut SignSweep::default(), &mut found);
    result
}

/// The height field along a path.
struct Field {
    procedure: Procedure,
    scale: f64,
    midlevel: f64,
    /// Numerators of u and v, and their denominator.
    path: [Quadratic; 3],
    /// Level at both ends; linear between.
    t: [f64; 2],
}

impl Field {
    fn uv(&self, x: f64) -> DVec2 {
        let [u, v, w] = self.path.map(|c| blossom(c, x, x));
        DVec2::new(u, v) / w
    }

    fn t(&self, x: f64) -> f64 {
        self.t[0] + (self.t[1] - self.t[0]) * x
    }

    fn surface(&self, h: f64) -> f64 {
        (h - self.midlevel) * self.scale
    }

    fn is_above(&self, x: f64) -> bool {
        self.t(x) > self.surface(self.procedure.height(self.uv(x)))
    }

    /// The box of a piece's UVs; none where the denominator's coefficients differ in sign.
    fn uv_box(&self, [a, b]: [f64; 2]) -> Option<[DVec2; 2]> {
        let [u, v, w] = self.path.map(|c| restrict(c, a, b));
        let same = w.iter().all(|w| *w > 0.0) || w.iter().all(|w| *w < 0.0);
        same.then(|| {
            let points: [DVec2; 3] = std::array::from_fn(|i| DVec2::new(u[i], v[i]) / w[i]);
            let [low, high] = [points[0].min(points[1]).min(points[2]), points[0].max(points[1]).max(points[2])];
            let room = UV_ROUNDING * low.abs().max(high.abs()).max(DVec2::ONE);
            [low - room, high + room]
        })
    }

    /// Follows the sign of t - S over a piece.
    fn sweep(
        &self,
        [a, b]: [f64; 2],
        sweep: &mut SignSweep,
        found: &mut impl FnMut(f64, bool) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let (ta, tb) = (self.t(a), self.t(b));
        if let Some([low, high]) = self.uv_box([a, b]) {
            let [least, greatest] = self.procedure.bounds(low, high).map(|h| self.surface(h));
            if ta.min(tb) > greatest {
                return sweep.constant(true, a, found);
            }
            if ta.max(tb) < least {
                return sweep.constant(false, a, found);
            }
            if greatest - least + (tb - ta).abs() <= RESOLUTION * self.scale {
                return self.ends([a, b], sweep, found);
            }
        }
        if b - a <= SHORTEST {
            return self.ends([a, b], sweep, found);
        }
        let middle = 0.5 * (a + b);
        self.sweep([a, middle], sweep, found)?;
        self.sweep([middle, b], sweep, found)
    }

    /// Takes a piece's sign from its ends.
    fn ends(
        &self,
        [mut a, mut b]: [f64; 2],
        sweep: &mut SignSweep,
        found: &mut impl FnMut(f64, bool) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let (first, last) = (self.is_above(a), self.is_above(b));
        sweep.constant(first, a, found)?;
        if first == last {
            return ControlFlow::Continue(());
        }
        loop {
            let middle = 0.5 * (a + b);
            if middle <= a || middle >= b {
                return sweep.constant(last, b, found);
            }
            if self.is_above(middle) == first {
                a = middle;
            } else {
                b = middle;
            }
        }
    }
}
