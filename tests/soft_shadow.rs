//! Soft self-shadow against the f64 reference, which measures the same clearances densely: in both shells, by the exact
//! march and by steps, and on the base surface.

mod rig;

use glam::DVec3;
use prism_engine::{
    aov::Aov,
    render::plan,
    scene::{Camera, Light, Mesh, Scene},
    settings::{March, SelfShadow, Settings, Shell, Stage},
    shell::reference::{Reference, Shadows},
};
use rig::{
    Rig, SHELLS,
    lights::{SUNS, lit_by, near_lights, sun},
};

/// Pixels of every picture.
const SIZE: [u32; 2] = [96, 54];

/// Tangent of the lights' angular radius.
const SOFTNESS: f64 = 0.05;

/// A difference that is seen: 2 % of the light.
const SEEN: f32 = 0.02;

fn soft(settings: Settings) -> Settings {
    Settings { self_shadow: SelfShadow::Soft, shadow_softness: SOFTNESS as f32, ..settings }
}

fn truth(scene: &Scene, light: Light, camera: &Camera) -> Aov {
    let shadows = Shadows::TraceOwnSoft { softness: SOFTNESS };
    Reference::new(&lit_by(scene, light)).render(camera, SIZE[0], SIZE[1], shadows)
}

/// How far what is seen of the light differs over the pixels that `counts` takes of those that both cover.
struct Difference {
    /// Pixels, and those of them that see a part of the light.
    counted: usize,
    penumbra: usize,
    mean: f64,
    /// Share of the pixels that is off by more than [`SEEN`].
    seen: f64,
}

impl Difference {
    fn new(name: &str, test: &Aov, truth: &Aov, counts: impl Fn(usize) -> bool) -> Difference {
        let both = |i: &usize| test.depth[*i].is_finite() && truth.depth[*i].is_finite() && counts(*i);
        let counted: Vec<usize> = (0..truth.depth.len()).filter(both).collect();
        let off = |i: &usize| (test.shadow[*i] - truth.shadow[*i]).abs();
        let share = |n: f64| n / counted.len().max(1) as f64;
        let difference = Difference {
            counted: counted.len(),
            penumbra: counted.iter().filter(|i| truth.shadow[**i] > 0.0 && truth.shadow[**i] < 1.0).count(),
            mean: share(counted.iter().map(|i| f64::from(off(i))).sum()),
            seen: share(counted.iter().filter(|i| off(i) > SEEN).count() as f64),
        };
        let Difference { counted, penumbra, mean, seen } = &difference;
        println!(
            "{name}: {counted} pixels, {penumbra} see a part; off by {mean:.1e} in the mean, {seen:.1e} by over 2 %"
        );
        difference
    }
}

/// Both shells see as much of each light as the reference does, to `most` in the mean and as the share that is seen.
fn assert_seen_alike(of: &str, scene: &Scene, lights: &[(String, Light)], most: [f64; 2]) {
    let rig = Rig::new();
    let camera = scene.camera.expect("the assets have cameras");
    let truths: Vec<_> = lights.iter().map(|&(_, light)| truth(scene, light, &camera)).collect();
    for (shell, stage) in SHELLS.into_iter().zip(rig::STAGES) {
        let mut easel = rig.easel(&lit_by(scene, lights[0].1), &soft(rig::exact(shell, stage)), SIZE);
        easel.assert_stage(stage);
        for ((name, light), truth) in lights.iter().zip(&truths) {
            easel.set_light(*light);
            let test = easel.draw(&camera);
            let off = Difference::new(&format!("{of} {shell} {name}"), &test, truth, |_| true);
            assert!(off.counted > 2000 && off.penumbra > 20);
            assert!(off.mean < most[0] && off.seen < most[1]);
            assert_eq!(easel.limits_reached(), 0);
        }
    }
}

/// Across the torus's triangles, for every kind of light. The penumbrae of 2,304 triangles could not agree with the
/// reference's if they ended at their borders.
#[test]
fn the_torus_sees_as_much_of_every_kind_of_light_as_the_reference_does() {
    let scene = rig::asset("torus.gltf");
    let mut lights = SUNS.map(|at| (format!("{}°", at[0]), sun(at))).to_vec();
    lights.extend(near_lights(DVec3::new(0.6, 0.9, 0.3)).map(|(name, light)| (name.to_owned(), light)));
    assert_seen_alike("torus", &scene, &lights, [1e-3, 1e-2]);
}

/// Heights that are functions: round, so that next to each point nothing but its own tangent plane hides the disc.
#[test]
fn under_functions_as_much_is_seen_as_by_the_reference() {
    let mut scene = rig::asset("procedural.gltf");
    // What nothing displaces has no shadow of its own.
    let displaced = |mesh: &Mesh| mesh.primitives.iter().any(|p| p.displacement_scale != 0.0);
    scene.instances.retain(|instance| displaced(&scene.meshes[instance.mesh]));
    let lights = [("the file's".to_owned(), scene.lights[0]), ("25°".to_owned(), sun([25.0, 40.0]))];
    assert_seen_alike("functions", &scene, &lights, [1e-4, 1e-3]);
}

/// Cobbles on two triangles: the walk by steps, and the base surface, away from the borders that it does not know.
#[test]
fn steps_see_nearly_as_much() {
    let rig = Rig::new();
    let scene = rig::asset("self_shadow.gltf");
    let camera = scene.camera.expect("the assets have cameras");
    let light = scene.lights[0];
    let truth = truth(&scene, light, &camera);
    let eye = camera.transform.translation;
    let base = soft(Settings { shadow_steps: Some(256), march: March::Relief, ..Settings::default() });
    for (shell, most) in [(Shell::Walk, [0.01, 0.05]), (Shell::Off, [0.01, 0.08])] {
        let test = rig.easel(&scene, &Settings { shell, max_steps: 256, ..base.clone() }, SIZE).draw(&camera);
        let inside = |i: usize| {
            let at = DVec3::from_array(truth.position[i].map(f64::from));
            at.x.abs() < 0.5 && at.z.abs() < 0.5 && (test.depth[i] / truth.depth[i] - 1.0).abs() < 1e-3 && at != eye
        };
        let off = Difference::new(&format!("cobbles {shell}"), &test, &truth, inside);
        assert!(off.counted > 500 && off.penumbra > 50);
        assert!(off.mean < most[0] && off.seen < most[1]);
    }
}

/// The same code draws both, to the last define.
#[test]
fn a_light_without_size_casts_hard_shadows() {
    for (name, shell) in [("torus", Shell::Walk), ("torus", Shell::Prism), ("plane", Shell::Off)] {
        let scene = rig::asset(&format!("{name}.gltf"));
        let drawn = |self_shadow, shadow_softness| {
            let settings = Settings { shell, self_shadow, shadow_softness, ..Settings::default() };
            let plan = plan::plan(&scene, &settings, Stage::Mesh, true);
            (plan.draws.iter().map(|draw| draw.variant).collect::<Vec<_>>(), plan.primitives[0].headroom)
        };
        let hard = drawn(SelfShadow::Hard, 0.3);
        assert_eq!((drawn(SelfShadow::Soft, 0.0), hard.1), (hard.clone(), 0.0));
        assert_ne!(drawn(SelfShadow::Soft, 0.3).0, hard.0);
    }
}
