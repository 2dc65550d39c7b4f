//! Whose walks begin at the lids that a visibility buffer names, and whose small triangles it names to be shaded.

use super::ledger::Need;
use super::{Draw, Plan, check::drawn, primitive_name, source};
use crate::error::{Error, Result};
use crate::render::variant::{Geometry, Variant};
use crate::render::visibility::{MAX_DRAWS, MAX_PRISMS, Named};
use crate::scene::{Material, Primitive, Scene};
use crate::settings::{Baseline, DepthPrepass, PrismCulling, Settings, Shell, View, VisibilityBuffer};
use crate::shell::prisms;

/// Prisms of a primitive from which on it pays: fewer are so large on the screen that few quads lie across their edges,
/// and the passes cost more than they spare (README, "The visibility buffer").
const PAYS_FROM: usize = 256;

/// Triangles of a micro-mesh from which on it pays: 2,304 on the torus cost more so, 9,216 less (samples/bench/README.md).
const MESH_PAYS_FROM: usize = 5_000;

/// Triangles of a micro-mesh whose indices and vertices shaders can read on every device: 13 bytes each at most, of the 128 MiB
/// that Vulkan promises of a buffer.
const MESH_PAYS_TO: usize = (128 << 20) / 13;

/// Refuses a visibility buffer that the settings have no use for.
pub fn check(scene: &Scene, settings: &Settings) -> Result<()> {
    if settings.visibility_buffer != VisibilityBuffer::On {
        return Ok(());
    }
    if let Some(Baseline::MicroMesh { .. }) = settings.baseline {
        let mut meshes = drawn(scene).filter(|p| prisms::displacement(scene, p).is_some()).peekable();
        if meshes.peek().is_none() {
            return Err(Error::Usage("--visibility-buffer on: nothing is displaced, so there is no micro-mesh".into()));
        }
        let told = |p: &Primitive| {
            let material = &scene.materials[p.material];
            let shifts = settings.depth_offset && material.depth_offset.is_some_and(|offset| offset.distance > 0.0);
            Some((material, unfit(material.alpha_cutoff.is_some(), shifts)?))
        };
        return meshes.find_map(told).map_or(Ok(()), |(Material { name, .. }, why)| {
            Err(Error::Usage(format!("--visibility-buffer on: material '{name}': {why}")))
        });
    }
    let unwalked = (!super::wants_shell(scene, settings)).then_some("no shell is walked");
    match unwalked.or_else(|| obstacle(settings)) {
        Some(why) => Err(Error::Usage(format!("--visibility-buffer on: {why}"))),
        None => Ok(()),
    }
}

/// Whether walks can begin at the lids of a visibility buffer under these settings.
pub fn may_name_lids(settings: &Settings) -> bool {
    obstacle(settings).is_none()
}

/// Why no draw has it under these settings.
fn obstacle(settings: &Settings) -> Option<&'static str> {
    match () {
        () if settings.resolved_shell() != Shell::Walk => Some("no shell is walked"),
        () if settings.keep_all => Some("--keep-all promises no depth behind the lids"),
        () if settings.msaa > 1 => Some("it names one lid a pixel; use --msaa 1"),
        () if settings.depth_prepass == DepthPrepass::On => Some("--depth-prepass on traces before it shades"),
        () if settings.prism_culling == PrismCulling::Hidden => {
            Some("--prism-culling hidden draws its prisms in two rounds")
        }
        () if settings.view == View::Limits => Some("--view limits shows rays that miss too"),
        () => None,
    }
}

/// Whether draw `index`, of lids, begins its walks so.
fn need(settings: &Settings, index: usize, draw: &Draw) -> Need {
    let prisms = draw.range.len();
    if settings.visibility_buffer == VisibilityBuffer::Off {
        return Need::No("--visibility-buffer off".into());
    }
    if let Some(why) = obstacle(settings) {
        return Need::No(why.into());
    }
    match settings.visibility_buffer {
        _ if index >= MAX_DRAWS || prisms > MAX_PRISMS => Need::No("it has no number for them".into()),
        VisibilityBuffer::Auto if prisms < PAYS_FROM => {
            Need::No(format!("its {prisms} prisms are so large that few quads lie across their edges"))
        }
        VisibilityBuffer::Auto => {
            Need::Yes(format!("its {prisms} prisms are so small that many quads lie across their edges"))
        }
        asked => Need::Yes(format!("--visibility-buffer {asked}")),
    }
}

/// Why the raster's depth and coverage are not all that says which triangle a pixel sees.
fn unfit(alpha_mask: bool, depth_shift: bool) -> Option<&'static str> {
    match () {
        () if alpha_mask => Some("alpha cuts holes into its triangles"),
        () if depth_shift => Some("its depth is moved"),
        () => None,
    }
}

/// Whether a micro-mesh over so many base triangles has it; none where there is no micro-mesh.
fn mesh_need(settings: &Settings, triangles: usize, variant: &Variant) -> Option<Need> {
    let Some(Baseline::MicroMesh { density, .. }) = settings.baseline else { return None };
    let small = triangles * (density as usize).pow(2);
    let unfit = unfit(variant.alpha_mask, variant.depth_shift.is_some());
    Some(match (settings.visibility_buffer, unfit) {
        (VisibilityBuffer::Off, _) => Need::No("--visibility-buffer off".into()),
        (_, Some(why)) => Need::No(why.into()),
        (VisibilityBuffer::On, _) => Need::Yes("--visibility-buffer on".into()),
        (VisibilityBuffer::Auto, _) if small < MESH_PAYS_FROM => {
            Need::No(format!("its {small} triangles are so large that few quads lie across their edges"))
        }
        (VisibilityBuffer::Auto, _) if small > MESH_PAYS_TO => {
            Need::No(format!("its {small} triangles are more than fragments may read on every device"))
        }
        (VisibilityBuffer::Auto, _) => {
            Need::Yes(format!("its {small} triangles are so small that many quads lie across their edges"))
        }
    })
}

/// Decides it for each draw of lids, or of a micro-mesh.
pub fn decide(scene: &Scene, settings: &Settings, plan: &mut Plan) {
    for (index, draw) in plan.draws.iter_mut().enumerate() {
        let planned = &plan.primitives[draw.primitive];
        let need = match draw.variant.geometry {
            Geometry::Lids(_) => Some(need(settings, index, draw)),
            Geometry::MicroMesh => mesh_need(settings, source(scene, planned).triangles.len(), &draw.variant),
            _ => None,
        };
        if let Some(need) = need {
            let of = primitive_name(scene, planned.mesh, planned.primitive);
            draw.variant.visibility = plan.ledger.decide(&of, "visibility buffer", need);
        }
    }
}

impl Plan {
    /// What a visibility buffer names, if there is one.
    pub fn named(&self) -> Option<Named> {
        let draw = self.draws.iter().find(|draw| draw.visibility.is_some())?;
        Some(if draw.is_shell() { Named::Lids } else { Named::Triangles })
    }

    /// Whether it names the small triangles of a primitive.
    pub fn names_triangles(&self, primitive: usize) -> bool {
        let of = |draw: &Draw| draw.primitive == primitive && draw.variant.names_triangles();
        self.draws.iter().any(of)
    }
}

/// What writes it, once all else about the draws is decided.
pub fn complete(plan: &mut Plan) {
    for draw in plan.draws.iter_mut().filter(|draw| draw.variant.visibility) {
        draw.visibility = Some(draw.variant.for_visibility());
    }
}
