//! The geometry stage and the mesh stage make the same picture, and each is what really ran.

mod common;

use common::{Frame, Picture, STAGES, asset, draw, folder};
use prism_engine::aov::Aov;

/// Depth, relative. The two stages reach the rasterizer with other outlines; the tracer's arithmetic is the same.
const DEPTH: f32 = 1e-6;
/// Of a channel of the picture.
const COLOUR: u8 = 2;

struct Drawn {
    aov: Aov,
    picture: Picture,
    /// Execution models of each pipeline that draws the shell, out of its SPIR-V.
    shells: Vec<String>,
}

fn drawn(scene: &str, shell: &str, stage: &str, flags: &str) -> Drawn {
    let folder = folder();
    let output = "--stats --out frame.png --aov frame.exr";
    let flags = format!("--size 160x120 --shell {shell} --stage {stage} {flags} {output}");
    let outcome = draw("render", asset(scene)).words(&flags).within(folder.path()).succeeds();
    let shell = |line: &str| line.strip_prefix("pipeline shell")?.split_once(": ").map(|(_, models)| models.to_owned());
    Drawn {
        aov: Frame::read(&folder.path().join("frame.exr")).aov(),
        picture: Picture::read(&folder.path().join("frame.png")),
        shells: outcome.stdout.lines().filter_map(shell).collect(),
    }
}

#[track_caller]
fn agree(scene: &str) {
    for shell in ["prism", "walk"] {
        agree_with(scene, shell, "");
    }
}

#[track_caller]
fn agree_with(scene: &str, shell: &str, flags: &str) {
    let [mesh, geometry] = STAGES.map(|stage| drawn(scene, shell, stage, flags));
    for (drawn, models) in [(&mesh, "MeshEXT+Fragment"), (&geometry, "Vertex+Geometry+Fragment")] {
        // A walk's lids have a pipeline of their own, beside that of its borders.
        let least = if shell == "walk" { 2 } else { 1 };
        assert!(drawn.shells.len() >= least, "{scene}, {shell}: pipelines {:?}", drawn.shells);
        assert!(drawn.shells.iter().all(|bound| bound == models), "{scene}: {:?} instead of {models}", drawn.shells);
    }
    let covered = mesh.aov.depth.iter().filter(|z| z.is_finite()).count();
    assert!(covered > 2000, "{scene}: only {covered} pixels are covered");
    let mut coverage = 0;
    let mut worst = 0f32;
    for (a, b) in mesh.aov.depth.iter().zip(&geometry.aov.depth) {
        if a.is_finite() != b.is_finite() {
            coverage += 1;
        } else if a.is_finite() {
            worst = worst.max((a - b).abs() / a);
        }
    }
    let colour = mesh.picture.differences(&geometry.picture).into_iter().max().unwrap_or(0);
    println!(
        "{scene}, {shell}: {covered} pixels; coverage differs at {coverage}, depth by {worst:.1e}, colour by {colour}/255"
    );
    assert_eq!(coverage, 0, "{scene}, {shell}: pixels that only one stage covers");
    assert!(worst <= DEPTH, "{scene}, {shell}: depth differs by {worst:e}");
    assert!(colour <= COLOUR, "{scene}, {shell}: colour differs by {colour}/255");
}

#[test]
fn on_the_torus() {
    agree("torus.gltf");
}

#[test]
fn on_suzanne() {
    agree("suzanne.gltf");
}

#[test]
fn on_the_cube() {
    agree("cube.gltf");
}

#[test]
fn on_the_sample() {
    agree("prism_shell.gltf");
}

#[test]
fn through_shadow_maps() {
    agree_with("shadows.gltf", "walk", "--shadow-map on --shadow-map-size 256 --cascades 1");
}

#[test]
fn without_a_shell_neither_stage_is_bound() {
    let folder = folder();
    let call = draw("render", asset("torus.gltf")).words("--size 64x48 --shell off --stats").within(folder.path());
    let outcome = call.succeeds();
    assert!(!outcome.stdout.contains("pipeline shell"), "{outcome}");
    assert!(!outcome.stdout.contains("MeshEXT") && !outcome.stdout.contains("Geometry+"), "{outcome}");
    // Nor are they asked of the device.
    let features =
        outcome.stdout.lines().find(|line| line.starts_with("features: ")).unwrap_or_else(|| panic!("{outcome}"));
    assert!(!features.contains("mesh") && !features.contains("geometry"), "{features}");
}

#[test]
fn each_stage_asks_the_device_for_itself_only() {
    let pairs = [("mesh", "geometry"), ("geometry", "mesh"), ("auto", "geometry")];
    for (shell, (stage, other)) in ["prism", "walk"].into_iter().flat_map(|shell| pairs.map(|pair| (shell, pair))) {
        let folder = folder();
        let flags = format!("--size 64x48 --shell {shell} --stage {stage} --stats");
        let outcome = draw("render", asset("cube.gltf")).words(&flags).within(folder.path()).succeeds();
        let features =
            outcome.stdout.lines().find(|line| line.starts_with("features: ")).unwrap_or_else(|| panic!("{outcome}"));
        let own = if stage == "auto" { "mesh" } else { stage };
        assert!(features.contains(own) && !features.contains(other), "--shell {shell} --stage {stage}: {features}");
    }
}
