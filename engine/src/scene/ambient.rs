//! Light that comes from everywhere: irradiance over the direction that a surface faces, in spherical harmonics up to
//! order 2. That is all there is of it within 1 % (Ramamoorthi and Hanrahan, "An Efficient Representation for
//! Irradiance Environment Maps", 2001).

use std::f64::consts::PI;

use glam::{DMat3, DMat4, DQuat, DVec3, DVec4};
use serde_json::{Map, Value};

use super::document::{Document, label};
use crate::error::Result;

/// The extension that brings it: multi-vendor, its specular images are not read.
pub(super) const EXTENSION: &str = "EXT_lights_image_based";

/// A two-colour sky: irradiance / π on what faces up, and on what faces down.
const SKY: DVec3 = DVec3::new(0.28, 0.31, 0.36);
const GROUND: DVec3 = DVec3::new(0.16, 0.14, 0.12);

/// Ambient light, as one quadratic form a colour: what faces n gets (n, 1)ᵀ M (n, 1), irradiance / π (eq. 12 of the
/// paper).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ambient {
    /// Symmetric; red, green, blue.
    pub forms: [DMat4; 3],
}

impl Default for Ambient {
    /// What lights a scene that brings none: brighter from above than from below.
    fn default() -> Self {
        let form = |sky: f64, ground: f64| {
            let half = 0.25 * (sky - ground);
            DMat4::from_cols(
                DVec4::ZERO,
                DVec4::new(0.0, 0.0, 0.0, half),
                DVec4::ZERO,
                DVec4::new(0.0, half, 0.0, 0.5 * (sky + ground)),
            )
        };
        Ambient { forms: [0, 1, 2].map(|c| form(SKY[c], GROUND[c])) }
    }
}

impl Ambient {
    /// From the nine coefficients of irradiance over the real spherical harmonics, in the order l = 0, l = 1 with m from
    /// -1 to 1, l = 2 with m from -2 to 2; `rotation` turns the surroundings.
    pub fn from_irradiance(coefficients: &[DVec3; 9], rotation: DQuat) -> Self {
        let form = |c: usize| {
            let [l00, l1m1, l10, l11, l2m2, l2m1, l20, l21, l22] = coefficients.map(|rgb| rgb[c] / PI);
            // Constants of the real harmonics: Y00; y, z, x; xy, yz, 3z² - 1, xz, x² - y².
            let y0 = 0.5 * (1.0 / PI).sqrt();
            let y1 = 0.5 * (3.0 / PI).sqrt();
            let y2 = 0.5 * (15.0 / PI).sqrt();
            let y20 = 0.25 * (5.0 / PI).sqrt();
            let (xx, yy, zz) = (0.5 * y2 * l22, -0.5 * y2 * l22, 3.0 * y20 * l20);
            let (xy, yz, xz) = (0.5 * y2 * l2m2, 0.5 * y2 * l2m1, 0.5 * y2 * l21);
            let square = DMat3::from_cols(DVec3::new(xx, xy, xz), DVec3::new(xy, yy, yz), DVec3::new(xz, yz, zz));
            let linear = 0.5 * y1 * DVec3::new(l11, l1m1, l10);
            let turn = DMat3::from_quat(rotation);
            let (square, linear) = (turn * square * turn.transpose(), turn * linear);
            DMat4::from_cols(
                square.x_axis.extend(linear.x),
                square.y_axis.extend(linear.y),
                square.z_axis.extend(linear.z),
                linear.extend(y0 * l00 - y20 * l20),
            )
        };
        Ambient { forms: [0, 1, 2].map(form) }
    }

    /// Irradiance / π on a surface that faces `normal` (unit, world).
    pub fn irradiance(&self, normal: DVec3) -> DVec3 {
        let v = normal.extend(1.0);
        DVec3::from(self.forms.map(|form| v.dot(form * v)))
    }
}

/// The ambient light of the file's scene, or the default.
pub(super) fn import(doc: &Document, notices: &mut Vec<String>) -> Result<Ambient> {
    let Some(reference) = &doc.ambient_reference else { return Ok(Ambient::default()) };
    let scene = "scene";
    let index = reference
        .get("light")
        .and_then(Value::as_u64)
        .ok_or_else(|| doc.error(scene, format!("its {EXTENSION} names no 'light'"), "give the light's index"))?
        as usize;
    let light = doc.ambients.get(index).ok_or_else(|| {
        let problem = format!("refers to image-based light {index}, but the file has {} of them", doc.ambients.len());
        doc.error(scene, problem, format!("correct the index in its {EXTENSION}"))
    })?;
    let name = label("image-based light", index, light.get("name").and_then(Value::as_str));
    let wrong = |problem: &str| doc.error(&name, problem, "correct the light");
    let coefficients: [[f64; 3]; 9] = field(light, "irradianceCoefficients")
        .ok_or_else(|| wrong("its irradianceCoefficients are not nine lists of three numbers"))?;
    let rotation: [f64; 4] = match light.get("rotation") {
        Some(_) => field(light, "rotation").ok_or_else(|| wrong("its rotation is not four numbers"))?,
        None => [0.0, 0.0, 0.0, 1.0],
    };
    let rotation = DQuat::from_array(rotation);
    if (rotation.length() - 1.0).abs() > 1e-3 {
        return Err(wrong("its rotation is no unit quaternion"));
    }
    let intensity: f64 = match light.get("intensity") {
        Some(_) => field(light, "intensity").ok_or_else(|| wrong("its intensity is not a number"))?,
        None => 1.0,
    };
    let coefficients = coefficients.map(|rgb| intensity * DVec3::from(rgb));
    if !coefficients.iter().all(|rgb| rgb.is_finite()) {
        return Err(wrong("its coefficients or its intensity are not finite"));
    }
    notices.push(format!("{name}: its specular images are not read; reflections take the diffuse light"));
    Ok(Ambient::from_irradiance(&coefficients, rotation.normalize()))
}

fn field<T: serde::de::DeserializeOwned>(light: &Map<String, Value>, key: &str) -> Option<T> {
    T::deserialize(light.get(key)?).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Directions spread evenly over the sphere (Fibonacci lattice), each of the same solid angle.
    fn directions(count: usize) -> impl Iterator<Item = DVec3> {
        (0..count).map(move |i| {
            let z = 1.0 - (2.0 * i as f64 + 1.0) / count as f64;
            let angle = PI * (1.0 + 5f64.sqrt()) * i as f64;
            DVec3::new((1.0 - z * z).sqrt() * angle.cos(), (1.0 - z * z).sqrt() * angle.sin(), z)
        })
    }

    /// The real harmonics by their textbook formulas.
    fn harmonics(d: DVec3) -> [f64; 9] {
        let DVec3 { x, y, z } = d;
        let (a, b, c) = (0.282_094_791_773_878, 0.488_602_511_902_92, 1.092_548_430_592_079);
        [
            a,
            b * y,
            b * z,
            b * x,
            c * x * y,
            c * y * z,
            0.315_391_565_252_52 * (3.0 * z * z - 1.0),
            c * x * z,
            0.5 * c * (x * x - y * y),
        ]
    }

    #[test]
    fn the_default_is_two_colours() {
        let ambient = Ambient::default();
        assert!(ambient.irradiance(DVec3::Y).abs_diff_eq(SKY, 1e-15));
        assert!(ambient.irradiance(DVec3::NEG_Y).abs_diff_eq(GROUND, 1e-15));
        assert!(ambient.irradiance(DVec3::X).abs_diff_eq(0.5 * (SKY + GROUND), 1e-15));
    }

    #[test]
    fn coefficients_give_the_irradiance_they_were_projected_from() {
        // Radiance of order 2, so that nothing is lost; its irradiance by brute force at each direction.
        let radiance = |d: DVec3| 1.0 + 0.7 * d.x - 0.3 * d.y + 0.4 * d.z * d.x + 0.2 * d.y * d.y;
        let count = 20_000;
        let solid = 4.0 * PI / count as f64;
        let irradiance = |n: DVec3| -> f64 { directions(count).map(|d| radiance(d) * d.dot(n).max(0.0) * solid).sum() };
        let mut coefficients = [DVec3::ZERO; 9];
        let lattice = 400;
        for n in directions(lattice) {
            let value = irradiance(n) * 4.0 * PI / lattice as f64;
            for (sum, y) in coefficients.iter_mut().zip(harmonics(n)) {
                *sum += DVec3::splat(value * y);
            }
        }
        let turn = DQuat::from_euler(glam::EulerRot::XYZ, 0.4, -1.1, 2.0);
        let still = Ambient::from_irradiance(&coefficients, DQuat::IDENTITY);
        let turned = Ambient::from_irradiance(&coefficients, turn);
        for n in directions(25) {
            let expected = irradiance(n) / PI;
            assert!((still.irradiance(n).x - expected).abs() < 5e-3, "{n}: {} for {expected}", still.irradiance(n).x);
            assert!((turned.irradiance(turn * n).x - still.irradiance(n).x).abs() < 1e-12);
        }
    }
}
