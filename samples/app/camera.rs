//! Where a run starts: the scene's camera, or what the command line puts in its place, and what an orbit turns around.

use glam::DVec3;
use prism_engine::{
    error::Result,
    scene::{Camera, Scene},
};

use super::{cli::CameraArgs, sample::Pose};

/// The camera that `args` ask for, starting from the scene's (`base`), and the point that an orbit turns around.
pub fn start(args: &CameraArgs, scene: &Scene, base: &Camera) -> Result<Pose> {
    let target = args.target.map(DVec3::from_array);
    let camera = base.overridden(args.eye.map(DVec3::from_array), target, args.fov_y)?;
    Ok(Pose { camera, pivot: target.unwrap_or_else(|| pivot(scene, &camera)) })
}

/// The point on the camera's axis that is nearest to the middle of what it may see.
fn pivot(scene: &Scene, camera: &Camera) -> DVec3 {
    let eye = camera.transform.translation;
    let forward = camera.transform.matrix3 * DVec3::NEG_Z;
    let (low, high) = scene.bounds().unwrap_or_default();
    let along = ((low + high) / 2.0 - eye).dot(forward);
    // A scene that lies behind the camera, or all around it, is turned around at its own radius.
    let radius = ((high - low).length() / 2.0).max(1e-3);
    eye + forward * if along > 0.01 * radius { along } else { radius }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::testing::empty_scene;
    use glam::DAffine3;
    use prism_engine::scene::Projection;

    fn base() -> Camera {
        Camera {
            transform: DAffine3::from_translation(DVec3::new(2.0, 0.0, 5.0)),
            projection: Projection::Perspective { fov_y: 1.0, near: 0.1, far: None },
        }
    }

    #[test]
    fn without_flags_the_pivot_lies_on_the_axis_nearest_to_the_middle() {
        let pose = start(&CameraArgs::default(), &empty_scene(), &base()).unwrap();
        assert_eq!(pose.camera.transform, base().transform);
        assert_eq!(pose.pivot, DVec3::new(2.0, 0.0, 0.0));
    }

    #[test]
    fn a_target_is_the_pivot() {
        let args = CameraArgs { target: Some([0.0, 1.0, 0.0]), ..CameraArgs::default() };
        let pose = start(&args, &empty_scene(), &base()).unwrap();
        assert_eq!(pose.pivot, DVec3::Y);
        let forward = pose.camera.transform.matrix3 * DVec3::NEG_Z;
        assert!(forward.abs_diff_eq((DVec3::Y - base().transform.translation).normalize(), 1e-12));
    }

    #[test]
    fn a_scene_behind_the_camera_is_turned_around_too() {
        let away = Camera { transform: DAffine3::from_translation(DVec3::new(0.0, 0.0, -5.0)), ..base() };
        let pose = start(&CameraArgs::default(), &empty_scene(), &away).unwrap();
        assert!(pose.pivot.z < -5.0, "ahead of the camera");
    }
}
