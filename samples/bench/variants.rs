//! What takes part in the contest, as data.

use prism_engine::settings::{Baseline, Culling, Dicer, March, Settings, Shell, Stage, VisibilityBuffer};

/// Our shells. A new one takes part with its name here.
const SHELLS: &[Shell] = &[Shell::Walk, Shell::Prism];

/// Our marches: linear steps in a prism, and bisections or secant steps after them; each list from fast to exact, and what follows one
/// that is exact enough is not tried.
const MARCHES: &[(March, &[(u32, u32)])] = &[
    (March::Exact, &[(1, 0)]),
    (
        March::Relief,
        &[(1, 2), (1, 4), (2, 2), (2, 4), (3, 2), (3, 3), (3, 4), (4, 4), (8, 4), (8, 8), (16, 8), (32, 8)],
    ),
    (March::Secant, &[(1, 1), (1, 2), (2, 1), (2, 2), (3, 1), (3, 2), (3, 3), (4, 2), (4, 4), (8, 4), (16, 4)]),
    (March::Pom, &[(1, 0), (2, 0), (3, 0), (4, 0), (6, 0), (8, 0), (12, 0), (16, 0), (32, 0), (64, 0)]),
];

/// Of the height range; within it a secant step is the last. The default, a hundredth, is a tenth of a footprint here.
const SECANT_TOLERANCE: f32 = 0.001;

/// How a micro-mesh is drawn. A visibility buffer looks its corners up; without one they come by indices and a vertex cache.
const MICRO_MESHES: &[(&str, Culling, VisibilityBuffer)] = &[
    ("culled by cluster", Culling::Clusters, VisibilityBuffer::Auto),
    ("culled by cluster, indexed", Culling::Clusters, VisibilityBuffer::Off),
    ("culled by triangle", Culling::Triangles, VisibilityBuffer::Auto),
    ("not culled", Culling::Off, VisibilityBuffer::Auto),
];

/// How many times faster than a baseline a shell has to be, by depth error in pixel footprints.
pub const SPEEDUPS: &[(f64, f64)] = &[(0.5, 2.0), (0.1, 8.0)];
/// The tightest error's setting, in floors.
pub const OVER_FLOOR: f64 = 5.0;
/// Twice the base triangles at the same coverage.
pub const DOUBLED: f64 = 1.3;
/// The same detail in a map of 8 times the texels on a side.
pub const FINE_MAP: f64 = 2.0;

/// A way to draw, and what it is called.
#[derive(Clone)]
pub struct Variant {
    /// As the table shows it.
    pub name: String,
    /// As the renderer takes it.
    pub settings: Settings,
}

/// Every setting of ours: for each shell and march a list from fast to exact.
pub fn ours() -> Vec<Vec<Variant>> {
    let settings = |shell: Shell, march: March, (steps, refine): (u32, u32)| {
        let name = match march {
            March::Exact => format!("{shell} {march}"),
            March::Relief | March::Secant => format!("{shell} {march} {steps}+{refine}"),
            _ => format!("{shell} {march} {steps}"),
        };
        let settings = Settings {
            shell,
            march,
            min_steps: steps,
            max_steps: steps,
            refine_steps: refine,
            tolerance: SECANT_TOLERANCE,
            ..Settings::default()
        };
        Variant { name, settings }
    };
    let mut lists = Vec::new();
    for shell in SHELLS {
        for (march, steps) in MARCHES {
            lists.push(steps.iter().map(|steps| settings(*shell, *march, *steps)).collect());
        }
    }
    lists
}

/// One of ours by a stage.
pub fn by_stage(variant: &Variant, stage: Stage) -> Variant {
    let name = format!("{}, {stage} stage", variant.name);
    Variant { name, settings: Settings { stage, ..variant.settings.clone() } }
}

/// Every way to draw a micro-mesh of a density; true for those culled by cluster, which is the common way.
pub fn micro_meshes(density: u32) -> Vec<(Variant, bool)> {
    let variant = |&(way, culling, visibility_buffer): &(&str, Culling, VisibilityBuffer)| {
        let baseline = Some(Baseline::MicroMesh { density, culling });
        let settings = Settings { baseline, visibility_buffer, ..Settings::default() };
        (Variant { name: format!("micro-mesh {density}, {way}"), settings }, culling == Culling::Clusters)
    };
    MICRO_MESHES.iter().map(variant).collect()
}

/// Base triangles diced for each frame, with edges of so many pixels.
pub fn diced(by: Dicer, edge: f32) -> Variant {
    let baseline = Baseline::Diced { by, edge, culls: true };
    Variant {
        name: format!("{by} {edge:.3} px"),
        settings: Settings { baseline: Some(baseline), ..Settings::default() },
    }
}

/// The floors: a name for the row, the variant, and how many times as long the tightest error's setting may take.
pub fn floors() -> [(&'static str, Variant, Option<f64>); 2] {
    // The walk to the base surface looks up no height: what any march costs at least.
    let walk = Settings { shell: Shell::Walk, march: March::None, ..Settings::default() };
    let normal = Settings { shell: Shell::Off, march: March::Normal, ..Settings::default() };
    [
        (
            "floor: the walk without height lookups",
            Variant { name: "walk, no lookups".into(), settings: walk },
            Some(OVER_FLOOR),
        ),
        ("floor: normal-mapped base surface", Variant { name: "off normal".into(), settings: normal }, None),
    ]
}
