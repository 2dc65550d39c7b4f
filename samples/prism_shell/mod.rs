//! The effect in one picture: a ring of cobbles over a floor of bricks, both coarse meshes, and plain balls that cut
//! through them. README.md says what to look at.

use std::f64::consts::TAU;

use prism_engine::scene::Scene;

use crate::app::sample::{Moment, Pose, Sample, Source};

/// Seconds of one turn around the ring.
const PERIOD: f64 = 40.0;

/// `prism run prism_shell`.
pub struct PrismShell;

impl Sample for PrismShell {
    fn id(&self) -> &'static str {
        "prism_shell"
    }

    fn summary(&self) -> &'static str {
        "Displaced cobbles and bricks on coarse meshes, with silhouettes and true depth; plain balls cut through them"
    }

    fn scene(&self) -> Source {
        Source::Asset("prism_shell.gltf")
    }

    /// The camera goes around, so that every silhouette and every intersection is seen to hold from all sides.
    /// Slowly: crawling layers or popping would show.
    fn at(&self, _scene: &Scene, start: &Pose, time: f64) -> Moment {
        Moment::still(start.orbited(TAU * time / PERIOD))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::testing::empty_scene;
    use glam::{DAffine3, DVec3};
    use prism_engine::scene::{Camera, Projection};

    #[test]
    fn a_turn_ends_where_it_began() {
        let transform = DAffine3::from_translation(DVec3::new(1.0, 2.0, 5.0));
        let projection = Projection::Perspective { fov_y: 0.6, near: 0.05, far: None };
        let start = Pose { camera: Camera { transform, projection }, pivot: DVec3::ZERO };
        let eye = |time| PrismShell.at(&empty_scene(), &start, time).pose.camera.transform.translation;
        assert_eq!(eye(0.0), transform.translation);
        assert!(eye(PERIOD).abs_diff_eq(eye(0.0), 1e-9));
        assert!(eye(PERIOD / 2.0).distance(eye(0.0)) > 1.0);
    }
}
