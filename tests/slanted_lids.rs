//! The walk under lids that are far from level: a map that climbs over the whole mesh, on a few large triangles of curved
//! surfaces. Each triangle's lid is slanted, and the prism that the raster names is often not the one the ray is in.

mod rig;

use std::f64::consts::{PI, TAU};

use glam::{DAffine2, DAffine3, DVec2, DVec3, Vec2};
use prism_engine::{
    measure::Metrics,
    scene::{
        Ambient, Camera, Displacement, HeightMap, HeightSource, HeightTexels, Instance, Material, Mesh, Primitive,
        Projection, Scene, Wrap,
    },
    settings::Shell,
    shell::reference::{Reference, Shadows},
};
use rig::{
    Rig, STAGES,
    exactness::{ABOVE_1, COVERAGE, DEPTH_P99},
    random::Random,
};

const SIZE: [u32; 2] = [160, 120];
/// Views of each mesh: from anywhere, along the surface, with parallel rays, of each a third.
const VIEWS: usize = 18;

/// A ramp up the map with bumps on it.
fn ramp() -> HeightMap {
    const N: u32 = 64;
    let height = |i: u32| {
        let (u, v) = (f64::from(i % N) / f64::from(N), f64::from(i / N) / f64::from(N));
        let ramp = 0.35 + 0.3 * (TAU * u).cos() + 0.25 * (PI * v).sin();
        ((ramp + 0.08 * (5.0 * TAU * u).sin() * (7.0 * TAU * v).cos()).clamp(0.0, 1.0) * 65535.0) as u16
    };
    HeightMap { name: "ramp".into(), width: N, height: N, texels: HeightTexels::U16((0..N * N).map(height).collect()) }
}

/// A grid of `columns` × `rows` cells, each point a position and a normal; points at one place are one.
fn grid(name: &str, [columns, rows]: [u32; 2], scale: f64, point: impl Fn(DVec2) -> [DVec3; 2]) -> Scene {
    let mut primitive = Primitive {
        material: 0,
        positions: Vec::new(),
        normals: Vec::new(),
        tangents: Vec::new(),
        own_tangents: false,
        uvs: [Vec::new(), Vec::new()],
        triangles: Vec::new(),
        weld: Vec::new(),
        displacement_scale: scale,
    };
    let mut shell_normals = Vec::new();
    let mut places: Vec<DVec3> = Vec::new();
    for (x, y) in (0..=rows).flat_map(|y| (0..=columns).map(move |x| (x, y))) {
        let uv = DVec2::new(f64::from(x) / f64::from(columns), f64::from(y) / f64::from(rows));
        let [at, normal] = point(uv);
        let place = places.iter().position(|p| p.distance(at) < 1e-6).unwrap_or_else(|| {
            places.push(at);
            shell_normals.push(normal.normalize());
            places.len() - 1
        });
        primitive.positions.push(places[place].as_vec3());
        primitive.normals.push(normal.normalize().as_vec3());
        primitive.uvs[0].push(uv.as_vec2() * Vec2::new(1.0, 0.97));
        primitive.weld.push(place as u32);
    }
    for (x, y) in (0..rows).flat_map(|y| (0..columns).map(move |x| (x, y))) {
        let first = y * (columns + 1) + x;
        for triangle in [[first, first + columns + 1, first + 1], [first + 1, first + columns + 1, first + columns + 2]]
        {
            let [a, b, c] = triangle.map(|v| primitive.weld[v as usize]);
            if a != b && b != c && c != a {
                primitive.triangles.push(triangle);
            }
        }
    }
    let displacement = Displacement {
        source: HeightSource::Map(0),
        wrap: [Wrap::Repeat; 2],
        tex_coord: 0,
        transform: DAffine2::IDENTITY,
        scale,
        relative: false,
        midlevel: 0.3,
        border_wall: false,
    };
    Scene {
        file: name.into(),
        meshes: vec![Mesh { name: name.into(), primitives: vec![primitive], shell_normals, deforms: false }],
        materials: vec![Material { name: name.into(), displacement: Some(displacement), ..Material::default() }],
        images: Vec::new(),
        height_maps: vec![ramp()],
        instances: vec![Instance { name: name.into(), mesh: 0, transform: DAffine3::IDENTITY }],
        camera: None,
        lights: Vec::new(),
        ambient: Ambient::default(),
        notices: Vec::new(),
    }
}

/// From anywhere, close along the mesh's side, or with parallel rays.
fn view(number: usize, random: &mut Random) -> Camera {
    let direction = random.in_ball().normalize();
    let target = 0.4 * random.in_ball();
    match number % 3 {
        0 => Camera::look_at(direction * (2.0 + 2.0 * random.next()), target, 30.0 + 30.0 * random.next()),
        1 => {
            // Past the rim: what is seen is seen at a small angle.
            let side = direction.cross(random.in_ball()).normalize();
            Camera::look_at(1.9 * direction + 0.9 * side, 1.0 * side, 40.0)
        }
        _ => Camera::look_at(3.0 * direction, target, 30.0).map(|camera| {
            let projection = Projection::Orthographic { y_mag: 1.2, near: 0.01, far: 10.0 };
            Camera { projection, ..camera }
        }),
    }
    .expect("two points")
}

fn near_the_truth(scene: &Scene, seed: u64) {
    let name = scene.file.display();
    let (rig, reference) = (Rig::new(), Reference::new(scene));
    let mut easels = STAGES.map(|stage| (stage, rig.easel(scene, &rig::exact(Shell::Walk, stage), SIZE)));
    let mut random = Random(seed);
    // The figures are those of all views together.
    // Pixels, those off by more than a footprint, those that one picture alone covers; of all views and both stages.
    let (mut covered, mut off, mut uncovered, mut worst) = (0.0, 0.0, 0.0, 0f64);
    for number in 0..VIEWS {
        let camera = view(number, &mut random);
        let truth = reference.render(&camera, SIZE[0], SIZE[1], Shadows::Skip);
        for (stage, easel) in &mut easels {
            easel.assert_stage(*stage);
            let test = easel.draw(&camera);
            assert_eq!(easel.limits_reached(), 0, "{name}, view {number}, {stage}: loops gave up");
            let m = Metrics::between(&test, &truth, &camera);
            assert_eq!(m.nan_count, 0, "{name}, view {number}, {stage}");
            let pixels = m.covered as f64;
            covered += pixels;
            off += pixels * m.depth_above_1;
            uncovered += pixels * m.coverage_differs;
            worst = worst.max(m.depth_p99);
            if m.depth_above_1 + m.coverage_differs > 0.0 {
                println!("{name}, view {number}, {stage}: {m:?}");
            }
            for line in rig::worst::lines(&test, &truth, &camera, rig::worst::asked()) {
                println!("{line}");
            }
        }
    }
    println!(
        "{name}: {covered} pixels; off by a footprint {off:.0}, covered in one picture only {uncovered:.0}; worst p99 {worst:.1e}"
    );
    assert!(covered > 2000.0 * (VIEWS * STAGES.len()) as f64, "{name}: only {covered} pixels");
    assert!(worst <= DEPTH_P99, "{name}: p99 {worst}");
    assert!(off <= ABOVE_1 * covered, "{name}: {off} pixels are off by more than a footprint");
    assert!(uncovered <= COVERAGE * covered, "{name}: {uncovered} pixels are covered in one picture only");
}

/// Closed: a seam, and poles around which many triangles meet.
#[test]
fn on_a_ball() {
    let ball = grid("ball", [9, 5], 0.45, |uv| {
        let (theta, phi) = (PI * uv.y, TAU * uv.x);
        let at = DVec3::new(theta.sin() * phi.cos(), theta.cos(), -theta.sin() * phi.sin());
        // The pole and the meridian of the seam at one place, to the bit.
        let at = if theta.sin().abs() < 1e-9 { DVec3::Y * theta.cos().signum() } else { at };
        [at, at]
    });
    near_the_truth(&ball, 1);
}

/// Open, curved both ways.
#[test]
fn on_a_saddle() {
    let saddle = grid("saddle", [5, 5], 0.5, |uv| {
        let (x, z) = (2.0 * uv.x - 1.0, 2.0 * uv.y - 1.0);
        [DVec3::new(x, 0.5 * (x * x - z * z), z), DVec3::new(-x, 1.0, z)]
    });
    near_the_truth(&saddle, 2);
}

/// Closed and hollow: rays leave through the lid and come back through another.
#[test]
fn on_a_coarse_torus() {
    let torus = grid("torus", [8, 6], 0.25, |uv| {
        let (phi, theta) = (TAU * uv.x, TAU * uv.y);
        let out = DVec3::new(phi.cos(), 0.0, -phi.sin());
        let normal = theta.cos() * out + DVec3::Y * -theta.sin();
        [0.75 * out + 0.4 * normal, normal]
    });
    near_the_truth(&torus, 3);
}
