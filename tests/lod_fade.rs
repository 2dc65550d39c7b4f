//! The heights of far shells fade: the picture changes no more from step to step than without, until it is the plain one.

mod rig;

use glam::DVec3;
use prism_engine::{
    scene::{Camera, Scene},
    settings::{March, SelfShadow, Settings, Shell},
};
use rig::{Rig, STAGES, asset};

const SIZE: [u32; 2] = [96, 72];
/// Degrees.
const FOV_Y: f64 = 30.0;
/// Levels of the ring's shell, of both directions.
const THICKNESS: f64 = 0.08;
/// The fade ends where the shell is a pixel thick.
const START: f32 = -1.0;

/// Along one direction toward the ring, from where its shell spans `pixels`.
fn camera(scene: &Scene, pixels: f64) -> Camera {
    let pixel = 2.0 * (0.5 * FOV_Y.to_radians()).tan() / f64::from(SIZE[1]);
    let eye = DVec3::new(0.3, 0.75, 0.55).normalize() * (THICKNESS / (pixels * pixel));
    let camera = scene.camera.expect("the scene has a camera");
    camera.overridden(Some(eye), Some(DVec3::ZERO), Some(FOV_Y)).expect("a perspective")
}

/// The greatest difference of a channel.
fn change(a: &[u8], b: &[u8]) -> u8 {
    a.iter().zip(b).map(|(a, b)| a.abs_diff(*b)).max().expect("pixels")
}

/// Near, along the fade, and far.
#[track_caller]
fn fades(rig: &Rig, scene: &Scene, settings: &Settings) {
    let fading = Settings { lod_fade: Some(START), ..settings.clone() };
    let plain = Settings { shell: Shell::Off, march: March::None, ..settings.clone() };
    let [mut faded, mut whole, mut plain] =
        [&fading, settings, &plain].map(|s| rig.try_easel_with(scene, s, SIZE, false).expect("a renderer"));
    let label = format!("{} {} {}", settings.shell, settings.march, settings.stage);

    // The box of the ring reaches a good part of the way to it.
    let near = camera(scene, 8.0);
    assert!(faded.picture(&near) == whole.picture(&near), "{label}: near by it is the shell, to the bit");
    for pixels in [0.7, 0.4] {
        let far = camera(scene, pixels);
        assert!(faded.picture(&far) == plain.picture(&far), "{label}: far away it is the plain surface, to the bit");
        assert!(change(&faded.picture(&far), &whole.picture(&far)) > 8, "{label}: which differs from the shell");
    }

    // A dolly through all of it: each step is a twenty-third of the distance.
    let steps: Vec<_> = (0..24).map(|i| camera(scene, 2.4 * 2f64.powf(f64::from(i) / -16.0))).collect();
    let mut changes = [&mut faded, &mut whole].map(|easel| {
        let pictures: Vec<_> = steps.iter().map(|camera| easel.picture(camera)).collect();
        pictures.windows(2).map(|pair| change(&pair[0], &pair[1])).collect::<Vec<_>>()
    });
    changes.iter_mut().for_each(|changes| changes.sort_unstable());
    let [with, without] = changes.map(|changes| *changes.last().expect("steps"));

    // Nor does it jump where one way to draw gives over to another, where the camera hardly moves: but for a pixel or two
    // at an edge, whose centre the rasteriser's grid puts on its other side. Such a one changes no more than from there to
    // the pixel beside it.
    let jumps = [(&mut whole, 8.0, 1.2), (&mut plain, 0.4, 2.4)].map(|(other, mut same, mut differs)| {
        for _ in 0..24 {
            let middle = camera(scene, 0.5 * (same + differs));
            if faded.picture(&middle) == other.picture(&middle) {
                same = 0.5 * (same + differs);
            } else {
                differs = 0.5 * (same + differs);
            }
        }
        let [before, after] = [same, differs].map(|pixels| faded.picture(&camera(scene, pixels)));
        let pixel = |picture: &[u8], i: usize| <[u8; 4]>::try_from(&picture[4 * i..4 * i + 4]).expect("four channels");
        let jumps: Vec<usize> =
            (0..before.len() / 4).filter(|&i| change(&pixel(&before, i), &pixel(&after, i)) > 6).collect();
        for &i in &jumps {
            let width = SIZE[0] as usize;
            let beside = [i - width, i - 1, i + 1, i + width].map(|j| change(&pixel(&before, i), &pixel(&before, j)));
            let jump = change(&pixel(&before, i), &pixel(&after, i));
            assert!(beside.iter().any(|edge| edge + 6 >= jump), "{label}: pixel {i} jumps by {jump} and is at no edge");
        }
        jumps.len()
    });
    println!(
        "{label}: from step to step {with} with the fade, {without} without; {jumps:?} pixels jump at the switches"
    );
    assert!(with <= without.saturating_add(4), "{label}: it pops: {with} beside {without}");
    assert!(jumps.iter().all(|jump| *jump <= 2), "{label}: {jumps:?} pixels jump");
}

#[test]
fn shells_fade_without_a_pop() {
    let rig = Rig::new();
    let scene = asset("torus.gltf");
    for (shell, stage) in [(Shell::Prism, STAGES[0]), (Shell::Walk, STAGES[1])] {
        fades(&rig, &scene, &Settings { shell, stage, march: March::Relief, ..Settings::default() });
    }
}

/// With rays toward the light, whose shadows fade too, and in each stage with the other shell.
#[test]
#[ignore = "lavapipe compiles a walk with self-shadow for half a minute: tests/run figures"]
fn every_shell_fades_in_each_stage() {
    let rig = Rig::new();
    let scene = asset("torus.gltf");
    for (shell, stage) in [(Shell::Prism, STAGES[1]), (Shell::Walk, STAGES[0])] {
        let settings = Settings { shell, stage, ..Settings::default() };
        fades(&rig, &scene, &settings);
        fades(&rig, &scene, &Settings { self_shadow: SelfShadow::Hard, march: March::Relief, ..settings });
    }
}
