//! `prism bench`: our fastest setting against the fastest baseline of the same error, a pre-tessellated mesh or triangles
//! diced for each frame. README.md says how to read the table.

pub mod contest;
pub mod scenes;
mod table;
pub mod variants;

use indicatif::{ProgressBar, ProgressStyle};
use prism_engine::{
    error::Result,
    measure::Metrics,
    scene::{self, Scene},
};

use self::{
    contest::{Judge, Judged},
    table::{Row, Target},
    variants::Variant,
};
use crate::{
    app::{assets, cli::BenchArgs, console, files},
    timing::{CULLS_BY, Device, Rounds, Spread, View},
};

/// The contest's scene: 2,304 triangles under a map of 512² texels.
const SCENE: &str = "torus.gltf";
/// Texels on a side of the map that is compared with the scene's own.
const FINE_SIDE: u32 = 4096;
/// The same with `--quick`, where nobody reads the figure.
const QUICK_SIDE: u32 = 1024;

/// One error's contestants.
struct Pair {
    error: f64,
    ours: Option<Judged>,
    micro_mesh: Option<(u32, Metrics)>,
    /// By tessellation and by mesh shaders, where the device has them.
    diced: Vec<Judged>,
}

/// Runs the command.
pub fn run(args: &BenchArgs) -> Result<()> {
    if let Some(path) = &args.csv {
        files::check_target(path, "table")?;
    }
    let mut device = Device::new("prism bench", &args.device, false)?;
    let log = device.ctx.validation_log();
    let [width, height] = args.pixels();
    let aspect = f64::from(width) / f64::from(height);
    let scene = scene::load(&assets::find(SCENE)?)?.with_defaults(aspect);
    let camera = scene.camera.unwrap_or_else(|| scene::frame(scene.bounds().unwrap_or_default(), aspect));
    let progress = Progress::new();

    progress.tell("tracing the truth");
    let view = View { camera, size: args.pixels() };
    let mut judge = Judge::new(&scene, view);
    progress.tell("measuring our settings");
    let tightest = args.errors.iter().copied().fold(f64::INFINITY, f64::min);
    let ours = judge.ours(&mut device, tightest)?;
    let fastest = judge.fastest(&mut device, &ours, &args.errors, args.rounds())?;
    progress.tell("measuring them by each stage");
    let by_stage =
        |judged: Option<Judged>| judged.map(|judged| judge.by_stage(&mut device, judged, args.rounds())).transpose();
    let fastest = fastest.into_iter().map(by_stage).collect::<Result<Vec<_>>>()?;
    let mut pairs = Vec::new();
    for (error, ours) in args.errors.iter().copied().zip(fastest) {
        progress.tell(&format!("looking for the micro-mesh within {error} footprints"));
        let micro_mesh = judge.density(&mut device, error)?;
        pairs.push(Pair { error, ours, micro_mesh, diced: Vec::new() });
    }

    for by in device.dicers() {
        progress.tell(&format!("looking for the edges of {by}"));
        for (pair, diced) in pairs.iter_mut().zip(judge.diced(&mut device, by, &args.errors)?) {
            pair.diced.extend(diced);
        }
    }

    progress.tell("building what is timed");
    let mut bench = Bench { device, view, rounds: Rounds::default(), rows: Vec::new(), later: Vec::new() };
    bench.memory(&scene, &pairs)?;
    for pair in &pairs {
        bench.contest(&scene, pair)?;
    }
    let side = if args.quick { QUICK_SIDE } else { FINE_SIDE };
    if let Some(ours) = pairs.iter().min_by(|a, b| a.error.total_cmp(&b.error)).and_then(|pair| pair.ours.as_ref()) {
        bench.floors(&scene, &ours.variant)?;
        bench.growth(&scene, &ours.variant, side)?;
    }
    let rounds = args.rounds();
    progress.count(u64::from(rounds), bench.rounds.len());
    let text = bench.finish(rounds, &progress, args)?;
    // Everything is destroyed now: what the validation layer has to say about that counts too.
    log.check()?;
    console::data(&text)
}

/// What a row's value is, once all have been timed.
enum Measured {
    /// One variant's time.
    Time(usize),
    /// The first over the fastest of the others.
    Over(usize, Vec<usize>),
    /// The fastest of the first over the second.
    Under(Vec<usize>, usize),
}

struct Bench {
    device: Device,
    view: View,
    rounds: Rounds,
    rows: Vec<Row>,
    /// Rows whose value is to be measured, by place.
    later: Vec<(usize, Measured)>,
}

impl Bench {
    fn push(&mut self, row: Row, measured: Option<Measured>) {
        if let Some(measured) = measured {
            self.later.push((self.rows.len(), measured));
        }
        self.rows.push(row);
    }

    /// Lets a variant take part, once whatever the number of its rows. `what` tells the scenes apart.
    fn place(&mut self, what: &str, scene: &Scene, variant: &Variant) -> Result<usize> {
        let name = format!("{what}, {}", variant.name);
        self.rounds.add(&mut self.device, &name, scene, &variant.settings, &self.view)
    }

    /// A row for the time of the variant at a place.
    fn time(&mut self, row: &str, place: usize, variant: &Variant, metrics: Option<Metrics>) {
        let (name, setting) = (row.to_owned(), variant.name.clone());
        self.push(Row { name, setting, metrics, unit: "ms", ..Row::default() }, Some(Measured::Time(place)));
    }

    /// One error's contest.
    fn contest(&mut self, scene: &Scene, pair: &Pair) -> Result<()> {
        let what = format!("{} footprints", pair.error);
        let (mut by_cluster, mut others) = (Vec::new(), Vec::new());
        if let Some((density, metrics)) = pair.micro_mesh {
            for (variant, culls_clusters) in variants::micro_meshes(density) {
                let place = self.place(SCENE, scene, &variant)?;
                self.time(&format!("{what}: micro-mesh"), place, &variant, Some(metrics));
                by_cluster.extend(culls_clusters.then_some(place));
                others.push(place);
            }
        }
        for Judged { variant, metrics } in &pair.diced {
            let place = self.place(SCENE, scene, variant)?;
            self.time(&format!("{what}: diced"), place, variant, Some(*metrics));
            others.push(place);
        }
        let mut own = None;
        if let Some(ours) = &pair.ours {
            let place = self.place(SCENE, scene, &ours.variant)?;
            self.time(&format!("{what}: ours"), place, &ours.variant, Some(ours.metrics));
            own = Some(place);
        }
        let target = variants::SPEEDUPS.iter().find(|(error, _)| *error == pair.error);
        for (than, others) in [("micro-mesh culled by cluster", by_cluster), ("fastest baseline", others)] {
            let row = Row {
                name: format!("{what}: times faster than the {than}"),
                setting: pair.ours.as_ref().map_or("none is within the error".to_owned(), |o| o.variant.name.clone()),
                unit: "×",
                target: target.map(|(_, speedup)| Target::AtLeast(*speedup)),
                ..Row::default()
            };
            let measured = own.filter(|_| !others.is_empty()).map(|place| Measured::Under(others, place));
            self.push(row, measured);
        }
        Ok(())
    }

    /// What there is to pay at least, and how much more ours costs.
    fn floors(&mut self, scene: &Scene, ours: &Variant) -> Result<()> {
        let place = self.place(SCENE, scene, ours)?;
        for (row, floor, most) in variants::floors() {
            let least = self.place(SCENE, scene, &floor)?;
            self.time(row, least, &floor, None);
            let (name, setting) = (format!("ours over the {row}"), ours.name.clone());
            let row = Row { name, setting, unit: "×", target: most.map(Target::AtMost), ..Row::default() };
            self.push(row, Some(Measured::Over(place, vec![least])));
        }
        Ok(())
    }

    /// What more triangles, texels and detail cost.
    fn growth(&mut self, scene: &Scene, ours: &Variant, side: u32) -> Result<()> {
        let place = self.place(SCENE, scene, ours)?;
        let doubled = scenes::doubled(scene);
        let scenes = [
            (
                format!("{} triangles for {}", scenes::triangles(&doubled), scenes::triangles(scene)),
                doubled,
                Some(variants::DOUBLED),
            ),
            (format!("same detail in a map of {side}²"), scenes::resampled(scene, side), Some(variants::FINE_MAP)),
            (format!("{} times finer detail", scenes::FINER), scenes::finer_detail(scene), None),
        ];
        for (row, scene, most) in scenes {
            let other = self.place(&row, &scene, ours)?;
            self.time(&row, other, ours, None);
            let (name, setting) = (format!("{row}: times as long"), ours.name.clone());
            let row = Row { name, setting, unit: "×", target: most.map(Target::AtMost), ..Row::default() };
            self.push(row, Some(Measured::Over(other, vec![place])));
        }
        Ok(())
    }

    /// Memory of the tightest error's shell and of each micro-mesh.
    fn memory(&mut self, scene: &Scene, pairs: &[Pair]) -> Result<()> {
        let tightest = pairs.iter().min_by(|a, b| a.error.total_cmp(&b.error)).and_then(|pair| pair.ours.as_ref());
        let colors: Vec<&str> = scene.images.iter().map(|image| image.name.as_str()).collect();
        let shell = tightest.map(|ours| {
            let bytes = self.device.footprint(scene, &ours.variant.settings, |name| !colors.contains(&name))?;
            self.push(memory_row("memory of the shell", &ours.variant.name, &bytes), None);
            Ok::<_, prism_engine::error::Error>(total(&bytes))
        });
        let shell = shell.transpose()?;
        for pair in pairs {
            let Some((density, _)) = pair.micro_mesh else { continue };
            let Some((variant, _)) = variants::micro_meshes(density).into_iter().next() else { continue };
            let counts = |name: &str| name.contains("micro-") || name == CULLS_BY;
            let bytes = self.device.footprint(scene, &variant.settings, counts)?;
            self.push(
                memory_row(&format!("memory of the micro-mesh, {} footprints", pair.error), &variant.name, &bytes),
                None,
            );
            if let Some(shell) = shell {
                let name = format!("micro-mesh's memory over the shell's, {} footprints", pair.error);
                let value = exactly(total(&bytes) / shell);
                self.push(Row { name, setting: variant.name, unit: "×", value, ..Row::default() }, None);
            }
        }
        // That of the base mesh and the map is the same at every edge length.
        for diced in pairs.first().map_or(&[][..], |pair| &pair.diced) {
            let bytes = self.device.footprint(scene, &diced.variant.settings, |name| !colors.contains(&name))?;
            self.push(memory_row("memory of diced triangles", &diced.variant.name, &bytes), None);
        }
        Ok(())
    }

    /// Times everything and fills the rows.
    fn finish(mut self, rounds: u32, progress: &Progress, args: &BenchArgs) -> Result<String> {
        self.rounds.run(&mut self.device, rounds, |done| progress.done(u64::from(done)))?;
        let timed = &self.rounds;
        let fastest = |places: &[usize]| {
            let median = |place: usize| timed.timing(place).spread().map_or(f64::INFINITY, |spread| spread.median);
            places.iter().copied().min_by(|a, b| median(*a).total_cmp(&median(*b)))
        };
        for (row, measured) in &self.later {
            self.rows[*row].value = match measured {
                Measured::Time(place) => timed.timing(*place).spread(),
                Measured::Over(a, others) => fastest(others).and_then(|b| timed.ratio(*a, b)),
                Measured::Under(others, b) => fastest(others).and_then(|a| timed.ratio(a, *b)),
            };
        }
        if let Some(path) = &args.csv {
            table::write_csv(path, &self.rows)?;
            console::notice(format_args!("wrote {}", path.display()));
        }
        let [width, height] = args.pixels();
        let device = format!("{}, {}", self.device.ctx.device_name(), self.device.ctx.driver().trim());
        Ok(format!(
            "{device}; {SCENE} at {width}x{height}; {rounds} rounds of {} variants in turns; ratios are of one round \
             each\n\n{}",
            timed.len(),
            table::markdown(&self.rows)
        ))
    }
}

fn memory_row(name: &str, setting: &str, bytes: &[(String, f64)]) -> Row {
    let parts: Vec<String> = bytes.iter().map(|(name, mib)| format!("{name} {mib:.2}")).collect();
    let setting = format!("{setting}: {}", parts.join(", "));
    Row { name: name.to_owned(), setting, unit: "MiB", value: exactly(total(bytes)), ..Row::default() }
}

fn total(bytes: &[(String, f64)]) -> f64 {
    bytes.iter().map(|(_, mib)| mib).sum()
}

fn exactly(value: f64) -> Option<Spread> {
    Some(Spread { low: value, median: value, high: value })
}

/// What is done now, on stderr where that is a terminal.
struct Progress(ProgressBar);

impl Progress {
    fn new() -> Progress {
        Progress(ProgressBar::new_spinner())
    }

    fn tell(&self, what: &str) {
        self.0.set_message(what.to_owned());
        self.0.tick();
    }

    fn count(&self, rounds: u64, variants: usize) {
        if let Ok(style) = ProgressStyle::with_template("{bar:40} {pos}/{len} rounds of {msg} variants, {eta} left") {
            self.0.set_style(style);
        }
        self.0.set_length(rounds);
        self.0.set_message(variants.to_string());
    }

    fn done(&self, rounds: u64) {
        self.0.set_position(rounds);
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}
