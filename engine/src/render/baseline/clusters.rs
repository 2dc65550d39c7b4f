//! Clusters of neighbouring triangles, and which of them a camera may see.

use std::ops::Range;

use glam::Vec3;
use meshopt::VertexDataAdapter;

use super::micro_mesh::MicroVertex;
use crate::render::layout::{Frame, Object};

/// Vertices and triangles of a cluster, as mesh shaders like them. Of 192 and 340, which would fill lavapipe's runs of
/// 1024 indices, a sixth less can be culled, and nothing is gained.
const MAX_VERTICES: usize = 64;
/// See [`MAX_VERTICES`].
const MAX_TRIANGLES: usize = 124;
/// How much the spread of normals counts beside the size when clusters grow: detail turns triangles every way.
const CONE_WEIGHT: f32 = 0.5;

/// Some triangles, and bounds of where they lie and where they face.
#[derive(Clone, Copy, Debug)]
pub struct Cluster {
    /// Place in the index buffer.
    pub first_index: u32,
    /// Three a triangle.
    pub index_count: u32,
    /// Sphere around its vertices.
    center: Vec3,
    radius: f32,
    /// All its triangles are seen from behind where the direction from this point to the eye is within the cone.
    apex: Vec3,
    axis: Vec3,
    /// Cosine; 1 or more where there is no such cone.
    cutoff: f32,
}

impl Cluster {
    /// The same, with its indices so much farther on.
    pub fn moved(self, indices: u32) -> Self {
        Cluster { first_index: self.first_index + indices, ..self }
    }
}

/// Clusters that share a range of vertices.
#[derive(Clone, Debug)]
pub struct ChunkRange {
    /// What index 0 means.
    pub first_vertex: u32,
    /// Range of [`Clusters::clusters`].
    pub clusters: Range<usize>,
}

/// A mesh's clusters, in the order of its indices.
#[derive(Clone, Debug, Default)]
pub struct Clusters {
    /// All of them.
    pub clusters: Vec<Cluster>,
    /// Those that share vertices.
    pub chunks: Vec<ChunkRange>,
}

/// Cuts a mesh into clusters: vertices and triangles in their order.
pub fn build(vertices: &[MicroVertex], indices: &[u32]) -> (Vec<MicroVertex>, Vec<u16>, Vec<Cluster>) {
    let bytes = bytemuck::cast_slice(vertices);
    let adapter = VertexDataAdapter::new(bytes, size_of::<MicroVertex>(), 0).expect("whole vertices");
    let meshlets = meshopt::build_meshlets(indices, &adapter, MAX_VERTICES, MAX_TRIANGLES, CONE_WEIGHT);
    let mut moved = vec![u32::MAX; vertices.len()];
    let mut ordered = Vec::with_capacity(vertices.len());
    let (mut all, mut clusters) = (Vec::with_capacity(indices.len()), Vec::with_capacity(meshlets.len()));
    for meshlet in meshlets.iter() {
        let bounds = meshopt::compute_meshlet_bounds(meshlet, &adapter);
        clusters.push(Cluster {
            first_index: all.len() as u32,
            index_count: meshlet.triangles.len() as u32,
            center: bounds.center.into(),
            radius: bounds.radius,
            apex: bounds.cone_apex.into(),
            axis: bounds.cone_axis.into(),
            cutoff: bounds.cone_cutoff,
        });
        for corner in meshlet.triangles {
            let vertex = meshlet.vertices[*corner as usize] as usize;
            if moved[vertex] == u32::MAX {
                moved[vertex] = ordered.len() as u32;
                ordered.push(vertices[vertex]);
            }
            all.push(moved[vertex] as u16);
        }
    }
    (ordered, all, clusters)
}

/// A camera as clusters are tested against it, in mesh space.
pub struct Sight {
    /// Unit normals into the frustum, and the distance of the origin from each plane.
    planes: Vec<(Vec3, f32)>,
    /// The eye, or the direction toward it.
    eye: Vec3,
    perspective: bool,
    double_sided: bool,
}

impl Sight {
    /// The camera of a frame and an object.
    pub fn new(frame: &Frame, object: &Object, double_sided: bool) -> Self {
        let [x, y, w] = [object.clip_x, object.clip_y, object.clip_w];
        let mut near = object.depth;
        near.w -= frame.lens.z;
        let mut far = -object.depth;
        far.w += frame.lens.w;
        let planes = [w + x, w - x, w + y, w - y, near, far]
            .into_iter()
            .map(|p| (p.truncate(), p.w, p.truncate().length()))
            .filter(|(_, _, length)| *length > 0.0)
            .map(|(normal, offset, length)| (normal / length, offset / length))
            .collect();
        Sight { planes, eye: object.eye.truncate(), perspective: object.eye.w != 0.0, double_sided }
    }

    /// Whether the hull of these points may reach into the picture.
    pub fn may_show(&self, points: &[Vec3]) -> bool {
        !self.planes.iter().any(|(normal, offset)| points.iter().all(|p| normal.dot(*p) + offset < 0.0))
    }

    fn sees(&self, c: &Cluster) -> bool {
        let outside = |(normal, offset): &(Vec3, f32)| normal.dot(c.center) + offset < -c.radius;
        if self.planes.iter().any(outside) {
            return false;
        }
        let away = if self.perspective { c.apex - self.eye } else { -self.eye };
        self.double_sided || c.cutoff >= 1.0 || away.dot(c.axis) < c.cutoff * away.length()
    }
}

/// One draw: neighbouring clusters of one chunk, all of them seen.
pub struct Run {
    /// Of the index buffer.
    pub indices: Range<u32>,
    /// What index 0 means.
    pub first_vertex: u32,
}

impl Clusters {
    /// What there is to draw: all, or with `cull` what the camera may see.
    pub fn visible(&self, frame: &Frame, object: &Object, double_sided: bool, cull: bool) -> Vec<Run> {
        let sight = cull.then(|| Sight::new(frame, object, double_sided));
        let mut runs: Vec<Run> = Vec::new();
        for chunk in &self.chunks {
            let mut open = false;
            for cluster in &self.clusters[chunk.clusters.clone()] {
                let end = cluster.first_index + cluster.index_count;
                let seen = sight.as_ref().is_none_or(|sight| sight.sees(cluster));
                match runs.last_mut() {
                    Some(run) if seen && open => run.indices.end = end,
                    _ if seen => {
                        runs.push(Run { indices: cluster.first_index..end, first_vertex: chunk.first_vertex });
                    }
                    _ => {}
                }
                open = seen;
            }
        }
        runs
    }
}
