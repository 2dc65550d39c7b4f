//! How far one frame is from another: metrics between two [`Aov`] sets of the same camera (DESIGN section 8).

pub mod flicker;

use crate::{
    aov::Aov,
    scene::{Camera, Projection},
};

/// What sets a tested frame apart from its reference. Errors are taken at pixels that both cover; a figure over no
/// pixel at all is 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Metrics {
    /// Pixels that the reference covers.
    pub covered: usize,
    /// Pixels that only one of the two covers, per pixel that the reference covers (per pixel if it covers none).
    pub coverage_differs: f64,
    /// Median depth error, pixel footprints.
    pub depth_p50: f64,
    /// 99th percentile of the depth error, pixel footprints.
    pub depth_p99: f64,
    /// Share of the pixels whose depth is off by more than one footprint.
    pub depth_above_1: f64,
    /// Median angle between the normals, degrees.
    pub normal_p50: f64,
    /// 99th percentile of the angle between the normals, degrees.
    pub normal_p99: f64,
    /// Share of the pixels that are lit in one and in shadow in the other.
    pub shadow_wrong: f64,
    /// Values of the tested frame that are NaN, or infinite elsewhere than in depth, where +∞ means a miss.
    pub nan_count: usize,
}

impl Metrics {
    /// Compares `test` with `reference`, both seen through `camera`.
    ///
    /// # Panics
    ///
    /// If the two frames differ in size.
    pub fn between(test: &Aov, reference: &Aov, camera: &Camera) -> Self {
        assert_eq!((test.width, test.height), (reference.width, reference.height), "frames of one size");
        let hit = |aov: &Aov, i: usize| aov.depth[i].is_finite();
        let pixels = 0..reference.depth.len();
        let covered = pixels.clone().filter(|&i| hit(reference, i)).count();
        let differ = pixels.clone().filter(|&i| hit(test, i) != hit(reference, i)).count();
        let both: Vec<usize> = pixels.filter(|&i| hit(test, i) && hit(reference, i)).collect();
        let mut depths: Vec<f64> = both.iter().map(|&i| depth_error(test, reference, camera, i)).collect();
        let mut angles: Vec<f64> = both.iter().map(|&i| degrees(test.normal[i], reference.normal[i])).collect();
        let share = |count: usize| count as f64 / both.len().max(1) as f64;
        let above = depths.iter().filter(|e| **e > 1.0).count();
        let dark = |aov: &Aov, i: usize| aov.shadow[i] < 0.5;
        let wrong = both.iter().filter(|&&i| dark(test, i) != dark(reference, i)).count();
        depths.sort_by(f64::total_cmp);
        angles.sort_by(f64::total_cmp);
        Metrics {
            covered,
            coverage_differs: differ as f64 / if covered > 0 { covered } else { reference.depth.len().max(1) } as f64,
            depth_p50: percentile(&depths, 0.5),
            depth_p99: percentile(&depths, 0.99),
            depth_above_1: share(above),
            normal_p50: percentile(&angles, 0.5),
            normal_p99: percentile(&angles, 0.99),
            shadow_wrong: share(wrong),
            nan_count: broken_values(test),
        }
    }
}

/// The size of a pixel of a picture `height` pixels high, at view depth `depth`, world units.
pub fn footprint(camera: &Camera, height: u32, depth: f64) -> f64 {
    match camera.projection {
        Projection::Perspective { fov_y, .. } => depth * 2.0 * (0.5 * fov_y).tan() / f64::from(height),
        Projection::Orthographic { y_mag, .. } => 2.0 * y_mag / f64::from(height),
    }
}

/// Depth error of pixel `i` in footprints at the reference's depth; both frames cover the pixel.
pub fn depth_error(test: &Aov, reference: &Aov, camera: &Camera, i: usize) -> f64 {
    let z = f64::from(reference.depth[i]);
    (f64::from(test.depth[i]) - z).abs() / footprint(camera, reference.height, z)
}

/// The angle between two vectors of any length, accurate for small angles too.
fn degrees(a: [f32; 3], b: [f32; 3]) -> f64 {
    let (a, b) = (glam::Vec3::from(a).as_dvec3(), glam::Vec3::from(b).as_dvec3());
    a.cross(b).length().atan2(a.dot(b)).to_degrees()
}

/// The least value that at least a share `q` of the sorted values does not exceed (nearest rank).
fn percentile(sorted: &[f64], q: f64) -> f64 {
    let rank = (q * sorted.len() as f64).ceil() as usize;
    sorted.get(rank.saturating_sub(1)).copied().unwrap_or(0.0)
}

fn broken_values(aov: &Aov) -> usize {
    let broken = |v: &f32| !v.is_finite();
    let vectors = aov.position.iter().chain(&aov.normal).chain(&aov.color).flatten();
    let others = vectors.chain(aov.uv.iter().flatten()).chain(&aov.height_at_hit).chain(&aov.shadow);
    let depths = aov.depth.iter().filter(|z| z.is_nan() || **z == f32::NEG_INFINITY);
    others.filter(|v| broken(v)).count() + depths.count()
}

#[cfg(test)]
mod tests {
    use glam::DAffine3;

    use super::*;

    /// fov_y such that 2 tan(fov_y / 2) = 1.
    fn camera() -> Camera {
        let fov_y = 2.0 * (0.5f64).atan();
        Camera { transform: DAffine3::IDENTITY, projection: Projection::Perspective { fov_y, near: 0.1, far: None } }
    }

    /// 10 × 10 pixels; the first `covered` are hit at depth 5, facing the camera.
    fn frame(covered: usize) -> Aov {
        let mut aov = Aov::missed(10, 10);
        aov.depth[..covered].fill(5.0);
        aov.normal[..covered].fill([0.0, 0.0, 1.0]);
        aov
    }

    #[test]
    fn equal_frames_differ_in_nothing() {
        let m = Metrics::between(&frame(40), &frame(40), &camera());
        let zero = Metrics {
            covered: 40,
            coverage_differs: 0.0,
            depth_p50: 0.0,
            depth_p99: 0.0,
            depth_above_1: 0.0,
            normal_p50: 0.0,
            normal_p99: 0.0,
            shadow_wrong: 0.0,
            nan_count: 0,
        };
        assert_eq!(m, zero);
        let empty = Metrics::between(&frame(0), &frame(0), &camera());
        assert_eq!(empty, Metrics { covered: 0, ..zero });
    }

    #[test]
    fn depth_is_measured_in_footprints() {
        let reference = frame(100);
        let mut test = frame(100);
        // A footprint is 5 · 1 / 10 = 0.5 world units.
        test.depth[..60].fill(5.25);
        test.depth[60..63].fill(4.0);
        let m = Metrics::between(&test, &reference, &camera());
        assert!((m.depth_p50 - 0.5).abs() < 1e-9 && (m.depth_p99 - 2.0).abs() < 1e-9);
        assert_eq!(m.depth_above_1, 0.03);
        let projection = Projection::Orthographic { y_mag: 2.5, near: 0.1, far: 9.0 };
        let m = Metrics::between(&test, &reference, &Camera { projection, ..camera() });
        assert!((m.depth_p50 - 0.5).abs() < 1e-9);
    }

    #[test]
    fn the_99th_percentile_forgives_exactly_one_pixel_in_a_hundred() {
        let mut test = frame(100);
        test.depth[7] = 9.0;
        assert_eq!(Metrics::between(&test, &frame(100), &camera()).depth_p99, 0.0);
        test.depth[8] = 9.0;
        assert!((Metrics::between(&test, &frame(100), &camera()).depth_p99 - 8.0).abs() < 1e-9);
    }

    #[test]
    fn coverage_normals_and_shadows() {
        let reference = frame(50);
        let mut test = frame(45);
        test.depth[99] = 5.0;
        let angle = 3e-4f32;
        test.normal[..30].fill([angle.sin(), 0.0, angle.cos()]);
        test.shadow[..9].fill(0.0);
        // Missed pixels have no say.
        test.shadow[60..].fill(0.0);
        let m = Metrics::between(&test, &reference, &camera());
        assert_eq!((m.covered, m.coverage_differs), (50, 6.0 / 50.0));
        assert!((m.normal_p50 - f64::from(angle).to_degrees()).abs() < 1e-6 && m.normal_p99 == m.normal_p50);
        assert_eq!(m.shadow_wrong, 9.0 / 45.0);
    }

    #[test]
    fn broken_values_are_counted_but_a_miss_is_none() {
        let mut test = frame(50);
        test.normal[3][1] = f32::NAN;
        test.uv[99][0] = f32::INFINITY;
        test.depth[0] = f32::NAN;
        test.depth[1] = f32::NEG_INFINITY;
        let m = Metrics::between(&test, &frame(50), &camera());
        assert_eq!(m.nan_count, 4);
        assert_eq!(m.coverage_differs, 2.0 / 50.0, "no depth, no cover");
    }
}
