//! Surfaces whose pixels can be written down: the program draws hand-written glTF files, and every pixel of its surface
//! data is compared with a formula.

mod common;

use std::f64::consts::PI;

use common::{Expected, Frame, Gltf, Lens, Map, Ray, STAGES, Shape, Wrap, check, draw, folder};
use glam::{DAffine3, DMat3, DVec2, DVec3};
use prism_engine::aov::Aov;
use serde_json::json;

/// World units; the scenes are 2 units wide and 3 away, where an f32 is good to 2.4e-7.
const TOLERANCE: f64 = 2e-5;

const EXACT: &str = "--march exact";
/// So many steps that the search adds nothing to the error: 0.4 / 64 / 2^16 is 1e-7.
const FINE: &str = "--march relief --min-steps 64 --max-steps 64 --refine-steps 16";
const MARCHES: [&str; 2] = [EXACT, FINE];

/// Where most scenes are looked at from.
fn oblique() -> Lens {
    Lens::at([1.4, 0.9, 2.2], [0.0; 3])
}

fn straight() -> Lens {
    Lens::at([0.0, 0.0, 3.0], [0.0; 3])
}

/// The surface data of a scene.
#[track_caller]
fn aov(gltf: &Gltf, lens: &Lens, flags: &str) -> Aov {
    let mut gltf = gltf.clone();
    gltf.camera(lens);
    let folder = folder();
    let file = folder.path().join("frame.exr");
    let [width, height] = lens.size;
    let call = draw("render", gltf.write(folder.path())).words(&format!("--size {width}x{height} {flags} --aov"));
    call.arg(&file).within(folder.path()).succeeds();
    Frame::read(&file).aov()
}

/// Compares the shell of both stages with a formula, and both marches at one of them.
#[track_caller]
fn both(gltf: &Gltf, lens: &Lens, surface: impl Fn(&Ray) -> Option<Expected>) {
    for (stage, march) in [("mesh", EXACT), ("geometry", EXACT), ("mesh", FINE)] {
        println!("{stage} {march}:");
        let aov = aov(gltf, lens, &format!("--shell prism --stage {stage} {march}"));
        check(&aov, lens, TOLERANCE, &surface);
    }
}

/// A part of the plane z = middle + slope · x over the square from -1 to 1 in mesh space, with UV 0 to 1 and v down.
#[derive(Clone, Copy)]
struct Sheet {
    transform: DAffine3,
    middle: f64,
    slope: f64,
    /// UV at the top left and the bottom right.
    uv: [DVec2; 2],
    /// Height where z is 0, and per unit of z.
    height: [f64; 2],
    double_sided: bool,
}

impl Sheet {
    /// All at the same height `h`.
    fn flat(h: f64, midlevel: f64, scale: f64) -> Sheet {
        Sheet { middle: (h - midlevel) * scale, ..Sheet::ramp(midlevel, scale) }.with_slope(0.0)
    }

    /// Rising from 0 at x = -1 to 1 at x = 1.
    fn ramp(midlevel: f64, scale: f64) -> Sheet {
        Sheet {
            transform: DAffine3::IDENTITY,
            middle: (0.5 - midlevel) * scale,
            slope: 0.5 * scale,
            uv: [DVec2::ZERO, DVec2::ONE],
            height: [midlevel, 1.0 / scale],
            double_sided: false,
        }
    }

    fn with_slope(self, slope: f64) -> Sheet {
        Sheet { slope, ..self }
    }

    fn uv_at(&self, p: DVec3) -> DVec2 {
        self.uv[0] + (self.uv[1] - self.uv[0]) * DVec2::new(p.x + 1.0, 1.0 - p.y) / 2.0
    }

    fn at(&self, lens: &Lens, ray: &Ray) -> Option<Expected> {
        let back = self.transform.inverse();
        let local = Ray { origin: back.transform_point3(ray.origin), direction: back.transform_vector3(ray.direction) };
        let normal = DVec3::new(-self.slope, 0.0, 1.0);
        let depth = local.plane(DVec3::new(0.0, 0.0, self.middle), normal);
        let p = local.at(depth);
        let inside = p.x.abs() <= 1.0 && p.y.abs() <= 1.0 && depth >= lens.near;
        let front = normal.dot(local.direction) < 0.0;
        if !inside || !(front || self.double_sided) {
            return None;
        }
        let world = (back.matrix3.transpose() * normal).normalize();
        let normal = if world.dot(ray.direction) < 0.0 { world } else { -world };
        let height = self.height[0] + self.height[1] * p.z;
        Some(Expected { depth, normal, uv: self.uv_at(p), height, plain: self.height[1] == 0.0 })
    }
}

/// A vertical wall: the part of the plane through `point` that `holds` says, with its UV and height.
fn wall(ray: &Ray, point: DVec3, normal: DVec3, holds: impl Fn(DVec3) -> Option<(DVec2, f64)>) -> Option<Expected> {
    let depth = ray.plane(point, normal);
    let (uv, height) = holds(ray.at(depth)).filter(|_| depth > 0.0 && normal.dot(ray.direction) < 0.0)?;
    Some(Expected { depth, normal, uv, height, plain: false })
}

/// The same wall from both sides.
fn both_sides(
    ray: &Ray,
    point: DVec3,
    normal: DVec3,
    holds: impl Fn(DVec3) -> Option<(DVec2, f64)>,
) -> Option<Expected> {
    wall(ray, point, normal, &holds).or_else(|| wall(ray, point, -normal, &holds))
}

fn nearest(all: impl IntoIterator<Item = Option<Expected>>) -> Option<Expected> {
    all.into_iter().flatten().min_by(|a, b| a.depth.total_cmp(&b.depth))
}

/// A sheet with UV 0 to 1 (the map's whole width) under this transform.
fn sheet_scene(map: &Map, displacement: serde_json::Value, transform: DAffine3) -> Gltf {
    let mut gltf = Gltf::new();
    let wall = gltf.displaced("wall", map, [Wrap::Clamp; 2], displacement);
    let mesh = gltf.mesh("Sheet", &Shape::sheet(1.0, [0.0, 0.0], [1.0, 1.0]), wall);
    gltf.node(json!({ "name": "tile", "mesh": mesh, "matrix": matrix(transform) }));
    gltf
}

fn matrix(transform: DAffine3) -> Vec<f64> {
    let [x, y, z, w] =
        [transform.matrix3.x_axis, transform.matrix3.y_axis, transform.matrix3.z_axis, transform.translation];
    vec![x.x, x.y, x.z, 0.0, y.x, y.y, y.z, 0.0, z.x, z.y, z.z, 0.0, w.x, w.y, w.z, 1.0]
}

/// [`Sheet::ramp`]: two texels, and UV from the centre of the one to the centre of the other.
fn ramp_scene(midlevel: f64, scale: f64, transform: DAffine3) -> (Gltf, Sheet) {
    let mut gltf = Gltf::new();
    let map = Map::sixteen(2, &[0, 65535]);
    let wall = gltf.displaced("wall", &map, [Wrap::Clamp; 2], json!({ "scale": scale, "midlevel": midlevel }));
    let mesh = gltf.mesh("Sheet", &Shape::sheet(1.0, [0.25, 0.0], [0.75, 1.0]), wall);
    gltf.node(json!({ "name": "tile", "mesh": mesh, "matrix": matrix(transform) }));
    let uv = [DVec2::new(0.25, 0.0), DVec2::new(0.75, 1.0)];
    (gltf, Sheet { transform, uv, ..Sheet::ramp(midlevel, scale) })
}

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
    for (stage, march) in STAGES.into_iter().zip(MARCHES) {
        let mut aov = aov(&gltf, &lens, &format!("--shell prism --stage {stage} {march}"));
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

/// A ramp whose borders reach down to the map's lowest height: to -0.2.
fn walled_ramp(double_sided: bool) -> (Gltf, impl Fn(&Lens, &Ray) -> Option<Expected>) {
    let (mut gltf, sheet) = ramp_scene(0.5, 0.4, DAffine3::IDENTITY);
    gltf.set("/materials/0/extras/displacement/border", json!("wall"));
    gltf.set("/materials/0/doubleSided", json!(double_sided));
    let sheet = Sheet { double_sided, ..sheet };
    let surface = move |lens: &Lens, ray: &Ray| {
        let borders = [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y].map(|normal| {
            let at = |p: DVec3| {
                // Into the wall's plane, so that rounding does not put the point beside the sheet.
                let p = p - normal * (p.dot(normal) - 1.0);
                let inside = p.z >= -0.2 && p.z <= 0.2 * p.x && p.x.abs() <= 1.0 && p.y.abs() <= 1.0;
                inside.then(|| (sheet.uv_at(p), 0.5 + p.z / 0.4))
            };
            if double_sided { both_sides(ray, normal, normal, at) } else { wall(ray, normal, normal, at) }
        });
        nearest(borders.into_iter().chain([sheet.at(lens, ray)]))
    };
    (gltf, surface)
}

#[test]
fn a_border_closed_by_a_wall() {
    let lens = Lens::at([2.4, 1.2, 1.1], [0.0; 3]);
    for double_sided in [false, true] {
        let (gltf, surface) = walled_ramp(double_sided);
        both(&gltf, &lens, |ray| surface(&lens, ray));
    }
}

#[test]
fn a_double_sided_wall_is_seen_from_within() {
    // From below, where the box that the walls make is open.
    let lens = Lens::at([-1.1, 0.6, -1.6], [0.3, 0.0, 0.0]);
    let (gltf, surface) = walled_ramp(true);
    both(&gltf, &lens, |ray| surface(&lens, ray));
}

/// Two squares side by side, from -1 to 0 and from 0 to 1.
fn halves(left_u: [f32; 2], right_u: [f32; 2]) -> [Shape; 2] {
    [(-1.0f32, left_u), (0.0, right_u)].map(|(x, u)| {
        let mut shape = Shape::sheet(1.0, [u[0], 0.0], [u[1], 1.0]);
        for position in &mut shape.positions {
            position[0] = x + (position[0] + 1.0) / 2.0;
        }
        shape
    })
}

/// Left lower than right: the step at x = 0 looks to the left. Its u is that of the prism being entered: the right one's
/// from the left, the left one's from the right, which only two sides show.
fn step(lens: &Lens, ray: &Ray, [left, right]: [Sheet; 2], edge_u: [f64; 2]) -> Option<Expected> {
    let half =
        |sheet: Sheet, low: f64, high: f64| sheet.at(lens, ray).filter(|e| (low..=high).contains(&ray.at(e.depth).x));
    let at = |u: f64| {
        move |p: DVec3| {
            let inside = p.z >= left.middle && p.z <= right.middle && p.y.abs() <= 1.0;
            inside.then(|| (DVec2::new(u, (1.0 - p.y) / 2.0), right.height[0] + right.height[1] * p.z))
        }
    };
    let front = wall(ray, DVec3::ZERO, DVec3::NEG_X, at(edge_u[1]));
    let back = wall(ray, DVec3::ZERO, DVec3::X, at(edge_u[0])).filter(|_| right.double_sided);
    nearest([half(left, -1.0, 0.0), half(right, 0.0, 1.0), front, back])
}

/// The eyes that see a step: from in front and above, and from behind and below.
fn step_lenses() -> [Lens; 2] {
    [Lens::at([-1.6, 0.8, 1.9], [0.0; 3]), Lens::at([1.4, 0.7, -1.7], [0.0; 3])]
}

#[test]
fn a_step_at_a_uv_seam_is_closed() {
    let mut gltf = Gltf::new();
    // The outer halves of the texels, where clamping makes them flat: 0.2 on the left, 0.8 on the right.
    let map = Map::eight(2, &[51, 204]);
    let wall = gltf.displaced("wall", &map, [Wrap::Clamp; 2], json!({ "scale": 0.4 }));
    let [mut shape, right] = halves([0.0, 0.25], [0.75, 1.0]);
    let first = shape.positions.len() as u32;
    shape.positions.extend(right.positions);
    shape.normals.extend(right.normals);
    shape.uvs.extend(right.uvs);
    shape.triangles.extend(right.triangles.iter().map(|t| t.map(|i| i + first)));
    let mesh = gltf.mesh("Halves", &shape, wall);
    gltf.node(json!({ "mesh": mesh }));
    let uv = |sheet: Sheet, from: f64| Sheet { uv: [DVec2::new(from, 0.0), DVec2::new(from + 0.5, 1.0)], ..sheet };
    // u runs over a quarter on each half, so over a half on the whole width.
    let sheets = [uv(Sheet::flat(0.2, 0.5, 0.4), 0.0), uv(Sheet::flat(0.8, 0.5, 0.4), 0.5)];
    let [above, below] = step_lenses();
    both(&gltf, &above, |ray| step(&above, ray, sheets, [0.25, 0.75]));
    gltf.set("/materials/0/doubleSided", json!(true));
    let sheets = sheets.map(|sheet| Sheet { double_sided: true, ..sheet });
    for lens in [above, below] {
        both(&gltf, &lens, |ray| step(&lens, ray, sheets, [0.25, 0.75]));
    }
}

#[test]
fn a_step_to_a_plain_neighbour_is_closed() {
    let mut gltf = Gltf::new();
    let plain = gltf.plain("plain");
    let wall = gltf.displaced("wall", &Map::eight(1, &[255]), [Wrap::Clamp; 2], json!({ "scale": 0.4 }));
    let [left, right] = halves([0.0, 0.5], [0.5, 1.0]);
    let mesh = gltf.mesh("Halves", &left, plain);
    let other = gltf.mesh("Right", &right, wall);
    let primitive = gltf.json["meshes"][other]["primitives"][0].clone();
    gltf.json["meshes"][mesh]["primitives"].as_array_mut().expect("a list").push(primitive);
    gltf.node(json!({ "mesh": mesh }));
    let left = Sheet { height: [0.5, 0.0], ..Sheet::flat(0.5, 0.5, 1.0) };
    let [above, below] = step_lenses();
    both(&gltf, &above, |ray| step(&above, ray, [left, Sheet::flat(1.0, 0.5, 0.4)], [0.5, 0.5]));
    for material in 0..2 {
        gltf.set(&format!("/materials/{material}/doubleSided"), json!(true));
    }
    let sheets = [left, Sheet::flat(1.0, 0.5, 0.4)].map(|sheet| Sheet { double_sided: true, ..sheet });
    for lens in [above, below] {
        both(&gltf, &lens, |ray| step(&lens, ray, sheets, [0.5, 0.5]));
    }
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
