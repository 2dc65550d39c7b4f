//! A hand on the camera: turns, shifts and zooms that are laid over whatever the sample does.

use std::f64::consts::FRAC_PI_2;

use glam::{DAffine3, DQuat, DVec2, DVec3};
use prism_engine::scene::Projection;

use crate::app::sample::Pose;

/// How near the camera may come to the poles, radians: at a pole "up" has no direction.
const POLE: f64 = 0.01;

/// What the user has done to the camera. The default does nothing, to the bit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Orbit {
    /// Turn around the vertical line through the pivot, radians.
    yaw: f64,
    /// Turn over the top, radians.
    pitch: f64,
    /// Factor of the distance to the pivot.
    distance: f64,
    /// Shift of the pivot and the eye, world units.
    shift: DVec3,
}

impl Default for Orbit {
    fn default() -> Self {
        Orbit { yaw: 0.0, pitch: 0.0, distance: 1.0, shift: DVec3::ZERO }
    }
}

impl Orbit {
    /// The sample's pose as the user has turned it.
    pub fn apply(&self, pose: &Pose) -> Pose {
        if *self == Orbit::default() {
            return *pose;
        }
        let turned = self.turned(pose);
        let mut camera = pose.camera;
        let pivot = pose.pivot + self.shift;
        camera.transform = DAffine3 {
            matrix3: turned.matrix3,
            translation: pivot + (turned.translation - pose.pivot) * self.distance,
        };
        if let Projection::Orthographic { y_mag, .. } = &mut camera.projection {
            // Coming nearer changes nothing without perspective: the extent does.
            *y_mag *= self.distance;
        }
        Pose { camera, pivot }
    }

    /// A drag of `pixels` in a window of `height` pixels turns the camera: half a turn over the window's height.
    pub fn turn(&mut self, pose: &Pose, pixels: DVec2, height: f64) {
        let angle = -pixels / height * std::f64::consts::PI;
        self.yaw += angle.x;
        self.pitch = self.held_off_the_poles(pose, self.pitch + angle.y);
    }

    /// A drag of `pixels` moves the camera in the picture's plane, so that what lies at the pivot's depth follows.
    pub fn shift(&mut self, pose: &Pose, pixels: DVec2, height: f64) {
        let now = self.apply(pose);
        let (extent, basis) = match now.camera.projection {
            Projection::Perspective { fov_y, .. } => {
                let distance = now.camera.transform.translation.distance(now.pivot);
                (2.0 * distance * (fov_y / 2.0).tan(), now.camera.transform.matrix3)
            }
            Projection::Orthographic { y_mag, .. } => (2.0 * y_mag, now.camera.transform.matrix3),
        };
        self.shift += (basis.x_axis * -pixels.x + basis.y_axis * pixels.y) * (extent / height);
    }

    /// One notch of a wheel comes a tenth nearer.
    pub fn zoom(&mut self, notches: f64) {
        self.distance = (self.distance * 0.9f64.powf(notches)).clamp(1e-3, 1e3);
    }

    /// Yaw and pitch around the pivot, without distance and shift.
    fn turned(&self, pose: &Pose) -> DAffine3 {
        let pitch = DQuat::from_axis_angle(level_right(pose), self.pitch);
        let turn = DQuat::from_rotation_y(self.yaw) * pitch;
        let around = DAffine3::from_translation(pose.pivot) * DAffine3::from_quat(turn);
        around * DAffine3::from_translation(-pose.pivot) * pose.camera.transform
    }

    /// `pitch`, limited so that the eye stays between straight above and straight below the pivot.
    fn held_off_the_poles(&self, pose: &Pose, pitch: f64) -> f64 {
        let arm = (pose.camera.transform.translation - pose.pivot).normalize_or(DVec3::Z);
        // Turning by a positive angle around the right axis lowers the eye.
        let elevation = arm.y.clamp(-1.0, 1.0).asin();
        let limit = FRAC_PI_2 - POLE;
        // A camera that starts at a pole may leave it, and only that way.
        pitch.clamp((elevation - limit).min(0.0), (elevation + limit).max(0.0))
    }
}

/// The horizontal direction to the right of the arm from pivot to eye; the camera's own right seen from a pole.
fn level_right(pose: &Pose) -> DVec3 {
    let arm = pose.camera.transform.translation - pose.pivot;
    let right = DVec3::Y.cross(arm);
    if right.length() > 1e-6 * arm.length() {
        right.normalize()
    } else {
        pose.camera.transform.matrix3.x_axis.normalize_or(DVec3::X)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use prism_engine::scene::Camera;

    fn pose() -> Pose {
        let transform = DAffine3::from_translation(DVec3::new(1.0, 2.0, 5.0));
        let projection = Projection::Perspective { fov_y: FRAC_PI_2, near: 0.1, far: None };
        Pose { camera: Camera { transform, projection }, pivot: DVec3::new(1.0, 2.0, 0.0) }
    }

    fn eye(orbit: &Orbit) -> DVec3 {
        orbit.apply(&pose()).camera.transform.translation
    }

    #[test]
    fn untouched_it_does_nothing() {
        assert_eq!(eye(&Orbit::default()), pose().camera.transform.translation);
    }

    #[test]
    fn dragging_to_the_right_takes_the_eye_to_the_left() {
        let mut orbit = Orbit::default();
        orbit.turn(&pose(), DVec2::new(250.0, 0.0), 500.0);
        assert!(eye(&orbit).abs_diff_eq(DVec3::new(-4.0, 2.0, 0.0), 1e-9), "{}", eye(&orbit));
    }

    #[test]
    fn dragging_down_takes_the_eye_up_and_stops_at_the_pole() {
        let mut orbit = Orbit::default();
        orbit.turn(&pose(), DVec2::new(0.0, 50.0), 500.0);
        assert!(eye(&orbit).y > 2.0);
        orbit.turn(&pose(), DVec2::new(0.0, 5000.0), 500.0);
        let arm = eye(&orbit) - pose().pivot;
        assert!(arm.y > 4.99 && arm.z > 0.0, "{arm}");
        let forward = orbit.apply(&pose()).camera.transform.matrix3 * DVec3::NEG_Z;
        assert!(forward.abs_diff_eq(-arm.normalize(), 1e-9), "it still looks at the pivot");
    }

    #[test]
    fn shifting_by_the_height_moves_by_the_height_at_the_pivot() {
        let mut orbit = Orbit::default();
        orbit.shift(&pose(), DVec2::new(0.0, 500.0), 500.0);
        // 90° at a distance of 5: the picture is 10 high there.
        assert!(eye(&orbit).abs_diff_eq(DVec3::new(1.0, 12.0, 5.0), 1e-9), "{}", eye(&orbit));
    }

    #[test]
    fn zooming_comes_nearer() {
        let mut orbit = Orbit::default();
        orbit.zoom(1.0);
        assert!((eye(&orbit).distance(pose().pivot) - 4.5).abs() < 1e-9);
    }
}
