//! What `prism render` draws: a file as it is.

use std::path::PathBuf;

use super::sample::{Sample, Source};

/// A sample in which nothing moves, for a file that the command line names.
pub struct Still(pub PathBuf);

impl Sample for Still {
    fn id(&self) -> &'static str {
        "render"
    }

    fn summary(&self) -> &'static str {
        "A glTF file as it is"
    }

    fn scene(&self) -> Source {
        Source::File(self.0.clone())
    }

    fn moves(&self) -> bool {
        false
    }
}
