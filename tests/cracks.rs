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

/// Why there are holes for now; such ones are shown as missed, any other fails. In a frame of 64² in which a loop gave up:
const LIMIT: &str = "the step limit is reached where a short path stays on the border of two cells of the map";
/// Where the reference hits a plain triangle:
const PLAIN: &str = "plain triangles are rasterised on a grid of 1/256 pixel and do not meet the traced prisms exactly";
/// Holes of both kinds together, per pixel.
const KNOWN: f64 = 3e-5;

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

/// A pixel whose whole neighbourhood the reference covers, but where the test shows the background, or something behind all
/// that the reference shows there.
struct Hole {
    what: String,
    /// If it is one of those that are known.
    why: Option<&'static str>,
}

/// The number of pixels that there are to judge, and the holes. `limits`: loops that gave up.
fn holes(test: &Aov, reference: &Aov, camera: &Camera, limits: u32) -> (usize, Vec<Hole>) {
    let [width, height] = SIZE.map(|n| n as usize);
    let (mut inside, mut holes) = (0, Vec::new());
    for (x, y) in (1..height - 1).flat_map(|y| (1..width - 1).map(move |x| (x, y))) {
        let around = || (y - 1..=y + 1).flat_map(|y| (x - 1..=x + 1).map(move |x| reference.depth[y * width + x]));
        let farthest = around().fold(0.0, f32::max);
        if !farthest.is_finite() {
            continue;
        }
        inside += 1;
        let i = y * width + x;
        if test.depth[i] > farthest + measure::footprint(camera, SIZE[1], farthest.into()) as f32 {
            // The displaced surface is nowhere on the midlevel.
            let plain = reference.height_at_hit[i] == 0.5;
            let why = if limits > 0 { Some(LIMIT) } else { plain.then_some(PLAIN) };
            let what = format!("pixel {x},{y}: depth {}, expected {}", test.depth[i], reference.depth[i]);
            holes.push(Hole { what, why });
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
    let (mut pixels, mut known, mut wrong) = (0, 0, Vec::new());
    for number in 0..VIEWS {
        let camera = view(&mut random, &scene);
        let truth = reference.render(&camera, SIZE[0], SIZE[1], Shadows::Skip);
        for (stage, easel) in &mut easels {
            easel.assert_stage(*stage);
            let test = easel.draw(&camera);
            let (inside, holes) = holes(&test, &truth, &camera, easel.limits_reached());
            pixels += inside;
            for Hole { what, why } in holes {
                let line = format!("{name}, view {number}, {stage}: {what}");
                if let Some(why) = why {
                    known += 1;
                    println!("MISSED {line}: {why}");
                } else {
                    wrong.push(line);
                }
            }
        }
    }
    println!("{name}: {} holes in {pixels} pixels of {VIEWS} views and both stages", known + wrong.len());
    assert!(wrong.is_empty(), "{} holes:\n{}", wrong.len(), wrong.join("\n"));
    assert!(known as f64 <= KNOWN * pixels as f64, "{name}: {known} known holes in {pixels} pixels");
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
