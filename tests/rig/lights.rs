//! Lights to cast shadows by, and what pictures make of them.

use glam::DVec3;
use image::RgbImage;
use prism_engine::{
    aov::Aov,
    scene::{Light, LightKind, Scene},
};

/// Elevation above the horizon and azimuth of suns from overhead to 1° above the horizon, degrees.
pub const SUNS: [[f64; 2]; 4] = [[90.0, 0.0], [45.0, 70.0], [10.0, 200.0], [1.0, 310.0]];

/// A directional light from there.
pub fn sun([elevation, azimuth]: [f64; 2]) -> Light {
    let (elevation, azimuth) = (elevation.to_radians(), azimuth.to_radians());
    let toward = DVec3::new(elevation.cos() * azimuth.cos(), elevation.sin(), elevation.cos() * azimuth.sin());
    Light {
        intensity: DVec3::splat(3.0),
        position: DVec3::ZERO,
        direction: -toward,
        range: None,
        kind: LightKind::Directional,
    }
}

/// A scene with one light.
pub fn lit_by(scene: &Scene, light: Light) -> Scene {
    Scene { lights: vec![light], ..scene.clone() }
}

/// A light at `position`, and one that looks from there at the middle through a cone. Their rays end at the light.
pub fn near_lights(position: DVec3) -> [(&'static str, Light); 2] {
    let lamp = Light {
        intensity: DVec3::splat(3.0),
        position,
        direction: -position.normalize(),
        range: None,
        kind: LightKind::Point,
    };
    [("point", lamp), ("spot", Light { kind: LightKind::Spot { inner: 0.3, outer: 1.2 }, ..lamp })]
}

/// Where what a picture sees of the light differs from the reference: light grey is lit, dark grey is not, red is lit in
/// the picture alone and blue in the reference alone; black is covered by neither or by one.
pub fn difference(test: &Aov, truth: &Aov) -> RgbImage {
    let mut picture = RgbImage::new(truth.width, truth.height);
    for (i, pixel) in picture.pixels_mut().enumerate() {
        if test.depth[i].is_finite() && truth.depth[i].is_finite() {
            pixel.0 = match (test.shadow[i] < 0.5, truth.shadow[i] < 0.5) {
                (false, false) => [190; 3],
                (true, true) => [70; 3],
                (false, true) => [255, 40, 40],
                (true, false) => [60, 110, 255],
            };
        }
    }
    picture
}
