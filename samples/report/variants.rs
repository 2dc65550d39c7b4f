//! The ways to draw that are compared, as data.

use prism_engine::settings::{Baseline, Culling, Dicer, March, SelfShadow, Settings, Shell, Stage};

/// Linear steps, or most cones, of a march.
const STEPS: &[u32] = &[8, 16, 32, 64, 128];
/// Fewer of them too in a walk, where they are of one prism, for the marches that are fast with few.
const FEWER_STEPS: &[u32] = &[1, 2, 4];
/// The same where time is short.
const QUICK_STEPS: &[u32] = &[8, 32];
/// Triangles along a base edge of the micro-mesh.
const DENSITIES: &[u32] = &[1, 2, 4, 8, 16, 32, 64];
/// The same where time is short.
const QUICK_DENSITIES: &[u32] = &[4, 16];
/// Edges of diced triangles, pixels.
const EDGES: &[f32] = &[16.0, 8.0, 4.0, 2.0, 1.0];
/// The same where time is short.
const QUICK_EDGES: &[f32] = &[8.0, 2.0];
/// Steps from which a march counts as a patient one: none of them may beat the exact march in both error and time.
pub const PATIENT: u32 = 32;

/// Ends the technique of a baseline that is as coarse as an error allows.
const MATCHED: &str = ", matched";
/// Name of pre-tessellated meshes.
const MICRO_MESH: &str = "micro-mesh";

/// What a technique is built on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Family {
    /// The base surface.
    Base,
    /// Prism by prism.
    Prism,
    /// From prism to prism.
    Walk,
    /// What a user would take instead.
    Baseline,
}

/// What a user would take instead: a kind of baseline.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rival {
    /// Pre-tessellated.
    MicroMesh,
    /// Diced for each frame.
    Diced(Dicer),
}

impl Rival {
    /// Every kind.
    pub const ALL: &'static [Rival] = &[Rival::MicroMesh, Rival::Diced(Dicer::Tessellation), Rival::Diced(Dicer::Mesh)];

    /// How its techniques' names begin.
    pub fn name(self) -> &'static str {
        match self {
            Rival::MicroMesh => MICRO_MESH,
            Rival::Diced(by) => by.name(),
        }
    }
}

/// A way to draw.
#[derive(Clone, Debug)]
pub struct Variant {
    /// What it is built on.
    pub family: Family,
    /// The curve that it is a point of.
    pub technique: String,
    /// Its place on the curve; empty where it is the only one.
    pub setting: String,
    /// As the renderer takes it.
    pub settings: Settings,
    /// Whether its picture is shown.
    pub shown: bool,
}

impl Variant {
    /// Both names.
    pub fn name(&self) -> String {
        if self.setting.is_empty() { self.technique.clone() } else { format!("{}, {}", self.technique, self.setting) }
    }

    /// Its picture is shown.
    fn show(mut self) -> Variant {
        self.shown = true;
        self
    }

    /// The same with other settings, as another technique.
    fn renamed(mut self, suffix: &str, change: impl Fn(&mut Settings)) -> Variant {
        self.technique += suffix;
        change(&mut self.settings);
        self
    }

    /// The same as the coarsest of its kind that an error allows.
    pub fn matched(mut self) -> Variant {
        self.technique += MATCHED;
        self
    }

    /// Whether it was chosen by its error.
    pub fn is_matched(&self) -> bool {
        self.technique.ends_with(MATCHED)
    }

    /// Whether it is one of our shells.
    pub fn is_ours(&self) -> bool {
        matches!(self.family, Family::Walk | Family::Prism)
    }

    /// The kind of baseline that it is; none of ours.
    pub fn rival(&self) -> Option<Rival> {
        self.settings.baseline.map(|baseline| match baseline {
            Baseline::MicroMesh { .. } => Rival::MicroMesh,
            Baseline::Diced { by, .. } => Rival::Diced(by),
        })
    }

    /// Whether it searches with many steps.
    pub fn is_patient(&self) -> bool {
        let march = self.settings.march;
        self.settings.baseline.is_none() && (march.steps() || march.reads_cones()) && self.settings.max_steps >= PATIENT
    }

    /// Whether it is the exact march in the walk: what has to stand on the front.
    pub fn is_walk_exact(&self) -> bool {
        self.family == Family::Walk && self.settings.march == March::Exact
    }
}

/// A march at so many steps; those that have none take 0.
pub fn march(shell: Shell, march: March, steps: u32) -> Variant {
    let family = match shell {
        Shell::Off => Family::Base,
        Shell::Prism => Family::Prism,
        Shell::Walk | Shell::Auto => Family::Walk,
    };
    let place = if family == Family::Base { "base" } else { shell.name() };
    let mut settings = Settings { shell, march, refine_steps: march.usual_refine_steps(), ..Settings::default() };
    if steps > 0 {
        (settings.min_steps, settings.max_steps) = (steps, steps);
    }
    let setting = if steps > 0 { format!("{steps} steps") } else { String::new() };
    Variant { family, technique: format!("{place} {march}"), setting, settings, shown: false }
}

/// A march at every number of steps that means something to it.
fn at_all(shell: Shell, kind: March, steps: &[u32]) -> Vec<Variant> {
    if kind.steps() || kind.reads_cones() {
        steps.iter().map(|&steps| march(shell, kind, steps)).collect()
    } else {
        vec![march(shell, kind, 0)]
    }
}

/// A pre-tessellated mesh.
pub fn micro_mesh(density: u32, culling: Culling) -> Variant {
    let way = match culling {
        Culling::Off => ", not culled",
        Culling::Clusters => ", culled by cluster",
        Culling::Triangles => "",
    };
    Variant {
        family: Family::Baseline,
        technique: format!("{MICRO_MESH}{way}"),
        setting: format!("density {density}"),
        settings: Settings { baseline: Some(Baseline::MicroMesh { density, culling }), ..Settings::default() },
        shown: false,
    }
}

/// Base triangles that the GPU dices for each frame, with edges of so many pixels.
pub fn diced(by: Dicer, edge: f32) -> Variant {
    Variant {
        family: Family::Baseline,
        technique: by.name().to_owned(),
        setting: format!("edges of {} px", (100.0 * edge).round() / 100.0),
        settings: Settings { baseline: Some(Baseline::Diced { by, edge, culls: true }), ..Settings::default() },
        shown: false,
    }
}

/// Every march in every shell, and the baselines: a front in full.
pub fn all() -> Vec<Variant> {
    let mut all = Vec::new();
    for shell in [Shell::Off, Shell::Walk, Shell::Prism] {
        for &march in March::ALL.iter().filter(|march| shell == Shell::Off || march.traces()) {
            if shell == Shell::Walk && [March::Pom, March::Relief].contains(&march) {
                all.extend(at_all(shell, march, FEWER_STEPS));
            }
            all.extend(at_all(shell, march, STEPS));
        }
    }
    all.extend(baselines(DENSITIES, EDGES));
    all.into_iter().map(shown).collect()
}

/// A march of each kind in every shell, and the baselines: the other scenes' fronts.
pub fn some() -> Vec<Variant> {
    let mut some = vec![march(Shell::Off, March::Normal, 0)];
    for shell in [Shell::Off, Shell::Walk] {
        for kind in [March::Pom, March::Relief, March::Exact] {
            if shell == Shell::Walk && kind.steps() {
                some.extend(at_all(shell, kind, FEWER_STEPS));
            }
            some.extend(at_all(shell, kind, STEPS));
        }
    }
    some.push(march(Shell::Prism, March::Exact, 0));
    some.extend(baselines(DENSITIES, EDGES));
    some.into_iter().map(shown).collect()
}

/// A few, where time is short.
pub fn few() -> Vec<Variant> {
    let mut few = vec![march(Shell::Off, March::Normal, 0)];
    few.extend(at_all(Shell::Off, March::Steep, QUICK_STEPS));
    few.extend(at_all(Shell::Off, March::Pom, QUICK_STEPS));
    few.extend(at_all(Shell::Walk, March::Pom, QUICK_STEPS));
    few.push(march(Shell::Walk, March::Exact, 0));
    few.push(march(Shell::Prism, March::Exact, 0));
    few.extend(baselines(QUICK_DENSITIES, QUICK_EDGES));
    few.into_iter().map(shown).collect()
}

/// Lets those be seen that stand for their kind.
fn shown(variant: Variant) -> Variant {
    const SHOWN: &[&str] = &[
        "base normal",
        "base pom, 32 steps",
        "base exact",
        "walk pom, 8 steps",
        "walk exact",
        "micro-mesh, density 4",
        "micro-mesh, density 16",
        "tessellation, edges of 8 px",
        "tessellation, edges of 2 px",
        "mesh-tessellation, edges of 2 px",
    ];
    if SHOWN.contains(&variant.name().as_str()) { variant.show() } else { variant }
}

fn baselines(densities: &[u32], edges: &[f32]) -> Vec<Variant> {
    let mut all: Vec<_> = densities.iter().map(|&density| micro_mesh(density, Culling::Triangles)).collect();
    for &by in Dicer::ALL {
        all.extend(edges.iter().map(|&edge| diced(by, edge)));
    }
    all
}

/// What a sweep follows: ours exact and stepping, the classic technique, a micro-mesh of a fixed density, and tessellation.
pub fn followed() -> Vec<Variant> {
    vec![
        march(Shell::Off, March::Pom, 32),
        march(Shell::Walk, March::Pom, 8),
        march(Shell::Walk, March::Exact, 0),
        micro_mesh(16, Culling::Triangles),
        diced(Dicer::Tessellation, 2.0),
    ]
}

/// The exact march in both shells from both stages.
pub fn stages() -> Vec<Variant> {
    let shells = [Shell::Walk, Shell::Prism].map(|shell| march(shell, March::Exact, 0));
    let staged = |variant: &Variant| {
        [Stage::Mesh, Stage::Geometry]
            .map(|stage| variant.clone().renamed(&format!(", {stage} stage"), |settings| settings.stage = stage))
    };
    shells.iter().flat_map(staged).collect()
}

/// Self-shadow in every way.
pub fn shadows(quick: bool) -> Vec<Variant> {
    // A walk that casts shadows takes lavapipe half a minute to compile.
    let drawn = if quick {
        vec![march(Shell::Off, March::Pom, 32)]
    } else {
        vec![march(Shell::Off, March::Pom, 32), march(Shell::Walk, March::Exact, 0)]
    };
    let shadowed = |variant: &Variant| {
        let with = |shadow: &SelfShadow| {
            variant.clone().renamed(&format!(", shadow {shadow}"), |settings| settings.self_shadow = *shadow).show()
        };
        SelfShadow::ALL.iter().map(with).collect::<Vec<_>>()
    };
    let mapped = drawn
        .iter()
        .filter(|variant| variant.family == Family::Walk)
        .map(|variant| variant.clone().renamed(", shadow map", |settings| settings.shadow_map = true).show());
    drawn.iter().flat_map(shadowed).chain(mapped).collect()
}

/// One sample a pixel, and four.
pub fn samples() -> Vec<Variant> {
    let drawn = [march(Shell::Off, March::Pom, 32), march(Shell::Walk, March::Exact, 0)];
    let sampled = |variant: &Variant| {
        [1, 4].map(|samples| {
            let s = if samples > 1 { "s" } else { "" };
            variant.clone().renamed(&format!(", {samples} sample{s}"), |settings| settings.msaa = samples).show()
        })
    };
    drawn.iter().flat_map(sampled).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_front_has_every_march_in_every_shell_at_every_number_of_steps() {
        let all = all();
        for shell in [Shell::Off, Shell::Prism, Shell::Walk] {
            for &march in March::ALL.iter().filter(|march| shell == Shell::Off || march.traces()) {
                let points: Vec<_> = all
                    .iter()
                    .filter(|v| v.settings.baseline.is_none())
                    .filter(|v| v.settings.shell == shell && v.settings.march == march)
                    .collect();
                let steps: &[u32] = if march.steps() || march.reads_cones() { STEPS } else { &[64] };
                for steps in steps {
                    let found = points.iter().filter(|v| v.settings.max_steps == *steps).count();
                    assert_eq!(found, 1, "{shell} {march} {steps}");
                }
            }
        }
    }

    #[test]
    fn no_two_have_one_name() {
        for list in [all(), some(), few(), followed(), stages(), shadows(false), samples()] {
            for (i, variant) in list.iter().enumerate() {
                assert!(list[..i].iter().all(|other| other.name() != variant.name()), "{}", variant.name());
            }
        }
    }
}
