//! What a scene needs under given settings on a given device: pure, before anything is created.

mod check;
mod derived;
mod draws;
pub mod fade;
pub mod ledger;
mod lights;
mod meshes;
mod needs;
pub mod tangents;
mod visibility;

use std::collections::{BTreeMap, HashSet};
use std::ops::Range;

use glam::Vec3;

pub use self::check::{allows, check, dicer, may_cull, may_shade_samples, wants_shell};
pub use self::derived::Derived;
use self::draws::plan_draws;
use self::fade::Span;
use self::ledger::{Ledger, Need};
use self::lights::MAX_SHADOWED_LIGHTS;
pub use self::lights::ShadowPlan;
use self::meshes::plan_mesh;
pub use self::visibility::may_name_lids;
use super::variant::{Cull, Geometry, Height, UV_SETS, Variant, Vertices};
use crate::scene::{Primitive, Scene, TextureRef};
use crate::settings::{DepthPrepass, SelfShadow, Settings, Shell, Stage, View};
use crate::shell::{prisms::ShellGeometry, walk::WalkGeometry};

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
    /// What writes its nearest lids, or small triangles, into the visibility buffer, where those are traced or shaded.
    pub visibility: Option<Variant>,
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
    /// What of its vertices follows from the rest of them.
    pub derived: Derived,
    /// What its draws read of its vertices besides.
    pub streams: Streams,
    /// The level that all of it lies at, mesh units, where it is drawn so in place of a shell.
    pub offset: Option<f64>,
    /// Its pose may change: what depends on that is the GPU's, and here all that can be displaced is.
    pub deforms: bool,
}

/// What draws read of vertices.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Streams {
    /// The vertices themselves.
    pub vertices: Vertices,
    /// UV sets 0 and 1.
    pub uvs: [bool; 2],
    /// Shading tangents.
    pub tangents: bool,
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
    /// Colour images with mips.
    pub mips: HashSet<usize>,
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
    /// Whether it is part of a shell.
    pub fn is_shell(&self) -> bool {
        self.variant.geometry.stage().is_some()
    }

    /// All that it is drawn by, in the order of the frame.
    pub fn all_variants(&self) -> impl Iterator<Item = Variant> {
        self.cull.into_iter().chain(self.depth).chain(self.visibility).chain([self.variant])
    }

    /// Whether those of its prisms are dropped that what is nearer hides.
    pub fn hides(&self) -> bool {
        self.variant.cull.is_some_and(|cull| cull.hidden)
    }
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
    plan_mips(scene, &mut plan);
    if settings.lod_fade.is_some() && aov {
        plan.notices.push("surface data are asked for, which no height fades in: the picture is drawn so too".into());
    }
    trim(settings, &mut plan);
    visibility::decide(scene, settings, &mut plan);
    plan_culling(scene, settings, stage, &mut plan);
    plan_samples(settings, aov, &mut plan);
    plan_streams(scene, &mut plan);
    plan_depths(settings, &mut plan);
    visibility::complete(&mut plan);
    plan_edges(settings, &mut plan);
    if plan.draws.iter().any(|d| d.variant.geometry.stage().is_some()) {
        plan.stage = Some(stage);
    }
    plan
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

/// What is there of vertices.
fn plan_streams(scene: &Scene, plan: &mut Plan) {
    for index in 0..plan.primitives.len() {
        let (mesh, number) = (plan.primitives[index].mesh, plan.primitives[index].primitive);
        let primitive = &scene.meshes[mesh].primitives[number];
        let drawn = plan.draws.iter().chain(&plan.aov_draws).filter(|draw| draw.primitive == index);
        let variants: Vec<_> = drawn.map(|draw| draw.variant).collect();
        let of = primitive_name(scene, mesh, number);
        let derived = plan.primitives[index].derived.uvs;
        // Poses are written with all there is.
        let posed = if plan.primitives[index].deforms { Vertices::Shell } else { Vertices::None };
        let read = variants.iter().map(Variant::reads_vertices).fold(posed, Vertices::max);
        let lifted = plan.ledger.decide(&of, "shell normals", needs::shell_normals(read));
        let vertices = if lifted { Vertices::Shell } else { read };
        let mut stream = |what, has: bool, reads: &dyn Fn(&Variant) -> bool, derived: bool| {
            plan.ledger.decide(&of, what, needs::stream(has, variants.iter().any(reads), derived))
        };
        let uvs = [0, 1].map(|set: usize| {
            let reads = |variant: &Variant| variant.reads_uvs(set as u8);
            stream(UV_SETS[set], !primitive.uvs[set].is_empty(), &reads, derived == Some(set as u8))
        });
        let tangents = stream("tangents", !primitive.tangents.is_empty(), &Variant::reads_tangents, false);
        plan.primitives[index].streams = Streams { vertices, uvs, tangents };
        let blockers = plan.shadow_maps.iter_mut().flat_map(|maps| &mut maps.draws);
        for draw in plan.draws.iter_mut().chain(&mut plan.aov_draws).chain(blockers) {
            if draw.primitive == index {
                draw.variant.surface_vertices = vertices == Vertices::Surface;
            }
        }
    }
}

/// Which draws' prisms are dropped unseen, before the stage that makes them.
fn plan_culling(scene: &Scene, settings: &Settings, stage: Stage, plan: &mut Plan) {
    let named = plan.draws.iter().any(|draw| draw.variant.visibility);
    for draw in plan.draws.iter_mut().filter(|draw| draw.variant.geometry.stage().is_some()) {
        let planned = &plan.primitives[draw.primitive];
        let of = primitive_name(scene, planned.mesh, planned.primitive);
        let prisms = draw.range.len();
        if !plan.ledger.decide(&of, "culling", needs::culling(settings, stage, prisms)) {
            continue;
        }
        let hidden = plan.ledger.decide(&of, "culling of the hidden", needs::hidden_culling(settings, named));
        draw.variant.cull = Some(Cull { hidden, counted: settings.count_limits });
        draw.cull = draw.variant.for_culling();
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
        edges.push(Draw { variant, depth: None, cull: None, visibility: None, span: None, ..draw.clone() });
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
            aov_uv: if variant.view == View::Uv { variant.aov_uv } else { 0 },
            samples: settings.msaa as u8,
            per_sample: variant.decides_coverage(),
            // Counted once, where there is one sample.
            height: variant.height.map(|height| Height { count_reads: height.count_reads && !aov, ..height }),
            ..*variant
        };
    }
}

/// The bits of each height map that a draw reads.
fn plan_height_maps(scene: &Scene, plan: &mut Plan) {
    for (index, map) in scene.height_maps.iter().enumerate() {
        let read = plan.draws.iter().any(|draw| height_maps(scene, plan, draw).contains(&index));
        let of = format!("height map '{}'", map.name);
        let need = Need::asked(read, "a surface is displaced or shaded by it", "no draw reads it");
        if !plan.ledger.decide(&of, "image", need) {
            continue;
        }
        if plan.ledger.decide(&of, "16 bits", needs::sixteen_bits(map)) {
            plan.sixteen_bits.insert(index);
        }
        let at_lods = |draw: &Draw| draw.variant.height.is_some_and(|height| height.pixel_lod);
        let lods = plan.draws.iter().any(|draw| at_lods(draw) && own_map(scene, plan, draw) == Some(index));
        plan.ledger.decide(&of, "mips", needs::height_mips(lods));
    }
}

/// The map that a draw's own field is of.
fn own_map(scene: &Scene, plan: &Plan, draw: &Draw) -> Option<usize> {
    let primitive = source(scene, &plan.primitives[draw.primitive]);
    scene.materials[primitive.material].displacement?.source.map()
}

/// The colour images of which some draw samples more than the full size.
fn plan_mips(scene: &Scene, plan: &mut Plan) {
    let textures = plan.draws.iter().flat_map(|draw| {
        let material = &scene.materials[source(scene, &plan.primitives[draw.primitive]).material];
        let read = |(texture, set): (Option<TextureRef>, Option<u8>)| texture.filter(|_| set.is_some());
        material.textures().into_iter().zip(draw.variant.textures).filter_map(read)
    });
    // Each image that is read, and whether at mips.
    let mut images = BTreeMap::new();
    for texture in textures {
        *images.entry(texture.image).or_insert(false) |= !texture.sampler.no_mips;
    }
    for (index, between) in images {
        let image = &scene.images[index];
        let need = needs::mips([image.width, image.height], between);
        if plan.ledger.decide(format!("image '{}'", image.name), "mips", need) {
            plan.mips.insert(index);
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

/// The primitive behind a planned one.
pub fn source<'a>(scene: &'a Scene, planned: &PlannedPrimitive) -> &'a Primitive {
    &scene.meshes[planned.mesh].primitives[planned.primitive]
}
