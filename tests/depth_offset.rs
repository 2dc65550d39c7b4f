//! The depth offset of plain surfaces: it moves the depth buffer, not what is shaded.

mod common;

use common::{Frame, Gltf, Lens, Shape, draw, folder};
use serde_json::{Value, json};

/// Two sheets, the nearer with these extras, 0.2 before the other.
fn sheets(extras: Value) -> Gltf {
    let mut gltf = Gltf::new();
    for (name, height) in [("near", 0.2), ("far", 0.0)] {
        let material = gltf.plain(name);
        let mesh = gltf.mesh(name, &Shape::sheet(1.0, [0.0; 2], [1.0; 2]), material);
        gltf.node(json!({ "mesh": mesh, "translation": [0.0, 0.0, height] }));
    }
    gltf.set("/materials/0/extras", extras);
    gltf.camera(&Lens::at([0.0, 0.0, 3.0], [0.0; 3]).orthographic(0.8));
    gltf
}

/// Share of the pixels that show the farther sheet.
fn far_shows(extras: Value, flags: &str) -> f64 {
    let folder = folder();
    let scene = sheets(extras).write(folder.path());
    let flags = format!("--size 64x64 {flags} --aov frame.exr");
    draw("render", &scene).words(&flags).within(folder.path()).succeeds();
    let aov = Frame::read(&folder.path().join("frame.exr")).aov();
    let far = aov.position.iter().filter(|position| {
        assert!(
            position[2].abs() < 1e-5 || (position[2] - 0.2).abs() < 1e-5,
            "what is shaded is not moved: {position:?}"
        );
        position[2] < 0.1
    });
    far.count() as f64 / aov.depth.len() as f64
}

#[test]
fn the_depth_moves_by_the_distance_and_a_dithered_one_by_parts_of_it() {
    let offset = |distance: f64, dither: bool| json!({ "depthOffset": { "distance": distance, "dither": dither } });
    assert_eq!(far_shows(json!({}), ""), 0.0);
    assert_eq!(far_shows(offset(0.19, false), ""), 0.0);
    assert_eq!(far_shows(offset(0.21, false), ""), 1.0);
    assert_eq!(far_shows(offset(0.21, false), "--shell off --depth-offset off"), 0.0);
    // 64 × 64 pixels see each value of the noise equally often: a part of 0.2 / 0.8 stays before the other sheet.
    let share = far_shows(offset(0.8, true), "");
    println!("dithered: the farther sheet shows on {share} of the pixels");
    assert!((share - 0.75).abs() < 0.005, "{share}");
}

#[test]
fn wrong_extras_are_told() {
    for (extras, word) in [
        (json!({ "depthOffset": 0.5 }), "depthOffset"),
        (json!({ "depthOffset": {} }), "distance"),
        (json!({ "depthOffset": { "distance": -1.0 } }), "distance"),
        (
            json!({ "depthOffset": { "distance": 1.0 }, "displacement": { "procedural": "waves", "scale": 0.1 } }),
            "both",
        ),
    ] {
        let folder = folder();
        let scene = sheets(extras).write(folder.path());
        draw("render", &scene).within(folder.path()).run().ends(1).complains(&["near", word]);
    }
}
