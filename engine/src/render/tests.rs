//! The renderer on a small scene of its own.

use glam::{DAffine2, DAffine3, DVec3, Vec2, Vec3, Vec4};

use super::*;
use crate::gpu::{ContextDesc, run_once};
use crate::scene::{Displacement, HeightMap, HeightSource, HeightTexels, Instance, Material, Mesh, Primitive, Wrap};
use crate::settings::{March, Validation};
use crate::shell::reference::{Reference, Shadows};

/// A square of side 2 under a checkered map, seen from above at an angle.
fn scene() -> Scene {
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    let primitive = Primitive {
        material: 0,
        positions: corners.map(|[x, z]| Vec3::new(x, 0.0, -z)).to_vec(),
        normals: vec![Vec3::Y; 4],
        tangents: Vec::new(),
        uvs: [corners.map(|[x, z]| Vec2::new(x, z)).to_vec(), Vec::new()],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        weld: vec![0, 1, 2, 3],
        displacement_scale: 0.2,
    };
    let material = Material {
        name: "checkers".into(),
        base_color_factor: Vec4::ONE,
        base_color: None,
        metallic: 0.0,
        roughness: 1.0,
        metallic_roughness: None,
        normal: None,
        occlusion: None,
        emissive_factor: Vec3::ZERO,
        emissive: None,
        alpha_cutoff: None,
        double_sided: false,
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
    };
    let texels = (0..64).map(|i| if (i + i / 8) % 2 == 0 { 0 } else { u16::MAX }).collect();
    Scene {
        file: "checkers".into(),
        meshes: vec![Mesh { name: "square".into(), primitives: vec![primitive], shell_normals: vec![DVec3::Y; 4] }],
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
        notices: Vec::new(),
    }
}

/// Draws it once; the surface and the loops that reached their limit.
fn draw(settings: &Settings) -> (Aov, Option<u32>) {
    let scene = scene();
    let features = features(&scene, settings, false);
    let ctx = Context::new(&ContextDesc {
        validation: Validation::Sync,
        required: &features.required,
        optional: &features.optional,
        ..ContextDesc::default()
    })
    .unwrap();
    let compiler = shader_compiler(None).unwrap();
    let color_format = vk::Format::R8G8B8A8_SRGB;
    let output = Output { color_format, aov: true };
    let mut renderer = Renderer::new(&ctx, &compiler, &scene, settings, output).unwrap();
    let target = Image::new(
        &ctx,
        &ImageDesc {
            name: "picture",
            extent: [96, 64],
            format: color_format,
            usage: vk::ImageUsageFlags::COLOR_ATTACHMENT,
            ..ImageDesc::default()
        },
    )
    .unwrap();
    run_once(&ctx, |cmd| {
        cmd.image_barrier(&target, Access::UNDEFINED, Access::COLOR_WRITE);
        renderer.record(cmd, 0, &scene.camera.unwrap(), &target, None)
    })
    .unwrap();
    let drawn = (renderer.read_aov().unwrap(), renderer.limits_reached(0).unwrap());
    ctx.check_validation().unwrap();
    drawn
}

#[test]
fn a_loop_that_gives_up_is_counted() {
    let counted = Settings { count_limits: true, ..Settings::default() };
    for shell in [crate::settings::Shell::Prism, crate::settings::Shell::Off] {
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
