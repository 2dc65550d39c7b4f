//! What is wrong with a file or a machine is told in one clear message, and nothing panics.

mod common;

use std::{fs, path::Path};

use common::{Frame, Gltf, Map, Outcome, STAGES, asset, draw, folder, prism};
use serde_json::json;

/// A sheet over a small map.
fn sheet() -> Gltf {
    Gltf::sheet(&Map::noise(4, 4))
}

/// Renders a file that must be refused: exit code 1, and a message with the file's name and these words.
#[track_caller]
fn refused(file: &Path, words: &[&str]) {
    let folder = folder();
    let outcome = draw("render", file).words("--size 32x24").within(folder.path()).run().ends(1);
    let name = file.file_name().expect("a name").to_string_lossy();
    outcome.complains(&[&[name.as_ref()], words].concat());
    assert_eq!(fs::read_dir(folder.path()).expect("the folder").count(), 0, "a failed run leaves no file\n{outcome}");
}

/// The same for a scene written by hand, once as a GLB and once as a text with a file beside it.
#[track_caller]
fn refused_scene(gltf: &Gltf, words: &[&str]) {
    let folder = folder();
    refused(&gltf.write(folder.path()), words);
    refused(&gltf.write_text(folder.path()), words);
}

#[track_caller]
fn drawn(gltf: &Gltf, flags: &str) -> Outcome {
    let folder = folder();
    draw("render", gltf.write(folder.path())).words("--size 32x24").words(flags).within(folder.path()).run()
}

#[test]
fn the_scene_they_are_made_from_is_fine() {
    let outcome = drawn(&sheet(), "").ends(0);
    assert!(!outcome.stderr.contains("error"), "{outcome}");
}

#[test]
fn a_missing_file() {
    refused(Path::new("/nowhere/at all.gltf"), &["/nowhere/", "read"]);
    let folder = folder();
    refused(folder.path(), &["read"]);
}

#[test]
fn json_that_is_no_gltf() {
    let folder = folder();
    for (name, text) in [
        ("empty.gltf", ""),
        ("prose.gltf", "once upon a time"),
        ("cut.gltf", "{ \"asset\": { \"version\": \"2.0\" }, \"nodes\": ["),
        ("list.gltf", "[1, 2, 3]"),
        ("other.gltf", "{ \"name\": \"package\", \"version\": \"1.0.0\" }"),
        ("old.gltf", "{ \"asset\": { \"version\": \"1.0\" } }"),
        ("noise.glb", "glTF and nothing else"),
    ] {
        let path = folder.path().join(name);
        fs::write(&path, text).expect("the file");
        refused(&path, &[]);
    }
}

#[test]
fn a_cut_glb() {
    let folder = folder();
    let path = sheet().write(folder.path());
    let bytes = fs::read(&path).expect("the scene");
    for length in [7, 15, 60, bytes.len() / 2, bytes.len() - 1] {
        fs::write(&path, &bytes[..length]).expect("the cut scene");
        refused(&path, &[]);
    }
}

#[test]
fn a_truncated_png() {
    let png = Map::noise(64, 64).png();
    // In the buffer of the scene.
    let mut gltf = sheet();
    let view = gltf.view(&png[..png.len() / 2]);
    gltf.set("/images/0/bufferView", json!(view));
    refused_scene(&gltf, &["image 0 'steps'"]);
    // In a file of its own: named too.
    let folder = folder();
    fs::write(folder.path().join("half.png"), &png[..png.len() / 2]).expect("the image");
    let mut gltf = sheet();
    gltf.set("/images/0", json!({ "uri": "half.png" }));
    refused(&gltf.write_text(folder.path()), &["image 0", "half.png"]);
    // No image at all.
    fs::write(folder.path().join("half.png"), "not a picture").expect("the image");
    refused(&gltf.write_text(folder.path()), &["image 0", "half.png"]);
}

#[test]
fn a_missing_image_and_a_missing_buffer() {
    let folder = folder();
    let mut gltf = sheet();
    gltf.set("/images/0", json!({ "uri": "gone.png" }));
    refused(&gltf.write_text(folder.path()), &["image 0", "gone.png"]);
    let mut gltf = sheet();
    gltf.set("/buffers", json!([{ "byteLength": 1000, "uri": "gone.bin" }]));
    refused(&gltf.write_text(folder.path()), &["buffer 0", "gone.bin"]);
}

#[test]
fn a_buffer_shorter_than_it_says() {
    let folder = folder();
    let path = sheet().write_text(folder.path());
    fs::write(folder.path().join("scene.bin"), [0; 16]).expect("the buffer");
    refused(&path, &["buffer 0"]);
}

#[test]
fn accessors_out_of_range() {
    let mut gltf = sheet();
    gltf.set("/accessors/0/count", json!(500));
    refused_scene(&gltf, &["accessor 0"]);
    let mut gltf = sheet();
    gltf.set("/accessors/2/bufferView", json!(99));
    refused_scene(&gltf, &["accessor 2"]);
    let mut gltf = sheet();
    gltf.set("/bufferViews/1/byteLength", json!(4_000_000_000u32));
    refused_scene(&gltf, &["buffer view 1"]);
    let mut gltf = sheet();
    gltf.set("/meshes/0/primitives/0/attributes/POSITION", json!(77));
    refused_scene(&gltf, &["Sheet", "77"]);
}

#[test]
fn positions_that_are_no_numbers() {
    for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut gltf = sheet();
        gltf.poke(0, 4, value);
        refused_scene(&gltf, &["accessor 0", "Sheet", "finite"]);
    }
}

#[test]
fn displacement_without_coordinates() {
    let mut gltf = sheet();
    gltf.remove("/meshes/0/primitives/0/attributes/TEXCOORD_0");
    refused_scene(&gltf, &["Sheet", "wall", "TEXCOORD_0"]);
    let mut gltf = sheet();
    gltf.set("/materials/0/extras/displacement/texture/texCoord", json!(1));
    refused_scene(&gltf, &["Sheet", "wall", "TEXCOORD_1"]);
}

#[test]
fn normals_without_length() {
    let mut gltf = sheet();
    for float in 0..3 {
        gltf.poke(1, float, 0.0);
    }
    refused_scene(&gltf, &["accessor 1", "Sheet"]);
}

#[test]
fn an_index_past_the_end() {
    let mut gltf = sheet();
    gltf.poke(3, 5, f32::from_bits(4));
    refused_scene(&gltf, &["accessor 3", "Sheet", "4"]);
    // The restart value of 32-bit indices is no vertex either.
    let mut gltf = sheet();
    gltf.poke(3, 0, f32::from_bits(u32::MAX));
    refused_scene(&gltf, &["accessor 3", "Sheet"]);
}

#[test]
fn uris_that_climb_out_of_the_folder() {
    let folder = folder();
    let inner = folder.path().join("inner");
    fs::create_dir(&inner).expect("a folder");
    // They are all there: the refusal is for the path, not for a missing file.
    let png = Map::noise(4, 4).png();
    fs::write(folder.path().join("outside.png"), &png).expect("an image");
    let absolute = folder.path().join("outside.png").to_string_lossy().into_owned();
    let mut ways = vec!["../outside.png", "sub/../../outside.png", "%2e%2e/outside.png", "..%2foutside.png", &absolute];
    let url = format!("file://{absolute}");
    ways.push(&url);
    for uri in ways {
        let mut gltf = sheet();
        gltf.set("/images/0", json!({ "uri": uri }));
        refused(&gltf.write_text(&inner), &["image 0"]);
    }
    let mut gltf = sheet();
    gltf.set("/buffers", json!([{ "byteLength": 8, "uri": "../outside.png" }]));
    refused(&gltf.write_text(&inner), &["buffer 0", "../outside.png"]);
}

#[cfg(unix)]
#[test]
fn a_link_that_leads_out_of_the_folder() {
    let folder = folder();
    let inner = folder.path().join("inner");
    fs::create_dir(&inner).expect("a folder");
    fs::write(folder.path().join("outside.png"), Map::noise(4, 4).png()).expect("an image");
    std::os::unix::fs::symlink("../outside.png", inner.join("inside.png")).expect("a link");
    let mut gltf = sheet();
    gltf.set("/images/0", json!({ "uri": "inside.png" }));
    refused(&gltf.write_text(&inner), &["image 0", "inside.png"]);
}

#[test]
fn displacements_that_make_no_sense() {
    for (key, value) in [
        ("scale", json!(-0.1)),
        ("scale", json!("tall")),
        ("midlevel", json!("middle")),
        ("border", json!("fence")),
        ("texture", json!({ "index": 9 })),
        ("relative", json!("yes")),
    ] {
        let mut gltf = sheet();
        gltf.set(&format!("/materials/0/extras/displacement/{key}"), value);
        refused_scene(&gltf, &["material 0 'wall'", key]);
    }
}

#[test]
fn a_map_of_one_pixel_works() {
    for bits in [Map::eight(1, &[200]), Map::sixteen(1, &[40_000])] {
        for stage in STAGES {
            let folder = folder();
            let scene = Gltf::sheet(&bits).write(folder.path());
            let frame = folder.path().join("frame.exr");
            let call = draw("render", &scene).words(&format!("--size 32x24 --stage {stage} --aov")).arg(&frame);
            call.within(folder.path()).succeeds();
            let hits = Frame::read(&frame).aov().depth.iter().filter(|depth| depth.is_finite()).count();
            assert!(hits > 100, "{stage}: {hits} pixels");
        }
    }
}

#[test]
fn a_map_above_the_device_s_limit() {
    let limited = |width: u32| {
        let folder = folder();
        let scene = Gltf::sheet(&Map::noise(width, 2)).write(folder.path());
        let call = draw("render", scene).words("--size 32x24").env("PRISM_MASK_LIMITS", "maxImageDimension2D=256");
        call.within(folder.path()).run()
    };
    limited(256).ends(0);
    let outcome = limited(257);
    // A device with more could do it: not the file's fault.
    assert!([1, 77].contains(&outcome.code), "{outcome}");
    let code = outcome.code;
    outcome.ends(code).complains(&["steps", "257", "256"]);
}

#[test]
fn unknown_extensions() {
    let mut gltf = sheet();
    gltf.set("/extensionsUsed", json!(["KHR_draco_mesh_compression"]));
    gltf.set("/extensionsRequired", json!(["KHR_draco_mesh_compression"]));
    refused_scene(&gltf, &["extensionsRequired", "KHR_draco_mesh_compression"]);
    gltf.remove("/extensionsRequired");
    drawn(&gltf, "").ends(0).notices(&["KHR_draco_mesh_compression"]);
}

#[test]
fn what_is_ignored_is_told() {
    let mut gltf = sheet();
    gltf.set("/materials/0/alphaMode", json!("BLEND"));
    gltf.set("/animations", json!([{ "channels": [], "samplers": [] }]));
    gltf.set("/skins", json!([{ "joints": [0] }]));
    let outcome = drawn(&gltf, "").ends(0);
    outcome.notices(&["wall", "BLEND"]);
    outcome.notices(&["animations"]);
    outcome.notices(&["skins"]);
}

#[test]
fn a_scene_without_camera_and_light_is_framed_and_lit() {
    let mut gltf = sheet();
    gltf.set("/scenes/0/nodes", json!([0]));
    let outcome = drawn(&gltf, "").ends(0);
    outcome.notices(&["camera"]);
    outcome.notices(&["light"]);
}

#[test]
fn no_vulkan_device() {
    for line in ["run prism_shell --headless --validation off", "devices"] {
        let folder = folder();
        let call = prism(line).env("VK_DRIVER_FILES", "/nonexistent.json").env("VK_ICD_FILENAMES", "/nonexistent.json");
        call.within(folder.path()).run().ends(77).complains(&["Vulkan"]);
    }
}

#[test]
fn a_device_without_the_asked_stage() {
    let scene = asset("cube.gltf");
    let run = |stage: &str, masked: &str| {
        let folder = folder();
        let call = draw("render", &scene).words(&format!("--size 32x24 --stats --stage {stage}"));
        call.env("PRISM_MASK_FEATURES", masked).within(folder.path()).run()
    };
    for stage in STAGES {
        run(stage, stage).ends(77).complains(&[stage]);
    }
    run("auto", "mesh,geometry").ends(77).complains(&["mesh", "geometry"]);
    // The other stage serves where the choice is free.
    let outcome = run("auto", "mesh").ends(0);
    assert!(outcome.stdout.contains("Geometry") && !outcome.stdout.contains("MeshEXT"), "{outcome}");
    let outcome = run("auto", "geometry").ends(0);
    assert!(outcome.stdout.contains("MeshEXT") && !outcome.stdout.contains("Geometry"), "{outcome}");
    // Classic parallax needs neither.
    let folder = folder();
    let call = draw("render", &scene).words("--size 32x24 --shell off").env("PRISM_MASK_FEATURES", "mesh,geometry");
    call.within(folder.path()).succeeds();
}

#[test]
fn a_device_without_what_a_baseline_needs() {
    let run = |baseline: &str, masked: &str| {
        let folder = folder();
        let call = draw("render", asset("cube.gltf")).words(&format!("--size 32x24 --baseline {baseline}"));
        call.env("PRISM_MASK_FEATURES", masked).within(folder.path()).run()
    };
    for (baseline, feature) in [("tessellation:4", "tessellation"), ("mesh-tessellation:4", "task")] {
        run(baseline, feature).ends(77).complains(&[feature]);
    }
    run("micro-mesh:4", "tessellation,mesh,geometry").ends(0);
}

#[test]
fn a_picture_above_the_device_s_limit() {
    let folder = folder();
    let call =
        draw("render", asset("cube.gltf")).words("--size 300x20").env("PRISM_MASK_LIMITS", "maxImageDimension2D=256");
    call.within(folder.path()).run().ends(77).complains(&["300", "256"]);
}

#[test]
fn a_gpu_that_is_not_there() {
    for gpu in ["99", "no such card"] {
        let folder = folder();
        let call = draw("render", asset("cube.gltf")).words("--size 32x24 --gpu").arg(gpu);
        call.within(folder.path()).run().ends(77).complains(&[gpu]);
    }
}
