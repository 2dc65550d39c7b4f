//! What a plan has on the GPU: images, buffers and descriptor sets.

mod images;
mod slot;

use std::ops::Range;

use glam::DVec3;

pub use self::images::{Images, color_format, height_mips_name, height_sampler, upload_height};
pub use self::slot::Slot;
use super::baseline::{Diced, Dicing, Drawable, MicroMesh};
use super::culling::Culled;
use super::geometry::{PrimitiveData, WalkData};
use super::plan::{Plan, PlannedPrimitive};
use super::variant::Variant;
use crate::error::Result;
use crate::gpu::{Binding, Buffer, Context, DescriptorSet, Pipeline, ShaderCompiler, Uploader, vk};
use crate::scene::Scene;
use crate::settings::{Baseline, Settings};

/// One primitive's buffers.
pub struct Primitive {
    /// Mesh-space point that its positions are relative to.
    pub center: DVec3,
    /// Triangles drawn as such; none where all are prisms.
    pub indices: Option<Buffer>,
    /// Drawn in place of its shell.
    pub micro_mesh: Option<Drawable>,
    /// The same, diced on the GPU.
    pub diced: Option<Diced>,
    /// What its pose overwrites, as uploaded: of a primitive that deforms.
    pub rest: Option<Rest>,
    /// With shell normals, or without.
    pub vertices: Option<Buffer>,
    pub surface_vertices: Option<Buffer>,
    /// UV sets that are read.
    pub uvs: [Option<Buffer>; 2],
    pub tangents: Option<Buffer>,
    pub prisms: Option<Buffer>,
    /// Boxes over them, where shadow rays want these.
    pub hierarchy: Option<Buffer>,
    pub material: Buffer,
    /// What the walk needs besides.
    pub walk: Option<Walk>,
    /// Half extents of a box around `center` that holds all of it, shell included.
    pub extent: DVec3,
    /// See [`PrimitiveData::thickness`].
    pub thickness: f64,
}

/// A deforming primitive's buffers as its file has them.
pub struct Rest {
    pub vertices: Buffer,
    pub vertex_count: u32,
    pub prism_count: u32,
    pub prisms: Option<Buffer>,
    pub adjacency: Option<Buffer>,
    /// Of the boxes over its prisms.
    pub refit: Option<Refit>,
}

/// The order in which boxes are fitted to a pose.
pub struct Refit {
    /// Their indices.
    pub order: Buffer,
    /// Parts of that order: the boxes of each need only those of the parts before.
    pub parts: Vec<Range<u32>>,
}

impl Rest {
    fn new(uploader: &mut Uploader, name: &str, data: &PrimitiveData) -> Result<Self> {
        let mut upload = |what: &str, bytes: &[u8]| {
            uploader.buffer(&format!("{name} {what} at rest"), vk::BufferUsageFlags::STORAGE_BUFFER, bytes)
        };
        Ok(Rest {
            vertices: upload("vertices", bytemuck::cast_slice(&data.vertices))?,
            vertex_count: data.vertices.len() as u32,
            prism_count: data.prisms.len() as u32,
            prisms: (!data.prisms.is_empty())
                .then(|| upload("prisms", bytemuck::cast_slice(&data.prisms)))
                .transpose()?,
            adjacency: data
                .walk
                .as_ref()
                .map(|walk| upload("adjacency", bytemuck::cast_slice(&walk.adjacency)))
                .transpose()?,
            refit: (!data.refit.is_empty()).then(|| Refit::new(uploader, name, &data.refit)).transpose()?,
        })
    }
}

impl Refit {
    fn new(uploader: &mut Uploader, name: &str, ranks: &[Vec<u32>]) -> Result<Self> {
        let order = ranks.concat();
        let order = uploader.buffer(&format!("{name} boxes' order"), vk::BufferUsageFlags::STORAGE_BUFFER, &order)?;
        let mut end = 0;
        let part = |rank: &Vec<u32>| {
            end += rank.len() as u32;
            end - rank.len() as u32..end
        };
        Ok(Refit { order, parts: ranks.iter().map(part).collect() })
    }
}

/// A walked primitive's buffers, by their names in the shaders.
pub struct Walk {
    buffers: Vec<(&'static str, Buffer)>,
    /// Meshlets of its lids.
    pub meshlets: u32,
    /// Borders in its list of prisms.
    pub border_count: u32,
    /// Whether bases may be seen from outside.
    pub open: bool,
}

impl Walk {
    fn new(uploader: &mut Uploader, name: &str, data: &WalkData) -> Result<Self> {
        let mut buffers = Vec::new();
        let mut upload = |what: &'static str, bytes: &[u8]| {
            if !bytes.is_empty() {
                let buffer = uploader.buffer(&format!("{name} {what}"), vk::BufferUsageFlags::STORAGE_BUFFER, bytes)?;
                buffers.push((what, buffer));
            }
            Ok(())
        };
        upload("adjacency", bytemuck::cast_slice(&data.adjacency))?;
        upload("lids", bytemuck::cast_slice(&data.lids))?;
        upload("borders", bytemuck::cast_slice(&data.borders))?;
        upload("meshlets", bytemuck::cast_slice(&data.meshlets.meshlets))?;
        upload("meshlet_vertices", bytemuck::cast_slice(&data.meshlets.vertices))?;
        upload("meshlet_triangles", bytemuck::cast_slice(&data.meshlets.triangles))?;
        let meshlets = data.meshlets.meshlets.len() as u32;
        Ok(Walk { buffers, meshlets, border_count: data.border_count, open: data.open })
    }

    /// Neighbour across each wall of each prism.
    pub fn adjacency(&self) -> Option<&Buffer> {
        self.buffers.iter().find(|(name, _)| *name == "adjacency").map(|(_, buffer)| buffer)
    }
}

/// Uploads the primitives of a plan.
pub fn upload(
    ctx: &Context,
    compiler: &ShaderCompiler,
    scene: &Scene,
    plan: &Plan,
    settings: &Settings,
) -> Result<Vec<Primitive>> {
    use vk::BufferUsageFlags as U;
    // The transfer is for the test of deforming meshes, which reads their vertices back.
    let storage = U::STORAGE_BUFFER | U::TRANSFER_SRC;
    let mut uploader = Uploader::new(ctx)?;
    let primitives = plan
        .primitives
        .iter()
        .enumerate()
        .map(|(index, planned)| {
            let data = PrimitiveData::new(scene, planned, settings);
            let name = format!("{}.{}", scene.meshes[planned.mesh].name, planned.primitive);
            let indices: &[u32] = data.indices.as_flattened();
            let indices = (!indices.is_empty())
                .then(|| uploader.buffer(&format!("{name} indices"), U::INDEX_BUFFER, indices))
                .transpose()?;
            let (mut micro_mesh, mut diced) = (None, None);
            if let Some(baseline) = settings.baseline.filter(|_| planned.shell.is_displaced()) {
                match baseline {
                    Baseline::MicroMesh { density, culling } => {
                        let mesh = MicroMesh::new(scene, planned, data.center, density)?;
                        let named = plan.names_triangles(index);
                        micro_mesh = Some(Drawable::new(ctx, compiler, &mut uploader, &name, mesh, culling, named)?);
                    }
                    Baseline::Diced { by, edge, culls } => {
                        let dicing = Dicing { by, edge, culls };
                        diced = Some(Diced::new(&mut uploader, &name, scene, planned, data.center, dicing)?);
                    }
                }
            }
            let prisms = (!data.prisms.is_empty())
                .then(|| uploader.buffer(&format!("{name} prisms"), U::STORAGE_BUFFER, &data.prisms))
                .transpose()?;
            let hierarchy = (!data.hierarchy.is_empty())
                .then(|| uploader.buffer(&format!("{name} hierarchy"), U::STORAGE_BUFFER, &data.hierarchy))
                .transpose()?;
            let mut stream = |what: &str, bytes: &[u8]| {
                (!bytes.is_empty()).then(|| uploader.buffer(&format!("{name} {what}"), storage, bytes)).transpose()
            };
            let vertices = stream("vertices", bytemuck::cast_slice(&data.vertices))?;
            let surface_vertices = stream("surface_vertices", bytemuck::cast_slice(&data.surface_vertices))?;
            let [uvs_0, uvs_1] = &data.uvs;
            let uvs = [stream("uvs_0", bytemuck::cast_slice(uvs_0))?, stream("uvs_1", bytemuck::cast_slice(uvs_1))?];
            let tangents = stream("tangents", bytemuck::cast_slice(&data.tangents))?;
            let rest = planned.deforms.then(|| Rest::new(&mut uploader, &name, &data)).transpose()?;
            let walk = data.walk.as_ref().map(|walk| Walk::new(&mut uploader, &name, walk)).transpose()?;
            Ok(Primitive {
                center: data.center,
                rest,
                walk,
                extent: data.extent,
                thickness: data.thickness,
                indices,
                micro_mesh,
                diced,
                vertices,
                surface_vertices,
                uvs,
                tangents,
                prisms,
                hierarchy,
                material: uploader.buffer(&format!("{name} material"), U::UNIFORM_BUFFER, &[data.material])?,
            })
        })
        .collect::<Result<_>>()?;
    uploader.finish()?;
    Ok(primitives)
}

impl Primitive {
    /// Set 1 of a draw of it by a variant's pipeline. `culled`: what is kept of it.
    #[allow(clippy::too_many_arguments)]
    pub fn set(
        &self,
        ctx: &Context,
        pipeline: &Pipeline,
        scene: &Scene,
        planned: &PlannedPrimitive,
        variant: &Variant,
        images: &Images,
        culled: Option<&Culled>,
    ) -> Result<DescriptorSet> {
        let mut bindings = images.bindings(scene, planned, variant);
        bindings.extend(culled.iter().flat_map(|culled| culled.bindings()));
        let [uvs_0, uvs_1] = &self.uvs;
        for (name, stream) in [
            ("vertices", &self.vertices),
            ("surface_vertices", &self.surface_vertices),
            ("uvs_0", uvs_0),
            ("uvs_1", uvs_1),
            ("tangents", &self.tangents),
        ] {
            bindings.extend(stream.as_ref().map(|stream| (name, Binding::Buffer(stream))));
        }
        bindings.push(("MaterialBlock", Binding::Buffer(&self.material)));
        bindings.extend(self.prisms.as_ref().map(|prisms| ("prisms", Binding::Buffer(prisms))));
        bindings.extend(self.micro_mesh.iter().flat_map(|mesh| mesh.bindings()));
        bindings.extend(self.diced.as_ref().map(|diced| ("diced_triangles", Binding::Buffer(diced.triangles()))));
        bindings.extend(self.hierarchy.as_ref().map(|boxes| ("shadow_hierarchy", Binding::Buffer(boxes))));
        if let Some(walk) = &self.walk {
            bindings.extend(walk.buffers.iter().map(|(name, buffer)| (*name, Binding::Buffer(buffer))));
        }
        // Optional: the compiler drops what a variant's optimised code does not read.
        DescriptorSet::with_optional(ctx, pipeline, 1, &[], &bindings)
    }
}
