//! Every technique's error against the f64 reference, in the order that its search lets one expect: a table.

mod rig;

use std::fs;

use prism_engine::{
    aov::Aov,
    measure::Metrics,
    scene::{Camera, Scene},
    settings::{March, Settings, Shell, Silhouette, Stage},
    shell::reference::{Reference, Shadows},
};
use rig::{Rig, SHELLS, asset, record};

/// Few enough that each search's own error shows.
const STEPS: u32 = 12;
/// Texels a side of the map of either scene.
const TEXELS: f64 = 512.0;

/// From no ray to the first hit, with the reason for its place.
const LADDER: [(March, &str); 11] = [
    (March::None, "no height"),
    (March::Normal, "the same surface: heights only shade it"),
    (March::Offset, "textures move, the surface does not"),
    (March::Steep, "the first step below the field"),
    (March::Pom, "one interpolation"),
    (March::Contact, "eight finer steps: a hundredth of a step, as false position"),
    (March::Secant, "false position, five times"),
    (March::Relief, "eight bisections"),
    (March::RelaxedCone, "steps of a cone map, eight bisections"),
    (March::Cone, "steps of a cone map, the cell's own root"),
    (March::Exact, "the first hit, to rounding"),
];

struct Row {
    march: March,
    metrics: Metrics,
    /// Distance of half the pixels' UVs from the reference's, at most, in texels.
    uv_p50: f64,
}

fn settings(shell: Shell, march: March) -> Settings {
    Settings {
        shell,
        stage: Stage::Mesh,
        march,
        min_steps: STEPS,
        // A cone map says itself how many it takes.
        max_steps: if march.reads_cones() { 256 } else { STEPS },
        refine_steps: march.usual_refine_steps(),
        // Its usual hundredth of the range would end the secant before it is any better.
        tolerance: 1e-4,
        silhouette: if shell == Shell::Off && march.traces() { Silhouette::UvBounds } else { Silhouette::None },
        ..Settings::default()
    }
}

/// All techniques that `shell` can draw, on a scene; of the pixels that `keep` names.
fn rows(rig: &Rig, scene: &Scene, shell: Shell, size: [u32; 2], keep: impl Fn(&Aov, usize) -> bool) -> Vec<Row> {
    let camera: Camera = scene.camera.expect("the scene has a camera");
    let reference = Reference::new(scene).render(&camera, size[0], size[1], Shadows::Skip);
    let drawn = LADDER.iter().map(|(march, _)| *march).filter(|march| shell == Shell::Off || march.traces());
    drawn
        .map(|march| {
            let mut test = rig.easel(scene, &settings(shell, march), size).draw(&camera);
            let mut truth = reference.clone();
            let mut off = Vec::new();
            for i in 0..test.depth.len() {
                if !keep(&reference, i) || !test.depth[i].is_finite() {
                    (test.depth[i], truth.depth[i]) = (f32::INFINITY, f32::INFINITY);
                    continue;
                }
                let [u, v] = [0, 1].map(|c| f64::from(test.uv[i][c] - truth.uv[i][c]));
                off.push(TEXELS * u.hypot(v));
            }
            off.sort_unstable_by(f64::total_cmp);
            let metrics = Metrics::between(&test, &truth, &camera);
            assert!(metrics.covered > 1500 && metrics.nan_count == 0, "{shell} {march}: {metrics:?}");
            let row = Row { march, metrics, uv_p50: off[off.len() / 2] };
            println!("{shell} {}", line(&row));
            row
        })
        .collect()
}

fn line(row: &Row) -> String {
    let m = &row.metrics;
    let why = LADDER.iter().find(|(march, _)| *march == row.march).map_or("", |(_, why)| why);
    format!(
        "| {} | {:.1e} | {:.1e} | {:.1e} | {:.1e} | {:.1e} | {why} |",
        row.march, m.depth_p50, m.depth_p99, m.depth_above_1, row.uv_p50, m.normal_p99
    )
}

/// A floor, where the tangent plane is the surface, so that the straight ray is the true one. A sheet is open at its
/// borders, where the true ray may pass below it.
fn on_a_floor(rig: &Rig, size: [u32; 2]) -> Vec<Row> {
    let inner = |aov: &Aov, i: usize| aov.uv[i].iter().all(|c| (0.12..=0.88).contains(c)) && aov.depth[i].is_finite();
    rows(rig, &asset("plane.gltf"), Shell::Off, size, inner)
}

/// Insists on the order, by a figure: each is at most `part` of the one before.
#[track_caller]
fn falls(rows: &[Row], order: &[March], part: f64, figure: impl Fn(&Row) -> f64) {
    let of = |march: March| figure(rows.iter().find(|row| row.march == march).expect("a row"));
    for pair in order.windows(2) {
        let (before, after) = (of(pair[0]), of(pair[1]));
        assert!(after <= part * before, "{} {after} after {} {before}", pair[1], pair[0]);
    }
}

/// On a floor the median tells: the last hundredth of the pixels is that of ridges between two of twelve steps, which no
/// refinement finds, so that all marches with steps are equally far off there. Cones and the exact march pass no ridge.
#[track_caller]
fn judge_floor(rows: &[Row]) {
    falls(rows, &[March::None, March::Offset], 0.95, |row| row.uv_p50);
    falls(rows, &[March::Offset, March::Steep, March::Pom, March::Secant, March::Relief], 0.5, |row| row.uv_p50);
    falls(rows, &[March::Pom, March::Contact, March::Relief], 0.5, |row| row.uv_p50);
    // UVs in f32 tell no more apart.
    falls(rows, &[March::Relief, March::Cone, March::Exact], 1.0, |row| row.uv_p50);
    falls(rows, &[March::Pom, March::RelaxedCone], 0.5, |row| row.uv_p50);
    for good in [March::Cone, March::RelaxedCone, March::Exact] {
        falls(rows, &[March::Relief, good], 0.1, |row| row.metrics.depth_p99);
    }
    // Without a ray the depth is the base surface's.
    falls(rows, &[March::None, March::Normal, March::Offset], 1.0, |row| row.metrics.depth_p50);
}

/// Texels by which a chord of a cone march may stray from the ray's path in a shell: MOST_BEND in `shell/march.glsl`.
const MOST_BEND: f64 = 0.125;

/// Prisms are small, so that twelve steps in each pass hardly a ridge: there 99 % of the pixels tell. Cones follow chords
/// of the path, and end with these chords' error, whatever the search: below pom's, above that of what follows the path.
#[track_caller]
fn judge_shell(rows: &[Row]) {
    falls(rows, &[March::Steep, March::Pom, March::Secant, March::Relief], 0.5, |row| row.metrics.depth_p99);
    falls(rows, &[March::Pom, March::Contact, March::Relief], 0.5, |row| row.metrics.depth_p99);
    for cone in [March::RelaxedCone, March::Cone] {
        falls(rows, &[March::Pom, cone], 1.0, |row| row.metrics.depth_p99);
        let row = rows.iter().find(|row| row.march == cone).expect("a row");
        assert!(row.uv_p50 <= MOST_BEND, "{cone}: {} texels", row.uv_p50);
    }
    // Both end at what f32 tells apart.
    falls(rows, &[March::Secant, March::Relief], 0.5, |row| row.metrics.depth_p99);
    falls(rows, &[March::Secant, March::Exact], 0.5, |row| row.metrics.depth_p99);
    falls(rows, &[March::Relief, March::Exact], 0.5, |row| row.metrics.depth_above_1);
}

#[test]
fn every_technique_on_a_base_surface_has_its_place() {
    judge_floor(&on_a_floor(&Rig::new(), [120, 90]));
}

#[test]
#[ignore = "takes minutes: tests/run figures"]
fn the_table_of_techniques() {
    let rig = Rig::new();
    let floor = on_a_floor(&rig, [320, 240]);
    let torus = asset("torus.gltf");
    let shells = SHELLS.map(|shell| rows(&rig, &torus, shell, [320, 240], |aov, i| aov.depth[i].is_finite()));
    let head = "| march | depth p50 | depth p99 | share above 1 | UV p50, texels | normal p99, degrees | what it does |\n\
                |---|---|---|---|---|---|---|";
    let section = |title: &str, rows: &[Row]| {
        format!("## {title}\n\n{head}\n{}\n", rows.iter().map(line).collect::<Vec<_>>().join("\n"))
    };
    let text = format!(
        "# Every technique against the f64 reference\n\n{}; 320×240; {}. Written by `tests/run figures`.\n\n\
         {STEPS} steps, cones as many as they take. Depth in pixel footprints. On the floor the median falls in this order; \
         its last hundredth is ridges between two of the steps, the same for all that take them. In a shell 99 % of the \
         pixels fall so, but for cones: they follow chords of the path, which stray from it by an eighth of a texel at most, \
         and end with that error. Contact and secant are as good as each other; relief and exact are both at f32's rounding, \
         but for the few pixels whose ridge no step meets.\n\n{}\n{}\n{}",
        rig.device(),
        record::date(),
        section("A flat floor, its base surface", &floor),
        section("A torus, `--shell prism`", &shells[0]),
        section("A torus, `--shell walk`", &shells[1])
    );
    let name = format!("techniques_{}.md", record::device_name(&rig.device()));
    fs::write(record::path(&name), text).expect("the table");
    judge_floor(&floor);
    shells.iter().for_each(|rows| judge_shell(rows));
}
