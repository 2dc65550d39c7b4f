//! Ambient light and its occlusion, as drawn.

#[path = "rig/mod.rs"]
mod rig;

use glam::{DQuat, DVec3};
use prism_engine::{
    aov::Aov,
    scene::{Ambient, Camera, Material, Scene},
    settings::{March, Settings, Shell, Stage},
};
use rig::Rig;

const EXTENT: [u32; 2] = [160, 90];

/// An asset lit by `ambient` alone.
fn unlit(name: &str, ambient: Ambient) -> (Scene, Camera) {
    let mut scene = rig::asset(name).with_defaults(f64::from(EXTENT[0]) / f64::from(EXTENT[1]));
    scene.lights.clear();
    scene.ambient = ambient;
    let camera = scene.camera.expect("the scene's own");
    (scene, camera)
}

/// Both shells, both stages, and the base surface.
fn looks() -> [Settings; 3] {
    let off = Settings { shell: Shell::Off, march: March::Exact, ..Settings::default() };
    [rig::exact(Shell::Prism, Stage::Geometry), rig::exact(Shell::Walk, Stage::Mesh), off]
}

#[test]
fn a_surface_takes_the_irradiance_of_the_direction_it_faces() {
    let coefficients = [
        [1.9, 2.1, 2.4],
        [0.5, 0.4, 0.6],
        [-0.3, 0.2, 0.1],
        [0.4, -0.2, 0.3],
        [0.1, -0.15, 0.2],
        [-0.2, 0.1, 0.12],
        [0.25, 0.05, -0.1],
        [-0.12, 0.2, 0.06],
        [0.15, -0.1, 0.22],
    ];
    let turn = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, 2.0) / 3.0, 1.0);
    let ambient = Ambient::from_irradiance(&coefficients.map(DVec3::from), turn);
    let (mut scene, camera) = unlit("plane.gltf", ambient);
    for material in &mut scene.materials {
        // White and without textures: what comes back is the irradiance times 1 + 0.04.
        *material = Material { displacement: material.displacement, metallic: 0.0, ..Material::default() };
    }
    let rig = Rig::new();
    for settings in looks() {
        let mut easel = rig.easel(&scene, &settings, EXTENT);
        let aov = easel.draw(&camera);
        let mut count = 0;
        for i in (0..aov.depth.len()).filter(|i| aov.depth[*i].is_finite()) {
            let expected = 1.04 * ambient.irradiance(DVec3::from(aov.normal[i].map(f64::from)));
            let found = DVec3::from(aov.color[i].map(f64::from));
            // The plane has no walls, and no vertex normal but its own: its shading normal is the surface's.
            assert!(found.abs_diff_eq(expected, 2e-4), "{settings:?} pixel {i}: {found} for {expected}");
            count += 1;
        }
        assert!(count > 3000, "{count} pixels");
    }
}

#[test]
fn occlusion_dims_the_joints_and_moves_nothing() {
    let (scene, camera) = unlit("torus.gltf", Ambient::default());
    let rig = Rig::new();
    for settings in looks() {
        let draw = |ambient_occlusion: bool| -> Aov {
            let settings = Settings { ambient_occlusion, ..settings.clone() };
            let mut easel = rig.easel(&scene, &settings, EXTENT);
            if settings.shell != Shell::Off {
                easel.assert_stage(settings.stage);
            }
            easel.draw(&camera)
        };
        let (open, dimmed) = (draw(false), draw(true));
        assert!(rig::same_bits(&Aov { color: open.color.clone(), ..dimmed.clone() }, &open), "{settings:?}");
        // Light left, low down and high up.
        let mut left = [[0.0, 0.0]; 2];
        for i in (0..open.depth.len()).filter(|i| open.depth[*i].is_finite()) {
            let (before, after) = (open.color[i][1], dimmed.color[i][1]);
            assert!(after <= before * 1.0001, "{settings:?} pixel {i}: {before} to {after}");
            let height = open.height_at_hit[i];
            if !(0.3..=0.7).contains(&height) {
                let sum = &mut left[usize::from(height > 0.7)];
                *sum = [sum[0] + before, sum[1] + after];
            }
        }
        let [low, high] = left.map(|[before, after]| after / before);
        println!("{} {}: {low:.2} of the light is left low down, {high:.2} high up", settings.shell, settings.stage);
        assert!(low < 0.8 && high > 0.85, "{settings:?}: {low} and {high}");
    }
}

#[test]
fn what_is_not_asked_for_is_not_in_the_code() {
    let (scene, _) = unlit("torus.gltf", Ambient::default());
    let rig = Rig::new();
    for ambient_occlusion in [false, true] {
        let settings = Settings { ambient_occlusion, ..rig::exact(Shell::Walk, Stage::Mesh) };
        let easel = rig.easel(&scene, &settings, EXTENT);
        let bound = easel
            .shell_shaders()
            .iter()
            .any(|shader| shader.reflection.bindings.iter().any(|binding| binding.name == "ambient_occlusion_map"));
        assert_eq!(bound, ambient_occlusion);
    }
}
