//! Where a run starts: the scene's camera, or what the command line puts in its place.

use glam::{DAffine3, DMat3, DVec3};
use prism_engine::{
    error::{Error, Result},
    scene::{Camera, Projection, Scene},
};

use super::{cli::CameraArgs, sample::Pose};

/// The camera that `args` ask for, starting from the scene's (`base`), and the point that an orbit turns around.
///
/// An eye without a target keeps the point that was looked at; a target without an eye keeps the eye.
pub fn start(args: &CameraArgs, scene: &Scene, base: &Camera) -> Result<Pose> {
    let mut pose = Pose { camera: *base, pivot: pivot(scene, base) };
    if let Some(degrees) = args.fov_y {
        match &mut pose.camera.projection {
            Projection::Perspective { fov_y, .. } => *fov_y = degrees.to_radians(),
            Projection::Orthographic { .. } => {
                return Err(Error::Usage(
                    "--fov-y: the scene's camera is orthographic and has no field of view; drop the flag".into(),
                ));
            }
        }
    }
    if args.eye.is_none() && args.target.is_none() {
        return Ok(pose);
    }
    let eye = args.eye.map_or(base.transform.translation, DVec3::from_array);
    let target = args.target.map_or(pose.pivot, DVec3::from_array);
    let Some(forward) = (target - eye).try_normalize() else {
        return Err(Error::Usage(format!(
            "--eye and --target: both are at {},{},{}, so there is no direction to look in; move one of them",
            eye.x, eye.y, eye.z
        )));
    };
    pose.camera.transform = DAffine3 { matrix3: looking(forward, base), translation: eye };
    pose.pivot = target;
    Ok(pose)
}

/// Camera axes that look along `forward` with +Y up; seen straight down or up, the scene's camera says what is up.
fn looking(forward: DVec3, base: &Camera) -> DMat3 {
    let ups = [DVec3::Y, base.transform.matrix3.y_axis, base.transform.matrix3.z_axis, DVec3::Z];
    let rights = ups.iter().map(|up| forward.cross(*up)).filter(|right| right.length() > 1e-6);
    let right = rights.map(DVec3::normalize).next().unwrap_or(DVec3::X);
    DMat3::from_cols(right, right.cross(forward), -forward)
}

/// The point on the camera's axis that is nearest to the middle of what it may see.
fn pivot(scene: &Scene, camera: &Camera) -> DVec3 {
    let eye = camera.transform.translation;
    let forward = camera.transform.matrix3 * DVec3::NEG_Z;
    let (low, high) = bounds(scene).unwrap_or((DVec3::ZERO, DVec3::ZERO));
    let along = ((low + high) / 2.0 - eye).dot(forward);
    // A scene that lies behind the camera, or all around it, is turned around at its own radius.
    let radius = ((high - low).length() / 2.0).max(1e-3);
    eye + forward * if along > 0.01 * radius { along } else { radius }
}

/// World bounds of the base meshes.
fn bounds(scene: &Scene) -> Option<(DVec3, DVec3)> {
    let mut bounds: Option<(DVec3, DVec3)> = None;
    for instance in &scene.instances {
        let Some(mesh) = scene.meshes.get(instance.mesh) else { continue };
        for position in mesh.primitives.iter().flat_map(|primitive| &primitive.positions) {
            let point = instance.transform.transform_point3(position.as_dvec3());
            let (low, high) = bounds.unwrap_or((point, point));
            bounds = Some((low.min(point), high.max(point)));
        }
    }
    bounds
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::testing::empty_scene;

    fn base() -> Camera {
        Camera {
            transform: DAffine3::from_translation(DVec3::new(0.0, 0.0, 5.0)),
            projection: Projection::Perspective { fov_y: 1.0, near: 0.1, far: None },
        }
    }

    fn args(eye: Option<[f64; 3]>, target: Option<[f64; 3]>, fov_y: Option<f64>) -> CameraArgs {
        CameraArgs { eye, target, fov_y }
    }

    #[test]
    fn without_flags_nothing_moves() {
        let pose = start(&args(None, None, None), &empty_scene(), &base()).unwrap();
        assert_eq!(pose.camera.transform, base().transform);
        assert_eq!(pose.pivot, DVec3::ZERO, "the middle of the scene");
    }

    #[test]
    fn the_camera_looks_from_eye_to_target_even_straight_down() {
        for (eye, target) in [([1.0, 2.0, 3.0], [0.0, -1.0, 2.0]), ([0.0, 4.0, 0.0], [0.0, 0.0, 0.0])] {
            let pose = start(&args(Some(eye), Some(target), Some(90.0)), &empty_scene(), &base()).unwrap();
            let axes = pose.camera.transform.matrix3;
            assert!((axes.determinant() - 1.0).abs() < 1e-12, "right-handed and orthonormal: {axes}");
            let forward = (DVec3::from_array(target) - DVec3::from_array(eye)).normalize();
            assert!((axes * DVec3::NEG_Z).abs_diff_eq(forward, 1e-12));
            assert!(axes.y_axis.y >= 0.0);
            let Projection::Perspective { fov_y, .. } = pose.camera.projection else { panic!("perspective") };
            assert!((fov_y - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
        }
    }

    #[test]
    fn no_direction_and_no_field_of_view_are_wrong_usage() {
        let same = args(Some([1.0; 3]), Some([1.0; 3]), None);
        assert_eq!(start(&same, &empty_scene(), &base()).unwrap_err().exit_code(), 2);
        let flat = Camera { projection: Projection::Orthographic { y_mag: 1.0, near: 0.1, far: 9.0 }, ..base() };
        assert_eq!(start(&args(None, None, Some(40.0)), &empty_scene(), &flat).unwrap_err().exit_code(), 2);
    }
}
