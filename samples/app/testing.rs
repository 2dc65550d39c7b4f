//! What several rooms' tests need.

use prism_engine::scene::{Ambient, Scene};

/// A scene with nothing in it.
pub fn empty_scene() -> Scene {
    Scene {
        file: "none".into(),
        meshes: vec![],
        materials: vec![],
        images: vec![],
        height_maps: vec![],
        instances: vec![],
        camera: None,
        lights: vec![],
        ambient: Ambient::default(),
        notices: vec![],
    }
}
