//! Where a light's maps look: the lens of each, in f64.
//!
//! A directional light's maps follow the camera. Its view is cut into slices (practical split scheme: Zhang, Sun, Xu and
//! Lun, "Parallel-Split Shadow Maps", 2006); each map holds the sphere around its slice, whose size does not change as
//! the camera turns, and moves by whole texels only ("Stable Rendering of Cascaded Shadow Maps", Valient 2007). So a
//! still surface is sampled at the same points in every frame, and no shadow edge crawls.

use glam::{DAffine3, DMat3, DVec3};

use crate::scene::{Camera, Light, LightKind, Projection};

/// Texels at a map's border that hold nothing: a filter's neighbours, and what snapping to texels moves.
const MARGIN: f64 = 2.0;

/// Half angle of a cone that one map still holds, radians; wider ones take the faces of a cube.
const WIDEST_CONE: f64 = 1.05;

/// Nearest depth of a lamp's maps, in radii of the scene. What is nearer to the lamp casts no shadow.
const LAMP_NEAR: f64 = 1e-4;

/// Steps to the power of two in which the distance that cascades share follows the camera, so that they keep their size.
const DISTANCE_STEPS: f64 = 4.0;

/// A sphere in the world.
#[derive(Clone, Copy, Debug)]
pub struct Sphere {
    /// Its middle.
    pub center: DVec3,
    /// Its radius.
    pub radius: f64,
}

/// The most maps of a light, given how many a directional one may have.
pub fn most_maps(light: &Light, cascades: u32) -> u32 {
    match light.kind {
        LightKind::Directional => cascades,
        LightKind::Spot { outer, .. } if outer <= WIDEST_CONE => 1,
        LightKind::Spot { .. } | LightKind::Point => 6,
    }
}

/// The cameras that see what the light sees of `scene`, onto `size` texels a side, the finest first: as many as
/// [`most_maps`], or fewer where one holds all. `camera` and the `aspect` of its picture matter to a directional light.
pub fn lenses(light: &Light, cascades: u32, size: u32, camera: &Camera, aspect: f64, scene: Sphere) -> Vec<Camera> {
    // What is to be held, as a part of what the whole map holds.
    let used = 1.0 - 2.0 * MARGIN / f64::from(size);
    let to_lamp = (light.position - scene.center).length();
    let near = (to_lamp - scene.radius).max(LAMP_NEAR * scene.radius);
    let lamp = |direction: DVec3, half_angle: f64| Camera {
        transform: DAffine3 { matrix3: axes(direction), translation: light.position },
        projection: Projection::Perspective { fov_y: 2.0 * (half_angle.tan() / used).atan(), near, far: None },
    };
    match light.kind {
        LightKind::Directional => {
            let mut maps = Vec::new();
            for slice in slices(camera, aspect, cascades, scene) {
                let held = if slice.radius < scene.radius { slice } else { scene };
                maps.push(parallel(light.direction, held, scene, size, used));
                if slice.radius >= scene.radius {
                    break;
                }
            }
            maps
        }
        LightKind::Spot { outer, .. } if outer <= WIDEST_CONE => vec![lamp(light.direction, outer)],
        LightKind::Spot { .. } | LightKind::Point => {
            let faces = [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];
            faces.map(|face| lamp(face, std::f64::consts::FRAC_PI_4)).to_vec()
        }
    }
}

/// Right, up and back of a camera that looks along `forward`.
fn axes(forward: DVec3) -> DMat3 {
    let up = if forward.y.abs() < 0.9 { DVec3::Y } else { DVec3::X };
    let right = forward.cross(up).normalize();
    DMat3::from_cols(right, right.cross(forward), -forward)
}

/// A camera of parallel rays that holds one sphere, from before `scene` to behind it: nothing that casts is cut away.
fn parallel(direction: DVec3, held: Sphere, scene: Sphere, size: u32, used: f64) -> Camera {
    let axes = axes(direction);
    let y_mag = held.radius / used;
    let texel = 2.0 * y_mag / f64::from(size);
    let snapped = |axis: DVec3| (axis.dot(held.center) / texel).round() * texel * axis;
    // Room on both sides for rounding, and so that the near plane cuts no shell.
    let room = 0.05 * scene.radius;
    let start = direction.dot(scene.center) - scene.radius - 2.0 * room;
    Camera {
        transform: DAffine3 {
            matrix3: axes,
            translation: snapped(axes.x_axis) + snapped(axes.y_axis) + start * direction,
        },
        projection: Projection::Orthographic { y_mag, near: room, far: 2.0 * scene.radius + 3.0 * room },
    }
}

/// Spheres around the slices of the camera's view, the nearest first.
fn slices(camera: &Camera, aspect: f64, count: u32, scene: Sphere) -> Vec<Sphere> {
    let eye = camera.transform.translation;
    let forward = -camera.transform.matrix3.z_axis;
    let distance = (scene.center - eye).length();
    let (lens_near, lens_far) = match camera.projection {
        Projection::Perspective { near, far, .. } => (near, far.unwrap_or(f64::INFINITY)),
        Projection::Orthographic { near, far, .. } => (near, far),
    };
    // Distances, not depths: turning the camera changes nothing.
    let stepped = |x: f64, round: fn(f64) -> f64| (round(x.log2() * DISTANCE_STEPS) / DISTANCE_STEPS).exp2();
    let far = stepped(distance + scene.radius, f64::ceil).min(lens_far);
    let near = stepped((distance - scene.radius).max(1e-3 * scene.radius), f64::floor).max(lens_near).min(far);
    let split = |i: u32| {
        let part = f64::from(i) / f64::from(count);
        0.5 * (near * (far / near).powf(part) + near + (far - near) * part)
    };
    let slice = |i: u32| {
        let (from, to) = (split(i), split(i + 1));
        // From the axis to the picture's corner, where it is `depth` away.
        let aside = |depth: f64| match camera.projection {
            Projection::Perspective { fov_y, .. } => depth * (0.5 * fov_y).tan() * aspect.hypot(1.0),
            Projection::Orthographic { y_mag, .. } => y_mag * aspect.hypot(1.0),
        };
        // Where corners of both ends are equally far, unless that lies beyond the slice.
        let (a, b) = (aside(from), aside(to));
        let middle = (0.5 * (from + to) + 0.5 * (b * b - a * a) / (to - from).max(1e-12 * to)).min(to);
        let radius = a.hypot(middle - from).max(b.hypot(to - middle));
        Sphere { center: eye + middle * forward, radius }
    };
    (0..count).map(slice).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sun() -> Light {
        Light {
            intensity: DVec3::ONE,
            position: DVec3::ZERO,
            direction: DVec3::new(0.4, -0.8, 0.2).normalize(),
            range: None,
            kind: LightKind::Directional,
        }
    }

    fn camera(eye: DVec3, target: DVec3) -> Camera {
        Camera::look_at(eye, target, 50.0).unwrap()
    }

    const SCENE: Sphere = Sphere { center: DVec3::new(3.0, 0.0, -5.0), radius: 40.0 };

    fn y_mag(camera: &Camera) -> f64 {
        let Projection::Orthographic { y_mag, .. } = camera.projection else { panic!("{camera:?}") };
        y_mag
    }

    /// As the camera moves and turns, each map keeps its size and moves by whole texels.
    #[test]
    fn maps_move_by_whole_texels() {
        let lenses = |eye, target| lenses(&sun(), 3, 256, &camera(eye, target), 1.6, SCENE);
        let still = lenses(DVec3::new(0.0, 2.0, 9.0), DVec3::ZERO);
        assert_eq!(still.len(), 3);
        let mut moved = 0;
        for step in 1..20 {
            let by = 0.013 * f64::from(step);
            let now = lenses(DVec3::new(by, 2.0 + 0.5 * by, 9.0), DVec3::new(3.0 * by, by, 0.0));
            for (a, b) in still.iter().zip(&now) {
                assert_eq!((a.projection, a.transform.matrix3), (b.projection, b.transform.matrix3));
                let texel = 2.0 * y_mag(a) / 256.0;
                let away = a.transform.matrix3.transpose() * (b.transform.translation - a.transform.translation);
                let texels = away / texel;
                assert!((texels - texels.round()).truncate().length() < 1e-6 && away.z.abs() < 1e-9, "{texels}");
                moved += u32::from(texels.round() != DVec3::ZERO);
            }
        }
        assert!(moved > 10, "{moved}: the camera did not move far enough to tell");
    }

    /// Every point of the scene that the camera sees lies in some map, and in the nearest slice's where that reaches.
    #[test]
    fn what_is_seen_is_mapped() {
        let camera = camera(DVec3::new(0.0, 2.0, 9.0), DVec3::new(1.0, 0.0, 0.0));
        let lenses = lenses(&sun(), 3, 256, &camera, 1.6, SCENE);
        assert!(lenses.windows(2).all(|w| y_mag(&w[0]) < y_mag(&w[1])), "finest first");
        let mut finest = [0; 3];
        for i in 0..4000 {
            let unit = |k: u32| f64::from(i * (7919 + 2 * k) % (997 + 2 * k)) / f64::from(997 + 2 * k);
            let depth = 0.1 + 60.0 * unit(0);
            let up = 25f64.to_radians().tan() * depth;
            let local = DVec3::new((2.0 * unit(1) - 1.0) * 1.6 * up, (2.0 * unit(2) - 1.0) * up, -depth);
            let point = camera.transform.transform_point3(local);
            if point.distance(SCENE.center) > SCENE.radius {
                continue;
            }
            let holds = |lens: &Camera| {
                let at = lens.transform.inverse().transform_point3(point);
                let Projection::Orthographic { near, far, .. } = lens.projection else { panic!() };
                at.truncate().abs().max_element() < y_mag(lens) * (1.0 - 2.0 / 256.0) && (near..far).contains(&-at.z)
            };
            let first = lenses.iter().position(holds);
            finest[first.unwrap_or_else(|| panic!("{point} is in no map"))] += 1;
        }
        assert!(finest.iter().all(|n| *n > 20), "{finest:?}");
    }
}
