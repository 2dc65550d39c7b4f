//! What changes in a moving picture that should not: the error of a point that stands still.

use glam::DVec3;

use super::{depth_error_signed, footprint, percentile};
use crate::{
    aov::Aov,
    scene::{Camera, Projection},
};

/// Two hits are of one point if they lie so near to each other, in footprints.
const SAME_POINT: f64 = 2.0;

/// A frame, what it should show, and the camera of both.
#[derive(Clone, Copy)]
pub struct Moment<'a> {
    /// The frame.
    pub test: &'a Aov,
    /// Its reference.
    pub reference: &'a Aov,
    /// Seen through.
    pub camera: &'a Camera,
}

/// 99th percentile of the change of the depth error, in footprints, from the first frame to the second, over all
/// points that both of them see, at the second one's pixels; 0 where there is none.
pub fn flicker(first: Moment<'_>, second: Moment<'_>) -> f64 {
    let sees = |at: Moment<'_>, i: usize| at.reference.depth[i].is_finite() && at.test.depth[i].is_finite();
    let change = |i: usize| {
        let point = glam::Vec3::from(second.reference.position[i]).as_dvec3();
        let j = pixel(first.camera, [first.reference.width, first.reference.height], point)?;
        let known = glam::Vec3::from(first.reference.position[j]).as_dvec3();
        let near = SAME_POINT * footprint(first.camera, first.reference.height, f64::from(first.reference.depth[j]));
        let same = sees(first, j) && known.distance(point) <= near;
        let error = |at: Moment<'_>, i| depth_error_signed(at.test, at.reference, at.camera, i);
        same.then(|| (error(second, i) - error(first, j)).abs())
    };
    let pixels = (0..second.reference.depth.len()).filter(|&i| sees(second, i));
    let mut changes: Vec<f64> = pixels.filter_map(change).collect();
    changes.sort_by(f64::total_cmp);
    percentile(&changes, 0.99)
}

/// The pixel that shows a point, if one does.
fn pixel(camera: &Camera, [width, height]: [u32; 2], point: DVec3) -> Option<usize> {
    let seen = camera.transform.inverse().transform_point3(point);
    let half = match camera.projection {
        Projection::Perspective { fov_y, .. } => -seen.z * (0.5 * fov_y).tan(),
        Projection::Orthographic { y_mag, .. } => y_mag,
    };
    if half <= 0.0 {
        return None;
    }
    let (width, height) = (f64::from(width), f64::from(height));
    let x = (0.5 * (width + seen.x / half * height)).floor();
    let y = (0.5 * (height - seen.y / half * height)).floor();
    let inside = (0.0..width).contains(&x) && (0.0..height).contains(&y);
    inside.then_some(y as usize * width as usize + x as usize)
}

#[cfg(test)]
mod tests {
    use glam::DAffine3;

    use super::*;

    /// Looks down -Z from above a plane at z = -5, moved along X.
    fn camera(x: f64) -> Camera {
        let projection = Projection::Orthographic { y_mag: 5.0, near: 0.1, far: 9.0 };
        Camera { transform: DAffine3::from_translation(DVec3::new(x, 0.0, 0.0)), projection }
    }

    /// The plane, 10 × 10 pixels of size 1, `error` in front of where it is at some places of the plane.
    fn frame(x: f64, error: impl Fn(f64) -> f32) -> [Aov; 2] {
        let mut reference = Aov::missed(10, 10);
        for i in 0..100 {
            let (column, row) = ((i % 10) as f64, (i / 10) as f64);
            reference.depth[i] = 5.0;
            reference.position[i] = [(x + column - 4.5) as f32, (4.5 - row) as f32, -5.0];
        }
        let mut test = reference.clone();
        for i in 0..100 {
            test.depth[i] -= error(f64::from(reference.position[i][0]));
        }
        [test, reference]
    }

    fn between([a, b]: &[Aov; 2], [c, d]: &[Aov; 2]) -> f64 {
        let [still, moved] = [0.0, 1.0].map(camera);
        flicker(Moment { test: a, reference: b, camera: &still }, Moment { test: c, reference: d, camera: &moved })
    }

    #[test]
    fn an_error_that_stays_with_its_point_does_not_flicker() {
        let error = |x: f64| if x > 0.0 { 0.75 } else { 0.0 };
        assert_eq!(between(&frame(0.0, error), &frame(1.0, error)), 0.0);
    }

    #[test]
    fn an_error_that_stays_with_the_pixel_does() {
        let first = frame(0.0, |x| if x > 0.0 { 0.75 } else { 0.0 });
        let second = frame(1.0, |x| if x > 1.0 { 0.75 } else { 0.0 });
        // A column of ten changes by 0.75: more than one in a hundred.
        assert!((between(&first, &second) - 0.75).abs() < 1e-6);
        assert_eq!(between(&frame(0.0, |_| 0.0), &frame(40.0, |_| 1.0)), 0.0, "nothing in common");
    }
}
