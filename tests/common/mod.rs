//! What the tests share: scenes written by hand, the program as a user runs it, and the files that it leaves.
//!
//! Nothing here knows how the engine works: cameras, height maps and the expected pixels are written anew.

// Every test file is a program of its own and uses its own part of this.
#![allow(dead_code, unused_imports)]

pub mod expect;
pub mod forms;
pub mod frame;
pub mod gltf;
pub mod lens;
pub mod losing;
pub mod map;
pub mod program;
pub mod window;

use std::path::{Path, PathBuf};

pub use self::{
    expect::{Expected, check},
    frame::{Frame, Picture},
    gltf::{Gltf, Shape},
    lens::{Lens, Ray},
    map::{Map, Wrap},
    program::{Outcome, draw, prism},
};

/// Both stages that can make a shell, by their names on the command line.
pub const STAGES: [&str; 2] = ["mesh", "geometry"];
/// Every way to draw a shell: shell and stage.
pub const WAYS: [&str; 4] = [
    "--shell prism --stage mesh",
    "--shell prism --stage geometry",
    "--shell walk --stage mesh",
    "--shell walk --stage geometry",
];

/// A scene of the project's assets.
pub fn asset(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets").join(name);
    assert!(path.is_file(), "{} is missing", path.display());
    path
}

/// A folder that is deleted when it goes out of scope.
pub fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

/// Where a failed test leaves pictures for whoever looks into it.
pub fn leftovers() -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("failed");
    std::fs::create_dir_all(&folder).expect("the folder for failed tests' pictures");
    folder
}
