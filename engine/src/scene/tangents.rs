//! MikkTSpace tangents for primitives whose file has none.

use std::collections::HashMap;

use bevy_mikktspace::{Geometry, TangentSpace, generate_tangents};
use glam::{DAffine2, Vec3, Vec4};

use super::Primitive;

/// Gives a primitive tangents along the texture coordinates of set `tex_coord` after `transform`, as glTF asks: those
/// are the coordinates of the normal texture. (Its `KHR_texture_transform` says nothing about tangents; following the
/// transformed coordinates is what makes a turned normal map turn its bumps.) Vertices whose corners get different
/// tangents are split.
///
/// As in glTF, the bitangent is `cross(normal, tangent) · w` and points to the top of the texture, against v.
///
/// The primitive has that UV set.
pub(super) fn generate(primitive: &mut Primitive, tex_coord: usize, transform: DAffine2) {
    // MikkTSpace's v points up, glTF's down. Negating keeps every bit, 1 - v would not.
    let uvs = primitive.uvs[tex_coord]
        .iter()
        .map(|uv| transform.transform_point2(uv.as_dvec2()).as_vec2())
        .map(|uv| [uv.x, -uv.y])
        .collect();
    let corners = vec![[None; 3]; primitive.triangles.len()];
    let mut task = Task { primitive, uvs, corners };
    match generate_tangents(&mut task) {
        Ok(()) => {}
        // The crate keeps the right to have errors some day; the fallback below then serves every corner.
        Err(_) => task.corners.fill([None; 3]),
    }
    let corners = task.corners;
    assign(primitive, &corners);
}

/// Turns tangents per corner into tangents per vertex.
fn assign(primitive: &mut Primitive, corners: &[[Option<Vec4>; 3]]) {
    let mut vertices = HashMap::new();
    let mut sources = Vec::new();
    let mut tangents = Vec::new();
    let mut triangles = primitive.triangles.clone();
    for (triangle, corners) in triangles.iter_mut().zip(corners) {
        for (vertex, corner) in triangle.iter_mut().zip(corners) {
            let tangent = usable(*corner, primitive.normals[*vertex as usize]);
            *vertex = *vertices.entry((*vertex, tangent.to_array().map(f32::to_bits))).or_insert_with(|| {
                sources.push(*vertex);
                tangents.push(tangent);
                // At most as many vertices as corners, whose number `Primitive` keeps within u32.
                (sources.len() - 1) as u32
            });
        }
    }
    primitive.pick_vertices(&sources);
    primitive.tangents = tangents;
    primitive.triangles = triangles;
}

/// MikkTSpace has no tangent where all triangles around are degenerate in UV, and numbers near the ends of f32 can
/// overflow in it. Shading then takes any direction across the normal, which is better than NaN.
fn usable(tangent: Option<Vec4>, normal: Vec3) -> Vec4 {
    let across = |tangent: &Vec4| tangent.is_finite() && tangent.truncate().cross(normal).length() > 1e-3;
    tangent.filter(across).unwrap_or_else(|| normal.any_orthonormal_vector().extend(1.0))
}

struct Task<'a> {
    primitive: &'a Primitive,
    uvs: Vec<[f32; 2]>,
    corners: Vec<[Option<Vec4>; 3]>,
}

impl Task<'_> {
    fn vertex(&self, face: usize, corner: usize) -> usize {
        self.primitive.triangles[face][corner] as usize
    }
}

impl Geometry for Task<'_> {
    fn num_faces(&self) -> usize {
        self.primitive.triangles.len()
    }

    fn num_vertices_of_face(&self, _face: usize) -> usize {
        3
    }

    fn position(&self, face: usize, corner: usize) -> [f32; 3] {
        self.primitive.positions[self.vertex(face, corner)].into()
    }

    fn normal(&self, face: usize, corner: usize) -> [f32; 3] {
        self.primitive.normals[self.vertex(face, corner)].into()
    }

    fn tex_coord(&self, face: usize, corner: usize) -> [f32; 2] {
        self.uvs[self.vertex(face, corner)]
    }

    fn set_tangent(&mut self, space: Option<TangentSpace>, face: usize, corner: usize) {
        self.corners[face][corner] = space.map(|space| space.tangent_encoded().into());
    }
}

#[cfg(test)]
mod tests {
    use glam::{DMat2, DVec2, Vec2};

    use super::*;

    /// Two quads in the plane z = 0 side by side, meeting at x = 0 with shared vertices; u = |x|, v = 1 - y.
    fn mirrored() -> Primitive {
        let positions: Vec<_> =
            [-1.0, 0.0, 1.0].into_iter().flat_map(|x| [Vec3::new(x, 0.0, 0.0), Vec3::new(x, 1.0, 0.0)]).collect();
        Primitive {
            material: 0,
            normals: vec![Vec3::Z; 6],
            tangents: Vec::new(),
            own_tangents: false,
            uvs: [positions.iter().map(|p| Vec2::new(p.x.abs(), 1.0 - p.y)).collect(), Vec::new()],
            triangles: vec![[0, 2, 3], [0, 3, 1], [2, 4, 5], [2, 5, 3]],
            weld: Vec::new(),
            displacement_scale: 0.0,
            positions,
        }
    }

    #[test]
    fn a_mirrored_seam_is_split_and_changes_hand() {
        let mut primitive = mirrored();
        generate(&mut primitive, 0, DAffine2::IDENTITY);
        assert_eq!(primitive.positions.len(), 8, "the two vertices of the seam are doubled");
        for (t, triangle) in primitive.triangles.iter().enumerate() {
            for &vertex in triangle {
                let tangent = primitive.tangents[vertex as usize];
                let expected = if t < 2 { Vec4::new(-1.0, 0.0, 0.0, -1.0) } else { Vec4::new(1.0, 0.0, 0.0, 1.0) };
                assert!(tangent.abs_diff_eq(expected, 1e-6), "triangle {t}: {tangent}");
                // The bitangent points to the texture's top, here +Y.
                let bitangent = primitive.normals[vertex as usize].cross(tangent.truncate()) * tangent.w;
                assert!(bitangent.abs_diff_eq(Vec3::Y, 1e-6));
            }
        }
    }

    #[test]
    fn tangents_follow_the_transformed_coordinates() {
        let mut primitive = mirrored();
        primitive.triangles.drain(..2);
        // u' = -v, v' = u: u' grows along +Y.
        let turn = DMat2::from_cols(DVec2::Y, DVec2::NEG_X);
        generate(&mut primitive, 0, DAffine2::from_mat2(turn));
        assert_eq!(primitive.tangents.len(), 4, "vertices that no triangle uses are gone");
        for tangent in &primitive.tangents {
            assert!(tangent.abs_diff_eq(Vec4::new(0.0, 1.0, 0.0, 1.0), 1e-6), "{tangent}");
        }
    }

    #[test]
    fn without_any_uv_area_tangents_lie_across_the_normal() {
        let mut primitive = mirrored();
        generate(&mut primitive, 0, DAffine2::from_scale(DVec2::ZERO));
        for (tangent, normal) in primitive.tangents.iter().zip(&primitive.normals) {
            assert!(tangent.is_finite() && tangent.truncate().dot(*normal).abs() < 1e-6, "{tangent}");
        }
    }
}
