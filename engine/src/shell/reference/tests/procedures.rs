//! Procedural heights on a flat square, where a ray is straight in texture space.

use glam::DVec2;

use super::*;

fn procedural(procedure: Procedure, scale: f64) -> Reference {
    let displacement = Displacement { source: HeightSource::Procedure(procedure), ..displacement(scale, 0.0) };
    Reference::new(&scene(square(), Some(displacement), map(1, 1, |_, _| 0.0)))
}

/// UV of a point of the square.
fn uv(point: DVec3) -> DVec2 {
    (point.truncate() + 1.0) / 2.0
}

/// Where a ray enters `{ z < top - bend |xy - middle|² }`, as a share of `way`.
fn into_paraboloid(middle: DVec2, top: f64, bend: f64, origin: DVec3, way: DVec3) -> Option<f64> {
    // bend |o + s w - m|² + z(s) - top = a s² + 2 b s + c, negative inside.
    let from = origin.truncate() - middle;
    let a = bend * way.truncate().length_squared();
    let b = bend * from.dot(way.truncate()) + 0.5 * way.z;
    let c = bend * from.length_squared() + origin.z - top;
    let discriminant = b * b - a * c;
    (discriminant > 0.0).then(|| (-b - discriminant.sqrt()) / a)
}

/// Cobbles are paraboloids over a plane: the first of their roots, a quadratic each, is the hit.
#[test]
fn cobbles_are_hit_where_the_closed_form_says() {
    const SCALE: f64 = 0.1;
    // 2 less for each cell, an eighth of a UV unit or a quarter of a mesh unit, squared.
    const BEND: f64 = 2.0 * 16.0 * SCALE;
    let procedure = Procedure::Cobbles;
    // Each stone from a height and a slope of it: z = top - BEND |xy - middle|².
    let mut stones: Vec<(DVec2, f64)> = Vec::new();
    for (i, j) in (0..=240).flat_map(|i| (0..=240).map(move |j| (i, j))) {
        let at = DVec2::new(f64::from(i), f64::from(j)) / 100.0 - 1.2;
        let uv = (at + 1.0) / 2.0;
        let height = procedure.height(uv);
        if height > 0.0 {
            let away = -procedure.gradient(uv) / 2.0 * SCALE / (2.0 * BEND);
            let (middle, top) = (at - away, SCALE * height + BEND * away.length_squared());
            if stones.iter().all(|(known, _)| known.distance(middle) > 1e-9) {
                stones.push((middle, top));
            }
        }
    }
    assert!((64..=144).contains(&stones.len()), "{}", stones.len());

    let reference = procedural(procedure, SCALE);
    let mut random = Random(5);
    let (mut stone_hits, mut bed_hits) = (0, 0);
    for _ in 0..3000 {
        let target = DVec3::new(random.within(-0.6, 0.6), random.within(-0.6, 0.6), 0.5 * SCALE);
        let mut way = random.direction();
        // Half of the rays at a flat angle.
        way.z = -way.z.abs().max(0.01) * if random.next() < 0.5 { 0.1 } else { 1.0 };
        // From the level of the highest stones.
        let origin = target - way * (0.5 * SCALE / -way.z);
        let bed = origin.z / -way.z;
        let stones = stones.iter().filter_map(|(middle, top)| into_paraboloid(*middle, *top, BEND, origin, way));
        let expected = stones.filter(|s| *s > 0.0).fold(bed, f64::min);
        let point = origin + expected * way;
        if origin.abs().max_element() > 0.99 || point.abs().max_element() > 0.99 {
            continue;
        }
        let hit = reference.trace(origin, way, 0.0).expect("the closed form hits");
        assert!((hit.distance - expected).abs() * -way.z < 1e-11, "{hit:?}, {expected}");
        if expected < bed {
            stone_hits += 1;
        } else {
            bed_hits += 1;
            assert!(hit.normal.distance(DVec3::Z) < 1e-12 && hit.height.abs() < 1e-10, "{hit:?}");
        }
    }
    assert!(stone_hits > 1000 && bed_hits > 20, "{stone_hits} {bed_hits}");
}

/// A graze of a paraboloid's top by a hair: below it is hit, above it is passed, however small the hair.
#[test]
fn a_ray_a_hair_below_a_stone_s_top_hits_it() {
    const SCALE: f64 = 0.1;
    const BEND: f64 = 2.0 * 16.0 * SCALE;
    let reference = procedural(Procedure::Cobbles, SCALE);
    // The top nearest to the square's middle.
    let mut at = DVec2::ZERO;
    for _ in 0..50 {
        at += Procedure::Cobbles.gradient((at + 1.0) / 2.0) / 2.0 * SCALE / (2.0 * BEND);
    }
    let top = SCALE * Procedure::Cobbles.height((at + 1.0) / 2.0);
    for hair in [1e-3, 1e-5, 1e-7, 1e-9, 1e-11] {
        // From so near that no other stone is in the way.
        let reach = 0.06;
        let ray =
            |z: f64| reference.trace((at - reach * DVec2::X).extend(z), DVec3::X, 0.0).filter(|h| h.distance < 0.12);
        let hit = ray(top - hair * SCALE).expect("the top");
        let expected = reach - (hair * SCALE / BEND).sqrt();
        assert!((hit.distance - expected).abs() < 1e-5 * hair.sqrt() + 1e-9, "{hair}: {} {expected}", hit.distance);
        assert!(ray(top + hair * SCALE).is_none(), "{hair}");
    }
}

#[test]
fn rays_straight_down_read_the_height_and_its_normal() {
    let mut random = Random(6);
    for procedure in Procedure::ALL {
        let reference = procedural(procedure, 0.3);
        for _ in 0..500 {
            let above = DVec3::new(random.within(-0.99, 0.99), random.within(-0.99, 0.99), 1.0);
            let hit = reference.trace(above, -DVec3::Z, 0.0).expect("the square");
            let height = procedure.height(uv(above));
            assert!((hit.position.z - 0.3 * height).abs() < 1e-11 && (hit.height - height).abs() < 1e-10);
            let slope = procedure.gradient(uv(above)) / 2.0 * 0.3;
            let normal = (-slope).extend(1.0).normalize();
            assert!(hit.normal.distance(normal) < 1e-9, "{procedure:?} {above}: {} {normal}", hit.normal);
        }
    }
}
