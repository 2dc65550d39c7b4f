//! What a base surface takes from its mesh and from the pixel: tangent frames, and the LOD of its heights.

mod common;

use std::path::Path;

use common::{Frame, Gltf, Lens, Map, Shape, Wrap, asset, draw, folder};
use glam::{DVec3, Vec3};
use prism_engine::{
    aov::Aov,
    gpu::ShaderStage,
    measure::Metrics,
    render::{self, plan},
    scene,
    settings::{March, Settings, Shell, Stage, Tangents},
    shell::reference::{Reference, Shadows},
};
use serde_json::json;

fn render(scene: &Path, flags: &str) -> Aov {
    let folder = folder();
    draw("render", scene).words(&format!("{flags} --aov frame.exr")).within(folder.path()).succeeds();
    Frame::read(&folder.path().join("frame.exr")).aov()
}

/// Eyes that see the sheet's front and its back.
const FRONT: [f64; 3] = [0.8, -1.6, 1.9];
const BACK: [f64; 3] = [0.8, -1.6, -1.9];

/// u runs outward on both sides of x = 0, mirrored, and both coordinates lean: u = 0.7 |x| + 0.3 y, v = -0.8 y.
fn mirrored_sheet(eye: [f64; 3]) -> Gltf {
    let mut shape = Shape::default();
    for side in [-1.0f32, 1.0] {
        let first = shape.positions.len() as u32;
        // Counter-clockwise from the front, whichever side.
        for (along, y) in [(0.0, 1.0), (0.0, -1.0), (1.0, -1.0), (1.0, 1.0)] {
            shape.positions.push([side * along, y, 0.0]);
            shape.normals.push([0.0, 0.0, 1.0]);
            shape.uvs.push([0.7 * along + 0.3 * y, -0.8 * y]);
        }
        let [a, b, c, d] = [0, 1, 2, 3].map(|i| first + i);
        let triangles = [[a, b, c], [a, c, d]];
        shape.triangles.extend(triangles.map(|[p, q, r]| if side > 0.0 { [p, q, r] } else { [p, r, q] }));
    }
    let texels: Vec<u16> = (0..256u16).map(|i| i.wrapping_mul(40503) ^ 0x5a5a).collect();
    let mut gltf = Gltf::new();
    let displacement = json!({ "scale": 0.05, "midlevel": 1.0 });
    let material = gltf.displaced("sheet", &Map::sixteen(16, &texels), [Wrap::Repeat; 2], displacement);
    let mesh = gltf.mesh("Sheet", &shape, material);
    // Columns: stretched, sheared and mirrored into the bargain.
    gltf.node(json!({ "mesh": mesh, "matrix": [
        -1.4, 0.0, 0.0, 0.0, 0.3, 0.9, 0.0, 0.0, 0.1, -0.2, 0.8, 0.0, 0.0, 0.0, 0.0, 1.0
    ] }));
    gltf.set(&format!("/materials/{material}/doubleSided"), json!(true));
    gltf.camera(&Lens::at(eye, [0.0, 0.0, 0.0]));
    gltf
}

/// Where the sheet is flat the tangent plane's ray is the true one, if handedness, lengths and shear are right.
#[test]
fn frames_are_right_on_mirrored_and_sheared_coordinates() {
    for (seen, eye) in [("front", FRONT), ("back", BACK)] {
        frames_are_right(seen, eye);
    }
}

#[track_caller]
fn frames_are_right(seen: &str, eye: [f64; 3]) {
    let folder = folder();
    let path = mirrored_sheet(eye).write(folder.path());
    let loaded = scene::load(&path).expect("a scene");
    let camera = loaded.camera.expect("a camera");
    let truth = Reference::new(&loaded).render(&camera, 160, 120, Shadows::Skip);
    for tangents in ["mesh", "derivatives"] {
        let flags = format!("--size 160x120 --shell off --march exact --tangents {tangents}");
        let (mut test, mut truth) = (render(&path, &flags), truth.clone());
        let mut sides = [0, 0];
        for i in 0..test.depth.len() {
            // Not where a ray has crossed a border or the crease.
            let [u, v] = truth.uv[i];
            let (y, along) = (v / -0.8, (u + 0.3 * v / 0.8) / 0.7);
            if truth.depth[i].is_finite() && (0.15..0.85).contains(&along) && y.abs() < 0.85 {
                sides[usize::from(truth.position[i][0] - 0.3 * truth.position[i][1] > 0.0)] += 1;
            } else {
                (test.depth[i], truth.depth[i]) = (f32::INFINITY, f32::INFINITY);
            }
        }
        let m = Metrics::between(&test, &truth, &camera);
        println!(
            "{seen}, {tangents}: {sides:?} pixels, depth p99 {:.1e} footprints, normals p99 {:.1e}°",
            m.depth_p99, m.normal_p99
        );
        assert!(sides.iter().all(|side| *side > 1000), "{seen}, {tangents}: {sides:?}");
        assert!(m.depth_p99 < 1e-3 && m.normal_p99 < 0.1, "{seen}, {tangents}: {m:?}");
        assert_eq!(m.coverage_differs, 0.0, "{seen}, {tangents}");
    }
}

/// Instructions of a SPIR-V module that take the derivative of a three-vector: of positions, here.
fn derivatives_of_vectors(spirv: &[u32]) -> usize {
    const OP_TYPE_VECTOR: u32 = 23;
    const OP_DPDX: u32 = 207;
    const OP_DPDY: u32 = 208;
    let (mut vectors, mut count) = (Vec::new(), 0);
    let mut rest = &spirv[5..];
    while let Some(first) = rest.first() {
        let (instruction, after) = rest.split_at((first >> 16) as usize);
        match (first & 0xffff, instruction) {
            (OP_TYPE_VECTOR, [_, result, _, 3]) => vectors.push(*result),
            (OP_DPDX | OP_DPDY, [_, kind, ..]) if vectors.contains(kind) => count += 1,
            _ => {}
        }
        rest = after;
    }
    count
}

/// DESIGN section 7: no derivative tangents where the mesh has its own.
#[test]
fn no_derivative_makes_a_frame_where_the_mesh_has_one() {
    let compiler = render::shader_compiler(None).expect("a compiler");
    let folder = folder();
    let loaded = scene::load(&mirrored_sheet(FRONT).write(folder.path())).expect("a scene");
    let derivatives = |scene: &scene::Scene, tangents: Tangents| {
        let settings = Settings { shell: Shell::Off, march: March::Relief, tangents, ..Settings::default() };
        plan::check(scene, &settings).expect("allowed");
        let variant = plan::plan(scene, &settings, Stage::Mesh, false).draws[0].variant;
        let shader =
            compiler.compile("render/surface.frag", ShaderStage::Fragment, &variant.defines()).expect("compiles");
        derivatives_of_vectors(&shader.spirv)
    };
    assert_eq!(derivatives(&loaded, Tangents::Mesh), 0);
    assert_eq!(derivatives(&loaded, Tangents::Derivatives), 2);
    // By default the file's own serve, and this one has none.
    assert_eq!(derivatives(&loaded, Tangents::Auto), 2);
    let mut own = loaded.clone();
    own.meshes[0].primitives[0].own_tangents = true;
    assert_eq!(derivatives(&own, Tangents::Auto), 0);
    // A normal map along other coordinates has the tangents follow those.
    let mut turned = own.clone();
    let displacement = turned.materials[0].displacement.as_mut().expect("displaced");
    displacement.transform = glam::DAffine2::from_angle(0.5);
    let texture = scene::TextureRef {
        image: 0,
        sampler: scene::Sampler::default(),
        tex_coord: 0,
        transform: glam::DAffine2::IDENTITY,
    };
    turned.materials[0].normal = Some((texture, 1.0));
    let flat = [128, 128, 255, 255].repeat(4);
    turned.images.push(scene::ColorImage { name: "flat".into(), width: 2, height: 2, rgba: flat, srgb: false });
    assert_eq!(derivatives(&turned, Tangents::Auto), 2);
    let settings =
        Settings { shell: Shell::Off, march: March::Relief, tangents: Tangents::Mesh, ..Settings::default() };
    let refused = plan::check(&turned, &settings).expect_err("tangents of other coordinates");
    assert_eq!(refused.exit_code(), 2, "{refused}");
}

/// Over a ring the mesh's smooth tangents and the facets' derivatives tell nearly the same.
#[test]
fn smooth_tangents_are_near_the_facets_derivatives() {
    let frame = |tangents| {
        render(&asset("torus.gltf"), &format!("--size 96x72 --shell off --march relief --tangents {tangents}"))
    };
    let (mesh, facets) = (frame("mesh"), frame("derivatives"));
    let hit: Vec<usize> = (0..mesh.depth.len()).filter(|&i| mesh.depth[i].is_finite()).collect();
    let mut angles: Vec<f32> = hit
        .iter()
        .map(|&i| Vec3::from(mesh.normal[i]).dot(Vec3::from(facets.normal[i])).clamp(-1.0, 1.0).acos().to_degrees())
        .collect();
    angles.sort_unstable_by(f32::total_cmp);
    let (median, differ) = (angles[angles.len() / 2], angles.iter().filter(|a| **a > 0.0).count());
    println!("torus: {} pixels, {differ} differ, normals by {median}° in the median", hit.len());
    assert!(hit.len() > 1500 && differ > hit.len() / 4 && median < 2.0);
}

/// The LOD of a pixel of a map of `texels` a unit on the floor y = 0, seen from `eye` toward the origin; none beside it.
fn floor_lod(eye: DVec3, [width, height]: [usize; 2], i: usize) -> Option<f64> {
    let forward = -eye.normalize();
    let (right, slope) = (DVec3::X, (0.698131701f64 / 2.0).tan());
    let texel = |x: usize, y: usize| {
        let across = (2.0 * (x as f64 + 0.5) - width as f64) / height as f64;
        let up = 1.0 - 2.0 * (y as f64 + 0.5) / height as f64;
        let ray = forward + slope * (across * right + up * right.cross(forward));
        let at = eye - ray * (eye.y / ray.y);
        (ray.y < 0.0 && at.x.abs() < 1.0 && at.z.abs() < 1.0).then_some(256.0 * at)
    };
    let (x, y) = (i % width, i / width);
    let [here, beside, below] = [texel(x, y)?, texel(x + 1, y)?, texel(x, y + 1)?];
    Some(here.distance(beside).max(here.distance(below)).log2())
}

/// Each pixel of the floor lies between the pictures of the mips around its LOD, and none strays: what a derivative
/// within the loop would make of every step's edge.
#[test]
fn each_pixel_reads_heights_at_its_own_lod() {
    let eye = DVec3::new(0.0, 0.55, 2.3);
    let size = [160, 120];
    let view =
        "--size 160x120 --eye 0,0.55,2.3 --target 0,0,0 --shell off --march relief --max-steps 64 --min-steps 64";
    let frame = |lod: &str| render(&asset("plane.gltf"), &format!("{view} --height-lod {lod}"));
    let auto = frame("auto");
    let fixed: Vec<Aov> = (0..5).map(|lod| frame(&lod.to_string())).collect();
    let (mut counted, mut beyond, mut stray, mut from_first, mut off) = (0, 0, 0, 0.0, 0.0);
    for i in 0..auto.depth.len() {
        let Some(lod) = floor_lod(eye, size, i).filter(|lod| *lod < 4.0 && auto.depth[i].is_finite()) else {
            continue;
        };
        let (low, high) = (&fixed[lod.floor().max(0.0) as usize], &fixed[lod.ceil().max(0.0) as usize]);
        let (a, b, h) = (low.height_at_hit[i], high.height_at_hit[i], auto.height_at_hit[i]);
        let outside = (a.min(b) - h).max(h - a.max(b));
        counted += 1;
        // Between two mips the surface is a blend of theirs, whose hit may lie somewhat beside both.
        beyond += usize::from(outside > 0.05);
        stray += usize::from(outside > 0.3);
        off += f64::from((h - 0.5 * (a + b)).abs());
        from_first += f64::from((h - fixed[0].height_at_hit[i]).abs());
    }
    println!(
        "{counted} pixels, {beyond} beyond their mips, {stray} far; mean {:.4} from them, {:.4} from mip 0",
        off / counted as f64,
        from_first / counted as f64
    );
    assert!(counted > 3000 && beyond < counted / 50 && stray <= counted / 500);
    assert!(off < 0.6 * from_first, "{off} {from_first}");
}

/// Near enough that a texel spans pixels the map itself is read. Two shaders of the same operations round apart: on
/// lavapipe by 2 ulp of the depth at most, in a tenth of the pixels.
#[test]
fn near_by_the_map_itself_is_read() {
    let view = "--size 192x144 --eye 0,0.2,0.05 --target 0,0,0 --shell off --march relief";
    let [auto, fixed] = ["auto", "0"].map(|lod| render(&asset("plane.gltf"), &format!("{view} --height-lod {lod}")));
    let covered = auto.depth.iter().filter(|depth| depth.is_finite()).count();
    let apart = |i: usize| (auto.depth[i] - fixed.depth[i]).abs() / fixed.depth[i];
    let worst = (0..auto.depth.len()).filter(|&i| fixed.depth[i].is_finite()).map(apart).fold(0.0, f32::max);
    println!("{covered} covered, {:.1} ulp apart at most", worst / f32::EPSILON);
    assert!(covered > 20_000 && worst <= 8.0 * f32::EPSILON, "{covered} covered, {worst:e} apart");
}
