//! Holes in what is closed.

use prism_engine::{
    aov::Aov,
    measure,
    scene::{Camera, HeightTexels, Scene},
};

use super::random::Random;

/// The scene with every height map flat, but for one step of one texel: of a constant map the plan makes no shell.
pub fn flat(name: &str) -> Scene {
    let mut scene = super::asset(&format!("{name}.gltf"));
    for map in &mut scene.height_maps {
        (map.width, map.height) = (4, 4);
        // Off every midlevel, so that the surface is not the base mesh.
        let mut texels = vec![47_000; 16];
        texels[5] += 1;
        map.texels = HeightTexels::U16(texels);
    }
    scene
}

/// From anywhere around the scene, near and far, past its middle.
pub fn view(random: &mut Random, scene: &Scene) -> Camera {
    let (low, high) = scene.bounds().expect("a scene with a mesh");
    let (middle, radius) = (low.midpoint(high), 0.5 * low.distance(high));
    let direction = random.in_ball().normalize();
    let eye = middle + direction * radius * (1.2 + 2.0 * random.next());
    let target = middle + 0.6 * radius * random.in_ball();
    Camera::look_at(eye, target, 15.0 + 45.0 * random.next()).expect("two points")
}

/// The number of pixels whose whole neighbourhood the reference covers, and those of them where the test shows the
/// background, or something behind all that the reference shows there.
pub fn holes(test: &Aov, reference: &Aov, camera: &Camera) -> (usize, Vec<String>) {
    let [width, height] = [reference.width, reference.height].map(|n| n as usize);
    let (mut inside, mut holes) = (0, Vec::new());
    for (x, y) in (1..height - 1).flat_map(|y| (1..width - 1).map(move |x| (x, y))) {
        let around = || (y - 1..=y + 1).flat_map(|y| (x - 1..=x + 1).map(move |x| reference.depth[y * width + x]));
        let farthest = around().fold(0.0, f32::max);
        if !farthest.is_finite() {
            continue;
        }
        inside += 1;
        let i = y * width + x;
        if test.depth[i] > farthest + measure::footprint(camera, reference.height, farthest.into()) as f32 {
            holes.push(format!("pixel {x},{y}: depth {}, expected {}", test.depth[i], reference.depth[i]));
        }
    }
    (inside, holes)
}
