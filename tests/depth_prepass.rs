//! A depth pre-pass changes nothing in a frame, to the bit: the trace that draws the depth and the one that is shaded agree.

mod rig;

use prism_engine::{
    render::{
        plan::{self, Draw},
        variant::Pass,
    },
    scene::{DepthOffset, Scene},
    settings::{DepthPrepass, March, Settings, Shell, Stage},
};
use rig::{Rig, same_bits};

const EXTENT: [u32; 2] = [96, 54];

/// Draws with a pre-pass of all draws and without one. Returns how many draws have their depth drawn first.
#[track_caller]
fn nothing_changes(rig: &Rig, scene: &Scene, settings: &Settings) -> usize {
    let [with, without] = [DepthPrepass::On, DepthPrepass::Off].map(|depth_prepass| {
        let mut easel = rig.easel(scene, &Settings { depth_prepass, ..settings.clone() }, EXTENT);
        let first = easel.plan().draws.iter().filter_map(|draw| draw.depth).collect::<Vec<_>>();
        assert!(first.iter().all(|variant| variant.pass == Pass::Depth));
        (easel.draw(&scene.camera.unwrap()), first.len(), easel.plan().draws.len())
    });
    assert_eq!((with.1, without.1), (with.2, 0), "every draw, or none");
    let seen = without.0.depth.iter().filter(|z| z.is_finite()).count();
    assert!(3 * seen > without.0.depth.len(), "{seen} pixels show something");
    assert!(same_bits(&with.0, &without.0), "{} {} {}", settings.shell, settings.stage, settings.march);
    with.1
}

#[test]
fn shells_shade_where_their_own_depth_stands() {
    let rig = Rig::new();
    let scene = rig::asset("torus.gltf");
    for (shell, stage, march) in
        [(Shell::Walk, Stage::Mesh, March::Relief), (Shell::Prism, Stage::Geometry, March::Exact)]
    {
        let draws = nothing_changes(&rig, &scene, &Settings { march, ..rig::exact(shell, stage) });
        assert_eq!(draws, if shell == Shell::Walk { 2 } else { 1 });
    }
}

/// Also where depth is moved, dithered, or cut out by alphaMode MASK.
#[test]
fn base_surfaces_shade_where_their_own_depth_stands() {
    let rig = Rig::new();
    let mut scene = rig::asset("depth_offset.gltf");
    for (i, material) in scene.materials.iter_mut().enumerate() {
        material.alpha_cutoff = Some(0.5);
        material.depth_offset = material.displacement.is_none().then_some(DepthOffset { distance: 0.1, dither: i > 0 });
    }
    for (march, depth_offset) in [(March::Relief, true), (March::Pom, false), (March::Normal, true)] {
        nothing_changes(&rig, &scene, &Settings { shell: Shell::Off, march, depth_offset, ..Settings::default() });
    }
}

/// What auto draws first is what needs no fragment shader for it, and not a single draw alone.
#[test]
fn by_default_several_plain_surfaces_draw_their_depth_first() {
    let firsts = |name: &str, settings: &Settings| {
        let plan = plan::plan(&rig::asset(name), settings, Stage::Mesh, false);
        let shell = |draw: &&Draw| draw.variant.geometry.stage().is_some();
        assert!(plan.draws.iter().filter(shell).all(|draw| draw.depth.is_none() && !draw.variant.depth_stands));
        let first = plan.draws.iter().filter_map(|draw| draw.depth);
        first.inspect(|depth| assert_eq!(depth.shaders().len(), 1)).count()
    };
    let parallax = Settings { shell: Shell::Off, march: March::Normal, ..Settings::default() };
    assert!(firsts("shadows.gltf", &Settings::default()) > 1);
    assert!(firsts("shadows.gltf", &parallax) > 3);
    assert_eq!(firsts("torus.gltf", &parallax), 0);
    assert_eq!(
        firsts("shadows.gltf", &Settings { march: March::Relief, depth_offset: true, ..parallax.clone() }),
        firsts("shadows.gltf", &Settings::default())
    );
    assert_eq!(firsts("shadows.gltf", &Settings { depth_prepass: DepthPrepass::Off, ..parallax }), 0);
}
