//! The classic marches against the f64 reference: on a flat base surface and in a shell, each with its own error, in the
//! order that its search lets one expect.

mod common;

use std::path::Path;

use common::{Frame, Picture, WAYS, asset, draw, folder};
use glam::DVec3;
use prism_engine::{
    aov::Aov,
    measure::Metrics,
    scene::{self, Camera},
    shell::reference::{Reference, Shadows},
};

const SIZE: [u32; 2] = [160, 120];
/// Few enough that each search's own error shows.
const STEPS: &str = "--min-steps 12 --max-steps 12";
/// The floor's detail is 0.12 deep, and its UVs go once around in 2 units.
const OFFSET_LIMIT: f32 = 0.06;
/// From the coarsest to the finest: no interpolation, one, several linear ones, bisection. With its usual tolerance of a
/// hundredth of the height the secant stops before them; here it may go on.
const LADDER: [(&str, &str); 5] = [
    ("steep", ""),
    ("pom", ""),
    ("contact", "--refine-steps 8"),
    ("secant", "--refine-steps 5 --tolerance 0.0001"),
    ("relief", "--refine-steps 8"),
];

fn render(scene: &Path, flags: &str) -> Aov {
    let folder = folder();
    let flags = format!("--size {}x{} {flags} --aov frame.exr", SIZE[0], SIZE[1]);
    draw("render", scene).words(&flags).within(folder.path()).succeeds();
    Frame::read(&folder.path().join("frame.exr")).aov()
}

fn reference(scene: &Path) -> (Aov, Camera) {
    let scene = scene::load(scene).expect("a scene");
    let camera = scene.camera.expect("the scene has a camera");
    (Reference::new(&scene).render(&camera, SIZE[0], SIZE[1], Shadows::Skip), camera)
}

/// Depth errors in pixel footprints: the median, and of 99 % of the pixels.
struct Off {
    p50: f64,
    p99: f64,
}

/// The errors of the marches of the ladder drawn in one way.
fn errors(scene: &Path, way: &str, truth: &(Aov, Camera), keep: impl Fn(&Aov, usize) -> bool) -> Vec<Off> {
    LADDER
        .iter()
        .map(|(march, refine)| {
            let mut test = render(scene, &format!("{way} --march {march} {STEPS} {refine}"));
            let mut truth = (truth.0.clone(), truth.1);
            for i in 0..test.depth.len() {
                if !keep(&truth.0, i) || !keep(&test, i) {
                    (test.depth[i], truth.0.depth[i]) = (f32::INFINITY, f32::INFINITY);
                }
            }
            let m = Metrics::between(&test, &truth.0, &truth.1);
            println!(
                "{way} {march:>8}: {} pixels, p50 {:.1e}, p99 {:.1e} footprints",
                m.covered, m.depth_p50, m.depth_p99
            );
            assert!(m.covered > 2000 && m.nan_count == 0, "{way} {march}: {m:?}");
            Off { p50: m.depth_p50, p99: m.depth_p99 }
        })
        .collect()
}

/// Every step of the ladder halves the error at least, but contact and secant, which are as good as each other: both
/// leave a bracket of about a hundredth of a step.
#[track_caller]
fn falls(way: &str, errors: &[f64]) {
    let [steep, pom, contact, secant, relief] = errors else { panic!("a march is missing") };
    let (better, worse) = (contact.min(*secant), contact.max(*secant));
    for (coarse, fine) in [(*steep, *pom), (*pom, worse), (better, *relief)] {
        assert!(fine < 0.5 * coarse, "{way}: {errors:?}");
    }
}

/// There the straight ray is the true one, so that what is left is the search's own. The last hundredth of the pixels is
/// that of ridges between two of twelve steps: no refinement finds what the linear search has passed, so these are equal.
#[test]
fn the_ladder_on_a_flat_base_surface() {
    let scene = asset("plane.gltf");
    let truth = reference(&scene);
    // A sheet is open at its borders, where the true ray may pass below it.
    let inner = |aov: &Aov, i: usize| aov.uv[i].iter().all(|c| (0.12..=0.88).contains(c)) && aov.depth[i].is_finite();
    let way = "--shell off --silhouette uv-bounds";
    let errors = errors(&scene, way, &truth, inner);
    falls(way, &errors.iter().map(|off| off.p50).collect::<Vec<_>>());
    let passed: Vec<f64> = errors[1..].iter().map(|off| off.p99).collect();
    assert!(passed.iter().all(|p99| (p99 / passed[0] - 1.0).abs() < 0.05), "{passed:?}");
}

/// Prisms are small, so that twelve steps in each pass hardly a ridge.
#[test]
fn the_ladder_in_a_shell() {
    let scene = asset("torus.gltf");
    let truth = reference(&scene);
    for way in [WAYS[1], WAYS[2]] {
        let errors = errors(&scene, way, &truth, |aov, i| aov.depth[i].is_finite());
        falls(way, &errors.iter().map(|off| off.p99).collect::<Vec<_>>());
    }
}

/// A point of the floor is shifted by no more than its own height, however flat the view: that is what the limit is for.
#[test]
fn offset_shifts_by_the_height_at_most() {
    let scene = asset("plane.gltf");
    for view in ["", "--eye 0,0.25,2.4 --target 0,0,0"] {
        let plain = render(&scene, &format!("{view} --shell off --march normal"));
        let shifted = render(&scene, &format!("{view} --shell off --march offset"));
        let moved = (0..plain.depth.len()).filter(|&i| plain.depth[i].is_finite());
        let lengths: Vec<f32> = moved
            .map(|i| {
                assert_eq!(plain.depth[i], shifted.depth[i], "offset moves textures, no surface");
                (plain.uv[i][0] - shifted.uv[i][0]).hypot(plain.uv[i][1] - shifted.uv[i][1])
            })
            .collect();
        let most = lengths.iter().fold(0.0, |a: f32, b| a.max(*b));
        println!("offset {view}: {} pixels, shifted by {most} at most", lengths.len());
        assert!(lengths.len() > 1000 && most > 0.5 * OFFSET_LIMIT && most <= OFFSET_LIMIT, "{view}: {most}");
    }
}

/// Eight fixed steps see nine levels; begun at a random part of the first, they see as many as there is noise.
#[test]
fn a_dithered_start_dissolves_the_layers() {
    let levels = |dither: &str| {
        let flags = format!("--shell off --march steep --min-steps 8 --max-steps 8 --dither {dither}");
        let aov = render(&asset("plane.gltf"), &flags);
        let hit = (0..aov.depth.len()).filter(|&i| aov.depth[i].is_finite());
        let mut heights: Vec<i64> = hit.map(|i| (f64::from(aov.height_at_hit[i]) * 1e4).round() as i64).collect();
        heights.sort_unstable();
        heights.dedup();
        heights.len()
    };
    let (layers, dissolved) = (levels("off"), levels("on"));
    println!("steep: {layers} levels; dithered: {dissolved}");
    assert!((3..=9).contains(&layers) && dissolved > 200, "{layers} and {dissolved}");
}

/// What goes is what the formula says, from the height at the hit and the angle of the ray; the floor's normal is up.
#[test]
fn the_horizon_cuts_by_its_formula() {
    let eye = [0.0, 0.5, 2.4];
    let view = "--eye 0,0.5,2.4 --target 0,0,0 --shell off --march relief";
    let all = render(&asset("plane.gltf"), view);
    for (strength, bias, threshold, falloff) in [(2.5, 0.0, 0.5, 2.0), (1.0, 0.2, 0.9, 1.0), (0.0, 0.0, 0.5, 2.0)] {
        let flags = format!(
            "{view} --silhouette horizon --horizon-strength {strength} --horizon-bias {bias} --horizon-threshold {threshold} \
             --horizon-falloff {falloff}"
        );
        let cut = render(&asset("plane.gltf"), &flags);
        let (mut gone, mut wrong) = (0, 0);
        for i in (0..all.depth.len()).filter(|&i| all.depth[i].is_finite()) {
            let [x, y, z] = [0, 1, 2].map(|c| f64::from(all.position[i][c]) - eye[c]);
            let cosine = (y / (x * x + y * y + z * z).sqrt()).abs();
            let f = (1.0 - cosine / threshold).clamp(0.0, 1.0).powf(falloff);
            let height = f64::from(all.height_at_hit[i]) - bias - (f * strength).clamp(0.0, 1.0);
            gone += usize::from(height < 0.0);
            // Linear interpolation leaves the level off the height by a hundredth.
            wrong += usize::from(height.abs() > 0.02 && (height < 0.0) == cut.depth[i].is_finite());
        }
        println!("horizon {strength} {bias} {threshold} {falloff}: {gone} pixels go, {wrong} wrong");
        assert!(wrong <= 5 && (gone > 100) == (strength > 0.0), "{flags}: {gone}, {wrong}");
    }
}

/// The floor's LOD in a pixel, seen from `eye` with the scene's own lens; none beside the floor. Its map has 512 texels in
/// 2 units.
fn floor_lod(eye: DVec3, x: usize, y: usize) -> Option<f64> {
    let forward = -eye.normalize();
    let (right, slope) = (DVec3::X, (0.698131701f64 / 2.0).tan());
    let texel = |x: usize, y: usize| {
        let [width, height] = SIZE.map(f64::from);
        let across = (2.0 * (x as f64 + 0.5) - width) / height;
        let up = 1.0 - 2.0 * (y as f64 + 0.5) / height;
        let ray = forward + slope * (across * right + up * right.cross(forward));
        let at = eye - ray * (eye.y / ray.y);
        (ray.y < 0.0 && at.x.abs() < 1.0 && at.z.abs() < 1.0).then_some(256.0 * at)
    };
    let [here, beside, below] = [texel(x, y)?, texel(x + 1, y)?, texel(x, y + 1)?];
    Some(here.distance(beside).max(here.distance(below)).log2())
}

/// Before the LOD it names all the detail is there, one LOD later none, in between a part that changes little by little.
#[test]
fn heights_fade_with_the_lod() {
    const START: f64 = 3.5;
    let eye = DVec3::new(0.0, 0.5, 2.4);
    let folder = folder();
    let picture = |flags: &str| {
        let view = format!("--size {}x{} --eye 0,0.5,2.4 --target 0,0,0 --shell off", SIZE[0], SIZE[1]);
        draw("render", asset("plane.gltf"))
            .words(&format!("{view} {flags} --out a.png"))
            .within(folder.path())
            .succeeds();
        Picture::read(&folder.path().join("a.png"))
    };
    let fading = |start: f64| picture(&format!("--march relief --lod-fade {start}"));
    let [full, plain, faded, later] =
        [picture("--march relief"), picture("--march none"), fading(START), fading(START + 1.0 / 32.0)];
    // Pixels, largest difference and sum of differences where the LOD, past START, is in this range.
    let between = |a: &Picture, b: &Picture, from: f64, to: f64| {
        let differences = a.differences(b);
        let pixels = (0..differences.len()).filter(|i| {
            let lod = floor_lod(eye, i % SIZE[0] as usize, i / SIZE[0] as usize);
            lod.is_some_and(|lod| (from..to).contains(&(lod - START)))
        });
        pixels.fold((0, 0, 0.0), |(count, most, sum), i| {
            (count + 1, differences[i].max(most), sum + f64::from(differences[i]))
        })
    };
    // A quad's derivatives are those of one of its pixels.
    let (near, off, _) = between(&faded, &full, -9.0, -0.15);
    assert!(near > 800 && off <= 1, "near: {near} pixels, off by {off}");
    let (far, off, _) = between(&faded, &plain, 1.15, 9.0);
    assert!(far > 200 && off <= 1, "far: {far} pixels, off by {off}");
    let [whole, to_full, to_plain, step] =
        [(&full, &plain), (&faded, &full), (&faded, &plain), (&faded, &later)].map(|(a, b)| between(a, b, 0.2, 0.8).2);
    println!("{near} near, {far} far; between: {whole}, of which {to_full} and {to_plain}; a step {step}");
    assert!(to_full > 0.2 * whole && to_plain > 0.2 * whole && step < 0.25 * whole);
}
