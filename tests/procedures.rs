//! Procedural heights: the GLSL against its f64 twin, and the exact march under them against the reference.

mod rig;

use glam::{DAffine2, DVec2};
use prism_engine::{
    aov::Aov,
    gpu::{
        Access, Binding, Buffer, BufferDesc, Context, ContextDesc, DescriptorSet, MemoryLocation, Pipeline,
        ShaderStage, Uploader, run_once, vk,
    },
    measure::Metrics,
    render::{self, variant::procedure_define},
    scene::{self, HeightSource, Material, Primitive, Procedure, Scene, Wrap},
    settings::{March, Settings, Shell},
    shell::reference::{Reference, Shadows},
};
use rig::{
    Rig, SHELLS, STAGES,
    exactness::{self, DEPTH_P99},
    random::Random,
};

/// Boxes of each procedure.
const BOXES: usize = 1 << 15;
/// Invocations of a workgroup of the shader.
const GROUP: u32 = 64;
/// What f32 may be off, where |uv| is at most 2; the heights' slopes are up to 100.
const HEIGHT_ERROR: f64 = 1e-6;
/// Share of a slope of 1 in the whole range.
const GRADIENT_ERROR: f64 = 1e-4;

/// Boxes of all sizes, low and high corner, each side by itself; a few are points.
fn boxes() -> Vec<[f32; 4]> {
    let mut random = Random(1);
    let mut side = |low: f32| {
        let size = if random.next() < 0.05 { 0.0 } else { (-24.0 * random.next()).exp2() };
        (low + size as f32).min(2.0)
    };
    let mut place = Random(2);
    (0..BOXES)
        .map(|_| {
            let low = [0, 1].map(|_| (4.0 * place.next() - 2.0) as f32);
            [low[0], low[1], side(low[0]), side(low[1])]
        })
        .collect()
}

/// Height and gradient at a box's low corner, the least of a grid in it less the bounds' slope, the bounds over it and
/// their slope, the greatest of the grid, and three words of padding.
type Answer = [f32; 12];

fn ask(procedure: Procedure, boxes: &[[f32; 4]]) -> Vec<Answer> {
    let ctx = Context::new(&ContextDesc { app: "prism tests", ..ContextDesc::default() }).expect("a device");
    let shaders = std::env::var_os("PRISM_SHADERS");
    let mut compiler = render::shader_compiler(shaders.as_deref().map(std::path::Path::new)).expect("a compiler");
    compiler.provide("tests/procedures.comp", include_str!("rig/procedures.comp").to_owned());
    let shader = compiler.compile("tests/procedures.comp", ShaderStage::Compute, &[procedure_define(procedure)]);
    let pipeline = Pipeline::compute(&ctx, procedure.name(), &shader.unwrap_or_else(|error| panic!("{error}")));
    let pipeline = pipeline.expect("a pipeline");
    let mut uploader = Uploader::new(&ctx).expect("an uploader");
    let from = uploader.buffer("boxes", vk::BufferUsageFlags::STORAGE_BUFFER, boxes).expect("a buffer");
    uploader.finish().expect("uploaded");
    let desc = BufferDesc {
        name: "answers",
        size: (boxes.len() * size_of::<Answer>()) as u64,
        usage: vk::BufferUsageFlags::STORAGE_BUFFER,
        location: MemoryLocation::GpuToCpu,
    };
    let to = Buffer::new(&ctx, &desc).expect("a buffer");
    let bindings = [("boxes", Binding::Buffer(&from)), ("results", Binding::Buffer(&to))];
    let set = DescriptorSet::new(&ctx, &pipeline, 0, &bindings).expect("a set");
    run_once(&ctx, |cmd| {
        cmd.bind_pipeline(&pipeline);
        cmd.bind_set(&pipeline, 0, &set);
        cmd.dispatch((boxes.len() as u32).div_ceil(GROUP), 1, 1);
        cmd.buffer_barrier(&to, Access::COMPUTE_WRITE, Access::HOST_READ);
        Ok(())
    })
    .expect("run");
    ctx.check_validation().expect("no message");
    to.read().expect("the answers")
}

#[test]
fn the_glsl_is_the_f64_twin_and_its_bounds_hold() {
    let boxes = boxes();
    for procedure in Procedure::ALL {
        let answers = ask(procedure, &boxes);
        let (mut worst, mut slopes, mut creases, mut tight, mut total) = (0.0f64, 0.0f64, 0, 0, 0);
        for (corners, answer) in boxes.iter().zip(&answers) {
            let [low, high] = [0, 2].map(|i| DVec2::new(corners[i].into(), corners[i + 1].into()));
            // As f32 has it.
            let middle = [0, 1].map(|i| f64::from(corners[i] + 0.5 * (corners[i + 2] - corners[i])));
            let [height, du, dv, grid_least, least, greatest, bu, bv, grid_greatest, ..] = answer.map(f64::from);
            worst = worst.max((height - procedure.height(low)).abs());
            let off = (DVec2::new(du, dv) - procedure.gradient(low)).length();
            // The last bit decides the side of a crease.
            if off > 1.0 {
                creases += 1
            } else {
                slopes = slopes.max(off)
            }
            assert!(least <= grid_least && grid_greatest <= greatest, "{procedure:?} {low} {high}: {answer:?}");
            for (i, j) in (0..=8).flat_map(|i| (0..=8).map(move |j| (i, j))) {
                let at = low + (high - low) * DVec2::new(f64::from(i), f64::from(j)) / 8.0;
                let h = procedure.height(at) - DVec2::new(bu, bv).dot(at - DVec2::from(middle));
                assert!(least <= h && h <= greatest, "{procedure:?} {low} {high}: {h}, {answer:?}");
            }
            // Away from creases they close in with the square of the box.
            let size = (high - low).max_element();
            if size < 1e-2 {
                total += 1;
                tight += u32::from(greatest - least < 4e-6 + 6e4 * size * size);
            }
        }
        println!(
            "{procedure:?}: heights within {worst:.1e}, gradients {slopes:.1e}, {creases} at creases; bounds of \
             {tight} of {total} small boxes are of second order"
        );
        assert!(f64::from(tight) > 0.95 * f64::from(total), "{procedure:?}: {tight} of {total}");
        assert!(worst <= HEIGHT_ERROR && slopes <= GRADIENT_ERROR, "{procedure:?}: {worst} {slopes}");
        assert!(creases <= 2, "{procedure:?}: {creases}");
    }
}

/// A scene with every displacement taken from a procedure.
fn with(procedure: Procedure, mut scene: Scene) -> Scene {
    for displacement in scene.materials.iter_mut().filter_map(|m| m.displacement.as_mut()) {
        displacement.source = HeightSource::Procedure(procedure);
        displacement.wrap = [Wrap::Repeat; 2];
        displacement.transform = DAffine2::IDENTITY;
    }
    scene
}

fn judge(rig: &Rig, name: &str, scene: &Scene, [width, height]: [u32; 2]) {
    let camera = scene.camera.expect("the assets have cameras");
    let truth = Reference::new(scene).render(&camera, width, height, Shadows::Skip);
    for (shell, stage) in SHELLS.into_iter().flat_map(|shell| STAGES.map(|stage| (shell, stage))) {
        let name = format!("{name}, {shell}");
        let mut easel = rig.easel(scene, &rig::exact(shell, stage), [width, height]);
        easel.assert_stage(stage);
        let test = easel.draw(&camera);
        let m = Metrics::between(&test, &truth, &camera);
        let limits = easel.limits_reached();
        println!("{name} {stage}: {limits} lost, {m:?}");
        for line in rig::worst::lines(&test, &truth, &camera, rig::worst::asked()) {
            println!("{line}");
        }
        assert!(m.covered > 3000, "{name} {stage}: {m:?}");
        assert_eq!(exactness::misses(&m, limits), [], "{name} {stage}");
        assert!(m.normal_p99 <= 0.05, "{name} {stage}: {m:?}");
    }
}

#[test]
fn every_procedure_meets_the_figures_on_hard_scenes() {
    let rig = Rig::new();
    for procedure in Procedure::ALL {
        // Fine prisms, large ones with steps at their edges, an open sheet seen from both sides, seams at every edge,
        // short ways through many slivers.
        for name in ["torus", "cube", "cloth", "stability_seams", "stability_slivers"] {
            let scene = with(procedure, rig::asset(&format!("{name}.gltf")));
            judge(&rig, &format!("{name} of {}", procedure.name()), &scene, [160, 90]);
        }
    }
}

#[test]
fn the_scene_of_all_procedures_meets_the_figures() {
    let scene = rig::asset("procedural.gltf");
    assert!(scene.height_maps.is_empty() && scene.images.is_empty());
    judge(&Rig::new(), "procedural", &scene, [240, 135]);
}

/// A torus in patches at random: every procedure and the map, on scales and midlevels of their own.
fn patchwork() -> Scene {
    let mut scene = rig::asset("torus.gltf");
    let material = scene.materials[0].clone();
    let map = material.displacement.expect("a displaced torus");
    let whole = scene.meshes[0].primitives.remove(0);
    let sources = Procedure::ALL.map(HeightSource::Procedure).into_iter().chain([map.source]);
    for (n, source) in sources.enumerate() {
        let displacement = scene::Displacement {
            source,
            wrap: [Wrap::Repeat; 2],
            transform: DAffine2::IDENTITY,
            scale: map.scale * (1.0 - 0.1 * n as f64),
            relative: false,
            midlevel: 0.1 * n as f64,
            ..map
        };
        scene.materials.push(Material { displacement: Some(displacement), ..material.clone() });
        scene.meshes[0].primitives.push(Primitive {
            material: scene.materials.len() - 1,
            displacement_scale: displacement.scale,
            triangles: Vec::new(),
            ..whole.clone()
        });
    }
    let mut random = Random(3);
    let patches = &mut scene.meshes[0].primitives;
    for pair in whole.triangles.chunks(2) {
        let patch = (random.next() * patches.len() as f64) as usize;
        patches[patch].triangles.extend(pair);
    }
    scene
}

#[test]
fn steps_between_procedures_and_a_map_are_closed() {
    let scene = patchwork();
    judge(&Rig::new(), "patchwork", &scene, [240, 135]);
}

/// Relief with many fine steps, which reads the heights only.
#[test]
fn the_marches_with_steps_go_through_the_same_hook() {
    let rig = Rig::new();
    for procedure in Procedure::ALL {
        let scene = with(procedure, rig::asset("torus.gltf"));
        let camera = scene.camera.expect("the assets have cameras");
        let truth = Reference::new(&scene).render(&camera, 160, 90, Shadows::Skip);
        let marches = [(March::Relief, 2e-3), (March::Pom, 1e-2)];
        for (shell, (march, stray)) in SHELLS.into_iter().flat_map(|shell| marches.map(|march| (shell, march))) {
            let settings = Settings { march, min_steps: 64, max_steps: 64, ..rig::exact(shell, STAGES[0]) };
            let settings = Settings { count_limits: false, ..settings };
            let m = Metrics::between(&rig.easel(&scene, &settings, [160, 90]).draw(&camera), &truth, &camera);
            println!("{procedure:?} {shell} {march}: {m:?}");
            assert!(m.depth_p99 <= 0.05 && m.depth_above_1 <= stray && m.coverage_differs <= stray, "{march}: {m:?}");
        }
    }
}

/// Detail that lies under a flat base surface is where the tangent plane's ray is exact.
#[test]
fn the_base_surface_of_a_plane_shows_them_exactly() {
    let rig = Rig::new();
    for procedure in Procedure::ALL {
        let scene = with(procedure, rig::asset("plane.gltf"));
        let camera = scene.camera.expect("the assets have cameras");
        let mut truth = Reference::new(&scene).render(&camera, 160, 90, Shadows::Skip);
        let mut easel = rig.easel(&scene, &rig::exact(Shell::Off, STAGES[0]), [160, 90]);
        let mut test = easel.draw(&camera);
        // At the sheet's borders the true ray may leave it, the tangent plane has none.
        let inner =
            |aov: &Aov, i: usize| aov.depth[i].is_finite() && aov.uv[i].iter().all(|c| (0.12..=0.88).contains(c));
        for i in 0..truth.depth.len() {
            if !inner(&truth, i) && !inner(&test, i) {
                (truth.depth[i], test.depth[i]) = (f32::INFINITY, f32::INFINITY);
            }
        }
        let m = Metrics::between(&test, &truth, &camera);
        println!("{procedure:?}: {m:?}");
        assert!(m.covered > 1500 && easel.limits_reached() == 0, "{m:?}");
        assert!(m.depth_p99 <= DEPTH_P99 && m.depth_above_1 <= 1e-3 && m.coverage_differs <= 1e-3, "{m:?}");
    }
}

/// Names of variables and types in a shader's code, and the bits of its constants of one word.
fn names_and_constants(spirv: &[u32]) -> (Vec<String>, Vec<u32>) {
    const OP_NAME: u32 = 5;
    const OP_CONSTANT: u32 = 43;
    let (mut at, mut names, mut constants) = (5, Vec::new(), Vec::new());
    while at < spirv.len() {
        let words = (spirv[at] >> 16) as usize;
        match spirv[at] & 0xffff {
            OP_NAME => {
                let bytes = spirv[at + 2..at + words].iter().flat_map(|word| word.to_le_bytes());
                let bytes = bytes.take_while(|byte| *byte != 0).collect();
                names.push(String::from_utf8(bytes).expect("UTF-8"));
            }
            OP_CONSTANT => constants.push(spirv[at + 3]),
            _ => {}
        }
        at += words;
    }
    (names, constants)
}

#[test]
fn no_map_is_bound_for_a_procedure_and_no_other_is_in_its_code() {
    let rig = Rig::new();
    let code = |scene: &Scene, shell: Shell| {
        let easel = rig.easel(scene, &rig::exact(shell, STAGES[0]), [16, 16]);
        let shaders = easel.shell_shaders();
        let parts: Vec<_> = shaders.iter().map(|shader| names_and_constants(&shader.spirv)).collect();
        let (names, constants): (Vec<_>, Vec<_>) = parts.into_iter().unzip();
        (names.concat(), constants.concat())
    };
    // A number of its own in each one's code: a crown's height, the texels of the nominal map, a phase.
    let marks = [(Procedure::Bricks, 0.84f32), (Procedure::Cobbles, 128.0), (Procedure::Waves, 0.703_125)];
    let maps = ["height_map", "PyramidBlock"];
    let map = rig::asset("torus.gltf");
    for shell in SHELLS {
        let (names, constants) = code(&map, shell);
        assert!(maps.iter().all(|map| names.iter().any(|name| name == map)), "{names:?}");
        assert!(marks.iter().all(|(_, mark)| !constants.contains(&mark.to_bits())), "{constants:x?}");
        for procedure in Procedure::ALL {
            let (names, constants) = code(&with(procedure, map.clone()), shell);
            assert!(!names.iter().any(|name| maps.contains(&name.as_str())), "{procedure:?}: {names:?}");
            for (other, mark) in marks {
                let has = constants.contains(&mark.to_bits());
                assert_eq!(has, other == procedure, "{procedure:?} with the code of {other:?}: {constants:x?}");
            }
        }
    }
    // Among neighbours the map's patches alone bind the map as their own, and no patch reads another one.
    let easel = rig.easel(&patchwork(), &rig::exact(Shell::Prism, STAGES[0]), [16, 16]);
    let fragments: Vec<_> = easel
        .shell_shaders()
        .iter()
        .filter(|s| s.stage == ShaderStage::Fragment)
        .map(|s| names_and_constants(&s.spirv))
        .collect();
    let count = |name: &str| fragments.iter().filter(|(names, _)| names.iter().any(|n| n.starts_with(name))).count();
    assert_eq!([count("height_map"), count("other_map_")], [1, Procedure::ALL.len()]);
}
