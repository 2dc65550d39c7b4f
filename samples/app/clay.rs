//! A surface in clay: shaded from its normals alone, so that a GPU's and the reference's look alike where they are.

use glam::{DVec3, Vec3};
use prism_engine::{aov::Aov, scene::Camera};

use super::picture::Picture;

/// Toward the light of the clay, in the camera's own directions: from the upper left, so that relief is seen.
const TO_LIGHT: DVec3 = DVec3::new(-0.5, 0.65, 0.57);
/// Behind the clay, sRGB.
pub const BEHIND: [u8; 3] = [62, 67, 75];

/// Matt grey under a light that goes with the camera: nothing but the surface's own normal, and the same formula for
/// both of them.
pub fn of(aov: &Aov, camera: &Camera) -> Picture {
    let to_light = (camera.transform.matrix3 * TO_LIGHT).normalize().as_vec3();
    Picture::of([aov.width, aov.height], |i| {
        if !aov.depth[i].is_finite() {
            return BEHIND;
        }
        // Half Lambert: what is turned away from the light keeps its relief.
        let facing = 0.5 + 0.5 * Vec3::from(aov.normal[i]).dot(to_light);
        let light = 0.02 + 0.7 * facing * facing;
        // sRGB's curve is nearly this power.
        [(255.0 * light.powf(1.0 / 2.2)).round() as u8; 3]
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DAffine3;
    use prism_engine::scene::Projection;

    fn camera() -> Camera {
        let projection = Projection::Perspective { fov_y: 1.0, near: 0.1, far: None };
        Camera { transform: DAffine3::IDENTITY, projection }
    }

    #[test]
    fn clay_is_bright_toward_the_light_and_black_nowhere() {
        let normals = [TO_LIGHT.as_vec3().normalize(), Vec3::Z, -TO_LIGHT.as_vec3(), Vec3::ZERO];
        let mut aov = Aov::missed(4, 1);
        (aov.depth, aov.normal) = (vec![1.0, 1.0, 1.0, f32::INFINITY], normals.map(|n| n.to_array()).to_vec());
        let grey: Vec<u8> = of(&aov, &camera()).pixels.iter().map(|p| p[0]).collect();
        assert!(grey[0] > grey[1] && grey[1] > grey[2] && grey[2] > 20, "{grey:?}");
        assert_eq!(grey[3], BEHIND[0]);
    }
}
