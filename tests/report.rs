//! `prism report`: that its figures are right. A surface whose error is known is found in the CSV with that error; what
//! is made slower moves, and nothing else; every cell of the page is there.

mod common;

use std::{collections::HashMap, fs, path::Path};

use common::{Gltf, Lens, Map, Shape, Wrap, folder, prism};
use serde_json::json;

/// So high is the field wherever it is seen.
const HEIGHT: f64 = 77.0 / 255.0;
const SCALE: f64 = 0.2;
/// Half the picture's height in world units, of parallel rays that all hit the sheet; and its pixels.
const HALF: f64 = 0.4;
const SIZE: [u32; 2] = [48, 36];

/// Aslant, as a ray straight down always looks up one height.
fn lens() -> Lens {
    Lens::at([0.9, 0.6, 2.2], [0.0; 3]).orthographic(HALF)
}

/// A sheet from -1 to 1 whose detail goes inward to one level, but for a corner beyond the picture that spans the range
/// which a search goes through.
fn sheet(folder: &Path) {
    let mut gltf = Gltf::new();
    let mut texels = [77; 16 * 16];
    texels[14..16].copy_from_slice(&[255, 0]);
    let map = Map::eight(16, &texels);
    let wall = gltf.displaced("wall", &map, [Wrap::Clamp; 2], json!({ "scale": SCALE, "midlevel": 1.0 }));
    let mesh = gltf.mesh("Sheet", &Shape::sheet(1.0, [0.0, 0.0], [1.0, 1.0]), wall);
    gltf.node(json!({ "name": "tile", "mesh": mesh }));
    gltf.camera(&lens());
    gltf.write(folder);
}

type Row = HashMap<String, String>;

/// The rows of the CSV, by the names of their columns.
fn rows(file: &Path) -> Vec<Row> {
    let text = fs::read_to_string(file).expect("the CSV");
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    reader.deserialize().collect::<Result<_, _>>().expect("rows")
}

fn number(row: &Row, column: &str) -> f64 {
    row[column].parse().unwrap_or_else(|_| panic!("{column} of {row:?}"))
}

fn named<'a>(rows: &'a [Row], technique: &str, setting: &str) -> &'a Row {
    let found = rows.iter().find(|row| row["technique"] == technique && row["setting"] == setting);
    found.unwrap_or_else(|| panic!("no {technique}, {setting}"))
}

/// Texts between two marks.
fn between<'a>(text: &'a str, begin: &str, end: &str) -> Vec<&'a str> {
    text.split(begin).skip(1).map(|rest| rest.split(end).next().expect("one")).collect()
}

#[test]
fn an_error_of_closed_form_is_in_the_csv_and_every_cell_on_the_page() {
    let folder = folder();
    sheet(folder.path());
    let words = "report --quick --scenes scene.glb --size 48x36 --rounds 2 --validation sync --out page --techniques";
    let call = prism(words).arg("base normal,base steep,base pom,walk exact,micro-mesh");
    let outcome = call.within(folder.path()).succeeds();
    let page = folder.path().join("page");
    let rows = rows(&page.join("points.csv"));

    let footprint = 2.0 * HALF / f64::from(SIZE[1]);
    let slant = lens().axes.z_axis.z;
    // The ray goes through the range of heights, and meets so many layers of it.
    let depth = 1.0 - HEIGHT;
    let layer = |steps: f64| (depth * steps).ceil() / steps;
    let expected = [
        ("base normal", "", depth),
        ("base steep", "8 steps", layer(8.0) - depth),
        ("base steep", "32 steps", layer(32.0) - depth),
        ("base pom", "8 steps", 0.0),
        ("base pom", "32 steps", 0.0),
        ("walk exact", "", 0.0),
        ("micro-mesh", "density 4", 0.0),
        ("micro-mesh", "density 16", 0.0),
    ];
    assert_eq!(rows.len(), expected.len(), "{rows:?}");
    for (technique, setting, of_range) in expected {
        let row = named(&rows, technique, setting);
        let error = of_range * SCALE / slant / footprint;
        for column in ["depth_p50", "depth_p99"] {
            let found = number(row, column);
            assert!((found - error).abs() < 1e-3, "{technique}, {setting}: {column} {found}, not {error}");
        }
        assert_eq!(number(row, "depth_above_1"), f64::from(u8::from(error > 1.0)), "{row:?}");
        assert_eq!(number(row, "covered"), f64::from(SIZE[0] * SIZE[1]));
        for column in ["silhouette", "shadow_wrong"] {
            assert_eq!(number(row, column), 0.0, "{column} of {row:?}");
        }
        assert!(number(row, "normal_p99") < 0.1, "{row:?}");
        let times = ["ms_least", "ms_low", "ms_median", "ms_high", "ms_most"].map(|column| number(row, column));
        assert!(times[0] > 0.0 && times.is_sorted(), "{times:?}");
        assert!(number(row, "fragments") > 0.0 && number(row, "memory_mib") > 0.0, "{row:?}");
    }
    assert_eq!(number(named(&rows, "walk exact", ""), "flip"), 0.0, "it is the truth of FLIP");
    // Light and textures are one everywhere: what stands too high looks the same.
    assert!(number(named(&rows, "base normal", ""), "flip") < 0.02);

    let html = fs::read_to_string(page.join("index.html")).expect("the page");
    let tables = between(&html, "<table>", "</table>");
    assert_eq!(tables.len(), 3, "aims, who competed, and points");
    for (table, count) in tables.iter().zip([2, 2, rows.len()]) {
        let lines = between(table, "<tr>", "</tr>");
        assert_eq!(lines.len(), 1 + count, "{table}");
        let heads = lines[0].matches("<th").count();
        for line in &lines[1..] {
            assert_eq!(line.matches("<td").count(), heads, "{line}");
        }
    }
    let verdicts = outcome.stdout.lines().filter(|line| line.ends_with("| met |") || line.ends_with("| MISSED |"));
    assert_eq!(verdicts.count(), 2, "{outcome}");
    let plot = fs::read_to_string(page.join("front-scene.svg")).expect("the plot");
    for (technique, ..) in expected {
        assert!(plot.contains(technique) && html.contains(technique), "{technique}");
    }
    assert!(html.contains(&plot), "the plot stands in the page");
    assert!(html.matches("data:image/png;base64,").count() >= 10, "pictures stand in the page");
    for reference in ["src=\"http", "href=\"http", "url(", "@import", "<script"] {
        assert!(!html.contains(reference), "{reference}");
    }
    assert!(html.contains("llvmpipe") && html.contains("48×36"), "device and settings");
}

#[test]
fn what_is_made_slower_moves_and_nothing_else() {
    let folder = folder();
    sheet(folder.path());
    let shaders = folder.path().join("shaders");
    copy(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../shaders"), &shaders);
    let measured = |out: &str| {
        let words =
            "report --quick --scenes scene.glb --parts front --size 160x120 --rounds 7 --shader-dir shaders --out";
        let techniques = ["--techniques", "base normal,base steep,base pom"];
        let call = prism(words).arg(out).arg(techniques[0]).arg(techniques[1]);
        call.within(folder.path()).succeeds();
        rows(&folder.path().join(out).join("points.csv"))
    };
    let usual = measured("usual");
    let search = shaders.join("shell/refine.glsl");
    let text = fs::read_to_string(&search).expect("the search");
    let slow = text.replacen(
        "    return x.b;\n#elif",
        "    float spin = x.a;\n    for (int i = 0; i < 20000; i++) { spin = fract(spin * 1.37 + 0.13); }\n    \
         return spin == 0.5 ? x.a : x.b;\n#elif",
        1,
    );
    assert_ne!(slow, text, "there is something to slow down");
    fs::write(&search, slow).expect("a slow search");
    let slowed = measured("slowed");

    assert_eq!(usual.len(), slowed.len());
    for (before, after) in usual.iter().zip(&slowed) {
        let name = [&before["technique"], &before["setting"]];
        assert_eq!(name, [&after["technique"], &after["setting"]]);
        let times = number(after, "ms_least") / number(before, "ms_least");
        // Tests share their machine; the slow one is slower by far.
        let moved = times > 8.0;
        assert_eq!(moved, before["technique"] == "base steep", "{name:?} takes {times} times as long");
        for column in ["depth_p50", "depth_p99", "silhouette", "normal_p99", "flip", "fragments"] {
            assert_eq!(before[column], after[column], "{column} of {name:?}");
        }
    }
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).expect("a folder");
    for entry in fs::read_dir(from).expect("a folder") {
        let path = entry.expect("an entry").path();
        let target = to.join(path.file_name().expect("a name"));
        if path.is_dir() {
            copy(&path, &target);
        } else {
            fs::copy(&path, &target).expect("a copy");
        }
    }
}

#[test]
fn wrong_words_are_told_before_the_work() {
    let folder = folder();
    fs::write(folder.path().join("taken"), "a file").expect("a file");
    for (words, code, told) in [
        ("--scenes nonesuch", 2, "torus, suzanne, plane"),
        ("--scenes none.gltf", 1, "none.gltf"),
        ("--parts nonesuch", 2, "front, stage"),
        ("--techniques nonesuch", 2, "nothing to measure"),
        ("--out taken", 1, "taken"),
        ("--out /proc/report", 1, "/proc/report"),
    ] {
        let outcome = prism("report --quick").words(words).within(folder.path()).run();
        outcome.ends(code).complains(&[told]);
    }
    for words in ["--rounds 0", "--size 0x9", "--frames 3"] {
        assert_eq!(prism("report --quick").words(words).within(folder.path()).run().code, 2, "{words}");
    }
}
