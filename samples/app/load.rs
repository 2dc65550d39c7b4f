//! A job's scenes, complete: what a file lacks is added, and the user is told.

use std::{path::Path, sync::Arc};

use prism_engine::{
    error::{Error, Result},
    scene::{self, Scene},
};

use super::{camera, cli::CameraArgs, console, job::Job, sample::Pose, surface::SurfaceArgs, walk};

/// A scene and where a run through it starts.
#[derive(Clone)]
pub struct Loaded {
    /// What it is called.
    pub name: String,
    /// The scene, with a camera and a light.
    pub scene: Arc<Scene>,
    /// The camera at time 0.
    pub start: Pose,
}

/// Reads the scenes that so many frames show, and tells their notices.
pub fn load(job: &Job<'_>, frames: u64) -> Result<Vec<Loaded>> {
    job.walk.files(frames).map(|file| load_one(job, file, &job.common.surface)).collect()
}

/// Reads all scenes again, with other values of their displaced materials.
#[cfg(feature = "window")]
pub fn again(job: &Job<'_>, surface: &SurfaceArgs) -> Result<Vec<Loaded>> {
    job.walk.files(u64::MAX).map(|file| load_one(job, file, surface)).collect()
}

/// Reads a scene in which nothing moves, and tells its notices. `size`: of the picture.
pub fn still(file: &Path, size: [u32; 2], surface: &SurfaceArgs, camera: &CameraArgs) -> Result<Loaded> {
    let (scene, start) = read(file, size, surface, camera)?;
    Ok(Loaded { name: walk::name(file), scene: Arc::new(scene), start })
}

fn load_one(job: &Job<'_>, file: &Path, surface: &SurfaceArgs) -> Result<Loaded> {
    let (mut scene, start) = read(file, job.size(), surface, &job.common.camera)?;
    let moment = job.sample.at(&scene, &start, 0.0);
    if surface.light.given() && !moment.lights.is_empty() {
        let id = job.sample.id();
        return Err(Error::Usage(format!("--sun, --light-intensity: {id} lights its scene itself; drop them")));
    }
    for (mesh, _) in moment.poses {
        scene.meshes[mesh].deforms = true;
    }
    Ok(Loaded { name: walk::name(file), scene: Arc::new(scene), start })
}

fn read(file: &Path, size: [u32; 2], surface: &SurfaceArgs, camera: &CameraArgs) -> Result<(Scene, Pose)> {
    let aspect = f64::from(size[0]) / f64::from(size[1]);
    let mut scene = scene::load(file)?;
    scene.adjust(&surface.adjustment())?;
    let mut scene = scene.with_defaults(aspect);
    surface.light.apply(&mut scene)?;
    for notice in &scene.notices {
        console::notice(notice);
    }
    let start = start(&scene, size, camera)?;
    Ok((scene, start))
}

/// Where a run through a scene starts.
pub fn start(scene: &Scene, size: [u32; 2], camera: &CameraArgs) -> Result<Pose> {
    let aspect = f64::from(size[0]) / f64::from(size[1]);
    let base = scene.camera.unwrap_or_else(|| scene::frame(scene.bounds().unwrap_or_default(), aspect));
    camera::start(camera, scene, &base)
}
