//! Waves: a sum of six sines, each with a whole number of waves per UV unit along both axes.

use std::f64::consts::TAU;

use glam::DVec2;

/// Waves per UV unit along u and v, amplitude, phase in turns. The amplitudes' sum is 0.5.
const WAVES: [([f64; 2], f64, f64); 6] = [
    ([1.0, 2.0], 0.14, 0.0),
    ([3.0, 1.0], 0.11, 0.375),
    ([-2.0, 3.0], 0.09, 0.703_125),
    ([4.0, -1.0], 0.07, 0.125),
    ([5.0, 4.0], 0.05, 0.593_75),
    ([-3.0, 6.0], 0.04, 0.828_125),
];

pub(super) fn height_and_gradient(uv: DVec2) -> (f64, DVec2) {
    let (mut height, mut gradient) = (0.5, DVec2::ZERO);
    for (count, amplitude, phase) in WAVES {
        let count = DVec2::from(count);
        let (sin, cos) = (TAU * (count.dot(uv) + phase)).sin_cos();
        height += amplitude * sin;
        gradient += amplitude * TAU * cos * count;
    }
    (height, gradient)
}

/// Taylor's expansion about the middle: a wave's second derivative along any way is at most its amplitude times the
/// square of the phase's change.
pub(super) fn bounds(low: DVec2, high: DVec2) -> [f64; 2] {
    let half = 0.5 * (high - low);
    let (height, gradient) = height_and_gradient(low + half);
    let mut room = gradient.abs().dot(half);
    for (count, amplitude, _) in WAVES {
        let turn = TAU * DVec2::from(count).abs().dot(half);
        room += 0.5 * amplitude * turn * turn;
    }
    [height - room, height + room]
}
