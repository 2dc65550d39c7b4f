//! The command line's grammar: what can be typed. What it means is decided in [`super::choices`].

use std::path::PathBuf;

use super::{baseline::BaselineArgs, classic::ClassicArgs, surface::SurfaceArgs};
use clap::{ArgAction, Args, Parser, Subcommand, builder::PossibleValuesParser, builder::TypedValueParser};
use prism_engine::{
    scene::Wrap,
    settings::{DepthPrepass, March, PrismCulling, SelfShadow, Shell, Silhouette, Stage, Validation, View},
};

/// Displaced detail on coarse meshes, by rays traced inside prism shells.
#[derive(Debug, Parser)]
#[command(name = "prism", version, after_help = AFTER_HELP)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

const AFTER_HELP: &str = "\
Exit codes: 0 done, 1 failed, 2 wrong usage, 77 this machine lacks what was asked (named).
Data go to stdout, notices to stderr. `prism COMMAND --help` has every option and its default.
PRISM_ASSETS names the assets' folder; PRISM_LOG=debug shows the engine's log.";

const RUN_AFTER_HELP: &str = "\
Keys in the window: U or F1 shows the panel (open where the window is 900 pixels wide) or puts it away, S stage, \
H shell on or off, M march, V the next view, 1 to 9 and 0 the first ten of them, E the error, K compares two settings \
(those of then on the right of a line that the mouse drags), X anti-aliasing, D dithered start, L self-shadow, \
W shadow maps, A ambient occlusion, without a shell C clipped outline and G normals, Space pauses the sample's time, \
R resets the camera, N and B show the next and the last scene of a sample of several, \
F11 or F lets RenderDoc take the next frame where it is loaded, F12 or P saves a screenshot in the current folder, \
Esc or Q quits. A click probes a pixel's ray, left drag turns the camera, right or middle drag \
(or Shift and left drag) moves it sideways, the wheel or a two-finger scroll or pinch zooms.";

const BAKE_AFTER_HELP: &str = "\
A cone's ratio is its radius in UV at height 1 over its tip, 1 at most. Its promise holds wherever the map is read, \
nearest or bilinearly; the ratio is rounded down. As .png: 16-bit RGB, red the height, green the square root of the \
ratio, blue 0. As .exr: 32-bit floats height.H and cone.R, the ratio itself.
minmax, .exr only: a part per level, 'level 0' the finest, with channels min and max. Node k of level L spans the \
texels k 2^L to (k + 1) 2^L along each axis, one less where the map is clamped, wrapped one by one; one node more than \
the map needs holds what lies beyond its end.";

const PROBE_AFTER_HELP: &str = "\
On the left the path over the height map, the base triangles of its prisms, and the straight ray that parallax mapping \
takes for it. On the right the ray's level against the surface's, each march's samples below, and what is around the \
hit. All of it is computed on the CPU in 64-bit floats; the true hit is the reference's.";

/// The commands of this build.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// The samples, one line each
    List,
    /// Every Vulkan device, and why one is refused
    Devices,
    /// Runs a sample: in a window where there is a display, else headless
    ///
    /// --headless, --out and --aov each keep it from opening a window.
    #[command(after_help = RUN_AFTER_HELP)]
    Run(RunArgs),
    /// Renders one frame of a glTF file offscreen
    Render(RenderArgs),
    /// What a scene or a sample needs, what was left out, and why
    Explain(ExplainArgs),
    /// Makes a cone map or a min-max pyramid of a height map, on the GPU
    #[command(after_help = BAKE_AFTER_HELP)]
    Bake(BakeArgs),
    /// Draws what one pixel's ray does in the shell: its path, the samples of each march, their hits and the true one
    #[command(after_help = PROBE_AFTER_HELP)]
    Probe(ProbeArgs),
    /// Our fastest setting against the fastest baseline of the same error, on a torus; a Markdown table
    Bench(BenchArgs),
    /// Error against run time: every technique, every baseline, one thing varied at a time; a page with plots and pictures
    #[cfg(feature = "report")]
    Report(ReportArgs),
}

/// `prism run SAMPLE`.
#[derive(Debug, Default, Args)]
pub struct RunArgs {
    /// One of `prism list`
    pub sample: String,

    /// The glTF file to look at, for `viewer`; where to begin, by name or number, for a sample of several scenes
    /// [default: the sample's own, the first]
    #[arg(long, value_name = "FILE|NAME|NUMBER", allow_hyphen_values = true)]
    pub scene: Option<PathBuf>,

    /// The angle between the view and the wall's normal, for `procedural`: one row at it in place of three; 0 to 88 degrees
    /// [default: 60, 80 and 88]
    #[arg(long, value_name = "DEG", value_parser = |s: &str| ranged(s, 0.0, 88.0))]
    pub tilt: Option<f32>,

    /// Never opens a window; writes a picture instead [default: off where there is a display]
    #[arg(long)]
    pub headless: bool,

    /// Ends after N frames, in a window too; headless, the last one is the picture
    /// [default: 1 headless, endless in a window]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    pub frames: Option<u64>,

    /// Seconds of the sample's time from one frame to the next
    /// [default: 1/60 headless, the clock's in a window]
    #[arg(long, value_name = "S", value_parser = seconds, allow_hyphen_values = true)]
    pub time_step: Option<f64>,

    /// The picture, an sRGB PNG [default: SAMPLE.png in the current folder; none if only --aov is given]
    #[arg(long, value_name = "FRAME.png")]
    pub out: Option<PathBuf>,

    /// What is common with `render`.
    #[command(flatten)]
    pub common: CommonArgs,
}

/// `prism render SCENE`.
#[derive(Debug, Args)]
pub struct RenderArgs {
    /// A glTF 2.0 file, .gltf or .glb
    pub scene: PathBuf,

    /// Never opens a window [default: always so with `render`]
    #[arg(long)]
    pub headless: bool,

    /// Renders the same frame N times, for --stats and --csv [default: 1]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    pub frames: Option<u64>,

    /// The picture, an sRGB PNG
    /// [default: the scene's name with .png in the current folder; none if only --aov is given]
    #[arg(long, value_name = "FRAME.png")]
    pub out: Option<PathBuf>,

    /// What is common with `run`.
    #[command(flatten)]
    pub common: CommonArgs,
}

/// `prism explain SCENE|SAMPLE`.
#[derive(Debug, Args)]
pub struct ExplainArgs {
    /// A glTF 2.0 file, .gltf or .glb, or one of `prism list`
    #[arg(value_name = "SCENE|SAMPLE")]
    pub what: PathBuf,

    /// Which one, of a sample of several scenes; the file, of viewer [default: the first]
    #[arg(long, value_name = "FILE|NAME|NUMBER", allow_hyphen_values = true)]
    pub scene: Option<PathBuf>,

    /// Prints JSON in place of text [default: off]
    #[arg(long)]
    pub json: bool,

    /// Of the picture that it is explained for, in pixels
    #[arg(long, value_name = "WxH", value_parser = size, default_value = "1280x720")]
    pub size: Size,

    /// The device that it is explained for, by its index or a part of its name [default: the best]
    #[arg(long, value_name = "INDEX|NAME")]
    pub gpu: Option<String>,

    /// How it is drawn.
    #[command(flatten)]
    pub look: LookArgs,
    /// The same, of the classic techniques.
    #[command(flatten)]
    pub classic: ClassicArgs,
    /// What is drawn otherwise than the file says.
    #[command(flatten)]
    pub surface: SurfaceArgs,
}

/// The device and the shaders of a command that is no sample.
#[derive(Clone, Debug, Args)]
pub struct DeviceArgs {
    /// A device by its index or a part of its name, as in `prism devices` [default: the best]
    #[arg(long, value_name = "INDEX|NAME")]
    pub gpu: Option<String>,

    /// The validation layer's checks; a warning or an error fails the run
    #[arg(long, default_value = "off", value_parser = words(Validation::ALL, Validation::name))]
    pub validation: Validation,

    /// Reads the shaders from this folder [default: those in the program]
    #[arg(long, value_name = "DIR")]
    pub shader_dir: Option<PathBuf>,
}

/// What can be baked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BakeKind {
    /// No surface in a cone.
    Cone,
    /// A ray crosses the surface at most once in a cone.
    RelaxedCone,
    /// Least and greatest heights of blocks of texels.
    MinMax,
}

impl BakeKind {
    const ALL: &'static [BakeKind] = &[BakeKind::Cone, BakeKind::RelaxedCone, BakeKind::MinMax];

    /// The word on the command line.
    pub fn name(self) -> &'static str {
        match self {
            BakeKind::Cone => "cone",
            BakeKind::RelaxedCone => "relaxed-cone",
            BakeKind::MinMax => "minmax",
        }
    }
}

/// `prism bake KIND IN.png OUT`.
#[derive(Clone, Debug, Args)]
pub struct BakeArgs {
    /// What to make
    #[arg(value_parser = words(BakeKind::ALL, BakeKind::name))]
    pub kind: BakeKind,

    /// The height map, an 8- or 16-bit PNG; its red channel counts
    #[arg(value_name = "IN.png")]
    pub input: PathBuf,

    /// Where to: .png (cones only) or .exr
    #[arg(value_name = "OUT")]
    pub out: PathBuf,

    /// How the map goes on beyond its edges
    #[arg(long, default_value = "repeat", value_parser = words(WRAPS, wrap_name))]
    pub wrap: Wrap,

    /// Where it is computed.
    #[command(flatten)]
    pub device: DeviceArgs,
}

const WRAPS: &[Wrap] = &[Wrap::Repeat, Wrap::Mirror, Wrap::Clamp];

fn wrap_name(wrap: Wrap) -> &'static str {
    match wrap {
        Wrap::Repeat => "repeat",
        Wrap::Mirror => "mirror",
        Wrap::Clamp => "clamp",
    }
}

/// `prism probe SCENE`.
#[derive(Clone, Debug, Args)]
pub struct ProbeArgs {
    /// A glTF 2.0 file, .gltf or .glb
    pub scene: PathBuf,

    /// Column and row, from 0, row 0 on top
    #[arg(long, value_name = "X,Y", value_parser = pixel, allow_hyphen_values = true)]
    pub pixel: [u32; 2],

    /// The drawing, an SVG [default: probe.svg in the current folder]
    #[arg(long, value_name = "PROBE.svg", default_value = "probe.svg", hide_default_value = true)]
    pub out: PathBuf,

    /// Prints the figures as JSON: the prisms, each march's samples and hit, the true hit [default: not printed]
    #[arg(long)]
    pub json: bool,

    /// Of the picture that has the pixel
    #[arg(long, value_name = "WxH", value_parser = size, default_value = "1280x720")]
    pub size: Size,

    /// The marches that are followed, each one that traces rays; exact is the true hit
    /// [default: all that the scene allows]
    #[arg(long, value_name = "MARCH,…", value_delimiter = ',', value_parser = tracing_march())]
    pub march: Vec<March>,

    /// Fewest linear steps of a prism, 1 to 4096 [default: 8, or --max-steps where that is less]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub min_steps: Option<u32>,

    /// Most steps of a prism, 1 to 4096 [default: 64, or --min-steps where that is more]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub max_steps: Option<u32>,

    /// Steps after the linear search, or in the last cone, 0 to 64 [default: 8; secant 5]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=64))]
    pub refine_steps: Option<u32>,

    /// Where march secant is content, as a share of the height's range, 0 to 1 [default: 0.01]
    #[arg(long, value_name = "N", value_parser = share)]
    pub tolerance: Option<f32>,

    /// What is displaced otherwise than the file says.
    #[command(flatten)]
    pub surface: SurfaceArgs,

    /// From where.
    #[command(flatten)]
    pub camera: CameraArgs,
}

/// `prism bench`.
#[derive(Clone, Debug, Args)]
pub struct BenchArgs {
    /// Of the picture, in pixels [default: 640x360; 160x90 with --quick]
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub size: Option<Size>,

    /// 99 % of the pixels may be so far off in depth, in pixel footprints: one contest each
    #[arg(long, value_name = "E,E", value_delimiter = ',', value_parser = positive, default_values_t = [0.5, 0.1])]
    pub errors: Vec<f64>,

    /// Frames of each variant that are timed, all variants taking turns [default: 15; 3 with --quick]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub rounds: Option<u32>,

    /// Small and short, for CI: every row, no figure worth quoting [default: off]
    #[arg(long)]
    pub quick: bool,

    /// The table's rows as CSV [default: not written]
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,

    /// Where it is computed.
    #[command(flatten)]
    pub device: DeviceArgs,
}

impl BenchArgs {
    /// The picture's size.
    pub fn pixels(&self) -> [u32; 2] {
        let usual = if self.quick { [160, 90] } else { [640, 360] };
        self.size.map_or(usual, |size| [size.width, size.height])
    }

    /// Timed frames of each variant.
    pub fn rounds(&self) -> u32 {
        self.rounds.unwrap_or(if self.quick { 3 } else { 15 })
    }
}

/// `prism report`.
#[cfg(feature = "report")]
#[derive(Clone, Debug, Args)]
pub struct ReportArgs {
    /// The folder that is filled: index.html with all pictures in it, points.csv, plots as SVG; made where it is missing
    #[arg(long, value_name = "DIR", default_value = "report")]
    pub out: PathBuf,

    /// Whose fronts, the first in every way that there is: torus, suzanne, plane, terrain, cliffs, needles, or glTF files
    /// [default: all six; torus with --quick]
    #[arg(long, value_name = "A,B", value_delimiter = ',')]
    pub scenes: Vec<String>,

    /// Only parts of these names: front, stage, shadow, samples, distance, stiffness, angle, scale, map, triangles,
    /// resolution, moving, contest [default: all]
    #[arg(long, value_name = "A,B", value_delimiter = ',')]
    pub parts: Vec<String>,

    /// Only techniques whose name begins with one of these, as in "walk exact" [default: all]
    #[arg(long, value_name = "A,B", value_delimiter = ',')]
    pub techniques: Vec<String>,

    /// Few points, small pictures: a look in two minutes instead of twenty [default: off]
    #[arg(long)]
    pub quick: bool,

    /// Of the pictures, in pixels [default: 240x135; 160x90 with --quick]
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub size: Option<Size>,

    /// Frames of each variant that are timed, all variants of a part taking turns [default: 5; 3 with --quick]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub rounds: Option<u32>,

    /// Minutes that it may take: where they run short fewer rounds are timed, one at least, and all points are measured
    /// [default: 20; 2 with --quick]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub minutes: Option<u32>,

    /// Where it is computed.
    #[command(flatten)]
    pub device: DeviceArgs,
}

#[cfg(feature = "report")]
impl ReportArgs {
    /// The time that it may take.
    pub fn budget(&self) -> std::time::Duration {
        std::time::Duration::from_secs(60 * u64::from(self.minutes.unwrap_or(if self.quick { 2 } else { 20 })))
    }

    /// The pictures' size.
    pub fn pixels(&self) -> [u32; 2] {
        let usual = if self.quick { [160, 90] } else { [240, 135] };
        self.size.map_or(usual, |size| [size.width, size.height])
    }

    /// Timed frames of each variant.
    pub fn rounds(&self) -> u32 {
        self.rounds.unwrap_or(if self.quick { 3 } else { 5 })
    }
}

/// Options of every command that draws.
#[derive(Clone, Debug, Default, Args)]
pub struct CommonArgs {
    /// How it is drawn.
    #[command(flatten)]
    pub look: LookArgs,
    /// The same, of the classic techniques.
    #[command(flatten)]
    pub classic: ClassicArgs,
    /// What is drawn in a shell's place.
    #[command(flatten)]
    pub baseline: BaselineArgs,
    /// What is drawn otherwise than the file says.
    #[command(flatten)]
    pub surface: SurfaceArgs,
    /// From where.
    #[command(flatten)]
    pub camera: CameraArgs,
    /// On what, and what is written besides the picture.
    #[command(flatten)]
    pub session: SessionArgs,
}

/// How a scene is drawn. An absent flag leaves the choice to the sample and to the other flags.
#[derive(Clone, Debug, Default, Args)]
#[command(next_help_heading = "Technique")]
pub struct LookArgs {
    /// The stage that makes the shell's geometry; auto: mesh where the device has it [default: auto]
    #[arg(long, value_parser = words(Stage::ALL, Stage::name))]
    pub stage: Option<Stage>,

    /// off: the base surface only, classic parallax; auto: walk [default: auto]
    #[arg(long, value_parser = words(Shell::ALL, Shell::name))]
    pub shell: Option<Shell>,

    /// How a ray finds the surface; none, normal and offset trace none, for --shell off only
    /// [default: exact; pom with --shell off]
    #[arg(long, value_parser = words(March::ALL, March::name))]
    pub march: Option<March>,

    /// Fewest linear steps (pom, relief): of a ray straight down (base surface), of a prism (shell), 1 to 4096
    /// [default: 8, or --max-steps where that is less]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub min_steps: Option<u32>,

    /// Most steps (not exact): of a ray at grazing angle (base surface), of a prism (shell), 1 to 4096
    /// [default: 64, or --min-steps where that is more]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub max_steps: Option<u32>,

    /// After the linear search: relief's bisections, secant's most steps, contact's fine steps; in the last
    /// cone: relaxed-cone's bisections; 0 to 64 [default: 8; secant 5]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=64))]
    pub refine_steps: Option<u32>,

    /// What clips the base surface, for --shell off: a shell needs nothing [default: none]
    #[arg(long, value_parser = words(Silhouette::ALL, Silhouette::name))]
    pub silhouette: Option<Silhouette>,

    /// Whether the base surface's hit moves the depth; a shell always writes the hit's depth [default: on]
    #[arg(long, value_name = "on|off", value_parser = on_off(), action = ArgAction::Set)]
    pub depth_offset: Option<bool>,

    /// Whether what the height field hides of the sky dims the ambient light [default: off]
    #[arg(long, value_name = "on|off", value_parser = on_off(), action = ArgAction::Set)]
    pub ambient_occlusion: Option<bool>,

    /// How much of the occlusion, the texture's or that of --ambient-occlusion, dims direct light too, 0 to 1 [default: 0]
    #[arg(long, value_name = "SHARE", value_parser = share)]
    pub occlusion_light: Option<f32>,

    /// Shadows that the detail casts on itself; in a shell exact across triangles. soft: those of round lights
    /// [default: off]
    #[arg(long, value_parser = words(SelfShadow::ALL, SelfShadow::name))]
    pub self_shadow: Option<SelfShadow>,

    /// Radius of every light for soft self-shadow, as the tangent of its angle, 0 to 1; 0 is hard [default: 0.05]
    #[arg(long, value_name = "S", value_parser = share)]
    pub shadow_softness: Option<f32>,

    /// Most linear steps of a ray toward a light: along the whole ray (base surface), in a prism (shell, not exact), 1 to
    /// 4096 [default: as the march's own]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub shadow_steps: Option<u32>,

    /// Whether depth is drawn before colours, so that no hidden pixel is shaded; auto: that of plain surfaces, where there
    /// are several [default: auto]
    #[arg(long, value_parser = words(DepthPrepass::ALL, DepthPrepass::name))]
    pub depth_prepass: Option<DepthPrepass>,

    /// Which prisms are dropped before the stage that makes them: those outside the view, or also those hidden by what is
    /// nearer, their shell's horizon included; auto: where it pays, as `explain` tells [default: auto]
    #[arg(long, value_parser = words(PrismCulling::ALL, PrismCulling::name))]
    pub prism_culling: Option<PrismCulling>,

    /// Whether lights cast shadows through maps of what they see, drawn by the same tracer
    /// [default: off, on where the sample says so]
    #[arg(long, value_name = "on|off", value_parser = on_off(), action = ArgAction::Set)]
    pub shadow_map: Option<bool>,

    /// Texels a side of each shadow map, 16 to 8192 [default: 1024]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(16..=8192))]
    pub shadow_map_size: Option<u32>,

    /// Shadow maps of a directional light, the nearer to the camera the finer, 1 to 6 [default: 3]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=6))]
    pub cascades: Option<u32>,

    /// Samples of a pixel: 4 smooth every outline, a shell's too; surface data keep one [default: 1]
    #[arg(long, value_name = "1|4", value_parser = PossibleValuesParser::new(["1", "4"]).map(|word| if word == "4" { 4u32 } else { 1 }))]
    pub msaa: Option<u32>,

    /// What the picture shows: the shaded surface; the base mesh; the edges of the prisms over the picture; a colour for each
    /// prism; how many prisms the walk visits; how many heights and bounds are read (1 to 256, dark to light); loops that
    /// gave up (red); UV, height, normal, depth (white to black each doubling), the first light's shadow; the depth error
    /// against the reference, 1e-6 to 10 footprints (dark to light) [default: shaded]
    #[arg(long, value_parser = words(View::ALL, View::name))]
    pub view: Option<View>,

    /// Keeps what `prism explain` says is left out, where it could be there: the same picture, for comparison [default: off]
    #[arg(long)]
    pub keep_all: bool,
}

/// What replaces the scene's camera.
#[derive(Clone, Debug, Default, Args)]
#[command(next_help_heading = "Camera")]
pub struct CameraArgs {
    /// The eye, world units; alone, it moves the camera without turning it
    /// [default: the scene's camera, else one that frames the scene]
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true)]
    pub eye: Option<[f64; 3]>,

    /// The point looked at, world units; alone, it turns the camera where it stands
    /// [default: the scene's camera, else one that frames the scene]
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true)]
    pub target: Option<[f64; 3]>,

    /// Vertical field of view, between 0 and 180 degrees [default: the scene's camera]
    #[arg(long, value_name = "DEG", value_parser = field_of_view, allow_hyphen_values = true)]
    pub fov_y: Option<f64>,
}

/// Device, size and what is measured.
#[derive(Clone, Debug, Default, Args)]
#[command(next_help_heading = "Device and output")]
pub struct SessionArgs {
    /// Of the picture, or of the window when it opens, in pixels
    #[arg(long, value_name = "WxH", value_parser = size, default_value = "1280x720")]
    pub size: Size,

    /// A device by its index or a part of its name, as in `prism devices` [default: the best]
    #[arg(long, value_name = "INDEX|NAME")]
    pub gpu: Option<String>,

    /// One turn of the camera around what it looks at, in N frames at 25 a second; the output's name says whether a .gif,
    /// an .apng or (.png) a picture each frame is written [default: none]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=3600))]
    pub turntable: Option<u32>,

    /// The last frame's surface data as 32-bit float OpenEXR [default: not written]
    ///
    /// Channels: R G B (scene-linear), depth.Z (+inf where nothing was hit), position.X/Y/Z, normal.X/Y/Z,
    /// uv.U/V, height.H, shadow.S.
    #[arg(long, value_name = "FRAME.exr")]
    pub aov: Option<PathBuf>,

    /// A row per frame and pass: frame, time, pass, gpu_ms, invocations, primitives [default: not written]
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,

    /// Prints GPU time (min, median, p95), invocations and primitives of each pass, the memory, the pipelines
    /// [default: not printed]
    #[arg(long)]
    pub stats: bool,

    /// The validation layer's checks; a warning or an error fails the run
    #[arg(
        long,
        default_value_t,
        value_parser = words(Validation::ALL, Validation::name),
        long_help = "The validation layer's checks; a warning or an error fails the run. The default is core in \
                     debug builds of prism and off in release builds"
    )]
    pub validation: Validation,

    /// Reads the shaders from this folder [default: those in the program]
    #[arg(long, value_name = "DIR")]
    pub shader_dir: Option<PathBuf>,
}

/// Width and height in pixels, both at least 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

impl Default for Size {
    fn default() -> Self {
        Size { width: 1280, height: 720 }
    }
}

/// A parser of the words that the engine gives its settings, so that they stand once.
pub fn words<T: Copy + Send + Sync + 'static>(
    all: &'static [T],
    name: fn(T) -> &'static str,
) -> impl TypedValueParser<Value = T> {
    PossibleValuesParser::new(all.iter().map(|&value| name(value)))
        .try_map(move |word| all.iter().copied().find(|&value| name(value) == word).ok_or("unknown word"))
}

/// `on` or `off`.
pub fn on_off() -> impl TypedValueParser<Value = bool> {
    PossibleValuesParser::new(["on", "off"]).map(|word| word == "on")
}

fn size(text: &str) -> Result<Size, String> {
    let side = |s: &str| s.parse::<u32>().ok().filter(|&n| n > 0);
    match text.split_once('x').map(|(w, h)| (side(w), side(h))) {
        Some((Some(width), Some(height))) => Ok(Size { width, height }),
        _ => Err("two whole numbers above 0, as in 1280x720".into()),
    }
}

fn pixel(text: &str) -> Result<[u32; 2], String> {
    let numbers: Option<Vec<u32>> = text.split(',').map(|part| part.trim().parse().ok()).collect();
    numbers.and_then(|n| n.try_into().ok()).ok_or_else(|| "column and row, whole numbers from 0, as in 640,360".into())
}

/// The marches that follow a ray.
fn tracing_march() -> impl TypedValueParser<Value = March> {
    let names = March::ALL.iter().filter(|march| march.traces()).map(|march| march.name());
    PossibleValuesParser::new(names)
        .try_map(|word| March::ALL.iter().copied().find(|march| march.name() == word).ok_or("unknown word"))
}

fn number(text: &str) -> Option<f64> {
    text.trim().parse().ok().filter(|n: &f64| n.is_finite())
}

fn positive(text: &str) -> Result<f64, String> {
    number(text).filter(|&n| n > 0.0).ok_or_else(|| "a finite number above 0".into())
}

/// A number between two, both allowed.
pub fn ranged(text: &str, least: f64, most: f64) -> Result<f32, String> {
    let inside = number(text).filter(|n| (least..=most).contains(n));
    inside.map(|n| n as f32).ok_or_else(|| format!("a number from {least} to {most}"))
}

/// Any number.
pub fn unbounded(text: &str) -> Result<f64, String> {
    number(text).ok_or_else(|| "a finite number".into())
}

/// A scale of heights.
pub fn height_scale(text: &str) -> Result<f64, String> {
    number(text).filter(|&n| n >= 0.0).ok_or_else(|| "a finite number, not below 0".into())
}

/// Factors of u and v.
pub fn scale_factors(text: &str) -> Result<[f32; 2], String> {
    two_numbers(text).ok().filter(|n| n.iter().all(|&n| n > 0.0)).ok_or_else(|| "two numbers above 0, as in 2,3".into())
}

/// A part of a whole.
pub fn share(text: &str) -> Result<f32, String> {
    ranged(text, 0.0, 1.0)
}

/// Two numbers, parted by a comma.
pub fn two_numbers(text: &str) -> Result<[f32; 2], String> {
    let numbers: Option<Vec<f32>> = text.split(',').map(|part| number(part).map(|n| n as f32)).collect();
    numbers.and_then(|n| n.try_into().ok()).ok_or_else(|| "two finite numbers, as in 0,1".into())
}

fn point(text: &str) -> Result<[f64; 3], String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(number).collect();
    numbers.and_then(|n| n.try_into().ok()).ok_or_else(|| "three finite numbers, as in -1,2.5,3".into())
}

fn field_of_view(text: &str) -> Result<f64, String> {
    number(text).filter(|&deg| deg > 0.0 && deg < 180.0).ok_or_else(|| "degrees, above 0 and below 180".into())
}

fn seconds(text: &str) -> Result<f64, String> {
    number(text).filter(|&s| s >= 0.0).ok_or_else(|| "seconds, finite and not negative".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(args: &str) -> Result<RunArgs, clap::Error> {
        let words = ["prism", "run", "prism_shell"].into_iter().chain(args.split_whitespace());
        match Cli::try_parse_from(words)?.command {
            Command::Run(run) => Ok(run),
            other => panic!("parsed as {other:?}"),
        }
    }

    #[test]
    fn grammar_is_consistent() {
        use clap::CommandFactory;
        Cli::command().debug_assert();
    }

    #[test]
    fn negative_coordinates_are_values() {
        let args = run("--eye -1,2,-3.5 --target -0,1e-3,+2").unwrap();
        assert_eq!(args.common.camera.eye, Some([-1.0, 2.0, -3.5]));
        assert_eq!(args.common.camera.target, Some([-0.0, 1e-3, 2.0]));
    }

    #[test]
    fn wrong_values_are_usage_errors() {
        for wrong in [
            "--size 0x0",
            "--size 640",
            "--size 640x",
            "--size -1x4",
            "--frames 0",
            "--frames -1",
            "--eye 1,2",
            "--eye nan,0,0",
            "--eye inf,0,0",
            "--fov-y 0",
            "--fov-y 180",
            "--fov-y -10",
            "--fov-y nan",
            "--time-step -0.1",
            "--tilt 89",
            "--tilt -1",
            "--min-steps 0",
            "--max-steps 5000",
            "--march cone-step",
            "--tolerance 2",
            "--horizon-falloff 0.1",
            "--horizon-threshold 1",
            "--uv-min 1",
            "--uv-scale 0,1",
            "--height-scale -1",
            "--midlevel nan",
            "--wrap beyond",
            "--height-lod 16",
            "--height-lod none",
            "--height-format r32",
            "--metallic-channel x",
            "--specular 1.5",
            "--occlusion-light 2",
            "--tangents screen",
            "--lod-fade soon",
            "--normals smooth",
            "--shell cage",
            "--stage task",
            "--depth-offset maybe",
            "--validation gpu",
            "--shadow-map soft",
            "--self-shadow softer",
            "--shadow-softness -0.1",
            "--shadow-softness 1.5",
            "--shadow-steps 0",
            "--shadow-map-size 8",
            "--cascades 0",
            "--msaa 2",
            "--msaa on",
        ] {
            let error = run(wrong).expect_err(wrong);
            assert_eq!(error.exit_code(), 2, "{wrong}");
        }
    }

    #[test]
    fn every_option_tells_its_default() {
        use clap::CommandFactory;
        for command in Cli::command().get_subcommands() {
            for option in command.get_opts() {
                let help = option.get_long_help().or(option.get_help()).map(ToString::to_string).unwrap_or_default();
                // What has to be given has none.
                let told =
                    option.is_required_set() || help.contains("default") || !option.get_default_values().is_empty();
                assert!(told, "prism {} --{}: no default in the help", command.get_name(), option.get_id());
            }
        }
    }
}
