//! Punctual lights: the file's, and the one that a scene without any gets.

use std::f64::consts::FRAC_PI_2;

use glam::DVec3;
use gltf::json::{extensions::scene::khr_lights_punctual::Type, validation::Checked};

use super::{
    Light, LightKind,
    document::{Document, label},
    node::Reached,
};
use crate::error::Result;

/// A white sun from above, the left and the front.
pub(super) fn default_light() -> Light {
    Light {
        intensity: DVec3::splat(3.0),
        position: DVec3::ZERO,
        direction: DVec3::new(0.4, -1.0, -0.6).normalize(),
        range: None,
        kind: LightKind::Directional,
    }
}

/// The lights of the nodes that the scene reaches, by the nodes' index in the file.
pub(super) fn import(doc: &Document, reached: &[Reached]) -> Result<Vec<Light>> {
    let mut sorted = reached.to_vec();
    sorted.sort_by_key(|reached| reached.node);
    let mut lights = Vec::new();
    for reached in sorted {
        let extensions = doc.nodes[reached.node].extensions.as_ref();
        if let Some(reference) = extensions.and_then(|extensions| extensions.khr_lights_punctual.as_ref()) {
            lights.push(light(doc, reached, reference.light.value())?);
        }
    }
    Ok(lights)
}

fn light(doc: &Document, reached: Reached, index: usize) -> Result<Light> {
    let node = doc.node_label(reached.node);
    let Some(light) = doc.lights.get(index) else {
        let problem = format!("refers to light {index}, but the file has {} of them", doc.lights.len());
        return Err(doc.error(node, problem, "correct the index in its KHR_lights_punctual"));
    };
    let wrong = |problem: &str| doc.error(label("light", index, light.name.as_deref()), problem, "correct the light");
    let intensity = DVec3::from(light.color.map(f64::from)) * f64::from(light.intensity);
    if !intensity.is_finite() || intensity.min_element() < 0.0 {
        return Err(wrong("its colour or intensity is negative or not finite"));
    }
    let range = light.range.map(f64::from);
    if range.is_some_and(|range| !(range > 0.0 && range.is_finite())) {
        return Err(wrong("its range is not above 0"));
    }
    let kind = match (&light.type_, &light.spot) {
        (Checked::Valid(Type::Directional), _) => LightKind::Directional,
        (Checked::Valid(Type::Point), _) => LightKind::Point,
        (Checked::Valid(Type::Spot), Some(spot)) => {
            let (inner, outer) = (f64::from(spot.inner_cone_angle), f64::from(spot.outer_cone_angle));
            // π/2 rounded to f32 is a hair above π/2.
            if !(0.0 <= inner && inner < outer && outer <= FRAC_PI_2 + 1e-6) {
                return Err(wrong("its cone angles are not 0 ≤ inner < outer ≤ π/2"));
            }
            LightKind::Spot { inner, outer: outer.min(FRAC_PI_2) }
        }
        (Checked::Valid(Type::Spot), None) => return Err(wrong("is a spot without 'spot'")),
        (Checked::Invalid, _) => {
            return Err(wrong("its type is none of directional, point and spot"));
        }
    };
    // A point light has no direction to lose; any unit vector keeps the others' arithmetic finite.
    let direction = match (reached.world.matrix3 * DVec3::NEG_Z).try_normalize() {
        Some(direction) => direction,
        None if kind == LightKind::Point => DVec3::NEG_Z,
        None => {
            return Err(doc.error(node, "its light has no direction: the scale is 0", "give it a scale of 1"));
        }
    };
    Ok(Light {
        intensity,
        position: reached.world.translation,
        direction,
        // The extension gives directional lights no range.
        range: range.filter(|_| kind != LightKind::Directional),
        kind,
    })
}
