//! The flags of camera, device and output.

use std::path::PathBuf;

use clap::Args;
use prism_engine::settings::Validation;

use super::value::{Size, field_of_view, point, size, words};

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
