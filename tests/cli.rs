//! The command line: exit codes, the two streams, the files that are written, and what is refused.

mod common;

use std::{collections::BTreeMap, fs, path::Path};

use common::{Frame, Outcome, Picture, STAGES, asset, draw, folder, prism};

/// `prism render` of a small scene, in a folder of its own.
fn render(flags: &str) -> Outcome {
    let folder = folder();
    // A flag may stand only once.
    let size = if flags.contains("--size") { "" } else { "--size 64x48" };
    let validation = if flags.contains("--validation") { "" } else { "--validation sync" };
    let call = prism("render").arg(asset("cube.gltf")).words(size).words(validation).words(flags);
    call.within(folder.path()).run()
}

/// Wrong words: exit code 2, nothing on stdout, and these words in the message.
#[track_caller]
fn usage_error(outcome: Outcome, words: &[&str]) {
    let outcome = outcome.ends(2);
    assert_eq!(outcome.stdout, "", "{outcome}");
    assert!(outcome.stderr.contains("error: "), "{outcome}");
    for word in words {
        assert!(outcome.stderr.contains(word), "'{word}' is not told\n{outcome}");
    }
}

/// The first flag in some words.
fn flag(flags: &str) -> &str {
    flags.split([' ', '=']).next().expect("a flag")
}

#[test]
fn help_tells_every_flag_of_the_contract_and_its_default() {
    let shared = [
        "--size",
        "--gpu",
        "--stage",
        "--shell",
        "--march",
        "--min-steps",
        "--max-steps",
        "--refine-steps",
        "--silhouette",
        "--depth-offset",
        "--ambient-occlusion",
        "--depth-prepass",
        "--self-shadow",
        "--headless",
        "--frames",
        "--out",
        "--aov",
        "--csv",
        "--eye",
        "--target",
        "--fov-y",
        "--validation",
        "--stats",
    ];
    for (command, own) in [("run", &["--time-step"][..]), ("render", &[])] {
        let help = prism(command).words("--help").succeeds();
        assert_eq!(help.stderr, "");
        let entries = options(&help.stdout);
        for flag in shared.iter().chain(own) {
            assert!(entries.contains_key(*flag), "prism {command}: no {flag} in\n{}", help.stdout);
        }
        for (flag, text) in entries.iter().filter(|(flag, _)| *flag != "--help") {
            assert!(text.contains("default"), "prism {command} {flag} tells no default:\n{text}");
        }
        for (flag, default) in [
            ("--size", "1280x720"),
            ("--stage", "auto"),
            ("--shell", "auto"),
            ("--march", "exact"),
            ("--silhouette", "none"),
            ("--depth-offset", "on"),
            ("--self-shadow", "off"),
        ] {
            let told = entries[flag].contains(&format!("[default: {default}"));
            assert!(told, "prism {command} {flag}: not {default} in\n{}", entries[flag]);
        }
    }
    let top = prism("--help").succeeds();
    for word in ["list", "devices", "run", "render", "bake", "77"] {
        assert!(top.stdout.contains(word), "'{word}' is not in\n{}", top.stdout);
    }
}

/// The help's text of each option, by its long name.
fn options(help: &str) -> BTreeMap<String, String> {
    let mut entries: BTreeMap<String, String> = BTreeMap::new();
    let mut flag = String::new();
    for line in help.lines().skip_while(|line| *line != "Options:") {
        let word = line.split_whitespace().find(|word| word.starts_with("--"));
        if line.trim_start().starts_with('-')
            && let Some(word) = word
        {
            flag = word.to_owned();
        }
        let entry = entries.entry(flag.clone()).or_default();
        entry.push_str(line.trim());
        entry.push(' ');
    }
    entries.remove("");
    entries
}

#[test]
fn wrong_words_are_usage_errors() {
    let bare = prism("").run().ends(2);
    assert!(bare.stdout.is_empty() && bare.stderr.contains("Usage: prism"), "{bare}");
    usage_error(prism("paint").run(), &["paint"]);
    usage_error(prism("render").run(), &[]);
    usage_error(prism("run").run(), &[]);
    usage_error(prism("run teapot --headless").run(), &["teapot", "prism_shell", "viewer"]);
    for flags in [
        "--no-such-flag",
        "--stage task",
        "--msaa 2",
        "--shell maybe",
        "--march fast",
        "--silhouette sharp",
        "--depth-offset 1",
        "--self-shadow on",
        "--validation all",
        "--size 0x48",
        "--size 64",
        "--size 64x",
        "--size=-64x48",
        "--size 64x48x2",
        "--size wide",
        "--frames 0",
        "--frames=-1",
        "--frames many",
        "--min-steps 0",
        "--max-steps=-3",
        "--refine-steps x",
        "--eye nan,0,0",
        "--eye 1,2",
        "--eye 1,2,3,4",
        "--eye inf,0,0",
        "--target 0,NaN,0",
        "--fov-y 0",
        "--fov-y 180",
        "--fov-y -20",
        "--fov-y nan",
        "--fov-y inf",
    ] {
        usage_error(render(flags), &[flag(flags)]);
    }
}

#[test]
fn what_a_combination_cannot_honour_is_a_usage_error() {
    for (flags, words) in [
        ("--march none", &["--march none"][..]),
        ("--march normal", &["--march normal"]),
        ("--shell prism --march none", &["--march none"]),
        ("--silhouette uv-bounds", &["--silhouette", "shell"]),
        ("--shell prism --silhouette uv-bounds", &["--silhouette", "shell"]),
        ("--shell prism --depth-offset off", &["--depth-offset"]),
        ("--march pom --min-steps 20 --max-steps 10", &["--min-steps", "--max-steps"]),
        ("--march pom --refine-steps 4", &["--refine-steps"]),
        ("--refine-steps 4", &["--refine-steps"]),
        ("--march cone --refine-steps 4", &["--refine-steps"]),
        ("--march relaxed-cone --min-steps 4", &["--min-steps"]),
        ("--min-steps 4", &["--min-steps"]),
        ("--march exact --max-steps 4", &["--max-steps"]),
        ("--shell off --stage mesh", &["--stage"]),
        ("--shell off --march none --min-steps 4", &["--min-steps"]),
        ("--shell off --march normal --depth-offset on", &["--depth-offset"]),
        ("--shell off --march none --self-shadow hard", &["--self-shadow"]),
        ("--shell off --march normal --silhouette uv-bounds", &["--silhouette"]),
        ("--eye 1,2,3 --target 1,2,3", &["eye", "target"]),
        ("--out same.png --csv same.png", &["--out", "--csv"]),
    ] {
        let outcome = render(flags);
        assert_eq!(outcome.code, 2, "{outcome}");
        usage_error(outcome, words);
    }
    // Before anything is loaded: the file need not exist.
    usage_error(prism("render nowhere.gltf --march none").run(), &["--march none"]);
    usage_error(prism("run prism_shell --headless --time-step -1").run(), &["--time-step"]);
    usage_error(prism("run prism_shell --headless --scene x.gltf").run(), &["--scene"]);
}

#[test]
fn every_combination_that_can_be_honoured_is() {
    for flags in [
        "--shell off --march none",
        "--shell off --march normal",
        "--shell off --march pom",
        "--shell off --march relief --refine-steps 4 --silhouette uv-bounds --self-shadow hard",
        "--shell off --depth-offset off",
        "--shell auto --stage auto",
        "--shell prism --march pom",
        "--shell walk --march relief",
        "--self-shadow hard",
        "--shell prism --march pom --self-shadow hard",
        "--march relief --min-steps 4 --max-steps 4",
        "--shell off --march exact",
        "--march relief --refine-steps 0",
        "--eye -1,2.5,4 --target 0,-0.5,0 --fov-y 30",
        "--frames 2",
        "--gpu 0",
        "--validation core",
        "--validation off",
        "--headless",
    ] {
        render(flags).ends(0);
    }
}

#[test]
fn list_names_the_samples_on_stdout() {
    let list = prism("list").succeeds();
    assert_eq!(list.stderr, "");
    let lines: Vec<&str> = list.stdout.lines().collect();
    let samples = [
        "prism_shell",
        "viewer",
        "stability",
        "cloth",
        "shadows",
        "self_shadow",
        "techniques",
        "silhouette",
        "depth_offset",
        "procedural",
        "photo",
        "terrain",
        "integration",
    ];
    assert_eq!(lines.len(), samples.len(), "{list}");
    for (line, sample) in lines.iter().zip(samples) {
        let (name, summary) = line.split_once(' ').expect("a summary");
        assert!(name == sample && summary.trim().len() > 20, "{line}");
    }
}

#[test]
fn devices_names_every_device_and_why_one_is_refused() {
    let devices = prism("devices").succeeds();
    assert!(devices.stdout.contains("usable") && devices.stdout.contains("Vulkan 1."), "{devices}");
    assert!(devices.stdout.contains("mesh") && devices.stdout.contains("geometry"), "{devices}");
    let masked = prism("devices").env("PRISM_MASK_FEATURES", "mesh").succeeds();
    assert_ne!(masked.stdout, devices.stdout, "what a device lacks is told");
}

#[test]
fn a_sample_is_written_into_the_caller_s_folder() {
    let folder = folder();
    let outcome = draw("run", "prism_shell").words("--headless --size 64x48").within(folder.path()).succeeds();
    assert_eq!(outcome.stdout, "", "a picture is no data of stdout\n{outcome}");
    outcome.notices(&["prism_shell.png"]);
    let names: Vec<_> = fs::read_dir(folder.path()).expect("the folder").flatten().map(|e| e.file_name()).collect();
    assert_eq!(names, ["prism_shell.png"]);
    let picture = Picture::read(&folder.path().join("prism_shell.png"));
    assert_eq!((picture.width, picture.height), (64, 48));
    assert!(picture.colours() > 200, "{} colours", picture.colours());
}

#[test]
fn without_a_display_a_sample_runs_headless() {
    let folder = folder();
    draw("run", "viewer").words("--size 64x48").within(folder.path()).succeeds().notices(&["headless"]);
    assert!(folder.path().join("viewer.png").is_file());
}

#[test]
fn a_scene_is_named_from_any_folder() {
    let folder = folder();
    let inner = folder.path().join("models/deep");
    fs::create_dir_all(&inner).expect("folders");
    common::Gltf::sheet(&common::Map::noise(4, 4)).write(&inner);
    draw("render", "models/deep/scene.glb").words("--size 64x48").within(folder.path()).succeeds();
    assert!(folder.path().join("scene.png").is_file(), "the picture lies where the command ran");
    draw("render", "../deep/scene.glb").words("--size 64x48 --out ../other.png").within(&inner).succeeds();
    assert!(folder.path().join("models/other.png").is_file());
    draw("run", "viewer").words("--headless --size 64x48 --scene scene.glb").within(&inner).succeeds();
    assert!(inner.join("viewer.png").is_file());
}

#[test]
fn the_surface_data_have_the_contract_s_channels() {
    let folder = folder();
    let call = draw("render", asset("torus.gltf")).words("--size 64x48 --aov frame.exr").within(folder.path());
    call.succeeds();
    assert!(!folder.path().join("torus.png").exists(), "only what was asked for is written");
    let frame = Frame::read(&folder.path().join("frame.exr"));
    assert_eq!((frame.width, frame.height), (64, 48));
    let names: Vec<&str> = frame.channels.keys().map(String::as_str).collect();
    let mut contract = [
        "R",
        "G",
        "B",
        "depth.Z",
        "position.X",
        "position.Y",
        "position.Z",
        "normal.X",
        "normal.Y",
        "normal.Z",
        "uv.U",
        "uv.V",
        "height.H",
        "shadow.S",
    ];
    contract.sort_unstable();
    assert_eq!(names, contract);
    let aov = frame.aov();
    let (mut hits, mut misses) = (0, 0);
    for i in 0..aov.depth.len() {
        let values = [aov.position[i], aov.normal[i], aov.color[i]].concat();
        if aov.depth[i] == f32::INFINITY {
            misses += 1;
            assert!(values.iter().chain(&aov.uv[i]).all(|v| *v == 0.0) && aov.height_at_hit[i] == 0.0, "pixel {i}");
            assert_eq!(aov.shadow[i], 1.0, "pixel {i}");
        } else {
            hits += 1;
            assert!(values.iter().chain(&aov.uv[i]).all(|v| v.is_finite()) && aov.depth[i] > 0.0, "pixel {i}");
            let length = glam::Vec3::from(aov.normal[i]).length();
            assert!((length - 1.0).abs() < 1e-4, "pixel {i}: a normal of length {length}");
            assert!((-1e-4..=1.0001).contains(&aov.height_at_hit[i]), "pixel {i}: height {}", aov.height_at_hit[i]);
            assert!((0.0..=1.0).contains(&aov.shadow[i]), "pixel {i}");
        }
    }
    assert!(hits > 500 && misses > 500, "{hits} hits, {misses} misses");
}

#[test]
fn the_top_row_comes_first() {
    // The camera looks down on the torus from above its rim: the far side is in the upper rows, the near in the lower.
    let folder = folder();
    let call = draw("render", asset("torus.gltf")).words("--size 64x48 --aov a.exr --out a.png").within(folder.path());
    call.succeeds();
    let aov = Frame::read(&folder.path().join("a.exr")).aov();
    let rows: Vec<f32> =
        aov.depth.chunks(64).filter_map(|row| row.iter().copied().filter(|z| z.is_finite()).reduce(f32::min)).collect();
    assert!(rows.len() > 10 && rows[0] > rows[rows.len() - 1] + 0.5, "{rows:?}");
    // And the picture is the right way up too: covered and empty pixels differ where the surface data say so.
    let picture = Picture::read(&folder.path().join("a.png"));
    let background = picture.pixels[0];
    assert_eq!(aov.depth[0], f32::INFINITY, "the corner is empty");
    let agree = picture.pixels.iter().zip(&aov.depth).filter(|(p, z)| (**p != background) == z.is_finite()).count();
    assert!(agree * 100 >= aov.depth.len() * 98, "{agree} of {} pixels", aov.depth.len());
}

#[test]
fn both_files_where_both_are_asked_for() {
    let folder = folder();
    let call = draw("run", "viewer").words("--size 64x48 --aov a.exr --out a.png --csv a.csv --headless");
    let outcome = call.within(folder.path()).succeeds();
    for name in ["a.exr", "a.png", "a.csv"] {
        assert!(folder.path().join(name).is_file(), "{name}");
        outcome.notices(&[name]);
    }
    assert_eq!(outcome.stdout, "");
}

#[test]
fn the_csv_has_a_row_for_each_frame_and_pass() {
    let folder = folder();
    let flags = "--headless --size 64x48 --frames 3 --time-step 0.5 --csv table.csv";
    draw("run", "prism_shell").words(flags).within(folder.path()).succeeds();
    let table = fs::read_to_string(folder.path().join("table.csv")).expect("the table");
    let mut lines = table.lines();
    assert_eq!(lines.next(), Some("frame,time,pass,gpu_ms,invocations,primitives"));
    let mut passes: BTreeMap<String, Vec<(u32, f64)>> = BTreeMap::new();
    for line in lines {
        let fields: Vec<&str> = line.split(',').collect();
        assert_eq!(fields.len(), 6, "{line}");
        let ms: f64 = fields[3].parse().unwrap_or_else(|error| panic!("{line}: {error}"));
        assert!(ms > 0.0, "{line}");
        let frame = (fields[0].parse().expect(line), fields[1].parse().expect(line));
        passes.entry(fields[2].to_owned()).or_default().push(frame);
    }
    assert!(passes.contains_key("shell"), "{table}");
    for (pass, frames) in passes {
        assert_eq!(frames, [(0, 0.0), (1, 0.5), (2, 1.0)], "{pass}");
    }
}

#[test]
fn time_moves_the_sample() {
    let folder = folder();
    let run = |name: &str, flags: &str| {
        let call = draw("run", "prism_shell").words(&format!("--size 64x48 {flags} --out {name}"));
        call.within(folder.path()).succeeds();
        Picture::read(&folder.path().join(name))
    };
    let start = run("start.png", "");
    let still = run("still.png", "--frames 3 --time-step 0");
    let later = run("later.png", "--frames 3 --time-step 1");
    assert_eq!(start, still, "at time 0 nothing has moved");
    assert_ne!(start, later);
}

#[test]
fn the_same_command_gives_the_same_bytes() {
    for stage in STAGES {
        let folder = folder();
        let run = |name: &str| {
            let flags = format!("--size 64x48 --stage {stage} --out {name}.png --aov {name}.exr");
            draw("render", asset("torus.gltf")).words(&flags).within(folder.path()).succeeds();
            [format!("{name}.png"), format!("{name}.exr")]
                .map(|file| fs::read(folder.path().join(file)).expect("a file"))
        };
        assert!(run("first") == run("second"), "{stage}: two runs differ");
    }
}

#[test]
fn stats_tell_each_pass_and_the_pipelines() {
    let outcome = render("--stats --frames 3").ends(0);
    let line = |key: &str| {
        let found = outcome.stdout.lines().find(|line| line.starts_with(key));
        found.unwrap_or_else(|| panic!("no '{key}'\n{outcome}"))
    };
    for word in ["min", "median", "p95", "invocations", "primitives"] {
        assert!(line("pass shell: ").contains(word), "'{word}' is not told\n{outcome}");
    }
    assert!(line("memory: ").contains("MiB"), "{outcome}");
    assert!(line("pipeline shell").contains("Fragment"), "{outcome}");
    assert!(!line("device: ").is_empty());
    // Without it, stdout stays empty.
    assert_eq!(render("").ends(0).stdout, "");
}

#[test]
fn the_camera_follows_the_flags() {
    // Straight above the plane's middle, which lies in y = 0: the height of the map is 0 to -0.12 there.
    let folder = folder();
    let flags = "--size 49x49 --eye 0,3,0.001 --target 0,0,0 --fov-y 30 --aov a.exr";
    draw("render", asset("plane.gltf")).words(flags).within(folder.path()).succeeds();
    let aov = Frame::read(&folder.path().join("a.exr")).aov();
    let middle = 24 * 49 + 24;
    let [x, y, z] = aov.position[middle];
    assert!(x.abs() < 0.01 && z.abs() < 0.01 && (-0.1201..=0.0001).contains(&y), "{x} {y} {z}");
    assert!((aov.depth[middle] + y - 3.0).abs() < 1e-3, "{}", aov.depth[middle]);
    // The half height is 3 tan 15° = 0.80 units: the picture is filled from edge to edge.
    assert!(aov.depth.iter().all(|z| z.is_finite()));
}

#[test]
fn outputs_that_cannot_be_written() {
    let folder = folder();
    let run =
        |flags: &str| draw("render", asset("cube.gltf")).words("--size 64x48").words(flags).within(folder.path()).run();
    for (flag, name) in [("--out", "gone/a.png"), ("--aov", "gone/a.exr"), ("--csv", "gone/a.csv")] {
        run(&format!("{flag} {name}")).ends(1).complains(&[name, "folder"]);
    }
    fs::create_dir(folder.path().join("taken.png")).expect("a folder");
    run("--out taken.png").ends(1).complains(&["taken.png"]);
    for flags in ["--out a.jpg", "--aov a.png"] {
        usage_error(run(flags), &[flags.split(' ').next_back().expect("a name")]);
    }
    // /dev/full takes no byte.
    if Path::new("/dev/full").exists() {
        std::os::unix::fs::symlink("/dev/full", folder.path().join("full.png")).expect("a link");
        run("--out full.png").ends(1).complains(&["full.png"]);
    }
}

#[test]
fn a_failed_write_leaves_the_old_file() {
    let folder = folder();
    let path = folder.path().join("frame.png");
    fs::write(&path, "the old one").expect("a file");
    let call = draw("render", "/nowhere.gltf").words("--size 64x48 --out frame.png").within(folder.path());
    call.run().ends(1);
    assert_eq!(fs::read_to_string(&path).expect("the file"), "the old one");
}

#[test]
fn a_turntable_is_one_turn() {
    use image::{AnimationDecoder, codecs::gif::GifDecoder};
    let folder = folder();
    let flags = "--turntable 4 --size 48x36 --shell off --march none --out turn.gif";
    draw("render", asset("torus.gltf")).words(flags).within(folder.path()).succeeds();
    let file = fs::File::open(folder.path().join("turn.gif")).expect("the animation");
    let decoder = GifDecoder::new(std::io::BufReader::new(file)).expect("a GIF");
    let frames = decoder.into_frames().collect_frames().expect("frames");
    assert_eq!(frames.len(), 4);
    // The first frame is what a picture alone shows, to the colours of a GIF; the others are seen from elsewhere.
    draw("render", asset("torus.gltf"))
        .words("--size 48x36 --shell off --march none --out still.png")
        .within(folder.path())
        .succeeds();
    let still = image::open(folder.path().join("still.png")).expect("a picture").into_rgb8();
    let apart = |frame: &image::Frame| {
        let pairs = frame.buffer().pixels().zip(still.pixels());
        let far = pairs.filter(|(a, b)| (0..3).any(|k| a[k].abs_diff(b[k]) > 24)).count();
        far as f64 / (48.0 * 36.0)
    };
    assert!(apart(&frames[0]) < 0.02, "{}", apart(&frames[0]));
    assert!(frames[1..].iter().all(|frame| apart(frame) > 0.05));

    for (flags, told) in
        [("--turntable 4 --frames 2", "--frames"), ("--turntable 4 --out turn.mp4", ".gif"), ("--turntable 1", "1")]
    {
        let outcome = prism("render").arg(asset("torus.gltf")).words(flags).within(folder.path()).run().ends(2);
        assert!(outcome.stderr.contains(told), "{outcome}");
    }
}

#[test]
fn a_sequence_is_every_frame() {
    use image::{AnimationDecoder, codecs::png::PngDecoder};
    let folder = folder();
    let run = |flags: &str| {
        let flags = format!("--headless --size 48x36 --shell off --march none --time-step 0.5 {flags}");
        draw("run", "prism_shell").words(&flags).within(folder.path())
    };
    run("--frames 3 --sequence s.png --out last.png").succeeds();
    let read = |name: &str| image::open(folder.path().join(name)).expect(name).into_rgb8();
    let frames = ["s-000.png", "s-001.png", "s-002.png"].map(read);
    assert_eq!(frames[2], read("last.png"));
    assert!(frames[0] != frames[1] && frames[1] != frames[2] && !folder.path().join("s-003.png").exists());

    run("--frames 3 --sequence s.apng").succeeds();
    assert!(!folder.path().join("prism_shell.png").exists(), "nobody asked for it");
    let file = fs::File::open(folder.path().join("s.apng")).expect("the animation");
    let decoder = PngDecoder::new(std::io::BufReader::new(file)).expect("a PNG").apng().expect("an animation");
    let same = decoder.into_frames().collect_frames().expect("frames");
    let same: Vec<_> =
        same.into_iter().map(|frame| image::DynamicImage::from(frame.into_buffer()).into_rgb8()).collect();
    assert_eq!(same, frames);

    for (flags, told) in [("--sequence s.png", "--frames"), ("--frames 2 --sequence s.mp4", "--sequence s.mp4")] {
        run(flags).run().ends(2).complains(&[told]);
    }
}

#[test]
fn a_plan_is_explained_as_text_and_as_json() {
    let outcome = prism("explain").arg(asset("suzanne.gltf")).words("--json").succeeds();
    let told: serde_json::Value = serde_json::from_str(&outcome.stdout).unwrap_or_else(|e| panic!("{e}: {outcome}"));
    let folds = told["folds"].as_array().expect("a list");
    assert!(folds.iter().all(|fold| fold["r"].as_f64().is_some_and(|r| (0.0..1.0).contains(&r))), "{folds:?}");
    // The notice counts what is listed.
    assert!(outcome.stderr.contains(&format!(": {} shell normals are shortened", folds.len())), "{outcome}");
    for list in ["decisions", "primitives", "passes", "pipelines", "buffers", "images"] {
        assert!(told[list].as_array().is_some_and(|list| !list.is_empty()), "{list}: {outcome}");
    }
    let text = prism("explain prism_shell --self-shadow hard").succeeds().stdout;
    for line in ["  left out  alphaMode MASK", "  kept      self-shadow ", "passes of a frame", "pipelines: "] {
        assert!(text.contains(line), "no '{line}' in {text}");
    }
    prism("explain nothing").run().ends(2);
    prism("explain prism_shell --march none").run().ends(2);
}
