//! A micro-mesh on the GPU.

use super::clusters::Clusters;
use super::cull::{Sides, TriangleCull, check_storage};
use super::micro_mesh::{MicroMesh, MicroVertex};
use crate::error::Result;
use crate::gpu::{Binding, Buffer, CommandEncoder, Context, ShaderCompiler, Uploader, VertexLayout, vk};
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
    /// A visibility buffer names its triangles: unless they are listed anew, its indices are absolute, of 32 bits.
    named: bool,
}

/// Bytes of an index of a mesh that is uploaded. `named`: a visibility buffer names its triangles.
pub fn bytes_of_index(culling: Culling, named: bool) -> usize {
    if named && culling != Culling::Triangles { size_of::<u32>() } else { size_of::<u16>() }
}

impl Drawable {
    /// Uploads a mesh. `named`: a visibility buffer names its triangles.
    ///
    /// # Errors
    /// Buffers larger than the device's shaders can address, where they read them.
    pub fn new(
        ctx: &Context,
        compiler: &ShaderCompiler,
        uploader: &mut Uploader,
        name: &str,
        mesh: MicroMesh,
        culling: Culling,
        named: bool,
    ) -> Result<Self> {
        use vk::BufferUsageFlags as U;
        let by_triangle = culling == Culling::Triangles;
        let read = if by_triangle || named { U::STORAGE_BUFFER } else { U::empty() };
        let vertices = uploader.buffer(&format!("{name} micro-vertices"), U::VERTEX_BUFFER | read, &mesh.vertices)?;
        let (what, usage) = (format!("{name} micro-indices"), U::INDEX_BUFFER | read);
        let indices = if named && !by_triangle {
            uploader.buffer(&what, usage, &mesh.absolute_indices())?
        } else {
            uploader.buffer(&what, usage, &mesh.indices)?
        };
        let count = mesh.indices.len() / 3;
        if named {
            check_storage(ctx, vertices.size().max(indices.size()), count, "use --visibility-buffer off")?;
        }
        let triangles = by_triangle
            .then(|| TriangleCull::new(ctx, compiler, uploader, [&vertices, &indices], count))
            .transpose()?;
        let cull_clusters = culling == Culling::Clusters;
        Ok(Drawable { vertices, indices, clusters: mesh.clusters, triangles, cull_clusters, named })
    }

    /// Bytes of the clusters, which stay on the CPU.
    pub fn host_bytes(&self) -> u64 {
        size_of_val(self.clusters.clusters.as_slice()) as u64
    }

    /// What named triangles are looked up in, by the names in the shaders.
    pub fn bindings(&self) -> Vec<(&'static str, Binding<'_>)> {
        if !self.named {
            return Vec::new();
        }
        let indices = self.triangles.as_ref().map_or(&self.indices, TriangleCull::kept);
        vec![("micro_vertices", Binding::Buffer(&self.vertices)), ("micro_indices", Binding::Buffer(indices))]
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
        if !self.named {
            cmd.bind_vertex_buffer(&self.vertices);
            cmd.bind_index_buffer(&self.indices, vk::IndexType::UINT16);
        }
        if let Some(triangles) = &self.triangles {
            return triangles.draw(cmd, self.named);
        }
        for run in self.clusters.visible(frame, object, sides.double, self.cull_clusters) {
            let (first, count) = (run.indices.start, run.indices.end - run.indices.start);
            if self.named {
                cmd.draw(count, 1, first, 0);
            } else {
                cmd.draw_indexed(count, 1, first, run.first_vertex as i32, 0);
            }
        }
    }
}
