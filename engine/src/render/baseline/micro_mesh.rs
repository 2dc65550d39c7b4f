//! A pre-tessellated mesh of the displaced surface: compact vertices, 16-bit indices, clusters that can be culled.

use std::collections::{HashMap, HashSet};

use bytemuck::{Pod, Zeroable};
use glam::{DVec2, DVec3, Vec2};
use rayon::prelude::*;

use super::clusters::{self, ChunkRange, Cluster, Clusters};
use super::surface::{Surface, edge_of};
use crate::error::{Error, Result};
use crate::render::plan::{PlannedPrimitive, source};
use crate::scene::Scene;

/// Densest mesh: the vertices of one base triangle still have 16-bit indices.
pub const MAX_DENSITY: u32 = 256;

/// Vertices of a chunk: as many as 16-bit indices reach.
const CHUNK_VERTICES: usize = 1 << 16;

/// A vertex, in the layout of `shaders/baseline/micro_mesh.vert`.
#[derive(Clone, Copy, Debug, Pod, Zeroable, PartialEq)]
#[repr(C)]
pub struct MicroVertex {
    /// Relative to the primitive's centre.
    pub position: [f32; 3],
    /// Octahedral, 16 bits signed normalised.
    pub normal: [i16; 2],
    /// As in the file.
    pub uv: [f32; 2],
}

/// Some base triangles with vertices of their own. Where two chunks meet, their vertices are the same to the bit.
struct Chunk {
    vertices: Vec<MicroVertex>,
    indices: Vec<u16>,
    clusters: Vec<Cluster>,
}

/// The mesh of one primitive.
pub struct MicroMesh {
    /// All chunks' vertices.
    pub vertices: Vec<MicroVertex>,
    /// All chunks' triangles, cluster by cluster; each index counts from its chunk's first vertex.
    pub indices: Vec<u16>,
    /// What can be culled.
    pub clusters: Clusters,
}

impl MicroMesh {
    /// Cuts every base triangle of a displaced primitive into `density`² triangles. `center`: the mesh-space point
    /// that positions are relative to.
    ///
    /// # Errors
    /// A density that is 0 or above [`MAX_DENSITY`], or a material that these vertices cannot carry.
    pub fn new(scene: &Scene, planned: &PlannedPrimitive, center: DVec3, density: u32) -> Result<Self> {
        check(scene, planned, density)?;
        let surface = Surface::new(scene, planned).ok_or_else(|| {
            Error::Usage(format!("mesh '{}': a micro-mesh needs displacement", scene.meshes[planned.mesh].name))
        })?;
        let triangles: Vec<u32> = (0..surface.triangles().len() as u32).collect();
        let chunks: Vec<Chunk> = triangles
            .par_chunks(chunk_triangles(density as usize))
            .map(|triangles| Builder::new(&surface, center, density).build(triangles))
            .collect();
        let mut mesh = MicroMesh { vertices: Vec::new(), indices: Vec::new(), clusters: Clusters::default() };
        for chunk in chunks {
            let first_index = mesh.indices.len() as u32;
            let Clusters { clusters, chunks } = &mut mesh.clusters;
            let first = clusters.len();
            clusters.extend(chunk.clusters.into_iter().map(|c| c.moved(first_index)));
            let first_vertex = mesh.vertices.len() as u32;
            chunks.push(ChunkRange { first_vertex, clusters: first..clusters.len() });
            mesh.vertices.extend(chunk.vertices);
            mesh.indices.extend(chunk.indices);
        }
        Ok(mesh)
    }

    /// The indices, each from the first vertex of all.
    pub fn absolute_indices(&self) -> Vec<u32> {
        let mut absolute = Vec::with_capacity(self.indices.len());
        for chunk in &self.clusters.chunks {
            let clusters = &self.clusters.clusters[chunk.clusters.clone()];
            let count = clusters.iter().map(|cluster| cluster.index_count as usize).sum::<usize>();
            let own = &self.indices[absolute.len()..][..count];
            absolute.extend(own.iter().map(|index| chunk.first_vertex + u32::from(*index)));
        }
        absolute
    }
}

/// Vertices and indices of what [`MicroMesh::new`] makes, counted without it.
///
/// # Errors
/// The same.
pub fn size(scene: &Scene, planned: &PlannedPrimitive, density: u32) -> Result<[usize; 2]> {
    check(scene, planned, density)?;
    let (primitive, n) = (source(scene, planned), density as usize);
    let chunk = |triangles: &[[u32; 3]]| {
        let corners: HashSet<u32> = triangles.iter().flatten().copied().collect();
        let edges = triangles.iter().flat_map(|[a, b, c]| [[*a, *b], [*b, *c], [*c, *a]]);
        let edges: HashSet<_> = edges.map(|edge| edge_of(&primitive.weld, edge)).collect();
        corners.len() + (n - 1) * edges.len() + (n - 1) * n.saturating_sub(2) / 2 * triangles.len()
    };
    let vertices = primitive.triangles.chunks(chunk_triangles(n)).map(chunk).sum();
    Ok([vertices, 3 * n * n * primitive.triangles.len()])
}

/// Base triangles of a chunk.
fn chunk_triangles(density: usize) -> usize {
    CHUNK_VERTICES / ((density + 1) * (density + 2) / 2)
}

fn check(scene: &Scene, planned: &PlannedPrimitive, density: u32) -> Result<()> {
    if !(1..=MAX_DENSITY).contains(&density) {
        let range = format!("a micro-mesh of density {density}: 1 to {MAX_DENSITY} triangles an edge are possible");
        return Err(Error::Usage(range));
    }
    check_material(scene, planned)
}

/// One set of texture coordinates and no tangent is all that a vertex has room for.
fn check_material(scene: &Scene, planned: &PlannedPrimitive) -> Result<()> {
    let material = &scene.materials[source(scene, planned).material];
    let set = material.displacement.map_or(0, |d| d.tex_coord);
    let others = material.textures().into_iter().flatten().any(|t| t.tex_coord != set);
    if material.normal.is_none() && !others {
        return Ok(());
    }
    Err(Error::input(
        &scene.file,
        format!("material '{}'", material.name),
        "the micro-mesh baseline has one UV set and no tangents",
        "compare on a material without normal map whose textures use the displacement's UV set",
    ))
}

/// Builds one chunk.
struct Builder<'a> {
    surface: &'a Surface,
    center: DVec3,
    density: u32,
    vertices: Vec<MicroVertex>,
    corners: HashMap<u32, u32>,
    /// First of the vertices inside an edge, which follow [`Surface::edge`]'s order.
    edges: HashMap<[u32; 2], u32>,
}

impl<'a> Builder<'a> {
    fn new(surface: &'a Surface, center: DVec3, density: u32) -> Self {
        let (vertices, corners, edges) = Default::default();
        Builder { surface, center, density, vertices, corners, edges }
    }

    fn build(mut self, triangles: &[u32]) -> Chunk {
        let n = self.density;
        let mut indices = Vec::with_capacity(triangles.len() * 3 * (n * n) as usize);
        // Row i holds the vertices with i steps away from corner 0; j of them toward corner 2.
        let mut ids = vec![0; ((n + 1) * (n + 2) / 2) as usize];
        let at = |i: u32, j: u32| (i * (i + 1) / 2 + j) as usize;
        for &triangle in triangles {
            for i in 0..=n {
                for j in 0..=i {
                    ids[at(i, j)] = self.vertex(triangle, [n - i, i - j, j]);
                }
            }
            for i in 0..n {
                for j in 0..=i {
                    indices.extend([ids[at(i, j)], ids[at(i + 1, j)], ids[at(i + 1, j + 1)]]);
                    if j < i {
                        indices.extend([ids[at(i, j)], ids[at(i + 1, j + 1)], ids[at(i, j + 1)]]);
                    }
                }
            }
        }
        let (vertices, indices, clusters) = clusters::build(&self.vertices, &indices);
        Chunk { vertices, indices, clusters }
    }

    /// The vertex of a triangle at so many `steps` of 1 / density toward each corner; one for all triangles there.
    fn vertex(&mut self, triangle: u32, steps: [u32; 3]) -> u32 {
        let (surface, n) = (self.surface, self.density);
        let corners = surface.triangles()[triangle as usize];
        if let Some(k) = steps.iter().position(|s| *s == n) {
            let v = corners[k];
            if let Some(known) = self.corners.get(&v) {
                return *known;
            }
            let id = self.push(surface.vertex(v), surface.vertex_normal(v), surface.uv(v).as_dvec2());
            self.corners.insert(v, id);
            return id;
        }
        if let Some(k) = steps.iter().position(|s| *s == 0) {
            let (a, b) = ((k + 1) % 3, (k + 2) % 3);
            let edge = surface.edge([corners[a], corners[b]]);
            let first = self.edge(edge);
            return first + if edge[0] == corners[a] { steps[b] } else { steps[a] } - 1;
        }
        let lambda = DVec3::from_array(steps.map(|s| f64::from(s) / f64::from(n)));
        let uv = (0..3).map(|k| surface.uv(corners[k]).as_dvec2() * lambda[k]).sum();
        self.push(surface.inside(triangle, lambda), surface.normal(triangle, lambda), uv)
    }

    /// First of the vertices inside an edge.
    fn edge(&mut self, edge: [u32; 2]) -> u32 {
        if let Some(first) = self.edges.get(&edge) {
            return *first;
        }
        let first = self.vertices.len() as u32;
        let [a, b] = edge.map(|v| self.surface.uv(v).as_dvec2());
        for step in 1..self.density {
            let s = f64::from(step) / f64::from(self.density);
            let (position, normal) = (self.surface.along_edge(edge, s), self.surface.edge_normal(edge, s));
            self.push(position, normal, a.lerp(b, s));
        }
        self.edges.insert(edge, first);
        first
    }

    fn push(&mut self, position: DVec3, normal: DVec3, uv: DVec2) -> u32 {
        let position = (position - self.center).as_vec3().to_array();
        self.vertices.push(MicroVertex { position, normal: octahedral(normal), uv: uv.as_vec2().to_array() });
        self.vertices.len() as u32 - 1
    }
}

/// A unit vector on the octahedron, unfolded (Meyer et al. 2010, "On floating-point normal vectors").
fn octahedral(n: DVec3) -> [i16; 2] {
    let sum = n.abs().element_sum();
    if sum == 0.0 {
        return [0, 0];
    }
    let p = n.truncate() / sum;
    let sign = |v: f64| if v < 0.0 { -1.0 } else { 1.0 };
    let folded = DVec2::new((1.0 - p.y.abs()) * sign(p.x), (1.0 - p.x.abs()) * sign(p.y));
    let p: Vec2 = if n.z < 0.0 { folded } else { p }.as_vec2();
    p.to_array().map(|v| meshopt::quantize_snorm(v, 16) as i16)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::render::plan;
    use crate::scene;
    use crate::settings::{Baseline, Culling, Settings, Stage};

    #[test]
    fn a_mesh_is_as_large_as_it_is_said_to_be() {
        for name in ["torus.gltf", "cube.gltf", "stability_seams.gltf", "cloth.gltf"] {
            let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets").join(name);
            let scene = scene::load(&path).unwrap();
            let baseline = Some(Baseline::MicroMesh { density: 1, culling: Culling::Off });
            let plan = plan::plan(&scene, &Settings { baseline, ..Settings::default() }, Stage::Mesh, false);
            for planned in plan.primitives.iter().filter(|planned| planned.shell.is_displaced()) {
                // Several chunks of a torus.
                for density in [1, 2, 3, 20] {
                    let mesh = MicroMesh::new(&scene, planned, DVec3::ZERO, density).unwrap();
                    let made = [mesh.vertices.len(), mesh.indices.len()];
                    assert_eq!(size(&scene, planned, density).unwrap(), made, "{name}, {density}");
                }
            }
        }
    }
}
