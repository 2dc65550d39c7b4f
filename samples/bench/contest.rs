//! Who may compete: every setting's error is measured, none is assumed.

use std::collections::BTreeMap;

use prism_engine::{
    aov::Aov,
    error::Result,
    measure::Metrics,
    render::{self, baseline::MAX_DENSITY},
    scene::Scene,
    settings::{Baseline, Culling, Dicer, Settings},
    shell::reference::{Reference, Shadows},
};

use super::{
    scenes,
    variants::{self, Variant},
};
use crate::timing::{Device, Rounds, View};

/// Where the search for a density begins, and the triangles that it may have there: a finer base mesh begins lower.
const FIRST_DENSITY: u32 = 8;
const FIRST_TRIANGLES: usize = 200_000;
/// Edges of diced triangles at first, pixels, and the shortest that are tried.
const FIRST_EDGE: f32 = 4.0;
/// See [`FIRST_EDGE`].
const LEAST_EDGE: f32 = 0.125;
/// The longest that are tried: a dense base mesh needs no dicing at all.
const MOST_EDGE: f32 = 64.0;
/// Halvings, in powers of two, of the span in which the longest edge lies: to 2^⅛ of it.
const EDGE_HALVINGS: u32 = 3;
/// Rounds after which the fastest of our settings is known well enough to compete.
const MAX_HEATS: u32 = 5;

/// A setting with its error.
#[derive(Clone)]
pub struct Judged {
    /// The setting.
    pub variant: Variant,
    /// Against the reference.
    pub metrics: Metrics,
}

/// Measures settings on one view.
pub struct Judge<'a> {
    scene: &'a Scene,
    view: View,
    truth: Aov,
    densities: BTreeMap<u32, Metrics>,
}

impl<'a> Judge<'a> {
    /// Traces the truth.
    pub fn new(scene: &'a Scene, view: View) -> Self {
        let [width, height] = view.size;
        let truth = Reference::new(scene).render(&view.camera, width, height, Shadows::Skip);
        Self::knowing(scene, view, truth)
    }

    /// The same with the truth as it was traced before.
    pub fn knowing(scene: &'a Scene, view: View, truth: Aov) -> Self {
        Judge { scene, view, truth, densities: BTreeMap::new() }
    }

    fn metrics(&self, device: &mut Device, settings: &Settings) -> Result<Metrics> {
        let aov = device.surface(self.scene, settings, &self.view)?;
        Ok(Metrics::between(&aov, &self.truth, &self.view.camera))
    }

    fn of_density(&mut self, device: &mut Device, density: u32) -> Result<Metrics> {
        if let Some(known) = self.densities.get(&density) {
            return Ok(*known);
        }
        let settings = Settings {
            baseline: Some(Baseline::MicroMesh { density, culling: Culling::Clusters }),
            ..Settings::default()
        };
        let metrics = self.metrics(device, &settings)?;
        self.densities.insert(density, metrics);
        Ok(metrics)
    }

    /// The coarsest micro-mesh whose depth error is within `error`; none where even the finest is not.
    pub fn density(&mut self, device: &mut Device, error: f64) -> Result<Option<(u32, Metrics)>> {
        let few = (FIRST_TRIANGLES / scenes::triangles(self.scene).max(1)).isqrt() as u32;
        let (mut fails, mut meets) = (0, few.clamp(1, FIRST_DENSITY));
        while self.of_density(device, meets)?.depth_p99 > error {
            if meets == MAX_DENSITY {
                return Ok(None);
            }
            (fails, meets) = (meets, MAX_DENSITY.min(2 * meets));
        }
        while meets - fails > 1 {
            let middle = fails.midpoint(meets);
            if self.of_density(device, middle)?.depth_p99 > error { fails = middle } else { meets = middle }
        }
        Ok(Some((meets, self.of_density(device, meets)?)))
    }

    /// For each error, diced triangles with the longest edges whose depth error is within it; none where even the shortest
    /// are not.
    pub fn diced(&self, device: &mut Device, by: Dicer, errors: &[f64]) -> Result<Vec<Option<Judged>>> {
        // One renderer for all: their length is no part of the shaders, which take long to compile.
        let mut renderer = device.measuring(self.scene, &variants::diced(by, FIRST_EDGE).settings)?;
        let mut of = |edge: f32| -> Result<Judged> {
            let variant = variants::diced(by, edge);
            let aov = device.surface_with(&mut renderer, &variant.settings, &self.view)?;
            Ok(Judged { variant, metrics: Metrics::between(&aov, &self.truth, &self.view.camera) })
        };
        errors.iter().map(|error| longest_edge(&mut of, *error)).collect()
    }

    /// Our settings, up to the first of each list that is within `tightest`: those after it can only be slower.
    pub fn ours(&self, device: &mut Device, tightest: f64) -> Result<Vec<Judged>> {
        let mut all = Vec::new();
        for list in variants::ours() {
            for variant in list {
                let metrics = self.metrics(device, &variant.settings)?;
                all.push(Judged { variant, metrics });
                if metrics.depth_p99 <= tightest {
                    break;
                }
            }
        }
        Ok(all)
    }

    /// For each error, the fastest of the settings that are within it.
    pub fn fastest(
        &self,
        device: &mut Device,
        settings: &[Judged],
        errors: &[f64],
        rounds: u32,
    ) -> Result<Vec<Option<Judged>>> {
        let widest = errors.iter().copied().fold(0.0, f64::max);
        let within = |judged: &&Judged, error: f64| judged.metrics.depth_p99 <= error;
        let able: Vec<&Judged> = settings.iter().filter(|judged| within(judged, widest)).collect();
        let times = self.heats(device, &able, rounds)?;
        let fastest = |error: &f64| {
            let able = able.iter().zip(&times).filter(|(judged, _)| within(judged, *error));
            able.min_by(|a, b| a.1.total_cmp(b.1)).map(|(judged, _)| (*judged).clone())
        };
        Ok(errors.iter().map(fastest).collect())
    }

    /// The least time of each setting, all in turns.
    fn heats(&self, device: &mut Device, settings: &[&Judged], rounds: u32) -> Result<Vec<f64>> {
        let mut heats = Rounds::default();
        for Judged { variant, .. } in settings {
            heats.add(device, &variant.name, self.scene, &variant.settings, &self.view)?;
        }
        heats.run(device, rounds.min(MAX_HEATS), |_| {})?;
        Ok((0..settings.len()).map(|place| heats.timing(place).least()).collect())
    }

    /// A setting by the stage that is faster, of those that leave its error what it is.
    pub fn by_stage(&self, device: &mut Device, judged: Judged, rounds: u32) -> Result<Judged> {
        let mut able = Vec::new();
        for stage in render::shell_stages(&device.ctx) {
            let variant = variants::by_stage(&judged.variant, stage);
            let metrics = self.metrics(device, &variant.settings)?;
            if metrics.depth_p99 <= judged.metrics.depth_p99 {
                able.push(Judged { variant, metrics });
            }
        }
        let times = self.heats(device, &able.iter().collect::<Vec<_>>(), rounds)?;
        let fastest = able.into_iter().zip(times).min_by(|a, b| a.1.total_cmp(&b.1));
        Ok(fastest.map_or(judged, |(fastest, _)| fastest))
    }
}

/// The longest edges within an error, of those that `of` draws.
fn longest_edge(of: &mut impl FnMut(f32) -> Result<Judged>, error: f64) -> Result<Option<Judged>> {
    let mut edge = FIRST_EDGE;
    let mut best = of(edge)?;
    while best.metrics.depth_p99 > error {
        edge *= 0.5;
        if edge < LEAST_EDGE {
            return Ok(None);
        }
        best = of(edge)?;
    }
    while (FIRST_EDGE..MOST_EDGE).contains(&edge) {
        let longer = of(2.0 * edge)?;
        if longer.metrics.depth_p99 > error {
            break;
        }
        if longer.metrics == best.metrics {
            // All of the base mesh's edges are shorter: nothing is diced any more.
            return Ok(Some(best));
        }
        (edge, best) = (2.0 * edge, longer);
    }
    let mut factor = 2f32;
    for _ in 0..EDGE_HALVINGS {
        factor = factor.sqrt();
        let longer = of(edge * factor)?;
        if longer.metrics.depth_p99 <= error {
            (edge, best) = (edge * factor, longer);
        }
    }
    Ok(Some(best))
}
