//! What follows from the points: the Pareto front, slopes, and where two curves cross.

/// The places of those that nothing beats in both coordinates, by the first one. A point is (time, error); equal ones
/// do not beat each other.
pub fn pareto(points: &[[f64; 2]]) -> Vec<usize> {
    let finite = |i: &usize| points[*i].iter().all(|v| v.is_finite());
    let beats = |a: [f64; 2], b: [f64; 2]| a[0] <= b[0] && a[1] <= b[1] && a != b;
    let all: Vec<usize> = (0..points.len()).filter(finite).collect();
    let free = |i: &usize| !all.iter().any(|&j| beats(points[j], points[*i]));
    let mut front: Vec<usize> = all.iter().copied().filter(free).collect();
    front.sort_by(|a, b| points[*a][0].total_cmp(&points[*b][0]));
    front
}

/// The exponent k of y ∝ x^k, by least squares over the logarithms; none of fewer than two places.
pub fn slope(points: &[[f64; 2]]) -> Option<f64> {
    let logs: Vec<[f64; 2]> =
        points.iter().filter(|p| p.iter().all(|v| v.is_finite() && *v > 0.0)).map(|p| p.map(f64::ln)).collect();
    let mean = |k: usize| logs.iter().map(|p| p[k]).sum::<f64>() / logs.len() as f64;
    let [x, y] = [mean(0), mean(1)];
    let spread: f64 = logs.iter().map(|p| (p[0] - x).powi(2)).sum();
    let together: f64 = logs.iter().map(|p| (p[0] - x) * (p[1] - y)).sum();
    (spread > 1e-12).then(|| together / spread)
}

/// Every x at which `a` ceases to be below `b`, or begins to, both straight between their places on logarithmic axes;
/// they have the same x, rising.
pub fn crossings(a: &[[f64; 2]], b: &[[f64; 2]]) -> Vec<f64> {
    let ratio: Vec<[f64; 2]> = a
        .iter()
        .filter_map(|p| Some([p[0].ln(), (p[1] / b.iter().find(|q| q[0] == p[0])?[1]).ln()]))
        .filter(|p| p.iter().all(|v| v.is_finite()))
        .collect();
    let crosses = ratio.windows(2).filter(|w| (w[0][1] < 0.0) != (w[1][1] < 0.0));
    crosses.map(|w| (w[0][0] + (w[1][0] - w[0][0]) * w[0][1] / (w[0][1] - w[1][1])).exp()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_front_is_what_nothing_beats() {
        let points = [[1.0, 9.0], [2.0, 5.0], [3.0, 5.0], [4.0, 1.0], [4.0, 8.0], [f64::NAN, 0.0], [2.0, 5.0]];
        assert_eq!(pareto(&points), [0, 1, 6, 3]);
        assert!(pareto(&[]).is_empty());
    }

    #[test]
    fn a_power_law_is_found() {
        let points: Vec<[f64; 2]> = [1.0, 4.0, 9.0, 100.0].iter().map(|&x: &f64| [x, 3.0 * x.powf(0.75)]).collect();
        assert!((slope(&points).unwrap() - 0.75).abs() < 1e-9);
        // Zero has no logarithm.
        assert!((slope(&[&[[0.0, 5.0]], &points[..]].concat()).unwrap() - 0.75).abs() < 1e-9);
        assert_eq!(slope(&points[..1]), None);
    }

    #[test]
    fn two_power_laws_cross_where_they_do() {
        let at = |f: fn(f64) -> f64| [1.0, 10.0, 100.0, 1000.0].map(|x| [x, f(x)]);
        let (linear, flat) = (at(|x| x), at(|_| 50.0));
        for crossed in [crossings(&linear, &flat), crossings(&flat, &linear)] {
            assert!(crossed.len() == 1 && (crossed[0] - 50.0).abs() < 1e-9, "{crossed:?}");
        }
        assert!(crossings(&flat, &at(|_| 51.0)).is_empty());
    }

    #[test]
    fn curves_that_meet_again_cross_at_each_place() {
        let hill = [[1.0, 1.0], [100.0, 100.0], [10_000.0, 1.0], [1e6, 0.1]];
        let flat = hill.map(|[x, _]| [x, 10.0]);
        for crossed in [crossings(&hill, &flat), crossings(&flat, &hill)] {
            assert_eq!(crossed.len(), 2, "{crossed:?}");
            assert!((crossed[0] - 10.0).abs() < 1e-9 && (crossed[1] - 1000.0).abs() < 1e-6, "{crossed:?}");
        }
        // A place that one of them lacks says nothing.
        assert!(crossings(&hill, &[flat[0], flat[2], flat[3]]).is_empty());
    }
}
