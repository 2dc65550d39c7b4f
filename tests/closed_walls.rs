//! Steps and borders whose pixels can be written down, as in closed_forms.rs.

mod common;

use common::{
    Expected, Gltf, Lens, Map, Ray, Shape, Wrap,
    forms::{Sheet, both, both_sides, nearest, ramp_scene, wall},
};
use glam::{DAffine3, DVec2, DVec3};
use serde_json::json;

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

/// Left lower than right: the step at x = 0 looks to the left. Its u and height are those of the prism being entered:
/// the right one's from the left, the left one's from the right, which only the higher side's material shows.
fn step(lens: &Lens, ray: &Ray, [left, right]: [Sheet; 2], edge_u: [f64; 2]) -> Option<Expected> {
    let half =
        |sheet: Sheet, low: f64, high: f64| sheet.at(lens, ray).filter(|e| (low..=high).contains(&ray.at(e.depth).x));
    let at = |u: f64, entered: Sheet| {
        move |p: DVec3| {
            let inside = p.z >= left.middle && p.z <= right.middle && p.y.abs() <= 1.0;
            inside.then(|| (DVec2::new(u, (1.0 - p.y) / 2.0), entered.height[0] + entered.height[1] * p.z))
        }
    };
    let front = wall(ray, DVec3::ZERO, DVec3::NEG_X, at(edge_u[1], right));
    // A plain surface takes no part in its steps: its neighbour's prism draws them.
    let behind = if left.height[1] == 0.0 { right } else { left };
    let back = wall(ray, DVec3::ZERO, DVec3::X, at(edge_u[0], behind)).filter(|_| right.double_sided);
    nearest([half(left, -1.0, 0.0), half(right, 0.0, 1.0), front, back])
}

/// One mesh of two primitives.
fn joined(gltf: &mut Gltf, [left, right]: [(Shape, usize); 2]) {
    let mesh = gltf.mesh("Halves", &left.0, left.1);
    let other = gltf.mesh("Right", &right.0, right.1);
    let primitive = gltf.json["meshes"][other]["primitives"][0].clone();
    gltf.json["meshes"][mesh]["primitives"].as_array_mut().expect("a list").push(primitive);
    gltf.node(json!({ "mesh": mesh }));
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
    joined(&mut gltf, [(left, plain), (right, wall)]);
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

/// Another map, scale, midlevel and wrap on either side; in one of them hits from behind count.
#[test]
fn a_step_between_two_height_fields_is_closed() {
    let fields = |gltf: &mut Gltf| {
        let low = gltf.displaced("low", &Map::eight(1, &[51]), [Wrap::Clamp; 2], json!({ "scale": 0.4 }));
        let map = Map::eight(3, &[204; 6]);
        let high = gltf.displaced("high", &map, [Wrap::Mirror; 2], json!({ "scale": 0.25, "midlevel": 0.2 }));
        [low, high]
    };
    for [left_two_sided, right_two_sided] in [[false, false], [true, false], [false, true], [true, true]] {
        let mut gltf = Gltf::new();
        let [low, high] = fields(&mut gltf);
        // Two even integers apart, as each primitive's coordinates are moved to near 0 by themselves.
        let [left, right] = halves([6.0, 6.5], [2.5, 3.0]);
        joined(&mut gltf, [(left, low), (right, high)]);
        for (material, two_sided) in [(low, left_two_sided), (high, right_two_sided)] {
            gltf.set(&format!("/materials/{material}/doubleSided"), json!(two_sided));
        }
        let sheet = |sheet: Sheet, u: f64, double_sided| {
            let uv = [DVec2::new(u, 0.0), DVec2::new(u + 1.0, 1.0)];
            Sheet { uv, double_sided, ..sheet }
        };
        let sheets = [
            sheet(Sheet::flat(0.2, 0.5, 0.4), 6.0, left_two_sided),
            sheet(Sheet::flat(0.8, 0.2, 0.25), 2.0, right_two_sided),
        ];
        // From below nothing is seen of one-sided sheets.
        let seen = if left_two_sided || right_two_sided { 2 } else { 1 };
        for lens in &step_lenses()[..seen] {
            both(&gltf, lens, |ray| step(lens, ray, sheets, [6.5, 2.5]));
        }
    }
}
