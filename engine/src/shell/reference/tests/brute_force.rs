//! The tracer against a method that shares nothing with it: small steps along the ray's distance, each inverted
//! through the shell map by Newton's iteration, on rough maps and strongly curved prisms.

use glam::DMat3;

use super::{
    super::{Accept, Ray, height::HeightField, prism, surface::Facet},
    *,
};

const STEPS: u32 = 4000;

/// λ1, λ2, t of a point, from a start nearby; `None` where the iteration does not settle.
fn inverted(facet: &Facet, point: DVec3, start: DVec3) -> Option<DVec3> {
    let mut at = start;
    for _ in 0..30 {
        let lambda = [1.0 - at.x - at.y, at.x, at.y];
        let level: [DVec3; 3] = std::array::from_fn(|k| facet.positions[k] + at.z * facet.lifts[k]);
        let lift = (0..3).map(|k| lambda[k] * facet.lifts[k]).sum();
        let jacobian = DMat3::from_cols(level[1] - level[0], level[2] - level[0], lift);
        let step = jacobian.inverse() * (point - facet.point(lambda, at.z));
        at += step;
        if step.abs().max_element() < 1e-13 {
            return at.is_finite().then_some(at);
        }
    }
    None
}

/// Height above the displaced surface, or `None` outside the prism (shrunk by `margin`).
fn above(facet: &Facet, fields: &[HeightField], at: DVec3, margin: f64) -> Option<f64> {
    let lambda = [1.0 - at.x - at.y, at.x, at.y];
    let [lo, hi] = facet.relief.expect("displaced").t_range;
    let inside = lambda.iter().all(|l| *l > margin) && at.z > lo && at.z < hi;
    inside.then(|| at.z - facet.surface_t(fields, lambda).0)
}

/// Distance before the first crossing from above to below that a small step sees.
fn stepped(facet: &Facet, fields: &[HeightField], origin: DVec3, direction: DVec3) -> Option<f64> {
    let (mut last, mut start) = (None, DVec3::new(0.3, 0.3, 0.0));
    for i in 0..=STEPS {
        let distance = f64::from(i) / f64::from(STEPS);
        let solved = inverted(facet, origin + distance * direction, start);
        start = solved.unwrap_or(DVec3::new(0.3, 0.3, 0.0));
        let height = solved.and_then(|at| above(facet, fields, at, 1e-7));
        if let (Some(before), Some(now)) = (last, height)
            && before > 0.0
            && now < 0.0
        {
            return Some(distance);
        }
        last = height;
    }
    None
}

/// A triangle with unit shell normals that lean apart, on a rough map, not folded.
fn curved_prism(random: &mut Random) -> Scene {
    loop {
        let positions = vec![
            Vec3::ZERO,
            Vec3::new(1.0, random.within(-0.2, 0.2) as f32, 0.0),
            Vec3::new(random.within(0.0, 0.8) as f32, 0.9, 0.0),
        ];
        let normals = (0..3).map(|_| (DVec3::Z + 0.7 * random.direction()).normalize().as_vec3()).collect();
        let tiles = random.within(0.3, 2.5) as f32;
        let uvs = positions.iter().map(|p| (p.truncate() + 0.1) * tiles).collect();
        let seed = random.within(0.0, 1e6) as u32;
        let rough = map(8, 8, |x, y| f64::from((x * 7 + y * 31 + seed).wrapping_mul(2654435761) >> 16) / 65535.0);
        let scene = scene(mesh(positions, normals, uvs, vec![[0, 1, 2]]), Some(displacement(0.3, 0.4)), rough);
        let facet = Reference::new(&scene).surfaces[0].facets[0];
        if facet.relief.is_some() && facet.lifts.iter().all(|l| (l.length() - 1.0).abs() < 1e-9) {
            return scene;
        }
    }
}

/// Compares both methods on one ray; returns whether there was a hit.
fn compare(reference: &Reference, origin: DVec3, direction: DVec3) -> bool {
    let (facet, fields) = (&reference.surfaces[0].facets[0], &reference.fields);
    let accept = Accept { range: [0.0, 1.0], both_sides: false };
    let exact = prism::hit(&Ray::new(origin, direction), &reference.surfaces[0].facets, 0, fields, accept);
    let steps = stepped(facet, fields, origin, direction);
    if let Some(found) = exact {
        // No ghost: the point is on the ray and on the surface.
        let point = facet.point(found.lambda, found.t);
        assert!(point.distance(origin + found.distance * direction) < 1e-7, "off the ray");
        assert!((found.t - facet.surface_t(fields, found.lambda).0).abs() < 1e-7, "off the surface");
        assert!(found.lambda.iter().all(|l| *l > -1e-8) && direction.dot(found.normal) < 1e-6);
    }
    // No miss: what the steps see is not nearer than what was found.
    let Some(steps) = steps else { return exact.is_some() };
    assert!(exact.is_some_and(|found| found.distance <= steps + 1e-9), "{exact:?} {steps} {origin} {direction}");
    true
}

#[test]
fn rough_curved_prisms_hide_no_crossing_and_invent_none() {
    let mut random = Random(41);
    let mut hits = 0;
    for _ in 0..60 {
        let scene = curved_prism(&mut random);
        let reference = Reference::new(&scene);
        let facet = reference.surfaces[0].facets[0];
        for _ in 0..10 {
            let a = random.within(0.05, 0.9);
            let through = facet.point([1.0 - a, 0.7 * a, 0.3 * a], random.within(-0.1, 0.16));
            let mut way = random.direction();
            way.z *= random.next().powi(2);
            hits += u32::from(compare(&reference, through - way, 2.0 * way));
        }
    }
    assert!(hits > 200, "{hits}");
}

#[test]
fn rays_along_a_level_of_a_curved_prism_are_exact_at_every_tilt() {
    let mut random = Random(43);
    let mut hits = 0;
    for tilt in [0.0, 1e-15, 1e-13, 1e-11, 1e-9, 3e-9, 1e-8, 1e-7, 1e-5] {
        for _ in 0..40 {
            let scene = curved_prism(&mut random);
            let reference = Reference::new(&scene);
            let facet = reference.surfaces[0].facets[0];
            let t = random.within(-0.1, 0.16);
            let a = facet.point([0.8, 0.1, 0.1], t);
            let beside = random.within(0.1, 0.7);
            let b = facet.point([0.8 - beside, beside, 0.2], t + tilt * random.within(-1.0, 1.0));
            hits += u32::from(compare(&reference, a - 2.0 * (b - a), 5.0 * (b - a)));
        }
    }
    assert!(hits > 100, "{hits}");
}

#[test]
fn procedures_on_curved_prisms_hide_no_crossing_and_invent_none() {
    let mut random = Random(47);
    for procedure in Procedure::ALL {
        let mut hits = 0;
        for _ in 0..20 {
            let mut scene = curved_prism(&mut random);
            let displacement = scene.materials[0].displacement.as_mut().expect("displaced");
            displacement.source = HeightSource::Procedure(procedure);
            let reference = Reference::new(&scene);
            let facet = reference.surfaces[0].facets[0];
            for _ in 0..10 {
                let a = random.within(0.05, 0.9);
                let through = facet.point([1.0 - a, 0.7 * a, 0.3 * a], random.within(-0.1, 0.16));
                let mut way = random.direction();
                way.z *= random.next().powi(2);
                hits += u32::from(compare(&reference, through - way, 2.0 * way));
            }
        }
        assert!(hits > 60, "{procedure:?}: {hits}");
    }
}
