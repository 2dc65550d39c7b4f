//! A micro-mesh on the GPU.

use super::clusters::Clusters;
use super::cull::{Sides, TriangleCull};
use super::micro_mesh::{MicroMesh, MicroVertex};
use crate::error::Result;
use crate::gpu::{Buffer, CommandEncoder, Context, ShaderCompiler, Uploader, VertexLayout, vk};
use crate::render::layout::{Frame, Object};
use crate::settings::Culling;

/// Where the vertex shader finds the parts of a vertex.
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
    /// With [`Culling::Triangles`].
    triangles: Option<TriangleCull>,
    cull_clusters: bool,
}

impl Drawable {
    /// Uploads a mesh.
    pub fn new(
        ctx: &Context,
        compiler: &ShaderCompiler,
        uploader: &mut Uploader,
        name: &str,
        mesh: MicroMesh,
        culling: Culling,
    ) -> Result<Self> {
        use vk::BufferUsageFlags as U;
        let read = if culling == Culling::Triangles { U::STORAGE_BUFFER } else { U::empty() };
        let vertices = uploader.buffer(&format!("{name} micro-vertices"), U::VERTEX_BUFFER | read, &mesh.vertices)?;
        let indices = uploader.buffer(&format!("{name} micro-indices"), U::INDEX_BUFFER | read, &mesh.indices)?;
        let triangles = (culling == Culling::Triangles)
            .then(|| TriangleCull::new(ctx, compiler, uploader, [&vertices, &indices], mesh.indices.len() / 3))
            .transpose()?;
        let cull_clusters = culling == Culling::Clusters;
        Ok(Drawable { vertices, indices, clusters: mesh.clusters, triangles, cull_clusters })
    }

    /// Bytes of the clusters, which stay on the CPU.
    pub fn host_bytes(&self) -> u64 {
        size_of_val(self.clusters.clusters.as_slice()) as u64
    }

    /// Records what has to run before the pass that draws it.
    pub fn prepare(&self, cmd: &mut CommandEncoder, frame: &Frame, object: &Object, sides: Sides) {
        if let Some(triangles) = &self.triangles {
            // A dispatch a chunk: one a run of clusters costs more than it saves.
            let runs = self.clusters.visible(frame, object, sides.double, false);
            triangles.record(cmd, frame, object, sides, &runs);
        }
    }

    /// Records its draws; the pipeline and its sets are bound. Clusters are culled here, on the CPU, so no GPU time is
    /// charged for it.
    pub fn record(&self, cmd: &mut CommandEncoder, frame: &Frame, object: &Object, sides: Sides) {
        cmd.bind_vertex_buffer(&self.vertices);
        if let Some(triangles) = &self.triangles {
            return triangles.draw(cmd);
        }
        cmd.bind_index_buffer(&self.indices, vk::IndexType::UINT16);
        for run in self.clusters.visible(frame, object, sides.double, self.cull_clusters) {
            let count = run.indices.end - run.indices.start;
            cmd.draw_indexed(count, 1, run.indices.start, run.first_vertex as i32, 0);
        }
    }
}
