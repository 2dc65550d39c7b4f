//! What the plan saves: the table of README.md, with the plan and with `--keep-all`.

mod common;
mod rig;

use std::{fs, path::PathBuf};

use common::{Gltf, Lens, Map, Shape, Wrap, asset, folder, leftovers, prism};
use rig::{Rig, record};
use serde_json::{Value, json};

/// Frames of a run whose time is steady, the first one with its compilation among them.
const FRAMES: u32 = 9;
/// Runs of each in turns, of which the fastest counts.
const ROUNDS: usize = 3;
/// The plan, and all kept.
const WAYS: [&str; 2] = ["", "--keep-all"];

/// One scene under some flags.
struct Row {
    name: &'static str,
    file: PathBuf,
    flags: &'static str,
}

impl Row {
    fn call(&self, command: &str, way: &str) -> common::program::Call {
        // Which `--keep-all` has not: it would hide what is saved.
        let common = "--march relief --visibility-buffer off --size 320x180";
        prism(command).arg(&self.file).words(self.flags).words(common).words(way)
    }

    /// What only `--keep-all` has.
    fn left_out(&self) -> String {
        let kept = |way: &str| {
            let told: Value =
                serde_json::from_str(&self.call("explain", way).words("--json").succeeds().stdout).unwrap();
            let decisions = told["decisions"].as_array().expect("a list").clone();
            decisions
                .into_iter()
                .filter(|decision| decision["kept"] == true)
                .map(|d| [d["of"].clone(), d["what"].clone()])
        };
        let plan: Vec<_> = kept(WAYS[0]).collect();
        let mut names: Vec<String> = Vec::new();
        for [of, what] in kept(WAYS[1]).filter(|decision| !plan.contains(decision)) {
            let (of, what) = (of.as_str().expect("a name"), what.as_str().expect("a name"));
            let name = if of.starts_with("height map") { format!("height map's {what}") } else { what.to_owned() };
            if !names.contains(&name) {
                names.push(name);
            }
        }
        names.join(", ")
    }

    /// A row of the table.
    fn measured(&self) -> String {
        let picture = leftovers().join("plan.png");
        let drawn = |way: &str, frames: u32| {
            self.call("render", way).words(&format!("--stats --frames {frames} --out")).arg(&picture)
        };
        let mut ms = [f64::INFINITY; 2];
        let mut mebibytes = [0.0; 2];
        for i in (0..ROUNDS).flat_map(|_| [0, 1]) {
            let stats = drawn(WAYS[i], FRAMES).succeeds().stdout;
            ms[i] = ms[i].min(frame_ms(&stats));
            mebibytes[i] = number(&stats, "\nmemory: ");
        }
        // From GLSL to the machine code that the first frame runs, nothing of it cached.
        let seconds = [0, 1].map(|i| {
            let cache = folder();
            let call = drawn(WAYS[i], 1).env("XDG_CACHE_HOME", cache.path()).env("MESA_SHADER_CACHE_DISABLE", "true");
            let stats = call.succeeds().stdout;
            let compiled = number(&stats, "compiled in ") + number(&stats, "created in ");
            (compiled + frame_ms(&stats) - ms[i]) / 1000.0
        });
        let pair = |[with, without]: [f64; 2], digits: usize| format!("{with:.digits$} / {without:.digits$}");
        let (name, left_out) = (self.name, self.left_out());
        let (ms, seconds, mebibytes) = (pair(ms, 1), pair(seconds, 1), pair(mebibytes, 2));
        format!("| {name} | {left_out} | {ms} | {seconds} | {mebibytes} |")
    }
}

/// The number after `before` in a text.
fn number(text: &str, before: &str) -> f64 {
    let (_, after) = text.split_once(before).unwrap_or_else(|| panic!("no '{before}' in {text}"));
    let end = after.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(after.len());
    after[..end].parse().unwrap_or_else(|_| panic!("no number after '{before}' in {text}"))
}

/// The medians of all passes.
fn frame_ms(stats: &str) -> f64 {
    stats.lines().filter(|line| line.starts_with("pass ")).map(|line| number(line, "ms min, ")).sum()
}

/// A square whose heights are all the same.
fn level(folder: &std::path::Path) -> PathBuf {
    let mut gltf = Gltf::new();
    let stone = gltf.displaced("stone", &Map::eight(8, &[200; 64]), [Wrap::Repeat; 2], json!({ "scale": 0.2 }));
    let mesh = gltf.mesh("floor", &Shape::sheet(1.0, [0.0, 0.0], [1.0, 1.0]), stone);
    gltf.node(json!({ "mesh": mesh }));
    gltf.camera(&Lens::at([0.6, -1.2, 1.4], [0.0; 3]));
    gltf.write(folder)
}

#[test]
#[ignore = "some minutes, of a machine that does nothing else; tests/run figures"]
fn what_is_left_out_is_saved() {
    let folder = folder();
    let row = |name, file: &str, flags| Row { name, file: asset(file), flags };
    let rows = [
        Row { name: "a square of one height, walk", file: level(folder.path()), flags: "" },
        row("`photo`, its base surface", "photo.gltf", "--shell off"),
        row("`plane`, `--shell prism`", "plane.gltf", "--shell prism"),
        row(
            "the same, under light that cannot graze",
            "plane.gltf",
            "--shell prism --height-scale 0.001 --self-shadow hard",
        ),
        row("`torus`, walk", "torus.gltf", ""),
        row("`prism_shell`, walk", "prism_shell.gltf", ""),
        row("`suzanne`, walk", "suzanne.gltf", ""),
    ];
    let device = Rig::new().device();
    let table: Vec<String> = rows.iter().map(Row::measured).inspect(|row| println!("{row}")).collect();
    let text = format!(
        "# What the plan saves\n\n{device}; 320×180, `--march relief --visibility-buffer off`; {}. Written by `tests/run figures`.\n\n\
         With the plan / with `--keep-all`. Times of a frame: the passes' medians, together, the least of {ROUNDS} runs in \
         turns. Compilation: from GLSL to the machine code that the first frame runs, with empty caches.\n\n\
         | scene | left out | ms a frame | s to compile | MiB |\n|---|---|---|---|---|\n{}\n",
        record::date(),
        table.join("\n")
    );
    fs::write(record::path(&format!("plan_{}.md", record::device_name(&device))), text).expect("the table");
}
