//! The commands beside drawing: baking, probing, measuring.

use std::path::PathBuf;

use clap::Args;
use prism_engine::{
    scene::Wrap,
    settings::{March, Validation},
};

use super::{
    look::StepArgs,
    session::CameraArgs,
    value::{Size, pixel, positive, size, tracing_march, words},
};
use crate::app::surface::SurfaceArgs;

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

    /// How finely.
    #[command(flatten)]
    pub steps: StepArgs,

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
    /// resolution, moving, contest (at equal error, with the fronts of our shells) [default: all]
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
