//! Sheets and walls whose every pixel can be written down, and the comparison with what the program draws.

use glam::{DAffine3, DVec2, DVec3};
use prism_engine::aov::Aov;
use serde_json::json;

use super::{Expected, Frame, Gltf, Lens, Map, Ray, Shape, WAYS, Wrap, check, draw, folder};

/// World units; the scenes are 2 units wide and 3 away, where an f32 is good to 2.4e-7.
pub const TOLERANCE: f64 = 2e-5;

pub const EXACT: &str = "--march exact";
/// So many steps that the search adds nothing to the error: 0.4 / 64 / 2^16 is 1e-7.
pub const FINE: &str = "--march relief --min-steps 64 --max-steps 64 --refine-steps 16";
pub const MARCHES: [&str; 2] = [EXACT, FINE];

/// Where most scenes are looked at from.
pub fn oblique() -> Lens {
    Lens::at([1.4, 0.9, 2.2], [0.0; 3])
}

pub fn straight() -> Lens {
    Lens::at([0.0, 0.0, 3.0], [0.0; 3])
}

/// The surface data of a scene.
#[track_caller]
pub fn aov(gltf: &Gltf, lens: &Lens, flags: &str) -> Aov {
    let mut gltf = gltf.clone();
    gltf.camera(lens);
    let folder = folder();
    let file = folder.path().join("frame.exr");
    let [width, height] = lens.size;
    let call = draw("render", gltf.write(folder.path())).words(&format!("--size {width}x{height} {flags} --aov"));
    call.arg(&file).within(folder.path()).succeeds();
    Frame::read(&file).aov()
}

/// Compares both shells of both stages with a formula, and the other march at one stage of each.
#[track_caller]
pub fn both(gltf: &Gltf, lens: &Lens, surface: impl Fn(&Ray) -> Option<Expected>) {
    for (way, march) in WAYS.into_iter().map(|way| (way, EXACT)).chain([(WAYS[0], FINE), (WAYS[3], FINE)]) {
        println!("{way} {march}:");
        let aov = aov(gltf, lens, &format!("{way} {march}"));
        check(&aov, lens, TOLERANCE, &surface);
    }
}

/// A part of the plane z = middle + slope · x over the square from -1 to 1 in mesh space, with UV 0 to 1 and v down.
#[derive(Clone, Copy)]
pub struct Sheet {
    pub transform: DAffine3,
    pub middle: f64,
    pub slope: f64,
    /// UV at the top left and the bottom right.
    pub uv: [DVec2; 2],
    /// Height where z is 0, and per unit of z.
    pub height: [f64; 2],
    pub double_sided: bool,
}

impl Sheet {
    /// All at the same height `h`.
    pub fn flat(h: f64, midlevel: f64, scale: f64) -> Sheet {
        Sheet { middle: (h - midlevel) * scale, ..Sheet::ramp(midlevel, scale) }.with_slope(0.0)
    }

    /// Rising from 0 at x = -1 to 1 at x = 1.
    pub fn ramp(midlevel: f64, scale: f64) -> Sheet {
        Sheet {
            transform: DAffine3::IDENTITY,
            middle: (0.5 - midlevel) * scale,
            slope: 0.5 * scale,
            uv: [DVec2::ZERO, DVec2::ONE],
            height: [midlevel, 1.0 / scale],
            double_sided: false,
        }
    }

    pub fn with_slope(self, slope: f64) -> Sheet {
        Sheet { slope, ..self }
    }

    pub fn uv_at(&self, p: DVec3) -> DVec2 {
        self.uv[0] + (self.uv[1] - self.uv[0]) * DVec2::new(p.x + 1.0, 1.0 - p.y) / 2.0
    }

    pub fn at(&self, lens: &Lens, ray: &Ray) -> Option<Expected> {
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
pub fn wall(ray: &Ray, point: DVec3, normal: DVec3, holds: impl Fn(DVec3) -> Option<(DVec2, f64)>) -> Option<Expected> {
    let depth = ray.plane(point, normal);
    let (uv, height) = holds(ray.at(depth)).filter(|_| depth > 0.0 && normal.dot(ray.direction) < 0.0)?;
    Some(Expected { depth, normal, uv, height, plain: false })
}

/// The same wall from both sides.
pub fn both_sides(
    ray: &Ray,
    point: DVec3,
    normal: DVec3,
    holds: impl Fn(DVec3) -> Option<(DVec2, f64)>,
) -> Option<Expected> {
    wall(ray, point, normal, &holds).or_else(|| wall(ray, point, -normal, &holds))
}

pub fn nearest(all: impl IntoIterator<Item = Option<Expected>>) -> Option<Expected> {
    all.into_iter().flatten().min_by(|a, b| a.depth.total_cmp(&b.depth))
}

/// A sheet with UV 0 to 1 (the map's whole width) under this transform.
pub fn sheet_scene(map: &Map, displacement: serde_json::Value, transform: DAffine3) -> Gltf {
    let mut gltf = Gltf::new();
    let wall = gltf.displaced("wall", map, [Wrap::Clamp; 2], displacement);
    let mesh = gltf.mesh("Sheet", &Shape::sheet(1.0, [0.0, 0.0], [1.0, 1.0]), wall);
    gltf.node(json!({ "name": "tile", "mesh": mesh, "matrix": matrix(transform) }));
    gltf
}

pub fn matrix(transform: DAffine3) -> Vec<f64> {
    let [x, y, z, w] =
        [transform.matrix3.x_axis, transform.matrix3.y_axis, transform.matrix3.z_axis, transform.translation];
    vec![x.x, x.y, x.z, 0.0, y.x, y.y, y.z, 0.0, z.x, z.y, z.z, 0.0, w.x, w.y, w.z, 1.0]
}

/// [`Sheet::ramp`]: two texels, and UV from the centre of the one to the centre of the other.
pub fn ramp_scene(midlevel: f64, scale: f64, transform: DAffine3) -> (Gltf, Sheet) {
    let mut gltf = Gltf::new();
    let map = Map::sixteen(2, &[0, 65535]);
    let wall = gltf.displaced("wall", &map, [Wrap::Clamp; 2], json!({ "scale": scale, "midlevel": midlevel }));
    let mesh = gltf.mesh("Sheet", &Shape::sheet(1.0, [0.25, 0.0], [0.75, 1.0]), wall);
    gltf.node(json!({ "name": "tile", "mesh": mesh, "matrix": matrix(transform) }));
    let uv = [DVec2::new(0.25, 0.0), DVec2::new(0.75, 1.0)];
    (gltf, Sheet { transform, uv, ..Sheet::ramp(midlevel, scale) })
}
