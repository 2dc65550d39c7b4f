//! Nothing that the program does displeases the validation layer, synchronization included. That its messages are caught at
//! all is shown in the engine's own tests, by a call that is deliberately wrong.

mod common;

use common::{STAGES, asset, draw, folder};

const SCENES: [&str; 9] = ["prism_shell", "torus", "suzanne", "cube", "cloth", "stack", "plane", "terrain", "shadows"];

#[track_caller]
fn quiet(scene: &str, flags: &str) {
    let folder = folder();
    let call = draw("render", asset(&format!("{scene}.gltf"))).words("--size 64x48").words(flags).within(folder.path());
    // An exit code of 0 says that the layer was loaded, too: the program fails without it.
    let outcome = call.succeeds();
    assert!(!outcome.stderr.to_lowercase().contains("validation"), "{outcome}");
}

/// The same of a sample, over several frames.
#[track_caller]
fn runs_quietly(sample: &str, flags: &str) {
    let folder = folder();
    let call = draw("run", sample).words("--headless --size 64x48").words(flags).within(folder.path());
    let outcome = call.succeeds();
    assert!(!outcome.stderr.to_lowercase().contains("validation"), "{outcome}");
}

#[test]
fn every_scene_in_both_stages() {
    for scene in SCENES {
        for stage in STAGES {
            quiet(scene, &format!("--stage {stage} --out a.png --aov a.exr"));
        }
    }
}

#[test]
fn every_march_of_the_base_surface() {
    for march in ["none", "normal", "pom", "relief", "exact"] {
        quiet("suzanne", &format!("--shell off --march {march} --out a.png --aov a.exr"));
    }
    quiet("plane", "--shell off --march relief --silhouette uv-bounds --self-shadow hard --depth-offset on");
    quiet("plane", "--shell off --march pom --depth-offset off");
}

#[test]
fn every_march_of_the_shell() {
    for stage in STAGES {
        for march in ["pom", "relief", "exact"] {
            quiet("torus", &format!("--stage {stage} --march {march} --out a.png --aov a.exr"));
        }
    }
}

#[test]
fn frames_in_a_row_with_queries() {
    for stage in STAGES {
        quiet("cube", &format!("--stage {stage} --frames 4 --stats --csv a.csv"));
    }
}

#[test]
fn frames_of_a_mesh_that_changes_shape() {
    for stage in STAGES {
        for shell in ["walk", "prism"] {
            runs_quietly("cloth", &format!("--stage {stage} --shell {shell} --frames 3 --time-step 0.4 --stats"));
        }
    }
    runs_quietly("cloth", "--shell off --frames 2 --time-step 0.4");
}

#[test]
fn shadow_maps_and_a_depth_pre_pass() {
    for (stage, depths) in STAGES.into_iter().zip(["on", "off"]) {
        let flags = "--frames 2 --time-step 0.4 --shadow-map-size 64 --cascades 2";
        runs_quietly("shadows", &format!("--stage {stage} --depth-prepass {depths} {flags} --stats"));
    }
    quiet("depth_offset", "--shell off --march relief --shadow-map on --depth-prepass on --out a.png --aov a.exr");
}

#[test]
fn without_the_layer_validation_is_refused_by_name() {
    let folder = folder();
    // The loader finds layers nowhere else than here.
    let nowhere = folder.path().join("none");
    std::fs::create_dir(&nowhere).expect("a folder");
    let call = draw("render", asset("cube.gltf")).words("--size 64x48").env("VK_LAYER_PATH", &nowhere);
    let outcome = call.within(folder.path()).run().ends(77);
    outcome.complains(&["VK_LAYER_KHRONOS_validation"]);
}
