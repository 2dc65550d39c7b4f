//! The flags of the technique.

use clap::{
    ArgAction, Args,
    builder::{PossibleValuesParser, TypedValueParser},
};
use prism_engine::settings::{
    DepthPrepass, March, PrismCulling, SelfShadow, Shell, Silhouette, Stage, View, VisibilityBuffer,
};

use super::value::{on_off, share, words};

/// How a scene is drawn. An absent flag leaves the choice to the sample and to the other flags.
#[derive(Clone, Debug, Default, Args)]
#[command(next_help_heading = "Technique")]
pub struct LookArgs {
    /// The stage that makes the shell's geometry; auto: mesh where the device has it [default: auto]
    #[arg(long, value_parser = words(Stage::ALL, Stage::name))]
    pub stage: Option<Stage>,

    /// off: the base surface only, classic parallax; auto: walk [default: auto]
    #[arg(long, value_parser = words(Shell::ALL, Shell::name))]
    pub shell: Option<Shell>,

    /// How a ray finds the surface; none, normal and offset trace none, for --shell off only
    /// [default: exact; pom with --shell off]
    #[arg(long, value_parser = words(March::ALL, March::name))]
    pub march: Option<March>,

    /// How finely.
    #[command(flatten)]
    pub steps: StepArgs,

    /// What clips the base surface, for --shell off: a shell needs nothing [default: none]
    #[arg(long, value_parser = words(Silhouette::ALL, Silhouette::name))]
    pub silhouette: Option<Silhouette>,

    /// Whether the base surface's hit moves the depth; a shell always writes the hit's depth [default: on]
    #[arg(long, value_name = "on|off", value_parser = on_off(), action = ArgAction::Set)]
    pub depth_offset: Option<bool>,

    /// Whether what the height field hides of the sky dims the ambient light [default: off]
    #[arg(long, value_name = "on|off", value_parser = on_off(), action = ArgAction::Set)]
    pub ambient_occlusion: Option<bool>,

    /// How much of the occlusion, the texture's or that of --ambient-occlusion, dims direct light too, 0 to 1 [default: 0]
    #[arg(long, value_name = "SHARE", value_parser = share)]
    pub occlusion_light: Option<f32>,

    /// Shadows that the detail casts on itself; in a shell exact across triangles. soft: those of round lights
    /// [default: off]
    #[arg(long, value_parser = words(SelfShadow::ALL, SelfShadow::name))]
    pub self_shadow: Option<SelfShadow>,

    /// Radius of every light for soft self-shadow, as the tangent of its angle, 0 to 1; 0 is hard [default: 0.05]
    #[arg(long, value_name = "S", value_parser = share)]
    pub shadow_softness: Option<f32>,

    /// Most linear steps of a ray toward a light: along the whole ray (base surface), in a prism (shell, not exact), 1 to
    /// 4096 [default: as the march's own]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub shadow_steps: Option<u32>,

    /// Whether depth is drawn before colours, so that no hidden pixel is shaded; auto: that of plain surfaces, where there
    /// are several [default: auto]
    #[arg(long, value_parser = words(DepthPrepass::ALL, DepthPrepass::name))]
    pub depth_prepass: Option<DepthPrepass>,

    /// Which prisms are dropped before the stage that makes them: those outside the view, or also those hidden by what is
    /// nearer, their shell's horizon included; auto: where it pays, as `explain` tells [default: auto]
    #[arg(long, value_parser = words(PrismCulling::ALL, PrismCulling::name))]
    pub prism_culling: Option<PrismCulling>,

    /// Whether walks begin at the lids that a visibility buffer names, each pixel's nearest one, or the triangles of
    /// --baseline micro-mesh are shaded so; auto: where they are so small that it pays, as `explain` tells [default: auto]
    #[arg(long, value_parser = words(VisibilityBuffer::ALL, VisibilityBuffer::name))]
    pub visibility_buffer: Option<VisibilityBuffer>,

    /// Whether lights cast shadows through maps of what they see, drawn by the same tracer
    /// [default: off, on where the sample says so]
    #[arg(long, value_name = "on|off", value_parser = on_off(), action = ArgAction::Set)]
    pub shadow_map: Option<bool>,

    /// Texels a side of each shadow map, 16 to 8192 [default: 1024]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(16..=8192))]
    pub shadow_map_size: Option<u32>,

    /// Shadow maps of a directional light, the nearer to the camera the finer, 1 to 6 [default: 3]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=6))]
    pub cascades: Option<u32>,

    /// Samples of a pixel: 4 smooth every outline, a shell's too; surface data keep one [default: 1]
    #[arg(long, value_name = "1|4", value_parser = PossibleValuesParser::new(["1", "4"]).map(|word| if word == "4" { 4u32 } else { 1 }))]
    pub msaa: Option<u32>,

    /// What the picture shows: the shaded surface; the base mesh; the edges of the prisms over the picture; a colour for each
    /// prism; how many prisms the walk visits; how many heights and bounds are read (1 to 256, dark to light); loops that
    /// gave up (red); UV, height, normal, depth (white to black each doubling), the first light's shadow; the depth error
    /// against the reference, 1e-6 to 10 footprints (dark to light) [default: shaded]
    #[arg(long, value_parser = words(View::ALL, View::name))]
    pub view: Option<View>,

    /// Keeps what `prism explain` says is left out, where it could be there: the same picture, for comparison [default: off]
    #[arg(long)]
    pub keep_all: bool,
}

/// How many steps a march takes, and how near it comes.
#[derive(Clone, Debug, Default, Args)]
pub struct StepArgs {
    /// Fewest linear steps (pom, relief): of a ray straight down (base surface), of a prism (shell), 1 to 4096
    /// [default: 8, or --max-steps where that is less]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub min_steps: Option<u32>,

    /// Most steps (not exact): of a ray at grazing angle (base surface), of a prism (shell), 1 to 4096
    /// [default: 64, or --min-steps where that is more]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub max_steps: Option<u32>,

    /// After the linear search: relief's bisections, secant's most steps, contact's fine steps; in the last
    /// cone: relaxed-cone's bisections; 0 to 64 [default: 8; secant 5]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=64))]
    pub refine_steps: Option<u32>,

    /// Secant is content with a height so near to the ray's, as a share of the height's range, 0 to 1 [default: 0.01]
    #[arg(long, value_name = "SHARE", value_parser = share)]
    pub tolerance: Option<f32>,
}
