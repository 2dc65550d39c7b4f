//! Whose walks begin at the lids that a visibility buffer names.

use super::ledger::Need;
use super::{Draw, Plan, primitive_name};
use crate::error::{Error, Result};
use crate::render::variant::Geometry;
use crate::render::visibility::{MAX_DRAWS, MAX_PRISMS};
use crate::scene::Scene;
use crate::settings::{DepthPrepass, PrismCulling, Settings, Shell, View, VisibilityBuffer};

/// Prisms of a primitive from which on it pays: fewer are so large on the screen that few quads lie across their edges,
/// and the passes cost more than they spare (README, "The visibility buffer").
const PAYS_FROM: usize = 256;

/// Refuses a visibility buffer that the settings have no use for.
pub fn check(scene: &Scene, settings: &Settings) -> Result<()> {
    if settings.visibility_buffer != VisibilityBuffer::On {
        return Ok(());
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

/// Decides it for each draw of lids.
pub fn decide(scene: &Scene, settings: &Settings, plan: &mut Plan) {
    for (index, draw) in plan.draws.iter_mut().enumerate() {
        if matches!(draw.variant.geometry, Geometry::Lids(_)) {
            let planned = &plan.primitives[draw.primitive];
            let of = primitive_name(scene, planned.mesh, planned.primitive);
            draw.variant.visibility = plan.ledger.decide(&of, "visibility buffer", need(settings, index, draw));
        }
    }
}

/// What writes it, once all else about the draws is decided.
pub fn complete(plan: &mut Plan) {
    for draw in plan.draws.iter_mut().filter(|draw| draw.variant.visibility) {
        draw.visibility = Some(draw.variant.for_visibility());
    }
}
