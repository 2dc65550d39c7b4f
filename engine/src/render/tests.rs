//! The renderer on a small scene of its own.

use glam::{DAffine2, DAffine3, DVec3, Vec2, Vec3};

use super::variant::Geometry;
use super::*;
use crate::gpu::{Access, ContextDesc, Image, ImageDesc, read_image, run_once};
use crate::scene::{
    Ambient, Camera, Displacement, HeightMap, HeightSource, HeightTexels, Instance, Material, Mesh, Primitive,
    Procedure, Wrap,
};
use crate::settings::{March, Shell, Validation};
use crate::shell::{
    prisms,
    reference::{Reference, Shadows},
};

/// A square of side 2 under a checkered map, seen from above at an angle.
fn scene() -> Scene {
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    let primitive = Primitive {
        material: 0,
        positions: corners.map(|[x, z]| Vec3::new(x, 0.0, -z)).to_vec(),
        normals: vec![Vec3::Y; 4],
        tangents: Vec::new(),
        own_tangents: false,
        uvs: [corners.map(|[x, z]| Vec2::new(x, z)).to_vec(), Vec::new()],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        weld: vec![0, 1, 2, 3],
        displacement_scale: 0.2,
    };
    let material = Material {
        name: "checkers".into(),
        displacement: Some(Displacement {
            source: HeightSource::Map(0),
            wrap: [Wrap::Repeat; 2],
            tex_coord: 0,
            transform: DAffine2::IDENTITY,
            scale: 0.2,
            relative: false,
            midlevel: 0.5,
            border_wall: false,
        }),
        ..Material::default()
    };
    let texels = (0..64).map(|i| if (i + i / 8) % 2 == 0 { 0 } else { u16::MAX }).collect();
    Scene {
        file: "checkers".into(),
        meshes: vec![Mesh {
            name: "square".into(),
            primitives: vec![primitive],
            shell_normals: vec![DVec3::Y; 4],
            deforms: false,
        }],
        materials: vec![material],
        images: Vec::new(),
        height_maps: vec![HeightMap {
            name: "checkers".into(),
            width: 8,
            height: 8,
            texels: HeightTexels::U16(texels),
        }],
        instances: vec![Instance { name: "square".into(), mesh: 0, transform: DAffine3::IDENTITY }],
        camera: Some(Camera::look_at(DVec3::new(0.0, 1.5, 2.5), DVec3::ZERO, 60.0).unwrap()),
        lights: Vec::new(),
        ambient: Ambient::default(),
        notices: Vec::new(),
    }
}

const COLOR_FORMAT: vk::Format = vk::Format::R8G8B8A8_SRGB;

fn renderer(scene: &Scene, settings: &Settings) -> (Context, Renderer) {
    let features = features(scene, settings, false);
    let ctx = Context::new(&ContextDesc {
        validation: Validation::Sync,
        required: &features.required,
        optional: &features.optional,
        alternatives: &features.alternatives,
        ..ContextDesc::default()
    })
    .unwrap();
    let compiler = shader_compiler(None).unwrap();
    let output = Output { color_format: COLOR_FORMAT, aov: true };
    let renderer = Renderer::new(&ctx, &compiler, scene, settings, output).unwrap();
    (ctx, renderer)
}

/// Draws it once; the surface and the loops that reached their limit.
fn draw(settings: &Settings) -> (Aov, Option<u32>) {
    let (_, aov, [limits, _]) = draw_counting(settings);
    (aov, limits)
}

/// The same: the picture's pixels before the surface, and the reads of height maps behind the loops.
fn draw_counting(settings: &Settings) -> (Vec<[u8; 4]>, Aov, [Option<u32>; 2]) {
    let scene = scene();
    let (ctx, mut renderer) = renderer(&scene, settings);
    let target = Image::new(
        &ctx,
        &ImageDesc {
            name: "picture",
            extent: [96, 64],
            format: COLOR_FORMAT,
            usage: vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::TRANSFER_SRC,
            ..ImageDesc::default()
        },
    )
    .unwrap();
    run_once(&ctx, |cmd| {
        cmd.image_barrier(&target, Access::UNDEFINED, Access::COLOR_WRITE);
        renderer.record(cmd, 0, &scene.camera.unwrap(), &target, None)
    })
    .unwrap();
    let counted = [renderer.limits_reached(0).unwrap(), renderer.height_reads(0).unwrap()];
    let pixels = bytemuck::pod_collect_to_vec(&read_image(&ctx, &target, Access::COLOR_WRITE).unwrap());
    let drawn = (pixels, renderer.read_aov().unwrap(), counted);
    ctx.check_validation().unwrap();
    drawn
}

#[test]
fn a_loop_that_gives_up_is_counted() {
    let counted = Settings { count_limits: true, ..Settings::default() };
    for shell in [Shell::Prism, Shell::Walk, Shell::Off] {
        let counted = Settings { shell, ..counted.clone() };
        let (_, limits) = draw(&counted);
        assert_eq!(limits, Some(0), "{shell}: the default limit is never reached");
        let (_, limits) = draw(&Settings { step_limit: 0, ..counted });
        assert!(limits.is_some_and(|n| n > 500), "{shell}: {limits:?}");
    }
    let (_, limits) = draw(&Settings::default());
    assert_eq!(limits, None, "nothing is counted unless asked for");
}

#[test]
fn reads_of_height_maps_are_counted() {
    let reads = |settings: Settings| {
        let (_, aov, [limits, reads]) = draw_counting(&Settings { count_reads: true, ..settings });
        assert_eq!(limits, None, "loops are not counted");
        let covered = aov.depth.iter().filter(|z| z.is_finite()).count() as u32;
        (reads.expect("they are counted"), covered)
    };
    // On the flat square, which no fragment covers twice, a pixel reads its slope for the geometric and the shading normal;
    // what moves the texture also the height.
    let base = |march| reads(Settings { shell: Shell::Off, march, ..Settings::default() });
    let [normal, offset] = [March::Normal, March::Offset].map(base);
    assert!(normal.1 > 500 && normal.0 % normal.1 == 0 && offset.0 % offset.1 == 0, "{normal:?} {offset:?}");
    assert!(normal.0 > 0 && offset.0 / offset.1 > normal.0 / normal.1, "{normal:?} {offset:?}");
    let steps =
        |steps| reads(Settings { march: March::Pom, min_steps: steps, max_steps: steps, ..Settings::default() });
    let [few, many] = [4, 64].map(steps);
    assert!(few.0 > few.1 && many.0 > 4 * few.0 && many.0 < 80 * many.1, "{few:?} {many:?}");
    let exact = reads(Settings::default());
    assert!((exact.1..200 * exact.1).contains(&exact.0), "{exact:?}");
    let (_, _, counted) = draw_counting(&Settings::default());
    assert_eq!(counted, [None; 2], "nothing is counted unless asked for");
}

#[test]
fn a_pixel_whose_loop_gives_up_is_red_in_the_view_of_limits() {
    let red = |settings: &Settings| {
        let (pixels, aov, _) = draw_counting(settings);
        let red = |(pixel, depth): &(&[u8; 4], &f32)| depth.is_finite() && pixel[..3] == [255, 0, 0];
        let covered = aov.depth.iter().filter(|depth| depth.is_finite()).count();
        (pixels.iter().zip(&aov.depth).filter(red).count(), covered)
    };
    let viewed = Settings { shell: Shell::Off, view: View::Limits, ..Settings::default() };
    let (none, covered) = red(&viewed);
    assert!(none == 0 && covered > 500, "{none} of {covered}");
    let (all, covered) = red(&Settings { step_limit: 0, ..viewed });
    assert!(all == covered && covered > 500, "{all} of {covered}");
}

#[test]
fn a_pixel_has_the_reference_s_depth() {
    let scene = scene();
    let reference = Reference::new(&scene).render(&scene.camera.unwrap(), 96, 64, Shadows::Skip);
    let covered = reference.depth.iter().filter(|d| d.is_finite()).count();
    assert!(covered > 500, "{covered}");
    let relief =
        Settings { march: March::Relief, min_steps: 512, max_steps: 512, refine_steps: 16, ..Settings::default() };
    // A linear search may step over a peak; the exact march may not. A hundredth of a pixel's footprint: where the ray
    // grazes a peak, f32 rounding of heights moves the hit that far.
    let tolerance = 0.01 * 2.0 * 30f32.to_radians().tan() / 64.0;
    for (settings, most) in [(Settings::default(), 0), (relief, covered / 100)] {
        let (drawn, _) = draw(&settings);
        let differs = |(a, b): &(&f32, &f32)| a.is_finite() != b.is_finite() || (*a - *b).abs() > tolerance * *b;
        let wrong = drawn.depth.iter().zip(&reference.depth).filter(differs).count();
        assert!(wrong <= most, "{}: {wrong} of {covered}", settings.march);
    }
}

/// The square in two: the second triangle is plain, of a primitive and a material of its own.
fn half_plain() -> Scene {
    let mut scene = scene();
    scene.materials.push(Material::default());
    let primitives = &mut scene.meshes[0].primitives;
    let whole = primitives.remove(0);
    for (material, first, displacement_scale) in [(0, 0, whole.displacement_scale), (1, 1, 0.0)] {
        let corners = whole.triangles[first].map(|v| v as usize);
        primitives.push(Primitive {
            material,
            displacement_scale,
            positions: corners.map(|v| whole.positions[v]).to_vec(),
            normals: corners.map(|v| whole.normals[v]).to_vec(),
            uvs: [corners.map(|v| whole.uvs[0][v]).to_vec(), Vec::new()],
            weld: corners.map(|v| whole.weld[v]).to_vec(),
            triangles: vec![[0, 1, 2]],
            ..whole.clone()
        });
    }
    scene
}

/// What the fragment shader of each pipeline reads.
fn reads(renderer: &Renderer) -> Vec<(String, Vec<String>)> {
    let bindings = |pipeline: &Pipeline| {
        let shader = pipeline.shaders().last().unwrap().clone();
        shader.reflection.bindings.iter().map(|b| b.name.clone()).collect()
    };
    renderer.pipelines().into_iter().map(|(name, pipeline)| (name, bindings(pipeline))).collect()
}

/// A strip of squares, each but the first a field of its own.
fn fields(count: usize) -> Scene {
    let mut scene = scene();
    let mesh = &mut scene.meshes[0];
    let square = mesh.primitives.remove(0);
    mesh.shell_normals = vec![DVec3::Y; 2 * count + 2];
    for n in 0..count {
        let mut primitive = Primitive { material: n, displacement_scale: 0.2 + 0.01 * n as f64, ..square.clone() };
        primitive.positions.iter_mut().for_each(|p| p.x += 2.0 * n as f32);
        primitive.weld = [2 * n, 2 * n + 2, 2 * n + 3, 2 * n + 1].map(|v| v as u32).to_vec();
        mesh.primitives.push(primitive);
        scene.materials.push(scene.materials[0].clone());
    }
    scene
}

#[test]
fn a_shell_binds_the_maps_of_the_fields_that_it_meets() {
    // One pipeline a primitive.
    let settings = Settings { shell: Shell::Prism, ..Settings::default() };
    let (ctx, renderer) = renderer(&fields(3), &settings);
    ctx.check_validation().unwrap();
    let others = |(_, names): &(String, Vec<String>)| names.iter().filter(|n| n.starts_with("other_map")).count();
    // The ends of the strip meet one, its middle two.
    let mut counts: Vec<usize> = reads(&renderer).iter().map(others).collect();
    counts.sort_unstable();
    assert_eq!(counts, [1, 2]);
    assert_eq!(renderer.plan().notices, [""; 0]);
    let mut scene = fields(3);
    scene.materials[1].displacement.as_mut().unwrap().source = HeightSource::Procedure(Procedure::Waves);
    let (ctx, mixed) = self::renderer(&scene, &settings);
    ctx.check_validation().unwrap();
    let mut counts: Vec<usize> = reads(&mixed).iter().map(others).collect();
    counts.sort_unstable();
    assert_eq!(counts, [0, 2], "a function in the middle takes no sampler");
    let (_, alone) = self::renderer(&fields(1), &settings);
    assert_eq!(reads(&alone).iter().map(others).collect::<Vec<_>>(), [0], "a lone field reads no other");
}

#[test]
fn fields_beyond_the_most_are_told() {
    let most = prisms::MAX_OTHERS;
    let mut scene = fields(2);
    let mesh = &mut scene.meshes[0];
    // Copies of both squares, far apart: the left ones are one primitive, each right one is a field of its own.
    let [left, right] = [0, 1].map(|p| mesh.primitives[p].clone());
    mesh.primitives.truncate(1);
    mesh.shell_normals = vec![DVec3::Y; 6 * (most + 2)];
    for n in 1..most + 2 {
        let strip = |primitive: &Primitive| {
            let mut copy = primitive.clone();
            copy.positions.iter_mut().for_each(|p| p.z += 4.0 * n as f32);
            copy.weld.iter_mut().for_each(|w| *w += 6 * n as u32);
            copy
        };
        let (left, mut right) = (strip(&left), strip(&right));
        let all = &mut mesh.primitives[0];
        let first = all.positions.len() as u32;
        all.triangles.extend(left.triangles.iter().map(|t| t.map(|v| v + first)));
        all.positions.extend(left.positions);
        all.normals.extend(left.normals);
        all.weld.extend(left.weld);
        all.uvs[0].extend(left.uvs[0].iter());
        right.displacement_scale = 0.2 + 0.01 * n as f64;
        mesh.primitives.push(right);
    }
    let plan = plan::plan(&scene, &Settings::default(), Stage::Mesh, true);
    assert_eq!(plan.primitives[0].shell.others.len(), most);
    let [notice] = &plan.notices[..] else { panic!("{:?}", plan.notices) };
    assert!(notice.contains("primitive 0") && notice.contains("at 1 edge") && notice.contains("stay open"), "{notice}");
}

#[test]
fn a_plain_neighbour_is_traced_without_a_height_map() {
    let (ctx, renderer) = renderer(&half_plain(), &Settings::default());
    ctx.check_validation().unwrap();
    let names: Vec<String> = renderer.pipelines().into_iter().map(|(name, _)| name).collect();
    assert_eq!(names, ["shell walk lids exact", "shell walk borders exact", "shell plain"]);
    let [displaced, plain] = [0, 2].map(|i| renderer.pipelines()[i].1.shaders().last().unwrap().clone());
    let reads = |shader: &crate::gpu::Shader, name| shader.reflection.bindings.iter().any(|b| b.name == name);
    for name in ["height_map", "pyramid"] {
        assert!(reads(&displaced, name) && !reads(&plain, name), "{name}");
    }
    let [displaced, plain] = [displaced.spirv.len(), plain.spirv.len()];
    assert!(plain * 2 < displaced, "{plain} words of {displaced}: the march is still there");
}

#[test]
fn a_plain_primitive_that_touches_no_shell_is_rasterised() {
    let mut scene = half_plain();
    for vertex in &mut scene.meshes[0].primitives[1].weld {
        *vertex += 4;
    }
    scene.meshes[0].shell_normals = vec![DVec3::Y; 8];
    let plan = plan::plan(&scene, &Settings::default(), Stage::Mesh, true);
    let drawn: Vec<Geometry> = plan.draws.iter().map(|d| d.variant.geometry).collect();
    assert_eq!(drawn, [Geometry::Lids(Stage::Mesh), Geometry::Borders(Stage::Mesh), Geometry::Surface]);
}

#[test]
fn primitives_of_a_mesh_meet_to_the_bit() {
    let mut scene = half_plain();
    // Off every power of two, so that one centre more would round otherwise.
    for primitive in &mut scene.meshes[0].primitives {
        primitive.positions.iter_mut().for_each(|p| *p = *p * 0.1 + Vec3::new(0.3, 7.1, -0.7));
    }
    let settings = Settings::default();
    let plan = plan::plan(&scene, &settings, Stage::Mesh, true);
    let data: Vec<_> =
        plan.primitives.iter().map(|planned| geometry::PrimitiveData::new(&scene, planned, &settings)).collect();
    assert_eq!(data[0].center, data[1].center);
    let vertex = |primitive: usize, weld: u32| {
        let at = scene.meshes[0].primitives[primitive].weld.iter().position(|w| *w == weld).unwrap();
        let vertex = data[primitive].vertices[at];
        [vertex.position, vertex.shell].map(|v| v.truncate().to_array().map(f32::to_bits))
    };
    for weld in [0, 2] {
        assert_eq!(vertex(0, weld), vertex(1, weld));
    }
}

#[test]
fn only_what_decides_its_coverage_is_shaded_sample_by_sample() {
    let mut scene = half_plain();
    // Apart, so that the plain half is no part of the shell.
    for vertex in &mut scene.meshes[0].primitives[1].weld {
        *vertex += 4;
    }
    scene.meshes[0].shell_normals = vec![DVec3::Y; 8];
    let asks = |draw: &plan::Draw| draw.variant.defines().iter().any(|(name, _)| *name == "SAMPLE_SHADING");
    let one = plan::plan(&scene, &Settings::default(), Stage::Mesh, true);
    assert!(one.aov_draws.is_empty() && !one.draws.iter().any(asks));
    let settings = Settings { msaa: 4, shadow_map: true, ..Settings::default() };
    let four = plan::plan(&scene, &settings, Stage::Mesh, true);
    assert_eq!(four.draws.iter().map(asks).collect::<Vec<_>>(), [true, true, false]);
    assert!(four.draws.iter().all(|draw| draw.variant.samples == 4 && !draw.variant.aov));
    assert!(four.aov_draws.iter().all(|draw| draw.variant.samples == 1 && draw.variant.aov));
    assert_eq!(four.aov_draws.len(), four.draws.len());
    for maps in four.shadow_maps.iter() {
        assert!(maps.draws.iter().all(|draw| draw.variant.samples == 1), "a map has one sample a texel");
    }
    assert_eq!(features(&scene, &settings, false).required, [crate::gpu::Feature::SampleRateShading]);
    assert!(features(&scene, &Settings::default(), false).required.is_empty());
}
