//! The passes of a deforming mesh: their pipelines, buffers and descriptor sets.

use std::{ops::Range, sync::Arc};

use super::topology::Topology;
use crate::error::Result;
use crate::gpu::{
    Access, Binding, Buffer, BufferDesc, CommandEncoder, Context, DescriptorSet, MemoryLocation, Pipeline,
    ShaderCompiler, ShaderStage, Uploader, vk,
};
use crate::render::layout::{DeformFrame, DeformPass};
use crate::render::resources::Primitive;

/// Rounds of the fold rule, a bit each; a vertex is halved 7 times at most, but a halving can fold a neighbour that
/// held before.
pub const ROUNDS: u32 = 30;

/// Invocations of a workgroup; `local_size_x` of `render/deform.glsl`.
const GROUP: u32 = 64;

/// Largest dispatch along one axis that every device allows.
const MOST_GROUPS: u32 = 65_535;

/// Most items of a pass.
pub const MOST_ITEMS: u32 = GROUP * MOST_GROUPS;

/// One pass.
struct Step {
    pipeline: Arc<Pipeline>,
    set: DescriptorSet,
    /// Its items; the passes over them wait for each other. See [`DeformPass::first`].
    parts: Vec<Range<u32>>,
}

fn one_part(first: u32, count: u32) -> Vec<Range<u32>> {
    vec![Range { start: first, end: first + count }]
}

/// A mesh's passes and what they share.
pub struct Passes {
    buffers: Buffers,
    /// Vertices whose normals are given, and those whose are not.
    given: Pipeline,
    gathered: Pipeline,
    shells: Step,
    /// Where a shell is drawn.
    folds: Option<Step>,
    /// Where it is walked.
    leans: Option<Step>,
    /// What the renderer reads, primitive by primitive.
    writes: Vec<Step>,
    /// What every pass is told.
    common: DeformPass,
    vertices: u32,
}

/// Buffers of the whole mesh, named as in `render/deform.glsl`.
pub(super) struct Buffers {
    mesh_vertices: Buffer,
    triangles: Buffer,
    fans: Buffer,
    posed: Buffer,
    pub shell_normals: Buffer,
    pub folds: Buffer,
    plains: Buffer,
}

/// Their names after the mesh's, and their bytes.
pub(super) fn buffers(topology: &Topology) -> [(&'static str, usize); 7] {
    let welds = topology.welds as usize;
    [
        ("deforming vertices", size_of_val(&topology.vertices[..])),
        ("deforming triangles", size_of_val(&topology.triangles[..])),
        ("fans", size_of_val(&topology.fans[..])),
        ("pose", size_of::<DeformFrame>() * topology.vertices.len()),
        ("shell normals", size_of::<[f32; 4]>() * welds),
        ("folds", size_of::<u32>() * (welds + ROUNDS as usize + 1)),
        ("plain triangles", size_of::<u32>() * topology.triangles.len()),
    ]
}

impl Buffers {
    fn new(ctx: &Context, name: &str, topology: &Topology) -> Result<Self> {
        use vk::BufferUsageFlags as U;
        let mut uploader = Uploader::new(ctx)?;
        let mut upload = |(what, _): (&str, usize), bytes: &[u8]| {
            uploader.buffer(&format!("{name} {what}"), vk::BufferUsageFlags::STORAGE_BUFFER, bytes)
        };
        let [vertices, faces, lists, posed, shell_normals, folds, plains] = buffers(topology);
        let mesh_vertices = upload(vertices, bytemuck::cast_slice(&topology.vertices))?;
        let triangles = upload(faces, bytemuck::cast_slice(&topology.triangles))?;
        let fans = upload(lists, bytemuck::cast_slice(&topology.fans))?;
        uploader.finish()?;
        let buffer = |(what, size): (&str, usize)| {
            let name = format!("{name} {what}");
            // The sources of transfers are for the test, which reads them back.
            let usage = U::STORAGE_BUFFER | U::TRANSFER_DST | U::TRANSFER_SRC;
            Buffer::new(ctx, &BufferDesc { name: &name, size: size as u64, usage, location: MemoryLocation::GpuOnly })
        };
        Ok(Buffers {
            mesh_vertices,
            triangles,
            fans,
            posed: buffer(posed)?,
            shell_normals: buffer(shell_normals)?,
            folds: buffer(folds)?,
            plains: buffer(plains)?,
        })
    }

    fn set(&self, ctx: &Context, pipeline: &Pipeline, more: &[(&str, Binding<'_>)]) -> Result<DescriptorSet> {
        let shared = [
            ("mesh_vertices", Binding::Buffer(&self.mesh_vertices)),
            ("triangles", Binding::Buffer(&self.triangles)),
            ("fans", Binding::Buffer(&self.fans)),
            ("posed", Binding::Buffer(&self.posed)),
            ("shell_normals", Binding::Buffer(&self.shell_normals)),
            ("folds", Binding::Buffer(&self.folds)),
            ("plains", Binding::Buffer(&self.plains)),
        ];
        DescriptorSet::with_optional(ctx, pipeline, 0, more, &shared)
    }
}

impl Passes {
    /// Makes them. `primitives`: those of the mesh.
    pub fn new(
        ctx: &Context,
        compiler: &ShaderCompiler,
        name: &str,
        topology: &Topology,
        primitives: &[Primitive],
    ) -> Result<Self> {
        let pipeline = |pass: &str, define: Option<&'static str>| {
            let defines: Vec<_> = define.map(|define| (define, String::new())).into_iter().collect();
            let shader = compiler.compile(&format!("render/deform_{pass}.comp"), ShaderStage::Compute, &defines)?;
            Pipeline::compute(ctx, &format!("deform {pass}"), &shader)
        };
        let buffers = Buffers::new(ctx, name, topology)?;
        let step = |pass: &str, count: usize| {
            let pipeline = Arc::new(pipeline(pass, None)?);
            let set = buffers.set(ctx, &pipeline, &[])?;
            Ok::<_, crate::error::Error>(Step { pipeline, set, parts: one_part(0, count as u32) })
        };
        let shelled = primitives.iter().any(|primitive| primitive.prisms.is_some());
        let walked = primitives.iter().any(|primitive| primitive.walk.is_some());
        let triangles = topology.triangles.len();
        let mut passes = Passes {
            given: pipeline("vertices", Some("NORMALS_GIVEN"))?,
            gathered: pipeline("vertices", None)?,
            shells: step("shells", topology.welds as usize)?,
            folds: shelled.then(|| step("folds", triangles)).transpose()?,
            leans: walked.then(|| step("leans", triangles)).transpose()?,
            writes: Vec::new(),
            common: DeformPass {
                center: primitives.first().map_or(glam::Vec4::ZERO, |p| p.center.as_vec3().extend(0.0)),
                rounds: ROUNDS,
                welds: topology.welds,
                weld_fans: 0,
                smooth_fans: topology.smooth_fans,
                vertex_fans: topology.vertex_fans,
                ..DeformPass::default()
            },
            vertices: topology.vertices.len() as u32,
            buffers,
        };
        let written = |tangents: bool| {
            let some = primitives.iter().any(|primitive| primitive.tangents.is_some() == tangents);
            let define = tangents.then_some("VERTEX_TANGENTS");
            some.then(|| pipeline("write_vertices", define).map(Arc::new)).transpose()
        };
        let vertices = [written(false)?, written(true)?];
        let prisms = shelled.then(|| pipeline("write_prisms", None).map(Arc::new)).transpose()?;
        let walks = walked.then(|| pipeline("write_prisms", Some("WALKED")).map(Arc::new)).transpose()?;
        let fitted = primitives.iter().any(|primitive| primitive.hierarchy.is_some());
        let boxes = fitted.then(|| pipeline("fit_boxes", None).map(Arc::new)).transpose()?;
        for (primitive, firsts) in primitives.iter().zip(&topology.firsts) {
            let vertices = vertices[usize::from(primitive.tangents.is_some())].as_ref();
            passes.add_writes(ctx, primitive, *firsts, vertices, [prisms.as_ref(), walks.as_ref()])?;
            passes.add_boxes(ctx, primitive, boxes.as_ref())?;
        }
        Ok(passes)
    }

    /// The passes that write what the renderer reads of one primitive. `prisms`: without and with a walk.
    fn add_writes(
        &mut self,
        ctx: &Context,
        primitive: &Primitive,
        [first_vertex, first_triangle]: [u32; 2],
        vertices: Option<&Arc<Pipeline>>,
        [prisms, walked]: [Option<&Arc<Pipeline>>; 2],
    ) -> Result<()> {
        let (Some(rest), Some(vertices), Some(posed)) = (&primitive.rest, vertices, &primitive.vertices) else {
            return Ok(());
        };
        let mut bindings =
            vec![("rest_vertices", Binding::Buffer(&rest.vertices)), ("vertices", Binding::Buffer(posed))];
        bindings.extend(primitive.tangents.as_ref().map(|tangents| ("tangents", Binding::Buffer(tangents))));
        let set = self.buffers.set(ctx, vertices, &bindings)?;
        let parts = one_part(first_vertex, rest.vertex_count);
        self.writes.push(Step { pipeline: vertices.clone(), set, parts });
        let (Some(from), Some(to)) = (&rest.prisms, &primitive.prisms) else { return Ok(()) };
        let mut bindings = vec![("rest_prisms", Binding::Buffer(from)), ("prisms", Binding::Buffer(to))];
        let adjacency = rest.adjacency.as_ref().zip(primitive.walk.as_ref().and_then(|walk| walk.adjacency()));
        if let Some((from, to)) = adjacency {
            bindings.extend([("rest_adjacency", Binding::Buffer(from)), ("adjacency", Binding::Buffer(to))]);
        }
        if let Some(pipeline) = if adjacency.is_some() { walked } else { prisms } {
            let set = self.buffers.set(ctx, pipeline, &bindings)?;
            let parts = one_part(first_triangle, rest.prism_count);
            self.writes.push(Step { pipeline: pipeline.clone(), set, parts });
        }
        Ok(())
    }

    /// The passes that fit the boxes over one primitive's prisms to what has been written of these.
    fn add_boxes(&mut self, ctx: &Context, primitive: &Primitive, pipeline: Option<&Arc<Pipeline>>) -> Result<()> {
        let refit = primitive.rest.as_ref().and_then(|rest| rest.refit.as_ref());
        let (Some(refit), Some(boxes), Some(prisms), Some(vertices)) =
            (refit, &primitive.hierarchy, &primitive.prisms, &primitive.vertices)
        else {
            return Ok(());
        };
        let bindings = [
            ("vertices", Binding::Buffer(vertices)),
            ("prisms", Binding::Buffer(prisms)),
            ("boxes", Binding::Buffer(boxes)),
            ("order", Binding::Buffer(&refit.order)),
            ("MaterialBlock", Binding::Buffer(&primitive.material)),
        ];
        if let Some(pipeline) = pipeline {
            let set = self.buffers.set(ctx, pipeline, &bindings)?;
            self.writes.push(Step { pipeline: pipeline.clone(), set, parts: refit.parts.clone() });
        }
        Ok(())
    }

    /// Vertices of the mesh.
    pub fn vertices(&self) -> u32 {
        self.vertices
    }

    /// Records them. Each waits for the one before; the last frame's draws and passes are waited for.
    pub fn record(
        &self,
        ctx: &Context,
        cmd: &mut CommandEncoder,
        positions: &Buffer,
        normals: Option<&Buffer>,
    ) -> Result<()> {
        let pipeline = if normals.is_some() { &self.given } else { &self.gathered };
        let mut bindings = vec![("positions", Binding::Buffer(positions))];
        bindings.extend(normals.map(|normals| ("normals", Binding::Buffer(normals))));
        let set = self.buffers.set(ctx, pipeline, &bindings)?;
        cmd.region("deform", |cmd| {
            cmd.memory_barrier(Access::SHADER_READ, Access::TRANSFER_DST);
            cmd.fill_buffer(&self.buffers.folds, 0);
            cmd.memory_barrier(Access::TRANSFER_DST, Access::COMPUTE_WRITE);
            self.dispatch(cmd, pipeline, &set, DeformPass { count: self.vertices, ..self.common });
            let mut step = |step: &Step, round: u32| {
                for part in &step.parts {
                    let pass = DeformPass { count: part.len() as u32, first: part.start, round, ..self.common };
                    self.dispatch(cmd, &step.pipeline, &step.set, pass);
                }
            };
            step(&self.shells, 0);
            if let Some(folds) = &self.folds {
                (0..=ROUNDS).for_each(|round| step(folds, round));
            }
            self.leans.iter().chain(&self.writes).for_each(|pass| step(pass, 0));
            cmd.memory_barrier(Access::COMPUTE_WRITE, Access::SHADER_READ);
        });
        Ok(())
    }

    fn dispatch(&self, cmd: &mut CommandEncoder, pipeline: &Pipeline, set: &DescriptorSet, pass: DeformPass) {
        cmd.memory_barrier(Access::COMPUTE_WRITE, Access::COMPUTE_WRITE);
        cmd.bind_pipeline(pipeline);
        cmd.bind_set(pipeline, 0, set);
        cmd.push(pipeline, &pass);
        cmd.dispatch(pass.count.div_ceil(GROUP), 1, 1);
    }

    /// What the test reads back.
    #[cfg(test)]
    pub(super) fn buffers(&self) -> &Buffers {
        &self.buffers
    }
}
