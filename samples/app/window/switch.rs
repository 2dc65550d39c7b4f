//! What a window's keys make of the settings: each the next of those that the others allow.

use prism_engine::settings::{March, SelfShadow, Settings, Shell, Silhouette, Stage};

/// The same settings with the shell switched on or off: the march follows where it must.
pub fn with_shell(settings: &Settings, shell: Shell) -> Settings {
    let mut next = Settings { shell, ..settings.clone() };
    let shelled = next.resolved_shell() != Shell::Off;
    if shelled && !next.march.traces() {
        next.march = March::Exact;
    }
    if shelled {
        // What a shell has by nature: the same words as a command line's defaults.
        (next.silhouette, next.depth_offset) = (Silhouette::None, true);
    }
    next
}

/// The same settings with the next march that its shell and its scene allow.
pub fn with_next_march(settings: &Settings, scene_allows: impl Fn(March) -> bool) -> Settings {
    let shelled = settings.resolved_shell() != Shell::Off;
    let at = March::ALL.iter().position(|&march| march == settings.march).unwrap_or(0);
    let mut after = March::ALL.iter().cycle().skip(at + 1).take(March::ALL.len());
    let march = after.find(|march| (!shelled || march.traces()) && scene_allows(**march));
    let march = march.copied().unwrap_or(settings.march);
    let mut next = Settings { march, refine_steps: march.usual_refine_steps(), ..settings.clone() };
    if !next.march.traces() {
        // Both need a traced ray.
        (next.silhouette, next.self_shadow) = (Silhouette::None, SelfShadow::Off);
    }
    next
}

/// The same settings with the next stage of those that the device has (`auto` is always one).
pub fn with_next_stage(settings: &Settings, device_has: &[Stage]) -> Settings {
    let at = Stage::ALL.iter().position(|&stage| stage == settings.stage).unwrap_or(0);
    let mut after = Stage::ALL.iter().copied().cycle().skip(at + 1).take(Stage::ALL.len());
    let stage = after.find(|stage| *stage == Stage::Auto || device_has.contains(stage)).unwrap_or(settings.stage);
    Settings { stage, ..settings.clone() }
}

/// The same settings with four samples a pixel in place of one, or the other way round.
pub fn with_other_samples(settings: &Settings) -> Settings {
    Settings { msaa: if settings.msaa == 1 { 4 } else { 1 }, ..settings.clone() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_never_reach_a_refused_combination() {
        let mut now = Settings::default();
        for step in 0..64 {
            now = match step % 3 {
                0 => with_shell(&now, if now.resolved_shell() == Shell::Off { Shell::Prism } else { Shell::Off }),
                1 => with_next_march(&now, |march| !march.reads_cones()),
                _ => with_next_stage(&now, &[Stage::Geometry]),
            };
            assert!(now.resolved_shell() == Shell::Off || now.march.traces(), "{now:?}");
            assert_ne!(now.stage, Stage::Mesh, "the device has none");
            assert!(!now.march.reads_cones(), "the scene has no height map");
        }
    }
}
