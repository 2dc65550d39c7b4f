//! Culls a micro-mesh triangle by triangle on the GPU, into one indirect draw.

use ash::vk::{AccessFlags2 as A, PipelineStageFlags2 as S};
use bytemuck::{Pod, Zeroable};

use super::clusters::Run;
use crate::error::{Error, Result};
use crate::gpu::{
    Access, Binding, Buffer, BufferDesc, CommandEncoder, Context, DescriptorSet, MemoryLocation, Pipeline,
    ShaderCompiler, ShaderStage, Uploader, vk,
};
use crate::render::layout::{Frame, Object};

/// Who reads what is kept: draws, or vertices and fragments that a visibility buffer names triangles by.
const KEPT_READ: Access = Access::new(
    S::from_raw(S::INDEX_INPUT.as_raw() | S::VERTEX_SHADER.as_raw() | S::FRAGMENT_SHADER.as_raw()),
    A::from_raw(A::INDEX_READ.as_raw() | A::SHADER_READ.as_raw()),
    vk::ImageLayout::UNDEFINED,
);

/// Invocations of a workgroup; those of `baseline/micro_cull.comp`.
const GROUP: u32 = 64;

/// `VkDrawIndexedIndirectCommand` before a frame: no index yet, one instance.
const NOTHING: [u32; 5] = [0, 1, 0, 0, 0];

/// Push constants of one run of triangles.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct CullBlock {
    clip_x: [f32; 4],
    clip_y: [f32; 4],
    clip_w: [f32; 4],
    viewport: [f32; 2],
    first_index: u32,
    triangles: u32,
    first_vertex: u32,
    facing: f32,
}

/// Which sides of a primitive's triangles show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sides {
    /// Both.
    pub double: bool,
    /// The transform turns winding around.
    pub mirrored: bool,
}

/// Its buffers by name, for so many triangles, and their bytes.
pub fn buffers(triangles: usize) -> [(&'static str, usize); 3] {
    [
        ("micro-indices kept", 3 * size_of::<u32>() * triangles),
        ("micro-mesh command", size_of_val(&NOTHING)),
        ("micro-mesh command, empty", size_of_val(&NOTHING)),
    ]
}

/// Refuses what shaders would have to address beyond the device's limit. `mend`: what else could be asked for.
pub fn check_storage(ctx: &Context, bytes: u64, triangles: usize, mend: &str) -> Result<()> {
    let most = u64::from(ctx.limits().max_storage_buffer_range);
    if bytes <= most {
        return Ok(());
    }
    Err(Error::unsupported(
        format!("'{}' has no storage buffers above {most} bytes, for {triangles} triangles", ctx.device_name()),
        format!("{mend}, or make the micro-mesh coarser"),
    ))
}

/// The pass, and what it writes.
pub struct TriangleCull {
    pipeline: Pipeline,
    set: DescriptorSet,
    /// Indices of what is kept.
    kept: Buffer,
    command: Buffer,
    nothing: Buffer,
}

impl TriangleCull {
    /// For a mesh of so many triangles.
    ///
    /// # Errors
    /// Buffers larger than the device's shaders can address.
    pub fn new(
        ctx: &Context,
        compiler: &ShaderCompiler,
        uploader: &mut Uploader,
        [vertices, indices]: [&Buffer; 2],
        triangles: usize,
    ) -> Result<Self> {
        use vk::BufferUsageFlags as U;
        let [kept, command, nothing] = buffers(triangles);
        check_storage(ctx, vertices.size().max(kept.1 as u64), triangles, "cull by cluster")?;
        let buffer = |(name, bytes): (&str, usize), usage: U| {
            Buffer::new(ctx, &BufferDesc { name, size: bytes as u64, usage, location: MemoryLocation::GpuOnly })
        };
        let kept = buffer(kept, U::STORAGE_BUFFER | U::INDEX_BUFFER)?;
        let usage = U::STORAGE_BUFFER | U::INDIRECT_BUFFER | U::TRANSFER_DST;
        let command = buffer(command, usage)?;
        let shader = compiler.compile("baseline/micro_cull.comp", ShaderStage::Compute, &[])?;
        let pipeline = Pipeline::compute(ctx, "micro-mesh culling", &shader)?;
        let bindings = [
            ("micro_vertices", Binding::Buffer(vertices)),
            ("micro_indices", Binding::Buffer(indices)),
            ("kept", Binding::Buffer(&kept)),
            ("command", Binding::Buffer(&command)),
        ];
        let set = DescriptorSet::new(ctx, &pipeline, 0, &bindings)?;
        let nothing = uploader.buffer(nothing.0, U::TRANSFER_SRC, &NOTHING)?;
        Ok(TriangleCull { pipeline, set, kept, command, nothing })
    }

    /// Records the culling of `runs`, outside a pass.
    pub fn record(&self, cmd: &mut CommandEncoder, frame: &Frame, object: &Object, sides: Sides, runs: &[Run]) {
        cmd.buffer_barrier(&self.command, Access::INDIRECT_READ, Access::TRANSFER_DST);
        cmd.buffer_barrier(&self.kept, KEPT_READ, Access::COMPUTE_WRITE);
        cmd.copy_buffer(&self.nothing, 0, &self.command, 0, self.nothing.size());
        cmd.buffer_barrier(&self.command, Access::TRANSFER_DST, Access::COMPUTE_WRITE);
        cmd.bind_pipeline(&self.pipeline);
        cmd.bind_set(&self.pipeline, 0, &self.set);
        for run in runs {
            let triangles = (run.indices.end - run.indices.start) / 3;
            let block = CullBlock {
                clip_x: object.clip_x.to_array(),
                clip_y: object.clip_y.to_array(),
                clip_w: object.clip_w.to_array(),
                viewport: [frame.viewport.x, frame.viewport.y],
                first_index: run.indices.start,
                triangles,
                first_vertex: run.first_vertex,
                // Window coordinates grow downwards, so what is counter-clockwise on screen has a negative area.
                facing: f32::from(i8::from(!sides.double)) * if sides.mirrored { -1.0 } else { 1.0 },
            };
            cmd.push(&self.pipeline, &block);
            cmd.dispatch(triangles.div_ceil(GROUP), 1, 1);
        }
        cmd.buffer_barrier(&self.command, Access::COMPUTE_WRITE, Access::INDIRECT_READ);
        cmd.buffer_barrier(&self.kept, Access::COMPUTE_WRITE, KEPT_READ);
    }

    /// Indices of what is kept.
    pub fn kept(&self) -> &Buffer {
        &self.kept
    }

    /// Records the draw of what was kept. `looks_up`: the vertex stage reads the indices itself.
    pub fn draw(&self, cmd: &mut CommandEncoder, looks_up: bool) {
        if looks_up {
            // Of the same words: vertices, instances, and where both begin.
            return cmd.draw_indirect(&self.command, 1);
        }
        cmd.bind_index_buffer(&self.kept, vk::IndexType::UINT32);
        cmd.draw_indexed_indirect(&self.command);
    }
}
