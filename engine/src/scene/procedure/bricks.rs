//! Bricks in running bond. A brick's own coordinates are in courses from its middle, 3 by 1.

use glam::DVec2;

use super::{fraction, scrambled};

/// Bricks in a course and courses, per UV unit.
const COUNT: DVec2 = DVec2::new(4.0, 8.0);
/// A brick's extent with its share of the joints.
const SIZE: DVec2 = DVec2::new(3.0, 1.0);
/// Half of a joint's width.
const JOINT: f64 = 0.0625;
/// Width of the bevel.
const BEVEL: f64 = 0.125;
/// Height of the middle of a brick: at least, and how much more.
const CROWN: [f64; 2] = [0.84, 0.11];
/// Steepest tilt of a brick's face along u and v, per course.
const TILT: DVec2 = DVec2::new(0.02, 0.04);

/// One brick's face: height in the middle and slopes.
struct Face {
    middle: f64,
    tilt: DVec2,
}

fn face(cell: DVec2) -> Face {
    let id = cell.rem_euclid(COUNT);
    let random = scrambled((id.y * COUNT.x + id.x) as u32);
    let tilt = DVec2::new(fraction(random, 10), fraction(random, 20)) * 2.0 - 1.0;
    Face { middle: CROWN[0] + CROWN[1] * fraction(random, 0), tilt: TILT * tilt }
}

/// In bricks and courses; every other course is moved by half a brick.
fn bond(uv: DVec2) -> DVec2 {
    let at = uv * COUNT;
    DVec2::new(at.x + 0.5 * at.y.floor().rem_euclid(2.0), at.y)
}

/// How far a point is into the bevel, per axis, from its distances to the brick's middle.
fn into_bevel(away: DVec2) -> DVec2 {
    (away - (0.5 * SIZE - JOINT - BEVEL)).max(DVec2::ZERO)
}

/// Share of the face's height after the bevel: 1 on the face, 0 in the joint.
fn share(away: DVec2) -> f64 {
    let s = (1.0 - into_bevel(away).length() / BEVEL).clamp(0.0, 1.0);
    s * s * (3.0 - 2.0 * s)
}

pub(super) fn height_and_gradient(uv: DVec2) -> (f64, DVec2) {
    let at = bond(uv);
    let cell = at.floor();
    let local = (at - cell - 0.5) * SIZE;
    let face = face(cell);
    let crown = face.middle + face.tilt.dot(local);
    let bevel = into_bevel(local.abs());
    let depth = bevel.length();
    let s = (1.0 - depth / BEVEL).clamp(0.0, 1.0);
    let profile = s * s * (3.0 - 2.0 * s);
    let mut slope = profile * face.tilt;
    if depth > 0.0 {
        slope -= crown * 6.0 * s * (1.0 - s) / (BEVEL * depth) * bevel * local.signum();
    }
    (profile * crown, slope * SIZE * COUNT)
}

/// Least and greatest distance from the nearest middle of a cell, in cells, for coordinates from `a` to `b`.
fn spread(a: f64, b: f64) -> [f64; 2] {
    if b - a >= 1.0 {
        return [0.0, 0.5];
    }
    // From the middle of the first one's cell.
    let from = a - a.floor() - 0.5;
    let to = b - a.floor() - 0.5;
    if to <= 0.5 {
        return [from.max(-to).max(0.0), from.abs().max(to.abs())];
    }
    [from.min(1.0 - to).max(0.0), 0.5]
}

pub(super) fn bounds(low: DVec2, high: DVec2) -> [f64; 2] {
    let one_course = (low.y * COUNT.y).floor() == (high.y * COUNT.y).floor();
    let (a, b) = (bond(low), bond(high));
    let across = if one_course { spread(a.x, b.x) } else { [0.0, 0.5] };
    let along = spread(a.y, b.y);
    let [near, far] = [0, 1].map(|i| DVec2::new(across[i], along[i]) * SIZE);
    let most = 0.5 * TILT.dot(SIZE);
    let mut crown = [CROWN[0] - most, CROWN[0] + CROWN[1] + most];
    if one_course && a.x.floor() == b.x.floor() {
        let face = face(a.floor());
        let middle = (0.5 * (a + b) - a.floor() - 0.5) * SIZE;
        let room = face.tilt.abs().dot(0.5 * (b - a) * SIZE);
        let height = face.middle + face.tilt.dot(middle);
        crown = [height - room, height + room];
    }
    [share(far) * crown[0], share(near) * crown[1]]
}
