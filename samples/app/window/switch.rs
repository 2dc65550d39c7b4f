//! What a window's keys make of the settings: each the next of those that the others allow. What a command line would
//! refuse is out of every key's reach: what no longer fits falls back to the default, and a key that fits nothing does
//! nothing.

use prism_engine::render::plan;
use prism_engine::settings::{
    DepthPrepass, March, Normals, PrismCulling, SelfShadow, Settings, Shell, Silhouette, Stage, Tangents, View,
    VisibilityBuffer,
};

/// The same settings with the shell switched on or off: the march follows where it must.
pub fn with_shell(settings: &Settings, shell: Shell) -> Settings {
    let mut next = Settings { shell, ..settings.clone() };
    if shelled(&next) && !next.march.traces() {
        next.march = March::Exact;
    }
    if shelled(&next) {
        // What a shell has by nature: the same words as a command line's defaults.
        next.depth_offset = true;
    }
    fitting(next)
}

/// The same settings with the next march that its shell and its scene allow.
pub fn with_next_march(settings: &Settings, scene_allows: impl Fn(March) -> bool) -> Settings {
    let march =
        after(March::ALL, settings.march, |march| (!shelled(settings) || march.traces()) && scene_allows(march));
    with_march(settings, march)
}

/// The same settings with another march, which its shell allows.
pub fn with_march(settings: &Settings, march: March) -> Settings {
    fitting(Settings { march, refine_steps: march.usual_refine_steps(), ..settings.clone() })
}

/// The same settings with the next stage of those that the device has (`auto` is always one).
pub fn with_next_stage(settings: &Settings, device_has: &[Stage]) -> Settings {
    let stage = after(Stage::ALL, settings.stage, |stage| stage == Stage::Auto || device_has.contains(&stage));
    Settings { stage, ..settings.clone() }
}

/// The same settings with the next clipping of the base surface.
pub fn with_next_silhouette(settings: &Settings) -> Settings {
    fitting(Settings { silhouette: after(Silhouette::ALL, settings.silhouette, |_| true), ..settings.clone() })
}

/// The same settings with the next shading normals of the base surface.
pub fn with_next_normals(settings: &Settings) -> Settings {
    fitting(Settings { normals: after(Normals::ALL, settings.normals, |_| true), ..settings.clone() })
}

/// The same settings with the next self-shadowing; cones in a shell know no soft one.
pub fn with_next_self_shadow(settings: &Settings) -> Settings {
    let cones = shelled(settings) && settings.march.reads_cones();
    let allowed = |shadow| shadow != SelfShadow::Soft || !cones;
    fitting(Settings { self_shadow: after(SelfShadow::ALL, settings.self_shadow, allowed), ..settings.clone() })
}

/// The same settings with dithered starts on or off.
pub fn with_dither(settings: &Settings, dither: bool) -> Settings {
    fitting(Settings { dither, ..settings.clone() })
}

/// The same settings with shadow maps on or off; heights that fade have none.
pub fn with_shadow_map(settings: &Settings, shadow_map: bool) -> Settings {
    Settings { shadow_map: shadow_map && settings.lod_fade.is_none(), ..settings.clone() }
}

/// The same settings with ambient occlusion on or off.
pub fn with_ambient_occlusion(settings: &Settings, ambient_occlusion: bool) -> Settings {
    fitting(Settings { ambient_occlusion, ..settings.clone() })
}

/// The same settings with the next view that they have something to show in.
pub fn with_next_view(settings: &Settings) -> Settings {
    with_view(settings, after(View::ALL, settings.view, |view| with_view(settings, view).view == view))
}

/// The same settings with this view, if they have something to show in it.
pub fn with_view(settings: &Settings, view: View) -> Settings {
    fitting(Settings { view, ..settings.clone() })
}

/// The first value after `now`, in the command line's order and around its end, that `allowed` lets through.
fn after<T: Copy + PartialEq>(all: &[T], now: T, allowed: impl Fn(T) -> bool) -> T {
    let at = all.iter().position(|&value| value == now).unwrap_or(0);
    all.iter().copied().cycle().skip(at + 1).take(all.len()).find(|&value| allowed(value)).unwrap_or(now)
}

fn shelled(settings: &Settings) -> bool {
    settings.resolved_shell() != Shell::Off
}

/// With the defaults in place of what shell and march cannot honour.
pub fn fitting(mut settings: Settings) -> Settings {
    let march = settings.march;
    if shelled(&settings) || !march.traces() {
        settings.silhouette = Silhouette::None;
    }
    if !march.traces() {
        settings.self_shadow = SelfShadow::Off;
    }
    if shelled(&settings) && march.reads_cones() && settings.self_shadow == SelfShadow::Soft {
        settings.self_shadow = SelfShadow::Hard;
    }
    if shelled(&settings) || march == March::None {
        settings.normals = Normals::Gather;
        settings.tangents = Tangents::Auto;
    }
    if march == March::None {
        settings.lod_fade = None;
    }
    if !shelled(&settings) || settings.msaa > 1 || settings.depth_prepass == DepthPrepass::On {
        settings.prism_culling = PrismCulling::Auto;
    }
    if !plan::may_name_lids(&settings) {
        settings.visibility_buffer = VisibilityBuffer::Auto;
    }
    settings.pixel_lod &= !shelled(&settings) && march.reads_lods();
    settings.dither &= march.steps();
    settings.ambient_occlusion &= march != March::None;
    if !settings.shows_view() {
        settings.view = View::Shaded;
    }
    settings
}

/// The same settings with four samples a pixel in place of one, or the other way round.
pub fn with_other_samples(settings: &Settings) -> Settings {
    Settings { msaa: if settings.msaa == 1 { 4 } else { 1 }, ..settings.clone() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::{
        choices,
        cli::{Cli, Command},
    };
    use clap::Parser;

    /// What the command line says to the same settings.
    fn refusal(settings: &Settings) -> Option<String> {
        let on_off = |on: bool| if on { "on" } else { "off" };
        let mut words = format!(
            "prism render scene.gltf --shell {} --march {} --silhouette {} --normals {} --self-shadow {} --dither {} \
             --shadow-map {} --ambient-occlusion {} --view {}",
            settings.shell,
            settings.march,
            settings.silhouette,
            settings.normals,
            settings.self_shadow,
            on_off(settings.dither),
            on_off(settings.shadow_map),
            on_off(settings.ambient_occlusion),
            settings.view
        );
        if settings.stage != Stage::Auto && shelled(settings) {
            words += &format!(" --stage {}", settings.stage);
        }
        let Ok(Cli { command: Command::Render(args) }) = Cli::try_parse_from(words.split_whitespace()) else {
            return Some(format!("{words}: not understood"));
        };
        choices::settings(&args.common.look, &args.common.classic, &Settings::default()).err().map(|e| e.to_string())
    }

    #[test]
    fn keys_never_reach_a_refused_combination() {
        let press = |now: &Settings, key: usize| match key {
            0 => with_shell(now, if shelled(now) { Shell::Off } else { Shell::Prism }),
            1 => with_next_march(now, |march| !march.reads_cones()),
            2 => with_next_stage(now, &[Stage::Geometry]),
            3 => with_next_silhouette(now),
            4 => with_next_normals(now),
            5 => with_next_self_shadow(now),
            6 => with_dither(now, !now.dither),
            7 => with_shadow_map(now, !now.shadow_map),
            _ => with_ambient_occlusion(now, !now.ambient_occlusion),
        };
        // Everything that any keys can reach, one after the other.
        let mut reached = vec![Settings::default()];
        let mut at = 0;
        while let Some(now) = reached.get(at).cloned() {
            assert_eq!(refusal(&now), None, "{now:?}");
            assert_ne!(now.stage, Stage::Mesh, "the device has none");
            assert!(!now.march.reads_cones(), "the scene has no height map");
            for key in 0..9 {
                // Its number of steps is nothing that can be refused.
                let next = Settings { refine_steps: now.refine_steps, ..press(&now, key) };
                if !reached.contains(&next) {
                    reached.push(next);
                }
            }
            at += 1;
        }
        for reached_by_some in [
            |s: &Settings| s.silhouette == Silhouette::Horizon,
            |s: &Settings| s.normals == Normals::Sobel,
            |s: &Settings| shelled(s) && s.self_shadow == SelfShadow::Hard,
            |s: &Settings| shelled(s) && s.self_shadow == SelfShadow::Soft,
            |s: &Settings| shelled(s) && s.dither,
            |s: &Settings| s.ambient_occlusion && s.march == March::Normal,
            |s: &Settings| s.march == March::None && s.shadow_map,
        ] {
            assert!(reached.iter().any(reached_by_some));
        }
        let fading = Settings { shell: Shell::Off, lod_fade: Some(2.0), ..Settings::default() };
        assert!(!with_shadow_map(&fading, true).shadow_map);
    }
}
