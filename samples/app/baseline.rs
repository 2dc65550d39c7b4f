//! The flag that draws what a user would take in place of a shell, and what it leaves no room for.

use clap::Args;
use prism_engine::{
    error::{Error, Result},
    render::baseline::MAX_DENSITY,
    settings::{Baseline, Culling, DepthPrepass, Dicer, SelfShadow, Settings, Silhouette, Stage},
};

use super::cli::{CommonArgs, ranged};

/// In place of the shell.
#[derive(Clone, Debug, Default, Args)]
#[command(next_help_heading = "Technique")]
pub struct BaselineArgs {
    /// What a shell is compared with, drawn in its place: a mesh of N² triangles for each of the base's, N from 1 to 256;
    /// or triangles with edges of PX pixels, 0.1 to 256, made for each frame by hardware tessellation or mesh shaders.
    /// Without shadows, one sample a pixel [default: off]
    #[arg(long, value_name = "off|micro-mesh:N|tessellation:PX|mesh-tessellation:PX", value_parser = baseline)]
    pub baseline: Option<Choice>,
}

/// A value of the flag; none is `off`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Choice(Option<Baseline>);

fn baseline(text: &str) -> std::result::Result<Choice, String> {
    let (word, value) = text.split_once(':').map_or((text, None), |(word, value)| (word, Some(value)));
    match (word, value) {
        ("off", None) => return Ok(Choice(None)),
        ("micro-mesh", Some(value)) => {
            let density = value.parse().ok().filter(|n| (1..=MAX_DENSITY).contains(n));
            let density =
                density.ok_or_else(|| format!("micro-mesh:N wants a whole number from 1 to {MAX_DENSITY}"))?;
            return Ok(Choice(Some(Baseline::MicroMesh { density, culling: Culling::Clusters })));
        }
        _ => {}
    }
    let dicer = Dicer::ALL.iter().copied().find(|by| by.name() == word).zip(value);
    let (by, value) =
        dicer.ok_or("off, micro-mesh:N, tessellation:PX or mesh-tessellation:PX, as in tessellation:2")?;
    let edge = ranged(value, 0.1, 256.0).map_err(|wanted| format!("{word}:PX wants {wanted}, of pixels"))?;
    Ok(Choice(Some(Baseline::Diced { by, edge, culls: true })))
}

impl BaselineArgs {
    /// Whether one is asked for.
    pub fn is_on(&self) -> bool {
        self.baseline.is_some_and(|Choice(baseline)| baseline.is_some())
    }
}

impl CommonArgs {
    /// Puts the baseline into `settings`, and takes out what the sample wants and no baseline has.
    pub fn apply_baseline(&self, settings: Settings) -> Result<Settings> {
        let Some(Choice(Some(baseline))) = self.baseline.baseline else { return Ok(settings) };
        let look = &self.look;
        let flags = [
            ("--stage", look.stage.is_some_and(|stage| stage != Stage::Auto)),
            ("--shell", look.shell.is_some()),
            ("--march", look.march.is_some()),
            ("--min-steps", look.steps.min_steps.is_some()),
            ("--max-steps", look.steps.max_steps.is_some()),
            ("--refine-steps", look.steps.refine_steps.is_some()),
            ("--tolerance", look.steps.tolerance.is_some()),
            ("--silhouette", look.silhouette.is_some_and(|silhouette| silhouette != Silhouette::None)),
            ("--ambient-occlusion on", look.ambient_occlusion == Some(true)),
            ("--self-shadow", look.self_shadow.is_some_and(|shadow| shadow != SelfShadow::Off)),
            ("--depth-prepass on", look.depth_prepass == Some(DepthPrepass::On)),
            ("--shadow-map on", look.shadow_map == Some(true)),
            ("--msaa 4", look.msaa == Some(4)),
        ];
        let given = flags.into_iter().find(|(_, given)| *given).map(|(flag, _)| flag);
        if let Some(flag) = given.or_else(|| self.classic.given()) {
            return Err(Error::Usage(format!(
                "{flag}: a baseline is triangles, lit without shadows, one sample a pixel; drop the flag, or --baseline"
            )));
        }
        Ok(Settings {
            baseline: Some(baseline),
            ambient_occlusion: false,
            self_shadow: SelfShadow::Off,
            shadow_map: false,
            msaa: 1,
            ..settings
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::cli::{Cli, Command};
    use clap::Parser;

    fn resolve(flags: &str) -> std::result::Result<Settings, String> {
        let words = ["prism", "render", "scene.gltf"].into_iter().chain(flags.split_whitespace());
        match Cli::try_parse_from(words).map_err(|error| error.to_string())?.command {
            Command::Render(args) => args.common.apply_baseline(Settings::default()).map_err(|error| error.to_string()),
            other => panic!("parsed as {other:?}"),
        }
    }

    #[test]
    fn every_baseline_has_a_word() {
        let chosen = |text: &str| resolve(&format!("--baseline {text}")).expect(text).baseline;
        assert_eq!(chosen("off"), None);
        let clusters = Culling::Clusters;
        assert_eq!(chosen("micro-mesh:16"), Some(Baseline::MicroMesh { density: 16, culling: clusters }));
        for by in Dicer::ALL.iter().copied() {
            assert_eq!(chosen(&format!("{by}:0.5")), Some(Baseline::Diced { by, edge: 0.5, culls: true }));
        }
    }

    #[test]
    fn a_wrong_baseline_and_what_it_cannot_honour_are_refused() {
        for wrong in ["on", "micro-mesh", "micro-mesh:0", "micro-mesh:257", "tessellation", "tessellation:0", "off:1"] {
            let error = resolve(&format!("--baseline {wrong}")).expect_err(wrong);
            assert!(error.contains("micro-mesh") || error.contains("tessellation:PX"), "{wrong}: {error}");
        }
        for flag in ["--shell walk", "--march exact", "--self-shadow hard", "--msaa 4", "--dither on", "--stage mesh"] {
            let error = resolve(&format!("--baseline tessellation:2 {flag}")).expect_err(flag);
            assert!(error.contains(flag.split(' ').next().expect("a word")), "{flag}: {error}");
        }
        for flags in ["--shell off", "--baseline off --self-shadow hard", "--baseline micro-mesh:4 --shadow-map off"] {
            resolve(flags).expect(flags);
        }
    }
}
