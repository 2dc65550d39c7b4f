//! What the passes compute, beside the same on the CPU in f64.

use std::path::Path;

use glam::{DAffine2, DVec3, Vec3, Vec4};

use super::*;
use crate::gpu::{Access, ContextDesc, run_once};
use crate::render::{Output, Renderer, shader_compiler};
use crate::scene::{ColorImage, Mesh, Sampler, TextureRef};
use crate::settings::{Settings, Shell, Validation};
use crate::shell::{certificate, walk};

/// The bit of the same name in `shaders/render/deform.glsl`.
const LEANS: u32 = 1 << 31;

/// A scene of the project's assets whose first mesh deforms.
fn asset(name: &str) -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets").join(name);
    let mut scene = scene::load(&path).unwrap();
    scene.meshes[0].deforms = true;
    scene
}

/// Every vertex moved anyhow by up to `reach`, those of one welded vertex alike.
fn crumpled(mesh: &Mesh, reach: f64) -> Vec<Vec3> {
    let offset = |weld: u32, axis: u32| {
        let mut state = weld.wrapping_mul(747_796_405).wrapping_add(axis.wrapping_mul(2_891_336_453) + 1);
        state = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
        f64::from((state >> 22) ^ state) / f64::from(u32::MAX) * 2.0 - 1.0
    };
    let moved = |(p, weld): (&Vec3, &u32)| {
        let offset = DVec3::new(offset(*weld, 0), offset(*weld, 1), offset(*weld, 2));
        (p.as_dvec3() + reach * offset).as_vec3()
    };
    mesh.primitives.iter().flat_map(|p| p.positions.iter().zip(&p.weld)).map(moved).collect()
}

/// The mesh in a pose: per vertex the mean of the triangles around all that share its place and normal in the file.
fn posed(mesh: &Mesh, positions: &[Vec3]) -> Mesh {
    let mut posed = mesh.clone();
    let [primitive] = &mut posed.primitives[..] else { panic!("these meshes have one primitive") };
    let rest = &mesh.primitives[0];
    primitive.positions = positions.to_vec();
    for v in 0..positions.len() {
        let mut sum = DVec3::ZERO;
        for triangle in &rest.triangles {
            for k in 0..3 {
                let at = triangle[k] as usize;
                if rest.weld[at] == rest.weld[v] && rest.normals[at] == rest.normals[v] {
                    let corner = triangle.map(|v| positions[v as usize].as_dvec3());
                    let [e1, e2] = [1, 2].map(|i| corner[(k + i) % 3] - corner[k]);
                    let normal = (corner[1] - corner[0]).cross(corner[2] - corner[0]);
                    sum += e1.angle_between(e2) * normal.normalize();
                }
            }
        }
        primitive.normals[v] = sum.normalize().as_vec3();
    }
    posed.update_shell_normals();
    posed
}

/// What the GPU makes of a pose.
struct Rig {
    ctx: Context,
    renderer: Renderer,
}

impl Rig {
    fn new(scene: &Scene) -> Rig {
        let settings = Settings { shell: Shell::Walk, ..Settings::default() };
        let features = crate::render::features(scene, &settings, false);
        let ctx = Context::new(&ContextDesc {
            validation: Validation::Sync,
            required: &features.required,
            optional: &features.optional,
            alternatives: &features.alternatives,
            ..ContextDesc::default()
        })
        .unwrap();
        let compiler = shader_compiler(None).unwrap();
        let output = Output { color_format: vk::Format::R8G8B8A8_SRGB, aov: false };
        let renderer = Renderer::new(&ctx, &compiler, scene, &settings, output).unwrap();
        Rig { ctx, renderer }
    }

    fn pose(&mut self, positions: &[Vec3]) -> Result<()> {
        let pose = Pose { positions: Vectors::Slice(positions), normals: None };
        run_once(&self.ctx, |cmd| self.renderer.deform(cmd, 0, 0, &pose, None))
    }

    fn read<T: bytemuck::Pod>(&self, buffer: &Buffer) -> Vec<T> {
        let usage = vk::BufferUsageFlags::TRANSFER_DST;
        let (size, location) = (buffer.size(), MemoryLocation::GpuToCpu);
        let copy = Buffer::new(&self.ctx, &BufferDesc { name: "copy", size, usage, location }).unwrap();
        run_once(&self.ctx, |cmd| {
            cmd.copy_buffer(buffer, 0, &copy, 0, size);
            cmd.buffer_barrier(&copy, Access::TRANSFER_DST, Access::HOST_READ);
            Ok(())
        })
        .unwrap();
        copy.read().unwrap()
    }

    /// Shell normals and factors of all welded vertices, and how many triangles fold still.
    fn shells(&self) -> (Vec<Vec4>, Vec<f64>, u32) {
        let buffers = self.renderer.deformers[0].passes.buffers();
        let normals: Vec<Vec4> = self.read(&buffers.shell_normals);
        let folds: Vec<u32> = self.read(&buffers.folds);
        let rounds = (1u32 << passes::ROUNDS) - 1;
        let factor = |(normal, word): (&Vec4, &u32)| match (word & rounds).count_ones() {
            halved if halved < 7 => f64::from(normal.w) / f64::from(1 << halved),
            _ => 0.0,
        };
        let factors = normals.iter().zip(&folds).map(factor).collect();
        let folding = folds[normals.len() + passes::ROUNDS as usize];
        (normals, factors, folding)
    }
}

#[track_caller]
fn agrees(name: &str, reach: f64) {
    let scene = asset(name);
    let mut rig = Rig::new(&scene);
    let positions = crumpled(&scene.meshes[0], reach);
    rig.pose(&positions).unwrap();
    let (normals, factors, folding) = rig.shells();
    rig.ctx.check_validation().unwrap();

    let mut expected = scene.clone();
    expected.meshes[0] = posed(&scene.meshes[0], &positions);
    let mesh = &expected.meshes[0];
    let off = normals.iter().zip(&mesh.shell_normals).map(|(a, b)| a.truncate().as_dvec3().distance(*b));
    let mut off: Vec<f64> = off.collect();
    off.sort_by(f64::total_cmp);
    let [median, most] = [off[off.len() / 2], off[off.len() - 1]];
    // Most, where a pose as wild as this has triangles that nearly cancel out.
    assert!(median < 2e-7 && most < 1e-4, "shell normals are off by {median:e}, at most {most:e}");

    let folds = certificate::mesh_folds(&expected, mesh);
    let mut counts = std::collections::BTreeMap::new();
    for factor in &folds.factors {
        *counts.entry((factor * 64.0) as u32).or_insert(0) += 1;
    }
    println!(
        "{name}: normals off by {median:.1e}, at most {most:.1e}; vertices by 64 r: {counts:?}, {} triangles plain",
        folds.plain.len()
    );
    assert!(counts.len() > 3 && folds.plain.len() > 10, "the pose is to fold, in all degrees: {counts:?}");
    let wrong = (0..factors.len()).filter(|w| factors[*w] != folds.factors[*w]).count();
    assert_eq!((wrong, folding), (0, 0), "of {} factors", factors.len());

    // Which of them lean, at the levels of the mesh's own lids.
    let primitive = &mesh.primitives[0];
    let lifts = |w: &u32| (mesh.shell_normals[*w as usize] * folds.factors[*w as usize]).as_vec3();
    let shell: Vec<Vec3> = primitive.weld.iter().map(lifts).collect();
    let lids = &rig.renderer.plan().primitives[0].walk.as_ref().unwrap().lids;
    let leaning = walk::leaning(primitive, &shell, lids);
    let standing = leaning.iter().filter(|w| folds.factors[**w as usize] > 0.0).count();
    let words: Vec<u32> = rig.read(&rig.renderer.deformers[0].passes.buffers().folds);
    let wrong = (0..factors.len()).filter(|w| (words[*w] & LEANS != 0) != leaning.contains(&(*w as u32))).count();
    println!("{name}: {} lean, {standing} of them not to zero; {wrong} told otherwise", leaning.len());
    assert!(standing >= 10, "the pose is to make normals lean");
    assert_eq!(wrong, 0);
}

#[test]
fn a_crumpled_sheet_has_the_certificate_s_factors() {
    agrees("cloth.gltf", 0.07);
}

#[test]
fn a_crumpled_head_has_the_certificate_s_factors() {
    agrees("suzanne.gltf", 0.05);
}

/// MikkTSpace's tangents, where the mesh stands as in its file; its normals there are the file's.
#[test]
fn tangents_follow_the_texture() {
    let mut scene = asset("torus.gltf");
    // A flat normal map, which reads them.
    let rgba = vec![128, 128, 255, 255];
    scene.images.push(ColorImage { name: "flat".into(), width: 1, height: 1, rgba, srgb: false });
    let (image, sampler) = (scene.images.len() - 1, Sampler::default());
    let texture = TextureRef { image, sampler, tex_coord: 0, transform: DAffine2::IDENTITY };
    scene.materials[scene.meshes[0].primitives[0].material].normal = Some((texture, 1.0));
    let mut rig = Rig::new(&scene);
    let primitive = &scene.meshes[0].primitives[0];
    rig.pose(&primitive.positions).unwrap();
    let tangents: Vec<Vec4> = rig.read(rig.renderer.primitives[0].tangents.as_ref().expect("a normal map reads them"));
    assert_eq!(tangents.len(), primitive.tangents.len());
    for (tangent, expected) in tangents.iter().zip(&primitive.tangents) {
        assert!(tangent.abs_diff_eq(*expected, 2e-3), "{tangent} {expected}");
    }
    rig.ctx.check_validation().unwrap();
}

#[test]
fn a_pose_must_fit_its_mesh() {
    let mut rig = Rig::new(&asset("cloth.gltf"));
    let error = rig.pose(&[Vec3::ZERO; 7]).unwrap_err().to_string();
    assert!(error.contains("'cloth'") && error.contains('7'), "{error}");
    let pose = Pose { positions: Vectors::Slice(&[]), normals: None };
    let error = run_once(&rig.ctx, |cmd| rig.renderer.deform(cmd, 0, 3, &pose, None)).unwrap_err().to_string();
    assert!(error.contains("mesh 3"), "{error}");
}
