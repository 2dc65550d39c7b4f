//! Cobbles: a paraboloid for each stone, the highest one counts, over a flat bed.

use glam::DVec2;

use super::{fraction, scrambled};

/// Stones per UV unit along both axes.
const COUNT: f64 = 8.0;
/// A stone's middle stands this far from its cell's low border, at least and how much farther.
const PLACE: [f64; 2] = [0.25, 0.5];
/// Height of its middle: at least, and how much more.
const TOP: [f64; 2] = [0.75, 0.25];
/// How much lower it is one cell away. A stone so reaches less than 0.71 of a cell, and any stone that is two cells
/// from a point's own is 1.25 away.
const DROP: f64 = 2.0;

/// One stone: its middle in cells, and the height there.
fn stone(cell: DVec2) -> (DVec2, f64) {
    let id = cell.rem_euclid(DVec2::splat(COUNT));
    let random = scrambled((id.y * COUNT + id.x) as u32);
    let place = DVec2::new(fraction(random, 0), fraction(random, 10));
    (cell + PLACE[0] + PLACE[1] * place, TOP[0] + TOP[1] * fraction(random, 20))
}

/// The stones of the cells from one to another, both included.
fn stones(first: DVec2, last: DVec2) -> impl Iterator<Item = (DVec2, f64)> {
    let count = (last - first + 1.0).as_uvec2();
    (0..count.y).flat_map(move |y| (0..count.x).map(move |x| stone(first + DVec2::new(x.into(), y.into()))))
}

pub(super) fn height_and_gradient(uv: DVec2) -> (f64, DVec2) {
    let at = uv * COUNT;
    let cell = at.floor();
    let (mut height, mut gradient) = (0.0, DVec2::ZERO);
    for (middle, top) in stones(cell - 1.0, cell + 1.0) {
        let h = top - DROP * at.distance_squared(middle);
        if h > height {
            (height, gradient) = (h, 2.0 * DROP * COUNT * (middle - at));
        }
    }
    (height, gradient)
}

pub(super) fn bounds(low: DVec2, high: DVec2) -> [f64; 2] {
    let (low, high) = (low * COUNT, high * COUNT);
    let (mut least, mut greatest) = (0.0f64, 0.0f64);
    for (middle, top) in stones(low.floor() - 1.0, high.floor() + 1.0) {
        let nearest = (low - middle).max(middle - high).max(DVec2::ZERO);
        let farthest = (low - middle).abs().max((high - middle).abs());
        least = least.max(top - DROP * farthest.length_squared());
        greatest = greatest.max(top - DROP * nearest.length_squared());
    }
    [least, greatest]
}
