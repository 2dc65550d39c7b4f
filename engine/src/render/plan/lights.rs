//! What the lights of a plan need: shadow maps, where something casts on something.

use glam::DVec3;

use super::{Draw, Plan, ledger::Need, source};
use crate::render::shadow;
use crate::scene::Scene;
use crate::settings::Settings;

/// Lights that cast shadows: the scene's first ones. A fragment keeps what it sees of each in registers.
pub(super) const MAX_SHADOWED_LIGHTS: usize = 8;

/// What the lights see.
#[derive(Clone, Debug)]
pub struct ShadowPlan {
    /// Draws of the scene as blockers of light.
    pub draws: Vec<Draw>,
    /// Maps of each light that casts shadows, in their order.
    pub maps: Vec<u32>,
}

impl ShadowPlan {
    /// Maps of all lights.
    pub fn count(&self) -> u32 {
        self.maps.iter().sum()
    }
}

/// Lights of a scene that cast shadows.
pub(super) fn shadowed_lights(scene: &Scene) -> u8 {
    scene.lights.len().min(MAX_SHADOWED_LIGHTS) as u8
}

/// Shadow maps need a light, something that casts and something that receives.
pub(super) fn plan_shadow_maps(scene: &Scene, settings: &Settings, plan: &mut Plan) {
    if !settings.shadow_map {
        plan.ledger.decide("scene", "shadow maps", Need::No("--shadow-map off".into()));
        return;
    }
    let one_plane = "all there is lies in one plane, so nothing casts on anything";
    let need = match () {
        () if settings.baseline.is_some() => Need::No("a baseline is drawn without shadows".into()),
        () if scene.lights.is_empty() => Need::No("the scene has no light".into()),
        () => Need::when(casts(scene, plan), "something may stand between a light and something else", one_plane),
    };
    if let Need::No(reason) | Need::Idle(reason) = &need {
        plan.notices.push(format!("no shadow map: {reason}"));
    }
    if !plan.ledger.decide("scene", "shadow maps", need) {
        return;
    }
    let lights = scene.lights.iter().take(usize::from(shadowed_lights(scene)));
    plan.shadow_maps = Some(ShadowPlan {
        draws: plan.draws.iter().map(|d| Draw { variant: d.variant.for_light(), ..d.clone() }).collect(),
        maps: lights.map(|light| shadow::maps(light, settings)).collect(),
    });
    for draw in &mut plan.draws {
        draw.variant.shadow_maps = true;
        draw.variant.shadowed_lights = shadowed_lights(scene);
    }
}

/// Whether something drawn may stand between a light and something else: not where all is one flat plain sheet.
fn casts(scene: &Scene, plan: &Plan) -> bool {
    let [draw] = &plan.draws[..] else { return !plan.draws.is_empty() };
    let primitive = source(scene, &plan.primitives[draw.primitive]);
    let mut normals = primitive.triangles.iter().map(|triangle| {
        let [a, b, c] = triangle.map(|v| primitive.positions[v as usize].as_dvec3());
        ((b - a).cross(c - a).normalize_or_zero(), a)
    });
    let first = normals.next();
    draw.variant.height.is_some()
        || plan.primitives[draw.primitive].deforms
        || plan.primitives[draw.primitive].offset.is_some()
        || first.is_some_and(|(n, p)| normals.any(|(m, q)| n.cross(m) != DVec3::ZERO || n.dot(q - p) != 0.0))
}
