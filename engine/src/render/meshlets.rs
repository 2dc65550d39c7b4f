//! The lids' triangles in meshlets: small sets of triangles over shared vertices, one mesh workgroup each.

use std::collections::HashMap;

use glam::{UVec2, UVec4, Vec3};

/// Vertices and triangles of a meshlet; those of `shaders/render/lids.mesh`.
const MOST_VERTICES: usize = 64;
const MOST_TRIANGLES: usize = 124;

/// A primitive's meshlets, as the shader reads them.
#[derive(Debug, Default)]
pub struct Meshlets {
    /// First vertex, first triangle, vertices, triangles of each.
    pub meshlets: Vec<UVec4>,
    /// The primitive's vertices.
    pub vertices: Vec<u32>,
    /// The triangle's index in the primitive; its three corners in the meshlet, 8 bits each.
    pub triangles: Vec<UVec2>,
}

/// Cuts those of `triangles` into meshlets whose index is in `kept`.
pub fn build(positions: &[Vec3], triangles: &[[u32; 3]], kept: impl Iterator<Item = usize>) -> Meshlets {
    let mut meshlets = Meshlets::default();
    // A triangle comes back with its corners turned, and where the file names it twice, twice.
    let mut names: HashMap<[u32; 3], Vec<u32>> = HashMap::new();
    let mut indices = Vec::new();
    for index in kept {
        indices.extend(triangles[index]);
        names.entry(turned(triangles[index])).or_default().push(index as u32);
    }
    if indices.is_empty() {
        return meshlets;
    }
    let adapter = meshopt::VertexDataAdapter::new(bytemuck::cast_slice(positions), size_of::<Vec3>(), 0)
        .expect("a stride of three floats, from the start");
    for meshlet in meshopt::build_meshlets(&indices, &adapter, MOST_VERTICES, MOST_TRIANGLES, 0.0).iter() {
        meshlets.meshlets.push(UVec4::new(
            meshlets.vertices.len() as u32,
            meshlets.triangles.len() as u32,
            meshlet.vertices.len() as u32,
            (meshlet.triangles.len() / 3) as u32,
        ));
        meshlets.vertices.extend(meshlet.vertices);
        for corners in meshlet.triangles.as_chunks::<3>().0 {
            let vertices = corners.map(|c| meshlet.vertices[usize::from(c)]);
            let name = names.get_mut(&turned(vertices)).and_then(Vec::pop).expect("meshlets only sort the triangles");
            let [a, b, c] = corners.map(u32::from);
            meshlets.triangles.push(UVec2::new(name, a | b << 8 | c << 16));
        }
    }
    meshlets
}

/// The same triangle with its least vertex first.
fn turned([a, b, c]: [u32; 3]) -> [u32; 3] {
    if a <= b && a <= c {
        [a, b, c]
    } else if b <= c {
        [b, c, a]
    } else {
        [c, a, b]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_triangle_is_in_one_meshlet_with_its_own_corners() {
        let side = 30u32;
        let positions: Vec<Vec3> =
            (0..side * side).map(|i| Vec3::new((i % side) as f32, 0.0, (i / side) as f32)).collect();
        let mut triangles = Vec::new();
        for i in (0..side * (side - 1)).filter(|i| i % side + 1 < side) {
            triangles.extend([[i, i + side, i + 1], [i + 1, i + side, i + side + 1]]);
        }
        // One of them twice, as a file may have it.
        triangles.push(triangles[7]);
        let built = build(&positions, &triangles, (0..triangles.len()).filter(|i| i % 5 != 0));
        let mut seen = vec![0; triangles.len()];
        for meshlet in &built.meshlets {
            assert!(meshlet.z as usize <= MOST_VERTICES && meshlet.w as usize <= MOST_TRIANGLES);
            for triangle in &built.triangles[meshlet.y as usize..(meshlet.y + meshlet.w) as usize] {
                let corner = |shift: u32| built.vertices[(meshlet.x + (triangle.y >> shift & 0xff)) as usize];
                let corners = [corner(0), corner(8), corner(16)];
                assert_eq!(turned(corners), turned(triangles[triangle.x as usize]));
                seen[triangle.x as usize] += 1;
            }
        }
        assert!(seen.iter().enumerate().all(|(i, n)| *n == u32::from(i % 5 != 0)), "{seen:?}");
    }
}
