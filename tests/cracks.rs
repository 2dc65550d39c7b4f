//! No cracks: under a constant height map a closed mesh has no hole, from wherever it is looked at.

mod rig;

use glam::DVec3;
use prism_engine::{
    scene::{Camera, Primitive, Scene},
    settings::{Shell, Stage},
    shell::reference::{Reference, Shadows},
};
use rig::{
    Rig, SHELLS, STAGES,
    holes::{flat, holes, view},
    random::Random,
};

/// Views of each mesh.
const VIEWS: u64 = 200;
const SIZE: [u32; 2] = [64, 64];

fn without_cracks(name: &str, scene: &Scene, seed: u64) {
    let rig = Rig::new();
    let reference = Reference::new(scene);
    let kinds = SHELLS.into_iter().flat_map(|shell| STAGES.map(|stage| (shell, stage)));
    let mut easels: Vec<_> =
        kinds.map(|(shell, stage)| (shell, stage, rig.easel(scene, &rig::exact(shell, stage), SIZE))).collect();
    let mut random = Random(seed);
    let (mut pixels, mut wrong) = (0, Vec::new());
    for number in 0..VIEWS {
        let camera = view(&mut random, scene);
        let truth = reference.render(&camera, SIZE[0], SIZE[1], Shadows::Skip);
        for (shell, stage, easel) in &mut easels {
            easel.assert_stage(*stage);
            let test = easel.draw(&camera);
            assert_eq!(easel.limits_reached(), 0, "{name}, view {number}, {shell} {stage}: loops gave up");
            let (inside, holes) = holes(&test, &truth, &camera);
            pixels += inside;
            wrong.extend(holes.iter().map(|hole| format!("{name}, view {number}, {shell} {stage}: {hole}")));
        }
    }
    println!("{name}: {} holes in {pixels} pixels of {VIEWS} views, both shells and both stages", wrong.len());
    assert!(wrong.is_empty(), "{} holes:\n{}", wrong.len(), wrong.join("\n"));
    // A fifth of the pictures at least, or the views look past the mesh.
    assert!(pixels as u64 * 5 > VIEWS * easels.len() as u64 * u64::from(SIZE[0] * SIZE[1]), "only {pixels} pixels");
}

#[test]
fn on_the_torus() {
    without_cracks("torus", &flat("torus"), 1);
}

#[test]
fn on_the_cube() {
    without_cracks("cube", &flat("cube"), 2);
}

/// She has open borders; what is seen through them is seen in the reference too.
#[test]
fn on_suzanne() {
    without_cracks("suzanne", &flat("suzanne"), 3);
}

/// Every edge of it is a UV seam, and one side is plain.
#[test]
fn on_the_ball_of_seams() {
    without_cracks("stability_seams", &flat("stability_seams"), 4);
}

/// Each `step`th triangle of a primitive, from the `first` on, with vertices of its own.
fn part(whole: &Primitive, first: usize, step: usize) -> Primitive {
    let triangles = whole.triangles.iter().skip(first).step_by(step);
    let corners: Vec<usize> = triangles.flatten().map(|v| *v as usize).collect();
    fn pick<T: Copy>(all: &[T], corners: &[usize]) -> Vec<T> {
        corners.iter().filter_map(|v| all.get(*v).copied()).collect()
    }
    Primitive {
        positions: pick(&whole.positions, &corners),
        normals: pick(&whole.normals, &corners),
        tangents: pick(&whole.tangents, &corners),
        uvs: [0, 1].map(|set| pick(&whole.uvs[set], &corners)),
        weld: pick(&whole.weld, &corners),
        triangles: (0..corners.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
        ..*whole
    }
}

/// Every triangle has neighbours of another primitive: of one at another scale and midlevel, or plain.
#[test]
fn on_the_torus_in_pieces() {
    const PIECES: usize = 5;
    let mut scene = flat("torus");
    let whole = scene.meshes[0].primitives.remove(0);
    for piece in 0..PIECES {
        let mut material = scene.materials[whole.material].clone();
        let mut primitive = part(&whole, piece, PIECES);
        if piece == 1 {
            (material.displacement, primitive.displacement_scale) = (None, 0.0);
        }
        if let Some(displacement) = &mut material.displacement {
            // The one whose steps go inward stands in its neighbours' way, the others in its.
            displacement.midlevel = [0.5, 0.5, 0.9, 0.5, 0.2][piece];
            displacement.scale *= [1.0, 0.0, 0.7, 0.4, 1.2][piece];
            primitive.displacement_scale = displacement.scale;
        }
        primitive.material = scene.materials.len();
        scene.materials.push(material);
        scene.meshes[0].primitives.push(primitive);
    }
    without_cracks("torus in pieces", &scene, 5);
}

/// The camera stands in the plane of an edge that ends in the open border, and of a column of pixel centres: these rays
/// come in through one corner, of a prism that has no wall at the border.
#[test]
fn in_the_plane_of_an_edge() {
    const ODD: [u32; 2] = [95, 53];
    let rig = Rig::new();
    let scene = rig::asset("planet.gltf");
    let camera = Camera::look_at(DVec3::new(-2.0, 1.5, 2.4), DVec3::new(-2.0, -0.05, 0.05), 34.0).expect("two points");
    let truth = Reference::new(&scene).render(&camera, ODD[0], ODD[1], Shadows::Skip);
    for (shell, stage) in [(Shell::Walk, Stage::Mesh), (Shell::Walk, Stage::Geometry), (Shell::Prism, Stage::Mesh)] {
        let mut easel = rig.easel(&scene, &rig::exact(shell, stage), ODD);
        easel.assert_stage(stage);
        let test = easel.draw(&camera);
        let middle = (0..ODD[1]).map(|y| (y * ODD[0] + ODD[0] / 2) as usize);
        let (mut seen, mut missed) = (0, Vec::new());
        for i in middle.filter(|i| truth.depth[*i].is_finite()) {
            seen += 1;
            missed.extend((!test.depth[i].is_finite()).then_some(i));
        }
        assert!(seen > 20 && missed.is_empty(), "{shell} {stage}: {missed:?} of {seen} in the middle column");
    }
}
