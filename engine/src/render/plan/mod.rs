//! What a scene needs under given settings on a given device: pure, before anything is created.

pub mod fade;
pub mod ledger;
mod lights;
mod needs;
pub mod tangents;

use std::collections::{BTreeMap, HashSet};
use std::ops::Range;

use glam::Vec3;

use self::fade::Span;
use self::ledger::{Ledger, Need};
pub use self::lights::ShadowPlan;
use self::lights::{MAX_SHADOWED_LIGHTS, shadowed_lights};
use super::variant::{Cull, Geometry, Height, Pass, TEXTURE_NAMES, Variant};
use crate::error::{Error, Result};
use crate::scene::{DepthOffset, Displacement, Instance, Material, Primitive, Procedure, Scene};
use crate::settings::{
    Baseline, DepthPrepass, Dicer, March, Normals, PrismCulling, SelfShadow, Settings, Shell, Silhouette, Stage, View,
};
use crate::shell::{
    certificate::{self, Folds},
    prisms::{self, MAX_OTHERS, ShellGeometry},
    walk::WalkGeometry,
};

/// One draw: a primitive of an instance, or the part of it that its variant draws.
#[derive(Clone, Debug)]
pub struct Draw {
    /// Index of the instance.
    pub instance: usize,
    /// Index into [`Plan::primitives`].
    pub primitive: usize,
    /// Shader code and state.
    pub variant: Variant,
    /// What draws its depth before any colour, if that comes first.
    pub depth: Option<Variant>,
    /// The pass that lists the prisms it draws, where its stage does not drop the others itself.
    pub cull: Option<Variant>,
    /// Triangles or prisms of the primitive's buffers.
    pub range: Range<u32>,
    /// When it is drawn; always where nothing fades.
    pub span: Option<Span>,
}

/// A primitive that is drawn, once whatever the number of its instances.
#[derive(Clone, Debug)]
pub struct PlannedPrimitive {
    /// Index of the mesh.
    pub mesh: usize,
    /// Index in the mesh.
    pub primitive: usize,
    /// Prisms, plain triangles among them; empty where nothing displaced is connected to it, or without a shell.
    pub shell: ShellGeometry,
    /// Adjacency and bounds, where the shell is walked, by pixels' rays or by shadow rays, or where it reads shadow maps.
    pub walk: Option<WalkGeometry>,
    /// The stage that makes its lids, where it is walked by pixels' rays.
    pub lids: Option<Stage>,
    /// Whether shadow rays that leave the shell go on in a hierarchy of boxes over its prisms.
    pub hierarchy: bool,
    /// Levels above its highest that soft shadows' rays are followed for, as far as no prism folds there; 0 without them.
    pub headroom: f64,
    /// Shell normal times r of each of its vertices (DESIGN section 1).
    pub shell_normals: Vec<Vec3>,
    /// The level that all of it lies at, mesh units, where it is drawn so in place of a shell.
    pub offset: Option<f64>,
    /// Its pose may change: what depends on that is the GPU's, and here all that can be displaced is.
    pub deforms: bool,
}

/// The plan.
#[derive(Clone, Debug, Default)]
pub struct Plan {
    /// Primitives to upload.
    pub primitives: Vec<PlannedPrimitive>,
    /// Draws, in order.
    pub draws: Vec<Draw>,
    /// The same draws with one sample a pixel, for the AOVs of a picture with several; else empty.
    pub aov_draws: Vec<Draw>,
    /// Shadow maps, where something casts on something.
    pub shadow_maps: Option<ShadowPlan>,
    /// The stage of the shell's geometry; none where no shell is drawn.
    pub stage: Option<Stage>,
    /// Height maps whose texels are kept at 16 bits.
    pub sixteen_bits: HashSet<usize>,
    /// Shell normals that are shortened, by mesh: welded vertex and factor.
    pub folds: BTreeMap<usize, Vec<(u32, f64)>>,
    /// What was decided, and why.
    pub ledger: Ledger,
    /// Sentences for the user.
    pub notices: Vec<String>,
}

impl Plan {
    /// Whether prisms are dropped that the depth of others hides.
    pub fn hides(&self) -> bool {
        self.draws.iter().any(Draw::hides)
    }
}

impl Draw {
    /// Whether those of its prisms are dropped that what is nearer hides.
    pub fn hides(&self) -> bool {
        self.variant.cull.is_some_and(|cull| cull.hidden)
    }
}

/// Whether any draw of the scene would be a shell under these settings, whatever the device.
pub fn wants_shell(scene: &Scene, settings: &Settings) -> bool {
    let settings = &settings.drawn();
    settings.baseline.is_none()
        && settings.resolved_shell() != Shell::Off
        && scene.instances.iter().map(|i| &scene.meshes[i.mesh]).any(|mesh| {
            mesh.primitives.iter().any(|p| prisms::displacement(scene, p).is_some())
                && (settings.keep_all || needs::offset(scene, mesh, settings).is_none())
        })
}

/// What is drawn, as often as it is.
fn drawn(scene: &Scene) -> impl Iterator<Item = &Primitive> {
    scene.instances.iter().flat_map(|i| &scene.meshes[i.mesh].primitives)
}

/// What dices the scene's displaced surfaces, where the settings want that.
pub fn dicer(scene: &Scene, settings: &Settings) -> Option<Dicer> {
    match settings.baseline {
        Some(Baseline::Diced { by, .. }) => {
            drawn(scene).any(|p| prisms::displacement(scene, p).is_some()).then_some(by)
        }
        _ => None,
    }
}

/// The first material whose heights are a function that a drawn primitive shows.
fn procedural(scene: &Scene) -> Option<(&Material, Procedure)> {
    let displaced = drawn(scene).filter(|p| prisms::displacement(scene, p).is_some());
    let materials = displaced.map(|p| &scene.materials[p.material]);
    materials.filter_map(|material| Some((material, material.displacement?.source.procedure()?))).next()
}

/// Whether a march can be used in this scene: cones are of height maps.
pub fn allows(scene: &Scene, march: March) -> bool {
    !march.reads_cones() || procedural(scene).is_none()
}

/// Whether fragments may have to be shaded sample by sample: not where all surfaces are plain and opaque.
pub fn may_shade_samples(scene: &Scene, settings: &Settings) -> bool {
    let material = |p: &Primitive| &scene.materials[p.material];
    let decides = |m: &Material| m.displacement.is_some() || m.depth_offset.is_some() || m.alpha_cutoff.is_some();
    settings.msaa > 1 && drawn(scene).any(|p| decides(material(p)))
}

/// Refuses settings that this scene cannot honour.
pub fn check(scene: &Scene, settings: &Settings) -> Result<()> {
    if !matches!(settings.msaa, 1 | 4) {
        return Err(Error::Usage(format!("--msaa {}: a pixel has 1 or 4 samples", settings.msaa)));
    }
    if settings.msaa > 1 && settings.baseline.is_some() {
        return Err(Error::Usage("--msaa: a baseline is drawn with one sample a pixel; use --msaa 1".into()));
    }
    if settings.occlusion_light > 0.0 {
        let occluded = |p: &Primitive| {
            scene.materials[p.material].occlusion.is_some()
                || (settings.ambient_occlusion && prisms::displacement(scene, p).is_some())
        };
        if scene.lights.is_empty() || !drawn(scene).any(occluded) {
            return Err(Error::Usage(
                "--occlusion-light: the scene has no light, or nothing that occludes: no occlusion texture, and no \
                 --ambient-occlusion on"
                    .into(),
            ));
        }
    }
    if settings.pixel_lod
        && let Some((material, procedure)) = procedural(scene)
    {
        return Err(Error::Usage(format!(
            "--height-lod auto: the heights of material '{}' are the function '{}', which has no LOD; drop the flag",
            material.name,
            procedure.name()
        )));
    }
    tangents::check(scene, settings)?;
    check_culling(scene, settings)?;
    if let Some(Baseline::Diced { edge, .. }) = settings.baseline
        && !(edge.is_finite() && edge > 0.0)
    {
        return Err(Error::Usage(format!("edges of {edge} pixels: more than 0 are possible")));
    }
    match procedural(scene).filter(|_| settings.march.reads_cones() && settings.baseline.is_none()) {
        None => Ok(()),
        Some((material, procedure)) => Err(Error::Usage(format!(
            "--march {}: cone maps are made of height maps, and the heights of material '{}' are the function '{}'; use \
             --march exact or relief",
            settings.march,
            material.name,
            procedure.name()
        ))),
    }
}

fn check_culling(scene: &Scene, settings: &Settings) -> Result<()> {
    let asked = settings.prism_culling;
    let why = match asked {
        PrismCulling::Auto | PrismCulling::Off => return Ok(()),
        _ if !wants_shell(scene, settings) => "no shell is drawn",
        _ if settings.keep_all => "--keep-all draws every prism",
        PrismCulling::Hidden if settings.msaa > 1 => "what is hidden is found with one sample a pixel; use --msaa 1",
        PrismCulling::Hidden if settings.depth_prepass == DepthPrepass::On => {
            "--depth-prepass on draws the depth of hidden prisms too"
        }
        PrismCulling::View | PrismCulling::Hidden => return Ok(()),
    };
    Err(Error::Usage(format!("--prism-culling {asked}: {why}")))
}

/// Makes the plan. `stage`: mesh or geometry, as the device allows.
pub fn plan(scene: &Scene, settings: &Settings, stage: Stage, aov: bool) -> Plan {
    let settings = &settings.drawn();
    let mut plan = Plan { ledger: Ledger::new(settings.keep_all), ..Plan::default() };
    if (settings.shadow_map || settings.self_shadow != SelfShadow::Off) && scene.lights.len() > MAX_SHADOWED_LIGHTS {
        plan.notices.push(format!("{} lights; the first {MAX_SHADOWED_LIGHTS} cast shadows", scene.lights.len()));
    }
    // First planned primitive of each mesh.
    let mut first = vec![None; scene.meshes.len()];
    for (index, instance) in scene.instances.iter().enumerate() {
        let start = *first[instance.mesh].get_or_insert_with(|| plan_mesh(scene, instance.mesh, settings, &mut plan));
        for offset in 0..scene.meshes[instance.mesh].primitives.len() {
            plan_draws(scene, settings, stage, aov, index, instance, start + offset, &mut plan);
        }
    }
    lights::plan_shadow_maps(scene, settings, &mut plan);
    plan_height_maps(scene, &mut plan);
    if settings.lod_fade.is_some() && aov {
        plan.notices.push("surface data are asked for, which no height fades in: the picture is drawn so too".into());
    }
    trim(settings, &mut plan);
    plan_culling(scene, settings, stage, &mut plan);
    plan_samples(settings, aov, &mut plan);
    plan_depths(settings, &mut plan);
    plan_edges(settings, &mut plan);
    if plan.draws.iter().any(|d| d.variant.geometry.stage().is_some()) {
        plan.stage = Some(stage);
    }
    plan
}

/// Plans a mesh's primitives and returns the index of the first.
fn plan_mesh(scene: &Scene, index: usize, settings: &Settings, plan: &mut Plan) -> usize {
    let start = plan.primitives.len();
    let mesh = &scene.meshes[index];
    let mut shells = vec![ShellGeometry::default(); mesh.primitives.len()];
    // Of the range of each primitive's levels; a base surface takes the light's way as straight however high.
    let mut headroom = if soft(settings) && !scene.lights.is_empty() { 1.0 } else { 0.0 };
    let shell = settings.resolved_shell();
    // A baseline samples the shell's own surface.
    let shelled = shell != Shell::Off || settings.baseline.is_some();
    // A baseline has its mesh made once.
    let deforms = mesh.deforms && settings.baseline.is_none();
    let name = |p: usize| primitive_name(scene, index, p);
    let moved = if shelled && settings.baseline.is_none() { needs::offset(scene, mesh, settings) } else { None };
    let mut wanted = false;
    for (p, primitive) in mesh.primitives.iter().enumerate() {
        wanted |= plan.ledger.decide(name(p), "shell", needs::shell(scene, primitive, settings, moved));
    }
    let offset = moved.filter(|_| !wanted);
    // Where all is moved to one level, nothing folds.
    let mut factors = vec![f64::from(u8::from(offset.is_some())); mesh.shell_normals.len()];
    if shelled && offset.is_none() && mesh.primitives.iter().any(|p| prisms::displacement(scene, p).is_some()) {
        let folds = if deforms {
            Folds { factors: vec![1.0; mesh.shell_normals.len()], reduced: Vec::new(), plain: Vec::new() }
        } else {
            certificate::mesh_folds(scene, mesh)
        };
        if !folds.reduced.is_empty() {
            plan.notices.push(format!(
                "mesh '{}': {} shell normals are shortened to keep prisms from folding, {} triangles stay plain",
                mesh.name,
                folds.reduced.len(),
                folds.plain.len()
            ));
        }
        shells = prisms::build(scene, mesh, &folds.factors);
        if headroom > 0.0 {
            headroom = certificate::headroom(scene, mesh, &folds.factors);
            if headroom == 0.0 {
                plan.notices.push(format!(
                    "mesh '{}': its prisms would fold right above the surface, where soft shadows' rays run: they are hard",
                    mesh.name
                ));
            }
        }
        plan.folds.insert(index, folds.reduced);
        for (p, shell) in shells.iter().enumerate().filter(|(_, shell)| shell.left_open > 0) {
            plan.notices.push(format!(
                "mesh '{}' primitive {p}: it meets more than {MAX_OTHERS} other height fields; the first {MAX_OTHERS} are \
                 joined to it, the steps at {} edge(s) to others stay open",
                mesh.name, shell.left_open
            ));
        }
        factors = folds.factors;
    }
    for (p, mut geometry) in shells.into_iter().enumerate() {
        // What a baseline does not displace it draws as it is.
        if settings.baseline.is_some() && !geometry.is_displaced() {
            geometry = ShellGeometry::default();
        }
        let primitive = &mesh.primitives[p];
        let normal = |w: &u32| (mesh.shell_normals[*w as usize] * factors[*w as usize]).as_vec3();
        let shell_normals: Vec<Vec3> = primitive.weld.iter().map(normal).collect();
        let traced = settings.baseline.is_none() && geometry.is_displaced();
        let shadows = settings.self_shadow != SelfShadow::Off && !scene.lights.is_empty() && traced;
        let mapped = settings.shadow_map && !scene.lights.is_empty() && traced;
        let walks = (shell == Shell::Walk && traced) || (shell == Shell::Prism && (shadows || mapped));
        let offset = offset.filter(|_| prisms::displacement(scene, primitive).is_some());
        let headroom = if headroom > 0.0 {
            let [low, high] = certificate::t_range(scene, primitive).unwrap_or_default();
            headroom * (high - low)
        } else {
            0.0
        };
        let walk = walks.then(|| WalkGeometry::new(mesh, p, &shell_normals, &geometry));
        plan.primitives.push(PlannedPrimitive {
            mesh: index,
            primitive: p,
            shell: geometry,
            walk,
            lids: None,
            hierarchy: shelled && shadows,
            headroom,
            shell_normals,
            offset,
            deforms,
        });
    }
    start
}

#[allow(clippy::too_many_arguments)]
fn plan_draws(
    scene: &Scene,
    settings: &Settings,
    stage: Stage,
    aov: bool,
    index: usize,
    instance: &Instance,
    planned: usize,
    plan: &mut Plan,
) {
    let geometry = &plan.primitives[planned];
    let primitive = &scene.meshes[instance.mesh].primitives[geometry.primitive];
    let material = &scene.materials[primitive.material];
    let displacement = prisms::displacement(scene, primitive);
    let of = primitive_name(scene, instance.mesh, geometry.primitive);
    let of_material = format!("material '{}'", material.name);
    let ledger = &mut plan.ledger;
    let mut textures = textures(material);
    for ((texture, what), need) in textures.iter_mut().zip(TEXTURE_NAMES).zip(needs::textures(material)) {
        *texture = texture.filter(|_| ledger.decide(&of_material, what, need));
    }
    let shifts = |offset: &DepthOffset| {
        let need = Need::when(offset.distance > 0.0, "it moves the depth", "its distance is 0");
        settings.depth_offset && ledger.decide(&of_material, "depth offset", need)
    };
    let depth_shift = material.depth_offset.filter(shifts).map(|offset| offset.dither);
    let alpha_mask = ledger.decide(&of_material, "alphaMode MASK", needs::alpha_mask(scene, material));
    let plain = Variant {
        geometry: Geometry::Surface,
        textures,
        specular: ledger.decide(&of_material, "specular", needs::specular(material)),
        channels: [material.roughness_channel, material.metallic_channel],
        occludes_light: settings.occlusion_light > 0.0 && !scene.lights.is_empty(),
        height: None,
        depth_shift,
        // Away from the eye.
        depth_behind: depth_shift.is_some() && !settings.keep_all,
        alpha_mask,
        double_sided: material.double_sided,
        mirrored: instance.transform.matrix3.determinant() < 0.0,
        lights: !scene.lights.is_empty(),
        pass: Pass::Shade,
        depth_stands: false,
        shadowed_lights: 0,
        shadow_maps: false,
        aov,
        samples: 1,
        per_sample: false,
        aov_uv: displacement.map_or(0, |d| d.tex_coord as u8),
        deforms: false,
        cull: None,
        // Of the others some add to the shaded picture.
        view: match settings.view {
            View::Base | View::Wireframe | View::Error => View::Shaded,
            own => own,
        },
    };
    let prisms = geometry.shell.prisms.len() as u32;
    let mut push_in = |span: Option<Span>, variant: Variant, range: Range<u32>| {
        if !range.is_empty() {
            plan.draws.push(Draw {
                instance: index,
                primitive: planned,
                variant,
                depth: None,
                cull: None,
                range,
                span,
            });
        }
    };
    let mut push = |variant: Variant, range: Range<u32>| push_in(None, variant, range);
    let baseline = settings.baseline.filter(|_| geometry.shell.is_displaced());
    if let (Some(baseline), Some(d)) = (baseline, &displacement) {
        push(baseline_variant(baseline, d, plain), 0..prisms);
    } else if prisms > 0 {
        let shown = displacement.filter(|_| geometry.shell.is_displaced());
        let others = geometry.shell.others.len() as u8;
        let mut other_procedures = [None; MAX_OTHERS];
        for (slot, other) in other_procedures.iter_mut().zip(&geometry.shell.others) {
            *slot = other.source.procedure();
        }
        let height = shown.map(|d| {
            let mesh = &scene.meshes[instance.mesh];
            let steps = ledger.decide(&of, "steps at walls", needs::steps(&geometry.shell, geometry.deforms));
            let plain = needs::plain_prisms(&geometry.shell, geometry.deforms);
            let shadow = needs::self_shadow(scene, instance, primitive, mesh, settings, steps);
            let field = height(&d, settings, true);
            let self_shadow = ledger.decide(&of, "self-shadow", shadow) && field.self_shadow;
            Height {
                others,
                other_procedures,
                steps,
                plain: ledger.decide(&of, "plain prisms", plain),
                self_shadow,
                soft_shadow: self_shadow && field.soft_shadow && geometry.headroom > 0.0,
                shadow_steps: self_shadow && field.shadow_steps,
                reenters: self_shadow && geometry.hierarchy,
                ..field
            }
        });
        let shadows = settings.self_shadow != SelfShadow::Off;
        let far = Variant { depth_shift: None, depth_behind: false, ..plain };
        let plain = Variant { shadowed_lights: if shadows { shadowed_lights(scene) } else { 0 }, ..plain };
        if plain.depth_shift.is_some() {
            plan.notices.push(format!("material '{}': its depth offset is left out beside a shell", material.name));
        }
        let fades = fade::fades(settings, aov);
        let spans: &[_] = if fades { &[Some(Span::Near), Some(Span::Fading)] } else { &[None] };
        for span in spans {
            let height = height.map(|h| Height { lod_fade: *span == Some(Span::Fading), ..h });
            // The raster's depth lies before all that a fragment can hit.
            let shelled = Variant { height, depth_shift: None, depth_behind: !settings.keep_all, ..plain };
            let outlines = Variant { mirrored: false, double_sided: false, ..shelled };
            if settings.resolved_shell() == Shell::Walk && geometry.walk.is_some() {
                // Front faces only: a lid seen from behind is where rays leave.
                let deforms = geometry.deforms && stage == Stage::Mesh;
                let lids = Variant { geometry: Geometry::Lids(stage), double_sided: false, deforms, ..shelled };
                push_in(*span, lids, 0..prisms);
                push_in(*span, Variant { geometry: Geometry::Borders(stage), ..outlines }, 0..prisms);
            } else {
                push_in(*span, Variant { geometry: Geometry::Shell(stage), ..outlines }, 0..prisms);
            }
        }
        if fades {
            push_in(Some(Span::Far), far, 0..primitive.triangles.len() as u32);
        }
    } else {
        let parallax =
            settings.baseline.is_none() && settings.resolved_shell() == Shell::Off && settings.march != March::None;
        let height = displacement.filter(|_| parallax).map(|d| height(&d, settings, false)).map(|h| Height {
            self_shadow: h.self_shadow && plain.lights,
            mesh_tangents: tangents::from_mesh(material, primitive, settings) && !geometry.deforms,
            soft_shadow: h.soft_shadow && plain.lights,
            shadow_steps: h.shadow_steps && plain.lights,
            // Surface data are of the whole field.
            lod_fade: settings.lod_fade.is_some() && !aov,
            ..h
        });
        let shadowed = if height.is_some_and(|h| h.self_shadow) { shadowed_lights(scene) } else { 0 };
        let offsets = height.is_some_and(|h| h.depth_offset) && !material.double_sided && !settings.keep_all;
        // No part of the field stands before the base surface.
        let depth_behind = plain.depth_behind || (offsets && scene.displacement_range(primitive).1 <= 0.0);
        let triangles = primitive.triangles.len() as u32;
        push(Variant { height, depth_behind, shadowed_lights: shadowed, ..plain }, 0..triangles);
    }
}

/// Leaves out of the primitives what none of their draws has turned out to read.
fn trim(settings: &Settings, plan: &mut Plan) {
    for (index, primitive) in plan.primitives.iter_mut().enumerate() {
        let draws = plan.draws.iter().filter(|draw| draw.primitive == index).map(|draw| draw.variant);
        let of = |field: fn(Height) -> bool| draws.clone().filter_map(|variant| variant.height).any(field);
        primitive.lids = draws.clone().find_map(|variant| match variant.geometry {
            Geometry::Lids(stage) => Some(stage),
            _ => None,
        });
        primitive.hierarchy &= of(|height| height.reenters);
        // Without a walk of the pixels' rays it is for the shadows', and for what reads shadow maps.
        let mapped = draws.clone().any(|variant| variant.shadow_maps && variant.height.is_some());
        if settings.resolved_shell() == Shell::Prism && !mapped && !of(|height| height.self_shadow) {
            primitive.walk = None;
        }
    }
}

/// Which draws' prisms are dropped unseen, before the stage that makes them.
fn plan_culling(scene: &Scene, settings: &Settings, stage: Stage, plan: &mut Plan) {
    for draw in plan.draws.iter_mut().filter(|draw| draw.variant.geometry.stage().is_some()) {
        let planned = &plan.primitives[draw.primitive];
        let of = primitive_name(scene, planned.mesh, planned.primitive);
        let prisms = draw.range.len();
        if !plan.ledger.decide(&of, "culling", needs::culling(settings, stage, prisms)) {
            continue;
        }
        let hidden = plan.ledger.decide(&of, "culling of the hidden", needs::hidden_culling(settings));
        draw.variant.cull = Some(Cull { hidden, counted: settings.count_limits });
        draw.cull = draw.variant.for_culling();
    }
}

/// Whether prisms may be dropped unseen, before the plan: what the device is asked for.
pub fn may_cull(scene: &Scene, settings: &Settings) -> bool {
    let decided = |prisms| matches!(needs::culling(settings, Stage::Mesh, prisms), Need::Yes(_));
    wants_shell(scene, settings) && drawn(scene).any(|primitive| decided(primitive.triangles.len()))
}

/// What draws a displaced primitive as a baseline does. `plain`: its variant without displacement.
fn baseline_variant(baseline: Baseline, displacement: &Displacement, plain: Variant) -> Variant {
    match baseline {
        Baseline::MicroMesh { .. } => Variant { geometry: Geometry::MicroMesh, ..plain },
        Baseline::Diced { by, culls, .. } => {
            let unmarched = Settings { march: March::None, ..Settings::default() };
            let height = Some(height(displacement, &unmarched, true));
            Variant { geometry: Geometry::Diced { by, culls }, height, ..plain }
        }
    }
}

/// Whose depth is drawn before all colours. What is not among them may be drawn after them as ever.
fn plan_depths(settings: &Settings, plan: &mut Plan) {
    // Without a fragment shader.
    let cheap = |draw: &Draw| matches!(draw.variant.for_depth().shaders(), [_]);
    let several = plan.draws.iter().filter(|draw| cheap(draw)).count() > 1;
    let first = |draw: &Draw| match settings.depth_prepass {
        DepthPrepass::Off => false,
        DepthPrepass::Auto => several && cheap(draw),
        // A baseline's mesh is culled for one pass.
        DepthPrepass::On => !matches!(draw.variant.geometry, Geometry::MicroMesh | Geometry::Diced { .. }),
    };
    for draw in plan.draws.iter_mut().filter(|draw| first(draw)) {
        draw.depth = Some(draw.variant.for_depth());
        draw.variant.depth_stands = true;
    }
}

/// The lines that a view draws over its picture: of each primitive once for each of its instances.
fn plan_edges(settings: &Settings, plan: &mut Plan) {
    let geometry = match settings.view {
        View::Base => Geometry::BaseEdges,
        View::Wireframe => Geometry::PrismEdges,
        _ => return,
    };
    let mut edges: Vec<Draw> = Vec::new();
    for draw in &plan.draws {
        let same = |edge: &Draw| [edge.instance, edge.primitive] == [draw.instance, draw.primitive];
        if (geometry == Geometry::PrismEdges && draw.variant.geometry.stage().is_none()) || edges.iter().any(same) {
            continue;
        }
        let variant = draw.variant.for_edges(geometry);
        edges.push(Draw { variant, depth: None, cull: None, span: None, ..draw.clone() });
    }
    plan.draws.append(&mut edges);
}

/// Several samples a pixel: AOVs have one, so they get draws of their own.
fn plan_samples(settings: &Settings, aov: bool, plan: &mut Plan) {
    if settings.msaa == 1 {
        return;
    }
    if aov {
        plan.aov_draws = plan.draws.clone();
    }
    for Draw { variant, .. } in &mut plan.draws {
        *variant = Variant {
            aov: false,
            aov_uv: 0,
            samples: settings.msaa as u8,
            per_sample: variant.decides_coverage(),
            // Counted once, where there is one sample.
            height: variant.height.map(|height| Height { count_reads: height.count_reads && !aov, ..height }),
            ..*variant
        };
    }
}

/// Whether self-shadow has a penumbra.
fn soft(settings: &Settings) -> bool {
    settings.self_shadow == SelfShadow::Soft && settings.shadow_softness > 0.0
}

fn height(displacement: &Displacement, settings: &Settings, shell: bool) -> Height {
    let traces = settings.march.traces();
    let parallax = !shell && traces;
    Height {
        procedure: displacement.source.procedure(),
        wrap: displacement.wrap,
        others: 0,
        steps: false,
        plain: false,
        other_procedures: [None; MAX_OTHERS],
        march: settings.march,
        uv_bounds: parallax && settings.silhouette == Silhouette::UvBounds,
        horizon: parallax && settings.silhouette == Silhouette::Horizon,
        dither: settings.dither && settings.march.steps(),
        normals: if shell { Normals::Gather } else { settings.normals },
        mesh_tangents: false,
        pixel_lod: !shell && settings.pixel_lod && settings.march.reads_lods(),
        depth_offset: parallax && settings.depth_offset,
        lod_fade: false,
        self_shadow: traces && settings.self_shadow != SelfShadow::Off,
        soft_shadow: traces && soft(settings),
        shadow_steps: traces && settings.self_shadow != SelfShadow::Off && settings.shadow_steps.is_some(),
        ambient_occlusion: settings.ambient_occlusion,
        reenters: false,
        // Linear searches end by themselves.
        count_limits: settings.count_limits && (settings.march == March::Exact || settings.march.reads_cones()),
        count_reads: settings.count_reads,
    }
}

/// The bits of each height map that a draw reads.
fn plan_height_maps(scene: &Scene, plan: &mut Plan) {
    for (index, map) in scene.height_maps.iter().enumerate() {
        let read = plan.draws.iter().any(|draw| height_maps(scene, plan, draw).contains(&index));
        let of = format!("height map '{}'", map.name);
        let need = Need::asked(read, "a surface is displaced or shaded by it", "no draw reads it");
        if plan.ledger.decide(&of, "image", need) && plan.ledger.decide(&of, "16 bits", needs::sixteen_bits(map)) {
            plan.sixteen_bits.insert(index);
        }
    }
}

/// The height maps that a draw reads: its own field's and those of its neighbours.
fn height_maps(scene: &Scene, plan: &Plan, draw: &Draw) -> Vec<usize> {
    let planned = &plan.primitives[draw.primitive];
    let own = scene.materials[source(scene, planned).material].displacement.map(|d| d.source);
    let others = planned.shell.others.iter().map(|other| other.source);
    let fields = own.into_iter().chain(others).filter(|_| draw.variant.height.is_some());
    fields.filter_map(|source| source.map()).collect()
}

/// What a primitive is called.
pub fn primitive_name(scene: &Scene, mesh: usize, primitive: usize) -> String {
    format!("{}.{primitive}", scene.meshes[mesh].name)
}

/// UV set of each texture slot.
fn textures(material: &Material) -> [Option<u8>; 7] {
    material.textures().map(|t| t.map(|t| t.tex_coord as u8))
}

/// The primitive behind a planned one.
pub fn source<'a>(scene: &'a Scene, planned: &PlannedPrimitive) -> &'a Primitive {
    &scene.meshes[planned.mesh].primitives[planned.primitive]
}
