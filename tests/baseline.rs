//! The baselines of the speed contest: they must show the surface that the shell shows, or the contest means nothing.

mod rig;

use glam::{DAffine3, DVec3, Vec2, Vec3};
use prism_engine::{
    aov::Aov,
    gpu::Feature,
    measure::Metrics,
    render::plan,
    scene::{Camera, HeightSource, HeightTexels, Procedure, Projection, Scene},
    settings::{Baseline, Culling, Dicer, Settings, Stage, VisibilityBuffer},
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

/// A scene whose first instance a mirror turns around.
fn mirrored(scene: &Scene) -> Scene {
    let mut mirrored = scene.clone();
    mirrored.instances[0].transform = DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0));
    mirrored
}

/// A scene of which both sides show.
fn double_sided(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    scene.materials.iter_mut().for_each(|material| material.double_sided = true);
    scene
}

#[test]
fn culling_leaves_out_nothing_that_is_seen() {
    let rig = device();
    let scene = rig::asset("torus.gltf");
    let (mirrored, double_sided) = (mirrored(&scene), double_sided(&scene));
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

/// Each way to cull, from outside and where the near plane cuts triangles, behind plain balls, turned around by a mirror, both
/// sides and an orthographic lens.
#[test]
fn a_visibility_buffer_shows_the_same_micro_mesh() {
    let rig = device();
    let torus = rig::asset("torus.gltf");
    let (mirrored, double_sided) = (mirrored(&torus), double_sided(&torus));
    let own = |scene: &Scene| scene.camera.expect("a camera");
    let seen = |eye: [f64; 3], target: [f64; 3]| {
        own(&torus).overridden(Some(eye.into()), Some(target.into()), None).expect("a camera")
    };
    let flat = Camera { projection: Projection::Orthographic { y_mag: 1.0, near: 0.1, far: 10.0 }, ..own(&torus) };
    let balls = rig::asset("prism_shell.gltf");
    for (what, scene, camera, density, culling) in [
        ("not culled", &torus, own(&torus), 12, Culling::Off),
        ("coarse", &torus, own(&torus), 2, Culling::Triangles),
        ("fine", &torus, own(&torus), 24, Culling::Triangles),
        ("mirrored", &mirrored, own(&torus), 12, Culling::Clusters),
        ("in the tube", &double_sided, seen([1.0, 0.0, 0.0], [0.8, 0.0, 0.6]), 12, Culling::Clusters),
        ("orthographic", &torus, flat, 12, Culling::Triangles),
        ("behind balls", &balls, own(&balls), 8, Culling::Clusters),
    ] {
        let [named, direct] = [VisibilityBuffer::On, VisibilityBuffer::Off].map(|visibility_buffer| {
            let settings = Settings { visibility_buffer, ..micro_mesh(density, culling) };
            let mut easel = rig.easel(scene, &settings, SIZE);
            (easel.draw(&camera), easel.passes(&camera), easel.picture(&camera))
        });
        let passes = |passes: &[String]| passes.iter().any(|name| name == "visibility");
        assert_eq!([passes(&named.1), passes(&direct.1)], [true, false], "{what}: {:?}", named.1);
        let covered = |aov: &Aov| aov.depth.iter().map(|z| z.is_finite()).collect::<Vec<_>>();
        assert!(covered(&direct.0).iter().filter(|covered| **covered).count() > 1000, "{what}: nothing is seen");
        assert!(covered(&named.0) == covered(&direct.0), "{what}: other pixels are covered");
        // The raster extrapolates where its grid lets a triangle cover a pixel beside it: of triangles seen edge-on, few, far.
        let off = |i: &usize| {
            let [a, b] = [&named.0, &direct.0].map(|aov| (aov.depth[*i], Vec3::from(aov.normal[*i]), aov.uv[*i]));
            let uv = Vec2::from(a.2).distance(b.2.into());
            (a.0 / b.0 - 1.0).abs() > 1e-5 || a.1.dot(b.1) < 0.9999 || uv > 1e-4
        };
        let pixels: Vec<_> = (0..direct.0.depth.len()).filter(|i| direct.0.depth[*i].is_finite()).collect();
        let wrong = pixels.iter().copied().filter(|i| off(i)).count();
        let codes = named.2.iter().zip(&direct.2).map(|(a, b)| a.abs_diff(*b));
        let (most, unlike) = (codes.clone().max(), codes.filter(|code| *code > 2).count());
        println!(
            "{what}: {wrong} of {} pixels off, {unlike} values by more than 2 codes, {most:?} at most",
            pixels.len()
        );
        assert!(200 * wrong <= pixels.len() && 1000 * unlike <= pixels.len(), "{what}: {wrong}, {unlike}");
    }
}

#[test]
fn a_visibility_buffer_is_where_a_micro_mesh_gains_by_it() {
    let named = |scene: &Scene, settings: &Settings| {
        let plan = plan::plan(scene, settings, Stage::Mesh, false);
        plan.draws.iter().filter(|draw| draw.visibility.is_some()).count()
    };
    let torus = rig::asset("torus.gltf");
    let dense = micro_mesh(16, Culling::Triangles);
    let off = Settings { visibility_buffer: VisibilityBuffer::Off, ..dense.clone() };
    let on = Settings { visibility_buffer: VisibilityBuffer::On, ..micro_mesh(1, Culling::Off) };
    assert_eq!([&dense, &micro_mesh(1, Culling::Off), &off, &on].map(|settings| named(&torus, settings)), [1, 0, 0, 1]);
    // What alpha cuts out of a triangle shows what is behind.
    let mut masked = torus.clone();
    masked.materials.iter_mut().for_each(|material| material.alpha_cutoff = Some(0.5));
    masked.materials.iter_mut().for_each(|material| material.base_color_factor.w = 0.4);
    assert_eq!(named(&masked, &dense), 0);
    let error = plan::check(&masked, &on).expect_err("refused").to_string();
    assert!(error.contains("alpha"), "{error}");
    let error =
        plan::check(&torus, &Settings { visibility_buffer: VisibilityBuffer::On, ..diced(Dicer::Mesh, 2.0, true) });
    assert!(error.expect_err("refused").to_string().contains("--visibility-buffer on"));
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
