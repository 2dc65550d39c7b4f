//! The flags that give a scene's displaced materials other values than its file.

use std::fmt;

use clap::{ArgAction, Args};
use prism_engine::{
    error::{self, Error},
    scene::{Adjustment, Beyond, Channel, HeightFormat},
    settings::{Settings, Shell},
};

use super::cli::{height_scale, on_off, scale_factors, share, two_numbers, unbounded, words};
use super::light::LightArgs;

/// An absent flag leaves what the file says.
#[derive(Clone, Debug, Default, PartialEq, Args)]
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

    /// The mip of their height maps that is read: halvings, by the mean, 0 to 15; auto, of base surfaces by a march with
    /// steps, normal or offset: in each pixel that of its footprint, the same all along its ray [default: 0]
    #[arg(long, value_name = "N|auto", value_parser = height_lod)]
    pub height_lod: Option<HeightLod>,

    /// The texels that height maps are kept in: the file's 8 or 16 bits, 8, 16, or half floats, whose 11 significant bits
    /// are off by 1/4096 at most [default: auto]
    #[arg(long, value_parser = words(HeightFormat::ALL, HeightFormat::name))]
    pub height_format: Option<HeightFormat>,

    /// The channel of roughness in their metallic-roughness texture [default: g, glTF's]
    #[arg(long, value_parser = words(Channel::ALL, Channel::name))]
    pub roughness_channel: Option<Channel>,

    /// The channel of metallic in it [default: b, glTF's]
    #[arg(long, value_parser = words(Channel::ALL, Channel::name))]
    pub metallic_channel: Option<Channel>,

    /// How much of the reflection of what is no metal there is, 0 to 1: at 1, 4 % at normal incidence
    /// (KHR_materials_specular) [default: the file's, 1]
    #[arg(long, value_name = "N", value_parser = share)]
    pub specular: Option<f32>,

    /// The lights.
    #[command(flatten)]
    pub light: LightArgs,
}

/// The LOD of height maps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HeightLod {
    /// Of each pixel.
    Auto,
    /// Halvings.
    Mip(u32),
}

impl fmt::Display for HeightLod {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            HeightLod::Auto => f.write_str("auto"),
            HeightLod::Mip(mip) => write!(f, "{mip}"),
        }
    }
}

fn height_lod(text: &str) -> Result<HeightLod, String> {
    match text {
        "auto" => Ok(HeightLod::Auto),
        _ => text
            .parse()
            .ok()
            .filter(|mip| *mip <= 15)
            .map(HeightLod::Mip)
            .ok_or_else(|| "auto, or a whole number from 0 to 15".into()),
    }
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
            height_lod: match self.height_lod {
                Some(HeightLod::Mip(mip)) => mip,
                Some(HeightLod::Auto) | None => 0,
            },
            height_format: self.height_format.unwrap_or_default(),
            roughness_channel: self.roughness_channel,
            metallic_channel: self.metallic_channel,
            specular: self.specular,
        }
    }

    /// Refuses what the shell and march of `settings` cannot honour, and puts the rest in them.
    pub fn apply(&self, settings: &mut Settings) -> error::Result<()> {
        let per_pixel = self.height_lod == Some(HeightLod::Auto);
        if per_pixel && (settings.resolved_shell() != Shell::Off || !settings.march.reads_lods()) {
            return Err(Error::Usage(format!(
                "--height-lod auto: a shell's surface has one LOD, and march {} reads the map itself; add --shell off and \
                 --march pom, relief or another with steps",
                settings.march
            )));
        }
        settings.pixel_lod = per_pixel || (self.height_lod.is_none() && settings.pixel_lod);
        Ok(())
    }
}
