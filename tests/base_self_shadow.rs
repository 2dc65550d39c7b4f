//! Self-shadow on a base surface by every march, against the f64 reference's light visibility of the point that is shaded:
//! that of the field at the hit's coordinates, where a march's own error has no say.

mod rig;

use std::f64::consts::FRAC_PI_2;

use glam::{DAffine3, DQuat, DVec3};
use prism_engine::{
    aov::Aov,
    scene::{Camera, HeightSource, Procedure, Projection, Scene},
    settings::{March, SelfShadow, Settings, Shell},
    shell::reference::{Reference, Shadows},
};
use rig::{
    Rig,
    lights::{lit_by, sun},
};

/// Pixels of every picture.
const SIZE: [u32; 2] = [64, 36];

/// The sheet is so many times as wide as the part that is judged: what its borders would do to a low sun's rays is not
/// the tangent plane's to know.
const ROOM: f32 = 8.0;

/// Elevation and azimuth, degrees.
const SUNS: [[f64; 2]; 3] = [[90.0, 0.0], [35.0, 70.0], [6.0, 310.0]];

/// A difference that is seen: 2 % of the light.
const SEEN: f32 = 0.02;

/// Steps toward the surface: few enough that a march by steps alone ends well below it. And toward the light.
const STEPS: u32 = 16;
const SHADOW_STEPS: u32 = 256;

/// Tangent of the soft suns' angular radius.
const SOFTNESS: f64 = 0.05;

/// Marches that look at nothing but heights, and what a height map has besides.
const MARCHES: [March; 6] = [March::Steep, March::Pom, March::Contact, March::Secant, March::Relief, March::Exact];
const CONES: [March; 2] = [March::RelaxedCone, March::Cone];

/// Flat bricks, two units a repeat, level 0 at the top.
fn floor(heights: Option<Procedure>) -> Scene {
    let mut scene = rig::asset("plane.gltf");
    let primitive = &mut scene.meshes[0].primitives[0];
    primitive.positions.iter_mut().for_each(|p| *p *= ROOM);
    primitive.uvs[0].iter_mut().for_each(|uv| *uv = 0.5 + ROOM * (*uv - 0.5));
    if let Some(procedure) = heights {
        let displacement = scene.materials[primitive.material].displacement.as_mut().expect("displaced");
        displacement.source = HeightSource::Procedure(procedure);
    }
    scene
}

/// How much of the light the reference sees from the field at a pixel's coordinates, found from straight above.
fn truth(reference: &Reference, uv: [f32; 2], shadows: Shadows) -> f32 {
    let [x, z] = uv.map(|c| 2.0 * f64::from(c) - 1.0);
    let transform = DAffine3::from_rotation_translation(DQuat::from_rotation_x(-FRAC_PI_2), DVec3::new(x, 1.0, z));
    let projection = Projection::Orthographic { y_mag: 1.0, near: 0.1, far: 10.0 };
    let seen = reference.render(&Camera { transform, projection }, 1, 1, shadows);
    assert!(seen.uv[0].iter().zip(uv).all(|(a, b)| (a - b).abs() < 1e-6), "{:?} for {uv:?}", seen.uv[0]);
    seen.shadow[0]
}

/// Shares of the pixels near the middle that see less of the light than the reference by over [`SEEN`] of it, and more.
fn off(test: &Aov, reference: &Reference, shadows: Shadows) -> [f64; 2] {
    let near = |i: &usize| test.depth[*i].is_finite() && test.position[*i].iter().all(|c| c.abs() < 2.0);
    let pixels: Vec<usize> = (0..test.depth.len()).filter(near).collect();
    assert!(pixels.len() > 1500, "{} pixels", pixels.len());
    let off: Vec<f32> = pixels.iter().map(|&i| test.shadow[i] - truth(reference, test.uv[i], shadows)).collect();
    [-1.0, 1.0].map(|side| off.iter().filter(|off| side * **off > SEEN).count() as f64 / off.len() as f64)
}

/// Insists that no march makes the point darker than it is, and that steps toward the light pass over few crests.
fn judge(name: &str, scene: &Scene, marches: &[March]) {
    let rig = Rig::new();
    let camera = scene.camera.expect("the asset has a camera");
    let references = SUNS.map(|at| Reference::new(&lit_by(scene, sun(at))));
    for (self_shadow, shadows) in
        [(SelfShadow::Hard, Shadows::TraceOwn), (SelfShadow::Soft, Shadows::TraceOwnSoft { softness: SOFTNESS })]
    {
        // How soft a shadow is does not depend on how the point was found.
        let softens = |march: &March| matches!(march, March::Steep | March::Pom | March::Exact);
        for &march in marches.iter().filter(|march| self_shadow == SelfShadow::Hard || softens(march)) {
            let settings = Settings {
                shell: Shell::Off,
                march,
                min_steps: STEPS,
                max_steps: if march.reads_cones() { 256 } else { STEPS },
                refine_steps: march.usual_refine_steps(),
                self_shadow,
                shadow_softness: SOFTNESS as f32,
                shadow_steps: Some(SHADOW_STEPS),
                ..Settings::default()
            };
            let mut easel = rig.easel(&lit_by(scene, sun(SUNS[0])), &settings, SIZE);
            for (at, reference) in SUNS.into_iter().zip(&references) {
                easel.set_light(sun(at));
                let [darker, lighter] = off(&easel.draw(&camera), reference, shadows);
                println!("{name} {self_shadow} {march} {}°: {darker:.1e} darker, {lighter:.1e} lighter", at[0]);
                assert!(darker <= 2e-3, "{darker}");
                // A crest between two steps hides a part of a disc more often than all of it.
                assert!(lighter <= if self_shadow == SelfShadow::Hard { 1e-2 } else { 6e-2 }, "{lighter}");
            }
        }
    }
}

#[test]
fn no_march_darkens_a_height_map() {
    judge("map", &floor(None), &[&MARCHES[..], &CONES].concat());
}

#[test]
fn no_march_darkens_a_function() {
    judge("bricks", &floor(Some(Procedure::Bricks)), &MARCHES);
}
