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

use std::{
    fs,
    path::Path,
    time::{Instant, SystemTime},
};

use indicatif::{ProgressBar, ProgressStyle};
use prism_engine::error::{Error, Result};

use self::{
    contest::Aim,
    measure::{Measured, Pace, Point},
    page::Section,
    parts::{Extent, Part},
};
use crate::{
    app::{cli::ReportArgs, console, files},
    timing::{Device, WARM_UP},
};

/// The word for what is held at equal error; it has no stands of its own.
const CONTEST: &str = "contest";
/// The part that contests begin with.
const FRONT: &str = "front";
/// Scenes of the contests: all but the plane, whose view is told by its sweep.
const CONTEST_SCENES: &[&str] = &["torus", "suzanne", "needles", "terrain", "cliffs"];
/// Frames of a round of a scene's contests, about: two errors, three of ours, the floor and five baselines each.
const CONTEST_FRAMES: u64 = 18;

/// Runs the command.
pub fn run(args: &ReportArgs) -> Result<()> {
    let parts = chosen(args)?;
    make_folder(&args.out)?;
    let mut device = Device::new("prism report", &args.device, true)?;
    let log = device.ctx.validation_log();
    let started = SystemTime::now();

    let contests = parts.iter().filter(|part| in_contest(args, part)).count() as u64;
    let total = parts.iter().map(|part| frames(part, args)).sum::<u64>() + contests * contest_frames(args);
    let progress = progress(total);
    let tick = || progress.inc(1);
    let mut clock = Clock { end: Instant::now() + args.budget(), frames: total };
    let mut all: Vec<(Part, Measured)> = Vec::new();
    for part in parts {
        progress.set_message(part.title.clone());
        progress.tick();
        let pace = pace_until(args, clock.share(frames(&part, args)));
        let measured = measure::part(&part, &mut device, pace, &tick)?;
        all.push((part, measured));
        // A run that is stopped keeps what it has.
        write(&args.out, &page::About::new(&device, args, started), &all, &[])?;
    }
    let mut aims = Vec::new();
    for scene in fronts(&all) {
        let points = of_front(&all, &scene);
        aims.extend(contest::standing(&scene, &points));
        if wants(args, CONTEST) && CONTEST_SCENES.contains(&scene.as_str()) {
            progress.set_message(format!("At equal error: {scene}"));
            let pace = pace_until(args, clock.share(contest_frames(args)));
            aims.extend(contest::run(&scene, &points, &mut device, pace, &tick)?);
        }
    }
    progress.finish_and_clear();

    let about = page::About::new(&device, args, started);
    let sections = write(&args.out, &about, &all, &aims)?;
    drop(device);
    // Everything is destroyed now: what the validation layer has to say about that counts too.
    log.check()?;
    console::notice(format_args!("wrote {}", args.out.join("index.html").display()));
    console::data(&page::summary(&about, &sections, &aims))
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
    // Contests are between the points of a front and baselines of their own.
    let fronts = wants(args, CONTEST) && !wants(args, FRONT);
    let mut parts = Extent { quick: args.quick, size: args.pixels(), ours: fronts }.parts(&scenes);
    parts.retain(|part| wants(args, part.id) || (fronts && in_contest(args, part)));
    let asked = |technique: &str| {
        args.techniques.is_empty() || args.techniques.iter().any(|begin| technique.starts_with(begin.as_str()))
    };
    for part in &mut parts {
        for stand in &mut part.stands {
            stand.variants.retain(|variant| asked(&variant.technique));
            stand.matched.retain(|rival| asked(rival.name()));
        }
        part.stands.retain(|stand| !stand.variants.is_empty() || !stand.matched.is_empty());
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

/// The time that is left, and what is to be done in it.
struct Clock {
    end: Instant,
    frames: u64,
}

impl Clock {
    /// When the next ones are to end that draw so many of the frames that are left.
    fn share(&mut self, frames: u64) -> Instant {
        let now = Instant::now();
        let left = self.end.saturating_duration_since(now);
        let share = frames as f64 / self.frames.max(1) as f64;
        self.frames = self.frames.saturating_sub(frames);
        now + left.mul_f64(share.min(1.0))
    }
}

fn pace_until(args: &ReportArgs, end: Instant) -> Pace {
    Pace { rounds: args.rounds(), end, as_measured: args.quick }
}

/// Frames of a part: one to be measured and those that are timed.
fn frames(part: &Part, args: &ReportArgs) -> u64 {
    let points: usize = part.stands.iter().map(|s| s.variants.len() + s.matched.len()).sum();
    points as u64 * u64::from(1 + WARM_UP + args.rounds())
}

fn contest_frames(args: &ReportArgs) -> u64 {
    CONTEST_FRAMES * u64::from(1 + WARM_UP + args.rounds())
}

/// Whether a part is the front of a scene that has its contests.
fn in_contest(args: &ReportArgs, part: &Part) -> bool {
    part.id == FRONT && wants(args, CONTEST) && CONTEST_SCENES.contains(&part.stands[0].scene.as_str())
}

/// A bar on stderr with what is left, where that is a terminal.
fn progress(frames: u64) -> ProgressBar {
    let style = ProgressStyle::with_template("{bar:40} {pos}/{len} frames, {eta} left: {msg}");
    ProgressBar::new(frames).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}

/// Scenes that have a front.
fn fronts(all: &[(Part, Measured)]) -> Vec<String> {
    all.iter().filter(|(part, _)| part.id == FRONT).map(|(part, _)| part.stands[0].scene.clone()).collect()
}

fn of_front<'a>(all: &'a [(Part, Measured)], scene: &str) -> Vec<&'a Point> {
    let front = all.iter().filter(|(part, _)| part.id == FRONT).flat_map(|(_, measured)| &measured.points);
    front.filter(|point| point.scene == scene).collect()
}

/// Fills the folder, and returns what the page shows.
fn write(folder: &Path, about: &page::About, all: &[(Part, Measured)], aims: &[Aim]) -> Result<Vec<Section>> {
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
    text(&folder.join("index.html"), &page::html(about, &sections, aims))?;
    Ok(sections)
}

fn text(path: &Path, text: &str) -> Result<()> {
    files::replace(path, "page", |file| Ok(std::io::Write::write_all(file, text.as_bytes())?))
}
