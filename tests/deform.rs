//! Meshes that change shape: what the GPU makes of a pose is the surface of a scene that has been so from the start.

mod rig;

use std::{array, collections::HashMap};

use glam::{DVec3, Vec3};
use prism_engine::{
    measure::Metrics,
    scene::{Camera, Scene},
    settings::{SelfShadow, Settings, Shell, Stage},
    shell::reference::{Reference, Shadows},
};
use rig::{Rig, SHELLS, STAGES, exactness};

const EXTENT: [u32; 2] = [160, 90];

/// Where a point of the mesh is at a time.
type Motion = fn(DVec3, f64) -> DVec3;

/// A wave through a sheet.
fn wave(p: DVec3, time: f64) -> DVec3 {
    let phase = 4.0 * p.x - 3.0 * time;
    p + DVec3::new(0.04 * phase.cos(), 0.05 * (3.0 * p.y + time).sin(), 0.2 * phase.sin() * (1.5 + p.x) / 3.0)
}

/// Turned about the vertical axis, further the higher it is, and squeezed in the middle.
fn twist(p: DVec3, time: f64) -> DVec3 {
    let (sin, cos) = (0.7 * time * p.y).sin_cos();
    let squeeze = 1.0 - 0.3 * (time - 0.5) * (2.0 * p.y).cos();
    DVec3::new(cos * p.x - sin * p.z, p.y, sin * p.x + cos * p.z) * DVec3::new(squeeze, 1.0, squeeze)
}

/// The positions of a scene's first mesh at a time.
fn pose(scene: &Scene, motion: Motion, time: f64) -> Vec<Vec3> {
    let vertices = scene.meshes[0].primitives.iter().flat_map(|p| &p.positions);
    vertices.map(|p| motion(p.as_dvec3(), time).as_vec3()).collect()
}

/// The scene with its first mesh in a pose, its vertex normals computed in f64: of all that share position and normal
/// in the file, the mean of the triangles' normals, weighted by corner angle.
fn posed(scene: &Scene, positions: &[Vec3]) -> Scene {
    let mut scene = scene.clone();
    let mesh = &mut scene.meshes[0];
    let key = |p: Vec3, n: Vec3| (p.to_array().map(|x| (x + 0.0).to_bits()), n.to_array().map(|x| (x + 0.0).to_bits()));
    let mut sums: HashMap<_, DVec3> = HashMap::new();
    let mut rest = positions;
    for primitive in &mut mesh.primitives {
        let (own, others) = rest.split_at(primitive.positions.len());
        rest = others;
        for triangle in &primitive.triangles {
            let corner = triangle.map(|v| own[v as usize].as_dvec3());
            let normal = (corner[1] - corner[0]).cross(corner[2] - corner[0]).normalize_or_zero();
            for k in 0..3 {
                let v = triangle[k] as usize;
                let [e1, e2] = [1, 2].map(|i| corner[(k + i) % 3] - corner[k]);
                let sum = sums.entry(key(primitive.positions[v], primitive.normals[v])).or_default();
                *sum += e1.angle_between(e2) * normal;
            }
        }
    }
    rest = positions;
    for primitive in &mut mesh.primitives {
        let (own, others) = rest.split_at(primitive.positions.len());
        rest = others;
        for v in 0..own.len() {
            let sum = sums.get(&key(primitive.positions[v], primitive.normals[v])).copied().unwrap_or(DVec3::Z);
            primitive.normals[v] = sum.normalize_or(DVec3::Z).as_vec3();
        }
        primitive.positions = own.to_vec();
    }
    scene
}

fn settings() -> impl Iterator<Item = Settings> {
    SHELLS.into_iter().flat_map(|shell| STAGES.map(|stage: Stage| rig::exact(shell, stage)))
}

/// Draws the poses at some times with every shell and stage, one after the other, and insists on the figures.
#[track_caller]
fn follows(name: &str, motion: Motion, times: [f64; 3], least_covered: usize) {
    let rig = Rig::new();
    let mut scene = rig::asset(name);
    scene.meshes[0].deforms = true;
    let camera: Camera = scene.camera.expect("the assets have cameras");
    let poses = times.map(|time| pose(&scene, motion, time));
    let [width, height] = EXTENT;
    let truths = array::from_fn::<_, 3, _>(|i| {
        Reference::new(&posed(&scene, &poses[i])).render(&camera, width, height, Shadows::Skip)
    });
    let mut wrong = Vec::new();
    for settings in settings() {
        let mut easel = rig.easel(&scene, &settings, EXTENT);
        easel.assert_stage(settings.stage);
        for (i, pose) in poses.iter().enumerate() {
            let drawn = easel.draw_posed(&camera, Some((0, pose)));
            let m = Metrics::between(&drawn, &truths[i], &camera);
            let (limits, time) = (easel.limits_reached(), times[i]);
            let line = format!("{name} at {time} {} {}: {limits} lost, {m:?}", settings.shell, settings.stage);
            println!("{line}");
            for line in rig::worst::lines(&drawn, &truths[i], &camera, rig::worst::asked()) {
                println!("{line}");
            }
            assert!(m.covered >= least_covered, "{line}");
            if !exactness::misses(&m, limits).is_empty() {
                wrong.push(line);
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn a_waving_sheet() {
    follows("cloth.gltf", wave, [0.0, 0.6, 1.7], 3000);
}

#[test]
fn a_twisted_ring() {
    follows("torus.gltf", twist, [0.3, 0.8, 1.5], 3000);
}

/// Its faces meet at hard edges, where shell normals are welded and shading normals are not.
#[test]
fn a_twisted_box() {
    follows("cube.gltf", twist, [0.2, 0.4, 0.6], 3000);
}

/// Folds, plain triangles, other walls than in the file.
#[test]
fn a_twisted_head() {
    follows("suzanne.gltf", twist, [0.2, 0.5, 1.0], 3000);
}

/// Shadow rays of a posed mesh go on in boxes that were fitted to the pose: across the ring, far from where it stood.
#[test]
fn a_twisted_ring_shadows_itself() {
    let rig = Rig::new();
    let mut scene = rig::asset("torus.gltf");
    scene.meshes[0].deforms = true;
    scene.lights.truncate(1);
    scene.lights[0].direction = DVec3::new(0.9, -0.3, -0.3).normalize();
    let camera: Camera = scene.camera.expect("the assets have cameras");
    let settings = Settings { self_shadow: SelfShadow::Hard, ..rig::exact(Shell::Walk, Stage::Mesh) };
    let mut easel = rig.easel(&scene, &settings, EXTENT);
    for time in [0.8, 1.5] {
        let moved = pose(&scene, |p, time| twist(p, time) + DVec3::new(0.0, 0.1, 0.0), time);
        let truth = Reference::new(&posed(&scene, &moved)).render(&camera, EXTENT[0], EXTENT[1], Shadows::TraceOwn);
        let drawn = easel.draw_posed(&camera, Some((0, &moved)));
        let both: Vec<_> = (0..truth.depth.len()).filter(|i| (truth.depth[*i] + drawn.depth[*i]).is_finite()).collect();
        let wrong = both.iter().filter(|i| (truth.shadow[**i] < 0.5) != (drawn.shadow[**i] < 0.5)).count();
        println!("torus at {time}: {wrong} of {} wrong", both.len());
        assert!(both.len() > 3000 && 1000 * wrong <= both.len(), "{wrong} of {}", both.len());
        assert_eq!(easel.limits_reached(), 0);
    }
}

/// A pose leaves nothing behind: a frame repeats to the bit, on a new device and after other poses.
#[test]
fn a_pose_repeats_to_the_bit() {
    let rig = Rig::new();
    let mut scene = rig::asset("suzanne.gltf");
    scene.meshes[0].deforms = true;
    let camera = scene.camera.expect("the assets have cameras");
    let [first, other] = [1.0, 0.3].map(|time| pose(&scene, twist, time));
    for settings in settings() {
        let mut easel = rig.easel(&scene, &settings, EXTENT);
        let drawn = easel.draw_posed(&camera, Some((0, &first)));
        let between = easel.draw_posed(&camera, Some((0, &other)));
        assert!(!rig::same_bits(&drawn, &between), "the poses differ");
        let again = easel.draw_posed(&camera, Some((0, &first)));
        assert!(rig::same_bits(&drawn, &again), "{} {}: after another pose", settings.shell, settings.stage);
        let kept = easel.draw(&camera);
        assert!(rig::same_bits(&drawn, &kept), "{} {}: a pose stays", settings.shell, settings.stage);
        let anew = rig.easel(&scene, &settings, EXTENT).draw_posed(&camera, Some((0, &first)));
        assert!(rig::same_bits(&drawn, &anew), "{} {}: drawn anew", settings.shell, settings.stage);
    }
}

/// Never posed, it stands as in its file.
#[test]
fn without_a_pose_it_rests() {
    let rig = Rig::new();
    let mut scene = rig::asset("suzanne.gltf");
    let camera = scene.camera.expect("the assets have cameras");
    let truth = Reference::new(&scene).render(&camera, EXTENT[0], EXTENT[1], Shadows::Skip);
    scene.meshes[0].deforms = true;
    for settings in settings() {
        let mut easel = rig.easel(&scene, &settings, EXTENT);
        let drawn = easel.draw(&camera);
        let m = Metrics::between(&drawn, &truth, &camera);
        assert_eq!(exactness::misses(&m, easel.limits_reached()), [], "{} {}", settings.shell, settings.stage);
    }
}
