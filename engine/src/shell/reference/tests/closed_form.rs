//! Surfaces whose hits are known in closed form.

use super::*;
use crate::{
    aov::Aov,
    scene::{Light, LightKind},
};

fn assert_near(a: DVec3, b: DVec3, tolerance: f64) {
    assert!(a.distance(b) < tolerance, "{a} is not {b} within {tolerance}");
}

/// Rays straight down onto the square: hits at (x, y, height).
fn down(reference: &Reference, x: f64, y: f64) -> super::super::Hit {
    reference.trace(DVec3::new(x, y, 5.0), -DVec3::Z, 0.0).unwrap_or_else(|| panic!("nothing at {x}, {y}"))
}

#[test]
fn a_constant_map_is_a_flat_sheet_at_its_height() {
    for (midlevel, h, z) in [(0.5, 1.0, 0.15), (0.0, 1.0, 0.3), (1.0, 0.0, -0.3), (1.0, 1.0, 0.0), (0.0, 0.0, 0.0)] {
        let scene = scene(square(), Some(displacement(0.3, midlevel)), map(4, 4, |_, _| h));
        let reference = Reference::new(&scene);
        // The diagonal and the texel borders included.
        for (x, y) in [(0.0, 0.0), (0.25, 0.25), (-0.3, 0.7), (0.999, -0.999)] {
            let hit = down(&reference, x, y);
            assert_near(hit.position, DVec3::new(x, y, z), 1e-12);
            assert_near(hit.normal, DVec3::Z, 1e-12);
            assert!((hit.distance - (5.0 - z)).abs() < 1e-12 && (hit.height - h).abs() < 1e-9);
            assert!((hit.uv.x - (x + 1.0) / 2.0).abs() < 1e-12 && (hit.uv.y - (y + 1.0) / 2.0).abs() < 1e-12);
        }
        assert!(reference.trace(DVec3::new(1.01, 0.0, 5.0), -DVec3::Z, 0.0).is_none());
        assert!(reference.trace(DVec3::new(0.1, 0.2, -5.0), DVec3::Z, 0.0).is_none(), "a sheet's back is not seen");
        assert!(reference.trace(DVec3::new(0.1, 0.2, 5.0), -DVec3::Z, 5.0 - z + 1e-9).is_none(), "behind t_min");
    }
}

#[test]
fn scale_zero_and_no_displacement_are_plain() {
    for displacement in [None, Some(displacement(0.0, 0.25))] {
        let height = displacement.map_or(0.5, |d| d.midlevel);
        let hit = down(&Reference::new(&scene(square(), displacement, map(2, 2, |x, _| f64::from(x)))), 0.3, 0.1);
        assert_near(hit.position, DVec3::new(0.3, 0.1, 0.0), 1e-14);
        assert!(hit.height == height && hit.t == 0.0);
    }
}

#[test]
fn a_two_texel_ramp_is_a_slope_with_its_normal_even_for_grazing_rays() {
    // Texel centres at u = 1/4 and 3/4, that is x = -1/2 and 1/2: z = 0.4 (x + 1/2) between them.
    let reference = Reference::new(&scene(square(), Some(displacement(0.4, 0.0)), map(2, 1, |x, _| f64::from(x))));
    let n = DVec3::new(-0.4, 0.0, 1.0).normalize();
    let mut random = Random(3);
    for _ in 0..2000 {
        let at = DVec3::new(random.within(-0.45, 0.45), random.within(-0.9, 0.9), 0.0);
        let on = DVec3::new(at.x, at.y, 0.4 * (at.x + 0.5));
        let mut toward = random.direction();
        toward -= n * (toward.dot(n) + random.within(0.001, 1.0).powi(2));
        let origin = on - toward * 0.01;
        let hit = reference.trace(origin, toward, 0.0).expect("the slope");
        assert_near(hit.position, on, 1e-10);
        assert_near(hit.normal, n, 1e-10);
    }
}

#[test]
fn wrap_modes_differ_outside_the_first_tile() {
    let mut mesh = square();
    mesh.primitives[0].uvs[0].iter_mut().for_each(|uv| *uv = *uv * 4.0 - 1.0);
    let ramp = || map(4, 1, |x, _| f64::from(x) / 3.0);
    let at = |wrap: Wrap, u: f64| {
        let d = Displacement { wrap: [wrap; 2], ..displacement(1.0, 0.0) };
        let reference = Reference::new(&scene(mesh.clone(), Some(d), ramp()));
        (down(&reference, (u + 1.0) / 2.0 - 1.0, 0.1).position.z * 3.0 * 1e8).round() / 1e8
    };
    assert_eq!([Wrap::Repeat, Wrap::Mirror, Wrap::Clamp].map(|w| at(w, 1.125)), [0.0, 3.0, 3.0]);
    assert_eq!([Wrap::Repeat, Wrap::Mirror, Wrap::Clamp].map(|w| at(w, -0.375)), [2.0, 1.0, 0.0]);
    assert_eq!([Wrap::Repeat, Wrap::Mirror, Wrap::Clamp].map(|w| at(w, 2.5)), [1.5, 1.5, 3.0]);
}

#[test]
fn relative_scale_follows_the_areas_and_transforms_move_the_map() {
    // Mesh area 4, UV area 1: the ratio's root is 2.
    let d = Displacement { relative: true, ..displacement(0.1, 0.0) };
    let hit = down(&Reference::new(&scene(square(), Some(d), map(1, 1, |_, _| 1.0))), 0.2, 0.1);
    assert!((hit.position.z - 0.2).abs() < 1e-12, "a map of one texel is constant");
    let turn = DAffine2::from_scale_angle_translation(glam::DVec2::new(2.0, 1.0), 0.0, glam::DVec2::new(0.25, 0.0));
    let d = Displacement { transform: turn, ..displacement(0.3, 0.0) };
    let hit = down(&Reference::new(&scene(square(), Some(d), map(2, 1, |x, _| f64::from(x)))), 0.0, 0.1);
    // u = 0.5 becomes 1.25: texel 0 of the next tile.
    assert!(hit.position.z.abs() < 1e-12 && (hit.uv.x - 0.5).abs() < 1e-12);
}

#[test]
fn a_constant_height_offsets_a_closed_mesh_along_its_shell_normals() {
    let c = 0.11;
    let reference = Reference::new(&scene(torus(16, 10), Some(displacement(c, 0.0)), map(1, 1, |_, _| 1.0)));
    let mut lifted = torus(16, 10);
    let normals = super::super::fold::Weld::new(&lifted);
    for (v, p) in lifted.primitives[0].positions.iter_mut().enumerate() {
        *p = (p.as_dvec3() + c * normals.normals[normals.ids[0][v]]).as_vec3();
    }
    let plain = Reference::new(&scene(lifted, None, map(1, 1, |_, _| 1.0)));
    let mut random = Random(5);
    let mut both = 0;
    for _ in 0..3000 {
        let origin = random.direction() * 4.0;
        let target = random.direction() * random.within(0.0, 1.5);
        let hits = [&reference, &plain].map(|r| r.trace(origin, target - origin, 0.0));
        if let [Some(a), Some(b)] = &hits {
            both += 1;
            // The plain mesh holds its lifted corners in f32.
            assert!(a.position.distance(b.position) < 2e-5 && a.normal.distance(b.normal) < 1e-5, "{a:?} {b:?}");
        } else {
            assert!(hits.iter().all(Option::is_none));
        }
    }
    assert!(both > 1000);
}

#[test]
fn mirrored_sheared_and_distant_nodes_transform_the_result() {
    let d = Some(displacement(0.2, 0.3));
    let bumps = || map(8, 8, |x, y| f64::from((3 * x + 5 * y) % 8) / 7.0);
    let base = Reference::new(&scene(square(), d, bumps()));
    let shear = DAffine3::from_cols_array(&[1.0, 0.0, 0.2, 0.4, 1.5, 0.0, 0.0, -0.3, 0.7, 3.0, -1.0, 2.0]);
    let mirror = DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0));
    let far = DAffine3::from_translation(DVec3::new(20_000.0, -20_000.0, 5_000.0));
    for (place, tolerance) in [(shear, 1e-12), (mirror, 1e-12), (far * shear * mirror, 5e-11)] {
        let mut moved = scene(square(), d, bumps());
        moved.instances[0].transform = place;
        let moved = Reference::new(&moved);
        let mut random = Random(9);
        for _ in 0..500 {
            let origin = DVec3::new(random.within(-1.0, 1.0), random.within(-1.0, 1.0), 1.0);
            let target = DVec3::new(random.within(-1.0, 1.0), random.within(-1.0, 1.0), 0.0);
            let Some(a) = base.trace(origin, target - origin, 0.0) else { continue };
            let way = place.transform_vector3(target - origin);
            let b = moved.trace(place.transform_point3(origin), way, 0.0).expect("the same surface");
            assert!((a.distance - b.distance).abs() < tolerance, "{} {}", a.distance, b.distance);
            assert_near(b.position, place.transform_point3(a.position), tolerance);
            assert_near(b.normal, (place.matrix3.inverse().transpose() * a.normal).normalize(), 1e-8);
            assert!(b.normal.dot(way) < 0.0);
        }
    }
}

#[test]
fn a_frame_puts_pixels_planes_and_channels_where_they_belong() {
    let mut scene = scene(square(), Some(displacement(0.3, 0.0)), map(1, 1, |_, _| 1.0));
    scene.lights = vec![Light {
        intensity: DVec3::ONE,
        position: DVec3::ZERO,
        direction: -DVec3::Z,
        range: None,
        kind: LightKind::Directional,
    }];
    let reference = Reference::new(&scene);
    let transform = DAffine3::from_translation(DVec3::new(0.0, 0.0, 2.0));
    let ortho = |near, far| Camera { transform, projection: Projection::Orthographic { y_mag: 2.0, near, far } };
    let aov = reference.render(&ortho(0.1, 10.0), 8, 4, Shadows::Trace);
    // Pixels are one unit wide; rows 1 and 2 and columns 3 and 4 look at the square.
    for i in 0..32 {
        let (x, y) = (f32::from(i as u16 % 8) - 3.5, 1.5 - f32::from(i as u16 / 8));
        if x.abs() < 1.0 && y.abs() < 1.0 {
            assert!((aov.depth[i] - 1.7).abs() < 1e-6 && aov.shadow[i] == 1.0);
            assert_eq!(aov.position[i].map(|v| (v * 1e5).round() / 1e5), [x, y, 0.3]);
            assert_eq!(aov.normal[i], [0.0, 0.0, 1.0]);
            assert!((aov.height_at_hit[i] - 1.0).abs() < 1e-6 && (aov.uv[i][0] - (x + 1.0) / 2.0).abs() < 1e-6);
        } else {
            assert!(aov.depth[i] == f32::INFINITY && aov.shadow[i] == 1.0 && aov.position[i] == [0.0; 3]);
        }
    }
    for planes in [(1.71, 10.0), (0.1, 1.69)] {
        assert_eq!(reference.render(&ortho(planes.0, planes.1), 8, 4, Shadows::Skip), Aov::missed(8, 4));
    }
    // Perspective: depth is along the axis, whatever the pixel.
    let wide = Camera { transform, projection: Projection::Perspective { fov_y: 1.0, near: 0.1, far: None } };
    let aov = reference.render(&wide, 9, 7, Shadows::Skip);
    assert!(aov.depth.iter().all(|z| *z == f32::INFINITY || (*z - 1.7).abs() < 1e-6));
    let half = (0.5f64).tan();
    assert!((f64::from(aov.position[3 * 9 + 6][0]) - 4.0 / 7.0 * half * 1.7).abs() < 1e-6);
}

#[test]
fn a_ray_inside_a_level_meets_what_stands_in_its_way() {
    // Triangle wave along x, 0 to 1 and back, texel centres at ±1/2; the ray runs along x at exactly half height.
    let scene = scene(square(), Some(displacement(0.4, 0.0)), map(2, 1, |x, _| f64::from(x)));
    let reference = Reference::new(&scene);
    for tilt in [0.0, 1e-14, -1e-12, 1e-10, -1e-9, 1e-8, -3e-8, 1e-7, 1e-5] {
        // 0.4 (x + 1/2) = 0.2 + tilt (x + 0.9)
        let x = 0.9 * tilt / (0.4 - tilt);
        for (y, slide) in [(0.3, 0.0), (0.0, 0.0), (-0.71, 0.0), (-0.9, 1.0), (0.4, -0.3)] {
            let hit = reference.trace(DVec3::new(-0.9, y, 0.2), DVec3::new(1.0, slide, tilt), 0.0).expect("the rise");
            let expected = DVec3::new(x, y + slide * (x + 0.9), 0.2 + tilt * (x + 0.9));
            assert_near(hit.position, expected, 3e-8);
        }
    }
}
