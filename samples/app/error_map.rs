//! `--view error`: a frame's depth error against the f64 reference as a heat map.

use prism_engine::{
    error::{Error, Result},
    measure::Metrics,
    scene::Scene,
    shell::reference::{Reference, Shadows},
};

use super::{
    heat,
    picture::Picture,
    sample::{Exhibit, Moment, Shot},
};

/// The frame, judged.
pub struct ErrorMap;

impl Exhibit for ErrorMap {
    fn frame_size(&self, size: [u32; 2]) -> Result<[u32; 2]> {
        Ok(size)
    }

    fn compose(&self, shot: &Shot<'_>, size: [u32; 2]) -> (Picture, String) {
        let [width, height] = shot.frame.size;
        let reference = Reference::new(shot.scene);
        let truth = reference.render_counting(shot.camera, width, height, Shadows::Skip, shot.done);
        let m = Metrics::between(shot.aov, &truth, shot.camera);
        let mut picture = heat::map(shot.aov, &truth, shot.camera);
        // The colours' scale, along the lower edge.
        let strip = size[1] / 40;
        picture.paste(&heat::strip([width, strip]), [0, height - strip]);
        let figures = format!(
            "{}: depth error p50 {:.1e}, p99 {:.1e} footprints; above 1 footprint {:.1e}; coverage differs {:.1e}",
            shot.name, m.depth_p50, m.depth_p99, m.depth_above_1, m.coverage_differs
        );
        (picture, figures)
    }
}

/// The scene as it stands at a moment.
///
/// # Errors
/// `Usage` where a mesh has changed shape: that is known on the GPU only.
pub fn moved(scene: &Scene, moment: &Moment) -> Result<Scene> {
    if !moment.poses.is_empty() {
        return Err(Error::Usage(
            "the mesh changes shape on the GPU, and the reference knows it at rest only: no --view error, no probe"
                .into(),
        ));
    }
    let mut scene = scene.clone();
    for &(instance, transform) in &moment.transforms {
        scene.instances[instance].transform = transform;
    }
    Ok(scene)
}
