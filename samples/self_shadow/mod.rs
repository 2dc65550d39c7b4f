//! A low sun circles over cobbles, which shadow each other in four ways: not at all, hard, soft, and by a shadow map.
//! README.md says what to look at.

use std::f64::consts::TAU;

use glam::DQuat;
use prism_engine::{
    aov::Aov,
    error::Result,
    scene::{Light, Scene},
    settings::{SelfShadow, Settings},
};

use crate::app::{
    grid::Grid,
    picture::Picture,
    sample::{Exhibit, Moment, Pose, Sample, Shot, Source},
};

const GRID: Grid = Grid { columns: 2, rows: 2 };

/// Seconds of the sun's turn.
const PERIOD: f64 = 24.0;

/// Tangent of its angular radius: 13 times the real sun's.
const SOFTNESS: f32 = 0.06;

/// `prism run self_shadow`.
pub struct SelfShadows;

impl Sample for SelfShadows {
    fn id(&self) -> &'static str {
        "self_shadow"
    }

    fn summary(&self) -> &'static str {
        "A low sun circles over cobbles: without their shadows, with hard ones, with soft ones, and with a shadow map"
    }

    fn scene(&self) -> Source {
        Source::Asset("self_shadow.gltf")
    }

    fn settings(&self) -> Settings {
        Settings { self_shadow: SelfShadow::Soft, shadow_softness: SOFTNESS, ..Settings::default() }
    }

    /// The camera and the cobbles rest.
    fn at(&self, scene: &Scene, start: &Pose, time: f64) -> Moment {
        let turn = DQuat::from_rotation_y(TAU * time / PERIOD);
        let turned = scene.lights.iter().map(|&sun| Light { direction: turn * sun.direction, ..sun });
        Moment { lights: turned.enumerate().collect(), ..Moment::still(*start) }
    }

    fn exhibit(&self) -> Option<&'static dyn Exhibit> {
        Some(&Four)
    }
}

/// A cell a way.
struct Four;

impl Exhibit for Four {
    fn frame_size(&self, size: [u32; 2]) -> Result<[u32; 2]> {
        GRID.cell(size)
    }

    fn variants(&self, settings: &Settings) -> Vec<Settings> {
        let rays = SelfShadow::ALL.iter().map(|&self_shadow| (self_shadow, false));
        let ways = rays.chain([(SelfShadow::Off, true)]);
        ways.map(|(self_shadow, shadow_map)| Settings { self_shadow, shadow_map, ..settings.clone() }).collect()
    }

    fn compose(&self, shot: &Shot<'_>, size: [u32; 2]) -> (Picture, String) {
        let names = SelfShadow::ALL.iter().map(|way| way.name()).chain(["shadow map"]);
        let lines = names.zip(shot.variants).map(|(name, drawn)| {
            let [lit, between] = light_on(&drawn.aov);
            format!("{name:>10}: {lit:.3} of the light arrives, {between:.3} of the pixels see a part of it")
        });
        let figures = lines.collect::<Vec<_>>().join("\n");
        (GRID.compose(size, shot.variants.iter().map(|drawn| &drawn.frame)), figures)
    }
}

/// Mean of what the covered pixels see of the light, and the share of those that see a part.
fn light_on(aov: &Aov) -> [f64; 2] {
    let seen: Vec<f64> =
        aov.depth.iter().zip(&aov.shadow).filter(|(d, _)| d.is_finite()).map(|(_, s)| f64::from(*s)).collect();
    let covered = seen.len().max(1) as f64;
    [seen.iter().sum::<f64>() / covered, seen.iter().filter(|s| **s > 0.0 && **s < 1.0).count() as f64 / covered]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_way_has_a_cell_of_its_own() {
        let variants = Four.variants(&SelfShadows.settings());
        assert_eq!(variants.len() as u32, GRID.columns * GRID.rows);
        for way in SelfShadow::ALL {
            assert_eq!(variants.iter().filter(|s| s.self_shadow == *way && !s.shadow_map).count(), 1);
        }
        assert_eq!(variants.iter().filter(|s| s.shadow_map).count(), 1);
    }

    #[test]
    fn parts_of_the_light_are_counted_where_something_is() {
        let mut aov = Aov::missed(4, 1);
        (aov.depth, aov.shadow) = (vec![1.0, 1.0, f32::INFINITY, 1.0], vec![0.0, 0.5, 1.0, 1.0]);
        assert_eq!(light_on(&aov), [0.5, 1.0 / 3.0]);
    }
}
