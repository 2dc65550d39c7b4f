//! A driver whose device is lost on request: this machine's own, with another one around it.

use std::{
    env, fs,
    path::{Path, PathBuf},
    process::Command,
};

use serde_json::{Value, json};

use super::{Outcome, program::Call};

/// The driver, in a folder of the caller's.
pub struct Losing {
    manifest: PathBuf,
    real: PathBuf,
}

impl Losing {
    /// Compiles it around the driver that the tests run on.
    pub fn new(folder: &Path) -> Losing {
        let own = PathBuf::from(env::var_os("VK_DRIVER_FILES").expect("tests/run names the driver"));
        let mut manifest: Value = serde_json::from_slice(&fs::read(&own).expect("its manifest")).expect("JSON");
        let named = Path::new(manifest["ICD"]["library_path"].as_str().expect("its library"));
        // A bare name is looked for by the system, another path begins at the manifest.
        let bare = named.parent() == Some(Path::new(""));
        let real = if bare { named.to_owned() } else { own.parent().expect("a folder").join(named) };

        let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/common/losing.c");
        let library = folder.join("liblosing.so");
        let mut compiler = Command::new("cc");
        compiler.args(["-shared", "-fPIC", "-Wall", "-Werror", "-o"]).arg(&library).arg(source).arg("-ldl");
        assert!(compiler.status().expect("a C compiler, which linking needs too").success());
        manifest["ICD"]["library_path"] = json!(library);
        let path = folder.join("losing.json");
        fs::write(&path, manifest.to_string()).expect("a file");
        Losing { manifest: path, real }
    }

    /// A run whose device is lost at the `call`th call of a function.
    pub fn loses(&self, run: Call, function: &str, call: u32) -> Call {
        let run = run.env("VK_DRIVER_FILES", &self.manifest).env("VK_ICD_FILENAMES", &self.manifest);
        let run = run.env("PRISM_TEST_DRIVER", &self.real).env("PRISM_TEST_LOST", function);
        run.env("PRISM_TEST_CALL", call.to_string())
    }
}

/// Insists that a run has told of the loss, once and as a user can read it, and has failed.
#[track_caller]
pub fn tells_of_the_loss(outcome: Outcome, pass: &str) {
    let outcome = outcome.ends(1);
    let told = outcome.stderr.lines().filter(|line| line.starts_with("error: "));
    let told: Vec<&str> = told.collect();
    let part = format!("the device was lost; the last pass recorded for it: {pass}.");
    assert!(told.len() == 1 && told[0].contains(&part), "{part}\n{outcome}");
    assert!(!outcome.stderr.contains("panicked"), "{outcome}");
}
