//! Cameras: the file's, the one that frames a scene without, and the command line's overrides.

use glam::{DAffine3, DMat3, DVec3};
use gltf::json::{self, Index, camera::Type, validation::Checked};

use super::{
    Camera, Projection,
    document::{Document, label},
    node::Reached,
};
use crate::error::{Error, Result};

/// Vertical field of view of a camera that the file does not give, in degrees.
const DEFAULT_FOV_Y: f64 = 45.0;

/// Near plane of such a camera, as a part of the distance to its target.
const NEAR_PER_DISTANCE: f64 = 1e-3;

impl Camera {
    /// A perspective camera at `eye` that looks at `target`, +Y up, with a vertical field of view in degrees.
    ///
    /// The near plane is at a thousandth of the distance, the far plane at infinity. Looking straight down, the top of
    /// the picture is -Z, as on a map; straight up, it is +Z.
    ///
    /// # Errors
    ///
    /// [`Error::Usage`] where eye and target coincide, a number is not finite, or the angle is not between 0 and 180.
    pub fn look_at(eye: DVec3, target: DVec3, fov_y: f64) -> Result<Camera> {
        let fov_y = checked_fov_y(fov_y)?;
        let near = eye.distance(target) * NEAR_PER_DISTANCE;
        let transform = look_at(eye, target)?;
        Ok(Camera { transform, projection: Projection::Perspective { fov_y, near, far: None } })
    }

    /// This camera with the parts that are given replaced: `--eye`, `--target`, `--fov-y` (degrees) of the command line.
    ///
    /// - An eye alone moves the camera without turning it.
    /// - A target alone turns the camera where it stands.
    /// - Both make it look from the one at the other, +Y up as in [`Camera::look_at`].
    /// - Near planes stay. A perspective far plane is dropped where the eye moves: it was chosen for another viewpoint.
    ///
    /// # Errors
    ///
    /// [`Error::Usage`] as in [`Camera::look_at`], and for a field of view with an orthographic camera.
    pub fn overridden(&self, eye: Option<DVec3>, target: Option<DVec3>, fov_y_deg: Option<f64>) -> Result<Camera> {
        let mut camera = *self;
        if let Some(eye) = eye {
            if !eye.is_finite() {
                return Err(Error::Usage("the camera's eye is not finite".to_owned()));
            }
            camera.transform.translation = eye;
            if let Projection::Perspective { far, .. } = &mut camera.projection {
                *far = None;
            }
        }
        if let Some(target) = target {
            camera.transform = look_at(camera.transform.translation, target)?;
        }
        if let Some(degrees) = fov_y_deg {
            let Projection::Perspective { fov_y, .. } = &mut camera.projection else {
                return Err(Error::Usage(
                    "the scene's camera is orthographic: it has no field of view to override".to_owned(),
                ));
            };
            *fov_y = checked_fov_y(degrees)?;
        }
        Ok(camera)
    }
}

/// A camera that shows all of `bounds` (lowest and highest corner) in a picture of the given aspect ratio (width by
/// height, positive), from the front, the right and above.
pub fn frame(bounds: (DVec3, DVec3), aspect: f64) -> Camera {
    let (low, high) = bounds;
    let center = low.midpoint(high);
    let radius = match low.distance(high) / 2.0 {
        // A point has no size to fill the picture with.
        0.0 => 1.0,
        radius => radius,
    };
    let fov_y = DEFAULT_FOV_Y.to_radians();
    let half_y = fov_y / 2.0;
    let half = half_y.min((half_y.tan() * aspect).atan());
    const MARGIN: f64 = 1.05;
    let distance = radius / half.sin() * MARGIN;
    let back = DVec3::new(0.5, 0.4, 1.0).normalize();
    Camera {
        transform: DAffine3 { matrix3: basis(back, DVec3::Y), translation: center + back * distance },
        projection: Projection::Perspective { fov_y, near: distance * NEAR_PER_DISTANCE, far: None },
    }
}

/// The camera of the first node, by index in the file, that has one and that the scene reaches.
pub(super) fn import(doc: &Document, reached: &[Reached]) -> Result<Option<Camera>> {
    let cameras = reached.iter().filter_map(|reached| Some((reached, doc.nodes[reached.node].camera?)));
    let Some((reached, index)) = cameras.min_by_key(|(reached, _)| reached.node) else {
        return Ok(None);
    };
    let node = doc.node_label(reached.node);
    let camera = doc.lookup(&doc.cameras, index, "camera", &node)?;
    let projection = projection(doc, index, camera)?;

    // Viewing direction and up are kept, scale and shear go.
    let back = reached.world.matrix3.z_axis.try_normalize();
    let up = reached.world.matrix3.y_axis.try_normalize();
    let Some((back, up)) = back.zip(up).filter(|(back, up)| back.cross(*up).length() > 1e-9) else {
        return Err(doc.error(node, "its camera has no direction: the transform is flat", "give it a scale of 1"));
    };
    let transform = DAffine3 { matrix3: basis(back, up), translation: reached.world.translation };
    Ok(Some(Camera { transform, projection }))
}

fn projection(doc: &Document, index: Index<json::Camera>, camera: &json::Camera) -> Result<Projection> {
    let wrong = |problem: &str| {
        doc.error(label("camera", index.value(), camera.name.as_deref()), problem, "correct the camera")
    };
    match (&camera.type_, &camera.perspective, &camera.orthographic) {
        (Checked::Valid(Type::Perspective), Some(lens), _) => {
            let (fov_y, near, far) = (f64::from(lens.yfov), f64::from(lens.znear), lens.zfar.map(f64::from));
            if !(fov_y > 0.0 && fov_y < std::f64::consts::PI) {
                return Err(wrong("its yfov is not between 0 and π"));
            }
            if !(near > 0.0 && near.is_finite()) {
                return Err(wrong("its znear is not above 0"));
            }
            if far.is_some_and(|far| !(far > near && far.is_finite())) {
                return Err(wrong("its zfar is not above its znear"));
            }
            Ok(Projection::Perspective { fov_y, near, far })
        }
        (Checked::Valid(Type::Orthographic), _, Some(lens)) => {
            let (y_mag, near, far) = (f64::from(lens.ymag), f64::from(lens.znear), f64::from(lens.zfar));
            if !(y_mag > 0.0 && y_mag.is_finite()) {
                return Err(wrong("its ymag is not above 0"));
            }
            if !(near >= 0.0 && far > near && far.is_finite()) {
                return Err(wrong("its znear is below 0, or its zfar not above its znear"));
            }
            Ok(Projection::Orthographic { y_mag, near, far })
        }
        (Checked::Invalid, ..) => Err(wrong("its type is neither 'perspective' nor 'orthographic'")),
        _ => Err(wrong("has no lens of the type that it names")),
    }
}

fn look_at(eye: DVec3, target: DVec3) -> Result<DAffine3> {
    let back = (eye - target)
        .try_normalize()
        .ok_or_else(|| Error::Usage("the camera's eye and target are not two different points".to_owned()))?;
    // Where the view is vertical, +Y says nothing about what is up in the picture.
    let up = if back.cross(DVec3::Y).length() > 1e-9 { DVec3::Y } else { DVec3::Z * -back.y.signum() };
    Ok(DAffine3 { matrix3: basis(back, up), translation: eye })
}

/// The right-handed orthonormal basis that looks along `-back`, a unit vector, with `up` not parallel to it.
fn basis(back: DVec3, up: DVec3) -> DMat3 {
    let right = up.cross(back).normalize();
    DMat3::from_cols(right, back.cross(right), back)
}

fn checked_fov_y(degrees: f64) -> Result<f64> {
    if degrees > 0.0 && degrees < 180.0 {
        return Ok(degrees.to_radians());
    }
    Err(Error::Usage(format!("a field of view of {degrees} degrees is not between 0 and 180")))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn right_handed(camera: &Camera) -> bool {
        let m = camera.transform.matrix3;
        (m.determinant() - 1.0).abs() < 1e-12 && (m.transpose() * m).abs_diff_eq(DMat3::IDENTITY, 1e-12)
    }

    #[test]
    fn looks_from_the_eye_at_the_target() {
        let (eye, target) = (DVec3::new(1.0, 2.0, 3.0), DVec3::new(-1.0, 2.5, 0.0));
        let camera = Camera::look_at(eye, target, 60.0).expect("two points");
        assert!(right_handed(&camera));
        let seen = camera.transform.inverse().transform_point3(target);
        assert!(seen.abs_diff_eq(DVec3::new(0.0, 0.0, -eye.distance(target)), 1e-12), "{seen}");
        assert!(camera.transform.matrix3.y_axis.y > 0.0);
    }

    #[test]
    fn straight_down_and_up_are_defined() {
        let down = Camera::look_at(DVec3::Y, DVec3::ZERO, 45.0).expect("two points");
        assert!(right_handed(&down) && down.transform.matrix3.y_axis.abs_diff_eq(DVec3::NEG_Z, 1e-12));
        let up = Camera::look_at(DVec3::NEG_Y, DVec3::ZERO, 45.0).expect("two points");
        assert!(right_handed(&up) && up.transform.matrix3.y_axis.abs_diff_eq(DVec3::Z, 1e-12));
    }

    #[test]
    fn senseless_cameras_are_wrong_usage() {
        for (eye, target, fov_y) in [
            (DVec3::ONE, DVec3::ONE, 45.0),
            (DVec3::NAN, DVec3::ONE, 45.0),
            (DVec3::ONE, DVec3::INFINITY, 45.0),
            (DVec3::ONE, DVec3::ZERO, 0.0),
            (DVec3::ONE, DVec3::ZERO, 180.0),
            (DVec3::ONE, DVec3::ZERO, f64::NAN),
        ] {
            assert!(matches!(Camera::look_at(eye, target, fov_y), Err(Error::Usage(_))), "{eye} {target} {fov_y}");
        }
    }

    #[test]
    fn overrides_replace_only_what_is_given() {
        let mut camera = Camera::look_at(DVec3::new(0.0, 0.0, 5.0), DVec3::ZERO, 40.0).expect("two points");
        camera.projection = Projection::Perspective { fov_y: 0.7, near: 0.1, far: Some(9.0) };

        let moved = camera.overridden(Some(DVec3::ONE), None, None).expect("finite");
        assert_eq!(moved.transform.matrix3, camera.transform.matrix3);
        assert_eq!(moved.transform.translation, DVec3::ONE);
        assert!(matches!(moved.projection, Projection::Perspective { far: None, near: 0.1, .. }));

        let turned = camera.overridden(None, Some(DVec3::X), Some(90.0)).expect("finite");
        assert_eq!(turned.transform.translation, camera.transform.translation);
        assert!(turned.transform.inverse().transform_point3(DVec3::X).truncate().length() < 1e-12);
        let Projection::Perspective { fov_y, far, .. } = turned.projection else { panic!("still perspective") };
        assert_eq!((fov_y, far), (90_f64.to_radians(), Some(9.0)));

        assert!(camera.overridden(Some(DVec3::X), Some(DVec3::X), None).is_err());
        assert!(camera.overridden(Some(DVec3::NAN), None, None).is_err());
        camera.projection = Projection::Orthographic { y_mag: 1.0, near: 0.0, far: 1.0 };
        assert!(matches!(camera.overridden(None, None, Some(40.0)), Err(Error::Usage(_))));
    }

    #[test]
    fn the_frame_holds_every_corner() {
        for aspect in [0.3, 1.0, 16.0 / 9.0] {
            let (low, high) = (DVec3::new(-3.0, 1.0, 2.0), DVec3::new(1.0, 1.5, 40.0));
            let camera = frame((low, high), aspect);
            let Projection::Perspective { fov_y, near, .. } = camera.projection else { panic!("perspective") };
            for corner in 0..8 {
                let pick = |axis: usize| {
                    if corner >> axis & 1 == 0 { low[axis] } else { high[axis] }
                };
                let world = DVec3::new(pick(0), pick(1), pick(2));
                let seen = camera.transform.inverse().transform_point3(world);
                let tangent = (fov_y / 2.0).tan();
                assert!(-seen.z > near);
                assert!(seen.y.abs() <= -seen.z * tangent && seen.x.abs() <= -seen.z * tangent * aspect);
            }
        }
        assert!(frame((DVec3::ONE, DVec3::ONE), 1.0).transform.is_finite());
    }
}
