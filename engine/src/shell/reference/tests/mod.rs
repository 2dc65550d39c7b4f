//! Scenes built in memory, and the tests of the whole tracer.

mod brute_force;
mod closed_form;
mod micro_mesh;
mod penumbra;
mod procedures;
mod seams;
mod watertight;

use std::{f64::consts::TAU, path::PathBuf};

use glam::{DAffine2, DAffine3, DVec3, Vec2, Vec3};

use super::{Reference, Shadows};
use crate::scene::{
    Ambient, Camera, Displacement, HeightMap, HeightSource, HeightTexels, Instance, Material, Mesh, Primitive,
    Procedure, Projection, Scene, Wrap,
};

/// A mesh of one primitive. Welded ids and shell normals stay empty: the reference makes its own.
pub(super) fn mesh(positions: Vec<Vec3>, normals: Vec<Vec3>, uvs: Vec<Vec2>, triangles: Vec<[u32; 3]>) -> Mesh {
    let primitive = Primitive {
        material: 0,
        positions,
        normals,
        tangents: Vec::new(),
        own_tangents: false,
        uvs: [uvs, Vec::new()],
        triangles,
        weld: Vec::new(),
        displacement_scale: 0.0,
    };
    Mesh { name: "mesh".into(), primitives: vec![primitive], shell_normals: Vec::new(), deforms: false }
}

pub(super) fn material(displacement: Option<Displacement>) -> Material {
    Material { displacement, ..Material::default() }
}

pub(super) fn displacement(scale: f64, midlevel: f64) -> Displacement {
    Displacement {
        source: HeightSource::Map(0),
        wrap: [Wrap::Repeat; 2],
        tex_coord: 0,
        transform: DAffine2::IDENTITY,
        scale,
        relative: false,
        midlevel,
        border_wall: false,
    }
}

pub(super) fn map(width: u32, height: u32, texel: impl Fn(u32, u32) -> f64) -> HeightMap {
    let value = |i: u32| (texel(i % width, i / width).clamp(0.0, 1.0) * 65535.0).round() as u16;
    HeightMap { name: "map".into(), width, height, texels: HeightTexels::U16((0..width * height).map(value).collect()) }
}

/// One mesh, one material, one map, one instance at the origin.
pub(super) fn scene(mesh: Mesh, displacement: Option<Displacement>, map: HeightMap) -> Scene {
    Scene {
        file: PathBuf::from("memory"),
        meshes: vec![mesh],
        materials: vec![material(displacement)],
        images: Vec::new(),
        height_maps: vec![map],
        instances: vec![Instance { name: "node".into(), mesh: 0, transform: DAffine3::IDENTITY }],
        camera: None,
        lights: Vec::new(),
        ambient: Ambient::default(),
        notices: Vec::new(),
    }
}

/// The square [-1, 1]² in the xy plane, facing +z, UV = (x + 1, y + 1) / 2, two triangles along the diagonal.
pub(super) fn square() -> Mesh {
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(Vec2::from);
    mesh(
        corners.iter().map(|c| c.extend(0.0)).collect(),
        vec![Vec3::Z; 4],
        corners.iter().map(|c| (*c + 1.0) / 2.0).collect(),
        vec![[0, 1, 2], [0, 2, 3]],
    )
}

/// A closed torus around z: `nu × nv` quads, radii 1 and 0.4, exact normals, UV once around each way.
pub(super) fn torus(nu: u32, nv: u32) -> Mesh {
    let (mut positions, mut normals, mut uvs, mut triangles) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for i in 0..=nu {
        for j in 0..=nv {
            // The seam's two copies are bit-equal.
            let (u, v) = (f64::from(i % nu) / f64::from(nu) * TAU, f64::from(j % nv) / f64::from(nv) * TAU);
            let n = DVec3::new(v.cos() * u.cos(), v.cos() * u.sin(), v.sin());
            positions.push((DVec3::new(u.cos(), u.sin(), 0.0) + 0.4 * n).as_vec3());
            normals.push(n.as_vec3());
            uvs.push(Vec2::new(i as f32 / nu as f32, j as f32 / nv as f32));
        }
    }
    for i in 0..nu {
        for j in 0..nv {
            let id = |i: u32, j: u32| i * (nv + 1) + j;
            let (a, b, c, d) = (id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1));
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh(positions, normals, uvs, triangles)
}

/// A smooth tileable map.
pub(super) fn waves(size: u32) -> HeightMap {
    map(size, size, |x, y| {
        let (x, y) = (f64::from(x) / f64::from(size) * TAU, f64::from(y) / f64::from(size) * TAU);
        0.5 + 0.25 * (6.0 * x).sin() * (4.0 * y).cos() + 0.25 * (2.0 * x + 3.0 * y).sin()
    })
}

pub(super) fn camera(eye: DVec3, target: DVec3, fov_y: f64) -> Camera {
    Camera {
        transform: {
            let back = (eye - target).normalize();
            let right = DVec3::Z.cross(back).normalize();
            DAffine3::from_cols(right, back.cross(right), back, eye)
        },
        projection: Projection::Perspective { fov_y, near: 0.01, far: None },
    }
}

/// Uniform numbers in [0, 1), the same every time.
pub(super) struct Random(pub u64);

impl Random {
    pub(super) fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    pub(super) fn within(&mut self, lo: f64, hi: f64) -> f64 {
        lo + (hi - lo) * self.next()
    }

    /// A unit vector.
    pub(super) fn direction(&mut self) -> DVec3 {
        loop {
            let v = DVec3::new(self.within(-1.0, 1.0), self.within(-1.0, 1.0), self.within(-1.0, 1.0));
            if v.length() > 0.1 && v.length() < 1.0 {
                return v.normalize();
            }
        }
    }
}
