//! No ray slips through a closed surface, and neighbours agree.

use super::*;

#[test]
fn no_ray_into_a_closed_torus_misses_it() {
    let scene = scene(torus(24, 12), Some(displacement(0.15, 0.5)), waves(64));
    let reference = Reference::new(&scene);
    let surface = &reference.surfaces[0];
    let mut random = Random(31);
    for n in 0..20_000 {
        // A point on the core circle is inside whatever the height; every third ray aims at a shared edge or vertex.
        let facet = &surface.facets[random.within(0.0, surface.facets.len() as f64) as usize];
        let along = if n % 3 == 0 { (random.next() * 2.0).floor() } else { random.next() };
        let t = random.within(-0.07, 0.07);
        let edge = facet.point([1.0 - along, along, 0.0], t);
        let angle = edge.y.atan2(edge.x);
        let core = DVec3::new(angle.cos(), angle.sin(), 0.0);
        let origin = core + (edge - core) * 20.0;
        let hit = reference.trace(origin, core - origin, 0.0).expect("the torus is closed");
        assert!(hit.distance < 1.0);
        assert!(reference.blocked(core, random.direction(), [0.0, f64::INFINITY]), "a ray out of the core is blocked");
    }
}

#[test]
fn walls_close_a_torus_whose_every_triangle_has_its_own_uv() {
    let whole = torus(16, 10).primitives.remove(0);
    let mut random = Random(53);
    let corners: Vec<usize> = whole.triangles.iter().flatten().map(|v| *v as usize).collect();
    let uvs = (0..corners.len()).map(|_| Vec2::new(random.next() as f32, random.next() as f32)).collect();
    let triangles = (0..whole.triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let own = mesh(
        corners.iter().map(|v| whole.positions[*v]).collect(),
        corners.iter().map(|v| whole.normals[*v]).collect(),
        uvs,
        triangles,
    );
    let reference = Reference::new(&scene(own, Some(displacement(0.2, 0.5)), waves(16)));
    let surface = &reference.surfaces[0];
    assert_eq!(surface.walls.len(), 3 * whole.triangles.len() / 2);
    let mut on_walls = 0;
    for n in 0..30_000 {
        let facet = &surface.facets[random.within(0.0, surface.facets.len() as f64) as usize];
        let along = if n % 5 == 0 { (random.next() * 2.0).floor() } else { random.next() };
        let edge = facet.point([1.0 - along, along, 0.0], random.within(-0.1, 0.1));
        let angle = edge.y.atan2(edge.x);
        let core = DVec3::new(angle.cos(), angle.sin(), 0.0);
        // From outside at a slant, past the edge, into the core.
        let origin = edge + (edge - core).normalize() * 0.5 + random.direction() * 0.2;
        let hit = reference.trace(origin, edge - origin, 0.0);
        let into = reference.trace(origin, core - origin, 0.0).expect("the torus is closed");
        assert!(into.distance < 1.0);
        on_walls += u32::from(hit.is_some_and(|h| h.on_wall)) + u32::from(into.on_wall);
        assert!(reference.blocked(core, origin - core, [0.0, 1.0]), "and so it is from within");
    }
    assert!(on_walls > 1000, "{on_walls}");
}

#[test]
fn a_ray_along_a_shared_wall_is_seen_by_both_prisms_alike() {
    let scene = scene(square(), Some(displacement(0.3, 0.5)), waves(16));
    let reference = Reference::new(&scene);
    let surface = &reference.surfaces[0];
    let mut random = Random(37);
    for _ in 0..2000 {
        let at = random.within(-0.5, 0.5);
        let origin = DVec3::new(at, at, 2.0);
        let slide = random.within(-0.2, 0.2);
        for direction in [-DVec3::Z, DVec3::new(slide, slide, -1.0)] {
            let ray = super::super::Ray::new(origin, direction);
            let accept = super::super::Accept { range: [0.0, f64::INFINITY], both_sides: false };
            let hits = [0, 1].map(|f| super::super::prism::hit(&ray, &surface.facets, f, &reference.fields, accept));
            let [Some(a), Some(b)] = hits else { panic!("{origin} {direction}: {hits:?}") };
            assert!((a.distance - b.distance).abs() < 1e-8);
        }
    }
}

#[test]
fn a_torus_renders_in_time_and_without_holes() {
    let mut scene = scene(torus(48, 24), Some(displacement(0.1, 0.5)), waves(512));
    scene.lights = vec![crate::scene::Light {
        intensity: DVec3::ONE,
        position: DVec3::ZERO,
        direction: DVec3::new(-0.3, -0.2, -1.0).normalize(),
        range: None,
        kind: crate::scene::LightKind::Directional,
    }];
    let started = std::time::Instant::now();
    let reference = Reference::new(&scene);
    let built = started.elapsed();
    let aov = reference.render(&camera(DVec3::new(1.5, -2.2, 2.0), DVec3::ZERO, 0.9), 160, 120, Shadows::Trace);
    let covered = aov.depth.iter().filter(|z| z.is_finite()).count();
    let dark = aov.shadow.iter().filter(|s| **s == 0.0).count();
    println!("built in {built:?}, all in {:?}: {covered} covered, {dark} dark", started.elapsed());
    assert!(covered > 4000 && dark > 500 && dark < covered);
    assert!(aov.normal.iter().flatten().chain(aov.uv.iter().flatten()).all(|v| v.is_finite()));
    // A hole is a missed pixel whose four neighbours are covered.
    for i in 161..160 * 119 - 1 {
        let around = [i - 160, i - 1, i + 1, i + 160];
        assert!(aov.depth[i].is_finite() || around.iter().any(|j| aov.depth[*j] == f32::INFINITY), "a hole at {i}");
    }
}

#[test]
fn a_plane_at_two_degrees_with_cliffs_a_texel_wide_is_covered_to_its_edge() {
    let cliffs = map(512, 512, |x, y| if (x / 16 + y / 16) % 2 == 0 { 1.0 } else { 0.0 });
    let reference = Reference::new(&scene(square(), Some(displacement(0.05, 1.0)), cliffs));
    let (sin, cos) = 2f64.to_radians().sin_cos();
    let started = std::time::Instant::now();
    let camera = camera(DVec3::new(0.0, -3.0 * cos, 3.0 * sin), DVec3::ZERO, 0.6);
    let aov = reference.render(&camera, 160, 120, Shadows::Skip);
    println!("two degrees: {:?}", started.elapsed());
    // Detail that goes inward ends at the plane, so every ray that meets the plane well inside its edge ends on a cliff
    // or a floor.
    for (i, depth) in aov.depth.iter().enumerate() {
        let (x, y) = (2.0 * (i % 160) as f64 + 1.0 - 160.0, 120.0 - 2.0 * (i / 160) as f64 - 1.0);
        let half = 0.3f64.tan() / 120.0;
        let way = camera.transform.transform_vector3(DVec3::new(x * half, y * half, -1.0));
        let meets = camera.transform.translation - way * (camera.transform.translation.z / way.z);
        if way.z < 0.0 && meets.x.abs() < 0.95 && meets.y > -0.95 && meets.y < -0.5 {
            assert!(depth.is_finite(), "a hole at {meets}");
        }
    }
}
