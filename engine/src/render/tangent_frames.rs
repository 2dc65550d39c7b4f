//! The mesh's tangents as frames of the height map's coordinates: with lengths, so that parallax keeps its proportions.
//!
//! A tangent says along which direction v stands still, and how u and v turn; how many texels lie along it is in the
//! coordinates. With the normal n, the unit tangent t and c = n × t (surface-gradient form, Mikkelsen 2010):
//!
//! ```text
//! grad u = a t + b c,  grad v = d c
//! ```

use glam::{DVec2, DVec3, Vec2, Vec4};

use crate::scene::Primitive;

/// Lengths that f32 can square.
const LEAST: f64 = 1e-15;

/// A vertex's frame as the shaders read it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TangentFrame {
    /// a t, and w d, where w = 1 if the bitangent w (n × t) points to the texture's top, against v.
    pub tangent: Vec4,
    /// b.
    pub shear: f32,
}

/// The frames of all vertices: each the mean, by area, of the triangles around. `uv`: the height map's coordinates. The
/// primitive has tangents.
pub fn of_vertices(primitive: &Primitive, uv: &[Vec2]) -> Vec<TangentFrame> {
    let mut sums = vec![([DVec3::ZERO; 2], 0.0); primitive.positions.len()];
    for triangle in &primitive.triangles {
        let [p, q, r] = triangle.map(|v| primitive.positions[v as usize].as_dvec3());
        let [a, b, c] = triangle.map(|v| uv[v as usize].as_dvec2());
        let (e1, e2, area) = (q - p, r - p, (q - p).cross(r - p));
        let squared = area.length_squared();
        if squared == 0.0 {
            continue;
        }
        // The weights' gradients times the area.
        let weight = squared.sqrt();
        let [of_1, of_2] = [e2.cross(area) / weight, area.cross(e1) / weight];
        let gain: [DVec2; 2] = [b - a, c - a];
        let gradients = [gain[0].x * of_1 + gain[1].x * of_2, gain[0].y * of_1 + gain[1].y * of_2];
        for v in triangle {
            let (sum, total) = &mut sums[*v as usize];
            *sum = [sum[0] + gradients[0], sum[1] + gradients[1]];
            *total += weight;
        }
    }
    let frame = |v: usize| {
        let ([u, v_gradient], total) = sums[v];
        let normal = primitive.normals[v].as_dvec3();
        let authored = primitive.tangents[v];
        let tangent =
            authored.truncate().as_dvec3().reject_from_normalized(normal).normalize_or(normal.any_orthonormal_vector());
        let across = normal.cross(tangent);
        let along = (u.dot(tangent) / total).max(LEAST);
        let up = (v_gradient.dot(across) / total).abs().max(LEAST);
        TangentFrame {
            tangent: (along * tangent).as_vec3().extend(authored.w * up as f32),
            shear: (u.dot(across) / total) as f32,
        }
    };
    (0..primitive.positions.len()).map(frame).collect()
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    /// u = 3 x + y, v = -2 y on one side, u mirrored on the other; tangents along the x at which v stands still.
    #[test]
    fn frames_give_the_gradients_back() {
        for mirror in [1.0f32, -1.0] {
            let positions = vec![Vec3::ZERO, Vec3::X, Vec3::new(0.3, 2.0, 0.0)];
            let uv: Vec<_> = positions.iter().map(|p| Vec2::new(mirror * (3.0 * p.x + p.y), -2.0 * p.y)).collect();
            let primitive = Primitive {
                material: 0,
                normals: vec![Vec3::Z; 3],
                tangents: vec![Vec4::new(mirror, 0.0, 0.0, mirror); 3],
                own_tangents: true,
                uvs: [uv.clone(), Vec::new()],
                triangles: vec![[0, 1, 2]],
                weld: Vec::new(),
                displacement_scale: 0.0,
                positions,
            };
            for frame in of_vertices(&primitive, &uv) {
                let tangent = frame.tangent.truncate();
                let across = Vec3::Z.cross(tangent.normalize());
                assert!(
                    (tangent + frame.shear * across).abs_diff_eq(mirror * Vec3::new(3.0, 1.0, 0.0), 1e-6),
                    "{frame:?}"
                );
                assert!((-frame.tangent.w * across).abs_diff_eq(Vec3::new(0.0, -2.0, 0.0), 1e-6), "{frame:?}");
            }
        }
    }
}
