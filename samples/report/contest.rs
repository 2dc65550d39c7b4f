//! "At equal error": the fastest setting of each baseline against our fastest, both within the error; and the other
//! aims of the report, each met or MISSED.

use prism_engine::{
    error::Result,
    scene::Scene,
    settings::{Culling, March, Shell},
};

use super::{
    fit,
    measure::{self, Point},
    scenes,
    variants::{self, Family, Variant},
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

/// The contests of one scene, between its front's points and what bisection finds.
pub fn run(name: &str, points: &[&Point], device: &mut Device, rounds: u32, tick: &dyn Fn()) -> Result<Vec<Aim>> {
    let Some(first) = points.first() else { return Ok(Vec::new()) };
    let aspect = f64::from(first.size[0]) / f64::from(first.size[1]);
    let scene = scenes::load(name, aspect)?;
    let view = View { camera: scenes::Place::Own.camera(&scene, aspect)?, size: first.size };
    let mut judge = Judge::new(&scene, view);
    let mut aims = Vec::new();
    for &(error, least) in SPEEDUPS {
        tick();
        let ours = fastest(points, error);
        let density = judge.density(device, error)?.map(|(density, _)| density);
        aims.extend(contest(name, &scene, view, [error, least], (&ours, density), device, rounds)?);
    }
    Ok(aims)
}

/// The fastest of ours within an error.
fn fastest<'a>(points: &[&'a Point], error: f64) -> Vec<&'a Point> {
    let ours = |point: &&&Point| matches!(point.variant.family, Family::Walk | Family::Prism);
    let mut able: Vec<&Point> = points.iter().filter(ours).filter(|p| p.metrics.depth_p99 <= error).copied().collect();
    able.sort_by(|a, b| a.place()[0].total_cmp(&b.place()[0]));
    able.truncate(ENTRANTS);
    able
}

fn contest(
    name: &str,
    scene: &Scene,
    view: View,
    [error, least]: [f64; 2],
    (ours, density): (&[&Point], Option<u32>),
    device: &mut Device,
    rounds: u32,
) -> Result<Vec<Aim>> {
    let mut turns = Rounds::default();
    let add = |variant: &Variant, turns: &mut Rounds, device: &mut Device| {
        turns.add(device, &variant.name(), scene, &variant.settings, &view)
    };
    let mut places = Vec::new();
    for point in ours {
        places.push(add(&point.variant, &mut turns, device)?);
    }
    let floor = add(&variants::march(Shell::Walk, March::None, 0), &mut turns, device)?;
    let mut others = Vec::new();
    for culling in [Culling::Triangles, Culling::Clusters, Culling::Off] {
        if let Some(density) = density {
            let variant = variants::micro_mesh(density, culling);
            let before = device.memory();
            let place = add(&variant, &mut turns, device)?;
            let memory = measure::held(&before, &device.memory(), turns.host_bytes(place), &measure::colours(scene));
            others.push((variant, place, memory));
        }
    }
    turns.run(device, rounds, |_| {})?;
    let median = |place: usize| turns.timing(place).spread().map_or(f64::INFINITY, |spread| spread.median);
    let best = (0..ours.len()).min_by(|a, b| median(places[*a]).total_cmp(&median(places[*b])));
    let rival = others.iter().min_by(|a, b| median(a.1).total_cmp(&median(b.1)));
    let our_name = best.map_or("none of ours is within it".to_owned(), |i| ours[i].variant.name());
    let rival_name = rival.map_or("no baseline is within it".to_owned(), |(variant, ..)| variant.name());
    let who = format!("{our_name} against {rival_name}");
    let speed = best.zip(rival).and_then(|(i, rival)| turns.ratio(rival.1, places[i]));
    let over = best.and_then(|i| turns.ratio(places[i], floor));
    let memory = best.zip(rival).map(|(i, rival)| exactly(rival.2 / ours[i].memory));
    let aim = |what: String, who: &str, asked: String, found: Option<Spread>, met: Option<bool>| Aim {
        scene: name.to_owned(),
        what,
        who: who.to_owned(),
        asked,
        found,
        met,
    };
    Ok(vec![
        aim(
            format!("p99 ≤ {error}: times faster than the best baseline"),
            &who,
            format!("≥ {least}"),
            speed,
            at_least(speed, least),
        ),
        aim(
            format!("p99 ≤ {error}: times less memory than that baseline"),
            &who,
            format!("≥ {LESS_MEMORY}"),
            memory,
            at_least(memory, LESS_MEMORY),
        ),
        aim(
            format!("p99 ≤ {error}: times as long as the walk without lookups"),
            &our_name,
            format!("≤ {OVER_FLOOR}"),
            over,
            over.map(|spread| spread.median <= OVER_FLOOR),
        ),
    ])
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
