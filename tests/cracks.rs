//! No cracks: under a constant height map a closed mesh has no hole, from wherever it is looked at.

mod rig;

use glam::DVec3;
use prism_engine::{
    aov::Aov,
    measure,
    scene::{Camera, HeightTexels, Scene},
    settings::Shell,
    shell::reference::{Reference, Shadows},
};
use rig::{Rig, STAGES};

/// Views of each mesh.
const VIEWS: u64 = 200;
const SIZE: [u32; 2] = [64, 64];

/// Holes there are for now: mesh, at most how many, why. They are shown as missed.
const KNOWN: &[(&str, usize, &str)] = &[
    ("cube", 4, "the step limit is reached where a short path stays on the border of two cells of the map"),
    ("suzanne", 4, PLAIN),
    ("stability_seams", 8, PLAIN),
];
const PLAIN: &str =
    "plain triangles are rasterised, on a grid of 1/256 pixel, and do not meet the traced prisms exactly";

/// The scene with every height map flat.
fn flat(name: &str) -> Scene {
    let mut scene = rig::asset(&format!("{name}.gltf"));
    for map in &mut scene.height_maps {
        (map.width, map.height) = (4, 4);
        // Off every midlevel, so that the surface is not the base mesh.
        map.texels = HeightTexels::U16(vec![47_000; 16]);
    }
    scene
}

/// Numbers in [0, 1) in an order that looks random, the same each time (splitmix64).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// A point in the unit ball.
    fn in_ball(&mut self) -> DVec3 {
        loop {
            let point = DVec3::from_array(std::array::from_fn(|_| 2.0 * self.next() - 1.0));
            if point.length() <= 1.0 {
                return point;
            }
        }
    }
}

/// From anywhere around the scene, near and far, past its middle.
fn view(random: &mut Random, scene: &Scene) -> Camera {
    let (low, high) = scene.bounds().expect("a scene with a mesh");
    let (middle, radius) = (low.midpoint(high), 0.5 * low.distance(high));
    let direction = random.in_ball().normalize();
    let eye = middle + direction * radius * (1.2 + 2.0 * random.next());
    let target = middle + 0.6 * radius * random.in_ball();
    Camera::look_at(eye, target, 15.0 + 45.0 * random.next()).expect("two points")
}

/// Pixels whose whole neighbourhood the reference covers, but where the test shows the background, or something behind all
/// that the reference shows there: how many pixels there are to judge, and what is wrong with each hole.
fn holes(test: &Aov, reference: &Aov, camera: &Camera) -> (usize, Vec<String>) {
    let [width, height] = SIZE.map(|n| n as usize);
    let (mut inside, mut holes) = (0, Vec::new());
    for (x, y) in (1..height - 1).flat_map(|y| (1..width - 1).map(move |x| (x, y))) {
        let around = || (y - 1..=y + 1).flat_map(|y| (x - 1..=x + 1).map(move |x| reference.depth[y * width + x]));
        let farthest = around().fold(0.0, f32::max);
        if farthest.is_finite() {
            inside += 1;
            let room = measure::footprint(camera, SIZE[1], farthest.into()) as f32;
            let depth = test.depth[y * width + x];
            if depth > farthest + room {
                holes.push(format!("pixel {x},{y}: depth {depth}, expected {}", reference.depth[y * width + x]));
            }
        }
    }
    (inside, holes)
}

fn without_cracks(name: &str, seed: u64) {
    let rig = Rig::new();
    let scene = flat(name);
    let reference = Reference::new(&scene);
    let mut easels = STAGES.map(|stage| (stage, rig.easel(&scene, &rig::exact(Shell::Prism, stage), SIZE)));
    let mut random = Random(seed);
    let (mut pixels, mut wrong) = (0, Vec::new());
    for number in 0..VIEWS {
        let camera = view(&mut random, &scene);
        let truth = reference.render(&camera, SIZE[0], SIZE[1], Shadows::Skip);
        for (stage, easel) in &mut easels {
            easel.assert_stage(*stage);
            let (inside, holes) = holes(&easel.draw(&camera), &truth, &camera);
            pixels += inside;
            wrong.extend(holes.into_iter().map(|hole| format!("view {number}, {stage}: {hole}")));
        }
    }
    println!("{name}: {} holes in {pixels} pixels of {VIEWS} views and both stages", wrong.len());
    let shown = wrong.iter().take(10).cloned().collect::<Vec<_>>().join("\n");
    let known = KNOWN.iter().find(|(mesh, ..)| *mesh == name).filter(|_| !wrong.is_empty());
    if let Some((_, _, why)) = known {
        println!("MISSED {name}: {why}\n{shown}");
    }
    let allowed = known.map_or(0, |(_, most, _)| *most);
    assert!(wrong.len() <= allowed, "{name}: {} holes in {pixels} pixels:\n{shown}", wrong.len());
    // A fifth of the pictures at least, or the views look past the mesh.
    assert!(pixels as u64 * 5 > VIEWS * 2 * u64::from(SIZE[0] * SIZE[1]), "only {pixels} pixels");
}

#[test]
fn on_the_torus() {
    without_cracks("torus", 1);
}

#[test]
fn on_the_cube() {
    without_cracks("cube", 2);
}

/// She has open borders; what is seen through them is seen in the reference too.
#[test]
fn on_suzanne() {
    without_cracks("suzanne", 3);
}

/// Every edge of it is a UV seam, and one side is plain.
#[test]
fn on_the_ball_of_seams() {
    without_cracks("stability_seams", 4);
}
