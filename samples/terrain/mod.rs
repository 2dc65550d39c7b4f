//! A real elevation model on a handful of triangles, flat and on a planet's patch, from far and from inside the shell.
//! README.md says what to look at.

use glam::DVec3;
use prism_engine::{
    error::Result,
    measure::Metrics,
    settings::Settings,
    shell::reference::{Reference, Shadows},
};

use crate::app::{
    grid::Grid,
    picture::Picture,
    sample::{Exhibit, Pose, Sample, Shot, Source},
};

const GRID: Grid = Grid { columns: 2, rows: 2 };

/// Name, eye, target and vertical angle of view in degrees. Inside, the eye is below the highest summit's level.
const VIEWS: [(&str, [f64; 3], [f64; 3], f64); 4] = [
    ("flat, from far", [-1.8, 1.5, 2.4], [-2.0, -0.05, 0.05], 34.0),
    ("curved, from far", [2.2, 1.3, 2.6], [2.0, -0.25, 0.05], 37.0),
    ("flat, from inside", [-1.853, 0.081, 0.023], [-2.159, 0.06, -0.622], 50.0),
    ("curved, from inside", [2.154, 0.074, 0.024], [1.848, -0.071, -0.629], 50.0),
];

/// `prism run terrain`.
pub struct Terrain;

impl Sample for Terrain {
    fn id(&self) -> &'static str {
        "terrain"
    }

    fn summary(&self) -> &'static str {
        "A real elevation model on 8 flat triangles and on 32 of a planet's patch, from far and from inside the shell"
    }

    fn scene(&self) -> Source {
        Source::Asset("planet.gltf")
    }

    fn moves(&self) -> bool {
        false
    }

    fn exhibit(&self) -> Option<&'static dyn Exhibit> {
        Some(&Views)
    }
}

struct Views;

impl Exhibit for Views {
    fn frame_size(&self, size: [u32; 2]) -> Result<[u32; 2]> {
        GRID.cell(size)
    }

    fn variants(&self, settings: &Settings) -> Vec<Settings> {
        vec![settings.clone(); VIEWS.len()]
    }

    fn seen_from(&self, index: usize, pose: &Pose) -> Pose {
        let (_, eye, target, fov_y) = VIEWS[index];
        let target = DVec3::from_array(target);
        // The file's camera is a perspective one, which refuses none of these.
        let camera = pose.camera.overridden(Some(DVec3::from_array(eye)), Some(target), Some(fov_y));
        Pose { camera: camera.unwrap_or(pose.camera), pivot: target }
    }

    fn compose(&self, shot: &Shot<'_>, size: [u32; 2]) -> (Picture, String) {
        let reference = Reference::new(shot.scene);
        let lines = VIEWS.iter().zip(shot.variants).map(|((name, ..), drawn)| {
            let truth = reference.render(&drawn.camera, drawn.aov.width, drawn.aov.height, Shadows::Skip);
            let m = Metrics::between(&drawn.aov, &truth, &drawn.camera);
            format!("{name}: coverage differs {:.1e}, depth p99 {:.1e} footprints", m.coverage_differs, m.depth_p99)
        });
        let figures = lines.collect::<Vec<_>>().join("\n");
        (GRID.compose(size, shot.variants.iter().map(|drawn| &drawn.frame)), figures)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DAffine3;
    use prism_engine::scene::{Camera, Projection};

    #[test]
    fn every_cell_has_its_view() {
        assert_eq!((GRID.columns * GRID.rows) as usize, Views.variants(&Terrain.settings()).len());
        let projection = Projection::Perspective { fov_y: 0.5, near: 0.1, far: None };
        let pose = Pose { camera: Camera { transform: DAffine3::IDENTITY, projection }, pivot: DVec3::ZERO };
        for (i, (name, eye, ..)) in VIEWS.iter().enumerate() {
            assert_eq!(Views.seen_from(i, &pose).camera.transform.translation.to_array(), *eye, "{name}");
        }
    }
}
