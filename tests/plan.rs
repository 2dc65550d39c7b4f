//! The plan is what is created: the SPIR-V of the pipelines, the device's features, the allocations and the passes of a
//! frame are what a scene needs and no more, and `prism explain` tells the same. What is left out would change nothing.

mod rig;

use std::collections::BTreeSet;

use glam::{DAffine2, DAffine3, DVec3, Vec2, Vec3, Vec4};
use prism_engine::{
    gpu::{Feature, Pipeline, ShaderStage, vk},
    render::{
        self, Output,
        explain::{Explanation, Situation},
        plan::{self, Plan},
        variant::UNIFORM_LIGHTS,
    },
    scene::{
        Ambient, Camera, ColorImage, DepthOffset, Displacement, HeightMap, HeightSource, HeightTexels, Instance, Light,
        LightKind, Material, Mesh, Procedure, Sampler, Scene, TextureRef, Wrap,
    },
    settings::{
        Baseline, Culling, Dicer, March, PrismCulling, SelfShadow, Settings, Shell, Stage, View, VisibilityBuffer,
    },
};
use rig::{FORMAT, Rig, asset, square::square};

const EXTENT: [u32; 2] = [64, 40];

/// A plain square of side 2 in the floor, seen at an angle, without lights or textures.
fn floor() -> Scene {
    let mesh = Mesh { name: "floor".into(), ..square(1.0, 0, 0.0) };
    Scene {
        file: "floor".into(),
        meshes: vec![mesh],
        materials: vec![Material { name: "stone".into(), base_color_factor: Vec4::ONE, ..Material::default() }],
        images: Vec::new(),
        height_maps: Vec::new(),
        instances: vec![Instance { name: "floor".into(), mesh: 0, transform: DAffine3::IDENTITY }],
        camera: Some(Camera::look_at(DVec3::new(0.3, 1.5, 2.2), DVec3::ZERO, 60.0).unwrap()),
        lights: Vec::new(),
        ambient: Ambient::default(),
        notices: Vec::new(),
    }
}

/// A single triangle of it.
fn triangle() -> Scene {
    let mut scene = floor();
    scene.meshes[0].primitives[0].triangles.pop();
    scene
}

/// The floor displaced by a map of 8 texels a side.
fn displaced(texels: impl Fn(u32) -> u16, scale: f64, midlevel: f64) -> Scene {
    let mut scene = floor();
    let texels = HeightTexels::U16((0..64).map(texels).collect());
    scene.height_maps.push(HeightMap { name: "bumps".into(), width: 8, height: 8, texels });
    scene.meshes[0].primitives[0].displacement_scale = scale;
    scene.materials[0].displacement = Some(Displacement {
        source: HeightSource::Map(0),
        wrap: [Wrap::Repeat; 2],
        tex_coord: 0,
        transform: DAffine2::IDENTITY,
        scale,
        relative: false,
        midlevel,
        border_wall: false,
    });
    scene
}

/// Without order, of 16 bits.
fn bumps(i: u32) -> u16 {
    (i.wrapping_mul(2_654_435_761) >> 16) as u16
}

/// With a map of normals and a base colour, and an occlusion on the second UV set.
fn mapped(mut scene: Scene) -> Scene {
    let texture = textured(&mut scene, 255);
    let primitive = &mut scene.meshes[0].primitives[0];
    primitive.tangents = vec![Vec4::new(1.0, 0.0, 0.0, 1.0); primitive.positions.len()];
    primitive.uvs[1] = primitive.uvs[0].iter().map(|uv| 2.0 * *uv).collect();
    scene.materials[0].base_color = Some(texture);
    scene.materials[0].normal = Some((texture, 1.0));
    scene.materials[0].occlusion = Some((TextureRef { tex_coord: 1, ..texture }, 0.5));
    scene
}

/// A white picture with this alpha, read as a texture.
fn textured(scene: &mut Scene, alpha: u8) -> TextureRef {
    let rgba = [255, 255, 255, alpha].repeat(16);
    scene.images.push(ColorImage { name: "white".into(), width: 4, height: 4, rgba, srgb: true });
    let image = scene.images.len() - 1;
    TextureRef { image, sampler: Sampler::default(), tex_coord: 0, transform: DAffine2::IDENTITY }
}

fn sun(direction: DVec3) -> Light {
    let kind = LightKind::Directional;
    Light { intensity: DVec3::ONE, position: DVec3::ZERO, direction: direction.normalize(), range: None, kind }
}

/// What a module has of what may be left out.
#[derive(Debug, Default)]
struct Module {
    replaces_depth: bool,
    only_behind: bool,
    discards: bool,
    loops: usize,
}

impl Module {
    fn new(spirv: &[u32]) -> Module {
        const EXECUTION_MODE: u32 = 16;
        const LOOP_MERGE: u32 = 246;
        const KILL: u32 = 252;
        const TERMINATE: u32 = 4416;
        const DEMOTE: u32 = 5380;
        let mut module = Module::default();
        let mut rest = &spirv[5..];
        while let Some(first) = rest.first() {
            let (instruction, after) = rest.split_at((first >> 16) as usize);
            match (first & 0xffff, instruction.get(2)) {
                (EXECUTION_MODE, Some(12)) => module.replaces_depth = true,
                (EXECUTION_MODE, Some(15)) => module.only_behind = true,
                (KILL | TERMINATE | DEMOTE, _) => module.discards = true,
                (LOOP_MERGE, _) => module.loops += 1,
                _ => {}
            }
            rest = after;
        }
        module
    }

    /// A pipeline's fragment shader; none if it has none.
    fn fragment(pipeline: &Pipeline) -> Option<Module> {
        let shaders = pipeline.shaders().iter();
        shaders.filter(|shader| shader.stage == ShaderStage::Fragment).map(|s| Module::new(&s.spirv)).next()
    }
}

/// Images that a pipeline reads.
fn samplers(pipeline: &Pipeline) -> BTreeSet<String> {
    let images = pipeline.bindings().iter().filter(|binding| binding.ty == vk::DescriptorType::COMBINED_IMAGE_SAMPLER);
    images.map(|binding| binding.name.clone()).collect()
}

/// One scene under some settings, and what it needs.
struct Case {
    name: &'static str,
    scene: Scene,
    settings: Settings,
    /// Shells are drawn, so by either stage.
    shell: bool,
    /// gl_FragDepth, the promise that it is behind, discard: in all of its pipelines that shade.
    depth: bool,
    behind: bool,
    discard: bool,
    /// All images that its pipelines read.
    images: &'static [&'static str],
    /// Allocations, by what their names end with, that must and must not be there.
    has: &'static [&'static str],
    lacks: &'static [&'static str],
    /// Passes of a frame.
    passes: &'static [&'static str],
}

impl Case {
    /// A plain surface, without anything.
    fn plain(name: &'static str, scene: Scene) -> Case {
        Case {
            name,
            scene,
            settings: Settings { shell: Shell::Prism, march: March::Relief, still: true, ..Settings::default() },
            shell: false,
            depth: false,
            behind: false,
            discard: false,
            images: &[],
            has: &["vertices", "indices", "material"],
            lacks: &["prisms", "adjacency", "lids", "hierarchy", "bumps", "pyramid", "shadow maps", "blue noise"],
            passes: &["surface"],
        }
    }

    /// A shell.
    fn shell(name: &'static str, scene: Scene) -> Case {
        Case {
            shell: true,
            depth: true,
            behind: true,
            discard: true,
            images: &["height_map"],
            has: &["vertices", "prisms", "material", "bumps"],
            lacks: &["indices", "adjacency", "lids", "hierarchy", "pyramid", "shadow maps", "blue noise"],
            passes: &["shell"],
            ..Case::plain(name, scene)
        }
    }

    /// The base surface by a classic technique.
    fn parallax(name: &'static str, march: March, scene: Scene) -> Case {
        let settings = Settings { shell: Shell::Off, march, ..Settings::default() };
        Case {
            settings,
            images: &["height_map"],
            has: &["vertices", "indices", "bumps"],
            lacks: &["prisms", "adjacency", "pyramid", "shadow maps"],
            ..Case::plain(name, scene)
        }
    }
}

/// From a bare triangle to everything at once.
fn cases() -> Vec<Case> {
    let with = |mut scene: Scene, change: &dyn Fn(&mut Scene)| {
        change(&mut scene);
        scene
    };
    let shadowed = |settings: Settings| Settings { self_shadow: SelfShadow::Hard, ..settings };
    let lit = |direction: DVec3| move |scene: &mut Scene| scene.lights = vec![sun(direction)];
    let masked = |alpha: u8| {
        move |scene: &mut Scene| {
            scene.materials[0].base_color = Some(textured(scene, alpha));
            scene.materials[0].alpha_cutoff = Some(0.5);
        }
    };
    let steep = DVec3::new(0.05, -1.0, 0.0);
    let low = DVec3::new(1.0, -0.1, 0.0);
    vec![
        Case::plain("a bare triangle", triangle()),
        Case {
            images: &["base_color_map"],
            has: &["white"],
            ..Case::plain("a textured square", with(floor(), &masked(255)))
        },
        Case {
            images: &["base_color_map"],
            discard: true,
            ..Case::plain("one that is cut out by its alpha", with(floor(), &masked(30)))
        },
        Case {
            images: &["base_color_map", "normal_map", "occlusion_map"],
            has: &["white", "uvs_0", "uvs_1", "tangents"],
            lacks: &["prisms"],
            ..Case::plain("a normal map, and one on the second UV set", mapped(floor()))
        },
        Case {
            images: &["base_color_map", "height_map", "normal_map", "occlusion_map"],
            has: &["white", "uvs_0", "uvs_1", "tangents", "prisms"],
            lacks: &["indices", "adjacency"],
            ..Case::shell("the same on a shell", mapped(displaced(bumps, 0.2, 0.5)))
        },
        Case {
            images: &["metallic_roughness_map", "specular_map"],
            has: &["white", "uvs_0"],
            ..Case::plain(
                "textures that two slots read",
                with(floor(), &|scene| {
                    let texture = textured(scene, 255);
                    let material = &mut scene.materials[0];
                    material.metallic_roughness = Some(texture);
                    material.occlusion = Some((texture, 0.5));
                    material.specular_map = Some(texture);
                    material.specular_color = Some(texture);
                }),
            )
        },
        Case {
            lacks: &["white", "uvs_0", "uvs_1", "tangents"],
            ..Case::plain(
                "textures that nothing of shows",
                with(floor(), &|scene| {
                    let texture = textured(scene, 255);
                    scene.materials[0].emissive = Some(texture);
                    scene.materials[0].occlusion = Some((texture, 0.0));
                }),
            )
        },
        Case::plain("displaced by nothing", displaced(bumps, 0.0, 0.5)),
        Case::plain("all heights the same", displaced(|_| 40_000, 0.3, 0.5)),
        Case {
            depth: true,
            behind: true,
            ..Case::plain(
                "depth moved away",
                with(floor(), &|scene| {
                    scene.materials[0].depth_offset = Some(DepthOffset { distance: 0.1, dither: false });
                }),
            )
        },
        Case::parallax("normals from heights", March::Normal, displaced(bumps, 0.2, 0.5)),
        Case {
            depth: true,
            discard: true,
            ..Case::parallax("relief around the base surface", March::Relief, displaced(bumps, 0.2, 0.5))
        },
        Case {
            depth: true,
            behind: true,
            discard: true,
            ..Case::parallax("relief below the base surface", March::Relief, displaced(bumps, 0.2, 1.0))
        },
        Case {
            settings: Settings { shell: Shell::Off, march: March::Relief, pixel_lod: true, ..Settings::default() },
            images: &["height_map", "height_mips"],
            has: &["bumps", "bumps mips"],
            depth: true,
            discard: true,
            ..Case::parallax("heights at the LOD of each pixel", March::Relief, displaced(bumps, 0.2, 0.5))
        },
        Case::shell("prisms", displaced(bumps, 0.2, 0.5)),
        Case {
            settings: shadowed(Case::plain("", floor()).settings),
            ..Case::shell("a sun that cannot graze", with(displaced(bumps, 0.05, 0.5), &lit(steep)))
        },
        Case {
            settings: shadowed(Case::plain("", floor()).settings),
            has: &["prisms", "adjacency", "lids", "hierarchy"],
            lacks: &["indices", "borders", "meshlets", "pyramid"],
            ..Case::shell("a sun that grazes", with(displaced(bumps, 0.05, 0.5), &lit(low)))
        },
        Case {
            images: &[],
            lacks: &["bumps", "pyramid"],
            has: &["prisms"],
            ..Case::shell(
                "heights that are a function",
                with(displaced(bumps, 0.2, 0.5), &|scene| {
                    scene.height_maps.clear();
                    let displacement = scene.materials[0].displacement.as_mut().unwrap();
                    displacement.source = HeightSource::Procedure(Procedure::ALL[0]);
                }),
            )
        },
        Case {
            settings: Settings { prism_culling: PrismCulling::Hidden, ..Case::plain("", floor()).settings },
            has: &["prisms", "seen prisms of draw 0", "depth tiles"],
            lacks: &["indices", "adjacency", "lids", "culled prisms of slot 0"],
            passes: &["culling", "shell", "depth tiles", "culling again", "shell again"],
            ..Case::shell("prisms of which the unseen are dropped", displaced(bumps, 0.2, 0.5))
        },
        Case {
            settings: Settings { march: March::Exact, shell: Shell::Walk, ..Settings::default() },
            has: &["prisms", "adjacency", "lids", "borders", "pyramid"],
            lacks: &["hierarchy", "shadow maps"],
            ..Case::shell("a walk", displaced(bumps, 0.2, 0.5))
        },
        Case {
            settings: Settings {
                march: March::Relief,
                shell: Shell::Walk,
                visibility_buffer: VisibilityBuffer::On,
                ..Settings::default()
            },
            images: &["height_map", "nearest_lids", "depth_so_far"],
            has: &["prisms", "adjacency", "lids", "nearest lids", "depth so far"],
            lacks: &["hierarchy", "pyramid", "shadow maps", "depth tiles"],
            passes: &["visibility", "shell", "shell rest"],
            ..Case::shell("a walk that begins at a visibility buffer", displaced(bumps, 0.2, 0.5))
        },
        Case {
            settings: Settings {
                baseline: Some(Baseline::MicroMesh { density: 4, culling: Culling::Off }),
                visibility_buffer: VisibilityBuffer::On,
                ..Settings::default()
            },
            discard: true,
            images: &["nearest_triangles"],
            has: &["micro-vertices", "micro-indices", "nearest triangles"],
            lacks: &["adjacency", "lids", "pyramid", "depth so far", "bumps"],
            passes: &["visibility", "micro-mesh"],
            ..Case::plain("a micro-mesh whose triangles are named", displaced(bumps, 0.2, 0.5))
        },
        Case {
            settings: Settings {
                shell: Shell::Prism,
                march: March::Relief,
                self_shadow: SelfShadow::Hard,
                shadow_map: true,
                shadow_map_size: 64,
                cascades: 1,
                ambient_occlusion: true,
                dither: true,
                msaa: 4,
                count_limits: true,
                ..Settings::default()
            },
            images: &["base_color_map", "height_map", "ambient_occlusion_map", "blue_noise", "shadow_atlas"],
            has: &["hierarchy", "adjacency", "shadow maps", "blue noise", "occlusion", "samples", "counters of slot 0"],
            lacks: &["pyramid"],
            passes: &["shadow maps", "shell"],
            ..Case::shell(
                "everything at once",
                with(displaced(bumps, 0.2, 0.5), &|scene| {
                    masked(30)(scene);
                    lit(low)(scene);
                }),
            )
        },
    ]
}

/// The stages that a case is to be looked at with.
fn stages(case: &Case) -> &'static [Stage] {
    if case.shell { &rig::STAGES } else { &[Stage::Auto] }
}

fn explained(scene: &Scene, settings: &Settings, plan: &Plan) -> Explanation {
    let output = Output { color_format: FORMAT, aov: false };
    let (device, window) = (None, false);
    Explanation::new(scene, settings, plan, &Situation { device, extent: EXTENT, max_image_2d: 4096, output, window })
}

/// A device with exactly the features that the scene asks for.
fn rig_for(scene: &Scene, settings: &Settings) -> Rig {
    let features = render::features(scene, settings, false);
    let tasks = |feature: &Feature| *feature == Feature::TaskShader;
    assert!(features.optional.iter().all(tasks) || settings.stage == Stage::Auto, "{features:?}");
    Rig::asking(&[features.required, features.optional].concat())
}

#[test]
fn what_a_scene_needs_is_created_and_no_more() {
    for case in cases() {
        for &stage in stages(&case) {
            let settings = Settings { stage, ..case.settings.clone() };
            let rig = rig_for(&case.scene, &settings);
            let mut easel = rig.try_easel_with(&case.scene, &settings, EXTENT, false).expect(case.name);
            let of = format!("{}, {stage}", case.name);

            // Features and extensions: one stage's, or none.
            let enabled: Vec<_> = rig.context().enabled_features().to_vec();
            for (feature, its) in [(Feature::MeshShader, Stage::Mesh), (Feature::GeometryShader, Stage::Geometry)] {
                assert_eq!(enabled.contains(&feature), case.shell && stage == its, "{of}: {enabled:?}");
            }
            let culled = settings.prism_culling != PrismCulling::Auto;
            assert_eq!(enabled.contains(&Feature::TaskShader), culled && stage == Stage::Mesh, "{of}: {enabled:?}");
            assert_eq!(enabled.contains(&Feature::SampleRateShading), settings.msaa > 1, "{of}: {enabled:?}");
            assert_eq!(
                enabled.contains(&Feature::FragmentStoresAndAtomics),
                settings.count_limits,
                "{of}: {enabled:?}"
            );
            let extensions = rig.context().enabled_extensions().to_vec();
            assert_eq!(extensions.len(), usize::from(stage == Stage::Mesh), "{of}: {extensions:?}");

            // The SPIR-V of the pipelines.
            let mut images = BTreeSet::new();
            for (name, pipeline) in easel.pipelines() {
                images.extend(samplers(pipeline));
                let Some(module) = Module::fragment(pipeline) else { continue };
                if name.starts_with("shadow map") {
                    continue;
                }
                if name.starts_with("visibility") {
                    // It names what is rasterised.
                    assert_eq!(
                        (module.replaces_depth, module.discards, module.loops),
                        (false, false, 0),
                        "{of}: {name}"
                    );
                    continue;
                }
                assert_eq!(module.replaces_depth, case.depth, "{of}: {name}: {module:?}");
                assert_eq!(module.only_behind, case.behind, "{of}: {name}: {module:?}");
                assert_eq!(module.discards, case.discard, "{of}: {name}: {module:?}");
                if case.images.is_empty() && !case.shell && case.scene.lights.is_empty() {
                    // Over the ambient light's three colours.
                    assert_eq!(module.loops, 1, "{of}: {name} loops over nothing");
                }
            }
            assert_eq!(images, case.images.iter().map(|name| (*name).to_owned()).collect(), "{of}");

            // The passes of a frame, and what is allocated after it.
            // The mesh stage has a task stage before it, in place of a pass.
            let lists = |name: &&&str| stage == Stage::Geometry || !name.starts_with("culling");
            let passes: Vec<_> = case.passes.iter().filter(lists).copied().collect();
            assert_eq!(easel.passes(&case.scene.camera.unwrap()), passes, "{of}");
            let allocated: BTreeSet<_> = rig.allocations().into_iter().collect();
            let has = |end: &str| allocated.iter().any(|name| name.ends_with(end));
            for end in case.has {
                assert!(has(end), "{of}: no '{end}' among {allocated:?}");
            }
            for end in case.lacks {
                assert!(!has(end), "{of}: '{end}' among {allocated:?}");
            }
            let meshlets = case.shell && settings.resolved_shell() == Shell::Walk && stage == Stage::Mesh;
            assert_eq!(has("meshlets"), meshlets, "{of}");
            assert_eq!(has("kept prisms of draw 0"), culled && stage == Stage::Geometry, "{of}");

            // Of vertices no more than its pipelines read.
            let bound = |name: &str| {
                let binds = |pipeline: &Pipeline| pipeline.bindings().iter().any(|binding| binding.name == name);
                easel.pipelines().iter().any(|(_, pipeline)| binds(pipeline))
            };
            for stream in ["floor.0 vertices", "surface_vertices", "uvs_0", "uvs_1", "tangents"] {
                assert_eq!(has(stream), bound(stream.trim_start_matches("floor.0 ")), "{of}: {stream}");
            }
            // Shell normals, where there is a shell.
            assert_eq!(has("floor.0 vertices"), case.shell, "{of}");

            // The same by its explanation: no allocation that it does not tell, and none that is not there.
            let told = explained(&case.scene, &settings, easel.plan());
            assert_allocated(&rig, &told, &of);
            let pipelines: Vec<_> = easel.pipelines().into_iter().map(|(name, _)| name).collect();
            assert_eq!(told.pipelines.iter().map(|p| p.name.clone()).collect::<Vec<_>>(), pipelines, "{of}");
            assert!(pipelines.len() <= told.most_pipelines, "{of}: {} pipelines", pipelines.len());
            let frame: Vec<_> = told.passes.iter().map(|pass| pass.name).filter(|name| *name != "resolve").collect();
            assert_eq!(frame, passes, "{of}");
            let names: BTreeSet<_> = enabled.iter().map(|feature| feature.name()).collect();
            assert_eq!(told.features.into_iter().collect::<BTreeSet<_>>(), names, "{of}");
            assert_eq!(told.extensions, extensions, "{of}");
        }
    }
}

/// What an explanation lists is what is allocated, no more and no less, and buffers are as large.
#[track_caller]
fn assert_allocated(rig: &Rig, told: &Explanation, of: &str) {
    let names = told.buffers.iter().map(|buffer| &buffer.name).chain(told.images.iter().map(|i| &i.name));
    let allocated: BTreeSet<_> = rig.allocations().into_iter().collect();
    assert_eq!(names.cloned().collect::<BTreeSet<_>>(), allocated, "{of}");
    let memory: std::collections::HashMap<_, _> = rig.context().memory_report().into_iter().collect();
    for buffer in &told.buffers {
        let real = memory[&buffer.name];
        // A block's alignment counts with the buffer behind it.
        let most = buffer.bytes.next_multiple_of(256) + 64;
        assert!((buffer.bytes..=most).contains(&real), "{of}: {buffer:?}, {real}");
    }
}

/// A mesh that changes shape, and what is drawn in a shell's place, have buffers of their own.
#[test]
fn buffers_of_posed_meshes_and_of_baselines_are_told() {
    let still = displaced(bumps, 0.05, 0.5);
    let mut posed = still.clone();
    posed.meshes[0].deforms = true;
    let mut shadowed = mapped(posed.clone());
    shadowed.lights = vec![sun(DVec3::new(1.0, -0.1, 0.0))];
    let walk = Settings { march: March::Relief, shell: Shell::Walk, ..Settings::default() };
    let hard = Settings { self_shadow: SelfShadow::Hard, ..walk.clone() };
    let prism = Settings { shell: Shell::Prism, ..walk.clone() };
    let off = Settings { shell: Shell::Off, ..walk.clone() };
    let instead = |baseline| Settings { baseline: Some(baseline), ..Settings::default() };
    let micro_mesh = |culling| instead(Baseline::MicroMesh { density: 4, culling });
    let diced = |by| instead(Baseline::Diced { by, edge: 4.0, culls: true });
    let rest = ["floor pose", "floor fans", "floor.0 vertices at rest"];
    for (of, scene, settings, has) in [
        ("posed walk", &posed, walk, &["floor.0 adjacency at rest", rest[0], rest[1], rest[2]][..]),
        ("posed, in shadows", &shadowed, hard, &["floor.0 boxes' order", "floor.0 tangents"]),
        ("posed prisms", &posed, prism, &["floor.0 prisms at rest"]),
        ("posed base surface", &posed, off, &rest),
        ("micro-mesh", &still, micro_mesh(Culling::Off), &["floor.0 micro-vertices"]),
        ("micro-mesh by triangle", &still, micro_mesh(Culling::Triangles), &["micro-indices kept"]),
        ("tessellated", &still, diced(Dicer::Tessellation), &["floor.0 diced triangles"]),
        ("diced by the mesh stage", &still, diced(Dicer::Mesh), &["floor.0 diced triangles"]),
    ] {
        let rig = Rig::asking(&[Feature::TessellationShader, Feature::TaskShader, Feature::MeshShader]);
        let mut easel = rig.try_easel_with(scene, &settings, EXTENT, false).expect(of);
        easel.passes(&scene.camera.unwrap());
        let told = explained(scene, &settings, easel.plan());
        assert_allocated(&rig, &told, of);
        for name in has {
            assert!(told.buffers.iter().any(|buffer| buffer.name == *name), "{of}: no {name}");
        }
    }
}

/// Every part that an explanation tells of a pipeline, read in its code where that shows it.
#[test]
fn a_pipeline_s_parts_are_those_of_its_code() {
    let mut loops = Vec::new();
    for (case, stage) in cases().iter().flat_map(|case| stages(case).iter().map(move |stage| (case, *stage))) {
        let settings = Settings { stage, ..case.settings.clone() };
        let plan = plan::plan(&case.scene, &settings, stage, false);
        let rig = rig_for(&case.scene, &settings);
        let easel = rig.try_easel_with(&case.scene, &settings, EXTENT, false).expect(case.name);
        for (told, (name, pipeline)) in explained(&case.scene, &settings, &plan).pipelines.iter().zip(easel.pipelines())
        {
            let part =
                |what: &str| told.parts.iter().find(|part| part.what == what).unwrap_or_else(|| panic!("{what}")).kept;
            let bound = |name: &str| pipeline.bindings().iter().any(|binding| binding.name == name);
            let module = Module::fragment(pipeline);
            let of = format!("{}, {stage}: {name}", case.name);
            assert_eq!(part("fragment shader"), module.is_some(), "{of}");
            let Some(module) = module else { continue };
            assert_eq!(part("gl_FragDepth"), module.replaces_depth, "{of}");
            assert_eq!(part("conservative depth"), module.only_behind, "{of}");
            assert_eq!(part("discard"), module.discards, "{of}");
            assert_eq!(part("lights"), bound("LightBlock"), "{of}");
            assert_eq!(part("min-max pyramid"), bound("pyramid"), "{of}");
            assert_eq!(part("cone map"), bound("cone_map"), "{of}");
            assert_eq!(part("dither"), bound("blue_noise"), "{of}");
            assert_eq!(part("ambient occlusion"), bound("ambient_occlusion_map"), "{of}");
            assert_eq!(part("re-entry of shadow rays"), bound("shadow_hierarchy"), "{of}");
            assert_eq!(part("shadow map look-ups"), bound("shadow_atlas"), "{of}");
            assert_eq!(part("loop counters"), bound("counters"), "{of}");
            assert_eq!(part("tangents"), bound("normal_map"), "{of}");
            assert_eq!(part("visibility buffer"), bound("nearest_lids") || bound("nearest_triangles"), "{of}");
            loops.push((case.name, stage, part("self-shadow"), module.loops));
        }
    }
    // The march toward the light is not in the code where it is left out.
    let of =
        |name: &'static str| loops.iter().filter(move |l| l.0 == name).map(|(.., shadow, loops)| (*shadow, *loops));
    for ((without, fewer), (with, more)) in of("a sun that cannot graze").zip(of("a sun that grazes")) {
        assert!(!without && with && fewer < more, "{fewer} and {more} loops");
    }
}

/// Draws with the plan and with all kept; how many pixels of the picture differ by more than rounding.
fn differing(rig: &Rig, scene: &Scene, settings: &Settings) -> usize {
    let [plan, all] = [false, true].map(|keep_all| {
        let prism_culling = if keep_all { PrismCulling::Off } else { settings.prism_culling };
        let visibility_buffer = if keep_all { VisibilityBuffer::Off } else { settings.visibility_buffer };
        let settings = Settings { keep_all, prism_culling, visibility_buffer, ..settings.clone() };
        let mut easel = rig.try_easel_with(scene, &settings, EXTENT, false).expect("a renderer");
        let kept = easel.plan().ledger.decisions().iter().filter(|decision| decision.kept).count();
        (easel.picture(&scene.camera.unwrap()), kept)
    });
    assert!(all.1 >= plan.1, "all is kept, and {} < {}", all.1, plan.1);
    let pairs = plan.0.chunks_exact(4).zip(all.0.chunks_exact(4));
    pairs.filter(|(a, b)| a.iter().zip(*b).any(|(a, b)| a.abs_diff(*b) > 1)).count()
}

/// A device for every case.
fn able() -> Rig {
    use Feature as F;
    Rig::asking(&[F::TaskShader, F::MeshShader, F::GeometryShader, F::FragmentStoresAndAtomics, F::SampleRateShading])
}

#[test]
fn the_picture_with_all_kept_is_the_same() {
    let rig = able();
    // The last one, all at once, compiles for long on lavapipe; the sweep below has it.
    let cases = cases();
    let (_, quick) = cases.split_last().expect("cases");
    for (i, case) in quick.iter().enumerate() {
        // Shells by one stage and the other in turn.
        let stage = stages(case)[i % stages(case).len()];
        assert_same(&rig, case, stage);
    }
}

#[track_caller]
fn assert_same(rig: &Rig, case: &Case, stage: Stage) {
    let differ = differing(rig, &case.scene, &Settings { stage, ..case.settings.clone() });
    // Drawn as a shell, its outline is not snapped to the rasteriser's grid.
    let outline = if case.name == "all heights the same" { 2 } else { 0 };
    assert!(differ <= outline, "{}, {stage}: {differ} pixels differ", case.name);
}

/// The same over the project's own scenes.
#[test]
#[ignore = "some minutes; tests/run figures"]
fn the_picture_with_all_kept_is_the_same_in_every_scene() {
    let rig = able();
    for (case, stage) in cases().iter().flat_map(|case| stages(case).iter().map(move |stage| (case, *stage))) {
        assert_same(&rig, case, stage);
    }
    for name in ["torus", "cube", "suzanne", "stability_seams", "plane", "prism_shell", "procedural", "shadows"] {
        let scene = asset(&format!("{name}.gltf")).with_defaults(1.6);
        for (shell, stage) in rig::SHELLS.into_iter().flat_map(|shell| rig::STAGES.map(|stage| (shell, stage))) {
            let differ = differing(&rig, &scene, &Settings { shell, stage, ..Settings::default() });
            println!("{name}, {shell}, {stage}: {differ} pixels differ");
            assert_eq!(differ, 0, "{name}, {shell}, {stage}");
        }
    }
}

/// A triangle over which the map has one height takes one step, and is hit in the same place.
#[test]
fn a_triangle_of_one_height_takes_one_step() {
    let rig = able();
    let mut scene = displaced(|i| if i % 8 < 4 { 40_000 } else { bumps(i) }, 0.2, 0.5);
    // The first triangle stays in the map's left half, the other one does not.
    scene.meshes[0].primitives[0].uvs[0] = [[0.1, 0.1], [0.35, 0.1], [0.35, 0.9], [0.9, 0.9]].map(Vec2::from).to_vec();
    for (number, march) in [March::Relief, March::Exact, March::Cone].into_iter().enumerate() {
        for (shell, stage) in [(Shell::Walk, rig::STAGES[number % 2]), (Shell::Prism, rig::STAGES[1 - number % 2])] {
            let settings = Settings { march, shell, stage, ..Settings::default() };
            let plan = plan::plan(&scene, &settings, stage, false);
            let level: Vec<_> = plan.primitives[0].shell.prisms.iter().map(|prism| prism.one_height).collect();
            assert_eq!(level, [true, false]);
            assert!(plan.ledger.find("floor.0", "one step").is_some_and(|decision| decision.kept));
            assert_eq!(explained(&scene, &settings, &plan).primitives[0].level_triangles, 1);
            assert_eq!(differing(&rig, &scene, &settings), 0, "{march}, {shell}, {stage}");
        }
    }
    // A step at a wall is none of its heights.
    scene.materials[0].displacement.as_mut().unwrap().border_wall = true;
    let plan = plan::plan(&scene, &Settings::default(), Stage::Mesh, false);
    assert!(plan.primitives[0].shell.prisms.iter().all(|prism| !prism.one_height));
}

/// More lights than a uniform buffer has room for are stored, and light the same together as one of their sum.
#[test]
fn lights_beyond_a_uniform_buffer_light_the_same() {
    let rig = able();
    let mut scene = displaced(bumps, 0.02, 0.5);
    let [one, many] = [1, UNIFORM_LIGHTS + 1].map(|count| {
        let light = sun(DVec3::new(0.3, -1.0, -0.2));
        scene.lights = vec![Light { intensity: light.intensity / count as f64, ..light }; count];
        let settings = Settings { march: March::Relief, ..Settings::default() };
        let stored = plan::plan(&scene, &settings, Stage::Mesh, false).draws[0].variant.defines();
        assert_eq!(stored.iter().any(|(name, _)| *name == "STORED_LIGHTS"), count > UNIFORM_LIGHTS);
        rig.easel(&scene, &settings, EXTENT).picture(&scene.camera.unwrap())
    });
    let most = one.iter().zip(&many).map(|(one, many)| one.abs_diff(*many)).max();
    let lit = one.chunks_exact(4).filter(|pixel| pixel[0] > 128).count();
    assert!(lit > 400 && most <= Some(1), "{lit} pixels are lit, {most:?} codes apart");
}

/// A picture with several samples a pixel has no surface data beside it, and shows coordinates all the same.
#[test]
fn a_view_of_coordinates_keeps_its_set_with_several_samples() {
    let rig = able();
    let mut scene = displaced(bumps, 0.02, 0.5);
    let primitive = &mut scene.meshes[0].primitives[0];
    primitive.uvs[1] = primitive.uvs[0].iter().map(|uv| 0.2 * *uv + 0.4).collect();
    scene.materials[0].displacement.as_mut().unwrap().tex_coord = 1;
    for (shell, march) in [(Shell::Off, March::None), (Shell::Prism, March::Relief)] {
        let [one, four] = [1, 4].map(|msaa| {
            let settings = Settings { shell, march, view: View::Uv, msaa, ..Settings::default() };
            let mut easel = rig.try_easel_with(&scene, &settings, EXTENT, false).expect("a renderer");
            easel.picture(&scene.camera.unwrap())
        });
        let shown = one.chunks_exact(4).filter(|pixel| pixel[2] == 0).count();
        let pairs = one.chunks_exact(4).zip(four.chunks_exact(4)).filter(|(one, _)| one[2] == 0);
        let near = pairs.filter(|(one, four)| one.iter().zip(*four).all(|(a, b)| a.abs_diff(*b) < 12)).count();
        // At the outline some samples see what lies behind.
        assert!(shown > 400 && 10 * near > 8 * shown, "{shell}: {near} of {shown} pixels show the same coordinates");
    }
}

/// Each derivation has a reason, and the reason follows the scene.
#[test]
fn the_reasons_follow_the_scene() {
    let decided = |scene: &Scene, settings: &Settings, of: &str, what: &str| {
        let plan = plan::plan(scene, settings, Stage::Mesh, false);
        let decision = plan.ledger.find(of, what).unwrap_or_else(|| panic!("{of}: {what}"));
        assert!(!decision.why.is_empty());
        (decision.kept, decision.why.clone())
    };
    let settings = Settings { still: true, self_shadow: SelfShadow::Hard, ..Settings::default() };
    // Of one height, beside one with detail: each in its own way, unless they meet.
    for (apart, offset) in [(5.0, true), (0.0, false)] {
        let mut scene = displaced(bumps, 0.2, 0.5);
        let level = HeightTexels::U8(vec![200; 64]);
        scene.height_maps.push(HeightMap { name: "level".into(), width: 8, height: 8, texels: level });
        let mut stone = scene.materials[0].clone();
        stone.displacement.as_mut().unwrap().source = HeightSource::Map(1);
        scene.materials.push(stone);
        let mesh = &mut scene.meshes[0];
        let mut beside = mesh.primitives[0].clone();
        beside.material = 1;
        beside.positions.iter_mut().for_each(|p| p.x += apart);
        if offset {
            beside.weld.iter_mut().for_each(|weld| *weld += 4);
            mesh.shell_normals.extend_from_within(..);
        }
        mesh.primitives.push(beside);
        let settings = Settings { march: March::Relief, ..Settings::default() };
        assert_eq!(decided(&scene, &settings, "floor.1", "shell").0, !offset);
        assert!(decided(&scene, &settings, "floor.0", "shell").0);
        let plan = plan::plan(&scene, &settings, Stage::Mesh, false);
        assert_eq!(explained(&scene, &settings, &plan).primitives[1].drawn_as, if offset { "offset" } else { "shell" });
        assert!(plan.primitives[1].shell_normals.iter().all(|normal| normal.y == 1.0));
    }

    let steps = |v: u32| displaced(move |i| (i * v) as u16, 0.2, 0.5);
    assert!(decided(&steps(257), &settings, "height map 'bumps'", "16 bits").1.contains("exactly"));
    assert!(decided(&steps(256), &settings, "height map 'bumps'", "16 bits").0);
    let kept = Settings { keep_all: true, ..settings.clone() };
    assert!(decided(&steps(257), &kept, "height map 'bumps'", "16 bits").0);

    // What vertices would say twice: the coordinates in the height map, and normals along the shell.
    let mut scene = mapped(displaced(bumps, 0.2, 0.5));
    for uv in &mut scene.meshes[0].primitives[0].uvs[0] {
        *uv += 1.0;
    }
    for what in ["first UV set", "normals"] {
        assert!(!decided(&scene, &settings, "floor.0", what).0, "{what}");
        assert!(decided(&scene, &kept, "floor.0", what).0, "{what}");
    }
    assert!(decided(&scene, &settings, "floor.0", "second UV set").0);
    let mut turned = scene.clone();
    turned.materials[0].displacement.as_mut().expect("is displaced").transform = DAffine2::from_angle(0.1);
    assert!(decided(&turned, &settings, "floor.0", "first UV set").0);
    scene.meshes[0].primitives[0].normals[0] = Vec3::new(0.6, 0.8, 0.0);
    assert!(decided(&scene, &settings, "floor.0", "normals").0);

    // Mips, where a sampler reads at them.
    for (no_mips, side, kept) in [(false, 4, true), (true, 4, false), (false, 1, false)] {
        let mut scene = floor();
        let texture = textured(&mut scene, 255);
        let image = &mut scene.images[0];
        (image.width, image.height) = (side, side);
        image.rgba.truncate(4 * (side * side) as usize);
        scene.materials[0].base_color =
            Some(TextureRef { sampler: Sampler { no_mips, ..Sampler::default() }, ..texture });
        assert_eq!(decided(&scene, &settings, "image 'white'", "mips").0, kept, "{no_mips}, {side}");
        let plan = plan::plan(&scene, &settings, Stage::Mesh, false);
        let told = explained(&scene, &settings, &plan);
        let white = told.images.iter().find(|image| image.name == "white").expect("the picture");
        assert_eq!(white.mips, if kept { 3 } else { 1 });
    }

    // The steepest light that still grazes: tan of its elevation is the field's greatest slope.
    let mut scene = displaced(|i| if i % 8 == 4 { u16::MAX } else { 0 }, 0.02, 0.5);
    // A cliff of the whole range within a texel of 1 / 8 of the UV, which is as long as the mesh.
    let slope = 0.02 * 8.0;
    for (elevation, grazes) in [(0.9 * slope, true), (1.1 * slope, false)] {
        scene.lights = vec![sun(DVec3::new(1.0, -elevation, 0.0))];
        assert_eq!(decided(&scene, &settings, "floor.0", "self-shadow").0, grazes, "{elevation}");
        // Whoever moves lights gets the code for all of them.
        let moving = Settings { still: false, ..settings.clone() };
        assert!(decided(&scene, &moving, "floor.0", "self-shadow").0);
    }
    // So near a lamp stands over it that none of its light comes in low; farther away some does.
    for (height, grazes) in [(0.5, false), (0.2, true)] {
        let lamp = Light { kind: LightKind::Point, position: DVec3::new(0.0, height, 0.0), ..sun(DVec3::NEG_Y) };
        scene.lights = vec![lamp];
        assert_eq!(decided(&scene, &settings, "floor.0", "self-shadow").0, grazes, "{height}");
    }
    // On a bent sheet every light may graze.
    scene.lights = vec![sun(DVec3::NEG_Y)];
    assert!(!decided(&scene, &settings, "floor.0", "self-shadow").0);
    scene.meshes[0].primitives[0].positions[2].y += 0.3;
    assert!(decided(&scene, &settings, "floor.0", "self-shadow").0);
}
