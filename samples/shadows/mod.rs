//! Shadow maps drawn by the tracer itself: displaced detail casts on plain and displaced things, and receives. README.md
//! says what to look at.

use std::f64::consts::TAU;

use glam::{DAffine3, DQuat};
use prism_engine::{scene::Scene, settings::Settings};

use crate::app::sample::{Moment, Pose, Sample, Source};

/// Seconds of one turn of the ring.
const PERIOD: f64 = 30.0;

/// `prism run shadows`.
pub struct Shadows;

impl Sample for Shadows {
    fn id(&self) -> &'static str {
        "shadows"
    }

    fn summary(&self) -> &'static str {
        "Stones, bricks and plain balls cast shadows on each other and on a plain floor, through maps drawn by the tracer"
    }

    fn scene(&self) -> Source {
        Source::Asset("shadows.gltf")
    }

    fn settings(&self) -> Settings {
        Settings { shadow_map: true, ..Settings::default() }
    }

    /// The ring turns about its own axis: every stone's shadow goes with it, over floor, block and ball.
    fn at(&self, scene: &Scene, start: &Pose, time: f64) -> Moment {
        let turn = DAffine3::from_quat(DQuat::from_rotation_y(TAU * time / PERIOD));
        let rings = scene.instances.iter().enumerate().filter(|(_, instance)| instance.name == "ring");
        Moment { transforms: rings.map(|(i, ring)| (i, ring.transform * turn)).collect(), ..Moment::still(*start) }
    }
}
