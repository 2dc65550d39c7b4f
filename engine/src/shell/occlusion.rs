//! Ambient occlusion of a height field: how much of the sky over a flat sheet of it each point sees, weighted by the
//! cosine, as a map over UV.
//!
//! Horizons are searched in slices around the sheet's normal, and each slice's part is an integral in closed form
//! (Jiménez et al., "Practical Realtime Strategies for Accurate Indirect Occlusion", 2016, eq. 7; horizons: Bavoil,
//! Sainz and Dimitrov, "Image-Space Horizon-Based Ambient Occlusion", 2008). The mesh's own curvature is not seen:
//! a primitive's UVs are taken as one affine map of its mean proportions.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::{DMat2, DVec2, DVec3};
use rayon::prelude::*;

use super::{heights::Heights, prisms};
use crate::scene::{HeightSource, Primitive, Scene};

/// Slices through the point; each has a horizon on either side.
const SLICES: usize = 8;
/// Samples along each horizon, denser near the point.
const STEPS: usize = 24;
/// How far away a horizon is searched, in ranges of height: what is beyond hides less than 1.6 % of the sky.
const REACH: f64 = 8.0;
/// Texels of a height map for one of its occlusion, along an axis: over so few the sky hardly changes.
const TEXELS_EACH: usize = 2;
/// Most texels along an axis: what is smaller the textures' own occlusion has to tell.
const MOST_TEXELS: usize = 512;

/// A height field over UV and its sheet.
struct Sheet<'a> {
    /// Level in mesh units at a UV.
    level: &'a (dyn Fn(DVec2) -> f64 + Sync),
    /// Greatest difference of two levels.
    range: f64,
    /// UV to the sheet, mesh units.
    plane: DMat2,
}

/// An occlusion map: 255 sees all of the sky.
pub struct OcclusionMap {
    /// Texels along u and v.
    pub size: [usize; 2],
    /// Row by row.
    pub texels: Vec<u8>,
}

/// A flat sheet of a primitive's mean proportions: the affine map with the mean of its triangles' metrics, by area in
/// UV. Identity where its UVs cover no area.
fn mean_plane(primitive: &Primitive, uv: &[glam::Vec2]) -> DMat2 {
    let (mut metric, mut area) = (DVec3::ZERO, 0.0);
    for triangle in &primitive.triangles {
        let [a, b, c] = triangle.map(|v| primitive.positions[v as usize].as_dvec3());
        let [ua, ub, uc] = triangle.map(|v| uv[v as usize].as_dvec2());
        let edges = DMat2::from_cols(ub - ua, uc - ua);
        let size = edges.determinant().abs();
        if size == 0.0 {
            continue;
        }
        let inverse = edges.inverse();
        let along_u = (b - a) * inverse.x_axis.x + (c - a) * inverse.x_axis.y;
        let along_v = (b - a) * inverse.y_axis.x + (c - a) * inverse.y_axis.y;
        metric += size * DVec3::new(along_u.dot(along_u), along_u.dot(along_v), along_v.dot(along_v));
        area += size;
    }
    let DVec3 { x: e, y: f, z: g } = metric / area;
    let side = e.sqrt();
    let plane = DMat2::from_cols(DVec2::new(side, 0.0), DVec2::new(f / side, (g - f * f / e).max(0.0).sqrt()));
    if plane.determinant() > 0.0 && plane.is_finite() { plane } else { DMat2::IDENTITY }
}

/// Texels of the occlusion map of a field, along u and v.
pub fn texels(scene: &Scene, source: HeightSource) -> [usize; 2] {
    let size = match source {
        HeightSource::Map(map) => [scene.height_maps[map].width, scene.height_maps[map].height].map(|n| n as usize),
        HeightSource::Procedure(_) => [MOST_TEXELS; 2],
    };
    size.map(|n| (n / TEXELS_EACH).clamp(1, MOST_TEXELS))
}

/// The occlusion map of a displaced primitive.
///
/// # Panics
///
/// Where the primitive is not displaced.
pub fn of_primitive(scene: &Scene, primitive: &Primitive) -> OcclusionMap {
    let d = prisms::displacement(scene, primitive).expect("only displaced primitives are asked for");
    let heights = Heights::new(scene, &d);
    let scale = primitive.displacement_scale;
    let size = texels(scene, d.source);
    let (low, high) = scene.displacement_range(primitive);
    let sheet = Sheet {
        level: &|uv| scale * heights.at(uv).0,
        range: high - low,
        plane: mean_plane(primitive, &prisms::height_uvs(primitive, &d)),
    };
    bake(&sheet, size)
}

/// Bakes a map of so many texels.
fn bake(sheet: &Sheet<'_>, size: [usize; 2]) -> OcclusionMap {
    let [width, height] = size;
    let texel = DVec2::new(1.0 / width as f64, 1.0 / height as f64);
    let value = |i: usize| {
        let uv = (DVec2::new((i % width) as f64, (i / width) as f64) + 0.5) * texel;
        (255.0 * visibility(sheet, uv, texel)).round() as u8
    };
    OcclusionMap { size, texels: (0..width * height).into_par_iter().map(value).collect() }
}

/// The part of the sky that the point at `uv` sees; `texel` is the least step in UV that matters.
fn visibility(sheet: &Sheet<'_>, uv: DVec2, texel: DVec2) -> f64 {
    let to_uv = sheet.plane.inverse();
    let here = (sheet.level)(uv);
    let slope = |step: DVec2| ((sheet.level)(uv + 0.5 * step) - (sheet.level)(uv - 0.5 * step)) / step.length();
    // The gradient over the sheet is the one over UV through the inverse's transpose.
    let over_uv = DVec2::new(slope(DVec2::new(texel.x, 0.0)), slope(DVec2::new(0.0, texel.y)));
    let gradient = to_uv.transpose() * over_uv;
    let normal = (-gradient).extend(1.0).normalize();
    let nearest =
        0.5 * (sheet.plane * DVec2::new(texel.x, 0.0)).length().min((sheet.plane * DVec2::new(0.0, texel.y)).length());
    let reach = (REACH * sheet.range).max(2.0 * nearest);
    let mut sum = 0.0;
    for slice in 0..SLICES {
        let direction = DVec2::from_angle(PI * (slice as f64 + 0.5) / SLICES as f64);
        // The normal in the slice's plane: its length, and its angle from the sheet's normal.
        let along = normal.truncate().dot(direction);
        let length = along.hypot(normal.z);
        let tilt = along.atan2(normal.z);
        for side in [-1.0, 1.0] {
            let step = to_uv * (side * direction);
            // Beyond its reach the sheet goes on, flat.
            let mut steepest: f64 = 0.0;
            for k in 1..=STEPS {
                let part = k as f64 / STEPS as f64;
                let distance = nearest + (reach - nearest) * part * part;
                steepest = steepest.max(((sheet.level)(uv + distance * step) - here) / distance);
            }
            let horizon = side * (FRAC_PI_2 - steepest.atan());
            let horizon = tilt + (horizon - tilt).clamp(-FRAC_PI_2, FRAC_PI_2);
            sum += length * 0.25 * (-(2.0 * horizon - tilt).cos() + tilt.cos() + 2.0 * horizon * tilt.sin());
        }
    }
    (sum / SLICES as f64).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXEL: DVec2 = DVec2::splat(1.0 / 512.0);

    fn sheet<'a>(level: &'a (dyn Fn(DVec2) -> f64 + Sync), range: f64) -> Sheet<'a> {
        Sheet { level, range, plane: DMat2::IDENTITY }
    }

    #[test]
    fn a_flat_sheet_sees_all_of_the_sky() {
        assert!((visibility(&sheet(&|_| 0.3, 0.0), DVec2::splat(0.5), TEXEL) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_tilted_sheet_loses_what_is_below_the_horizon() {
        // An endless plane at an angle sees its own half of the sky, less what lies below level: (1 + cos) / 2.
        let slope = 0.8f64;
        let seen = visibility(&sheet(&|uv| slope * uv.x, 1e-3), DVec2::splat(0.5), TEXEL);
        let expected = 0.5 * (1.0 + slope.atan().cos());
        assert!((seen - expected).abs() < 0.01, "{seen} for {expected}");
    }

    #[test]
    fn a_wall_hides_its_form_factor() {
        // A point at distance d from the foot of an endless wall of height h sees (1 + cos(atan(h / d))) / 2.
        let wall = 0.05f64;
        let level = |uv: DVec2| if uv.x < 0.5 { wall } else { 0.0 };
        for distance in [0.01, 0.02, 0.05, 0.1] {
            let seen = visibility(&sheet(&level, wall), DVec2::new(0.5 + distance, 0.3), TEXEL);
            let expected = 0.5 * (1.0 + (wall / distance).atan().cos());
            assert!((seen - expected).abs() < 0.03, "at {distance}: {seen} for {expected}");
        }
    }

    #[test]
    fn proportions_matter_and_not_the_unwrapping() {
        // The same waves, in UVs that are sheared and stretched.
        let plane = DMat2::from_cols(DVec2::new(2.0, 0.0), DVec2::new(0.7, 0.5));
        let wave = |p: DVec2| 0.02 * (40.0 * p.x).sin() * (30.0 * p.y).cos();
        let straight = |p: DVec2| wave(p);
        let sheared = |uv: DVec2| wave(plane * uv);
        for p in [DVec2::new(0.31, 0.22), DVec2::new(0.4, 0.1), DVec2::new(0.55, 0.3)] {
            let a = visibility(&sheet(&straight, 0.04), p, TEXEL);
            let b = visibility(&Sheet { level: &sheared, range: 0.04, plane }, plane.inverse() * p, TEXEL);
            assert!((a - b).abs() < 0.02, "{a} and {b}");
        }
    }

    #[test]
    fn bumps_hide_what_rays_find_hidden() {
        let level = |uv: DVec2| {
            0.03 * (0.5 + 0.5 * (23.0 * uv.x).sin() * (19.0 * uv.y).cos()) + 0.01 * (61.0 * uv.x + 47.0 * uv.y).sin()
        };
        let field = sheet(&level, 0.05);
        let (mut worst, mut sum, mut count) = (0.0f64, 0.0, 0.0);
        for i in 0..40 {
            let uv = DVec2::new(0.07 + 0.021 * i as f64, 0.9 - 0.019 * i as f64);
            let seen = visibility(&field, uv, TEXEL);
            let truth = by_rays(&level, uv);
            worst = worst.max((seen - truth).abs());
            sum += seen - truth;
            count += 1.0;
        }
        assert!(worst < 0.06 && (sum / count).abs() < 0.02, "worst {worst}, mean {}", sum / count);
    }

    /// Rays spread by the cosine around the point's normal, followed in small steps until above everything.
    fn by_rays(level: &dyn Fn(DVec2) -> f64, uv: DVec2) -> f64 {
        let small = 1e-5;
        let gradient = DVec2::new(
            level(uv + DVec2::new(small, 0.0)) - level(uv - DVec2::new(small, 0.0)),
            level(uv + DVec2::new(0.0, small)) - level(uv - DVec2::new(0.0, small)),
        ) / (2.0 * small);
        let normal = (-gradient).extend(1.0).normalize();
        let (a, b) = normal.any_orthonormal_pair();
        let rays = 1500;
        let mut seen = 0;
        for i in 0..rays {
            let radius = ((i as f64 + 0.5) / rays as f64).sqrt();
            let angle = PI * (1.0 + 5f64.sqrt()) * i as f64;
            let (s, c) = angle.sin_cos();
            let direction = radius * (c * a + s * b) + (1.0 - radius * radius).sqrt() * normal;
            if direction.z <= 0.0 {
                continue;
            }
            let mut clear = true;
            for k in 1..4000 {
                let distance = 2.5e-4 * f64::from(k);
                let at = level(uv) + distance * direction.z;
                if at > 0.041 {
                    break;
                }
                if level(uv + distance * direction.truncate()) > at + 1e-6 {
                    clear = false;
                    break;
                }
            }
            seen += usize::from(clear);
        }
        seen as f64 / rays as f64
    }
}
