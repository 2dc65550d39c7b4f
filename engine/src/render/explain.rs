//! A plan, told: what is created for a scene, what is not, and why. For `prism explain` and for tests.

mod inventory;
mod parts;

use std::collections::BTreeMap;
use std::fmt;

use serde::Serialize;

use self::inventory::{BufferFact, ImageFact};
use super::passes::{DrawPass, Part, passes};
use super::plan::{self, Draw, Plan, PlannedPrimitive, ledger::Decision};
use super::variant::{MOST_VARIANTS, Variant};
use super::{Output, depth_tiles, features};
use crate::gpu::Feature;
use crate::scene::Scene;
use crate::settings::{Settings, Stage};

/// What the plan was made for, besides scene and settings.
#[derive(Clone, Debug)]
pub struct Situation {
    /// The device's name; none where the plan is for any that has the stage.
    pub device: Option<String>,
    /// Pixels of the picture.
    pub extent: [u32; 2],
    /// Texels that an image may have a side.
    pub max_image_2d: u32,
    /// What is drawn into.
    pub output: Output,
    /// There is a window to present to.
    pub window: bool,
}

/// All of it.
#[derive(Clone, Debug, Serialize)]
pub struct Explanation {
    /// The scene's file.
    pub scene: String,
    /// The device, if it was asked.
    pub device: Option<String>,
    /// What makes shells; none where there is none.
    pub stage: Option<&'static str>,
    /// Shell, march and all else that was asked for, as on the command line.
    pub settings: BTreeMap<&'static str, String>,
    /// Device features that are enabled beyond Vulkan 1.3.
    pub features: Vec<&'static str>,
    /// Device extensions.
    pub extensions: Vec<&'static str>,
    /// What was decided, in the plan's order.
    pub decisions: Vec<Decision>,
    /// Primitives that are drawn.
    pub primitives: Vec<PrimitiveFact>,
    /// Shell normals that are shortened, so that no prism folds (DESIGN section 1).
    pub folds: Vec<FoldFact>,
    /// Passes of a frame, in order.
    pub passes: Vec<PassFact>,
    /// Pipelines, in the order of their first draw.
    pub pipelines: Vec<PipelineFact>,
    /// What their number cannot exceed, whatever the settings: draws times what one can be drawn by.
    pub most_pipelines: usize,
    /// Buffers.
    pub buffers: Vec<BufferFact>,
    /// Images.
    pub images: Vec<ImageFact>,
}

/// One primitive.
#[derive(Clone, Debug, Serialize)]
pub struct PrimitiveFact {
    /// Mesh and number.
    pub name: String,
    /// The material's.
    pub material: String,
    /// "shell", "traced" (plain, but it meets a shell), "offset" or "plain".
    pub drawn_as: &'static str,
    /// Of its mesh.
    pub triangles: usize,
    /// Of these, plain ones within a shell.
    pub plain_triangles: usize,
    /// And those whose heights are all the same.
    pub level_triangles: usize,
    /// Lowest and highest level of its height field, mesh units.
    pub levels: Option<[f64; 2]>,
    /// Mean thickness of its prisms over that of the whole range.
    pub thickness: Option<f64>,
}

/// One shell normal that is shortened.
#[derive(Clone, Debug, Serialize)]
pub struct FoldFact {
    /// The mesh's name.
    pub mesh: String,
    /// Welded vertex.
    pub vertex: u32,
    /// Its factor r, below 1.
    pub r: f64,
}

/// One pass.
#[derive(Clone, Debug, Serialize)]
pub struct PassFact {
    /// Its name, as in `--stats`.
    pub name: &'static str,
    /// What is drawn in it: pipeline and primitive.
    pub draws: Vec<String>,
}

/// One pipeline.
#[derive(Clone, Debug, Serialize)]
pub struct PipelineFact {
    /// Debug name.
    pub name: String,
    /// Its shaders, below `shaders/`.
    pub shaders: Vec<&'static str>,
    /// What they are compiled with.
    pub defines: Vec<String>,
    /// What they have and have not.
    pub parts: Vec<parts::Part>,
}

impl Explanation {
    /// Explains a plan that was made of `scene` and `settings` for `situation`.
    pub fn new(scene: &Scene, settings: &Settings, plan: &Plan, situation: &Situation) -> Self {
        let needed = features(scene, settings, false);
        let stage = plan.stage.map(Stage::name);
        let stage_feature = |name: &&str| Some(*name) == stage;
        let mut features: Vec<_> = needed.required.iter().map(|feature| feature.name()).collect();
        features.extend(needed.alternatives.iter().map(|feature| feature.name()).filter(stage_feature));
        if plan.stage == Some(Stage::Mesh) && plan.draws.iter().any(|draw| draw.variant.cull.is_some()) {
            features.push(Feature::TaskShader.name());
        }
        let mut extensions = Vec::new();
        if plan.stage == Some(Stage::Mesh) {
            extensions.push("VK_EXT_mesh_shader");
        }
        if situation.window {
            extensions.push("VK_KHR_swapchain");
        }
        Explanation {
            scene: scene.file.display().to_string(),
            device: situation.device.clone(),
            stage,
            settings: asked(settings),
            features,
            extensions,
            decisions: plan.ledger.decisions().to_vec(),
            primitives: plan.primitives.iter().map(|planned| primitive(scene, planned)).collect(),
            folds: folds(scene, plan),
            passes: frame(scene, settings, plan),
            pipelines: variants(plan).iter().map(pipeline).collect(),
            most_pipelines: drawn(plan).count() * MOST_VARIANTS,
            buffers: inventory::buffers(scene, settings, plan, situation),
            images: inventory::images(scene, settings, plan, situation),
        }
    }

    /// As JSON, its members in the order they have here.
    pub fn json(&self) -> String {
        serde_json::to_string_pretty(self).expect("text, numbers and lists of them")
    }
}

/// What the settings say, where it decides something.
fn asked(settings: &Settings) -> BTreeMap<&'static str, String> {
    let on_off = |on: bool| if on { "on" } else { "off" }.to_owned();
    BTreeMap::from([
        ("shell", settings.resolved_shell().to_string()),
        ("march", settings.march.to_string()),
        ("silhouette", settings.silhouette.to_string()),
        ("self-shadow", settings.self_shadow.to_string()),
        ("shadow-map", on_off(settings.shadow_map)),
        ("ambient-occlusion", on_off(settings.ambient_occlusion)),
        ("depth-prepass", settings.depth_prepass.to_string()),
        ("prism-culling", settings.prism_culling.to_string()),
        ("visibility-buffer", settings.visibility_buffer.to_string()),
        ("dither", on_off(settings.dither)),
        ("lod-fade", settings.lod_fade.map_or("off".into(), |start| start.to_string())),
        ("msaa", settings.msaa.to_string()),
        ("view", settings.view.to_string()),
        ("keep-all", on_off(settings.keep_all)),
    ])
}

fn primitive(scene: &Scene, planned: &PlannedPrimitive) -> PrimitiveFact {
    let primitive = plan::source(scene, planned);
    let displaced = planned.shell.is_displaced();
    let (low, high) = scene.displacement_range(primitive);
    let has_field = displaced || primitive.displacement_scale > 0.0;
    let prisms = planned.shell.prisms.iter().filter(|prism| !prism.plain);
    let (thick, count) = prisms.fold((0.0, 0), |(sum, n), prism| (sum + prism.range[1] - prism.range[0], n + 1));
    PrimitiveFact {
        name: plan::primitive_name(scene, planned.mesh, planned.primitive),
        material: scene.materials[primitive.material].name.clone(),
        drawn_as: match () {
            () if displaced => "shell",
            () if !planned.shell.prisms.is_empty() => "traced",
            () if planned.offset.is_some() => "offset",
            () => "plain",
        },
        triangles: primitive.triangles.len(),
        plain_triangles: planned.shell.prisms.iter().filter(|prism| prism.plain).count(),
        level_triangles: planned.shell.prisms.iter().filter(|prism| prism.one_height).count(),
        levels: has_field.then_some([low, high]),
        thickness: (count > 0 && high > low).then(|| thick / f64::from(count) / (high - low)),
    }
}

fn folds(scene: &Scene, plan: &Plan) -> Vec<FoldFact> {
    let of = |(mesh, list): (&usize, &Vec<(u32, f64)>)| {
        let mesh = scene.meshes[*mesh].name.clone();
        list.iter().map(|(vertex, r)| FoldFact { mesh: mesh.clone(), vertex: *vertex, r: *r }).collect::<Vec<_>>()
    };
    plan.folds.iter().flat_map(of).collect()
}

/// Every draw of a plan: into the picture, the AOVs and the shadow maps.
fn drawn(plan: &Plan) -> impl Iterator<Item = &Draw> {
    let blockers = plan.shadow_maps.as_ref().map_or(&[][..], |maps| &maps.draws);
    plan.draws.iter().chain(&plan.aov_draws).chain(blockers)
}

/// Every variant of a plan's draws, once.
pub fn variants(plan: &Plan) -> Vec<Variant> {
    let mut variants: Vec<Variant> = Vec::new();
    for variant in drawn(plan).flat_map(Draw::all_variants) {
        if !variants.contains(&variant) {
            variants.push(variant);
        }
    }
    variants
}

/// The passes, as [`super::Renderer::record`] records them.
fn frame(scene: &Scene, settings: &Settings, plan: &Plan) -> Vec<PassFact> {
    let told = |draw: &Draw, variant: &Variant| {
        let planned = &plan.primitives[draw.primitive];
        format!("{}: {}", variant.name(), plan::primitive_name(scene, planned.mesh, planned.primitive))
    };
    let mut list = Vec::new();
    if plan.primitives.iter().any(|planned| planned.deforms && !planned.shell.prisms.is_empty()) {
        list.push(PassFact { name: "deform", draws: Vec::new() });
    }
    if let Some(maps) = &plan.shadow_maps {
        let draws = maps.draws.iter().map(|draw| told(draw, &draw.variant)).collect();
        list.push(PassFact { name: "shadow maps", draws });
    }
    let of = |draws: &[Draw], of_aov: bool| -> Vec<PassFact> {
        let facts = |pass: DrawPass| {
            let of = |what: fn(&Draw) -> Option<Variant>| -> Vec<String> {
                let told = |index: &usize| Some(told(&draws[*index], &what(&draws[*index])?));
                pass.draws.iter().filter_map(told).collect()
            };
            let drawn: fn(&Draw) -> Option<Variant> = match pass.part {
                Part::Write => |draw| draw.visibility,
                _ if pass.shades => |draw| Some(draw.variant),
                _ => |draw| draw.depth.or(Some(draw.variant)),
            };
            let mut facts = Vec::new();
            if pass.round > 0 {
                facts.push(PassFact { name: depth_tiles::PASS, draws: Vec::new() });
            }
            if pass.lists(draws) {
                facts.push(PassFact { name: pass.culling(), draws: of(|draw| draw.cull) });
            }
            facts.push(PassFact { name: pass.name, draws: of(drawn) });
            facts
        };
        passes(draws, of_aov).into_iter().flat_map(facts).collect()
    };
    if !plan.aov_draws.is_empty() {
        list.extend(of(&plan.aov_draws, true));
    }
    list.extend(of(&plan.draws, false));
    if settings.msaa > 1 {
        list.push(PassFact { name: "resolve", draws: vec!["resolve: the picture".into()] });
    }
    list
}

fn pipeline(variant: &Variant) -> PipelineFact {
    let define = |(name, value): (&str, String)| if value.is_empty() { name.into() } else { format!("{name}={value}") };
    PipelineFact {
        name: variant.name(),
        shaders: variant.shaders().iter().map(|(path, _)| *path).collect(),
        defines: variant.defines().into_iter().map(define).collect(),
        parts: parts::of(variant),
    }
}

/// Lists, or that there is nothing in them.
fn listed(items: &[&str]) -> String {
    if items.is_empty() { "none".into() } else { items.join(", ") }
}

impl fmt::Display for Explanation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let settings: Vec<_> = self.settings.iter().map(|(name, value)| format!("--{name} {value}")).collect();
        writeln!(f, "{}\n  {}", self.scene, settings.join(" "))?;
        writeln!(f, "  device: {}", self.device.as_deref().unwrap_or("any with the stage"))?;
        writeln!(f, "  stage: {}", self.stage.unwrap_or("none, as there is no shell"))?;
        writeln!(f, "  features beyond Vulkan 1.3: {}", listed(&self.features))?;
        writeln!(f, "  extensions: {}", listed(&self.extensions))?;
        self.write_decisions(f)?;
        writeln!(f, "\nprimitives")?;
        for p in &self.primitives {
            write!(f, "  {}: {}, {} triangles of '{}'", p.name, p.drawn_as, p.triangles, p.material)?;
            if p.plain_triangles > 0 {
                write!(f, ", {} of them plain", p.plain_triangles)?;
            }
            if p.level_triangles > 0 {
                write!(f, ", {} of one height each", p.level_triangles)?;
            }
            if let Some([low, high]) = p.levels {
                write!(f, "; levels {low:.6} to {high:.6}")?;
            }
            if let Some(share) = p.thickness {
                write!(f, ", of which its prisms take {:.0} %", 100.0 * share)?;
            }
            writeln!(f)?;
        }
        if !self.folds.is_empty() {
            writeln!(f, "\nfolds: {} shell normals are shortened", self.folds.len())?;
            for FoldFact { mesh, vertex, r } in &self.folds {
                writeln!(f, "  {mesh}, welded vertex {vertex}: r = {r}")?;
            }
        }
        writeln!(f, "\npasses of a frame")?;
        for pass in &self.passes {
            writeln!(f, "  {}", pass.name)?;
            pass.draws.iter().try_for_each(|draw| writeln!(f, "    {draw}"))?;
        }
        writeln!(f, "\npipelines: {} of at most {}", self.pipelines.len(), self.most_pipelines)?;
        for pipeline in &self.pipelines {
            writeln!(f, "  {}: {}", pipeline.name, pipeline.shaders.join(", "))?;
            writeln!(f, "    compiled with {}", pipeline.defines.join(" "))?;
            for part in &pipeline.parts {
                writeln!(f, "    {:<9} {:<22} {}", word(part.kept), part.what, part.why)?;
            }
        }
        let bytes: u64 = self.buffers.iter().map(|buffer| buffer.bytes).sum();
        writeln!(f, "\nbuffers: {}, {bytes} bytes", self.buffers.len())?;
        self.buffers.iter().try_for_each(|buffer| writeln!(f, "  {:>12}  {}", buffer.bytes, buffer.name))?;
        let bytes: u64 = self.images.iter().map(|image| image.bytes).sum();
        writeln!(f, "\nimages: {}, {bytes} bytes", self.images.len())?;
        self.images.iter().try_for_each(|image| {
            let ImageFact { name, extent: [w, h], format, mips, samples, bytes } = image;
            writeln!(f, "  {bytes:>12}  {name}: {w}x{h} {format}, {mips} mips, {samples} samples")
        })
    }
}

impl Explanation {
    fn write_decisions(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut told: Vec<&str> = Vec::new();
        for Decision { of, .. } in &self.decisions {
            if told.contains(&of.as_str()) {
                continue;
            }
            told.push(of);
            writeln!(f, "\n{of}")?;
            for decision in self.decisions.iter().filter(|decision| decision.of == *of) {
                writeln!(f, "  {:<9} {:<22} {}", word(decision.kept), decision.what, decision.why)?;
            }
        }
        Ok(())
    }
}

fn word(kept: bool) -> &'static str {
    if kept { "kept" } else { "left out" }
}
