//! The figures of the exact shell: every scene × shell × stage against the f64 reference, as a table.
//!
//! `tests/run` checks every cell on small pictures; `tests/run figures` measures them in full and writes the table. With
//! `PRISM_WORST=N` the N worst pixels of each cell are told, with both hits; `PRISM_SCENE=NAME` leaves the other scenes
//! out, and no table is written then.

mod rig;

use std::{fmt::Write as _, fs};

use prism_engine::{
    measure::Metrics,
    settings::{Shell, Stage},
    shell::reference::{Reference, Shadows},
};
use rig::{
    Rig, SHELLS, STAGES,
    exactness::{self, ABOVE_1, COVERAGE, DEPTH_P99, SCENES},
    record,
};

/// Cells that miss a figure for now: scene, figure, why. They are measured and shown like the others, as missed.
const EXPECTED_MISSES: &[(&str, &str, &str)] = &[];

/// One cell of the table.
struct Cell {
    scene: &'static str,
    shell: Shell,
    stage: Stage,
    metrics: Metrics,
    /// Loops that gave up.
    limits: u32,
    /// Drawn anew from the start, the frame came out the same to the bit.
    repeats: bool,
}

impl Cell {
    /// The figures that it misses, by name, and its values there.
    fn misses(&self) -> Vec<(&'static str, String)> {
        let mut misses = exactness::misses(&self.metrics, self.limits);
        if !self.repeats {
            misses.push(("repeats", "no".to_owned()));
        }
        misses
    }

    fn row(&self) -> String {
        let m = &self.metrics;
        let misses: Vec<String> =
            self.misses().iter().map(|(name, value)| format!("**MISSED** {name} {value}")).collect();
        format!(
            "| {} | {} | {} | {} | {:.1e} | {:.1e} | {:.1e} | {:.1e} | {} | {} | {} | {} |",
            self.scene,
            self.shell,
            self.stage,
            m.covered,
            m.depth_p99,
            m.depth_above_1,
            m.coverage_differs,
            m.normal_p99,
            m.nan_count,
            self.limits,
            if self.repeats { "yes" } else { "no" },
            if misses.is_empty() { "met".to_owned() } else { misses.join(", ") },
        )
    }
}

const HEADER: &str = "\
| scene | shell | stage | pixels covered | depth p99, footprints | share above 1 footprint | coverage differs | normal p99, degrees | NaN | limits reached | repeats | figures |
|---|---|---|---|---|---|---|---|---|---|---|---|";

/// Whether the scene is to be measured.
fn chosen(scene: &str) -> bool {
    std::env::var("PRISM_SCENE").map_or(true, |only| only == scene)
}

/// Measures every cell, telling each as it comes.
fn measure(rig: &Rig, [width, height]: [u32; 2]) -> Vec<Cell> {
    let mut cells = Vec::new();
    println!("{HEADER}");
    for name in SCENES.into_iter().filter(|name| chosen(name)) {
        let scene = rig::asset(&format!("{name}.gltf"));
        let camera = scene.camera.expect("the assets have cameras");
        let truth = Reference::new(&scene).render(&camera, width, height, Shadows::Skip);
        for shell in SHELLS {
            for stage in STAGES {
                let settings = rig::exact(shell, stage);
                let draw = || {
                    let mut easel = rig.easel(&scene, &settings, [width, height]);
                    easel.assert_stage(stage);
                    (easel.draw(&camera), easel.limits_reached())
                };
                let ((test, limits), (again, _)) = (draw(), draw());
                let metrics = Metrics::between(&test, &truth, &camera);
                let cell = Cell { scene: name, shell, stage, metrics, limits, repeats: rig::same_bits(&test, &again) };
                println!("{}", cell.row());
                for line in rig::worst::lines(&test, &truth, &camera, rig::worst::asked()) {
                    println!("{line}");
                }
                cells.push(cell);
            }
        }
    }
    cells
}

/// Insists on every cell, and on its figures.
fn judge(cells: &[Cell], least_covered: usize) {
    let scenes = SCENES.iter().filter(|name| chosen(name)).count();
    assert_eq!(cells.len(), scenes * SHELLS.len() * STAGES.len(), "every scene with every shell and every stage");
    let mut wrong = Vec::new();
    for cell in cells {
        assert!(cell.metrics.covered >= least_covered, "{}: too few pixels to show anything", cell.scene);
        for (figure, value) in cell.misses() {
            let known = EXPECTED_MISSES.iter().find(|(scene, name, _)| (*scene, *name) == (cell.scene, figure));
            let line = format!("MISSED {} {} {}: {figure} {value}", cell.scene, cell.shell, cell.stage);
            match known {
                Some((_, _, why)) => println!("{line}, as expected: {why}"),
                None => wrong.push(line),
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn every_cell_meets_its_figures_on_small_pictures() {
    let rig = Rig::new();
    judge(&measure(&rig, [160, 90]), 3000);
}

#[test]
#[ignore = "takes minutes: tests/run figures"]
fn every_cell_meets_its_figures_in_full() {
    let rig = Rig::new();
    let cells = measure(&rig, [640, 360]);
    if cells.len() == SCENES.len() * SHELLS.len() * STAGES.len() {
        write_table(&rig.device(), &cells);
    }
    judge(&cells, 48_000);
}

/// Writes `tests/figures/DEVICE.md`.
fn write_table(device: &str, cells: &[Cell]) {
    let march = rig::exact(Shell::Prism, Stage::Mesh).march;
    let rows: Vec<String> = cells.iter().map(Cell::row).collect();
    let missed = cells.iter().filter(|cell| !cell.misses().is_empty()).count();
    let mut text = format!(
        "# Figures of the {march} march\n\n{device}; 640×360; {}. Written by `tests/run figures`.\n\n\
         Against the f64 reference, at the same pixel centres. To be reached in every cell: depth p99 ≤ {DEPTH_P99} pixel \
         footprints, share above 1 footprint ≤ {ABOVE_1}, coverage differs on ≤ {COVERAGE} of the covered pixels, no NaN, \
         no loop that reached its limit, the same bytes when drawn again. {} cells, {missed} missed.\n\n{HEADER}\n{}\n",
        record::date(),
        cells.len(),
        rows.join("\n")
    );
    for (scene, figure, why) in EXPECTED_MISSES {
        let _ = writeln!(text, "\n{scene}, {figure}: {why}");
    }
    fs::write(record::path(&format!("{}.md", record::device_name(device))), text).expect("the table");
}

#[test]
fn dates_are_those_of_the_calendar() {
    assert_eq!([0, 59, 11_016, 20_779].map(record::civil), ["1970-01-01", "1970-03-01", "2000-02-29", "2026-11-22"]);
}
