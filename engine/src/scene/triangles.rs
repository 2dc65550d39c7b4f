//! Triangle lists: from glTF's modes, without triangles that have no area, with flat normals where asked.

use glam::{DVec2, DVec3};
use gltf::json::mesh::Mode;

use super::Primitive;

/// The triangles of an index list, each front counter-clockwise; nothing for points and lines.
pub(super) fn assemble(mode: Mode, indices: &[u32]) -> Option<Vec<[u32; 3]>> {
    let triangles = match mode {
        Mode::Triangles => indices.as_chunks::<3>().0.to_vec(),
        Mode::TriangleStrip => indices
            .windows(3)
            .enumerate()
            // Every other triangle of a strip is wound the other way round.
            .map(|(i, v)| if i % 2 == 0 { [v[0], v[1], v[2]] } else { [v[0], v[2], v[1]] })
            .collect(),
        Mode::TriangleFan => match indices.split_first() {
            Some((&hub, rim)) => rim.windows(2).map(|v| [v[0], v[1], hub]).collect(),
            None => Vec::new(),
        },
        Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip => return None,
    };
    Some(triangles)
}

impl Primitive {
    /// Drops triangles without area and returns how many there were. They show nothing, they have no plane that a prism
    /// could stand on, and their corners would weigh in on the shell normals.
    pub(super) fn drop_degenerate(&mut self) -> usize {
        let before = self.triangles.len();
        let mut triangles = std::mem::take(&mut self.triangles);
        triangles.retain(|triangle| self.area_vector(triangle) != DVec3::ZERO);
        self.triangles = triangles;
        before - self.triangles.len()
    }

    /// Gives every triangle its own vertices and its own normal, as glTF asks where a file has no normals.
    pub(super) fn flatten(&mut self) {
        let normals = self.triangles.iter().flat_map(|triangle| [self.area_vector(triangle).normalize().as_vec3(); 3]);
        let normals = normals.collect();
        let sources: Vec<_> = self.triangles.as_flattened().to_vec();
        self.pick_vertices(&sources);
        self.normals = normals;
        // The number of corners was checked to fit when the triangles were read.
        for (i, triangle) in self.triangles.iter_mut().enumerate() {
            *triangle = std::array::from_fn(|corner| (3 * i + corner) as u32);
        }
    }

    /// Replaces the vertices by copies of those named; the triangles are the caller's to correct.
    pub(super) fn pick_vertices(&mut self, sources: &[u32]) {
        fn pick<T: Copy>(values: &mut Vec<T>, sources: &[u32]) {
            // What the file lacks stays empty.
            if !values.is_empty() {
                *values = sources.iter().map(|&source| values[source as usize]).collect();
            }
        }
        pick(&mut self.positions, sources);
        pick(&mut self.normals, sources);
        pick(&mut self.tangents, sources);
        self.uvs.iter_mut().for_each(|uvs| pick(uvs, sources));
    }

    /// Mesh area and UV area of a set that the primitive has.
    pub(super) fn areas(&self, tex_coord: usize) -> (f64, f64) {
        let uvs = &self.uvs[tex_coord];
        let mesh: f64 = self.triangles.iter().map(|triangle| self.area_vector(triangle).length()).sum();
        let uv: f64 = self
            .triangles
            .iter()
            .map(|triangle| {
                let [a, b, c]: [DVec2; 3] = triangle.map(|vertex| uvs[vertex as usize].as_dvec2());
                (b - a).perp_dot(c - a).abs()
            })
            .sum();
        (mesh / 2.0, uv / 2.0)
    }

    /// The front's normal, twice as long as the triangle's area. In f64 the products of f32 differences are exact but
    /// for extreme exponents, so that no area gives exactly zero.
    fn area_vector(&self, triangle: &[u32; 3]) -> DVec3 {
        let [a, b, c] = triangle.map(|vertex| self.positions[vertex as usize].as_dvec3());
        (b - a).cross(c - a)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn modes_become_lists() {
        let indices = [5, 6, 7, 8, 9];
        assert_eq!(assemble(Mode::Triangles, &indices[..3]), Some(vec![[5, 6, 7]]));
        assert_eq!(assemble(Mode::TriangleStrip, &indices), Some(vec![[5, 6, 7], [6, 8, 7], [7, 8, 9]]));
        assert_eq!(assemble(Mode::TriangleFan, &indices), Some(vec![[6, 7, 5], [7, 8, 5], [8, 9, 5]]));
        assert_eq!(assemble(Mode::TriangleFan, &[]), Some(Vec::new()));
        assert_eq!(assemble(Mode::LineStrip, &indices), None);
    }
}
