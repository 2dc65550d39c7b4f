//! Meshes that change shape: each frame the GPU computes what depends on their positions, which is the shading normals
//! and tangents, the shell normals and how far they reach (DESIGN section 1), and which prisms are plain, irregular or
//! at a border. What follows from triangles, texture coordinates and map alone stays: adjacency, ranges of levels, lids.

mod passes;
#[cfg(test)]
mod tests;
mod topology;

use glam::Vec3;

use self::passes::{MOST_ITEMS, Passes};
use self::topology::Topology;
use super::plan::Plan;
use super::resources::Primitive;
use crate::error::{Error, Result};
use crate::gpu::{Buffer, BufferDesc, CommandEncoder, Context, MemoryLocation, ShaderCompiler, vk};
use crate::scene::{self, Scene};

/// A shape of a mesh.
#[derive(Clone, Copy)]
pub struct Pose<'a> {
    /// Of each vertex of its primitives, one primitive after the other; mesh space. f32 is taken relative to the middle
    /// of the mesh as its file has it: what goes far from there is moved by its instance's transform.
    pub positions: Vectors<'a>,
    /// Shading normals, unit. Where none are given, each vertex takes the mean of the triangles around it, weighted by
    /// corner angle: across seams, but not across hard edges of the file.
    pub normals: Option<Vectors<'a>>,
}

/// A vector for each vertex.
#[derive(Clone, Copy)]
pub enum Vectors<'a> {
    /// From the CPU.
    Slice(&'a [Vec3]),
    /// From the caller's own pass: three floats a vertex, which a barrier has made visible to
    /// [`crate::gpu::Access::COMPUTE_READ`].
    Buffer(&'a Buffer),
}

/// What poses one mesh.
pub struct Deformer {
    /// Index of the mesh.
    pub mesh: usize,
    name: String,
    passes: Passes,
    /// For each frame in flight: vectors from the CPU, positions and normals.
    slots: Vec<[Option<Buffer>; 2]>,
    posed: bool,
}

/// The buffers of all of the plan's meshes that deform, by name, and their bytes; those of the pose as their file has it.
pub fn buffers(scene: &Scene, plan: &Plan) -> Vec<(String, usize)> {
    let mut buffers = Vec::new();
    for (first, planned) in plan.primitives.iter().enumerate().filter(|(_, p)| p.deforms && p.primitive == 0) {
        let mesh = &scene.meshes[planned.mesh];
        let topology = Topology::new(scene, mesh, &plan.primitives[first..first + mesh.primitives.len()]);
        let of = |what: &str| format!("{} {what}", mesh.name);
        buffers.extend(passes::buffers(&topology).map(|(what, bytes)| (of(what), bytes)));
        let vectors = size_of::<Vec3>() * topology.vertices.len();
        buffers.extend(["positions", "normals"].map(|what| (of(&format!("{what} of slot 0")), vectors)));
    }
    buffers
}

/// One for each mesh of the plan that deforms. `primitives`: the plan's, uploaded.
pub fn deformers(
    ctx: &Context,
    compiler: &ShaderCompiler,
    scene: &Scene,
    plan: &Plan,
    primitives: &[Primitive],
) -> Result<Vec<Deformer>> {
    let mut deformers = Vec::new();
    for (first, planned) in plan.primitives.iter().enumerate() {
        if !planned.deforms || planned.primitive > 0 {
            continue;
        }
        let mesh = &scene.meshes[planned.mesh];
        let range = first..first + mesh.primitives.len();
        let topology = Topology::new(scene, mesh, &plan.primitives[range.clone()]);
        if topology.vertices.len().max(topology.triangles.len()) > MOST_ITEMS as usize {
            return Err(Error::unsupported(
                format!("mesh '{}' is to deform, with more than {MOST_ITEMS} triangles or vertices", mesh.name),
                "split the mesh",
            ));
        }
        let passes = Passes::new(ctx, compiler, &mesh.name, &topology, &primitives[range])?;
        let (mesh, name) = (planned.mesh, mesh.name.clone());
        deformers.push(Deformer { mesh, name, passes, slots: Vec::new(), posed: false });
    }
    Ok(deformers)
}

impl Deformer {
    /// Records the pose of the scene's file, unless there has been any.
    pub fn record_rest(&mut self, ctx: &Context, cmd: &mut CommandEncoder, slot: usize, scene: &Scene) -> Result<()> {
        if self.posed {
            return Ok(());
        }
        let gather = |of: fn(&scene::Primitive) -> &Vec<Vec3>| -> Vec<Vec3> {
            scene.meshes[self.mesh].primitives.iter().flat_map(of).copied().collect()
        };
        let (positions, normals) = (gather(|p| &p.positions), gather(|p| &p.normals));
        let pose = Pose { positions: Vectors::Slice(&positions), normals: Some(Vectors::Slice(&normals)) };
        self.record(ctx, cmd, slot, &pose)
    }

    /// Records the passes for a pose. The GPU must be done with the slot's last frame.
    pub fn record(&mut self, ctx: &Context, cmd: &mut CommandEncoder, slot: usize, pose: &Pose<'_>) -> Result<()> {
        if self.slots.len() <= slot {
            self.slots.resize_with(slot + 1, Default::default);
        }
        self.write(ctx, slot, 0, pose.positions)?;
        if let Some(normals) = pose.normals {
            self.write(ctx, slot, 1, normals)?;
        }
        let uploaded = &self.slots[slot];
        let positions = chosen(pose.positions, &uploaded[0]);
        let normals = pose.normals.and_then(|normals| chosen(normals, &uploaded[1]));
        if let Some(positions) = positions {
            self.passes.record(ctx, cmd, positions, normals)?;
            self.posed = true;
        }
        Ok(())
    }

    /// Writes vectors from the CPU into the slot's buffer; checks the caller's own.
    fn write(&mut self, ctx: &Context, slot: usize, which: usize, vectors: Vectors<'_>) -> Result<()> {
        let expected = self.passes.vertices() as usize;
        let what = ["positions", "normals"][which];
        let given = match vectors {
            Vectors::Slice(slice) => slice.len(),
            Vectors::Buffer(buffer) => buffer.size() as usize / size_of::<Vec3>(),
        };
        let fits = if matches!(vectors, Vectors::Slice(_)) { given == expected } else { given >= expected };
        if !fits {
            return Err(Error::Usage(format!(
                "mesh '{}' has {expected} vertices, and its pose {given} {what}",
                self.name
            )));
        }
        let Vectors::Slice(slice) = vectors else { return Ok(()) };
        let buffer = &mut self.slots[slot][which];
        if buffer.is_none() {
            let name = format!("{} {what} of slot {slot}", self.name);
            *buffer = Some(Buffer::new(
                ctx,
                &BufferDesc {
                    name: &name,
                    size: size_of_val(slice) as u64,
                    usage: vk::BufferUsageFlags::STORAGE_BUFFER,
                    location: MemoryLocation::CpuToGpu,
                },
            )?);
        }
        buffer.as_ref().map_or(Ok(()), |buffer| buffer.write(0, slice))
    }
}

/// The buffer that holds the vectors.
fn chosen<'a>(vectors: Vectors<'a>, uploaded: &'a Option<Buffer>) -> Option<&'a Buffer> {
    match vectors {
        Vectors::Buffer(buffer) => Some(buffer),
        Vectors::Slice(_) => uploaded.as_ref(),
    }
}
