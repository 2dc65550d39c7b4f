//! The renderer: a scene and its settings become a plan, the plan becomes pipelines and buffers, and a frame is
//! recorded into a command buffer that the caller hands over, so that another engine can embed it.

mod aov;
pub mod bake;
pub mod baseline;
mod blue_noise;
mod cones;
pub mod culling;
pub mod deform;
mod depth_tiles;
mod device_features;
pub mod explain;
mod geometry;
pub mod layout;
mod meshlets;
mod passes;
mod pipelines;
pub mod plan;
mod pyramid;
mod record;
pub mod reload;
mod resolve;
mod resources;
mod shadow;
mod tangent_frames;
mod targets;
#[cfg(test)]
mod tests;
pub mod variant;
pub mod view;
mod visibility;

use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

use glam::DAffine3;

use self::baseline::{Diced, Drawable};
use self::culling::Culled;
use self::deform::{Deformer, Pose};
use self::depth_tiles::TilePass;
pub use self::device_features::{Features, dicer_features, features, shell_stages};
use self::pipelines::{variant_pipeline, variant_shaders};
use self::plan::{Draw, Plan};
use self::resolve::Resolve;
use self::resources::{Images, Primitive, Slot};
use self::shadow::ShadowMaps;
use self::targets::Targets;
use self::variant::Variant;
use crate::aov::Aov;
use crate::error::{Error, Result};
use crate::gpu::{CommandEncoder, Context, DescriptorSet, Feature, PassTimers, Pipeline, ShaderCompiler, Uploader, vk};
use crate::scene::{Light, Scene};
use crate::settings::{PrismCulling, Settings, Stage, View};

/// Depth: 32 bits, reversed, so that f32's precision near 0 serves the distance.
const DEPTH_FORMAT: vk::Format = vk::Format::D32_SFLOAT;

/// A compiler that knows the shared structs. `shader_dir`: read shaders from there instead of from this binary.
pub fn shader_compiler(shader_dir: Option<&Path>) -> Result<ShaderCompiler> {
    let mut compiler = ShaderCompiler::new(shader_dir, crate::gpu::default_cache_dir().as_deref())?;
    compiler.provide("layout.glsl", layout::glsl());
    Ok(compiler)
}

/// What a renderer draws into.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Output {
    /// Format of the colour target that each frame brings; an sRGB one, as colours are linear after tone mapping.
    pub color_format: vk::Format,
    /// Also write the AOVs, for [`Renderer::read_aov`].
    pub aov: bool,
}

/// Pipelines that renderers of one context and colour format have in common: what one of them has made, the next one
/// finds compiled.
#[derive(Clone, Default)]
pub struct Pipelines(HashMap<Variant, Arc<Pipeline>>);

/// Draws one scene.
pub struct Renderer {
    ctx: Context,
    scene: Scene,
    settings: Settings,
    output: Output,
    transforms: Vec<DAffine3>,
    lights: Vec<Light>,
    plan: Plan,
    images: Images,
    primitives: Vec<Primitive>,
    pipelines: HashMap<Variant, Arc<Pipeline>>,
    /// Of the meshes that change shape.
    deformers: Vec<Deformer>,
    /// Set 1 of each draw.
    sets: Vec<DescriptorSet>,
    /// The same of those whose depth comes first.
    depth_sets: Vec<Option<DescriptorSet>>,
    /// The same of those that write the visibility buffer.
    visibility_sets: Vec<Option<DescriptorSet>>,
    /// Set 1 of each of [`Plan::aov_draws`].
    aov_sets: Vec<DescriptorSet>,
    slots: Vec<Slot>,
    /// By draw, where prisms are culled.
    culled: Vec<Option<Culled>>,
    /// Set 1 of what lists their prisms, by draw.
    cull_sets: Vec<Option<DescriptorSet>>,
    /// Where hidden prisms are found.
    tile_pass: Option<TilePass>,
    shadow_maps: Option<ShadowMaps>,
    /// Where a pixel has several samples.
    resolve: Option<Resolve>,
    targets: Option<Targets>,
}

impl Renderer {
    /// Plans `scene` and creates everything the plan names.
    ///
    /// # Errors
    /// [`Error::Unsupported`] where the device lacks the stage that the settings ask for, or cannot hold an image.
    pub fn new(
        ctx: &Context,
        compiler: &ShaderCompiler,
        scene: &Scene,
        settings: &Settings,
        output: Output,
    ) -> Result<Renderer> {
        Self::sharing(ctx, compiler, scene, settings, output, &mut Pipelines::default())
    }

    /// [`Renderer::new`], with what it needs of `pipelines`; those that it makes are added to them.
    pub fn sharing(
        ctx: &Context,
        compiler: &ShaderCompiler,
        scene: &Scene,
        settings: &Settings,
        output: Output,
        pipelines: &mut Pipelines,
    ) -> Result<Renderer> {
        let mut renderer = Renderer {
            ctx: ctx.clone(),
            scene: scene.clone(),
            settings: settings.clone(),
            output,
            transforms: scene.instances.iter().map(|i| i.transform).collect(),
            lights: scene.lights.clone(),
            plan: Plan::default(),
            images: Images::default(),
            primitives: Vec::new(),
            deformers: Vec::new(),
            pipelines: pipelines.0.clone(),
            sets: Vec::new(),
            depth_sets: Vec::new(),
            visibility_sets: Vec::new(),
            aov_sets: Vec::new(),
            slots: Vec::new(),
            culled: Vec::new(),
            cull_sets: Vec::new(),
            tile_pass: None,
            shadow_maps: None,
            resolve: None,
            targets: None,
        };
        renderer.set_settings(compiler, settings)?;
        pipelines.0.clone_from(&renderer.pipelines);
        Ok(renderer)
    }

    /// Plans anew for other settings; images stay. The caller's frames need not be done.
    pub fn set_settings(&mut self, compiler: &ShaderCompiler, settings: &Settings) -> Result<()> {
        let asked = settings;
        let settings = &settings.drawn();
        plan::check(&self.scene, settings)?;
        if settings.view == View::Base && !self.ctx.has(Feature::FillModeNonSolid) {
            return Err(Error::unsupported(
                format!("'{}' draws no edges of triangles, or was not asked to", self.ctx.device_name()),
                "use another --view, or another --gpu",
            ));
        }
        if let Some(by) = plan::dicer(&self.scene, settings)
            && let Some(lacking) = dicer_features(by).iter().find(|feature| !self.ctx.has(**feature))
        {
            return Err(Error::unsupported(
                format!("'{}' lacks the feature '{lacking}', or was not asked for it", self.ctx.device_name()),
                "use another --gpu or --baseline",
            ));
        }
        let stage = self.stage_for(settings)?;
        let plan = plan::plan(&self.scene, &self.cullable(settings, stage)?, stage, self.output.aov);
        self.images.complete(&self.ctx, compiler, &self.scene, &plan)?;
        let primitives = resources::upload(&self.ctx, compiler, &self.scene, &plan, settings)?;
        let blockers = plan.shadow_maps.as_ref().map_or(&[][..], |maps| &maps.draws);
        for draw in plan.draws.iter().chain(&plan.aov_draws).chain(blockers) {
            if draw.variant.per_sample && !self.ctx.has(Feature::SampleRateShading) {
                return Err(Error::unsupported(
                    format!("'{}' cannot shade each sample, or was not asked to", self.ctx.device_name()),
                    "use --msaa 1, or another --gpu",
                ));
            }
            for variant in draw.all_variants() {
                if !self.pipelines.contains_key(&variant) {
                    let pipeline = Arc::new(self.pipeline(compiler, &variant)?);
                    self.pipelines.insert(variant, pipeline);
                }
            }
        }
        let mut uploader = Uploader::new(&self.ctx)?;
        let culled = plan.draws.iter().enumerate().map(|(index, draw)| {
            draw.variant.cull.map(|_| Culled::new(&self.ctx, &mut uploader, index, draw)).transpose()
        });
        let culled = culled.collect::<Result<Vec<_>>>()?;
        uploader.finish()?;
        let set_of = |draw: &Draw, variant: &Variant, culled: Option<&Culled>| {
            let pipeline = &self.pipelines[variant];
            let planned = &plan.primitives[draw.primitive];
            primitives[draw.primitive].set(&self.ctx, pipeline, &self.scene, planned, variant, &self.images, culled)
        };
        let sets_of = |draws: &[Draw], of: fn(&Draw) -> Option<Variant>| {
            let set = |(draw, culled): (&Draw, &Option<Culled>)| {
                of(draw).map(|variant| set_of(draw, &variant, culled.as_ref())).transpose()
            };
            draws.iter().zip(&culled).map(set).collect::<Result<Vec<_>>>()
        };
        // Every draw has one of its own.
        let own = |draws| Ok(sets_of(draws, |draw| Some(draw.variant))?.into_iter().flatten().collect());
        let sets = own(&plan.draws)?;
        let depth_sets = sets_of(&plan.draws, |draw| draw.depth)?;
        let cull_sets = sets_of(&plan.draws, |draw| draw.cull)?;
        let visibility_sets = sets_of(&plan.draws, |draw| draw.visibility)?;
        let aov_sets = own(&plan.aov_draws)?;
        let shadow_maps = plan
            .shadow_maps
            .as_ref()
            .map(|maps| {
                let sets = maps.draws.iter().map(|draw| set_of(draw, &draw.variant, None)).collect::<Result<_>>()?;
                ShadowMaps::new(&self.ctx, maps, settings, sets)
            })
            .transpose()?;
        let tile_pass = plan.hides().then(|| TilePass::new(&self.ctx, compiler)).transpose()?;
        let deformers = deform::deformers(&self.ctx, compiler, &self.scene, &plan, &primitives)?;
        let format = self.output.color_format;
        let resolve = (settings.msaa > 1).then(|| Resolve::new(&self.ctx, compiler, format)).transpose()?;
        // Their samples and uses may be others, and their sets are of the pipelines.
        let others = resolve.is_some()
            || self.resolve.is_some()
            || tile_pass.is_some()
            || self.tile_pass.is_some()
            || plan.named() != self.plan.named();
        if others {
            self.targets = None;
        }
        self.resolve = resolve;
        self.slots.clear();
        self.settings = asked.clone();
        self.plan = plan;
        self.primitives = primitives;
        self.deformers = deformers;
        self.sets = sets;
        self.depth_sets = depth_sets;
        self.visibility_sets = visibility_sets;
        self.aov_sets = aov_sets;
        self.culled = culled;
        self.cull_sets = cull_sets;
        self.tile_pass = tile_pass;
        self.shadow_maps = shadow_maps;
        Ok(())
    }

    /// The settings in force.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// The plan in force.
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// Moves an instance.
    pub fn set_instance_transform(&mut self, instance: usize, transform: DAffine3) {
        self.transforms[instance] = transform;
    }

    /// Replaces a light, for the frames recorded from now on.
    ///
    /// # Panics
    /// Where the scene has no light of that index.
    pub fn set_light(&mut self, index: usize, light: Light) {
        self.lights[index] = light;
    }

    /// Gives a mesh whose [`crate::scene::Mesh::deforms`] is set a new shape, for this and all later frames: records
    /// the passes that compute what depends on it. `slot` is that of the frame, which is recorded next.
    ///
    /// # Errors
    /// A mesh that is not drawn or does not deform, or a pose with other than its number of vertices.
    pub fn deform(
        &mut self,
        cmd: &mut CommandEncoder,
        slot: usize,
        mesh: usize,
        pose: &Pose<'_>,
        mut timers: Option<&mut PassTimers>,
    ) -> Result<()> {
        let deformer = self.deformers.iter_mut().find(|deformer| deformer.mesh == mesh);
        let deformer = deformer.ok_or_else(|| Error::Usage(format!("mesh {mesh} is none of those that deform")))?;
        if let Some(timers) = timers.as_deref_mut() {
            timers.begin(cmd, slot, "deform");
        }
        let result = deformer.record(&self.ctx, cmd, slot, pose);
        if let Some(timers) = timers {
            timers.end(cmd);
        }
        result
    }

    /// The AOVs of the last recorded frame, once it has run; [`Output::aov`] must have been asked for.
    pub fn read_aov(&self) -> Result<Aov> {
        let targets = self.targets.as_ref().and_then(|t| Some((t.aov.as_ref()?, t.camera)));
        let (aov, camera) = targets.ok_or_else(|| Error::Usage("no frame with AOVs has been recorded".into()))?;
        aov.read(&self.ctx, camera)
    }

    /// Loops of the slot's last frame, which has run, that gave up at their limit: pixels that may be wrong. `None`
    /// unless [`Settings::count_limits`] is on.
    pub fn limits_reached(&self, slot: usize) -> Result<Option<u32>> {
        if !self.settings.count_limits {
            return Ok(None);
        }
        Ok(self.slots.get(slot).map_or(Ok(None), Slot::counted)?.map(|counted| counted.limits))
    }

    /// Reads of height maps, and of bounds and cones over them, by the fragments of the slot's last frame, which has run.
    /// `None` unless [`Settings::count_reads`] is on.
    pub fn height_reads(&self, slot: usize) -> Result<Option<u32>> {
        if !self.settings.count_reads {
            return Ok(None);
        }
        Ok(self.slots.get(slot).map_or(Ok(None), Slot::counted)?.map(|counted| counted.reads))
    }

    /// What became of the prisms of the slot's last frame, which has run. `None` where none are culled, or, by
    /// [`Settings::count_limits`], not counted.
    pub fn culled(&self, slot: usize) -> Result<Option<culling::Counts>> {
        self.slots.get(slot).map_or(Ok(None), Slot::culled)
    }

    /// Bytes of what a baseline keeps on the CPU to cull by.
    pub fn baseline_host_bytes(&self) -> u64 {
        let micro_meshes = self.primitives.iter().filter_map(|p| p.micro_mesh.as_ref()).map(Drawable::host_bytes);
        micro_meshes.chain(self.primitives.iter().filter_map(|p| p.diced.as_ref()).map(Diced::host_bytes)).sum()
    }

    /// The pipelines that a frame binds, by name.
    pub fn pipelines(&self) -> Vec<(String, &Pipeline)> {
        explain::variants(&self.plan).iter().map(|v| (v.name(), &*self.pipelines[v])).collect()
    }

    /// Mesh or geometry: what the settings ask for, or what the device has.
    fn stage_for(&self, settings: &Settings) -> Result<Stage> {
        if !plan::wants_shell(&self.scene, settings) {
            return Ok(settings.stage);
        }
        let lacks = |what: &str| {
            Error::unsupported(
                format!("'{}' has no {what}", self.ctx.device_name()),
                "ask for another --stage, another --gpu, or --shell off",
            )
        };
        match settings.stage {
            Stage::Mesh if !self.ctx.has(Feature::MeshShader) => Err(lacks("mesh stage")),
            Stage::Geometry if !self.ctx.has(Feature::GeometryShader) => Err(lacks("geometry stage")),
            Stage::Auto if self.ctx.has(Feature::MeshShader) => Ok(Stage::Mesh),
            Stage::Auto if self.ctx.has(Feature::GeometryShader) => Ok(Stage::Geometry),
            Stage::Auto => Err(lacks("mesh or geometry stage")),
            asked => Ok(asked),
        }
    }

    /// The settings, without culling where the device's mesh stage has no task stage before it.
    fn cullable(&self, settings: &Settings, stage: Stage) -> Result<Settings> {
        if stage != Stage::Mesh || self.ctx.has(Feature::TaskShader) {
            return Ok(settings.clone());
        }
        match settings.prism_culling {
            PrismCulling::Auto | PrismCulling::Off => {
                Ok(Settings { prism_culling: PrismCulling::Off, ..settings.clone() })
            }
            asked => Err(Error::unsupported(
                format!("'{}' has no task stage, or was not asked for it", self.ctx.device_name()),
                format!("use --stage geometry, or --prism-culling off in place of {asked}"),
            )),
        }
    }

    fn pipeline(&self, compiler: &ShaderCompiler, variant: &Variant) -> Result<Pipeline> {
        variant_pipeline(&self.ctx, self.output, variant, &variant_shaders(compiler, variant)?)
    }
}
