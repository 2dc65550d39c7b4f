//! `--view error`: a frame's depth error against the f64 reference as a heat map.

use prism_engine::{
    error::Result,
    measure::Metrics,
    shell::reference::{Reference, Shadows},
};

use super::{
    heat,
    picture::Picture,
    sample::{Exhibit, Shot},
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
