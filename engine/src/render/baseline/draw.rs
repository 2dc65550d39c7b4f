//! A micro-mesh on the GPU.

use super::clusters::Clusters;
use super::micro_mesh::{MicroMesh, MicroVertex};
use crate::error::Result;
use crate::gpu::{Buffer, CommandEncoder, Uploader, VertexLayout, vk};
use crate::render::layout::{Frame, Object};

/// Where the vertex shader finds a [`MicroVertex`].
pub const VERTEX_LAYOUT: VertexLayout<'static> = VertexLayout {
    stride: size_of::<MicroVertex>() as u32,
    attributes: &[
        (vk::Format::R32G32B32_SFLOAT, 0),
        (vk::Format::R16G16_SNORM, std::mem::offset_of!(MicroVertex, normal) as u32),
        (vk::Format::R32G32_SFLOAT, std::mem::offset_of!(MicroVertex, uv) as u32),
    ],
};

/// A micro-mesh, ready to be drawn.
pub struct Drawable {
    vertices: Buffer,
    indices: Buffer,
    clusters: Clusters,
}

impl Drawable {
    /// Uploads a mesh.
    pub fn new(uploader: &mut Uploader, name: &str, mesh: MicroMesh) -> Result<Self> {
        use vk::BufferUsageFlags as U;
        Ok(Drawable {
            vertices: uploader.buffer(&format!("{name} micro-vertices"), U::VERTEX_BUFFER, &mesh.vertices)?,
            indices: uploader.buffer(&format!("{name} micro-indices"), U::INDEX_BUFFER, &mesh.indices)?,
            clusters: mesh.clusters,
        })
    }

    /// Bytes of the clusters, which stay on the CPU.
    pub fn host_bytes(&self) -> u64 {
        size_of_val(self.clusters.clusters.as_slice()) as u64
    }

    /// Records its draws; the pipeline and its sets are bound. `cull`: only the clusters that may be seen. They are
    /// found here, on the CPU, so no GPU time is charged for it.
    pub fn record(&self, cmd: &mut CommandEncoder, frame: &Frame, object: &Object, double_sided: bool, cull: bool) {
        cmd.bind_vertex_buffer(&self.vertices);
        cmd.bind_index_buffer(&self.indices, vk::IndexType::UINT16);
        for run in self.clusters.visible(frame, object, double_sided, cull) {
            let count = run.indices.end - run.indices.start;
            cmd.draw_indexed(count, 1, run.indices.start, run.first_vertex as i32, 0);
        }
    }
}
