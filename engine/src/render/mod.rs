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
pub mod explain;
mod geometry;
pub mod layout;
mod meshlets;
mod passes;
pub mod plan;
mod pyramid;
pub mod reload;
mod resolve;
mod resources;
mod shadow;
mod tangent_frames;
#[cfg(test)]
mod tests;
pub mod variant;
pub mod view;
mod visibility;

use std::collections::{HashMap, HashSet};
use std::path::Path;
use std::sync::Arc;

use glam::{DAffine3, DVec3};

use self::aov::AovTargets;
use self::baseline::{Diced, Drawable};
use self::culling::Culled;
use self::deform::{Deformer, Pose};
use self::depth_tiles::{DepthTiles, TilePass};
use self::layout::{Frame, Object};
use self::passes::{DrawPass, EDGES, Part, passes};
use self::plan::{
    Draw, Plan,
    fade::{self, Span},
};
use self::resolve::{Resolve, Samples};
use self::resources::{Images, Primitive, Slot};
use self::shadow::ShadowMaps;
use self::variant::{Geometry, Pass, Variant};
use self::view::View;
use self::visibility::Visibility;
use crate::aov::Aov;
use crate::error::{Error, Result};
use crate::gpu::{
    Access, Attachment, Binding, CommandEncoder, Context, DepthAttachment, DepthState, DescriptorSet, Feature,
    GraphicsDesc, Image, ImageDesc, Load, PassTimers, Pipeline, RenderingDesc, Shader, ShaderCompiler, Uploader, vk,
};
use crate::scene::{Camera, Light, Scene};
use crate::settings::{self, Dicer, PrismCulling, Settings, Stage};

/// Prisms that one mesh workgroup takes; the constant of the same name in `render/kept_prisms.glsl`.
const PRISMS_PER_GROUP: u32 = 24;

/// Prisms that one task workgroup looks at; the constant of the same name in `render/kept_prisms.glsl`.
const PRISMS_PER_TASK: u32 = 96;

/// Ends of a prism's nine edges; `render/edges.vert` counts on it.
const VERTICES_OF_EDGES: u32 = 18;

/// Depth: 32 bits, reversed, so that f32's precision near 0 serves the distance.
const DEPTH_FORMAT: vk::Format = vk::Format::D32_SFLOAT;

/// Lids and bases come nearer by a pixel of their slope and some ulp: the rasteriser's own depth may then promise that
/// no hit lies before it, though it moves corners to its grid.
const LID_DEPTH_BIAS: [f32; 2] = [64.0, 1.0];

/// Scene-linear colour behind everything, before tone mapping.
const BACKGROUND: [f32; 4] = [0.05, 0.06, 0.075, 1.0];

/// Device features that a scene needs under given settings.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Features {
    /// Without these nothing can be drawn.
    pub required: Vec<Feature>,
    /// Used where the device has them.
    pub optional: Vec<Feature>,
}

/// The features of `scene` under `settings`. `interactive`: the settings may change while it runs, so both stages are
/// asked for, neither insisted on.
pub fn features(scene: &Scene, settings: &Settings, interactive: bool) -> Features {
    let mut features = Features::default();
    if interactive {
        features.optional.extend([
            Feature::TaskShader,
            Feature::MeshShader,
            Feature::GeometryShader,
            Feature::SampleRateShading,
        ]);
        features.optional.push(Feature::FillModeNonSolid);
    }
    if settings.view == settings::View::Base {
        features.required.push(Feature::FillModeNonSolid);
    }
    if plan::may_shade_samples(scene, settings) {
        features.required.push(Feature::SampleRateShading);
    }
    if settings.counts() {
        features.required.push(Feature::FragmentStoresAndAtomics);
    }
    if plan::wants_shell(scene, settings) {
        match settings.stage {
            Stage::Mesh => features.required.push(Feature::MeshShader),
            Stage::Geometry => features.required.push(Feature::GeometryShader),
            Stage::Auto => features.optional.extend([Feature::MeshShader, Feature::GeometryShader]),
        }
    }
    if settings.stage != Stage::Geometry && plan::may_cull(scene, settings) {
        features.optional.push(Feature::TaskShader);
    }
    if let Some(by) = plan::dicer(scene, settings) {
        features.required.extend_from_slice(dicer_features(by));
    }
    features
}

/// What a baseline that dices needs of the device.
pub fn dicer_features(by: Dicer) -> &'static [Feature] {
    match by {
        Dicer::Tessellation => &[Feature::TessellationShader],
        Dicer::Mesh => &[Feature::TaskShader, Feature::MeshShader],
    }
}

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

/// Images of the picture's size.
struct Targets {
    depth: Image,
    /// Of `depth`, where hidden prisms are found.
    tiles: Option<DepthTiles>,
    /// Resolved to the caller's image, where a pixel has several samples.
    samples: Option<Samples>,
    aov: Option<AovTargets>,
    /// Depth of [`Plan::aov_draws`].
    aov_depth: Option<Image>,
    /// Where walks begin at the lids that it names.
    visibility: Option<Visibility>,
    /// Camera of the last recorded frame: AOV positions are relative to it.
    camera: DVec3,
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
        if settings.view == settings::View::Base && !self.ctx.has(Feature::FillModeNonSolid) {
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
            || plan.has_visibility() != self.plan.has_visibility();
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

    /// Records one frame. `slot` counts the frames in flight: what the frame last recorded with it reads is written
    /// anew. `target` is in the layout of [`Access::COLOR_WRITE`] before and after.
    pub fn record(
        &mut self,
        cmd: &mut CommandEncoder,
        slot: usize,
        camera: &Camera,
        target: &Image,
        mut timers: Option<&mut PassTimers>,
    ) -> Result<()> {
        // Until it is told otherwise, a mesh stands as in its file.
        for deformer in &mut self.deformers {
            deformer.record_rest(&self.ctx, cmd, slot, &self.scene)?;
        }
        let extent = target.extent();
        let view = View::new(camera, extent);
        self.resize(extent)?;
        while self.slots.len() <= slot {
            let index = self.slots.len();
            let (draws, lights) = (self.plan.draws.len(), self.lights.len());
            let maps = self.plan.shadow_maps.as_ref().map_or(0, |maps| maps.count() as usize);
            let label = format!("slot {index}");
            let counted = self.plan.draws.iter().any(|draw| draw.variant.cull.is_some_and(|cull| cull.counted));
            let counts = [self.settings.counts(), counted];
            self.slots.push(Slot::new(&self.ctx, &label, draws, lights, maps, counts)?);
        }
        let mapped = self.record_shadow_maps(cmd, slot, camera, extent, timers.as_deref_mut())?;
        let (mut objects, cut) = self.objects(&view, &self.plan.draws);
        let spans = self.fade(&view, &mut objects);
        let mut lights: Vec<_> = self.lights.iter().map(|light| view.light(light)).collect();
        for (light, maps) in lights.iter_mut().zip(&mapped.of_light) {
            light.set_maps(*maps);
        }
        let mut frame = view.frame(lights.len(), &self.scene.ambient);
        frame.origin.z = self.settings.occlusion_light;
        self.slots[slot].write(&frame, &objects, &lights, &mapped.views)?;
        self.targets.as_mut().expect("resize made them").camera = view.position;
        let targets = self.targets.as_ref().expect("resize made them");
        let mut extra: Vec<_> = self.shadow_maps.iter().map(ShadowMaps::binding).collect();
        extra.extend(targets.visibility.iter().flat_map(Visibility::bindings));
        extra.extend(targets.tiles.iter().map(|tiles| ("depth_tiles", Binding::Buffer(&tiles.tiles))));
        let drawn = self.plan.draws.iter().chain(&self.plan.aov_draws);
        for variant in drawn.flat_map(Draw::all_variants) {
            self.slots[slot].prepare(&self.ctx, &variant, &self.pipelines[&variant], &extra)?;
        }

        for depth in std::iter::once(&targets.depth).chain(&targets.aov_depth) {
            cmd.image_barrier(depth, Access::DEPTH_WRITE.discarded(), Access::DEPTH_WRITE);
        }
        if let Some(samples) = &targets.samples {
            cmd.image_barrier(&samples.image, Access::FRAGMENT_READ.discarded(), Access::COLOR_WRITE);
        }
        if let Some(aov) = &targets.aov {
            aov.begin(cmd);
        }
        let mut first = true;
        // Draws whose prisms the frame has tested, by round.
        let mut tested = HashSet::new();
        let culler = if self.plan.stage == Some(Stage::Mesh) { Access::TASK_WRITE } else { Access::COMPUTE_WRITE };
        for of_aov in [true, false] {
            let (draws, sets) = match of_aov {
                true => (&self.plan.aov_draws, &self.aov_sets),
                false => (&self.plan.draws, &self.sets),
            };
            for pass in passes(draws, of_aov) {
                if !first {
                    cmd.memory_barrier(Access::COLOR_WRITE, Access::COLOR_WRITE);
                    cmd.memory_barrier(Access::DEPTH_WRITE, Access::DEPTH_WRITE);
                }
                first = false;
                if let (Some(tile_pass), Some(tiles), 1..) = (&self.tile_pass, &targets.tiles, pass.round) {
                    if let Some(timers) = timers.as_deref_mut() {
                        timers.begin(cmd, slot, depth_tiles::PASS);
                    }
                    tile_pass.record(cmd, &targets.depth, tiles, culler);
                    if let Some(timers) = timers.as_deref_mut() {
                        timers.end(cmd);
                    }
                }
                let shown = |i: &&usize| draws[**i].variant.cull.is_some() && draws[**i].span == spans[**i];
                let fresh: Vec<_> =
                    pass.draws.iter().filter(shown).copied().filter(|i| tested.insert((*i, pass.round))).collect();
                if pass.lists(draws) {
                    if let Some(timers) = timers.as_deref_mut() {
                        timers.begin(cmd, slot, pass.culling());
                    }
                    for index in &fresh {
                        let draw = &draws[*index];
                        let (Some(variant), Some(culled), Some(set)) =
                            (&draw.cull, &self.culled[*index], &self.cull_sets[*index])
                        else {
                            continue;
                        };
                        let push =
                            layout::Draw { round: pass.round, counted: 1, ..self.push(draw, *index, cut[*index]) };
                        self.slots[slot].recount(cmd, culler);
                        culled.record(cmd, &self.pipelines[variant], [self.slots[slot].set(variant), set], &push);
                    }
                    if let Some(timers) = timers.as_deref_mut() {
                        timers.end(cmd);
                    }
                }
                if let Some(timers) = timers.as_deref_mut() {
                    timers.begin(cmd, slot, pass.name);
                }
                for index in &pass.draws {
                    let draw = &draws[*index];
                    if draw.span != spans[*index] {
                        continue;
                    }
                    if let Some(mesh) = &self.primitives[draw.primitive].micro_mesh {
                        mesh.prepare(cmd, &frame, &objects[*index], draw.variant.sides());
                    }
                }
                for culled in pass.draws.iter().filter_map(|index| self.culled[*index].as_ref()) {
                    culled.before_tasks(cmd);
                    self.slots[slot].recount(cmd, culler);
                }
                if let Some(visibility) = &targets.visibility {
                    visibility.before(cmd, pass.part, (!pass.clear[0]).then_some(&targets.depth));
                }
                self.begin_pass(cmd, &pass, target);
                for index in pass.draws {
                    let draw = &draws[index];
                    if draw.span != spans[index] {
                        continue;
                    }
                    let (variant, set) = match (&draw.depth, &draw.visibility) {
                        (Some(depth), _) if !pass.shades => (depth, self.depth_sets[index].as_ref()),
                        (_, Some(visibility)) if pass.part == Part::Write => {
                            (visibility, self.visibility_sets[index].as_ref())
                        }
                        _ => (&draw.variant, Some(&sets[index])),
                    };
                    let sets = [self.slots[slot].set(variant), set.expect("made with the variant")];
                    let counted = u32::from(fresh.contains(&index));
                    let resolves = u32::from(pass.part == Part::Resolve);
                    let push =
                        layout::Draw { round: pass.round, counted, resolves, ..self.push(draw, index, cut[index]) };
                    if resolves != 0 {
                        let Some([origin, extent]) = self.resolved(&view, draw) else { continue };
                        cmd.set_scissor(origin, extent);
                    }
                    self.record_draw(cmd, draw, variant, sets, index, &frame, &objects[index], &push);
                }
                cmd.end_rendering();
                if let Some(timers) = timers.as_deref_mut() {
                    timers.end(cmd);
                }
            }
        }
        if let (Some(resolve), Some(samples)) = (&self.resolve, &targets.samples) {
            resolve.record(cmd, samples, target);
        }
        self.slots[slot].end(cmd, culler);
        Ok(())
    }

    /// Begins a pass over all its targets.
    fn begin_pass(&self, cmd: &mut CommandEncoder, pass: &DrawPass, target: &Image) {
        let targets = self.targets.as_ref().expect("made before the first pass");
        let [clear_depth, clear_color] = pass.clear;
        if let (Some(visibility), Part::Write) = (&targets.visibility, pass.part) {
            return visibility.begin_pass(cmd, clear_depth);
        }
        let load = if clear_color { Load::Clear(BACKGROUND) } else { Load::Keep };
        let samples = targets.samples.as_ref().filter(|_| !pass.of_aov);
        let mut color = Vec::new();
        if pass.shades {
            let image = samples.map_or(target, |samples| &samples.image);
            color.push(Attachment { image, load, store: true, resolve: None });
            let writes = pass.name != EDGES && (pass.of_aov || targets.samples.is_none());
            let aov = targets.aov.as_ref().filter(|_| writes);
            color.extend(aov.iter().flat_map(|aov| aov.attachments(clear_color)));
        }
        let image = targets.aov_depth.as_ref().filter(|_| pass.of_aov).unwrap_or(&targets.depth);
        let depth = DepthAttachment { image, clear: clear_depth.then_some(0.0), store: true };
        let extent = target.extent();
        cmd.begin_rendering(&RenderingDesc { name: pass.name, color: &color, depth: Some(depth), extent });
    }

    /// What `draws` need of a view: each one's transforms, and whether the near plane may lie within its shell or under it.
    fn objects(&self, view: &View, draws: &[Draw]) -> (Vec<Object>, Vec<bool>) {
        let of = |draw: &Draw| {
            let (transform, primitive) = (&self.transforms[draw.instance], &self.primitives[draw.primitive]);
            // Where a pose reaches is known on the GPU only.
            let cut = primitive.rest.is_some() || view.near_plane_meets(transform, primitive.center, primitive.extent);
            (view.object(transform, primitive.center), cut)
        };
        draws.iter().map(of).unzip()
    }

    /// The span that each draw's instance is in, where its shells fade; completes their objects.
    fn fade(&self, view: &View, objects: &mut [Object]) -> Vec<Option<Span>> {
        let start = f64::from(self.settings.lod_fade.unwrap_or_default());
        let of = |(draw, object): (&Draw, &mut Object)| {
            draw.span?;
            let mesh = self.plan.primitives[draw.primitive].mesh;
            let parts = self.plan.primitives.iter().zip(&self.primitives).filter(|(planned, _)| planned.mesh == mesh);
            // The thickest shell of the mesh decides for all of it.
            let (extent, thickness) = parts.fold((DVec3::ZERO, 0.0), |(extent, thickness): (DVec3, f64), (_, part)| {
                (extent.max(part.extent), thickness.max(part.thickness))
            });
            let transform = &self.transforms[draw.instance];
            let fade = view.fade(extent, thickness * fade::stretch(transform), start);
            object.fade = fade.extent.as_vec3().extend(fade.scale as f32);
            let [nearest, farthest] = view.depths(transform, self.primitives[draw.primitive].center, extent);
            Some(fade.span(nearest, farthest))
        };
        self.plan.draws.iter().zip(objects).map(of).collect()
    }

    /// Where a draw's walks may begin, in pixels; nowhere if it lies outside the picture.
    fn resolved(&self, view: &View, draw: &Draw) -> Option<[[u32; 2]; 2]> {
        let primitive = &self.primitives[draw.primitive];
        // Where a pose reaches is known on the GPU only.
        let bounds = primitive.rest.is_none().then_some((primitive.center, primitive.extent));
        view.pixels(&self.transforms[draw.instance], bounds)
    }

    /// The push constants of a draw. `index`: of its object. `cut`: see [`Renderer::objects`].
    fn push(&self, draw: &Draw, index: usize, cut: bool) -> layout::Draw {
        let prism_count = draw.range.end;
        let mut push = layout::Draw { object: index as u32, count: prism_count, prism_count, ..Default::default() };
        if let Some(walk) = &self.primitives[draw.primitive].walk {
            push.bases = u32::from(walk.open || cut);
            if matches!(draw.variant.geometry, Geometry::Borders(_)) && !cut {
                push.count = walk.border_count;
            }
        }
        push
    }

    /// `variant`: the draw's, or what draws its depth. `sets`: 0 and 1. `index`: of the draw's object.
    #[allow(clippy::too_many_arguments)]
    fn record_draw(
        &self,
        cmd: &mut CommandEncoder,
        draw: &Draw,
        variant: &Variant,
        sets: [&DescriptorSet; 2],
        index: usize,
        frame: &Frame,
        object: &Object,
        push: &layout::Draw,
    ) {
        if push.count == 0 {
            // Some drivers compile at a pipeline's first draw, even of nothing.
            return;
        }
        let pipeline = &self.pipelines[variant];
        let primitive = &self.primitives[draw.primitive];
        cmd.bind_pipeline(pipeline);
        for (number, set) in (0..).zip(sets) {
            cmd.bind_set(pipeline, number, set);
        }
        if let Some(diced) = &primitive.diced {
            return diced.record(cmd, pipeline, push.object, frame, object);
        }
        cmd.push(pipeline, push);
        match draw.variant.geometry {
            // One workgroup, or primitive, makes the triangle over the picture.
            Geometry::Lids(Stage::Mesh) if push.resolves != 0 => cmd.draw_mesh_tasks(1, 1, 1),
            _ if push.resolves != 0 => cmd.draw(3, 1, 0, 0),
            _ if variant.cull.is_some() && draw.cull.is_some() => {
                if let Some(culled) = &self.culled[index] {
                    culled.draw(cmd, push.count);
                }
            }
            Geometry::Lids(Stage::Mesh) => {
                cmd.draw_mesh_tasks(primitive.walk.as_ref().map_or(0, |walk| walk.meshlets), 1, 1);
            }
            Geometry::PrismEdges => cmd.draw(VERTICES_OF_EDGES * push.count, 1, 0, 0),
            Geometry::Surface | Geometry::BaseEdges | Geometry::Lids(_) => {
                if let Some(indices) = &primitive.indices {
                    cmd.bind_index_buffer(indices, vk::IndexType::UINT32);
                    cmd.draw_indexed(3 * draw.range.end, 1, 0, 0, 0);
                }
            }
            Geometry::MicroMesh => {
                if let Some(mesh) = &primitive.micro_mesh {
                    mesh.record(cmd, frame, object, draw.variant.sides());
                }
            }
            Geometry::Diced { .. } => {}
            Geometry::Shell(Stage::Mesh) | Geometry::Borders(Stage::Mesh) => {
                let each = if variant.cull.is_some() { PRISMS_PER_TASK } else { PRISMS_PER_GROUP };
                cmd.draw_mesh_tasks(push.count.div_ceil(each), 1, 1);
            }
            Geometry::Shell(_) | Geometry::Borders(_) => cmd.draw(push.count, 1, 0, 0),
        }
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

    fn resize(&mut self, extent: [u32; 2]) -> Result<()> {
        if self.targets.as_ref().is_some_and(|t| t.depth.extent() == extent) {
            return Ok(());
        }
        let samples = vk::SampleCountFlags::from_raw(self.settings.msaa);
        let image = |name, format, samples, usage| {
            Image::new(&self.ctx, &ImageDesc { name, extent, format, mips: 1, samples, usage })
        };
        let one = vk::SampleCountFlags::TYPE_1;
        let depth_usage = vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT;
        let read = if self.tile_pass.is_some() { vk::ImageUsageFlags::SAMPLED } else { vk::ImageUsageFlags::empty() };
        let named = self.plan.has_visibility();
        let copied = if named { vk::ImageUsageFlags::TRANSFER_SRC } else { vk::ImageUsageFlags::empty() };
        let depth = image("depth", DEPTH_FORMAT, samples, depth_usage | read | copied)?;
        let visibility = named.then(|| Visibility::new(&self.ctx, extent)).transpose()?;
        let tiles = self.tile_pass.as_ref().map(|pass| pass.tiles(&self.ctx, &depth)).transpose()?;
        if tiles.is_some() || visibility.is_some() {
            // Their sets name the old ones.
            self.slots.clear();
        }
        let format = self.output.color_format;
        let resolved = self.resolve.as_ref().map(|resolve| resolve.target(&self.ctx, extent, format, samples));
        let samples = resolved.transpose()?;
        let aov = self.output.aov.then(|| AovTargets::new(&self.ctx, extent)).transpose()?;
        let aov_depth = || image("depth of AOVs", DEPTH_FORMAT, one, depth_usage);
        let aov_depth = (samples.is_some() && self.output.aov).then(aov_depth).transpose()?;
        self.targets = Some(Targets { depth, tiles, samples, aov, aov_depth, visibility, camera: DVec3::ZERO });
        Ok(())
    }
}

/// A variant's shaders, one a stage.
fn variant_shaders(compiler: &ShaderCompiler, variant: &Variant) -> Result<Vec<Arc<Shader>>> {
    let defines = variant.defines();
    variant.shaders().iter().map(|(path, stage)| compiler.compile(path, *stage, &defines)).collect()
}

fn variant_pipeline(ctx: &Context, output: Output, variant: &Variant, shaders: &[Arc<Shader>]) -> Result<Pipeline> {
    if let (Pass::Cull, [shader]) = (variant.pass, shaders) {
        return Pipeline::compute(ctx, &variant.name(), shader);
    }
    let mut color_formats = Vec::new();
    if variant.pass == Pass::Visibility {
        color_formats.push(visibility::FORMAT);
    }
    if variant.pass == Pass::Shade {
        color_formats.push(output.color_format);
        if variant.aov {
            color_formats.extend(AovTargets::FORMATS);
        }
    }
    let outlines = matches!(variant.geometry, Geometry::Shell(_) | Geometry::Borders(_));
    let cull = if outlines || variant.double_sided { vk::CullModeFlags::NONE } else { vk::CullModeFlags::BACK };
    let front_face = if variant.mirrored { vk::FrontFace::CLOCKWISE } else { vk::FrontFace::COUNTER_CLOCKWISE };
    Pipeline::graphics(
        ctx,
        &GraphicsDesc {
            name: &variant.name(),
            shaders: &shaders.iter().collect::<Vec<_>>(),
            vertices: (variant.geometry == Geometry::MicroMesh).then_some(baseline::VERTEX_LAYOUT),
            color_formats: &color_formats,
            depth_format: Some(DEPTH_FORMAT),
            depth: match variant.geometry {
                _ if variant.depth_stands => {
                    DepthState { write: false, compare: vk::CompareOp::EQUAL, ..DepthState::REVERSED }
                }
                Geometry::BaseEdges | Geometry::PrismEdges => DepthState { write: false, ..DepthState::REVERSED },
                _ => DepthState::REVERSED,
            },
            cull,
            front_face,
            topology: match variant.geometry {
                _ if outlines => vk::PrimitiveTopology::POINT_LIST,
                Geometry::Diced { .. } => vk::PrimitiveTopology::PATCH_LIST,
                Geometry::PrismEdges => vk::PrimitiveTopology::LINE_LIST,
                _ => vk::PrimitiveTopology::TRIANGLE_LIST,
            },
            samples: vk::SampleCountFlags::from_raw(variant.samples.into()),
            polygon_mode: match variant.geometry {
                Geometry::BaseEdges => vk::PolygonMode::LINE,
                _ => vk::PolygonMode::FILL,
            },
            blend: false,
            depth_bias: matches!(variant.geometry, Geometry::Lids(_) | Geometry::BaseEdges).then_some(LID_DEPTH_BIAS),
        },
    )
}
