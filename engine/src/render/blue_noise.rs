//! Blue noise for dithering: ranks whose every threshold gives evenly spread pixels, made by void-and-cluster (Ulichney
//! 1993, "The void-and-cluster method for dither array generation"). Made when something asks for it: no image is kept.

/// Texels a side; it tiles.
pub const SIDE: usize = 64;
const TEXELS: usize = SIDE * SIDE;
/// Of the Gaussian that says how near is near, in texels; the paper's.
const SIGMA: f32 = 1.5;

/// Row by row, each value equally often.
pub fn texels() -> Vec<u8> {
    ranks().into_iter().map(|rank| (rank * 256 / TEXELS) as u8).collect()
}

/// A pattern of points and, at every texel, how crowded it is by them.
struct Pattern {
    points: Vec<bool>,
    crowd: Vec<f32>,
    /// What a point adds at so many texels right and down of it, around the torus.
    reach: Vec<f32>,
}

impl Pattern {
    fn new() -> Pattern {
        let squared = |i: usize| (i.min(SIDE - i) * i.min(SIDE - i)) as f32;
        let reach = (0..TEXELS).map(|i| (-(squared(i % SIDE) + squared(i / SIDE)) / (2.0 * SIGMA * SIGMA)).exp());
        Pattern { points: vec![false; TEXELS], crowd: vec![0.0; TEXELS], reach: reach.collect() }
    }

    fn toggle(&mut self, at: usize) {
        self.points[at] = !self.points[at];
        let sign = if self.points[at] { 1.0 } else { -1.0 };
        let (x, y) = (at % SIDE, at / SIDE);
        for row in 0..SIDE {
            let reach = &self.reach[(row + SIDE - y) % SIDE * SIDE..][..SIDE];
            for column in 0..SIDE {
                self.crowd[row * SIDE + column] += sign * reach[(column + SIDE - x) % SIDE];
            }
        }
    }

    /// The point that is crowded most.
    fn cluster(&self) -> usize {
        let points = (0..TEXELS).filter(|i| self.points[*i]);
        points.max_by(|a, b| self.crowd[*a].total_cmp(&self.crowd[*b])).unwrap_or(0)
    }

    /// The free texel that is crowded least.
    fn void(&self) -> usize {
        let free = (0..TEXELS).filter(|i| !self.points[*i]);
        free.min_by(|a, b| self.crowd[*a].total_cmp(&self.crowd[*b])).unwrap_or(0)
    }
}

fn ranks() -> Vec<usize> {
    let mut start = Pattern::new();
    let mut dice = 1u32;
    let first = TEXELS / 10;
    for _ in 0..first {
        dice = dice.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let at = (dice >> 20) as usize % TEXELS;
        if !start.points[at] {
            start.toggle(at);
        }
    }
    // Points move from clusters to voids until the one that moves comes back.
    loop {
        let cluster = start.cluster();
        start.toggle(cluster);
        let void = start.void();
        start.toggle(void);
        if void == cluster {
            break;
        }
    }
    let count = start.points.iter().filter(|point| **point).count();
    let mut ranks = vec![0; TEXELS];
    let mut thinned = Pattern { points: start.points.clone(), crowd: start.crowd.clone(), reach: start.reach.clone() };
    for rank in (0..count).rev() {
        let cluster = thinned.cluster();
        thinned.toggle(cluster);
        ranks[cluster] = rank;
    }
    // The tightest cluster of free texels is the largest void of points: both are where points are farthest.
    for rank in count..TEXELS {
        let void = start.void();
        start.toggle(void);
        ranks[void] = rank;
    }
    ranks
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranks_are_evenly_spread_at_every_threshold() {
        let ranks = ranks();
        let mut sorted = ranks.clone();
        sorted.sort_unstable();
        assert!(sorted.into_iter().eq(0..TEXELS), "a permutation");
        for below in [64, 256, 1024] {
            let points: Vec<usize> = (0..TEXELS).filter(|i| ranks[*i] < below).collect();
            let apart = |a: usize, b: usize| {
                let axis = |d: usize| (d.min(SIDE - d) * d.min(SIDE - d)) as f64;
                (axis((a % SIDE).abs_diff(b % SIDE)) + axis((a / SIDE).abs_diff(b / SIDE))).sqrt()
            };
            let nearest = |a: &usize| points.iter().filter(|b| *b != a).map(|b| apart(*a, *b)).fold(f64::MAX, f64::min);
            let mean = points.iter().map(nearest).sum::<f64>() / below as f64;
            // Of points at random it is half the square root of the area of each; of a square grid all of it.
            let area = (TEXELS as f64 / below as f64).sqrt();
            println!("{below} points: nearest {:.2} of the grid's", mean / area);
            assert!(mean > 0.7 * area, "{below}: {mean} of {area}");
        }
    }
}
