//! What the exact march has to reach against the f64 reference, with every shell and in every scene.

use prism_engine::measure::Metrics;

/// The scenes of the table of figures, by their files below `assets/`.
pub const SCENES: [&str; 10] = [
    "torus",
    "suzanne",
    "cube",
    "cloth",
    "stability_cliffs",
    "stability_needles",
    "stability_slivers",
    "stability_seams",
    "stability_far",
    "stability_inside",
];

/// 99 % of the pixels are this near to the truth, in pixel footprints.
pub const DEPTH_P99: f64 = 0.05;
/// Share of the pixels that may be off by more than a footprint.
pub const ABOVE_1: f64 = 1e-4;
/// Pixels that one picture alone covers, per covered pixel.
pub const COVERAGE: f64 = 2e-4;

/// The figures that a picture misses, by name, and its values there. `limits`: loops that gave up.
pub fn misses(m: &Metrics, limits: u32) -> Vec<(&'static str, String)> {
    let limited = [
        ("p99", m.depth_p99, DEPTH_P99),
        ("above 1", m.depth_above_1, ABOVE_1),
        ("coverage", m.coverage_differs, COVERAGE),
    ];
    let over = limited.into_iter().filter(|(_, value, limit)| value > limit || value.is_nan());
    let mut misses: Vec<_> = over.map(|(name, value, _)| (name, format!("{value:.1e}"))).collect();
    for (name, count) in [("NaN", m.nan_count), ("limits", limits as usize)] {
        if count > 0 {
            misses.push((name, count.to_string()));
        }
    }
    misses
}
