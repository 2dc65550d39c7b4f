//! The command line's grammar: what can be typed. What it means is decided in [`super::choices`].

mod draw;
mod look;
mod session;
mod tools;
mod value;

use clap::{Parser, Subcommand};

#[cfg(feature = "report")]
pub use tools::ReportArgs;
pub use {
    draw::{CommonArgs, ExplainArgs, RenderArgs, RunArgs},
    look::{LookArgs, StepArgs},
    session::{CameraArgs, SessionArgs},
    tools::{BakeArgs, BakeKind, BenchArgs, DeviceArgs, ProbeArgs},
    value::{height_scale, on_off, ranged, scale_factors, share, two_numbers, unbounded, words},
};

/// Displaced detail on coarse meshes, by rays traced inside prism shells.
#[derive(Debug, Parser)]
#[command(name = "prism", version, after_help = AFTER_HELP)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

const AFTER_HELP: &str = "\
Exit codes: 0 done, 1 failed, 2 wrong usage, 77 this machine lacks what was asked (named).
Data go to stdout, notices to stderr. `prism COMMAND --help` has every option and its default.
PRISM_ASSETS names the assets' folder; PRISM_LOG=debug shows the engine's log.";

const RUN_AFTER_HELP: &str = "\
Keys in the window: U or F1 shows the panel (open where the window is 900 pixels wide) or puts it away, S stage, \
H shell on or off, M march, V the next view, 1 to 9 and 0 the first ten of them, E the error, K compares two settings \
(those of then on the right of a line that the mouse drags), X anti-aliasing, D dithered start, L self-shadow, \
W shadow maps, A ambient occlusion, without a shell C clipped outline and G normals, Space pauses the sample's time, \
R resets the camera, N and B show the next and the last scene of a sample of several, \
F11 or F lets RenderDoc take the next frame where it is loaded, F12 or P saves a screenshot in the current folder, \
I every frame from then on as a picture until it is pressed again, Esc or Q quits. A click probes a pixel's ray, left drag turns the camera, right or middle drag \
(or Shift and left drag) moves it sideways, the wheel or a two-finger scroll or pinch zooms.";

const BAKE_AFTER_HELP: &str = "\
A cone's ratio is its radius in UV at height 1 over its tip, 1 at most. Its promise holds wherever the map is read, \
nearest or bilinearly; the ratio is rounded down. As .png: 16-bit RGB, red the height, green the square root of the \
ratio, blue 0. As .exr: 32-bit floats height.H and cone.R, the ratio itself.
minmax, .exr only: a part per level, 'level 0' the finest, with channels min and max. Node k of level L spans the \
texels k 2^L to (k + 1) 2^L along each axis, one less where the map is clamped, wrapped one by one; one node more than \
the map needs holds what lies beyond its end.";

const PROBE_AFTER_HELP: &str = "\
On the left the path over the height map, the base triangles of its prisms, and the straight ray that parallax mapping \
takes for it. On the right the ray's level against the surface's, each march's samples below, and what is around the \
hit. All of it is computed on the CPU in 64-bit floats; the true hit is the reference's.";

/// The commands of this build.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// The samples, one line each
    List,
    /// Every Vulkan device, and why one is refused
    Devices,
    /// Runs a sample: in a window where there is a display, else headless
    ///
    /// --headless, --out, --aov and --sequence each keep it from opening a window.
    #[command(after_help = RUN_AFTER_HELP)]
    Run(RunArgs),
    /// Renders one frame of a glTF file offscreen
    Render(RenderArgs),
    /// What a scene or a sample needs, what was left out, and why
    Explain(ExplainArgs),
    /// Makes a cone map or a min-max pyramid of a height map, on the GPU
    #[command(after_help = BAKE_AFTER_HELP)]
    Bake(BakeArgs),
    /// Draws what one pixel's ray does in the shell: its path, the samples of each march, their hits and the true one
    #[command(after_help = PROBE_AFTER_HELP)]
    Probe(ProbeArgs),
    /// Our fastest setting against the fastest baseline of the same error, on a torus; a Markdown table
    Bench(BenchArgs),
    /// Error against run time: every technique, every baseline, one thing varied at a time; a page with plots and pictures
    #[cfg(feature = "report")]
    Report(ReportArgs),
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(args: &str) -> Result<RunArgs, clap::Error> {
        let words = ["prism", "run", "prism_shell"].into_iter().chain(args.split_whitespace());
        match Cli::try_parse_from(words)?.command {
            Command::Run(run) => Ok(run),
            other => panic!("parsed as {other:?}"),
        }
    }

    #[test]
    fn grammar_is_consistent() {
        use clap::CommandFactory;
        Cli::command().debug_assert();
    }

    #[test]
    fn negative_coordinates_are_values() {
        let args = run("--eye -1,2,-3.5 --target -0,1e-3,+2").unwrap();
        assert_eq!(args.common.camera.eye, Some([-1.0, 2.0, -3.5]));
        assert_eq!(args.common.camera.target, Some([-0.0, 1e-3, 2.0]));
    }

    #[test]
    fn wrong_values_are_usage_errors() {
        for wrong in [
            "--size 0x0",
            "--size 640",
            "--size 640x",
            "--size -1x4",
            "--frames 0",
            "--frames -1",
            "--eye 1,2",
            "--eye nan,0,0",
            "--eye inf,0,0",
            "--fov-y 0",
            "--fov-y 180",
            "--fov-y -10",
            "--fov-y nan",
            "--time-step -0.1",
            "--tilt 89",
            "--tilt -1",
            "--min-steps 0",
            "--max-steps 5000",
            "--march cone-step",
            "--tolerance 2",
            "--horizon-falloff 0.1",
            "--horizon-threshold 1",
            "--uv-min 1",
            "--uv-scale 0,1",
            "--height-scale -1",
            "--midlevel nan",
            "--wrap beyond",
            "--height-lod 16",
            "--height-lod none",
            "--height-format r32",
            "--metallic-channel x",
            "--specular 1.5",
            "--occlusion-light 2",
            "--tangents screen",
            "--lod-fade soon",
            "--normals smooth",
            "--shell cage",
            "--stage task",
            "--depth-offset maybe",
            "--validation gpu",
            "--shadow-map soft",
            "--self-shadow softer",
            "--shadow-softness -0.1",
            "--shadow-softness 1.5",
            "--shadow-steps 0",
            "--shadow-map-size 8",
            "--cascades 0",
            "--msaa 2",
            "--msaa on",
        ] {
            let error = run(wrong).expect_err(wrong);
            assert_eq!(error.exit_code(), 2, "{wrong}");
        }
    }

    #[test]
    fn every_option_tells_its_default() {
        use clap::CommandFactory;
        for command in Cli::command().get_subcommands() {
            for option in command.get_opts() {
                let help = option.get_long_help().or(option.get_help()).map(ToString::to_string).unwrap_or_default();
                // What has to be given has none.
                let told =
                    option.is_required_set() || help.contains("default") || !option.get_default_values().is_empty();
                assert!(told, "prism {} --{}: no default in the help", command.get_name(), option.get_id());
            }
        }
    }
}
