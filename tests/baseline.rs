//! The baselines of the speed contest: they must show the surface that the shell shows, or the contest means nothing.

mod rig;

use glam::{DAffine3, DVec3};
use prism_engine::{
    gpu::Feature,
    measure::Metrics,
    scene::{Camera, HeightSource, HeightTexels, Procedure, Scene},
    settings::{Baseline, Culling, Dicer, Settings},
    shell::reference::{Reference, Shadows},
};
use rig::{
    Rig,
    holes::{flat, holes, view},
    random::Random,
};

const SIZE: [u32; 2] = [160, 90];

/// One with the stages that dice.
fn device() -> Rig {
    Rig::asking(&[Feature::TessellationShader, Feature::TaskShader, Feature::MeshShader])
}

fn micro_mesh(density: u32, culling: Culling) -> Settings {
    Settings { baseline: Some(Baseline::MicroMesh { density, culling }), ..Settings::default() }
}

fn diced(by: Dicer, edge: f32, culls: bool) -> Settings {
    Settings { baseline: Some(Baseline::Diced { by, edge, culls }), ..Settings::default() }
}

fn measured(rig: &Rig, scene: &Scene, camera: &Camera, settings: &[Settings]) -> Vec<Metrics> {
    let truth = Reference::new(scene).render(camera, SIZE[0], SIZE[1], Shadows::Skip);
    let measure =
        |settings: &Settings| Metrics::between(&rig.easel(scene, settings, SIZE).draw(camera), &truth, camera);
    settings.iter().map(measure).collect()
}

/// By how many powers of two a figure falls from each to the next.
fn orders(metrics: &[Metrics], figure: fn(&Metrics) -> f64) -> Vec<f64> {
    metrics.windows(2).map(|pair| (figure(&pair[0]) / figure(&pair[1])).log2()).collect()
}

#[test]
fn a_micro_mesh_converges_to_the_surface_with_its_density() {
    let rig = device();
    let scene = rig::asset("torus.gltf");
    let densities = [8, 16, 32];
    let settings = densities.map(|density| micro_mesh(density, Culling::Clusters));
    let metrics = measured(&rig, &scene, &scene.camera.expect("a camera"), &settings);
    for (n, m) in densities.iter().zip(&metrics) {
        println!(
            "density {n}: depth p50 {:.4} p99 {:.4} footprints, coverage differs {:.1e}, normals p50 {:.2} degrees",
            m.depth_p50, m.depth_p99, m.coverage_differs, m.normal_p50
        );
    }
    let depth = orders(&metrics, |m| m.depth_p50);
    println!("order of the median depth error {depth:.2?}");
    // Texels are as large as the triangles at density 11, so the second order of smooth surfaces only begins here.
    assert!(depth.iter().all(|order| (1.4..2.4).contains(order)), "{depth:?}");
    let last = metrics.last().expect("three");
    assert!(last.depth_p50 < 0.005 && last.coverage_differs < 2e-3 && last.nan_count == 0, "{last:?}");
}

#[test]
fn hard_edges_seams_and_folds_leave_a_micro_mesh_whole() {
    let rig = device();
    for (name, density) in [("cube", 256), ("suzanne", 48), ("cloth", 48)] {
        let scene = rig::asset(&format!("{name}.gltf"));
        let settings = micro_mesh(density, Culling::Clusters);
        let m = measured(&rig, &scene, &scene.camera.expect("a camera"), &[settings])[0];
        println!("{name}: {m:?}");
        assert!(m.coverage_differs < 5e-3 && m.depth_above_1 < 0.01 && m.depth_p50 < 0.05, "{name}: {m:?}");
    }
}

#[test]
fn culling_leaves_out_nothing_that_is_seen() {
    let rig = device();
    let scene = rig::asset("torus.gltf");
    let mut mirrored = scene.clone();
    mirrored.instances[0].transform = DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0));
    let mut double_sided = scene.clone();
    double_sided.materials.iter_mut().for_each(|material| material.double_sided = true);
    // So smooth that patches which face away are told by a cone around their normals.
    let mut smooth = flat("torus");
    smooth
        .height_maps
        .iter_mut()
        .for_each(|map| map.texels = HeightTexels::U16((0..16).map(|i| 4000 * (i % 3)).collect()));
    let outside = ([1.6, 2.05, 2.9], [0.0; 3]);
    // In the hole, near enough for what surrounds the eye; and in the tube itself, where only backs are seen.
    let (hole, tube) = (([0.0, 0.3, 0.0], [1.0, 0.0, 0.2]), ([1.0, 0.0, 0.0], [0.8, 0.0, 0.6]));
    let micro_meshes = [Culling::Off, Culling::Clusters, Culling::Triangles].map(|way| micro_mesh(12, way));
    let diced = |by| [false, true].map(|culls| diced(by, 4.0, culls));
    for (what, scene, (eye, target)) in [
        ("outside", &scene, outside),
        ("smooth", &smooth, outside),
        ("in the hole", &scene, hole),
        ("mirrored", &mirrored, outside),
        ("in the tube", &double_sided, tube),
    ] {
        let camera = scene.camera.expect("a camera");
        let camera = camera.overridden(Some(eye.into()), Some(target.into()), None).expect("a camera");
        for ways in [&micro_meshes[..], &diced(Dicer::Tessellation), &diced(Dicer::Mesh)] {
            let drawn = ways.iter().map(|way| rig.easel(scene, way, SIZE).draw(&camera)).collect::<Vec<_>>();
            assert!(drawn[0].depth.iter().filter(|z| z.is_finite()).count() > 1000, "{what}: nothing is seen");
            for (aov, way) in drawn.iter().zip(ways).skip(1) {
                assert!(rig::same_bits(&drawn[0], aov), "{what}, {:?}", way.baseline);
            }
        }
    }
}

#[test]
fn diced_triangles_converge_to_the_surface_with_their_size() {
    let rig = device();
    // A function without creases, so that the second order of smooth surfaces shows.
    let mut smooth = rig::asset("torus.gltf");
    smooth.materials.iter_mut().filter_map(|m| m.displacement.as_mut()).for_each(|displacement| {
        displacement.source = HeightSource::Procedure(Procedure::Waves);
    });
    let camera = smooth.camera.expect("a camera");
    for by in Dicer::ALL.iter().copied() {
        let edges = [4.0, 2.0, 1.0];
        let metrics = measured(&rig, &smooth, &camera, &edges.map(|edge| diced(by, edge, true)));
        for (edge, m) in edges.iter().zip(&metrics) {
            println!(
                "{by} {edge} px: depth p50 {:.5} p99 {:.4} footprints, coverage differs {:.1e}, normals p50 {:.2} degrees",
                m.depth_p50, m.depth_p99, m.coverage_differs, m.normal_p50
            );
        }
        let (depth, outline) = (orders(&metrics, |m| m.depth_p50), orders(&metrics, |m| m.coverage_differs));
        println!("order of the median depth error {depth:.2?}, of the silhouettes' {outline:.2?}");
        assert!(depth.iter().all(|order| (1.4..2.6).contains(order)), "{by}: {depth:?}");
        let [first, .., last] = metrics[..] else { unreachable!("three") };
        assert!(last.depth_p99 < 0.1 && last.coverage_differs < 2e-3 && last.nan_count == 0, "{by}: {last:?}");
        assert!(last.coverage_differs < 0.5 * first.coverage_differs, "{by}: {metrics:?}");
    }
}

/// Views of each mesh, from near and far.
const VIEWS: u64 = 4;

/// Tried on dicing that was broken on purpose (`PRISM_SHADERS`), holes of 9,125 pixels of the torus at 1 and at ¼ pixel: with
/// a step more on every edge of each second triangle 7 and 67 by tessellation, 9 and 69 by mesh shaders; with edges counted
/// from each triangle's own corner 149 and 270, 157 and 320. Where an edge has as many parts as its triangle, not as it needs
/// itself, neighbours differ so little that one pixel shows it, of mesh shaders at ¼.
#[test]
fn diced_triangles_leave_no_crack() {
    let rig = device();
    // Hard edges and UV seams under a constant height; and detail that any point out of place would open.
    for (name, scene) in [("cube", flat("cube")), ("suzanne", flat("suzanne")), ("torus", rig::asset("torus.gltf"))] {
        let reference = Reference::new(&scene);
        for by in Dicer::ALL.iter().copied() {
            // The second cuts triangles into many patches, and neighbours into different numbers of them.
            let mut easels = [1.0, 0.25].map(|edge| rig.easel(&scene, &diced(by, edge, true), [64, 64]));
            let mut random = Random(5);
            for number in 0..VIEWS {
                let camera = view(&mut random, &scene);
                let truth = reference.render(&camera, 64, 64, Shadows::Skip);
                for easel in &mut easels {
                    let (inside, holes) = holes(&easel.draw(&camera), &truth, &camera);
                    assert!(inside > 500, "{name}, view {number}: only {inside} pixels");
                    assert!(holes.is_empty(), "{name}, view {number}, {by}:\n{}", holes.join("\n"));
                }
            }
        }
    }
}

#[test]
fn what_a_micro_mesh_cannot_carry_is_told() {
    let rig = device();
    let scene = rig::asset("torus.gltf");
    for density in [0, 257] {
        let error =
            rig.try_easel(&scene, &micro_mesh(density, Culling::Clusters), SIZE).err().expect("refused").to_string();
        assert!(error.contains("1 to 256"), "{error}");
    }
}
