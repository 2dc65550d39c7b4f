//! Soft self-shadow: the one clearance of its definition against what a round light really is, an integral of hard rays.

use glam::{DVec2, DVec3};

use super::{displacement, map, scene, square};
use crate::{
    scene::{Light, LightKind},
    shell::reference::{
        Hit, Reference,
        penumbra::{Roofs, disc_above},
    },
};

/// Texels along the map: a wall of one height stands from 5/8 to 7/8 of x.
const TEXELS: u32 = 64;

/// Height of the wall.
const WALL: f64 = 0.05;

/// A floor at z = 0 with a wall along y, whose sides are a texel wide.
fn walled() -> Reference {
    let wall = map(TEXELS, TEXELS, |x, _| if (40..56).contains(&x) { 1.0 } else { 0.0 });
    Reference::new(&scene(square(), Some(displacement(WALL, 0.0)), wall))
}

/// Where the wall's top begins.
const EDGE: f64 = 2.0 * 40.5 / TEXELS as f64 - 1.0;

fn floor_at(reference: &Reference, x: f64) -> Hit {
    let hit = reference.trace(DVec3::new(x, 0.05, 5.0), DVec3::NEG_Z, 0.0).expect("the floor");
    assert!(hit.position.z.abs() < 1e-12);
    hit
}

fn sun(elevation: f64) -> Light {
    let toward = DVec3::new(elevation.cos(), 0.0, elevation.sin());
    let intensity = DVec3::ONE;
    Light { intensity, position: DVec3::ZERO, direction: -toward, range: None, kind: LightKind::Directional }
}

/// The share of a disc of that angular radius whose hard rays arrive: a grid of directions.
fn disc_seen(reference: &Reference, hit: &Hit, light: &Light, softness: f64) -> f64 {
    const SIDE: i32 = 60;
    let toward = -light.direction;
    let (across, up) = (DVec3::Y, toward.cross(DVec3::Y) * -1.0);
    let offsets = (0..SIDE * SIDE)
        .map(|i| (DVec2::new(f64::from(i % SIDE), f64::from(i / SIDE)) + 0.5) * (2.0 / f64::from(SIDE)) - 1.0)
        .filter(|offset| offset.length() < 1.0);
    let (mut seen, mut all) = (0, 0);
    for offset in offsets {
        let way = toward + softness * (offset.x * across + offset.y * up);
        all += 1;
        seen += u32::from(!reference.blocked(hit.position, way, [1e-6, f64::INFINITY]));
    }
    f64::from(seen) / f64::from(all)
}

#[test]
fn the_disc_is_cut_as_its_area_says() {
    assert_eq!([0.0, 0.5, 1.0].map(disc_above), [0.0, 0.5, 1.0]);
    // A quarter of the diameter: 1/3 - √3 / (4 π) of the area.
    assert!((disc_above(0.25) - (1.0 / 3.0 - 3.0f64.sqrt() / (4.0 * std::f64::consts::PI))).abs() < 1e-12);
}

/// How far the definition is off the integral, at most, from below the light's lower limb to above the upper one.
fn most_off(reference: &Reference, degrees: f64, softness: f64) -> f64 {
    let light = sun(f64::to_radians(degrees));
    let roofs = Roofs::new(reference, softness);
    let mut between = 0;
    let off = (0..=24).map(|i| {
        let edge = f64::to_radians(degrees) + 1.2 * softness * (f64::from(i) / 12.0 - 1.0);
        let hit = floor_at(reference, EDGE - WALL / edge.tan());
        let (soft, rays) =
            (reference.seen_past_own(&hit, &light, &roofs), disc_seen(reference, &hit, &light, softness));
        between += usize::from(soft > 0.0 && soft < 1.0);
        (soft - rays).abs()
    });
    let most = off.fold(0.0, f64::max);
    println!("{degrees}°, softness {softness}: at most {most:.4} off");
    assert!(between > 15, "{degrees}° {softness}: {between} of the places see a part");
    most
}

#[test]
fn a_straight_edge_hides_as_much_of_a_round_light_as_rays_to_all_of_it_say() {
    let reference = walled();
    for (degrees, softness) in [(8.0, 0.02), (8.0, 0.03), (15.0, 0.05), (25.0, 0.05), (40.0, 0.05)] {
        assert!(most_off(&reference, degrees, softness) < 0.012);
    }
    // 0.08 wide where it passes the wall, and taken to be as wide as the headroom: 0.05.
    let most = most_off(&reference, 8.0, 0.06);
    assert!(most > 0.05 && most < 0.13, "{most}");
}

#[test]
fn a_light_without_size_is_seen_or_not() {
    let reference = walled();
    let roofs = Roofs::new(&reference, 0.0);
    let light = sun(0.3);
    let seen = [0.05, 0.15, 0.17, 0.6].map(|away| {
        let hit = floor_at(&reference, EDGE - away);
        assert_eq!(reference.seen_past_own(&hit, &light, &roofs), f64::from(u8::from(reference.lit(&hit, &light))));
        reference.lit(&hit, &light)
    });
    assert_eq!(seen, [false, false, true, true]);
}
