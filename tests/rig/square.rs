//! The simplest mesh: two triangles.

use glam::{DVec3, Vec2, Vec3};
use prism_engine::scene::{Mesh, Primitive};

/// A level square of so much half a side about the origin, facing up.
pub fn square(half: f32, material: usize, displacement_scale: f64) -> Mesh {
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0f32]];
    let primitive = Primitive {
        material,
        positions: corners.map(|[x, z]| half * Vec3::new(x, 0.0, -z)).to_vec(),
        normals: vec![Vec3::Y; 4],
        tangents: Vec::new(),
        own_tangents: false,
        uvs: [corners.map(|[x, z]| Vec2::new(x, z)).to_vec(), Vec::new()],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        weld: vec![0, 1, 2, 3],
        displacement_scale,
    };
    let shell_normals = vec![DVec3::Y; 4];
    Mesh { name: format!("square {material}"), primitives: vec![primitive], shell_normals, deforms: false }
}
