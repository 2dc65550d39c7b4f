//! Polynomials in Bernstein form on [0, 1]: their sign changes, found rigorously by subdivision.
//!
//! A polynomial whose Bernstein coefficients share a sign has no root; one with a single sign variation has exactly
//! one (Descartes' rule in Bernstein form: Lane and Riesenfeld 1981).

use std::ops::ControlFlow;

/// Bernstein coefficients of a quadratic.
pub(super) type Quadratic = [f64; 3];

/// Bernstein coefficients of a quintic.
pub(super) type Quintic = [f64; 6];

/// Halvings before two or more roots count as one point: 2^-48 of the interval.
const MAX_DEPTH: u32 = 48;

/// The blossom (polar form) of a quadratic: `blossom(c, x, x)` is its value at x.
pub(super) fn blossom(c: Quadratic, a: f64, b: f64) -> f64 {
    c[0] * (1.0 - a) * (1.0 - b) + c[1] * (a * (1.0 - b) + b * (1.0 - a)) + c[2] * a * b
}

/// The same quadratic over `[a, b]`, as coefficients on [0, 1] again.
pub(super) fn restrict(c: Quadratic, a: f64, b: f64) -> Quadratic {
    [blossom(c, a, a), blossom(c, a, b), blossom(c, b, b)]
}

/// The roots of a quadratic in the open interval (0, 1), in no order. Its square or linear term may vanish.
pub(super) fn quadratic_roots(c: Quadratic) -> impl Iterator<Item = f64> {
    let (a, half_b) = (c[0] - 2.0 * c[1] + c[2], c[1] - c[0]);
    // half_b² - a c0, free of the cancellation that the power basis would bring.
    let root = (c[1] * c[1] - c[0] * c[2]).sqrt();
    let q = -(half_b + root.copysign(half_b));
    // A negative discriminant makes both NaN, which no comparison lets through.
    [q / a, c[0] / q].into_iter().filter(|x| *x > 0.0 && *x < 1.0)
}

/// Product of two quadratics, degree 4.
pub(super) fn product(f: Quadratic, g: Quadratic) -> [f64; 5] {
    [
        f[0] * g[0],
        0.5 * (f[0] * g[1] + f[1] * g[0]),
        (f[0] * g[2] + 4.0 * f[1] * g[1] + f[2] * g[0]) / 6.0,
        0.5 * (f[1] * g[2] + f[2] * g[1]),
        f[2] * g[2],
    ]
}

/// Follows the sign of a piecewise polynomial along a path and reports where it changes. The sign is carried from
/// piece to piece, so a root that falls exactly between two pieces is reported once: rounding cannot lose it.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct SignSweep {
    positive: Option<bool>,
}

impl SignSweep {
    /// The next piece has one known sign throughout; reports a change at its start.
    pub(super) fn constant(
        &mut self,
        positive: bool,
        start: f64,
        found: &mut impl FnMut(f64, bool) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        if self.positive.replace(positive).is_some_and(|before| before != positive) {
            found(start, positive)?;
        }
        ControlFlow::Continue(())
    }

    /// The next piece is `c` on `[lo, hi]`. `found(x, now_positive)` is called at each sign change in order; it may
    /// break to end the search.
    pub(super) fn quintic(
        &mut self,
        c: Quintic,
        [lo, hi]: [f64; 2],
        found: &mut impl FnMut(f64, bool) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        self.piece(c, lo, hi, MAX_DEPTH, found)
    }

    fn piece(
        &mut self,
        c: Quintic,
        lo: f64,
        hi: f64,
        depth: u32,
        found: &mut impl FnMut(f64, bool) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        let mut signs = c.iter().filter(|v| **v != 0.0).map(|v| *v > 0.0);
        // Zero throughout: the path lies in the surface, and the sign stays what it was.
        let Some(first) = signs.next() else { return ControlFlow::Continue(()) };
        let (mut last, mut variations) = (first, 0);
        for sign in signs {
            variations += u32::from(sign != last);
            last = sign;
        }
        if variations >= 2 && depth > 0 {
            let (left, right) = halves(c);
            let middle = 0.5 * (lo + hi);
            self.piece(left, lo, middle, depth - 1, found)?;
            return self.piece(right, middle, hi, depth - 1, found);
        }
        self.constant(first, lo, found)?;
        if variations % 2 == 1 {
            self.positive = Some(last);
            found(lo + (hi - lo) * only_root(c, last), last)?;
        }
        ControlFlow::Continue(())
    }
}

/// The one root of `c` in [0, 1], to the last bit, by bisection; `c` is `positive` after it.
fn only_root(c: Quintic, positive: bool) -> f64 {
    let (mut lo, mut hi) = (0.0, 1.0);
    loop {
        let middle = 0.5 * (lo + hi);
        // Absolute: the root's place in its piece, which is itself a small part of the path.
        if hi - lo < 1e-16 || middle <= lo || middle >= hi {
            return middle;
        }
        if (value(c, middle) > 0.0) == positive {
            hi = middle;
        } else {
            lo = middle;
        }
    }
}

fn value(mut c: Quintic, x: f64) -> f64 {
    for n in (1..6).rev() {
        for i in 0..n {
            c[i] += (c[i + 1] - c[i]) * x;
        }
    }
    c[0]
}

fn halves(mut c: Quintic) -> (Quintic, Quintic) {
    let mut left = [c[0]; 6];
    // De Casteljau in place: the left half's coefficients pass through c[0], the right half's stay behind.
    for (n, coefficient) in (1..6).rev().zip(1..) {
        for i in 0..n {
            c[i] = 0.5 * (c[i] + c[i + 1]);
        }
        left[coefficient] = c[0];
    }
    (left, c)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bernstein coefficients of Π (x - root), five roots.
    fn from_roots(roots: [f64; 5]) -> Quintic {
        let mut power = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        for (n, root) in roots.into_iter().enumerate() {
            for i in (0..=n + 1).rev() {
                power[i] = if i > 0 { power[i - 1] } else { 0.0 } - root * power[i];
            }
        }
        let choose = |n: u32, k: u32| (0..k).fold(1.0, |c, i| c * f64::from(n - i) / f64::from(i + 1));
        std::array::from_fn(|j| (0..=j).map(|i| power[i] * choose(j as u32, i as u32) / choose(5, i as u32)).sum())
    }

    fn changes(pieces: &[(Quintic, [f64; 2])]) -> Vec<(f64, bool)> {
        let (mut sweep, mut out) = (SignSweep::default(), Vec::new());
        for (c, range) in pieces {
            let mut found = |x, positive| {
                out.push((x, positive));
                ControlFlow::Continue(())
            };
            assert!(sweep.quintic(*c, *range, &mut found).is_continue());
        }
        out
    }

    #[test]
    fn five_roots_come_in_order() {
        let roots = [0.05, 0.2, 0.200_001, 0.7, 0.9];
        let found = changes(&[(from_roots(roots), [0.0, 1.0])]);
        assert_eq!(found.len(), 5);
        for ((x, positive), (i, root)) in found.iter().zip(roots.iter().enumerate()) {
            assert!((x - root).abs() < 1e-8, "{x} {root}");
            assert_eq!(*positive, i % 2 == 0);
        }
    }

    #[test]
    fn a_double_root_changes_nothing() {
        let found = changes(&[(from_roots([0.5, 0.5, 2.0, 3.0, -1.0]), [0.0, 1.0])]);
        assert!(found.is_empty() || (found.len() == 2 && (found[0].0 - found[1].0).abs() < 1e-6), "{found:?}");
    }

    #[test]
    fn a_root_between_two_pieces_is_found_once() {
        // x - 1 on [0, 1], then on [1, 2], the second one a rounding off.
        let left = [-1.0, -0.8, -0.6, -0.4, -0.2, -1e-18];
        let right = [1e-18, 0.2, 0.4, 0.6, 0.8, 1.0];
        assert_eq!(changes(&[(left, [0.0, 1.0]), (right, [1.0, 2.0])]), [(1.0, true)]);
        let touching = [0.0, 0.2, 0.4, 0.6, 0.8, 1.0];
        assert_eq!(changes(&[(left, [0.0, 1.0]), (touching, [1.0, 2.0])]), [(1.0, true)]);
        assert_eq!(changes(&[([0.0; 6], [0.0, 1.0]), (touching, [1.0, 2.0])]), []);
    }

    #[test]
    fn a_root_at_the_middle_of_a_piece_survives_its_halving() {
        let found = changes(&[(from_roots([0.5, 0.25, 0.75, 3.0, -1.0]), [0.0, 1.0])]);
        assert_eq!(found.len(), 3, "{found:?}");
    }

    #[test]
    fn quadratics_of_every_degree() {
        let roots = |c| {
            let mut r: Vec<f64> = quadratic_roots(c).collect();
            r.sort_by(f64::total_cmp);
            r
        };
        // (x - 1/4)(x - 1/2) = 1/8 - 3/4 x + x².
        let found = roots([0.125, 0.125 - 0.375, 0.375]);
        assert!((found[0] - 0.25).abs() < 1e-15 && (found[1] - 0.5).abs() < 1e-15);
        assert_eq!(roots([-1.0, 0.0, 1.0]), [0.5]);
        assert_eq!(roots([1.0, -1.0, 1.0]).len(), 2, "a double root may be seen twice");
        assert!(roots([1.0, 0.0, 1.0]).is_empty() && roots([0.0; 3]).is_empty());
        let nearly_linear = roots([-1.0, 1e-17, 1.0]);
        assert_eq!(nearly_linear.len(), 1);
        assert!((nearly_linear[0] - 0.5).abs() < 1e-15);
    }
}
