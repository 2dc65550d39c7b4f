//! One ray against one wall: the part of an edge's ruled surface between the two heights that meet there.

use super::{
    bezier::quadratic_roots,
    height::HeightField,
    prism::{Accept, Found, OVERLAP, Ray},
    surface::{Facet, Outer, Side, Wall},
};

/// A step below this share of the height range is rounding: the hit is on the surface that begins there.
const STEP: f64 = 1e-6;

/// The first hit of a ray with a wall. A wall faces its lower side; from the higher one it is met from behind.
pub(super) fn hit(
    ray: &Ray,
    facets: &[Facet],
    wall: &Wall,
    fields: &[HeightField],
    mut accept: Accept,
) -> Option<Found> {
    let [lo, hi] = wall.t_range;
    let p = wall.positions.map(|p| ray.project(p));
    let q = wall.lifts.map(|n| ray.project_vector(n));
    let (a, b) = ([p[0] + lo * q[0], p[1] + lo * q[1]], [p[0] + hi * q[0], p[1] + hi * q[1]]);
    let s = [a[0].perp_dot(a[1]), 0.5 * (a[0].perp_dot(b[1]) + b[0].perp_dot(a[1])), b[0].perp_dot(b[1])];
    let mut best = None;
    for root in quadratic_roots(s) {
        if let Some(found) = crossing(ray, facets, wall, fields, accept, lo + (hi - lo) * root) {
            accept.range[1] = found.distance;
            best = Some(found);
        }
    }
    best
}

/// The wall's edge on level t passes the ray; whether that point lies on the wall and counts.
fn crossing(ray: &Ray, facets: &[Facet], wall: &Wall, fields: &[HeightField], accept: Accept, t: f64) -> Option<Found> {
    let ends = [0, 1].map(|k| wall.positions[k] + t * wall.lifts[k]);
    let [a, b] = ends.map(|x| ray.project(x));
    let along = -a.dot(b - a) / (b - a).length_squared();
    // NaN where the ray runs along the edge: it does not cross the wall then.
    if !(-OVERLAP..=1.0 + OVERLAP).contains(&along) {
        return None;
    }
    let lambda = |side: Side| {
        let mut lambda = [0.0; 3];
        (lambda[side.corners[0]], lambda[side.corners[1]]) = (1.0 - along, along);
        lambda
    };
    let surface = |side: Side| facets[side.facet].surface_t(fields, lambda(side));
    let inner = surface(wall.inner).0;
    let outer = match wall.outer {
        Outer::Neighbour(side) => surface(side).0,
        Outer::Floor(t) => t,
    };
    if t < inner.min(outer) || t > inner.max(outer) {
        return None;
    }
    let lift = wall.lifts[0] * (1.0 - along) + wall.lifts[1] * along;
    // The edge runs counter-clockwise around the inner facet, so this points away from it.
    let outward = (ends[1] - ends[0]).cross(lift);
    let leaves = ray.direction.dot(outward) > 0.0;
    let higher = wall.outer.neighbour().filter(|_| outer > inner).unwrap_or(wall.inner);
    let rises = (outer > inner) == leaves;
    let distance = ray.distance(ends[0].lerp(ends[1], along));
    if !accept.takes(distance, rises, facets[higher.facet].double_sided) {
        return None;
    }
    // A plain surface has no prism to enter: coordinates and height on its steps are its neighbour's.
    let displaced = |side: &Side| facets[side.facet].relief.is_some();
    let entered = match wall.outer.neighbour() {
        Some(side) if displaced(&side) && (leaves || !displaced(&wall.inner)) => side,
        _ => wall.inner,
    };
    let facet = &facets[entered.facet];
    let on_wall = (inner - outer).abs() > STEP * (wall.t_range[1] - wall.t_range[0]);
    let normal = if !on_wall {
        facet.normal(lambda(entered), t, surface(entered).1)
    } else if outer > inner {
        -outward
    } else {
        outward
    };
    Some(Found { distance, facet: entered.facet, lambda: lambda(entered), t, normal, on_wall })
}
