//! The tracer against the same surface as a dense mesh of plain triangles.

use super::*;

/// `mesh` cut into n² triangles each, moved onto the displaced surface: its position and nothing else.
fn tessellated(coarse: &Scene, n: u32) -> Scene {
    let reference = Reference::new(coarse);
    let surface = &reference.surfaces[0];
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for facet in &surface.facets {
        let first = positions.len() as u32;
        let id = |i: u32, j: u32| first + i * (i + 1) / 2 + j;
        for i in 0..=n {
            for j in 0..=i {
                let (a, b) = (f64::from(i - j) / f64::from(n), f64::from(j) / f64::from(n));
                let lambda = [1.0 - a - b, a, b];
                positions.push(facet.point(lambda, facet.surface_t(&reference.fields, lambda).0).as_vec3());
            }
        }
        for i in 0..n {
            for j in 0..=i {
                triangles.push([id(i, j), id(i + 1, j), id(i + 1, j + 1)]);
                if j < i {
                    triangles.push([id(i, j), id(i + 1, j + 1), id(i, j + 1)]);
                }
            }
        }
    }
    let count = positions.len();
    scene(mesh(positions, vec![Vec3::Z; count], vec![Vec2::ZERO; count], triangles), None, map(1, 1, |_, _| 0.0))
}

#[test]
fn a_dense_mesh_converges_to_the_surface_with_order_two() {
    // Texels much larger than the micro-triangles; bilinear patches are smooth but for their borders.
    let coarse = scene(torus(12, 8), Some(displacement(0.12, 0.5)), waves(24));
    let reference = Reference::new(&coarse);
    let mut random = Random(17);
    let rays: Vec<(DVec3, DVec3)> = (0..4000)
        .map(|_| {
            let origin = random.direction() * 3.0;
            (origin, random.direction() * 1.2 - origin)
        })
        .collect();
    let exact: Vec<_> = rays.iter().map(|(o, d)| reference.trace(*o, *d, 0.0)).collect();
    let mut errors = Vec::new();
    let mut coverage = Vec::new();
    for n in [8, 16, 32] {
        let dense = Reference::new(&tessellated(&coarse, n));
        let mut found = Vec::new();
        let mut differs = 0;
        for ((o, d), exact) in rays.iter().zip(&exact) {
            match (dense.trace(*o, *d, 0.0), exact) {
                (Some(a), Some(b)) => found.push(a.position.distance(b.position)),
                (None, None) => {}
                _ => differs += 1,
            }
        }
        found.sort_by(f64::total_cmp);
        errors.push(found[found.len() / 2]);
        coverage.push(differs);
    }
    let orders = [errors[0] / errors[1], errors[1] / errors[2]].map(f64::log2);
    println!("median error {errors:.7?}, order {orders:.2?}, covered in one only {coverage:?} of {}", rays.len());
    assert!(orders.iter().all(|order| (1.7..2.3).contains(order)), "{orders:?}");
    assert!(coverage[2] <= 8 && errors[2] < 1e-4, "{coverage:?} {errors:?}");
}

#[test]
fn normals_are_the_surfaces_own_finite_differences() {
    let scene = scene(torus(12, 8), Some(displacement(0.12, 0.5)), waves(24));
    let reference = Reference::new(&scene);
    let (surface, mut random) = (&reference.surfaces[0], Random(23));
    for _ in 0..2000 {
        let facet = &surface.facets[random.within(0.0, surface.facets.len() as f64) as usize];
        let (a, b) = (random.within(0.01, 0.49), random.within(0.01, 0.49));
        let point = |a: f64, b: f64| {
            let lambda = [1.0 - a - b, a, b];
            facet.point(lambda, facet.surface_t(&reference.fields, lambda).0)
        };
        let (t, slope) = facet.surface_t(&reference.fields, [1.0 - a - b, a, b]);
        let step = 1e-6;
        let cross = |s: f64| (point(a + s, b) - point(a, b)).cross(point(a, b + s) - point(a, b)).normalize();
        let closed = facet.normal([1.0 - a - b, a, b], t, slope).normalize();
        // One of the two one-sided differences stays in the cell.
        let error = cross(step).distance(closed).min(cross(-step).distance(closed));
        assert!(error < 1e-4, "{error}");
    }
}
