//! `prism probe`: its marches are those that the GPU draws, and what cannot be probed is told.

mod common;

use std::fs;

use common::{Frame, Gltf, Shape, asset, draw, folder, prism};
use prism_engine::{
    measure::footprint,
    scene,
    settings::{March, Settings},
    shell::{follow::Marches, reference::Reference},
};
use serde_json::Value;

const SIZE: [u32; 2] = [64, 36];

/// Draws a march and follows it on the CPU through every pixel; returns each one's distance between the two in pixel
/// footprints, infinite where one of them hit something and the other did not.
fn against_the_gpu(name: &str, way: &str, settings: &Settings, flags: &str) -> Vec<f64> {
    let folder = folder();
    let words =
        format!("--size {}x{} {way} --march {} {flags} --stats --aov frame.exr", SIZE[0], SIZE[1], settings.march);
    let outcome = draw("render", asset(name)).words(&words).within(folder.path()).succeeds();
    let stage = if way.contains("mesh") { "MeshEXT" } else { "Geometry" };
    let shells = outcome.stdout.lines().filter(|line| line.starts_with("pipeline shell"));
    assert!(shells.clone().count() > 0 && shells.into_iter().all(|line| line.contains(stage)), "{outcome}");
    let drawn = Frame::read(&folder.path().join("frame.exr")).aov();

    let scene = scene::load(&asset(name)).expect("a scene");
    let camera = scene.camera.expect("a camera");
    let reference = Reference::new(&scene);
    let mut marches = Marches::new(&scene);
    let pixels = (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| [x, y]));
    let apart = |([x, y], gpu): ([u32; 2], &f32)| {
        let followed = marches.follow(&reference.way(&camera, SIZE, [x, y]), settings);
        match (followed.distance, gpu.is_finite()) {
            (None, false) => None,
            (Some(cpu), true) => Some((cpu - f64::from(*gpu)).abs() / footprint(&camera, SIZE[1], cpu)),
            _ => Some(f64::INFINITY),
        }
    };
    pixels.zip(&drawn.depth).filter_map(apart).collect()
}

#[test]
fn the_marches_are_those_that_the_gpu_draws() {
    let few = Settings { min_steps: 4, max_steps: 6, refine_steps: 3, ..Settings::default() };
    // So few steps that each march ends visibly elsewhere, and that one sample more or less would be seen.
    let steps = "--min-steps 4 --max-steps 6";
    let (mesh, geometry) = ("--shell walk --stage mesh", "--shell prism --stage geometry");
    for (march, way, flags) in [
        (March::Steep, mesh, steps),
        (March::Secant, geometry, "--min-steps 4 --max-steps 6 --refine-steps 3"),
        (March::Contact, mesh, "--min-steps 4 --max-steps 6 --refine-steps 3"),
        (March::Relief, geometry, "--min-steps 4 --max-steps 6 --refine-steps 3"),
        (March::Cone, geometry, "--max-steps 6"),
        (March::RelaxedCone, mesh, "--max-steps 6 --refine-steps 3"),
    ] {
        let refine_steps = if flags.contains("--refine") { 3 } else { few.refine_steps };
        let settings = Settings { march, refine_steps, ..few.clone() };
        let apart = against_the_gpu("torus.gltf", way, &settings, flags);
        assert!(apart.len() > 500, "{march}: {} pixels", apart.len());
        // A cone map of the GPU rounds ratios down by up to 2e-4 more than the twin, which shows where the steps run out.
        let room = if march.reads_cones() { 0.05 } else { 2e-3 };
        // Where the ray all but touches the field at a sample, f32 may fall on its other side.
        let off = apart.iter().filter(|apart| **apart > room).count();
        println!("{march}, {way}: {off} of {} pixels apart", apart.len());
        assert!(off * 100 <= apart.len(), "{march}, {way}: {off} of {} pixels", apart.len());
    }
}

#[test]
fn a_probe_is_drawn_and_told() {
    let folder = folder();
    let words = "--pixel 30,20 --size 64x36 --max-steps 6 --out probe.svg --json";
    let outcome = prism("probe").arg(asset("torus.gltf")).words(words).within(folder.path()).succeeds();
    let told: Value = serde_json::from_str(&outcome.stdout).expect("JSON");
    let marches = told["marches"].as_array().expect("marches");
    let names: Vec<&str> = marches.iter().filter_map(|march| march["march"].as_str()).collect();
    assert_eq!(names, ["steep", "pom", "relief", "secant", "contact", "cone", "relaxed-cone"]);

    let scene = scene::load(&asset("torus.gltf")).expect("a scene");
    let camera = scene.camera.expect("a camera");
    let reference = Reference::new(&scene);
    let way = reference.way(&camera, SIZE, [30, 20]);
    let hit = way.hit.expect("a hit");
    assert_eq!(told["hit"]["depth"].as_f64(), Some(hit.distance));
    // Steep's hit is its last sample, and below the surface.
    let steep = &marches[0];
    assert_eq!(steep["samples"].as_array().and_then(|samples| samples.last()), Some(&steep["hit"]));
    assert!(steep["hit"]["height"].as_f64() < steep["hit"]["surface"].as_f64());

    let drawing = fs::read_to_string(folder.path().join("probe.svg")).expect("a drawing");
    assert!(drawing.starts_with("<svg") && drawing.trim_end().ends_with("</svg>"));
    for name in names {
        assert!(
            drawing.contains(&format!("{name}\n")) || drawing.contains(&format!(">{name}<")),
            "{name} is not drawn"
        );
    }
    assert!(drawing.len() < 400_000, "{} bytes", drawing.len());
}

#[test]
fn what_cannot_be_probed_is_told() {
    let folder = folder();
    let mut gltf = Gltf::new();
    let clay = gltf.plain("clay");
    let mesh = gltf.mesh("sheet", &Shape::sheet(1.0, [0.0, 0.0], [1.0, 1.0]), clay);
    gltf.node(serde_json::json!({ "mesh": mesh }));
    let plain = gltf.write(folder.path());
    let torus = asset("torus.gltf");
    for (scene, words, told) in [
        (&torus, "--pixel 64,3", "ends at 63,35"),
        (&torus, "--pixel 3", "column and row"),
        (&torus, "--pixel -1,3", "column and row"),
        (&torus, "--pixel 0,0", "hits nothing"),
        (&plain, "--pixel 32,18", "plain surface (material 'clay')"),
        (&torus, "--pixel 30,20 --out probe.png", ".svg"),
        (&torus, "--pixel 30,20 --march normal", "normal"),
        (&torus, "--pixel 30,20 --march pom --refine-steps 4", "--refine-steps"),
        (&torus, "--pixel 30,20 --min-steps 9 --max-steps 8", "--min-steps 9"),
    ] {
        let outcome = prism("probe").arg(scene).words("--size 64x36").words(words).within(folder.path()).run().ends(2);
        assert!(outcome.stderr.contains(told), "{words}\n{outcome}");
    }
    let outcome = prism("probe").arg("none.gltf").words("--pixel 3,3").within(folder.path()).run().ends(1);
    outcome.complains(&["none.gltf"]);
    assert!(!folder.path().join("probe.svg").exists());
}
