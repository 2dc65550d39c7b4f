//! What changes from frame to frame though it should not, while the camera moves: of a surface point that both frames
//! show, an error that is not the same in both is seen as crawling or popping, even where each picture alone looks right.

use glam::DVec3;

use super::{depth_error, footprint, percentile};
use crate::{
    aov::Aov,
    scene::{Camera, Projection},
};

/// One frame of a motion, with what is right there.
#[derive(Clone, Copy)]
pub struct Moment<'a> {
    /// As drawn.
    pub test: &'a Aov,
    /// As the reference has it, of the same size.
    pub reference: &'a Aov,
    /// Both frames'.
    pub camera: &'a Camera,
}

/// What changes between two frames. The points are those of the later reference that the earlier one shows too; a figure
/// over no point at all is 0.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Flicker {
    /// Points that both references show.
    pub points: usize,
    /// Share of the points that the test shows in one of the frames only.
    pub vanishes: f64,
    /// Median change of the depth error of a point, pixel footprints.
    pub depth_p50: f64,
    /// 99th percentile of that change.
    pub depth_p99: f64,
}

impl Flicker {
    /// Compares a frame with the one before.
    ///
    /// # Panics
    /// If the frames differ in size.
    pub fn between(before: &Moment<'_>, after: &Moment<'_>) -> Self {
        let size = |aov: &Aov| [aov.width, aov.height];
        let sizes = [before.test, before.reference, after.test, after.reference].map(size);
        assert!(sizes.iter().all(|other| *other == sizes[0]), "frames of one size");
        let (mut points, mut vanished, mut changes) = (0usize, 0, Vec::new());
        for i in (0..after.reference.depth.len()).filter(|i| after.reference.depth[*i].is_finite()) {
            let Some(j) = shown(before, glam::Vec3::from(after.reference.position[i]).as_dvec3()) else { continue };
            points += 1;
            match (before.test.depth[j].is_finite(), after.test.depth[i].is_finite()) {
                (true, true) => changes.push((signed_error(after, i) - signed_error(before, j)).abs()),
                (false, false) => {}
                _ => vanished += 1,
            }
        }
        changes.sort_by(f64::total_cmp);
        Flicker {
            points,
            vanishes: f64::from(vanished) / points.max(1) as f64,
            depth_p50: percentile(&changes, 0.5),
            depth_p99: percentile(&changes, 0.99),
        }
    }
}

/// The depth error of a pixel that both cover, in footprints; negative where the test is nearer.
fn signed_error(moment: &Moment<'_>, pixel: usize) -> f64 {
    let error = depth_error(moment.test, moment.reference, moment.camera, pixel);
    if moment.test.depth[pixel] < moment.reference.depth[pixel] { -error } else { error }
}

/// The pixel in which a frame's reference shows a point of the world: what it has there lies no farther off than the
/// pixel's own diagonal.
fn shown(moment: &Moment<'_>, point: DVec3) -> Option<usize> {
    let reference = moment.reference;
    let [width, height] = [reference.width, reference.height].map(f64::from);
    let local = moment.camera.transform.inverse().transform_point3(point);
    let half = match moment.camera.projection {
        Projection::Perspective { fov_y, .. } => -local.z * (0.5 * fov_y).tan(),
        Projection::Orthographic { y_mag, .. } => y_mag,
    };
    if local.z >= 0.0 {
        return None;
    }
    // Pixels are square.
    let (x, y) = (0.5 * (width + local.x / half * height), 0.5 * (1.0 - local.y / half) * height);
    if !(0.0..width).contains(&x) || !(0.0..height).contains(&y) {
        return None;
    }
    let pixel = y as usize * reference.width as usize + x as usize;
    let there = glam::Vec3::from(reference.position[pixel]).as_dvec3();
    let reach = 2f64.sqrt() * footprint(moment.camera, reference.height, -local.z);
    (reference.depth[pixel].is_finite() && there.distance(point) <= reach).then_some(pixel)
}

#[cfg(test)]
mod tests {
    use glam::DAffine3;

    use super::*;

    /// Looks along -Z from `x`, 2 tan(fov_y / 2) = 1.
    fn camera(x: f64) -> Camera {
        let fov_y = 2.0 * (0.5f64).atan();
        let transform = DAffine3::from_translation(DVec3::new(x, 0.0, 0.0));
        Camera { transform, projection: Projection::Perspective { fov_y, near: 0.1, far: None } }
    }

    /// 10 × 10 pixels, half a unit each, of the wall at z = -5 as a camera at `x` sees it.
    fn wall(x: f64) -> Aov {
        let mut aov = Aov::missed(10, 10);
        for (i, position) in aov.position.iter_mut().enumerate() {
            let at = DVec3::new(x + 0.5 * ((i % 10) as f64 - 4.5), 0.5 * (4.5 - (i / 10) as f64), -5.0);
            *position = at.as_vec3().to_array();
        }
        aov.depth.fill(5.0);
        aov
    }

    /// A frame from `x`, its depth moved by so many footprints in each pixel.
    fn flicker(before: impl Fn(usize) -> f32, after: impl Fn(usize) -> f32) -> Flicker {
        let moved = |by: &dyn Fn(usize) -> f32, x: f64| {
            let mut aov = wall(x);
            (0..100).for_each(|i| aov.depth[i] += 0.5 * by(i));
            aov
        };
        // One pixel to the right.
        let (cameras, references) = ([camera(0.0), camera(0.5)], [wall(0.0), wall(0.5)]);
        let tests = [moved(&before, 0.0), moved(&after, 0.5)];
        let moment = |i: usize| Moment { test: &tests[i], reference: &references[i], camera: &cameras[i] };
        Flicker::between(&moment(0), &moment(1))
    }

    #[test]
    fn an_error_that_moves_with_the_surface_does_not_flicker() {
        // The last column of the later frame comes into sight.
        let still = Flicker { points: 90, ..Flicker::default() };
        assert_eq!(flicker(|_| 0.0, |_| 0.0), still);
        let column = |offset: usize| move |i: usize| if (i + offset) % 10 == 4 { 3.0 } else { 0.0 };
        let f = flicker(column(0), column(1));
        assert!(f.points == 90 && f.depth_p99 < 1e-5, "{f:?}");
    }

    #[test]
    fn an_error_that_stays_on_the_screen_flickers() {
        let column = |i: usize| if i % 10 == 4 { 3.0 } else { 0.0 };
        let f = flicker(column, column);
        // Two of nine columns change by three footprints.
        assert!(f.depth_p50 < 1e-5 && (f.depth_p99 - 3.0).abs() < 1e-5, "{f:?}");
        let sides = flicker(|_| -1.0, |_| 1.0);
        assert!((sides.depth_p50 - 2.0).abs() < 1e-5, "from one side to the other: {sides:?}");
    }

    #[test]
    fn a_hole_in_one_frame_is_something_that_vanishes() {
        let f = flicker(|i| if i == 55 { f32::INFINITY } else { 0.0 }, |_| 0.0);
        assert_eq!((f.points, f.vanishes, f.depth_p99), (90, 1.0 / 90.0, 0.0));
        // In both it is wrong, but does not flicker.
        let f = flicker(|i| if i == 55 { f32::INFINITY } else { 0.0 }, |i| if i == 54 { f32::INFINITY } else { 0.0 });
        assert_eq!((f.points, f.vanishes), (90, 0.0));
    }
}
