//! Without an end to its steps every march comes to the reference's hit, which shares no code with it.

use std::path::Path;

use super::*;
use crate::{
    scene::{self, Projection},
    shell::reference::Reference,
};

const SIZE: [u32; 2] = [40, 24];

/// Every pixel's error, in pixel footprints, of every march with `flags` changed from the usual settings.
fn errors(asset: &str, settings: &Settings) -> Vec<Option<f64>> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets").join(asset);
    let scene = scene::load(&path).unwrap().with_defaults(f64::from(SIZE[0]) / f64::from(SIZE[1]));
    let camera = scene.camera.unwrap_or_else(|| scene::frame(scene.bounds().unwrap(), 5.0 / 3.0));
    let reference = Reference::new(&scene);
    let mut marches = Marches::new(&scene);
    let pixels = (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| [x, y]));
    let error = |pixel: [u32; 2]| {
        let way = reference.way(&camera, SIZE, pixel);
        let hit = way.hit?.distance;
        let Projection::Perspective { fov_y, .. } = camera.projection else { panic!("{asset}: a perspective camera") };
        let footprint = hit * 2.0 * (0.5 * fov_y).tan() / f64::from(SIZE[1]);
        Some(marches.follow(&way, settings).distance.map(|distance| (distance - hit).abs() / footprint))
    };
    pixels.filter_map(error).collect()
}

#[test]
fn with_steps_enough_every_march_comes_to_the_true_hit() {
    for asset in ["torus.gltf", "suzanne.gltf", "stability_seams.gltf"] {
        let steps = Settings { min_steps: 2048, max_steps: 2048, refine_steps: 40, ..Settings::default() };
        for march in [March::Pom, March::Relief, March::Secant, March::Contact, March::Cone] {
            let tolerance = 1e-9;
            let found = errors(asset, &Settings { march, tolerance, ..steps.clone() });
            assert!(found.len() > 100, "{asset}: {}", found.len());
            // Cones follow chords that stray an eighth of a texel from the path.
            let room = if march == March::Cone { 0.25 } else { 0.02 };
            let off = found.iter().filter(|error| error.is_none_or(|error| error > room)).count();
            assert!(off * 100 <= found.len(), "{asset}, {march}: {off} of {}", found.len());
        }
    }
}

#[test]
fn fewer_steps_are_further_off_and_fewer() {
    let mean = |steps: u32| {
        let found = errors(
            "torus.gltf",
            &Settings { march: March::Steep, min_steps: steps, max_steps: steps, ..Settings::default() },
        );
        let near: Vec<f64> = found.into_iter().flatten().filter(|error| *error < 5.0).collect();
        near.iter().sum::<f64>() / near.len() as f64
    };
    let [coarse, fine] = [8, 64].map(mean);
    // A first sample beyond the field is half a step late on the mean.
    assert!(coarse > 5.0 * fine && coarse < 12.0 * fine, "{coarse}, {fine}");
}
