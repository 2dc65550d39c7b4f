//! A job's scene, complete: what the file lacks is added, and the user is told.

use prism_engine::{
    error::Result,
    scene::{self, Scene},
};

use super::{camera, console, job::Job, sample::Pose};

/// Reads the scene and tells its notices. The pose is the camera at time 0.
pub fn load(job: &Job<'_>) -> Result<(Scene, Pose)> {
    let size = job.common.session.size;
    let aspect = f64::from(size.width) / f64::from(size.height);
    let scene = scene::load(&job.scene)?.with_defaults(aspect);
    for notice in &scene.notices {
        console::notice(notice);
    }
    let base = scene.camera.unwrap_or_else(|| scene::frame(scene.bounds().unwrap_or_default(), aspect));
    let pose = camera::start(&job.common.camera, &scene, &base)?;
    Ok((scene, pose))
}
