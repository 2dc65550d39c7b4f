//! "At equal error": the fastest setting of each baseline against our fastest, both within the error; and the other
//! aims of the report, each met or MISSED.

use std::time::Instant;

use prism_engine::{
    error::Result,
    scene::Scene,
    settings::{Baseline, Culling, March, Shell},
};

use super::{
    fit,
    measure::{self, Pace, Point},
    scenes,
    table::short,
    variants::{self, Rival, Variant},
};
use crate::{
    bench::{
        contest::Judge,
        variants::{OVER_FLOOR, SPEEDUPS},
    },
    timing::{Device, Rounds, Spread, View},
};

/// How many times less memory it has to hold.
const LESS_MEMORY: f64 = 20.0;
/// Of ours, so many of the fastest compete: their times were taken in other rounds.
const ENTRANTS: usize = 3;

/// A figure that was asked for.
#[derive(Clone, Debug)]
pub struct Aim {
    /// Of which scene.
    pub scene: String,
    /// What is measured.
    pub what: String,
    /// Who competes.
    pub who: String,
    /// What it must be.
    pub asked: String,
    /// What it is.
    pub found: Option<Spread>,
    /// Whether that will do; none where it could not be measured.
    pub met: Option<bool>,
}

impl Aim {
    /// In capitals where it was missed.
    pub fn verdict(&self) -> &'static str {
        match self.met {
            Some(true) => "met",
            Some(false) => "MISSED",
            None => "not measured",
        }
    }
}

fn at_least(found: Option<Spread>, least: f64) -> Option<bool> {
    found.map(|spread| spread.median >= least)
}

/// The coarsest baseline of a kind whose depth error is within `error`; none where not even the finest is, or where the
/// device lacks the stages.
pub fn coarsest(rival: Rival, judge: &mut Judge<'_>, device: &mut Device, error: f64) -> Result<Option<Variant>> {
    Ok(match rival {
        Rival::MicroMesh => {
            let found = judge.density(device, error)?;
            found.map(|(density, _)| variants::micro_mesh(density, Culling::Triangles))
        }
        Rival::Diced(by) if device.dicers().contains(&by) => {
            let found = judge.diced(device, by, &[error])?.pop().flatten();
            found.and_then(|judged| match judged.variant.settings.baseline {
                Some(Baseline::Diced { edge, .. }) => Some(variants::diced(by, edge)),
                _ => None,
            })
        }
        Rival::Diced(_) => None,
    })
}

/// The ways to draw it that compete: of the pre-tessellated mesh each kind of culling.
fn ways(coarsest: Variant) -> Vec<Variant> {
    match coarsest.settings.baseline {
        Some(Baseline::MicroMesh { density, .. }) => {
            let ways = [Culling::Triangles, Culling::Clusters, Culling::Off];
            ways.map(|culling| variants::micro_mesh(density, culling)).to_vec()
        }
        _ => vec![coarsest],
    }
}

/// The contests of one scene, between its front's points and what bisection finds.
pub fn run(name: &str, points: &[&Point], device: &mut Device, pace: Pace, tick: &dyn Fn()) -> Result<Vec<Aim>> {
    let Some(first) = points.first() else { return Ok(Vec::new()) };
    let aspect = f64::from(first.size[0]) / f64::from(first.size[1]);
    let scene = scenes::load(name, aspect)?;
    let view = View { camera: scenes::Place::Own.camera(&scene, aspect)?, size: first.size };
    let mut judge = Judge::new(&scene, view);
    let mut aims = Vec::new();
    for (i, &(error, least)) in SPEEDUPS.iter().enumerate() {
        let left = (SPEEDUPS.len() - i) as u32;
        let now = Instant::now();
        let pace = Pace { end: now + pace.end.saturating_duration_since(now) / left, ..pace };
        let ours = fastest(points, error);
        let mut others = Vec::new();
        for rival in Rival::ALL {
            others.extend(coarsest(*rival, &mut judge, device, error)?.into_iter().flat_map(ways));
        }
        let ring = Ring { name, scene: &scene, view };
        aims.extend(contest(&ring, [error, least], (&ours, others), device, pace, tick)?);
    }
    Ok(aims)
}

/// The fastest of ours within an error.
fn fastest<'a>(points: &[&'a Point], error: f64) -> Vec<&'a Point> {
    let ours = points.iter().filter(|point| point.variant.is_ours());
    let mut able: Vec<&Point> = ours.filter(|p| p.metrics.depth_p99 <= error).copied().collect();
    able.sort_by(|a, b| a.place()[0].total_cmp(&b.place()[0]));
    able.truncate(ENTRANTS);
    able
}

/// One of those who take turns.
struct Entrant {
    variant: Variant,
    place: usize,
    /// See [`Point::memory`].
    memory: f64,
}

impl Entrant {
    fn told(&self, turns: &Rounds) -> String {
        let ms = turns.timing(self.place).spread().map_or(f64::NAN, |spread| spread.median);
        format!("{} ({} ms, {} MiB)", self.variant.name(), short(ms), short(self.memory))
    }
}

/// Where they compete.
struct Ring<'a> {
    name: &'a str,
    scene: &'a Scene,
    view: View,
}

fn contest(
    ring: &Ring<'_>,
    [error, least]: [f64; 2],
    (ours, others): (&[&Point], Vec<Variant>),
    device: &mut Device,
    pace: Pace,
    tick: &dyn Fn(),
) -> Result<Vec<Aim>> {
    let Ring { name, scene, view } = *ring;
    let mut turns = pace.turns();
    let add = |variant: &Variant, turns: &mut Rounds, device: &mut Device| {
        turns.add(device, &variant.name(), scene, &pace.timed(device, &variant.settings), &view)
    };
    let mut entrants = Vec::new();
    for point in ours {
        let place = add(&point.variant, &mut turns, device)?;
        entrants.push(Entrant { variant: point.variant.clone(), place, memory: point.memory });
    }
    let floor = add(&variants::march(Shell::Walk, March::None, 0), &mut turns, device)?;
    let mut rivals = Vec::new();
    for variant in others {
        let before = device.memory();
        let place = add(&variant, &mut turns, device)?;
        let memory = measure::held(&before, &device.memory(), turns.host_bytes(place), &measure::colours(scene));
        rivals.push(Entrant { variant, place, memory });
    }
    turns.run_until(device, pace.rounds, Some(pace.end), |_| tick())?;
    let median = |place: usize| turns.timing(place).spread().map_or(f64::INFINITY, |spread| spread.median);
    for list in [&mut entrants, &mut rivals] {
        list.sort_by(|a, b| median(a.place).total_cmp(&median(b.place)));
    }
    let (best, rival) = (entrants.first(), rivals.first());
    let our_name = best.map_or("none of ours is within it".to_owned(), |ours| ours.told(&turns));
    // The fastest of each kind.
    let first = |kind: &Rival| rivals.iter().find(|rival| rival.variant.rival() == Some(*kind));
    let next: Vec<&Entrant> =
        Rival::ALL.iter().filter_map(first).filter(|r| Some(r.place) != rival.map(|r| r.place)).collect();
    let mut who = match rival {
        Some(rival) => format!("{our_name} against {}", rival.told(&turns)),
        None => format!("{our_name}; no baseline is within it"),
    };
    for other in &next {
        who += &format!("; {}", other.told(&turns));
    }
    let speed = best.zip(rival).and_then(|(best, rival)| turns.ratio(rival.place, best.place));
    let over = best.and_then(|best| turns.ratio(best.place, floor));
    let aim = |what: String, who: &str, asked: String, found: Option<Spread>, met: Option<bool>| Aim {
        scene: name.to_owned(),
        what,
        who: who.to_owned(),
        asked,
        found,
        met,
    };
    let mut aims = vec![aim(
        format!("p99 ≤ {error}: times faster than the best baseline"),
        &who,
        format!("≥ {least}"),
        speed,
        // Whoever is within it alone has won.
        at_least(speed, least).or_else(|| best.is_some_and(|_| rival.is_none()).then_some(true)),
    )];
    for other in rival.into_iter().chain(next) {
        let kind = other.variant.rival().map_or("", Rival::name);
        let memory = best.map(|best| exactly(other.memory / best.memory));
        aims.push(aim(
            format!("p99 ≤ {error}: times less memory than {kind}"),
            &format!("{our_name} against {}", other.told(&turns)),
            format!("≥ {LESS_MEMORY}"),
            memory,
            at_least(memory, LESS_MEMORY),
        ));
    }
    aims.push(aim(
        format!("p99 ≤ {error}: times as long as the walk without lookups"),
        &our_name,
        format!("≤ {OVER_FLOOR}"),
        over,
        over.map(|spread| spread.median <= OVER_FLOOR),
    ));
    Ok(aims)
}

fn exactly(value: f64) -> Spread {
    Spread { low: value, median: value, high: value }
}

/// Whether the exact march in the walk stands on the front of a scene, and whether a patient march beats it.
pub fn standing(name: &str, points: &[&Point]) -> Vec<Aim> {
    let Some(exact) = points.iter().find(|point| point.variant.is_walk_exact()) else { return Vec::new() };
    let beats = |point: &Point| {
        let ([t, e], [our_t, our_e]) = (point.place(), exact.place());
        t <= our_t && e <= our_e && [t, e] != [our_t, our_e]
    };
    let places: Vec<[f64; 2]> = points.iter().map(|point| point.place()).collect();
    let on_front = fit::pareto(&places).into_iter().any(|i| points[i].variant.is_walk_exact());
    let by = |beats: Vec<String>| if beats.is_empty() { "nothing beats it".to_owned() } else { beats.join("; ") };
    let all = points.iter().filter(|point| beats(point)).map(|point| point.variant.name()).collect();
    let patient = points.iter().filter(|point| beats(point) && point.variant.is_patient());
    let patient: Vec<String> = patient.map(|point| point.variant.name()).collect();
    let aim = |what: &str, met: bool, who: Vec<String>| Aim {
        scene: name.to_owned(),
        what: what.to_owned(),
        who: by(who),
        asked: "yes".into(),
        found: None,
        met: Some(met),
    };
    vec![
        aim("walk exact is on the front", on_front, all),
        aim(
            &format!("walk exact is beaten by no march of {} steps or more", variants::PATIENT),
            patient.is_empty(),
            patient.clone(),
        ),
    ]
}
