//! `prism report`: error against run time, for every technique and baseline. README.md says how to read the page.

mod contest;
mod fit;
mod flip;
mod measure;
mod page;
mod parts;
mod plot;
mod scenes;
mod table;
mod variants;

use std::{fs, path::Path, time::SystemTime};

use indicatif::{ProgressBar, ProgressStyle};
use prism_engine::error::{Error, Result};

use self::{
    contest::Aim,
    measure::{Measured, Point},
    page::Section,
    parts::{Extent, Part},
};
use crate::{
    app::{cli::ReportArgs, console, files},
    timing::{Device, WARM_UP},
};

/// The word for what is held at equal error; it has no stands of its own.
const CONTEST: &str = "contest";
/// Scenes of the contests: those whose base mesh is no mere sheet, where a micro-mesh's density means something.
const CONTEST_SCENES: &[&str] = &["torus", "suzanne", "needles"];

/// Runs the command.
pub fn run(args: &ReportArgs) -> Result<()> {
    let parts = chosen(args)?;
    make_folder(&args.out)?;
    let mut device = Device::new("prism report", &args.device, true)?;
    let log = device.ctx.validation_log();
    let started = SystemTime::now();

    let progress = progress(&parts, args);
    let tick = || progress.inc(1);
    let mut all: Vec<(Part, Measured)> = Vec::new();
    for part in parts {
        progress.set_message(part.title.clone());
        progress.tick();
        let measured = measure::part(&part, &mut device, args.rounds(), &tick)?;
        all.push((part, measured));
    }
    let mut aims = Vec::new();
    for scene in fronts(&all) {
        let points = of_front(&all, &scene);
        aims.extend(contest::standing(&scene, &points));
        if wants(args, CONTEST) && CONTEST_SCENES.contains(&scene.as_str()) {
            progress.set_message(format!("At equal error: {scene}"));
            aims.extend(contest::run(&scene, &points, &mut device, args.rounds(), &tick)?);
        }
    }
    progress.finish_and_clear();

    let about = page::About::new(&device, args, started);
    write(&args.out, &about, &all, &aims)?;
    drop(device);
    // Everything is destroyed now: what the validation layer has to say about that counts too.
    log.check()?;
    console::notice(format_args!("wrote {}", args.out.join("index.html").display()));
    console::data(&page::summary(&about, &aims))
}

/// Whether a part is asked for.
fn wants(args: &ReportArgs, id: &str) -> bool {
    args.parts.is_empty() || args.parts.iter().any(|part| part == id)
}

/// The parts that are asked for, with the techniques that are asked for.
fn chosen(args: &ReportArgs) -> Result<Vec<Part>> {
    let known = |part: &&String| part.as_str() != CONTEST && !parts::IDS.contains(&part.as_str());
    if let Some(part) = args.parts.iter().find(known) {
        let words = parts::IDS.join(", ");
        return Err(Error::Usage(format!("--parts {part}: no such part; there are {words}, {CONTEST}")));
    }
    let all: Vec<String> = scenes::NAMED.iter().map(|(word, _)| (*word).to_owned()).collect();
    let scenes = match (args.scenes.is_empty(), args.quick) {
        (false, _) => args.scenes.clone(),
        (true, true) => all[..1].to_vec(),
        (true, false) => all,
    };
    for scene in &scenes {
        // Now, not after minutes of work.
        scenes::load(scene, 1.0)?;
    }
    let mut parts = Extent { quick: args.quick, size: args.pixels() }.parts(&scenes);
    parts.retain(|part| wants(args, part.id));
    let asked = |technique: &str| {
        args.techniques.is_empty() || args.techniques.iter().any(|begin| technique.starts_with(begin.as_str()))
    };
    for part in &mut parts {
        for stand in &mut part.stands {
            stand.variants.retain(|variant| asked(&variant.technique));
            stand.matched = stand.matched.filter(|_| asked("micro-mesh"));
        }
        part.stands.retain(|stand| !stand.variants.is_empty() || stand.matched.is_some());
    }
    parts.retain(|part| !part.stands.is_empty());
    if parts.is_empty() {
        return Err(Error::Usage("--parts and --techniques leave nothing to measure; drop one of them".into()));
    }
    Ok(parts)
}

fn make_folder(folder: &Path) -> Result<()> {
    let failed = |cause: std::io::Error| {
        let problem = format!("cannot be filled: {cause}");
        Error::input(folder, "folder of the report", problem, "name a folder that you may write with --out")
    };
    fs::create_dir_all(folder).map_err(failed)?;
    // A folder that exists need not be writable: better told now.
    let probe = folder.join(format!(".report.{}.tmp", std::process::id()));
    fs::write(&probe, "").and_then(|()| fs::remove_file(&probe)).map_err(failed)
}

/// A bar on stderr with what is left, where that is a terminal.
fn progress(parts: &[Part], args: &ReportArgs) -> ProgressBar {
    let of =
        |part: &Part| part.stands.iter().map(|s| s.variants.len() + usize::from(s.matched.is_some())).sum::<usize>();
    let points: usize = parts.iter().map(of).sum();
    let frames = points as u64 * u64::from(1 + WARM_UP + args.rounds());
    let style = ProgressStyle::with_template("{bar:40} {pos}/{len} frames, {eta} left: {msg}");
    ProgressBar::new(frames).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}

/// Scenes that have a front.
fn fronts(all: &[(Part, Measured)]) -> Vec<String> {
    all.iter().filter(|(part, _)| part.id == "front").map(|(part, _)| part.stands[0].scene.clone()).collect()
}

fn of_front<'a>(all: &'a [(Part, Measured)], scene: &str) -> Vec<&'a Point> {
    let front = all.iter().filter(|(part, _)| part.id == "front").flat_map(|(_, measured)| &measured.points);
    front.filter(|point| point.scene == scene).collect()
}

/// Fills the folder.
fn write(folder: &Path, about: &page::About, all: &[(Part, Measured)], aims: &[Aim]) -> Result<()> {
    let points: Vec<Point> = all.iter().flat_map(|(_, measured)| measured.points.iter().cloned()).collect();
    table::write_csv(&folder.join("points.csv"), &points)?;
    let mut sections = Vec::new();
    for (part, measured) in all {
        let section = Section::of(part, measured)?;
        for (name, svg) in &section.plots {
            text(&folder.join(format!("{name}.svg")), svg)?;
        }
        sections.push(section);
    }
    text(&folder.join("index.html"), &page::html(about, &sections, aims))
}

fn text(path: &Path, text: &str) -> Result<()> {
    files::replace(path, "page", |file| Ok(std::io::Write::write_all(file, text.as_bytes())?))
}
