//! From flags to settings: defaults that depend on one another, and combinations that cannot be honoured.
//!
//! A flag that would change nothing is refused rather than ignored: whoever typed it expects to see something.

use prism_engine::{
    error::{Error, Result},
    settings::{March, SelfShadow, Settings, Shell, Silhouette, Stage, View},
};

use super::{
    classic::ClassicArgs,
    cli::{LookArgs, StepArgs},
};

/// The settings that `args` ask for, starting from those of the sample.
pub fn settings(args: &LookArgs, classic: &ClassicArgs, base: &Settings) -> Result<Settings> {
    let shell = args.shell.unwrap_or(base.shell);
    let mut settings = Settings { shell, ..base.clone() };
    let shelled = settings.resolved_shell() != Shell::Off;
    settings.march = args.march.unwrap_or_else(|| march_for(shelled, base));
    if shelled {
        refuse_base_surface_flags(args)?;
    } else {
        refuse_flags_without_shell(args, settings.march)?;
        settings.silhouette = args.silhouette.unwrap_or(base.silhouette);
        settings.depth_offset = args.depth_offset.unwrap_or(base.depth_offset);
    }
    settings.keep_all = args.keep_all || base.keep_all;
    settings.depth_prepass = args.depth_prepass.unwrap_or(base.depth_prepass);
    settings.visibility_buffer = args.visibility_buffer.unwrap_or(base.visibility_buffer);
    settings.prism_culling = args.prism_culling.unwrap_or(base.prism_culling);
    settings.msaa = args.msaa.unwrap_or(base.msaa);
    settings.shadow_map = args.shadow_map.unwrap_or(base.shadow_map);
    if !settings.shadow_map && (args.shadow_map_size.is_some() || args.cascades.is_some()) {
        return usage("--shadow-map-size, --cascades: no shadow map is drawn; add --shadow-map on".into());
    }
    settings.shadow_map_size = args.shadow_map_size.unwrap_or(base.shadow_map_size);
    settings.cascades = args.cascades.unwrap_or(base.cascades);
    if args.steps.refine_steps.is_some() && !settings.march.refines() {
        return usage(format!(
            "--refine-steps: march {} does not refine; use --march relief, secant, contact or relaxed-cone",
            settings.march
        ));
    }
    self_shadow_flags(args, shelled, &mut settings)?;
    // The exact march needs none; its shadow rays on a base surface do, where they have none of their own.
    let shadows = settings.self_shadow != SelfShadow::Off && settings.shadow_steps.is_none();
    let takes_steps = settings.march != March::Exact || (!shelled && shadows);
    if !takes_steps && (args.steps.min_steps.is_some() || args.steps.max_steps.is_some()) {
        return usage("--min-steps, --max-steps: march exact takes no steps; use --march relief or pom".into());
    }
    if settings.march == March::None && args.ambient_occlusion == Some(true) {
        return usage("--ambient-occlusion on: march none reads no heights; use another march".into());
    }
    settings.ambient_occlusion = args.ambient_occlusion.unwrap_or(base.ambient_occlusion);
    settings.occlusion_light = args.occlusion_light.unwrap_or(base.occlusion_light);
    // Their number of steps is the heights' to decide, up to the most.
    if settings.march.reads_cones() && settings.self_shadow == SelfShadow::Off && args.steps.min_steps.is_some() {
        return usage(format!("--min-steps: march {} takes no more steps than it needs; drop it", settings.march));
    }
    if args.steps.tolerance.is_some() && settings.march != March::Secant {
        return usage(format!("--tolerance: march {} has none; use --march secant", settings.march));
    }
    settings.tolerance = args.steps.tolerance.unwrap_or(base.tolerance);
    settings.stage = args.stage.unwrap_or(base.stage);
    let same = settings.march == base.march;
    let usual = if same { base.refine_steps } else { settings.march.usual_refine_steps() };
    settings.refine_steps = args.steps.refine_steps.unwrap_or(usual);
    (settings.min_steps, settings.max_steps) = steps(&args.steps, base)?;
    classic.apply(&mut settings)?;
    settings.view = args.view.unwrap_or(base.view);
    check_view(&settings)?;
    Ok(settings)
}

/// Refuses a view of what the other settings leave out.
pub fn check_view(settings: &Settings) -> Result<()> {
    let Settings { view, shell, march, .. } = settings;
    if settings.shows_view() {
        return Ok(());
    }
    if settings.baseline.is_some() {
        return usage(format!("--view {view}: a baseline has neither prisms nor rays; use another view"));
    }
    match view {
        View::Walk => usage(format!("--view walk: --shell {shell} walks nowhere; use --shell walk")),
        View::Gathers => usage(format!("--view gathers: march {march} reads no heights; use another march")),
        View::Limits => usage(format!("--view limits: march {march} traces no ray; use --march exact, cone or relief")),
        _ => usage(format!("--view {view}: --shell {shell} has no prisms; use --shell walk or prism")),
    }
}

/// DESIGN section 3: the sample's march in a shell, `pom` without one unless the sample itself has no shell.
fn march_for(shelled: bool, base: &Settings) -> March {
    let base_shelled = base.resolved_shell() != Shell::Off;
    match (shelled, base_shelled) {
        (true, true) | (false, false) => base.march,
        (true, false) => March::Exact,
        (false, true) => March::Pom,
    }
}

/// What only a base surface can honour.
fn refuse_base_surface_flags(args: &LookArgs) -> Result<()> {
    if let Some(march) = args.march.filter(|march| !march.traces()) {
        return usage(format!(
            "--march {march} traces no ray, and a shell needs one; use --march exact, cone, relief or pom, or add --shell off"
        ));
    }
    if let Some(silhouette) = args.silhouette.filter(|&silhouette| silhouette != Silhouette::None) {
        return usage(format!(
            "--silhouette {silhouette} clips a base surface, and a shell has its own silhouette; add --shell off"
        ));
    }
    if args.depth_offset == Some(false) {
        return usage("--depth-offset off: a shell always writes the hit's depth; add --shell off".into());
    }
    Ok(())
}

/// What `--shell off`, or its march, cannot honour.
fn refuse_flags_without_shell(args: &LookArgs, march: March) -> Result<()> {
    if let Some(stage) = args.stage.filter(|&stage| stage != Stage::Auto) {
        return usage(format!("--stage {stage} makes a shell's geometry, and --shell off has none; drop one of them"));
    }
    if march.traces() {
        return Ok(());
    }
    let untraced = [
        ("--min-steps", args.steps.min_steps.is_some()),
        ("--max-steps", args.steps.max_steps.is_some()),
        ("--depth-offset on", args.depth_offset == Some(true)),
        ("--silhouette uv-bounds", args.silhouette == Some(Silhouette::UvBounds)),
        ("--silhouette horizon", args.silhouette == Some(Silhouette::Horizon)),
        ("--self-shadow hard", args.self_shadow == Some(SelfShadow::Hard)),
        ("--self-shadow soft", args.self_shadow == Some(SelfShadow::Soft)),
    ];
    match untraced.iter().find(|(_, given)| *given) {
        Some((flag, _)) => usage(format!("{flag}: march {march} traces no ray; use --march pom, relief or exact")),
        None => Ok(()),
    }
}

/// Self-shadow and what belongs to it.
fn self_shadow_flags(args: &LookArgs, shelled: bool, settings: &mut Settings) -> Result<()> {
    let march = settings.march;
    settings.self_shadow = args.self_shadow.unwrap_or(settings.self_shadow);
    if settings.self_shadow == SelfShadow::Soft && shelled && march.reads_cones() {
        return usage(format!(
            "--self-shadow soft: march {march} leaps over the clearances that tell how much of a light is seen; use \
             --march exact or relief, or --self-shadow hard"
        ));
    }
    if args.shadow_softness.is_some() && settings.self_shadow != SelfShadow::Soft {
        return usage("--shadow-softness: no self-shadow is soft; add --self-shadow soft".into());
    }
    if args.shadow_steps.is_some() {
        if settings.self_shadow == SelfShadow::Off {
            return usage("--shadow-steps: nothing shadows itself; add --self-shadow hard or soft".into());
        }
        if shelled && !march.steps() {
            return usage(format!(
                "--shadow-steps: march {march} takes no linear steps in a shell; use --march relief or pom"
            ));
        }
    }
    settings.shadow_softness = args.shadow_softness.unwrap_or(settings.shadow_softness);
    settings.shadow_steps = args.shadow_steps.or(settings.shadow_steps);
    Ok(())
}

/// Fewest and most steps. A bound that was not given makes room for the one that was.
fn steps(args: &StepArgs, base: &Settings) -> Result<(u32, u32)> {
    match (args.min_steps, args.max_steps) {
        (Some(min), Some(max)) if min > max => {
            usage(format!("--min-steps {min} is more than --max-steps {max}; lower the one or raise the other"))
        }
        (Some(min), Some(max)) => Ok((min, max)),
        (Some(min), None) => Ok((min, base.max_steps.max(min))),
        (None, Some(max)) => Ok((base.min_steps.min(max), max)),
        (None, None) => Ok((base.min_steps, base.max_steps)),
    }
}

fn usage<T>(message: String) -> Result<T> {
    Err(Error::Usage(message))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::cli::{Cli, Command};
    use clap::Parser;

    fn resolve(flags: &str) -> Result<Settings> {
        let words = ["prism", "render", "scene.gltf"].into_iter().chain(flags.split_whitespace());
        match Cli::try_parse_from(words).expect(flags).command {
            Command::Render(args) => settings(&args.common.look, &args.common.classic, &Settings::default()),
            other => panic!("parsed as {other:?}"),
        }
    }

    #[test]
    fn the_march_follows_the_shell() {
        assert_eq!(resolve("").unwrap(), Settings::default());
        assert_eq!(resolve("--shell prism").unwrap().march, March::Exact);
        assert_eq!(resolve("--shell off").unwrap().march, March::Pom);
        assert_eq!(resolve("--shell off --march relief").unwrap().march, March::Relief);
    }

    #[test]
    fn an_absent_step_bound_makes_room() {
        let bounds =
            |flags: &str| resolve(&format!("--march relief {flags}")).map(|s| (s.min_steps, s.max_steps)).unwrap();
        assert_eq!(bounds(""), (8, 64));
        assert_eq!(bounds("--max-steps 4"), (4, 4));
        assert_eq!(bounds("--min-steps 100"), (100, 100));
    }

    #[test]
    fn what_cannot_be_honoured_is_wrong_usage() {
        for flags in [
            "--march none",
            "--march normal --shell prism",
            "--march none --shell auto",
            "--silhouette uv-bounds",
            "--depth-offset off",
            "--self-shadow hard --max-steps 32",
            "--shell off --stage mesh",
            "--shell off --stage geometry",
            "--shell off --refine-steps 4",
            "--refine-steps 4",
            "--shadow-map-size 512",
            "--shadow-map off --cascades 2",
            "--max-steps 4",
            "--shell off --march exact --min-steps 4",
            "--march pom --refine-steps 4",
            "--march cone --refine-steps 4",
            "--march cone --min-steps 4",
            "--shell off --march relaxed-cone --min-steps 4",
            "--min-steps 9 --max-steps 8",
            "--march offset",
            "--dither on",
            "--march relief --slope-limit 4",
            "--normals sobel",
            "--shell off --march none --normals 4-tap",
            "--shell off --horizon-bias 0.1",
            "--shell off --silhouette horizon --uv-max 1,1",
            "--shell off --silhouette uv-bounds --uv-min 1,1 --uv-max 0,2",
            "--shell off --march offset --dither on",
            "--silhouette horizon",
            "--march steep --refine-steps 4",
            "--march relief --tolerance 0.1",
            "--shell off --march offset --max-steps 4",
            "--shell off --march offset --depth-offset on",
            "--shell off --march normal --min-steps 4",
            "--shell off --march none --max-steps 4",
            "--shell off --march none --depth-offset on",
            "--shell off --march normal --silhouette uv-bounds",
            "--shell off --march normal --self-shadow hard",
            "--shell off --march normal --self-shadow soft",
            "--march cone --self-shadow soft",
            "--shell prism --march relaxed-cone --self-shadow soft",
            "--shadow-softness 0.1",
            "--self-shadow hard --shadow-softness 0.1",
            "--march relief --shadow-steps 8",
            "--self-shadow soft --shadow-steps 8",
            "--march cone --self-shadow hard --shadow-steps 8",
            "--shell off --march exact --self-shadow soft --shadow-steps 8 --max-steps 32",
            "--shell off --march none --ambient-occlusion on",
            "--shadow-map on --lod-fade 3",
            "--tangents mesh",
            "--shell off --march none --tangents derivatives",
            "--shell off --march none --lod-fade 3",
            "--shell off --shadow-map on --lod-fade 3",
            "--shell off --view prisms",
            "--shell off --view wireframe",
            "--shell prism --view walk",
            "--shell off --march none --view gathers",
            "--shell off --march normal --view limits",
        ] {
            let error = resolve(flags).expect_err(flags);
            assert_eq!(error.exit_code(), 2, "{flags}: {error}");
        }
    }

    #[test]
    fn what_can_be_honoured_is_accepted() {
        for flags in [
            "--shell off --march none",
            "--shell off --march normal --depth-offset off",
            "--shell off --silhouette uv-bounds --self-shadow hard --depth-offset off",
            "--shell off --stage auto",
            "--shell off --march exact --self-shadow hard --max-steps 32",
            "--shadow-map on --shadow-map-size 512 --cascades 1",
            "--shell off --shadow-map on",
            "--silhouette none --self-shadow off --depth-offset on",
            "--stage geometry --march pom",
            "--ambient-occlusion on",
            "--msaa 4 --shell off",
            "--shell off --march normal --ambient-occlusion on",
            "--shell off --march none --ambient-occlusion off",
            "--self-shadow hard",
            "--self-shadow soft --shadow-softness 0",
            "--shell prism --march relief --self-shadow soft --shadow-softness 1 --shadow-steps 8",
            "--shell off --march cone --self-shadow soft --shadow-steps 8",
            "--shell off --march exact --self-shadow hard --shadow-steps 8",
            "--shell prism --march relief --self-shadow hard --max-steps 32",
            "--march contact --refine-steps 4",
            "--march steep --dither on",
            "--shell off --march offset --slope-limit 4 --normals sobel",
            "--shell off --silhouette horizon --horizon-strength 2 --horizon-bias 0.1 --horizon-threshold 0.3",
            "--shell off --silhouette uv-bounds --uv-min 0,0 --uv-max 2,1",
            "--march secant --tolerance 0.1 --refine-steps 2",
            "--shell off --march normal --lod-fade -0.5",
            "--lod-fade -1",
            "--shell prism --march relief --self-shadow hard --lod-fade 0",
            "--shell off --march steep --silhouette uv-bounds",
            "--shell off --march normal --tangents mesh",
            "--tangents auto",
            "--occlusion-light 0.5",
            "--march cone --max-steps 30",
            "--view walk",
            "--shell prism --view wireframe",
            "--shell off --view gathers",
            "--shell off --march none --view base",
            "--view error",
            "--shell off --march relaxed-cone --max-steps 30 --refine-steps 6",
            "--shell off --march cone --self-shadow hard --min-steps 4",
        ] {
            resolve(flags).unwrap_or_else(|error| panic!("{flags}: {error}"));
        }
    }
}
