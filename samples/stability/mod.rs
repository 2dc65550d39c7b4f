//! The hard scenes, where a trace in a shell loses its digits, its rays or its way, each beside the f64 reference.
//! README.md says what to look at.

use prism_engine::{
    error::{Error, Result},
    measure::Metrics,
    shell::reference::{Reference, Shadows},
};

use crate::app::{
    clay, heat,
    picture::Picture,
    sample::{Exhibit, Sample, Shot, Source},
};

/// From the tame to the wild: closed, uneven, hard-edged and open meshes, then each the worst case of one kind.
const SCENES: [&str; 10] = [
    "torus.gltf",
    "suzanne.gltf",
    "cube.gltf",
    "cloth.gltf",
    "stability_cliffs.gltf",
    "stability_needles.gltf",
    "stability_slivers.gltf",
    "stability_seams.gltf",
    "stability_far.gltf",
    "stability_inside.gltf",
];

/// What the exact march has to reach. 99 % of the pixels are this near to the truth, in pixel footprints.
const DEPTH_P99: f64 = 0.05;
/// Share of the pixels that may be off by more than a footprint.
const ABOVE_1: f64 = 1e-4;
/// Pixels that one picture alone covers, per covered pixel.
const COVERAGE: f64 = 2e-4;

/// `prism run stability`.
pub struct Stability;

impl Sample for Stability {
    fn id(&self) -> &'static str {
        "stability"
    }

    fn summary(&self) -> &'static str {
        "Ten hard scenes, each beside the f64 reference, with a heat map of the depth error"
    }

    fn scene(&self) -> Source {
        Source::Walk(&SCENES)
    }

    fn moves(&self) -> bool {
        false
    }

    fn exhibit(&self) -> Option<&'static dyn Exhibit> {
        Some(&Panels)
    }
}

/// Four panels of equal size:
///
/// | the frame as the GPU shades it | the reference's surface in clay |
/// |---|---|
/// | the GPU's surface in clay | the depth error between the two as a heat map |
struct Panels;

impl Exhibit for Panels {
    fn frame_size(&self, size: [u32; 2]) -> Result<[u32; 2]> {
        if size.contains(&1) {
            let [width, height] = size;
            return Err(Error::Usage(format!("--size {width}x{height}: four panels need 2x2 pixels at least")));
        }
        Ok(size.map(|side| side / 2))
    }

    fn compose(&self, shot: &Shot<'_>, size: [u32; 2]) -> (Picture, String) {
        let truth = Reference::new(shot.scene).render(shot.camera, shot.aov.width, shot.aov.height, Shadows::Skip);
        let figures = figures(shot.name, &Metrics::between(shot.aov, &truth, shot.camera));

        let [width, height] = shot.frame.size;
        // With an odd size a line is left over; it lies between the panels.
        let (right, below) = (size[0] - width, size[1] - height);
        let mut picture = Picture::filled(size, heat::BACKGROUND);
        picture.paste(shot.frame, [0, 0]);
        picture.paste(&clay::of(&truth, shot.camera), [right, 0]);
        picture.paste(&clay::of(shot.aov, shot.camera), [0, below]);
        picture.paste(&heat::map(shot.aov, &truth, shot.camera), [right, below]);
        // The colours' scale, along the heat map's lower edge where there is room for it.
        let strip = height / 24;
        picture.paste(&heat::strip([width, strip]), [right, size[1] - strip]);
        (picture, figures)
    }
}

/// One line: the scene, its figures, and whether they are those of the exact march.
fn figures(name: &str, m: &Metrics) -> String {
    let met = m.depth_p99 <= DEPTH_P99
        && m.depth_above_1 <= ABOVE_1
        && m.coverage_differs <= COVERAGE
        && m.nan_count == 0
        && m.covered > 0;
    format!(
        "{name}: {} pixels covered; depth error p99 {:.1e} footprints; above 1 footprint {:.1e}; coverage differs {:.1e}; \
         NaN {}; {}",
        m.covered,
        m.depth_p99,
        m.depth_above_1,
        m.coverage_differs,
        m.nan_count,
        if met { "met" } else { "missed" }
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::testing::empty_scene;
    use glam::DAffine3;
    use prism_engine::{
        aov::Aov,
        scene::{Camera, Projection},
    };
    use std::sync::atomic::AtomicUsize;

    fn camera() -> Camera {
        let projection = Projection::Perspective { fov_y: 1.0, near: 0.1, far: None };
        Camera { transform: DAffine3::IDENTITY, projection }
    }

    #[test]
    fn every_scene_of_the_walk_is_an_asset_with_a_camera() {
        for name in SCENES {
            let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets").join(name);
            assert!(prism_engine::scene::load(&file).unwrap().camera.is_some(), "{name}");
        }
    }

    #[test]
    fn the_panels_stand_where_they_should() {
        let size = [9, 101];
        let [width, height] = Panels.frame_size(size).unwrap();
        let frame = Picture::filled([width, height], [1, 2, 3]);
        let mut aov = Aov::missed(width, height);
        aov.depth[0] = 1.0;
        let (scene, camera) = (empty_scene(), camera());
        let shot = Shot {
            name: "none",
            scene: &scene,
            camera: &camera,
            frame: &frame,
            aov: &aov,
            variants: &[],
            done: &AtomicUsize::new(0),
        };
        let (picture, figures) = Panels.compose(&shot, size);
        let at = |x: usize, y: usize| <[u8; 3]>::try_from(&picture.pixels[y * 9 + x][..3]).unwrap();
        assert_eq!((at(0, 0), at(3, 49)), ([1, 2, 3], [1, 2, 3]), "the frame");
        assert_eq!((at(5, 0), at(8, 49)), (clay::BEHIND, clay::BEHIND), "an empty reference");
        assert_ne!(at(0, 51), clay::BEHIND, "a surface in clay");
        assert_eq!((at(5, 51), at(6, 51)), (heat::GHOST, heat::BACKGROUND), "the heat map");
        assert_eq!((at(5, 100), at(8, 100)), (heat::SCALE[0], heat::SCALE[7]), "the scale");
        assert!(figures.starts_with("none: 0 pixels") && figures.ends_with("missed"), "{figures}");
        assert!(Panels.frame_size([1, 2]).is_err());
    }
}
