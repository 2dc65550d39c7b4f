//! What a sample is. One trait serves the window, the headless run, the report and the tests.

use std::{
    path::{Path, PathBuf},
    sync::atomic::AtomicUsize,
};

use glam::{DAffine3, DQuat, DVec3, Vec3};
use prism_engine::{
    aov::Aov,
    error::{Error, Result},
    scene::{Camera, Light, Scene},
    settings::{Settings, Validation},
};

use super::picture::Picture;

/// A sample: what is shown, and how it moves. Everything else is the application's.
///
/// It keeps no state: a frame follows from its time alone, so that any frame can be asked for in any order.
pub trait Sample: Sync {
    /// Its name on the command line and of its folder.
    fn id(&self) -> &'static str;

    /// One line for `prism list`.
    fn summary(&self) -> &'static str;

    /// Where its scene comes from.
    fn scene(&self) -> Source;

    /// How it is drawn unless the command line says otherwise.
    fn settings(&self) -> Settings {
        Settings::default()
    }

    /// Whether [`Sample::at`] depends on the time. Where not, a window draws only when something else changes.
    fn moves(&self) -> bool {
        true
    }

    /// The picture at `time` seconds, which starts as `start` at time 0. By default nothing moves.
    fn at(&self, _scene: &Scene, start: &Pose, _time: f64) -> Moment {
        Moment::still(*start)
    }

    /// The sample with its wall at this angle between the view and its normal, in degrees, where it has one to tilt.
    fn tilted(&self, _degrees: f64) -> Option<&'static dyn Sample> {
        None
    }

    /// How the sample draws its picture by itself, on a device of its own. By default the application draws.
    fn embedding(&self) -> Option<fn(&Embedding<'_>) -> Result<Picture>> {
        None
    }

    /// What a frame is made into before it is shown. By default it is shown as it is.
    fn exhibit(&self) -> Option<&'static dyn Exhibit> {
        None
    }
}

/// What a sample that draws by itself is to draw.
pub struct Embedding<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Where from.
    pub camera: &'a Camera,
    /// How.
    pub settings: &'a Settings,
    /// Pixels of the picture.
    pub size: [u32; 2],
    /// What the validation layer checks.
    pub validation: Validation,
    /// Where shaders are read from, if not from the program.
    pub shader_dir: Option<&'a Path>,
}

/// A picture made of a frame and its surface data, such as a comparison, and what it says in figures.
pub trait Exhibit: Sync {
    /// Pixels of the frame that goes into a picture of `size`.
    ///
    /// # Errors
    /// `Usage` where `size` leaves no room for it.
    fn frame_size(&self, size: [u32; 2]) -> Result<[u32; 2]>;

    /// Settings of further frames that go into the picture. By default there are none.
    fn variants(&self, _settings: &Settings) -> Vec<Settings> {
        Vec::new()
    }

    /// Where the further frame `index` is seen from, while the frame itself is seen from `pose`. By default from there too.
    fn seen_from(&self, _index: usize, pose: &Pose) -> Pose {
        *pose
    }

    /// The picture of `size`, and its figures: a line for stdout.
    fn compose(&self, shot: &Shot<'_>, size: [u32; 2]) -> (Picture, String);
}

/// One frame, drawn.
pub struct Shot<'a> {
    /// The scene's name: that of its file without the extension.
    pub name: &'a str,
    /// As it was loaded; nothing in it has moved, unless the view is of the error, of which this is the truth.
    pub scene: &'a Scene,
    /// Where from.
    pub camera: &'a Camera,
    /// What was drawn.
    pub frame: &'a Picture,
    /// Its surface data, pixel by pixel.
    pub aov: &'a Aov,
    /// The frames of [`Exhibit::variants`], in their order.
    pub variants: &'a [Drawn],
    /// Counts the pixels of the reference that are done, for whoever waits for the picture.
    pub done: &'a AtomicUsize,
}

/// A frame and its surface data.
pub struct Drawn {
    /// Where from.
    pub camera: Camera,
    /// What was drawn.
    pub frame: Picture,
    /// Pixel by pixel.
    pub aov: Aov,
}

/// Where a sample's scene comes from.
pub enum Source {
    /// A file below the assets' folder.
    Asset(&'static str),
    /// The file that `--scene` names, or else a file below the assets' folder.
    Chosen {
        /// What is shown without `--scene`.
        default: &'static str,
    },
    /// Files below the assets' folder, one after the other: without a window each frame shows the next one. The walk
    /// begins where `--scene` says, by a file's name without its extension or by its number, from 1.
    Walk(&'static [&'static str]),
    /// This file.
    File(PathBuf),
}

/// A camera and the point it is about: what an orbit turns around.
#[derive(Clone, Copy, Debug)]
pub struct Pose {
    /// The camera.
    pub camera: Camera,
    /// The point it looks at, world units.
    pub pivot: DVec3,
}

impl Pose {
    /// Turns the camera around the vertical line through the pivot, counter-clockwise seen from above.
    pub fn orbited(&self, angle: f64) -> Pose {
        let turn = DAffine3::from_quat(DQuat::from_rotation_y(angle));
        let around = DAffine3::from_translation(self.pivot) * turn * DAffine3::from_translation(-self.pivot);
        Pose { camera: Camera { transform: around * self.camera.transform, ..self.camera }, ..*self }
    }
}

/// What is in the picture at one time.
#[derive(Clone, Debug)]
pub struct Moment {
    /// Where from.
    pub pose: Pose,
    /// Instances (indices into `Scene::instances`) that have moved, and where to.
    pub transforms: Vec<(usize, DAffine3)>,
    /// Lights (indices into `Scene::lights`) that have changed, but not their kind.
    pub lights: Vec<(usize, Light)>,
    /// Meshes (indices into `Scene::meshes`) that change shape, and the positions of all vertices of their primitives.
    /// At every time the same meshes.
    pub poses: Vec<(usize, Vec<Vec3>)>,
}

impl Moment {
    /// Nothing but the camera has moved.
    pub fn still(pose: Pose) -> Moment {
        Moment { pose, transforms: Vec::new(), lights: Vec::new(), poses: Vec::new() }
    }

    /// The same things, from another place.
    pub fn seen_from(&self, pose: Pose) -> Moment {
        Moment { pose, ..self.clone() }
    }

    /// The scene as it stands then, for those who trace it on the CPU.
    ///
    /// # Errors
    /// `Usage` where a mesh has changed shape: that is known on the GPU only.
    pub fn placed(&self, scene: &Scene) -> Result<Scene> {
        if !self.poses.is_empty() {
            return Err(Error::Usage(
                "the mesh changes shape on the GPU, and the reference knows it at rest only: no --view error, no probe"
                    .into(),
            ));
        }
        let mut scene = scene.clone();
        for &(instance, transform) in &self.transforms {
            scene.instances[instance].transform = transform;
        }
        Ok(scene)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use prism_engine::scene::Projection;

    #[test]
    fn an_orbit_keeps_distance_and_height() {
        let camera = Camera {
            transform: DAffine3::from_translation(DVec3::new(1.0, 2.0, 5.0)),
            projection: Projection::Perspective { fov_y: 1.0, near: 0.1, far: None },
        };
        let pose = Pose { camera, pivot: DVec3::new(1.0, 0.0, 0.0) };
        let quarter = pose.orbited(std::f64::consts::FRAC_PI_2).camera.transform;
        assert!(quarter.translation.abs_diff_eq(DVec3::new(6.0, 2.0, 0.0), 1e-12), "{quarter:?}");
        // It still looks at the pivot's axis.
        assert!((quarter.matrix3 * DVec3::NEG_Z).abs_diff_eq(DVec3::NEG_X, 1e-12));
        let back = pose.orbited(0.0).camera.transform;
        assert!(back.translation.abs_diff_eq(camera.transform.translation, 0.0));
    }
}
