//! The sample `stability`: the hard scenes beside the reference, and its figures.

mod common;

use common::{Frame, Outcome, Picture, STAGES, draw, folder};

/// Issue 3's figures: depth p99 in footprints, share above one footprint, coverage.
const LIMITS: [f64; 3] = [0.05, 1e-4, 2e-4];

/// What one line of stdout says.
struct Figures {
    scene: String,
    covered: usize,
    values: [f64; 3],
    verdict: String,
}

/// `SCENE: N pixels covered; depth error p99 X footprints; above 1 footprint X; coverage differs X; NaN N; met`.
#[track_caller]
fn parse(line: &str) -> Figures {
    let (scene, rest) = line.split_once(": ").unwrap_or_else(|| panic!("no scene in '{line}'"));
    let parts: Vec<&str> = rest.split("; ").collect();
    let number = |part: usize, before: &str, after: &str| -> f64 {
        let text = parts[part].strip_prefix(before).and_then(|text| text.strip_suffix(after));
        text.and_then(|text| text.parse().ok()).unwrap_or_else(|| panic!("'{}' in '{line}'", parts[part]))
    };
    assert_eq!(parts.len(), 6, "{line}");
    assert_eq!(number(4, "NaN ", ""), 0.0, "{line}");
    Figures {
        scene: scene.to_owned(),
        covered: number(0, "", " pixels covered") as usize,
        values: [
            number(1, "depth error p99 ", " footprints"),
            number(2, "above 1 footprint ", ""),
            number(3, "coverage differs ", ""),
        ],
        verdict: parts[5].to_owned(),
    }
}

#[track_caller]
fn all_met(outcome: &Outcome, scenes: &[&str]) {
    let lines: Vec<Figures> = outcome.stdout.lines().map(parse).collect();
    let names: Vec<&str> = lines.iter().map(|line| line.scene.as_str()).collect();
    assert_eq!(names, scenes, "{outcome}");
    for line in lines {
        assert!(line.covered > 500, "{outcome}");
        assert!(line.values.iter().zip(LIMITS).all(|(value, limit)| *value <= limit), "{outcome}");
        assert_eq!(line.verdict, "met", "{outcome}");
    }
}

/// The colours of a quarter of the picture, from the left upper to the right lower.
fn panel(picture: &Picture, x: u32, y: u32) -> Vec<[u8; 3]> {
    let (width, height) = (picture.width / 2, picture.height / 2);
    let row = |row: u32| {
        let from = ((y * height + row) * picture.width + x * width) as usize;
        picture.pixels[from..from + width as usize].to_vec()
    };
    (0..height).flat_map(row).collect()
}

fn colours(pixels: &[[u8; 3]]) -> usize {
    pixels.iter().collect::<std::collections::HashSet<_>>().len()
}

#[test]
fn a_scene_stands_beside_its_reference() {
    let folder = folder();
    for stage in STAGES {
        let flags =
            format!("--headless --size 128x96 --scene cube --stage {stage} --stats --out four.png --aov cube.exr");
        let outcome = draw("run", "stability").words(&flags).within(folder.path()).succeeds();
        let (figures, stats) = outcome.stdout.split_once('\n').expect("figures, then statistics");
        all_met(&Outcome { stdout: figures.to_owned(), ..outcome_of(&outcome) }, &["cube"]);
        let model = if stage == "mesh" { "MeshEXT" } else { "Geometry" };
        assert!(stats.contains(model), "{outcome}");

        let picture = Picture::read(&folder.path().join("four.png"));
        assert_eq!([picture.width, picture.height], [128, 96]);
        let (frame, truth, clay) = (panel(&picture, 0, 0), panel(&picture, 1, 0), panel(&picture, 0, 1));
        let heat = panel(&picture, 1, 1);
        for (name, panel) in [("frame", &frame), ("reference", &truth), ("clay", &clay), ("heat map", &heat)] {
            assert!(colours(panel) > 40, "{name}: {} colours", colours(panel));
        }
        // Two surfaces that agree, under one light: only rounding sets them apart.
        let differ = truth.iter().zip(&clay).filter(|(a, b)| a[0].abs_diff(b[0]) > 2).count();
        assert!(differ * 1000 < truth.len(), "{differ} of {} pixels in clay differ", truth.len());
        assert_ne!(frame, clay);
        // The colours of a ghost, a hole and an error of 10 footprints: the last is on the scale alone.
        assert!(!heat.contains(&[0, 220, 255]) && !heat.contains(&[0, 255, 0]), "coverage differs");
        assert!(heat.contains(&[252, 255, 164]), "no scale");

        let aov = Frame::read(&folder.path().join("cube.exr")).aov();
        assert_eq!([aov.width, aov.height], [128, 96], "the frame in the size that was asked for");
    }
}

/// The same ending without the text.
fn outcome_of(outcome: &Outcome) -> Outcome {
    Outcome { line: outcome.line.clone(), code: outcome.code, stdout: String::new(), stderr: outcome.stderr.clone() }
}

#[test]
fn each_frame_shows_the_next_scene() {
    let folder = folder();
    let run = |flags: &str| {
        let call = draw("run", "stability").words("--headless --size 128x72").words(flags);
        call.within(folder.path()).succeeds()
    };
    all_met(&run("--frames 2 --out walk.png"), &["torus", "suzanne"]);
    all_met(&run("--scene suzanne --out suzanne.png"), &["suzanne"]);
    all_met(&run("--scene 10 --frames 2 --out around.png"), &["stability_inside", "torus"]);
    all_met(&run("--out torus.png"), &["torus"]);
    let read = |name: &str| Picture::read(&folder.path().join(name));
    assert!(read("walk.png") == read("suzanne.png"), "the last frame is the picture");
    assert!(read("around.png") == read("torus.png"), "after the last scene comes the first");
    assert!(read("torus.png") != read("suzanne.png"));
}

#[test]
fn a_base_surface_misses_and_says_so() {
    let folder = folder();
    let flags = "--headless --size 128x72 --shell off --scene stability_needles --out off.png";
    let outcome = draw("run", "stability").words(flags).within(folder.path()).succeeds();
    let figures = parse(outcome.stdout.trim_end());
    assert!(figures.verdict == "missed" && figures.values[2] > 100.0 * LIMITS[2], "{outcome}");
    let heat = panel(&Picture::read(&folder.path().join("off.png")), 1, 1);
    assert!(heat.contains(&[0, 255, 0]), "needles that a base surface cannot have are holes");
}

#[test]
fn what_it_cannot_show_is_wrong_usage() {
    for (flags, words) in [
        ("--scene 11", ["--scene 11", "stability_cliffs"]),
        ("--scene cub", ["--scene cub", "cube"]),
        ("--size 64x1", ["--size 64x1", "2x2"]),
        ("--frames 2 --time-step 1", ["--time-step", "stability"]),
    ] {
        let outcome = draw("run", "stability").words("--headless").words(flags).run().ends(2);
        outcome.complains(&words);
    }
}
