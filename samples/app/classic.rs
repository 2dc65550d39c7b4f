//! The flags of the classic techniques beyond march and steps, and what they make of the settings.

use clap::{ArgAction, Args};
use prism_engine::{
    error::{Error, Result},
    settings::{Horizon, March, Normals, Settings, Shell, Silhouette, Tangents},
};

use super::cli::{on_off, ranged, two_numbers, words};

/// An absent flag leaves the choice to the sample.
#[derive(Clone, Debug, Default, Args)]
#[command(next_help_heading = "Classic techniques")]
pub struct ClassicArgs {
    /// A march with steps begins at a random part of its first one, blue noise: grain in place of layers [default: off]
    #[arg(long, value_name = "on|off", value_parser = on_off(), action = ArgAction::Set)]
    pub dither: Option<bool>,

    /// Farthest that a ray runs along a base surface for each unit of depth, above 0 [default: 1000]
    #[arg(long, value_name = "N", value_parser = |s: &str| ranged(s, 1e-3, 1e6))]
    pub slope_limit: Option<f32>,

    /// Shading normals from the height map, for --shell off: one gather (the surface's own slope), four heights, or
    /// eight [default: gather]
    #[arg(long, value_parser = words(Normals::ALL, Normals::name))]
    pub normals: Option<Normals>,

    /// What tells how texels lie on a base surface, for --shell off: the file's tangents where they follow the height map,
    /// else derivatives (auto); the mesh's, by MikkTSpace where the file has none; or derivatives [default: auto]
    #[arg(long, value_parser = words(Tangents::ALL, Tangents::name))]
    pub tangents: Option<Tangents>,

    /// The LOD at which heights begin to fade, -16 to 16; one further the surface is plain. On a base surface that of the
    /// height map in a pixel; of a shell that of its thickness: -1 fades it while it shrinks from two pixels to one.
    /// Without shadow maps; never in --aov [default: nowhere]
    #[arg(long, value_name = "START", value_parser = |s: &str| ranged(s, -16.0, 16.0), allow_hyphen_values = true)]
    pub lod_fade: Option<f32>,

    /// Horizon clipping: how much is cut where the surface is edge-on, 0 to 4 [default: 1]
    #[arg(long, value_name = "N", value_parser = |s: &str| ranged(s, 0.0, 4.0))]
    pub horizon_strength: Option<f32>,

    /// Horizon clipping: taken off the height before it is compared, 0 to 1 [default: 0]
    #[arg(long, value_name = "N", value_parser = |s: &str| ranged(s, 0.0, 1.0))]
    pub horizon_bias: Option<f32>,

    /// Horizon clipping: nothing is cut where normal and view have a greater cosine, 0 to 0.95 [default: 0.5]
    #[arg(long, value_name = "COS", value_parser = |s: &str| ranged(s, 0.0, 0.95))]
    pub horizon_threshold: Option<f32>,

    /// Horizon clipping: power of the cut's rise toward the edge, 0.5 to 8 [default: 2]
    #[arg(long, value_name = "N", value_parser = |s: &str| ranged(s, 0.5, 8.0))]
    pub horizon_falloff: Option<f32>,

    /// UV bounds: least displaced UV that is kept [default: the primitive's own]
    #[arg(long, value_name = "U,V", value_parser = two_numbers, allow_hyphen_values = true)]
    pub uv_min: Option<[f32; 2]>,

    /// UV bounds: greatest displaced UV that is kept [default: the primitive's own]
    #[arg(long, value_name = "U,V", value_parser = two_numbers, allow_hyphen_values = true)]
    pub uv_max: Option<[f32; 2]>,
}

impl ClassicArgs {
    /// The first of these flags that was typed and would change anything.
    pub fn given(&self) -> Option<&'static str> {
        let flags = [
            ("--dither on", self.dither == Some(true)),
            ("--slope-limit", self.slope_limit.is_some()),
            ("--normals", self.normals.is_some_and(|normals| normals != Normals::Gather)),
            ("--tangents", self.tangents.is_some_and(|tangents| tangents != Tangents::Auto)),
            ("--lod-fade", self.lod_fade.is_some()),
            ("--horizon-strength", self.horizon_strength.is_some()),
            ("--horizon-bias", self.horizon_bias.is_some()),
            ("--horizon-threshold", self.horizon_threshold.is_some()),
            ("--horizon-falloff", self.horizon_falloff.is_some()),
            ("--uv-min", self.uv_min.is_some()),
            ("--uv-max", self.uv_max.is_some()),
        ];
        flags.into_iter().find(|(_, given)| *given).map(|(flag, _)| flag)
    }

    /// Refuses what the shell, march and silhouette of `settings` cannot honour, and puts the rest in them.
    pub fn apply(&self, settings: &mut Settings) -> Result<()> {
        let march = settings.march;
        let shelled = settings.resolved_shell() != Shell::Off;
        if self.dither == Some(true) && !march.steps() {
            return usage(format!("--dither on: march {march} takes no steps; use --march relief, pom or steep"));
        }
        if self.slope_limit.is_some() && (shelled || !march.moves()) {
            return usage(
                "--slope-limit limits the rays of a base surface; add --shell off and a march that has some".into(),
            );
        }
        if let Some(normals) = self.normals.filter(|&normals| normals != Normals::Gather)
            && (shelled || march == March::None)
        {
            return usage(format!(
                "--normals {normals}: a shell has its surface's own normals, and march none has no others; add --shell off \
                 and another march"
            ));
        }
        if let Some(tangents) = self.tangents.filter(|&tangents| tangents != Tangents::Auto)
            && (shelled || march == March::None)
        {
            return usage(format!(
                "--tangents {tangents}: a shell needs no frames, nor does march none; add --shell off and another march"
            ));
        }
        if self.lod_fade.is_some() {
            if march == March::None {
                return usage("--lod-fade: march none reads no heights that could fade; use another march".into());
            }
            if settings.shadow_map {
                return usage("--lod-fade: a shadow map sees a surface at another LOD; add --shadow-map off".into());
            }
        }
        let horizon = [
            ("--horizon-strength", self.horizon_strength.is_some()),
            ("--horizon-bias", self.horizon_bias.is_some()),
            ("--horizon-threshold", self.horizon_threshold.is_some()),
            ("--horizon-falloff", self.horizon_falloff.is_some()),
        ];
        let bounds = [("--uv-min", self.uv_min.is_some()), ("--uv-max", self.uv_max.is_some())];
        for (silhouette, flags) in [(Silhouette::Horizon, &horizon[..]), (Silhouette::UvBounds, &bounds[..])] {
            if let Some((flag, _)) = flags.iter().find(|(_, given)| *given && settings.silhouette != silhouette) {
                return usage(format!("{flag} is one of --silhouette {silhouette}; add that"));
            }
        }
        if let (Some(min), Some(max)) = (self.uv_min, self.uv_max)
            && (min[0] > max[0] || min[1] > max[1])
        {
            return usage(format!(
                "--uv-min {},{} exceeds --uv-max {},{}; exchange them",
                min[0], min[1], max[0], max[1]
            ));
        }
        settings.dither = self.dither.unwrap_or(settings.dither);
        settings.slope_limit = self.slope_limit.unwrap_or(settings.slope_limit);
        settings.normals = self.normals.unwrap_or(settings.normals);
        settings.tangents = self.tangents.unwrap_or(settings.tangents);
        settings.lod_fade = self.lod_fade.or(settings.lod_fade);
        let base = settings.horizon;
        settings.horizon = Horizon {
            strength: self.horizon_strength.unwrap_or(base.strength),
            bias: self.horizon_bias.unwrap_or(base.bias),
            safe_threshold: self.horizon_threshold.unwrap_or(base.safe_threshold),
            falloff: self.horizon_falloff.unwrap_or(base.falloff),
        };
        settings.uv_min = self.uv_min.or(settings.uv_min);
        settings.uv_max = self.uv_max.or(settings.uv_max);
        Ok(())
    }
}

fn usage<T>(message: String) -> Result<T> {
    Err(Error::Usage(message))
}
