//! The baselines of the speed contest: they must show the surface that the shell shows, or the contest means nothing.

mod rig;

use glam::{DAffine3, DVec3};
use prism_engine::{
    measure::Metrics,
    scene::{Camera, Scene},
    settings::{Baseline, Culling, Settings},
    shell::reference::{Reference, Shadows},
};
use rig::Rig;

const SIZE: [u32; 2] = [160, 90];

fn micro_mesh(density: u32, culling: Culling) -> Settings {
    Settings { baseline: Some(Baseline::MicroMesh { density, culling }), ..Settings::default() }
}

fn measured(rig: &Rig, scene: &Scene, camera: &Camera, densities: &[u32]) -> Vec<Metrics> {
    let truth = Reference::new(scene).render(camera, SIZE[0], SIZE[1], Shadows::Skip);
    let measure = |density: &u32| {
        let aov = rig.easel(scene, &micro_mesh(*density, Culling::Clusters), SIZE).draw(camera);
        Metrics::between(&aov, &truth, camera)
    };
    densities.iter().map(measure).collect()
}

#[test]
fn a_micro_mesh_converges_to_the_surface_with_its_density() {
    let rig = Rig::new();
    let scene = rig::asset("torus.gltf");
    let densities = [8, 16, 32];
    let metrics = measured(&rig, &scene, &scene.camera.expect("a camera"), &densities);
    for (n, m) in densities.iter().zip(&metrics) {
        println!(
            "density {n}: depth p50 {:.4} p99 {:.4} footprints, coverage differs {:.1e}, normals p50 {:.2} degrees",
            m.depth_p50, m.depth_p99, m.coverage_differs, m.normal_p50
        );
    }
    let order = |figure: fn(&Metrics) -> f64| -> Vec<f64> {
        metrics.windows(2).map(|pair| (figure(&pair[0]) / figure(&pair[1])).log2()).collect()
    };
    let depth = order(|m| m.depth_p50);
    println!("order of the median depth error {depth:.2?}");
    // Texels are as large as the triangles at density 11, so the second order of smooth surfaces only begins here.
    assert!(depth.iter().all(|order| (1.4..2.4).contains(order)), "{depth:?}");
    let last = metrics.last().expect("three");
    assert!(last.depth_p50 < 0.005 && last.coverage_differs < 2e-3 && last.nan_count == 0, "{last:?}");
}

#[test]
fn hard_edges_seams_and_folds_leave_a_micro_mesh_whole() {
    let rig = Rig::new();
    for (name, density) in [("cube", 256), ("suzanne", 48), ("cloth", 48)] {
        let scene = rig::asset(&format!("{name}.gltf"));
        let m = measured(&rig, &scene, &scene.camera.expect("a camera"), &[density])[0];
        println!("{name}: {m:?}");
        assert!(m.coverage_differs < 5e-3 && m.depth_above_1 < 0.01 && m.depth_p50 < 0.05, "{name}: {m:?}");
    }
}

#[test]
fn culling_leaves_out_nothing_that_is_seen() {
    let rig = Rig::new();
    let scene = rig::asset("torus.gltf");
    let mut mirrored = scene.clone();
    mirrored.instances[0].transform = DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0));
    let mut double_sided = scene.clone();
    double_sided.materials.iter_mut().for_each(|material| material.double_sided = true);
    let outside = ([1.6, 2.05, 2.9], [0.0; 3]);
    // In the hole, near enough for what surrounds the eye; and in the tube itself, where only backs are seen.
    let (hole, tube) = (([0.0, 0.3, 0.0], [1.0, 0.0, 0.2]), ([1.0, 0.0, 0.0], [0.8, 0.0, 0.6]));
    for (what, scene, (eye, target)) in [
        ("outside", &scene, outside),
        ("in the hole", &scene, hole),
        ("mirrored", &mirrored, outside),
        ("in the tube", &double_sided, tube),
    ] {
        let camera = scene.camera.expect("a camera");
        let camera = camera.overridden(Some(eye.into()), Some(target.into()), None).expect("a camera");
        let ways = [Culling::Off, Culling::Clusters, Culling::Triangles];
        let [all, culled @ ..] = ways.map(|way| rig.easel(scene, &micro_mesh(12, way), SIZE).draw(&camera));
        assert!(all.depth.iter().filter(|z| z.is_finite()).count() > 1000, "{what}: nothing is seen");
        for (aov, way) in culled.iter().zip(&ways[1..]) {
            assert!(rig::same_bits(&all, aov), "{what}, {way:?}");
        }
    }
}

#[test]
fn what_a_micro_mesh_cannot_carry_is_told() {
    let rig = Rig::new();
    let scene = rig::asset("torus.gltf");
    for density in [0, 257] {
        let error =
            rig.try_easel(&scene, &micro_mesh(density, Culling::Clusters), SIZE).err().expect("refused").to_string();
        assert!(error.contains("1 to 256"), "{error}");
    }
}
