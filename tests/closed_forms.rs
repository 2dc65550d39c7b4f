//! Surfaces whose pixels can be written down: the program draws hand-written glTF files, and every pixel of its surface
//! data is compared with a formula. Steps and borders are in closed_walls.rs.

mod common;

use std::f64::consts::PI;

use common::{
    Expected, Gltf, Lens, Map, Ray, Shape, WAYS, Wrap, check,
    forms::{
        EXACT, FINE, MARCHES, Sheet, TOLERANCE, aov, both, matrix, nearest, oblique, ramp_scene, sheet_scene, straight,
        wall,
    },
};
use glam::{DAffine3, DMat3, DVec2, DVec3};
use serde_json::json;

#[test]
fn a_flat_sheet_straight_on_with_each_midlevel() {
    for midlevel in [0.0, 0.5, 1.0] {
        let gltf =
            sheet_scene(&Map::eight(1, &[204]), json!({ "scale": 0.4, "midlevel": midlevel }), DAffine3::IDENTITY);
        let sheet = Sheet::flat(0.8, midlevel, 0.4);
        both(&gltf, &straight(), |ray| sheet.at(&straight(), ray));
    }
}

#[test]
fn a_flat_sheet_at_an_angle() {
    // More than one texel, so that the constant comes from filtering too.
    let gltf = sheet_scene(&Map::eight(3, &[51; 6]), json!({ "scale": 0.4, "midlevel": 0.0 }), DAffine3::IDENTITY);
    let sheet = Sheet::flat(0.2, 0.0, 0.4);
    both(&gltf, &oblique(), |ray| sheet.at(&oblique(), ray));
}

#[test]
fn midlevel_is_one_half_unless_said() {
    let gltf = sheet_scene(&Map::eight(1, &[255]), json!({ "scale": 0.4 }), DAffine3::IDENTITY);
    let sheet = Sheet::flat(1.0, 0.5, 0.4);
    both(&gltf, &oblique(), |ray| sheet.at(&oblique(), ray));
}

#[test]
fn sixteen_bits_stay_sixteen_bits() {
    // 8 bits would make it 128 / 255, which is off by 2e-3.
    let gltf = sheet_scene(&Map::sixteen(1, &[32_795]), json!({ "scale": 0.4 }), DAffine3::IDENTITY);
    let sheet = Sheet::flat(32_795.0 / 65_535.0, 0.5, 0.4);
    both(&gltf, &straight(), |ray| sheet.at(&straight(), ray));
}

#[test]
fn a_ramp_in_perspective_and_in_parallel() {
    let (gltf, sheet) = ramp_scene(0.5, 0.4, DAffine3::IDENTITY);
    for lens in [oblique(), oblique().orthographic(1.1), Lens::at([-2.0, 0.7, 1.2], [0.0; 3])] {
        both(&gltf, &lens, |ray| sheet.at(&lens, ray));
    }
}

#[test]
fn a_mirrored_node() {
    let mirror = DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0));
    let (gltf, sheet) = ramp_scene(0.25, 0.4, mirror);
    both(&gltf, &oblique(), |ray| sheet.at(&oblique(), ray));
}

#[test]
fn a_sheared_and_squeezed_node_off_centre() {
    let matrix3 =
        DMat3::from_cols(DVec3::new(0.75, 0.125, 0.0), DVec3::new(-0.25, 1.0, 0.25), DVec3::new(0.5, 0.25, 1.5));
    let transform = DAffine3 { matrix3, translation: DVec3::new(0.125, -0.25, -0.5) };
    let (gltf, sheet) = ramp_scene(0.5, 0.4, transform);
    both(&gltf, &oblique(), |ray| sheet.at(&oblique(), ray));
}

#[test]
fn far_from_the_origin_nothing_shakes() {
    // Exact in f32, and so large that a world-space f32 is good to 6e-5 only. Depth and normal are compared, which do not
    // carry the offset; positions carry it in the f32 of the file itself.
    let away = DVec3::new(1024.0, -512.0, 768.0);
    let (gltf, sheet) = ramp_scene(0.5, 0.4, DAffine3::from_translation(away));
    let eye = DVec3::new(1.5, 1.0, 2.25) + away;
    let lens = Lens::at(eye.to_array(), away.to_array());
    for (way, march) in WAYS.into_iter().zip(MARCHES.into_iter().cycle()) {
        let mut aov = aov(&gltf, &lens, &format!("{way} {march}"));
        let hits = aov.position.iter_mut().zip(&aov.depth).filter(|(_, depth)| depth.is_finite());
        for (position, _) in hits {
            *position = std::array::from_fn(|i| position[i] - away.to_array()[i] as f32);
        }
        let near = Lens { eye: eye - away, ..lens };
        let still = Sheet { transform: DAffine3::IDENTITY, ..sheet };
        check(&aov, &near, 1e-4, |ray| still.at(&near, ray));
    }
}

#[test]
fn hits_nearer_than_the_near_plane_do_not_count() {
    // The ramp comes up to 2.8 from the eye; from 2.95 on it counts.
    let (gltf, sheet) = ramp_scene(0.5, 0.4, DAffine3::IDENTITY);
    let lens = Lens { near: 2.95, ..straight() };
    both(&gltf, &lens, |ray| sheet.at(&lens, ray));
    let lens = Lens { near: 2.7, ..oblique() };
    both(&gltf, &lens, |ray| sheet.at(&lens, ray));
}

#[test]
fn a_camera_inside_the_shell() {
    // The shell reaches from -0.2 to 0.2 everywhere; the eye is in it, just above the ramp.
    let (gltf, sheet) = ramp_scene(0.5, 0.4, DAffine3::IDENTITY);
    let lens = Lens { near: 0.01, ..Lens::at([-0.5, 0.03, 0.0], [1.0, -0.02, 0.1]) };
    both(&gltf, &lens, |ray| sheet.at(&lens, ray));
}

#[test]
fn relative_scale_follows_the_areas() {
    // 4 square units over a quarter of UV space: a factor of 4.
    let mut gltf = Gltf::new();
    let map = Map::eight(1, &[255]);
    let wall = gltf.displaced("wall", &map, [Wrap::Repeat; 2], json!({ "scale": 0.1, "relative": true }));
    let mesh = gltf.mesh("Sheet", &Shape::sheet(1.0, [0.0, 0.0], [0.5, 0.5]), wall);
    gltf.node(json!({ "mesh": mesh }));
    let sheet = Sheet { uv: [DVec2::ZERO, DVec2::splat(0.5)], ..Sheet::flat(1.0, 0.5, 0.4) };
    both(&gltf, &oblique(), |ray| sheet.at(&oblique(), ray));
}

/// The welded cube's faces stay planes: each corner moves along its diagonal.
fn cube(ray: &Ray, half: f64, height: f64) -> Option<Expected> {
    let faces = (0..6).map(|face| {
        let (axis, sign) = (face / 2, if face % 2 == 0 { 1.0 } else { -1.0 });
        let unit = |axis: usize| DVec3::AXES[axis % 3];
        let (normal, right, down) = (sign * unit(axis), sign * unit(axis + 1), -unit(axis + 2));
        wall(ray, half * normal, normal, |p| {
            let (a, b) = (p.dot(right) / half, p.dot(down) / half);
            let inside = a.abs() <= 1.0 && b.abs() <= 1.0;
            inside.then_some((DVec2::new(a + 1.0, b + 1.0) / 2.0, height))
        })
    });
    nearest(faces)
}

#[test]
fn a_welded_cube_grows_and_shrinks_without_a_gap() {
    for (midlevel, lens) in [(0.0, Lens::at([2.5, 1.8, 3.5], [0.0; 3])), (1.0, Lens::at([-3.0, -1.2, 2.6], [0.0; 3]))] {
        let mut gltf = Gltf::new();
        let map = Map::eight(1, &[153]);
        let wall = gltf.displaced("wall", &map, [Wrap::Repeat; 2], json!({ "scale": 0.3, "midlevel": midlevel }));
        let mesh = gltf.mesh("Cube", &Shape::cube(1.0), wall);
        gltf.node(json!({ "mesh": mesh }));
        let half = 1.0 + (0.6 - midlevel) * 0.3 / 3f64.sqrt();
        both(&gltf, &lens, |ray| cube(ray, half, 0.6));
    }
}

/// A sheet with UV beyond the map on all sides, seen from straight above with parallel rays, so that the height at a pixel
/// is the height at its own UV.
fn above(map: &Map, wrap: [Wrap; 2], uv: [DVec2; 2], place: impl Fn(DVec2) -> DVec2, ray: &Ray) -> Option<Expected> {
    let (x, y) = (ray.origin.x, ray.origin.y);
    let whole = |p: DVec2| uv[0] + (uv[1] - uv[0]) * DVec2::new(p.x + 1.0, 1.0 - p.y) / 2.0;
    let h = |x: f64, y: f64| map.at(place(whole(DVec2::new(x, y))), wrap);
    // Within a cell the surface is smooth, and pixels at a cell's edge are not judged.
    let e = 1e-7;
    let slope = DVec2::new(h(x + e, y) - h(x - e, y), h(x, y + e) - h(x, y - e)) * 0.1 / (2.0 * e);
    let inside = x.abs() <= 1.0 && y.abs() <= 1.0;
    let height = h(x, y);
    inside.then(|| Expected {
        depth: 3.0 - (height - 0.5) * 0.1,
        normal: DVec3::new(-slope.x, -slope.y, 1.0).normalize(),
        uv: whole(DVec2::new(x, y)),
        height,
        plain: false,
    })
}

fn above_scene(map: &Map, wrap: [Wrap; 2], uv: [[f32; 2]; 2]) -> Gltf {
    let mut gltf = Gltf::new();
    let wall = gltf.displaced("wall", map, wrap, json!({ "scale": 0.1 }));
    let mesh = gltf.mesh("Sheet", &Shape::sheet(1.0, uv[0], uv[1]), wall);
    gltf.node(json!({ "mesh": mesh }));
    gltf
}

/// Ends of the UV that put no pixel on a cell's edge.
const BEYOND: [[f32; 2]; 2] = [[-1.313, -0.877], [2.171, 1.931]];

fn beyond() -> [DVec2; 2] {
    BEYOND.map(|uv| DVec2::new(f64::from(uv[0]), f64::from(uv[1])))
}

#[test]
fn each_wrap_mode() {
    let map = Map::noise(5, 4);
    for wrap in [[Wrap::Repeat; 2], [Wrap::Mirror; 2], [Wrap::Clamp; 2], [Wrap::Clamp, Wrap::Mirror]] {
        println!("{wrap:?}");
        let gltf = above_scene(&map, wrap, BEYOND);
        let lens = straight().orthographic(1.05);
        both(&gltf, &lens, |ray| above(&map, wrap, beyond(), |uv| uv, ray));
    }
}

#[test]
fn each_wrap_mode_on_the_base_surface() {
    let map = Map::noise(5, 4);
    let lens = straight().orthographic(1.05);
    let pom = "--march pom --min-steps 64 --max-steps 64";
    let wraps = [[Wrap::Repeat, Wrap::Mirror], [Wrap::Mirror, Wrap::Clamp], [Wrap::Clamp, Wrap::Repeat]];
    for (wrap, march) in wraps.into_iter().zip([EXACT, FINE, pom]) {
        println!("{wrap:?} {march}");
        let gltf = above_scene(&map, wrap, BEYOND);
        let aov = aov(&gltf, &lens, &format!("--shell off {march}"));
        check(&aov, &lens, TOLERANCE, |ray| above(&map, wrap, beyond(), |uv| uv, ray));
    }
}

#[test]
fn the_height_texture_s_own_transform() {
    // KHR_texture_transform: T · R · S, where a positive rotation turns the coordinates counter-clockwise as they are
    // seen, with v down. The specification's example, "the lower left quadrant of the image": offset (0, 1), a quarter
    // turn and scale ½ take (0..1)² to (0..½) × (½..1).
    let quadrant = |uv: DVec2| DVec2::new(0.5 * uv.y, 1.0 - 0.5 * uv.x);
    let example = texture_transform([0.0, 1.0], PI / 2.0, [0.5, 0.5]);
    assert!(example(DVec2::new(0.3, 0.6)).abs_diff_eq(quadrant(DVec2::new(0.3, 0.6)), 1e-12));
    let (offset, rotation, scale) = ([0.37, -0.21], 0.4, [1.7, 0.6]);
    let map = Map::noise(4, 5);
    let mut gltf = above_scene(&map, [Wrap::Repeat; 2], BEYOND);
    let transform = json!({ "KHR_texture_transform": { "offset": offset, "rotation": rotation, "scale": scale } });
    gltf.set("/materials/0/extras/displacement/texture/extensions", transform);
    gltf.set("/extensionsUsed", json!(["KHR_texture_transform"]));
    let lens = straight().orthographic(1.05);
    let place = texture_transform(offset, rotation, scale);
    // The UV of the surface data is the one in the file, which every texture shares.
    both(&gltf, &lens, |ray| above(&map, [Wrap::Repeat; 2], beyond(), &place, ray));
}

fn texture_transform(offset: [f64; 2], rotation: f64, scale: [f64; 2]) -> impl Fn(DVec2) -> DVec2 {
    let (s, c) = rotation.sin_cos();
    move |uv| {
        let (u, v) = (uv.x * scale[0], uv.y * scale[1]);
        DVec2::new(c * u + s * v + offset[0], -s * u + c * v + offset[1])
    }
}

#[test]
fn the_second_uv_set() {
    let map = Map::noise(5, 4);
    let mut gltf = above_scene(&map, [Wrap::Repeat; 2], [[0.0, 0.0], [1.0, 1.0]]);
    let second = gltf.floats(&Shape::sheet(1.0, BEYOND[0], BEYOND[1]).uvs);
    gltf.set("/meshes/0/primitives/0/attributes/TEXCOORD_1", json!(second));
    gltf.set("/materials/0/extras/displacement/texture/texCoord", json!(1));
    let lens = straight().orthographic(1.05);
    both(&gltf, &lens, |ray| above(&map, [Wrap::Repeat; 2], beyond(), |uv| uv, ray));
}

/// A plain sheet, at a scale of its own.
fn add_plain(gltf: &mut Gltf, transform: DAffine3) -> Sheet {
    let material = gltf.plain("plain");
    let mesh = gltf.mesh("Plain", &Shape::sheet(1.0, [0.0, 0.0], [1.0, 1.0]), material);
    gltf.node(json!({ "name": "plain", "mesh": mesh, "matrix": matrix(transform) }));
    // A plain surface is at its midlevel, and no z changes that.
    Sheet { transform, height: [0.5, 0.0], ..Sheet::flat(0.5, 0.5, 1.0) }
}

#[test]
fn a_plain_object_that_cuts_through() {
    let (mut gltf, sheet) = ramp_scene(0.5, 0.4, DAffine3::IDENTITY);
    let tilt = DAffine3::from_translation(DVec3::new(0.0, 0.125, 0.03125)) * DAffine3::from_rotation_x(-0.5);
    let plain = add_plain(&mut gltf, tilt * DAffine3::from_scale(DVec3::splat(0.75)));
    both(&gltf, &oblique(), |ray| nearest([sheet.at(&oblique(), ray), plain.at(&oblique(), ray)]));
}

#[test]
fn a_one_sided_sheet_is_not_there_from_behind() {
    for double_sided in [false, true] {
        let (mut gltf, sheet) = ramp_scene(0.5, 0.4, DAffine3::IDENTITY);
        gltf.set("/materials/0/doubleSided", json!(double_sided));
        let sheet = Sheet { double_sided, ..sheet };
        // Beyond it, seen from below, a plain sheet that looks this way.
        let turned = DAffine3::from_translation(DVec3::new(0.25, 0.125, 1.0)) * DAffine3::from_rotation_y(PI);
        let plain = add_plain(&mut gltf, turned);
        let lens = Lens::at([0.7, 0.4, -2.5], [0.0; 3]);
        both(&gltf, &lens, |ray| nearest([sheet.at(&lens, ray), plain.at(&lens, ray)]));
    }
}

#[test]
fn scale_zero_is_a_plain_surface() {
    let displacement = json!({ "scale": 0.0, "midlevel": 0.25 });
    let gltf = sheet_scene(&Map::noise(4, 4), displacement, DAffine3::IDENTITY);
    let sheet = Sheet { height: [0.25, 0.0], ..Sheet::flat(0.25, 0.25, 1.0) };
    both(&gltf, &oblique(), |ray| sheet.at(&oblique(), ray));
}

#[test]
fn a_base_surface_with_inward_detail() {
    // The plane lies 0.2 under the sheet. A fragment of the sheet is drawn if its ray still is over the sheet there.
    let gltf = sheet_scene(&Map::eight(1, &[127]), json!({ "scale": 0.4, "midlevel": 1.0 }), DAffine3::IDENTITY);
    let sheet = Sheet::flat(127.0 / 255.0, 1.0, 0.4);
    let base = Sheet::flat(0.5, 0.5, 0.4);
    let lens = oblique();
    for march in MARCHES {
        let aov = aov(&gltf, &lens, &format!("--shell off {march} --silhouette uv-bounds"));
        check(&aov, &lens, TOLERANCE, |ray| base.at(&lens, ray).and_then(|_| sheet.at(&lens, ray)));
    }
}

#[test]
fn a_base_surface_that_is_not_marched() {
    let gltf = sheet_scene(&Map::noise(4, 4), json!({ "scale": 0.4, "midlevel": 0.75 }), DAffine3::IDENTITY);
    let base = Sheet { height: [0.75, 0.0], ..Sheet::flat(0.75, 0.75, 1.0) };
    for march in ["none", "normal"] {
        let aov = aov(&gltf, &oblique(), &format!("--shell off --march {march}"));
        check(&aov, &oblique(), TOLERANCE, |ray| base.at(&oblique(), ray));
    }
}

#[test]
fn without_depth_offset_the_base_surface_keeps_its_depth() {
    let gltf = sheet_scene(&Map::eight(1, &[127]), json!({ "scale": 0.4, "midlevel": 1.0 }), DAffine3::IDENTITY);
    let base = Sheet::flat(0.5, 0.5, 0.4);
    let lens = oblique();
    let aov = aov(&gltf, &lens, &format!("--shell off {FINE} --depth-offset off"));
    let mut hits = 0;
    for (i, depth) in aov.depth.iter().enumerate().filter(|(_, depth)| depth.is_finite()) {
        let (x, y) = (i as u32 % aov.width, i as u32 / aov.width);
        let Some(expected) = base.at(&lens, &lens.ray(f64::from(x) + 0.5, f64::from(y) + 0.5)) else { continue };
        assert!((f64::from(*depth) - expected.depth).abs() < TOLERANCE, "{x},{y}: {depth}, expected {expected:?}");
        hits += 1;
    }
    assert!(hits > 400, "{hits} hits");
}
