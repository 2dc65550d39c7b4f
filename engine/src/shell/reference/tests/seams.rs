//! Steps and their walls, borders, sides and folds.

use super::*;
use crate::scene::{Light, LightKind};

/// The square split at x = 0 into two quads with their own UVs and materials: material 0 left, 1 right.
fn split(left: Option<Displacement>, right: Option<Displacement>) -> Scene {
    let quad = |x: f32, material: usize| {
        let mut mesh = square();
        let mut primitive = mesh.primitives.remove(0);
        primitive.positions.iter_mut().for_each(|p| p.x = x + (p.x + 1.0) / 2.0);
        primitive.material = material;
        primitive
    };
    let mut scene = scene(square(), left, map(2, 2, |_, y| f64::from(y)));
    scene.meshes[0].primitives = vec![quad(-1.0, 0), quad(0.0, 1)];
    scene.materials.push(material(right));
    scene
}

/// Constant height 1 on `scale`.
fn lifted(scale: f64) -> Option<Displacement> {
    // Texel row 1 alone: v = 3/4.
    Some(Displacement {
        transform: DAffine2::from_scale_angle_translation(glam::DVec2::ZERO, 0.0, glam::DVec2::new(0.0, 0.75)),
        ..displacement(scale, 0.0)
    })
}

#[test]
fn a_step_between_two_heights_is_closed_by_a_wall_that_faces_the_lower_side() {
    let reference = Reference::new(&split(lifted(0.2), lifted(0.5)));
    let across = |z: f64, x: f64| reference.trace(DVec3::new(x, 0.1, z), DVec3::new(-x.signum(), 0.0, 0.0), 0.0);
    let hit = across(0.35, -0.9).expect("the wall");
    assert!(hit.on_wall && hit.position.distance(DVec3::new(0.0, 0.1, 0.35)) < 1e-12);
    assert!(hit.normal.distance(-DVec3::X) < 1e-12 && hit.primitive == 1, "{hit:?}");
    // UV of the prism being entered: the right quad's left edge. Height by its scale.
    assert!(hit.uv.x.abs() < 1e-12 && (hit.height - 0.7).abs() < 1e-12);
    assert!(across(0.35, 0.9).is_none(), "from behind");
    assert!(across(0.1, -0.9).is_none() && across(0.55, -0.9).is_none(), "below and above the step");
    assert!(reference.blocked(DVec3::new(0.9, 0.1, 0.35), -DVec3::X, [0.0, 9.0]), "both sides block");
}

#[test]
fn a_plain_neighbour_counts_as_height_zero() {
    for (scene, low) in [(split(None, lifted(0.5)), -0.9), (split(lifted(0.5), None), 0.9)] {
        let reference = Reference::new(&scene);
        let hit = reference.trace(DVec3::new(low, 0.1, 0.35), DVec3::new(-low, 0.0, 0.0), 0.0).expect("the wall");
        assert!(hit.on_wall && hit.position.x.abs() < 1e-12 && hit.normal.x * low > 0.0);
        // Whichever side the ray comes from, only the displaced one has coordinates at that level.
        let displaced = usize::from(scene.materials[1].displacement.is_some());
        assert!(hit.primitive == displaced && (hit.height - 0.7).abs() < 1e-12, "{hit:?}");
    }
}

#[test]
fn equal_sides_have_no_wall_and_a_seam_of_unequal_uvs_has_one() {
    let ramp = Some(displacement(0.3, 0.0));
    let mut scene = split(ramp, ramp);
    for primitive in &mut scene.meshes[0].primitives {
        primitive.uvs[0] = primitive.positions.iter().map(|p| p.truncate()).collect();
    }
    assert!(Reference::new(&scene).surfaces[0].walls.is_empty());
    scene.meshes[0].primitives[1].uvs[0].iter_mut().for_each(|uv| uv.y += 0.25);
    assert_eq!(Reference::new(&scene).surfaces[0].walls.len(), 1);
}

#[test]
fn borders_stay_open_unless_walls_are_asked_for() {
    let ridge = |border_wall| Some(Displacement { border_wall, ..displacement(0.4, 0.5) });
    // Rows 0 and 1: t = -0.2 where v = 1/4 (y = -1/2), 0.2 where v = 3/4.
    let from_side = |border_wall: bool, y: f64, z: f64| {
        let reference = Reference::new(&scene(square(), ridge(border_wall), map(1, 2, |_, y| f64::from(y))));
        reference.trace(DVec3::new(2.0, y, z), -DVec3::X, 0.0)
    };
    assert!(from_side(false, 0.5, 0.0).is_none(), "from behind, through the open border");
    let hit = from_side(true, 0.5, 0.0).expect("the border wall");
    assert!(hit.on_wall && hit.position.distance(DVec3::new(1.0, 0.5, 0.0)) < 1e-12 && hit.normal.x > 0.999);
    assert!((hit.uv.x - 1.0).abs() < 1e-12);
    assert!(from_side(true, 0.5, -0.21).is_none() && from_side(true, 0.5, 0.21).is_none(), "below and above it");
    assert!(from_side(true, -0.5, -0.19).is_none(), "no higher than the surface");
}

#[test]
fn double_sided_sheets_are_hit_from_behind() {
    let mut scene = scene(square(), Some(displacement(0.3, 0.0)), map(1, 1, |_, _| 1.0));
    scene.materials[0].double_sided = true;
    let hit = Reference::new(&scene).trace(DVec3::new(0.2, 0.1, -2.0), DVec3::Z, 0.0).expect("the back");
    assert!((hit.position.z - 0.3).abs() < 1e-12 && hit.normal.distance(-DVec3::Z) < 1e-12);
}

#[test]
fn a_one_texel_tower_casts_its_shadow() {
    let tower = map(16, 16, |x, y| if (x, y) == (8, 8) { 1.0 } else { 0.0 });
    let mut scene = scene(square(), Some(displacement(0.5, 0.0)), tower);
    scene.lights = vec![Light {
        intensity: DVec3::ONE,
        position: DVec3::ZERO,
        direction: DVec3::new(1.0, 0.0, -1.0).normalize(),
        range: None,
        kind: LightKind::Directional,
    }];
    let reference = Reference::new(&scene);
    let lit = |x: f64, y: f64| {
        let hit = reference.trace(DVec3::new(x, y, 3.0), -DVec3::Z, 0.0).expect("the square");
        reference.lit(&hit, &scene.lights[0])
    };
    // The tower stands on texel centre (8.5 / 8 - 1) = 0.0625 and is 0.5 high: its shadow reaches x = 0.5625.
    assert!(lit(-0.3, 0.0625) && !lit(0.3, 0.0625) && !lit(0.5, 0.0625) && lit(0.6, 0.0625));
    assert!(lit(0.3, 0.25));
    // Its far flank turns away from the light.
    assert!(!lit(0.1, 0.0625) && lit(0.01, 0.0625));
}

#[test]
fn folds_shrink_as_the_contract_says() {
    // A valley whose normals meet at height 1 or so: scale 4 would turn its prisms inside out.
    let (c, s) = (0.4f32, 0.9f32);
    let positions = [[-c, 0.0, s], [-c, 1.0, s], [0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [c, 0.0, s], [c, 1.0, s]];
    let normals = [[s, 0.0, c], [s, 0.0, c], [0.0, 0.0, 1.0], [0.0, 0.0, 1.0], [-s, 0.0, c], [-s, 0.0, c]];
    let normals: Vec<Vec3> = normals.map(|n| Vec3::from(n).normalize()).to_vec();
    let triangles = vec![[0, 2, 1], [1, 2, 3], [2, 4, 3], [3, 4, 5]];
    let mesh = mesh(positions.map(Vec3::from).to_vec(), normals, vec![Vec2::ZERO; 6], triangles);
    let r = |scale: f64| {
        let scene = scene(mesh.clone(), Some(displacement(scale, 0.0)), map(1, 1, |_, _| 1.0));
        let facets = Reference::new(&scene).surfaces[0].facets.clone();
        facets.iter().flat_map(|f| f.lifts.map(|l| l.length())).fold(1.0, f64::min)
    };
    assert!((r(0.05) - 1.0).abs() < 1e-12);
    let folded = r(4.0);
    assert!(folded < 1.0 && folded > 0.0 && (folded.log2() - folded.log2().round()).abs() < 1e-9, "{folded}");
}
