//! Fair timing: all variants take turns in one process, and what is compared was measured in the same round.

use prism_engine::{
    error::Result,
    render::Renderer,
    scene::{Camera, Scene},
    settings::Settings,
};

use super::device::Device;

/// Untimed frames first: lavapipe compiles at the first draw, and caches fill.
const WARM_UP: u32 = 2;

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

struct Entry {
    name: String,
    renderer: Renderer,
    times: Vec<f64>,
}

/// The variants that take turns.
pub struct Rounds {
    camera: Camera,
    entries: Vec<Entry>,
}

impl Rounds {
    /// None yet.
    pub fn new(camera: Camera) -> Self {
        Rounds { camera, entries: Vec::new() }
    }

    /// Lets a variant take part, once whatever the number of rows that it is in, and returns its place.
    pub fn add(&mut self, device: &Device, name: &str, scene: &Scene, settings: &Settings) -> Result<usize> {
        if let Some(place) = self.entries.iter().position(|entry| entry.name == name) {
            return Ok(place);
        }
        let renderer = device.renderer(scene, settings)?;
        self.entries.push(Entry { name: name.to_owned(), renderer, times: Vec::new() });
        Ok(self.entries.len() - 1)
    }

    /// How many take part.
    pub fn len(&self) -> usize {
        self.entries.len()
    }

    /// Times every variant once a round; `tick` is called with the number of rounds done.
    pub fn run(&mut self, device: &mut Device, rounds: u32, tick: impl Fn(u32)) -> Result<()> {
        let count = self.entries.len();
        for round in 0..WARM_UP + rounds {
            for i in 0..count {
                // Each round begins with another one, so that nobody always follows the same neighbour.
                let entry = &mut self.entries[(i + round as usize) % count];
                let time = device.time(&mut entry.renderer, &self.camera)?;
                if round >= WARM_UP {
                    entry.times.push(time);
                }
            }
            tick((round + 1).saturating_sub(WARM_UP));
        }
        Ok(())
    }

    /// A variant's times, milliseconds.
    pub fn spread(&self, place: usize) -> Option<Spread> {
        Spread::of(self.entries[place].times.clone())
    }

    /// A variant's least time, milliseconds.
    pub fn least(&self, place: usize) -> f64 {
        self.entries[place].times.iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// How many times as long as `b` variant `a` took, round by round.
    pub fn ratio(&self, a: usize, b: usize) -> Option<Spread> {
        let pairs = self.entries[a].times.iter().zip(&self.entries[b].times);
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
}
