//! The flags that give a scene's displaced materials other values than its file.

use clap::{ArgAction, Args};
use prism_engine::scene::{Adjustment, Beyond};

use super::cli::{height_scale, on_off, scale_factors, two_numbers, unbounded, words};

/// An absent flag leaves what the file says.
#[derive(Clone, Debug, Default, Args)]
#[command(next_help_heading = "Displaced materials")]
pub struct SurfaceArgs {
    /// Factors of their textures' UVs, the height map's too, above 0 [default: 1,1]
    #[arg(long, value_name = "U,V", value_parser = scale_factors)]
    pub uv_scale: Option<[f32; 2]>,

    /// Added to these UVs [default: 0,0]
    #[arg(long, value_name = "U,V", value_parser = two_numbers, allow_hyphen_values = true)]
    pub uv_offset: Option<[f32; 2]>,

    /// Turns heights around: 1 - h [default: off]
    #[arg(long, value_name = "on|off", value_parser = on_off(), action = ArgAction::Set)]
    pub height_flip: Option<bool>,

    /// Scale of the heights, at least 0: mesh units, or a factor with --relative on [default: the file's]
    #[arg(long, value_name = "N", value_parser = height_scale)]
    pub height_scale: Option<f64>,

    /// Whether the scale is relative to the texture's size on the surface [default: the file's]
    #[arg(long, value_name = "on|off", value_parser = on_off(), action = ArgAction::Set)]
    pub relative: Option<bool>,

    /// The height that stays on the base surface [default: the file's]
    #[arg(long, value_name = "N", value_parser = unbounded, allow_hyphen_values = true)]
    pub midlevel: Option<f64>,

    /// How their textures go on beyond their edges, the height map too; border: heights are 0 there, other textures
    /// clamped [default: the file's]
    #[arg(long, value_parser = words(Beyond::ALL, Beyond::name))]
    pub wrap: Option<Beyond>,

    /// The mip of their height maps that is read: halvings, by the mean, 0 to 15 [default: 0]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=15))]
    pub height_lod: Option<u32>,
}

impl SurfaceArgs {
    /// What they change.
    pub fn adjustment(&self) -> Adjustment {
        Adjustment {
            uv_scale: self.uv_scale.map(|scale| scale.map(f64::from)),
            uv_offset: self.uv_offset.map(|offset| offset.map(f64::from)),
            height_flip: self.height_flip == Some(true),
            height_scale: self.height_scale,
            relative: self.relative,
            midlevel: self.midlevel,
            wrap: self.wrap,
            height_lod: self.height_lod.unwrap_or(0),
        }
    }
}
