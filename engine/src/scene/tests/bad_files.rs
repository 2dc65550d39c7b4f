//! Files, containers, JSON, URIs, buffers, nodes, cameras and lights that must be refused by name.

use std::path::Path;

use serde_json::json;

use super::{
    super::{import::from_bytes, load},
    Folder, Gltf, assert_fails, data_uri,
};

#[track_caller]
fn text_fails(text: &str, object: &str, problem: &str) {
    assert_fails(from_bytes(Path::new("test.gltf"), text.as_bytes()), object, problem);
}

#[test]
fn a_missing_file_and_a_folder() {
    assert_fails(load(Path::new("/nowhere/scene.gltf")), "scene file", "cannot be read");
    assert_fails(load(Path::new("/")), "scene file", "cannot be read");
}

#[test]
fn json_that_is_none() {
    text_fails("", "JSON", "ends too early");
    text_fails("{\"asset\": {", "JSON", "ends too early");
    text_fails("nonsense", "JSON", "is not valid JSON");
    text_fails("{\"a\": 1e999}", "JSON", "number out of range");
    text_fails(&"[".repeat(100_000), "JSON", "recursion limit");
}

#[test]
fn json_that_is_no_gltf() {
    text_fails("[1, 2]", "JSON", "no object");
    text_fails("{}", "JSON", "has no 'asset'");
    text_fails("{\"asset\": 3}", "asset", "has no 'version'");
    text_fails("{\"asset\": {\"version\": \"1.0\"}}", "asset", "glTF 1.0");
    text_fails("{\"asset\": {\"version\": \"2.1\", \"minVersion\": \"2.1\"}}", "asset", "glTF 2.1");
    text_fails("{\"asset\": {\"version\": \"2.0\"}, \"nodes\": 3}", "nodes", "is no list");
    text_fails("{\"asset\": {\"version\": \"2.0\"}, \"scene\": -1}", "scene", "is no index");
}

#[test]
fn objects_of_the_wrong_shape_are_named() {
    let mut gltf = Gltf::plain();
    gltf.set("/nodes/0/translation", json!([1, 2])).fails("node 0 'tile'", "cannot be understood");
    Gltf::plain().remove("/accessors/2/count").fails("accessor 2", "missing field `count`");
    Gltf::plain().set("/meshes/0/primitives", json!("all")).fails("mesh 0 'Quad'", "cannot be understood");
}

#[test]
fn containers_cut_short_or_damaged() {
    let glb = Gltf::plain().glb();
    let file = Path::new("test.glb");
    let fails = |bytes: &[u8], problem: &str| assert_fails(from_bytes(file, bytes), "GLB container", problem);
    assert!(from_bytes(file, &glb).is_ok());
    fails(&glb[..10], "ends within its header");
    fails(&glb[..glb.len() - 1], "its header says");
    fails(b"{}", "does not start with 'glTF'");
    let with = |offset: usize, value: u32| {
        let mut bytes = glb.clone();
        bytes[offset..offset + 4].copy_from_slice(&value.to_le_bytes());
        bytes
    };
    fails(&with(4, 1), "container version 1");
    fails(&with(8, 4), "its header says 4");
    fails(&with(12, u32::MAX), "ends within chunk 0");
    fails(&with(16, 7), "has no JSON");
    fails(&with(8, 15)[..15], "ends within the header of chunk 0");
}

#[test]
fn extensions() {
    Gltf::plain()
        .set("/extensionsRequired", json!(["KHR_lights_punctual", "KHR_draco_mesh_compression"]))
        .fails("extensionsRequired", "'KHR_draco_mesh_compression', which is not supported");
    Gltf::plain().set("/extensionsRequired", json!("all")).fails("extensionsRequired", "no list of names");
    Gltf::plain().set("/extensionsUsed", json!([3])).fails("extensionsUsed", "no list of names");
}

#[test]
fn uris_that_leave_the_folder() {
    let folder = Folder::new();
    folder.write("outside.bin", &[0; 256]);
    let mut gltf = Gltf::plain();
    gltf.set("/buffers/0/byteLength", json!(120));
    for uri in ["../outside.bin", "maps/../../outside.bin", "%2e%2e/outside.bin", "/etc/passwd", "..\\outside.bin"] {
        gltf.set("/buffers/0/uri", json!(uri));
        let path = folder.write("scene/scene.gltf", &gltf.text());
        assert_fails(load(&path), "buffer 0", "leaves the scene's folder");
    }
    for uri in ["file:///etc/passwd", "http://example.org/a.bin", "C:\\a.bin"] {
        gltf.set("/buffers/0/uri", json!(uri));
        let path = folder.write("scene/scene.gltf", &gltf.text());
        assert_fails(load(&path), "buffer 0", "is no relative path");
    }
}

#[cfg(unix)]
#[test]
fn links_that_leave_the_folder() {
    let folder = Folder::new();
    let outside = folder.write("outside.bin", &[0; 256]);
    std::os::unix::fs::symlink(&outside, folder.0.join("scene/inside.bin")).expect("a link");
    let mut gltf = Gltf::plain();
    gltf.set("/buffers/0/byteLength", json!(120)).set("/buffers/0/uri", json!("inside.bin"));
    let path = folder.write("scene/scene.gltf", &gltf.text());
    assert_fails(load(&path), "buffer 0", "leaves the scene's folder");
}

#[test]
fn buffers_that_are_missing_or_short() {
    let folder = Folder::new();
    let mut gltf = Gltf::plain();
    gltf.set("/buffers/0/byteLength", json!(1000)).fails("buffer 0", "its byteLength is 1000");
    gltf.set("/buffers/0/uri", json!("data:;base64,AAAA")).fails("buffer 0", "has 3 bytes");
    gltf.set("/buffers/0/uri", json!("data:;base64,A")).fails("buffer 0", "no base64");
    gltf.set("/buffers/0/uri", json!("data:text/plain,A")).fails("buffer 0", "is not base64");
    gltf.set("/buffers/0/uri", json!("maps"));
    assert_fails(load(&folder.write("scene/scene.gltf", &gltf.text())), "buffer 0", "is no regular file");
    gltf.set("/buffers/0/uri", json!("gone.bin"));
    assert_fails(load(&folder.write("scene/scene.gltf", &gltf.text())), "buffer 0", "'gone.bin' cannot be read");
    gltf.set("/buffers/0/uri", json!(null)).fails("buffer 0", "has no uri");
}

#[test]
fn views_out_of_their_buffer() {
    for (key, value) in [("byteLength", 4000_u64), ("byteLength", u64::MAX), ("byteOffset", u64::MAX)] {
        Gltf::plain().set(&format!("/bufferViews/0/{key}"), json!(value)).fails("buffer view 0", "but buffer 0 has");
    }
    Gltf::plain().set("/bufferViews/0/buffer", json!(7)).fails("buffer view 0", "refers to buffer 7");
}

#[test]
fn graphs_that_are_no_trees() {
    let mut gltf = Gltf::plain();
    gltf.set("/nodes", json!([{ "children": [1] }, { "children": [2] }, { "children": [1] }]));
    gltf.fails("node 1", "is a child of node 0 and of node 2");
    gltf.set("/nodes", json!([{}, { "name": "a", "children": [2] }, { "children": [1] }]));
    gltf.fails("node 1 'a'", "cycle");
    gltf.set("/nodes", json!([{ "children": [0] }])).fails("node 0", "cycle");
    gltf.set("/nodes", json!([{ "children": [5] }])).fails("node 0", "refers to node 5");
    gltf.set("/nodes", json!([{}])).set("/scenes/0/nodes", json!([0, 0])).fails("node 0", "occurs twice");
    gltf.set("/scenes/0/nodes", json!([9])).fails("scene 0", "refers to node 9");
    gltf.set("/scene", json!(4)).fails("scene", "refers to scene 4");
    Gltf::plain().set("/nodes/0/mesh", json!(1)).fails("node 0 'tile'", "refers to mesh 1");
}

#[test]
fn transforms_that_are_none() {
    let fails = |key: &str, value, problem: &str| {
        Gltf::plain().set(&format!("/nodes/0/{key}"), value).fails("node 0 'tile'", problem);
    };
    fails("scale", json!([1, 0, 1]), "singular");
    fails("scale", json!([1, 1e39, 1]), "not finite");
    fails("translation", json!([1e39, 0, 0]), "not finite");
    fails("rotation", json!([0, 0, 0, 0]), "no unit quaternion");
    fails("rotation", json!([0, 0, 0, 1e39]), "no unit quaternion");
    fails("matrix", json!([1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]), "singular");
    fails("matrix", json!([1e39, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]), "matrix is not finite");
    fails("matrix", json!([1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]), "not affine");
}

#[test]
fn cameras_that_are_none() {
    let fails = |camera, problem: &str| {
        Gltf::plain().set("/cameras", json!([camera])).set("/nodes/0/camera", json!(0)).fails("camera 0", problem);
    };
    fails(json!({ "type": "fisheye" }), "its type is neither");
    fails(json!({ "type": "perspective" }), "no lens");
    fails(json!({ "type": "perspective", "perspective": { "yfov": 0, "znear": 1 } }), "yfov");
    fails(json!({ "type": "perspective", "perspective": { "yfov": 1, "znear": 0 } }), "znear");
    fails(json!({ "type": "perspective", "perspective": { "yfov": 1, "znear": 2, "zfar": 2 } }), "zfar");
    let orthographic = |ymag: f32, znear: f32| json!({ "type": "orthographic", "orthographic": { "xmag": 1, "ymag": ymag, "znear": znear, "zfar": 2 } });
    fails(orthographic(0.0, 1.0), "ymag");
    fails(orthographic(1.0, 2.0), "zfar");
    Gltf::plain().set("/nodes/0/camera", json!(0)).fails("node 0 'tile'", "refers to camera 0");
    let lens = json!({ "type": "perspective", "perspective": { "yfov": 1, "znear": 1 } });
    Gltf::plain()
        .set("/cameras", json!([lens]))
        .set("/nodes/0", json!({ "camera": 0, "scale": [1, 0, 1] }))
        .fails("node 0", "its camera has no direction");
}

#[test]
fn lights_that_are_none() {
    let with = |light| {
        let mut gltf = Gltf::plain();
        gltf.set("/extensions", json!({ "KHR_lights_punctual": { "lights": [light] } }))
            .set("/nodes/0/extensions", json!({ "KHR_lights_punctual": { "light": 0 } }));
        gltf
    };
    with(json!({ "type": "area" })).fails("light 0", "its type is none");
    with(json!({ "type": "spot", "name": "lamp" })).fails("light 0 'lamp'", "a spot without");
    with(json!({ "type": "spot", "spot": { "innerConeAngle": 1 } })).fails("light 0", "cone angles");
    with(json!({ "type": "point", "range": 0 })).fails("light 0", "range");
    with(json!({ "type": "point", "intensity": -1 })).fails("light 0", "negative");
    with(json!({ "type": "point", "color": [1e39, 1, 1] })).fails("light 0", "not finite");
    with(json!({ "type": 3 })).fails("light 0", "cannot be understood");
    let mut gltf = with(json!({ "type": "point" }));
    gltf.set("/nodes/0/extensions/KHR_lights_punctual/light", json!(1)).fails("node 0 'tile'", "refers to light 1");
    let mut gltf = with(json!({ "type": "directional" }));
    gltf.remove("/nodes/0/mesh").set("/nodes/0/scale", json!([0, 0, 0])).fails("node 0", "no direction");
}

#[test]
fn embedded_data_is_not_mistaken_for_a_path() {
    let mut gltf = Gltf::plain();
    let uri = data_uri(&gltf.bytes);
    gltf.set("/buffers/0/uri", json!(uri)).loads();
}

#[test]
fn image_based_lights() {
    let with = |light: serde_json::Value, index: u32| {
        let mut gltf = Gltf::quad();
        gltf.set("/extensions", json!({ "EXT_lights_image_based": { "lights": [light] } }));
        gltf.set("/scenes/0/extensions", json!({ "EXT_lights_image_based": { "light": index } }));
        from_bytes(Path::new("test.gltf"), &gltf.text())
    };
    let flat = || vec![json!([0, 0, 0]); 9];
    let good = json!({ "irradianceCoefficients": flat() });
    assert!(with(good.clone(), 0).is_ok());
    assert_fails(with(good, 7), "scene", "refers to image-based light 7");
    assert_fails(with(json!({}), 0), "image-based light 0", "irradianceCoefficients");
    let short = json!({ "irradianceCoefficients": [[0, 0, 0]] });
    assert_fails(with(short, 0), "image-based light 0", "nine lists of three numbers");
    let turned = json!({ "irradianceCoefficients": flat(), "rotation": [0, 0, 0, 0] });
    assert_fails(with(turned, 0), "image-based light 0", "no unit quaternion");
    let bright = json!({ "irradianceCoefficients": flat(), "intensity": "very" });
    assert_fails(with(bright, 0), "image-based light 0", "its intensity is not a number");
}
