//! Welding: one shell normal per position, so that no displaced surface tears at a hard edge or a UV seam.

use std::collections::HashMap;

use glam::{DVec3, Vec3};

use super::{Mesh, Primitive};

/// A sum of normals shorter than this, per unit of weight, has no direction worth the name.
const LEAST_MEAN: f64 = 1e-6;

/// Fills the `weld` of a mesh's primitives and returns the shell normals that it points at: at each position the mean
/// of the vertex normals there, weighted by corner angle and normalised, or zero where the mean vanishes.
pub(super) fn weld(primitives: &mut [Primitive]) -> Vec<DVec3> {
    let mut known = HashMap::new();
    for primitive in primitives.iter_mut() {
        let mut id = |position: &Vec3| {
            let next = known.len() as u32;
            // Adding zero turns -0 into 0: the two are one position.
            *known.entry(position.to_array().map(|x| (x + 0.0).to_bits())).or_insert(next)
        };
        primitive.weld = primitive.positions.iter().map(&mut id).collect();
    }

    shell_normals(primitives, known.len())
}

impl Mesh {
    /// Computes the shell normals anew, after positions or normals have changed. What is welded stays so, wherever it
    /// is now: a pose opens no seam.
    pub fn update_shell_normals(&mut self) {
        self.shell_normals = shell_normals(&self.primitives, self.shell_normals.len());
    }
}

/// The shell normals of so many welded vertices.
fn shell_normals(primitives: &[Primitive], welded: usize) -> Vec<DVec3> {
    let mut sums = vec![(DVec3::ZERO, 0.0); welded];
    for primitive in primitives {
        for triangle in &primitive.triangles {
            let corners = triangle.map(|vertex| primitive.positions[vertex as usize].as_dvec3());
            for (i, vertex) in triangle.map(|vertex| vertex as usize).into_iter().enumerate() {
                let angle = angle(corners[(i + 1) % 3] - corners[i], corners[(i + 2) % 3] - corners[i]);
                let (sum, weight) = &mut sums[primitive.weld[vertex] as usize];
                *sum += angle * primitive.normals[vertex].as_dvec3();
                *weight += angle;
            }
        }
    }
    sums.into_iter()
        .map(|(sum, weight)| if sum.length() > LEAST_MEAN * weight { sum.normalize() } else { DVec3::ZERO })
        .collect()
}

/// The angle between two vectors; the tangent keeps it exact where the cosine is flat.
fn angle(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length().atan2(a.dot(b))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A primitive of separate triangles with flat normals.
    fn soup(triangles: &[[Vec3; 3]]) -> Primitive {
        let positions: Vec<_> = triangles.as_flattened().to_vec();
        let normals = triangles.iter().flat_map(|[a, b, c]| [(b - a).cross(c - a).normalize(); 3]).collect();
        Primitive {
            material: 0,
            normals,
            tangents: Vec::new(),
            own_tangents: false,
            uvs: [Vec::new(), Vec::new()],
            triangles: (0..triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
            weld: Vec::new(),
            displacement_scale: 0.0,
            positions,
        }
    }

    /// The quad of a unit cube's face whose normal is along `axis`, split along either diagonal.
    fn face(axis: usize, sign: f32, flip: bool) -> [[Vec3; 3]; 2] {
        let mut along = [Vec3::ZERO; 3];
        for (i, vector) in along.iter_mut().enumerate() {
            vector[(axis + i) % 3] = 1.0;
        }
        let [normal, u, v] = [along[0] * sign, along[1] * sign, along[2]];
        let corner = |a: f32, b: f32| normal + a * u + b * v;
        let quad = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
        let [a, b, c, d] = if flip { [quad[1], quad[2], quad[3], quad[0]] } else { quad };
        [[a, b, c], [a, c, d]]
    }

    #[test]
    fn a_cubes_corners_point_along_the_diagonals_whatever_the_diagonal() {
        for flips in 0..64 {
            // Two primitives, so that welding is seen to cross them.
            let mut primitives: Vec<_> = [0..3, 3..6]
                .into_iter()
                .map(|faces| {
                    let faces = faces.map(|i| face(i % 3, if i < 3 { 1.0 } else { -1.0 }, flips >> i & 1 == 1));
                    soup(faces.collect::<Vec<_>>().as_flattened())
                })
                .collect();
            let normals = weld(&mut primitives);
            assert_eq!(normals.len(), 8);
            for primitive in &primitives {
                for (position, &id) in primitive.positions.iter().zip(&primitive.weld) {
                    let expected = position.as_dvec3() / 3_f64.sqrt();
                    assert!(normals[id as usize].abs_diff_eq(expected, 1e-12), "{position}");
                }
            }
        }
    }

    #[test]
    fn the_sign_of_zero_does_not_part_positions() {
        let a = [Vec3::ZERO, Vec3::X, Vec3::Y];
        let b = [Vec3::new(-0.0, 0.0, -0.0), Vec3::Y, Vec3::NEG_X];
        let mut primitives = [soup(&[a, b])];
        assert_eq!(weld(&mut primitives).len(), 4);
        assert_eq!(primitives[0].weld, [0, 1, 2, 0, 2, 3]);
    }

    #[test]
    fn opposed_normals_cancel_to_zero() {
        let (a, b, c) = (Vec3::ZERO, Vec3::X, Vec3::Y);
        let normals = weld(&mut [soup(&[[a, b, c], [a, c, b]])]);
        assert_eq!(normals, [DVec3::ZERO; 3]);
    }

    #[test]
    fn weights_are_angles() {
        // At the origin: a right angle in the plane z = 0, and 45 degrees in the plane y = 0.
        let flat = [Vec3::ZERO, Vec3::X, Vec3::Y];
        let upright = [Vec3::ZERO, Vec3::new(1.0, 0.0, 1.0), Vec3::X];
        let normals = weld(&mut [soup(&[flat, upright])]);
        let expected = DVec3::new(0.0, 1.0, 2.0).normalize();
        assert!(normals[0].abs_diff_eq(expected, 1e-12), "{}", normals[0]);
    }
}
