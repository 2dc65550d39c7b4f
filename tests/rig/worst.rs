//! The pixels that are farthest off, with what both frames say about them: where the search for a bug begins.

use prism_engine::{aov::Aov, measure, scene::Camera};

/// How many pixels of each cell are told, by the environment variable `PRISM_WORST`; 0 without it.
pub fn asked() -> usize {
    std::env::var("PRISM_WORST").ok().and_then(|value| value.parse().ok()).unwrap_or(0)
}

/// Up to `count` lines: pixels that one frame alone covers, then by depth error.
pub fn lines(test: &Aov, reference: &Aov, camera: &Camera, count: usize) -> Vec<String> {
    let error = |i: usize| match (test.depth[i].is_finite(), reference.depth[i].is_finite()) {
        (true, true) => measure::depth_error(test, reference, camera, i),
        (false, false) => 0.0,
        _ => f64::INFINITY,
    };
    let mut pixels: Vec<(usize, f64)> = (0..reference.depth.len()).map(|i| (i, error(i))).collect();
    pixels.retain(|(_, error)| *error > 0.05);
    pixels.sort_by(|a, b| b.1.total_cmp(&a.1));
    let tell = |aov: &Aov, i: usize| {
        let (z, h, uv, n) = (aov.depth[i], aov.height_at_hit[i], aov.uv[i], aov.normal[i]);
        format!("z {z:.7} h {h:.6} uv {:.6} {:.6} n {:.3} {:.3} {:.3}", uv[0], uv[1], n[0], n[1], n[2])
    };
    let line = |&(i, error): &(usize, f64)| {
        let (x, y) = (i as u32 % test.width, i as u32 / test.width);
        format!(
            "  pixel {x},{y}: {error:.2} footprints\n    test      {}\n    reference {}",
            tell(test, i),
            tell(reference, i)
        )
    };
    pixels.iter().take(count).map(line).collect()
}
