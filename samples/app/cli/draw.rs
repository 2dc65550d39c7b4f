//! The commands that draw a scene, or tell how it would be drawn.

use std::path::PathBuf;

use clap::Args;

use super::{
    look::LookArgs,
    session::{CameraArgs, SessionArgs},
    value::{Size, ranged, seconds, size},
};
use crate::app::{baseline::BaselineArgs, classic::ClassicArgs, surface::SurfaceArgs};

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
    /// [default: 1/60 headless, 1/25 in a sequence, the clock's in a window]
    #[arg(long, value_name = "S", value_parser = seconds, allow_hyphen_values = true)]
    pub time_step: Option<f64>,

    /// The picture, an sRGB PNG [default: SAMPLE.png in the current folder; none if only --aov is given]
    #[arg(long, value_name = "FRAME.png")]
    pub out: Option<PathBuf>,

    /// Every frame of --frames, without a window: a picture each (.png: NAME-000.png and so on), or one .gif or .apng at 25 a
    /// second [default: not written]
    #[arg(long, value_name = "FRAMES.png")]
    pub sequence: Option<PathBuf>,

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
