//! Any glTF file, to be looked at from all sides. README.md says what to look at.

use crate::app::sample::{Sample, Source};

/// `prism run viewer --scene FILE`.
pub struct Viewer;

impl Sample for Viewer {
    fn id(&self) -> &'static str {
        "viewer"
    }

    fn summary(&self) -> &'static str {
        "Any glTF file (--scene FILE), turned by hand; Suzanne with a displaced skin without one"
    }

    fn scene(&self) -> Source {
        Source::Chosen { default: "suzanne.gltf" }
    }

    fn moves(&self) -> bool {
        false
    }
}
