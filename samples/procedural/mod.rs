//! A brick wall that is a function, at several tilts: 32 steps on its base surface beside the shell. README.md says what to
//! look at.

use glam::{DQuat, DVec3};
use prism_engine::{
    error::Result,
    measure::Metrics,
    scene::Scene,
    settings::{March, Settings, Shell},
    shell::reference::{Reference, Shadows},
};

use crate::app::{
    grid::Grid,
    picture::Picture,
    sample::{Exhibit, Moment, Pose, Sample, Shot, Source},
};

/// The base surface, and the shell.
const COLUMNS: u32 = 2;

/// Degrees between the view and the wall's normal, a row each.
const TILTS: &[f64] = &[60.0, 80.0, STEEPEST];
/// Beyond it next to nothing of the wall is left in view.
const STEEPEST: f64 = 88.0;
/// Seconds from face to face again.
const PERIOD: f64 = 16.0;
/// Degrees: the wall at the least tilt fills a cell, in a picture of 16 to 9.
const CELL_FOV_Y: f64 = 11.0;

/// `prism run procedural`.
pub struct Wall {
    /// Where `--tilt` holds it.
    tilt: Option<f64>,
    tilts: &'static Tilts,
}

impl Wall {
    /// At several tilts, and in motion.
    pub const SWINGING: Wall = Wall { tilt: None, tilts: &Tilts(TILTS) };
}

impl Sample for Wall {
    fn id(&self) -> &'static str {
        "procedural"
    }

    fn summary(&self) -> &'static str {
        "A brick wall that is a function, tilted up to 88 degrees: 32 steps on its base surface beside the shell"
    }

    fn scene(&self) -> Source {
        Source::Asset("wall.gltf")
    }

    fn moves(&self) -> bool {
        self.tilt.is_none()
    }

    /// From face to face through every tilt.
    fn at(&self, _scene: &Scene, start: &Pose, time: f64) -> Moment {
        let swing = 0.5 - 0.5 * (std::f64::consts::TAU * time / PERIOD).cos();
        match self.tilt {
            Some(degrees) => Moment::still(tilted(start, degrees, None)),
            None if time == 0.0 => Moment::still(*start),
            None => Moment::still(tilted(start, STEEPEST * swing, None)),
        }
    }

    fn tilted(&self, degrees: f64) -> Option<&'static dyn Sample> {
        // There is one such wall, until the program ends.
        let tilts = Box::leak(Box::new(Tilts(Box::leak(Box::new([degrees])))));
        Some(Box::leak(Box::new(Wall { tilt: Some(degrees), tilts })))
    }

    fn exhibit(&self) -> Option<&'static dyn Exhibit> {
        Some(self.tilts)
    }
}

/// The same distance from the wall, which faces +Z, looking up along it.
fn tilted(pose: &Pose, degrees: f64, fov_y: Option<f64>) -> Pose {
    let away = DQuat::from_rotation_x(degrees.to_radians()) * DVec3::Z;
    let eye = pose.pivot + away * pose.camera.transform.translation.distance(pose.pivot);
    // Only an orthographic camera refuses an angle of view; it then stays as it is.
    let camera = pose.camera.overridden(Some(eye), Some(pose.pivot), fov_y).unwrap_or(pose.camera);
    Pose { camera, ..*pose }
}

struct Tilts(&'static [f64]);

impl Tilts {
    fn grid(&self) -> Grid {
        Grid { columns: COLUMNS, rows: self.0.len() as u32 }
    }
}

impl Exhibit for Tilts {
    fn frame_size(&self, size: [u32; 2]) -> Result<[u32; 2]> {
        self.grid().cell(size)
    }

    fn variants(&self, settings: &Settings) -> Vec<Settings> {
        let (min_steps, max_steps) = (32, 32);
        let steep = Settings { shell: Shell::Off, march: March::Steep, min_steps, max_steps, ..settings.clone() };
        let refine_steps = steep.march.usual_refine_steps();
        let shell = if settings.resolved_shell() == Shell::Off { Shell::Auto } else { settings.shell };
        let exact = Settings { shell, march: March::Exact, ..settings.clone() };
        self.0.iter().flat_map(|_| [Settings { refine_steps, ..steep.clone() }, exact.clone()]).collect()
    }

    fn seen_from(&self, index: usize, pose: &Pose) -> Pose {
        tilted(pose, self.0[index / COLUMNS as usize], Some(CELL_FOV_Y))
    }

    fn compose(&self, shot: &Shot<'_>, size: [u32; 2]) -> (Picture, String) {
        let reference = Reference::new(shot.scene);
        let lines = self.0.iter().zip(shot.variants.chunks(COLUMNS as usize)).map(|(tilt, row)| {
            let truth = reference.render(&row[0].camera, shot.aov.width, shot.aov.height, Shadows::Skip);
            let errors = row.iter().zip(["32 steps on the base surface", "the shell"]).map(|(drawn, what)| {
                let m = Metrics::between(&drawn.aov, &truth, &drawn.camera);
                format!("{what}: coverage differs {:.1e}, depth p99 {:.1e} footprints", m.coverage_differs, m.depth_p99)
            });
            format!("{tilt} degrees: {}", errors.collect::<Vec<_>>().join("; "))
        });
        let figures = lines.collect::<Vec<_>>().join("\n");
        (self.grid().compose(size, shot.variants.iter().map(|drawn| &drawn.frame)), figures)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DAffine3;
    use prism_engine::scene::{Camera, Projection};

    #[test]
    fn every_row_is_seen_at_its_tilt_and_distance() {
        let camera = Camera {
            transform: DAffine3::from_translation(DVec3::new(0.0, 0.0, 7.0)),
            projection: Projection::Perspective { fov_y: 0.5, near: 0.1, far: None },
        };
        let pose = Pose { camera, pivot: DVec3::ZERO };
        let wall = Wall::SWINGING;
        let variants = wall.tilts.variants(&wall.settings());
        assert_eq!(variants.len(), 2 * TILTS.len());
        for (i, settings) in variants.iter().enumerate() {
            let seen = wall.tilts.seen_from(i, &pose).camera.transform;
            let cosine = seen.translation.normalize().z;
            assert!((cosine.acos().to_degrees() - TILTS[i / 2]).abs() < 1e-6);
            assert!((seen.translation.length() - 7.0).abs() < 1e-12 && seen.translation.y < 0.0);
            assert_eq!(settings.resolved_shell() == Shell::Off, i % 2 == 0);
        }
    }

    #[test]
    fn a_tilt_of_ones_own_is_the_only_row() {
        let wall = Wall::SWINGING.tilted(30.0).expect("a wall");
        assert!(!wall.moves() && Wall::SWINGING.moves());
        let exhibit = wall.exhibit().expect("a grid");
        assert_eq!(exhibit.variants(&wall.settings()).len(), 2);
        assert_eq!(exhibit.frame_size([642, 180]).expect("room"), [320, 180]);
    }
}
