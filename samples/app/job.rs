//! One run, decided: what is drawn, where, how often, and which files come out of it.

use std::{
    env,
    path::{Path, PathBuf},
};

use prism_engine::{
    error::{Error, Result},
    settings::{Settings, View},
};

use super::{
    animation::{self, Kind},
    assets, choices,
    cli::{CommonArgs, ExplainArgs, RenderArgs, RunArgs, SessionArgs},
    console, files,
    sample::{Sample, Source},
    still::Still,
    walk::Walk,
};

/// The time from one frame to the next of a headless run whose frames are no animation, seconds.
const HEADLESS_STEP: f64 = 1.0 / 60.0;

/// A run whose flags have been checked. Nothing of it is loaded yet.
#[derive(Clone)]
pub struct Job<'a> {
    /// What moves.
    pub sample: &'a dyn Sample,
    /// Its glTF files.
    pub walk: Walk,
    /// How it is drawn.
    pub settings: Settings,
    /// Camera, device and measurements as they were typed.
    pub common: CommonArgs,
    /// Whether it is shown in a window.
    pub window: bool,
    /// How many frames; absent in a window that the user closes.
    pub frames: Option<u64>,
    /// Seconds from frame to frame; absent where the clock decides.
    pub time_step: Option<f64>,
    /// The picture, if one is written; with a turntable all of its frames.
    pub out: Option<PathBuf>,
    /// All frames, if they are written.
    pub sequence: Option<PathBuf>,
}

/// The settings of a job: what the flags ask of the picture, and what `--stats` wants counted.
fn settings(args: &CommonArgs, sample: &dyn Sample) -> Result<Settings> {
    let mut settings = args.apply_baseline(choices::settings(&args.look, &args.classic, &sample.settings())?)?;
    args.surface.apply(&mut settings)?;
    choices::check_view(&settings)?;
    let view = settings.view;
    if view != View::Shaded {
        if sample.exhibit().is_some() || sample.embedding().is_some() {
            return usage(format!(
                "--view {view}: {} composes its picture itself; use `prism run viewer`",
                sample.id()
            ));
        }
        if args.session.aov.is_some() {
            return usage(format!(
                "--view {view}: --aov writes the surface itself, whatever the view; drop one of them"
            ));
        }
    }
    Ok(Settings { count_limits: args.session.stats, still: !sample.moves(), ..settings })
}

impl<'a> Job<'a> {
    /// `prism run`.
    pub fn run(args: RunArgs, samples: &[&'a dyn Sample]) -> Result<Job<'a>> {
        let sample = find(&args.sample, samples)?;
        let sample = args.tilt.map_or(Ok(sample), |degrees| tilted(sample, degrees))?;
        let embedded = sample.embedding().is_some();
        if embedded {
            refuse_without_application(&args, sample)?;
        }
        if args.common.baseline.is_on() && (embedded || sample.exhibit().is_some()) {
            return usage(format!("--baseline: {} shows techniques of its own; use `prism run viewer`", sample.id()));
        }
        let walk = match (sample.scene(), args.scene) {
            (Source::Walk(names), chosen) => {
                let files = names.iter().map(|name| assets::find(name)).collect::<Result<_>>()?;
                Walk::several(files, chosen.as_deref())?
            }
            (Source::Chosen { .. }, Some(file)) => Walk::single(file),
            (_, Some(_)) => {
                return usage(format!("--scene: {} brings its own scene; use `prism run viewer`", sample.id()));
            }
            (Source::Asset(name) | Source::Chosen { default: name }, None) => Walk::single(assets::find(name)?),
            (Source::File(file), None) => Walk::single(file),
        };
        let session = &args.common.session;
        let files_only = args.headless
            || [&args.out, &args.sequence, &session.aov].into_iter().any(Option::is_some)
            || session.turntable.is_some();
        refuse_beside_turntable(&args.common, args.frames)?;
        if let Some(path) = &args.sequence {
            let flag = format!("--sequence {}", path.display());
            if session.turntable.is_some() {
                return usage(format!("{flag}: --out has the frames of a turntable; drop one of the two"));
            }
            if args.frames.is_none() {
                return usage(format!("{flag}: one frame is no sequence; add --frames N"));
            }
        }
        let window = !files_only && !embedded && window_possible();
        if args.time_step.is_some() && !sample.moves() {
            return usage(format!("--time-step: nothing in {} moves with time; drop the flag", sample.id()));
        }
        if !window && args.time_step.is_some() && args.frames.is_none() {
            return usage("--time-step needs --frames without a window: a single frame is at time 0".into());
        }
        let step = if args.sequence.is_some() { animation::STEP } else { HEADLESS_STEP };
        let files = args.sequence.is_some() || session.aov.is_some();
        let job = Job {
            sample,
            walk,
            settings: settings(&args.common, sample)?,
            window,
            frames: if window { args.frames } else { Some(frames(&args.common, args.frames)) },
            time_step: if window { args.time_step } else { Some(args.time_step.unwrap_or(step)) },
            out: if window { None } else { picture(args.out, files, &args.common, sample.id()) },
            sequence: args.sequence,
            common: args.common,
        };
        if let Some(exhibit) = sample.exhibit() {
            exhibit.frame_size(job.size())?;
        }
        job.check_files()?;
        Ok(job)
    }

    /// `prism render`. `still` is the sample that draws `args.scene` as it is.
    pub fn render(args: RenderArgs, still: &'a Still) -> Result<Job<'a>> {
        refuse_beside_turntable(&args.common, args.frames)?;
        let stem = args.scene.file_stem().map_or("frame".into(), |stem| stem.to_string_lossy().into_owned());
        let job = Job {
            sample: still,
            settings: settings(&args.common, still)?,
            window: false,
            frames: Some(frames(&args.common, args.frames)),
            time_step: Some(0.0),
            out: picture(args.out, args.common.session.aov.is_some(), &args.common, &stem),
            sequence: None,
            walk: Walk::single(args.scene),
            common: args.common,
        };
        job.check_files()?;
        Ok(job)
    }

    /// `prism explain`: a sample by its name, else a file. `still` is the sample that draws it as it is.
    pub fn explain(args: &ExplainArgs, samples: &[&'a dyn Sample], still: &'a Still) -> Result<Job<'a>> {
        let session = SessionArgs { size: args.size, gpu: args.gpu.clone(), ..SessionArgs::default() };
        let (look, classic, surface) = (args.look.clone(), args.classic.clone(), args.surface.clone());
        let common = CommonArgs { look, classic, surface, session, ..CommonArgs::default() };
        let id = args.what.to_string_lossy();
        if samples.iter().any(|sample| sample.id() == id) || args.what.extension().is_none() {
            let run = RunArgs { sample: id.into_owned(), scene: args.scene.clone(), common, ..RunArgs::default() };
            return Job::run(RunArgs { headless: true, ..run }, samples);
        }
        if args.scene.is_some() {
            return usage("--scene chooses one of a sample's, and this is a file; drop it".into());
        }
        Job::render(RenderArgs { scene: args.what.clone(), headless: true, frames: None, out: None, common }, still)
    }

    /// Another sample as its name alone would show it, in a window of this size; on the same device, with the same checks
    /// and shaders.
    #[cfg(feature = "window")]
    pub fn beside(&self, id: &str, [width, height]: [u32; 2], samples: &[&'a dyn Sample]) -> Result<Job<'a>> {
        let SessionArgs { gpu, validation, shader_dir, .. } = self.common.session.clone();
        let mut session = SessionArgs { gpu, validation, shader_dir, ..SessionArgs::default() };
        (session.size.width, session.size.height) = (width, height);
        let common = CommonArgs { session, ..CommonArgs::default() };
        Job::run(RunArgs { sample: id.to_owned(), common, ..RunArgs::default() }, samples)
    }

    /// The same of another file, seen by its own camera.
    #[cfg(feature = "window")]
    pub fn of_file(&self, file: PathBuf) -> Job<'a> {
        let common = CommonArgs { camera: Default::default(), ..self.common.clone() };
        Job { walk: Walk::single(file), common, ..self.clone() }
    }

    /// Width and height of the picture, or of the window when it opens.
    pub fn size(&self) -> [u32; 2] {
        let size = self.common.session.size;
        [size.width, size.height]
    }

    /// The output files' names make sense and their folders exist, found out before minutes are spent.
    fn check_files(&self) -> Result<()> {
        let session = &self.common.session;
        let mut pictures = Some("png");
        if let (Some(_), Some(path)) = (session.turntable, &self.out) {
            Kind::of("--out", path)?;
            pictures = None;
        }
        if let Some(path) = &self.sequence {
            Kind::of("--sequence", path)?;
        }
        let outputs = [
            ("--out", "picture", &self.out, pictures),
            ("--sequence", "animation", &self.sequence, None),
            ("--aov", "surface data", &session.aov, Some("exr")),
            ("--csv", "table", &session.csv, None),
        ];
        let mut seen: Vec<(&str, &Path)> = Vec::new();
        for (flag, object, path, format) in outputs {
            let Some(path) = path else { continue };
            let extension = path.extension().map(|extension| extension.to_string_lossy().to_lowercase());
            if let (Some(format), Some(extension)) = (format, extension)
                && extension != format
            {
                return usage(format!("{flag} {}: only .{format} is written; name it so", path.display()));
            }
            if let Some((other, _)) = seen.iter().find(|(_, taken)| *taken == path) {
                return usage(format!("{other} and {flag} both name {}; name two files", path.display()));
            }
            files::check_target(path, object)?;
            seen.push((flag, path));
        }
        Ok(())
    }
}

/// What is the application's doing, and not that of a sample which draws by itself.
fn refuse_without_application(args: &RunArgs, sample: &dyn Sample) -> Result<()> {
    let session = &args.common.session;
    let flags = [
        ("--frames", args.frames.is_some()),
        ("--sequence", args.sequence.is_some()),
        ("--aov", session.aov.is_some()),
        ("--turntable", session.turntable.is_some()),
        ("--csv", session.csv.is_some()),
        ("--stats", session.stats),
        ("--gpu", session.gpu.is_some()),
    ];
    match flags.iter().find(|(_, given)| *given) {
        Some((flag, _)) => usage(format!("{flag}: {} draws one picture on a device of its own; drop it", sample.id())),
        None => Ok(()),
    }
}

/// How many frames are drawn without a window.
fn frames(common: &CommonArgs, asked: Option<u64>) -> u64 {
    common.session.turntable.map_or(asked.unwrap_or(1), u64::from)
}

/// A turntable's frames are all of one turn, and only their colours are kept.
fn refuse_beside_turntable(common: &CommonArgs, frames: Option<u64>) -> Result<()> {
    let others = [("--frames", frames.is_some()), ("--aov", common.session.aov.is_some())];
    match others.iter().find(|(_, given)| *given && common.session.turntable.is_some()) {
        Some((flag, _)) => {
            usage(format!("{flag}: a turntable draws the frames of one turn, as pictures; drop one of the two"))
        }
        None => Ok(()),
    }
}

/// The sample with its wall at this tilt.
fn tilted(sample: &dyn Sample, degrees: f32) -> Result<&'static dyn Sample> {
    sample.tilted(f64::from(degrees)).ok_or_else(|| {
        Error::Usage(format!("--tilt: {} has no wall to tilt; use `prism run procedural`, or --eye", sample.id()))
    })
}

/// The named sample.
fn find<'a>(id: &str, samples: &[&'a dyn Sample]) -> Result<&'a dyn Sample> {
    samples.iter().copied().find(|sample| sample.id() == id).ok_or_else(|| {
        let ids: Vec<&str> = samples.iter().map(|sample| sample.id()).collect();
        let file = Path::new(id).extension().is_some();
        let mend = if file { "; a glTF file is shown by `prism run viewer --scene FILE`" } else { "" };
        Error::Usage(format!("no sample is called '{id}'; there are {}{mend}", ids.join(", ")))
    })
}

/// Where the picture goes: nowhere if only other `files` were asked for.
fn picture(out: Option<PathBuf>, files: bool, common: &CommonArgs, name: &str) -> Option<PathBuf> {
    let ending = if common.session.turntable.is_some() { "gif" } else { "png" };
    out.or_else(|| (!files).then(|| PathBuf::from(format!("{name}.{ending}"))))
}

/// Whether a window can be opened, as far as the build and the environment tell. Says so if not.
fn window_possible() -> bool {
    if cfg!(not(feature = "window")) {
        console::notice("this build has no window (feature `window`); rendering headless");
        return false;
    }
    let set = |name: &str| env::var_os(name).is_some_and(|value| !value.is_empty());
    let display = !cfg!(all(unix, not(target_os = "macos")))
        || ["WAYLAND_DISPLAY", "WAYLAND_SOCKET", "DISPLAY"].into_iter().any(set);
    if !display {
        console::notice("no display (neither WAYLAND_DISPLAY nor DISPLAY is set); rendering headless");
    }
    display
}

fn usage<T>(message: String) -> Result<T> {
    Err(Error::Usage(message))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::cli::{Cli, Command};
    use clap::Parser;

    struct Own;
    impl Sample for Own {
        fn id(&self) -> &'static str {
            "own"
        }
        fn summary(&self) -> &'static str {
            "brings its own scene"
        }
        fn scene(&self) -> Source {
            Source::File("own.gltf".into())
        }
    }

    fn job(line: &str) -> Result<Job<'static>> {
        let words = std::iter::once("prism").chain(line.split_whitespace());
        match Cli::try_parse_from(words).expect(line).command {
            Command::Run(args) => Job::run(args, &[&Own, &crate::viewer::Viewer]),
            Command::Render(args) => {
                let still = Box::leak(Box::new(Still(args.scene.clone())));
                Job::render(args, still)
            }
            other => panic!("parsed as {other:?}"),
        }
    }

    #[test]
    fn the_picture_is_named_after_what_is_drawn() {
        assert_eq!(job("run own --headless").unwrap().out.as_deref(), Some(Path::new("own.png")));
        assert_eq!(job("render /some/wall.glb").unwrap().out.as_deref(), Some(Path::new("wall.png")));
        assert_eq!(job("render wall.glb --aov wall.exr").unwrap().out, None);
        let both = job("render wall.glb --aov wall.exr --out a.png").unwrap();
        assert_eq!(both.out.as_deref(), Some(Path::new("a.png")));
    }

    #[test]
    fn a_headless_run_counts_its_frames() {
        let one = job("run own --headless").unwrap();
        assert_eq!((one.window, one.frames, one.time_step), (false, Some(1), Some(HEADLESS_STEP)));
        let three = job("run own --out a.png --frames 3 --time-step 0.5").unwrap();
        assert_eq!((three.window, three.frames, three.time_step), (false, Some(3), Some(0.5)));
        let all = job("run own --sequence a.gif --frames 3").unwrap();
        assert_eq!((all.window, all.frames, all.time_step, all.out), (false, Some(3), Some(0.04), None));
    }

    #[test]
    fn wrong_usage_is_told_before_anything_is_loaded() {
        for line in [
            "run nothing",
            "run scene.gltf",
            "run own --scene other.gltf",
            "run own --tilt 80",
            "run own --sequence a.png",
            "run own --sequence a.mp4 --frames 4",
            "run own --sequence a.png --frames 4 --out a.png",
            "run own --sequence a.png --turntable 4",
            "run own --headless --time-step 0.5",
            "run viewer --headless --frames 2 --time-step 0.5",
            "run own --out a.jpg",
            "render a.gltf --aov a.png",
            "render a.gltf --csv a.png --out a.png",
            "render a.gltf --march none",
            "render a.gltf --height-lod auto",
            "render a.gltf --shell off --march exact --height-lod auto",
        ] {
            let error = job(line).err().unwrap_or_else(|| panic!("{line}: accepted"));
            assert_eq!(error.exit_code(), 2, "{line}: {error}");
        }
        let error = job("render a.gltf --out /no/such/folder/a.png").err().expect("no folder");
        assert_eq!(error.exit_code(), 1);
    }

    #[test]
    fn a_wrong_name_lists_the_right_ones() {
        let error = job("run nothing").err().expect("unknown").to_string();
        assert!(error.contains("own, viewer"), "{error}");
    }
}
