//! A flag in the wind: the mesh has another shape in every frame, and nothing about its shell is built anew. README.md
//! says what to look at.
//!
//! This file says where the vertices are, and no more. Normals, shell normals, how far those may reach before prisms
//! fold, and where rays may enter the shell: all that the engine's compute passes find for each frame.

use std::f64::consts::TAU;

use glam::{DVec3, Vec3};
use prism_engine::scene::Scene;

use crate::app::sample::{Moment, Pose, Sample, Source};

/// Seconds after which everything repeats.
const PERIOD: f64 = 6.0;

/// The cloth at rest, a sheet about the origin: half its length and half its height, mesh units.
const HALF: [f64; 2] = [1.5, 1.0];

/// A wave that travels along the cloth.
struct Wave {
    /// At the free edge, mesh units.
    height: f64,
    /// Radians per mesh unit along x and y.
    number: [f64; 2],
    /// Times in a period: whole, so that the last frame of a period meets the first.
    beats: f64,
    /// Radians.
    start: f64,
}

/// A long swell, a slanted ripple over it, and a flutter that runs the other way up.
const WAVES: [Wave; 3] = [
    Wave { height: 0.30, number: [2.7, 0.4], beats: 3.0, start: 0.0 },
    Wave { height: 0.11, number: [5.2, 2.3], beats: 5.0, start: 1.1 },
    Wave { height: 0.05, number: [7.9, -4.1], beats: 8.0, start: 2.6 },
];

/// How far the free edge hangs, and how far the swing of the waves draws it in, mesh units.
const SAG: f64 = 0.12;
const DRAW_IN: f64 = 0.18;

/// `prism run cloth`.
pub struct Cloth;

impl Sample for Cloth {
    fn id(&self) -> &'static str {
        "cloth"
    }

    fn summary(&self) -> &'static str {
        "A woven flag in the wind: a mesh that changes shape every frame, and its shell with it, at no rebuild"
    }

    fn scene(&self) -> Source {
        Source::Asset("cloth.gltf")
    }

    /// The camera stands still; the yarns do not slide on the sheet, nor does the outline come apart.
    fn at(&self, scene: &Scene, start: &Pose, time: f64) -> Moment {
        let poses = scene.meshes.iter().enumerate().map(|(mesh, shape)| {
            let vertices = shape.primitives.iter().flat_map(|primitive| &primitive.positions);
            (mesh, vertices.map(|at| waving(*at, time)).collect())
        });
        Moment { poses: poses.collect(), ..Moment::still(*start) }
    }
}

/// Where a vertex that rests at `at` is at a time. The edge at the pole, x = -1.5, never moves.
fn waving(at: Vec3, time: f64) -> Vec3 {
    let (x, y) = (f64::from(at.x), f64::from(at.y));
    // 0 at the pole, 1 at the free edge.
    let loose = (x + HALF[0]) / (2.0 * HALF[0]);
    let wave = |wave: &Wave| {
        let phase = wave.number[0] * x + wave.number[1] * y - TAU * wave.beats * time / PERIOD + wave.start;
        wave.height * phase.sin()
    };
    let out = loose * WAVES.iter().map(wave).sum::<f64>();
    // The lower edge hangs with the upper one; both come nearer to the pole where the cloth is thrown up in waves.
    let down = SAG * loose * loose * (1.0 + 0.2 * y / HALF[1]);
    DVec3::new(x - DRAW_IN * loose * loose, y - down, out).as_vec3()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_edge_at_the_pole_is_pinned_and_the_rest_waves() {
        for y in [-1.0, 0.0, 1.0] {
            let pole = Vec3::new(-1.5, y, 0.0);
            assert!([0.0, 0.7, 2.9].iter().all(|time| waving(pole, *time) == pole), "{pole}");
            let free = Vec3::new(1.5, y, 0.0);
            assert!(waving(free, 0.0).distance(waving(free, 0.7)) > 0.1, "{free}");
        }
    }

    #[test]
    fn a_period_ends_where_it_began() {
        let at = Vec3::new(0.4, -0.3, 0.0);
        assert!(waving(at, 0.0).abs_diff_eq(waving(at, PERIOD), 1e-6));
        assert!(waving(at, 0.0).distance(waving(at, PERIOD / 2.0)) > 0.01);
    }
}
