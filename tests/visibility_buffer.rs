//! Walks that begin at the lids of a visibility buffer draw the same frame, to the bit, as lids that trace where they are
//! rasterised; and each pixel's ray is traced once but where it leaves a shell unhit.

mod rig;

use glam::{DAffine3, DVec3};
use prism_engine::{
    gpu::Feature as F,
    render::{plan, variant::Pass},
    scene::{Camera, Scene},
    settings::{March, PrismCulling, SelfShadow, Settings, Shell, Stage, VisibilityBuffer},
};
use rig::{Rig, same_bits};

const EXTENT: [u32; 2] = [96, 54];

/// Draws with and without; the walks must really have begun at it.
#[track_caller]
fn nothing_changes(rig: &Rig, scene: &Scene, settings: &Settings, camera: &Camera) {
    let [with, without] = [VisibilityBuffer::On, VisibilityBuffer::Off].map(|visibility_buffer| {
        let mut easel = rig.easel(scene, &Settings { visibility_buffer, ..settings.clone() }, EXTENT);
        let frame = easel.draw(camera);
        if settings.prism_culling == PrismCulling::Auto {
            easel.assert_stage(settings.stage);
        }
        (frame, easel.passes(camera), easel.picture(camera))
    });
    let writes = |passes: &[String]| passes.iter().filter(|name| *name == "visibility").count();
    assert_eq!([writes(&with.1), writes(&without.1)], [1, 0], "{:?}", with.1);
    let seen = without.0.depth.iter().filter(|z| z.is_finite()).count();
    assert!(6 * seen > without.0.depth.len(), "{seen} pixels show something");
    assert!(same_bits(&with.0, &without.0), "{} {}", settings.stage, settings.march);
    assert!(with.2 == without.2, "{} {}: the picture", settings.stage, settings.march);
}

fn walk(stage: Stage, march: March) -> Settings {
    Settings { march, ..rig::exact(Shell::Walk, stage) }
}

/// Holes in silhouettes, needles, seams with steps, open borders beside lids, a plain ball through a shell, and two stages.
#[test]
fn the_frame_is_the_same_to_the_bit() {
    let rig = Rig::new();
    for (name, stage, march) in [
        ("torus.gltf", Stage::Mesh, March::Relief),
        ("suzanne.gltf", Stage::Geometry, March::Relief),
        ("stability_needles.gltf", Stage::Mesh, March::Pom),
        ("stability_seams.gltf", Stage::Geometry, March::Exact),
        ("stability_slivers.gltf", Stage::Geometry, March::Relief),
        ("prism_shell.gltf", Stage::Mesh, March::Relief),
    ] {
        let scene = rig::asset(name);
        nothing_changes(&rig, &scene, &walk(stage, march), &scene.camera.expect("the file has one"));
    }
}

/// A shell within another's: what the nearest lid's ray meets may lie behind what a later lid's does.
#[test]
fn shells_that_cut_through_each_other_hide_each_other_as_ever() {
    let rig = Rig::new();
    let mut scene = rig::asset("torus.gltf");
    let mut second = scene.instances[0].clone();
    second.transform = DAffine3::from_translation(DVec3::new(0.07, 0.05, 0.1)) * second.transform;
    let mut mirrored = scene.instances[0].clone();
    mirrored.transform = DAffine3::from_scale(DVec3::new(-1.0, 1.1, 1.0)) * mirrored.transform;
    scene.instances.extend([second, mirrored]);
    for stage in [Stage::Mesh, Stage::Geometry] {
        nothing_changes(&rig, &scene, &walk(stage, March::Relief), &scene.camera.unwrap());
    }
}

/// The near plane cuts lids; bases are drawn beside them.
#[test]
fn it_holds_from_inside_a_shell() {
    let rig = Rig::new();
    let scene = rig::asset("stability_inside.gltf");
    for stage in [Stage::Mesh, Stage::Geometry] {
        nothing_changes(&rig, &scene, &walk(stage, March::Relief), &scene.camera.unwrap());
    }
}

/// With prisms dropped outside the view, with shadow rays, and beside LOD fades.
#[test]
fn it_goes_with_culling_shadows_and_fades() {
    let rig = Rig::asking(&[F::TaskShader, F::MeshShader, F::GeometryShader, F::FragmentStoresAndAtomics]);
    let scene = rig::asset("torus.gltf");
    let camera = scene.camera.unwrap();
    for stage in [Stage::Mesh, Stage::Geometry] {
        let culled = Settings { prism_culling: PrismCulling::View, ..walk(stage, March::Relief) };
        nothing_changes(&rig, &scene, &culled, &camera);
    }
    let shadowed = Settings { self_shadow: SelfShadow::Hard, ..walk(Stage::Mesh, March::Pom) };
    nothing_changes(&rig, &scene, &shadowed, &camera);
    let fading = Settings { lod_fade: Some(-3.0), ..walk(Stage::Mesh, March::Pom) };
    let [with, without] = [VisibilityBuffer::On, VisibilityBuffer::Off].map(|visibility_buffer| {
        let settings = Settings { visibility_buffer, ..fading.clone() };
        rig.try_easel_with(&scene, &settings, EXTENT, false).expect("a renderer").picture(&camera)
    });
    assert!(with == without, "faded");
}

/// Auto takes it where triangles are many, and never where a frame draws what it has no place for.
#[test]
fn by_default_shells_of_many_prisms_have_it() {
    let named = |name: &str, settings: &Settings| {
        let plan = plan::plan(&rig::asset(name), settings, Stage::Mesh, false);
        let named = plan.draws.iter().filter_map(|draw| draw.visibility);
        named.inspect(|variant| assert_eq!(variant.pass, Pass::Visibility)).count()
    };
    let walk = Settings { shell: Shell::Walk, ..Settings::default() };
    assert_eq!(named("torus.gltf", &walk), 1);
    assert_eq!(named("cube.gltf", &walk), 0);
    assert_eq!(named("cube.gltf", &Settings { visibility_buffer: VisibilityBuffer::On, ..walk.clone() }), 1);
    for without in [
        Settings { shell: Shell::Prism, ..walk.clone() },
        Settings { msaa: 4, ..walk.clone() },
        Settings { keep_all: true, ..walk.clone() },
        Settings { prism_culling: PrismCulling::Hidden, ..walk.clone() },
        Settings { visibility_buffer: VisibilityBuffer::Off, ..walk.clone() },
    ] {
        assert_eq!(named("torus.gltf", &without), 0);
    }
}
