//! Fair timing: all variants take turns in one process, and what is compared was measured in the same round.

use std::time::Instant;

use prism_engine::{error::Result, render::Renderer, scene::Scene, settings::Settings};

use super::device::{Cost, Device, View};

/// Untimed frames first: lavapipe compiles at the first draw, and caches fill.
pub const WARM_UP: u32 = 2;
/// What lies further from the quartiles than so many times their distance is an outlier (Tukey 1977).
const FENCE: f64 = 1.5;

/// Median and quartiles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// A quarter of the values lies below.
    pub low: f64,
    /// The middle one.
    pub median: f64,
    /// A quarter of the values lies above.
    pub high: f64,
}

impl Spread {
    /// Of some values, between which it interpolates; none of none.
    pub fn of(mut values: Vec<f64>) -> Option<Spread> {
        values.sort_by(f64::total_cmp);
        let last = values.len().checked_sub(1)?;
        let at = |share: f64| {
            let place = share * last as f64;
            let below = place.floor() as usize;
            values[below] + (values[(below + 1).min(last)] - values[below]) * place.fract()
        };
        Some(Spread { low: at(0.25), median: at(0.5), high: at(0.75) })
    }
}

/// The times of one variant, milliseconds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Timing {
    /// One a round.
    pub times: Vec<f64>,
    /// Fragment shader invocations of a frame, where they are counted.
    pub fragments: Option<u64>,
}

impl Timing {
    /// Median and quartiles.
    pub fn spread(&self) -> Option<Spread> {
        Spread::of(self.times.clone())
    }

    /// The least: what else runs on the machine makes a frame slower, never faster.
    pub fn least(&self) -> f64 {
        self.times.iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// The times far outside of the quartiles.
    pub fn outliers(&self) -> Vec<f64> {
        let Some(spread) = self.spread() else { return Vec::new() };
        let fence = FENCE * (spread.high - spread.low);
        let outside = |time: &f64| !(spread.low - fence..=spread.high + fence).contains(time);
        self.times.iter().copied().filter(outside).collect()
    }
}

struct Entry {
    name: String,
    renderer: Renderer,
    view: View,
    timing: Timing,
}

/// The variants that take turns.
#[derive(Default)]
pub struct Rounds {
    entries: Vec<Entry>,
    writes_surface: bool,
}

impl Rounds {
    /// Of frames that write surface data too. It makes all of them a little slower, but where they were measured before, no
    /// shader has to be compiled for the timing alone.
    pub fn writing_surface() -> Rounds {
        Rounds { writes_surface: true, ..Rounds::default() }
    }

    /// Lets a variant take part, once whatever the number of rows that it is in, and returns its place.
    pub fn add(
        &mut self,
        device: &mut Device,
        name: &str,
        scene: &Scene,
        settings: &Settings,
        view: &View,
    ) -> Result<usize> {
        if let Some(place) = self.entries.iter().position(|entry| entry.name == name) {
            return Ok(place);
        }
        let renderer =
            if self.writes_surface { device.measuring(scene, settings)? } else { device.renderer(scene, settings)? };
        Ok(self.enter(name, renderer, view))
    }

    /// Lets a renderer take part that was made before, and returns its place.
    pub fn enter(&mut self, name: &str, renderer: Renderer, view: &View) -> usize {
        self.entries.push(Entry { name: name.to_owned(), renderer, view: *view, timing: Timing::default() });
        self.entries.len() - 1
    }

    /// How many take part.
    pub fn len(&self) -> usize {
        self.entries.len()
    }

    /// Times every variant once a round, its second frame in turn: the first finds the caches full of another's data, a
    /// micro-mesh's above all, and a frame in a program follows one like it. `tick` is called after every timed frame, with
    /// the number of rounds done.
    pub fn run(&mut self, device: &mut Device, rounds: u32, tick: impl FnMut(u32)) -> Result<()> {
        self.take_turns(device, rounds, None, true, tick)
    }

    /// Times the first frame in turn, which costs half the time; and fewer rounds where time is up before: one that counts
    /// at least, after one that does not.
    pub fn run_until(
        &mut self,
        device: &mut Device,
        rounds: u32,
        end: Option<Instant>,
        tick: impl FnMut(u32),
    ) -> Result<()> {
        self.take_turns(device, rounds, end, false, tick)
    }

    fn take_turns(
        &mut self,
        device: &mut Device,
        rounds: u32,
        end: Option<Instant>,
        settles: bool,
        mut tick: impl FnMut(u32),
    ) -> Result<()> {
        let count = self.entries.len();
        let late = || end.is_some_and(|end| Instant::now() >= end);
        let (mut round, mut timed) = (0, 0);
        while timed < rounds && !(timed > 0 && late()) {
            let counts = round >= WARM_UP || round > 0 && late();
            for i in 0..count {
                // Each round begins with another one, so that what else the machine does meets them all.
                let entry = &mut self.entries[(i + round as usize) % count];
                if settles && counts {
                    device.time(&mut entry.renderer, &entry.view)?;
                }
                let Cost { ms, fragments } = device.time(&mut entry.renderer, &entry.view)?;
                if counts {
                    entry.timing.times.push(ms);
                    entry.timing.fragments = fragments;
                }
                tick(timed + u32::from(counts && i + 1 == count));
            }
            round += 1;
            timed += u32::from(counts);
        }
        Ok(())
    }

    /// A variant's times.
    pub fn timing(&self, place: usize) -> &Timing {
        &self.entries[place].timing
    }

    /// Bytes that a variant's baseline keeps on the CPU.
    pub fn host_bytes(&self, place: usize) -> u64 {
        self.entries[place].renderer.baseline_host_bytes()
    }

    /// How many times as long as `b` variant `a` took, round by round.
    pub fn ratio(&self, a: usize, b: usize) -> Option<Spread> {
        let pairs = self.timing(a).times.iter().zip(&self.timing(b).times);
        Spread::of(pairs.map(|(a, b)| a / b).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quartiles_are_interpolated() {
        let spread = Spread::of(vec![5.0, 1.0, 2.0, 4.0, 3.0]);
        assert_eq!(spread, Some(Spread { low: 2.0, median: 3.0, high: 4.0 }));
        assert_eq!(Spread::of(vec![1.0, 2.0]), Some(Spread { low: 1.25, median: 1.5, high: 1.75 }));
        assert_eq!(Spread::of(vec![]), None);
    }

    #[test]
    fn an_outlier_lies_beyond_the_fence() {
        let timing = Timing { times: vec![10.0, 11.0, 12.0, 13.0, 30.0], fragments: None };
        assert_eq!(timing.outliers(), [30.0]);
        assert_eq!(timing.least(), 10.0);
        let calm = Timing { times: vec![10.0, 11.0, 12.0, 13.0, 16.0], ..timing };
        assert!(calm.outliers().is_empty());
    }
}
