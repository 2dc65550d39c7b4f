//! Errors as colours: a scale with a decade from colour to colour, and colours of its own for what has no error.

use prism_engine::{aov::Aov, measure, scene::Camera};

use super::picture::Picture;

/// Errors from 1e-6 (and less) to 1e1 (and more), a colour each power of ten; logarithmic in between. Lightness rises
/// with the error.
pub const SCALE: [[u8; 3]; 8] = [
    [0, 0, 4],
    [40, 11, 84],
    [101, 21, 110],
    [159, 42, 99],
    [212, 72, 66],
    [245, 125, 21],
    [250, 193, 39],
    [252, 255, 164],
];
/// The exponent of the scale's first colour.
const FIRST_DECADE: f64 = -6.0;

/// Nothing there, as it should be.
pub const BACKGROUND: [u8; 3] = [96, 96, 96];
/// A surface where the reference has none.
pub const GHOST: [u8; 3] = [0, 220, 255];
/// No surface where the reference has one.
pub const HOLE: [u8; 3] = [0, 255, 0];

/// The colour of an error.
pub fn colour(error: f64) -> [u8; 3] {
    let last = SCALE.len() - 1;
    let at = (error.log10() - FIRST_DECADE).clamp(0.0, last as f64);
    let below = (at as usize).min(last - 1);
    let mix = |k: usize| {
        let (a, b) = (f64::from(SCALE[below][k]), f64::from(SCALE[below + 1][k]));
        (a + (b - a) * (at - below as f64)).round() as u8
    };
    [mix(0), mix(1), mix(2)]
}

/// Depth errors in pixel footprints, seen through `camera`.
pub fn map(test: &Aov, reference: &Aov, camera: &Camera) -> Picture {
    Picture::of([test.width, test.height], |i| match (test.depth[i].is_finite(), reference.depth[i].is_finite()) {
        (true, true) => colour(measure::depth_error(test, reference, camera, i)),
        (true, false) => GHOST,
        (false, true) => HOLE,
        (false, false) => BACKGROUND,
    })
}

/// The scale as a strip: small errors on the left, a colour each decade where the strip's parts meet.
pub fn strip(size: [u32; 2]) -> Picture {
    let decades = (SCALE.len() - 1) as f64;
    Picture::of(size, |i| {
        let along = f64::from(i as u32 % size[0]) / f64::from(size[0].max(2) - 1);
        colour(10f64.powf(FIRST_DECADE + along * decades))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DAffine3;
    use prism_engine::scene::Projection;

    #[test]
    fn each_decade_has_its_colour() {
        for (i, expected) in SCALE.into_iter().enumerate() {
            assert_eq!(colour(10f64.powi(i as i32 - 6)), expected, "1e{}", i as i32 - 6);
        }
        assert_eq!(colour(10f64.powf(-0.5)), [248, 159, 30], "half way between 0.1 and 1");
    }

    #[test]
    fn what_leaves_the_scale_has_the_colour_of_its_end() {
        assert_eq!([0.0, 1e-300, 9e-7].map(colour), [SCALE[0]; 3]);
        assert_eq!([11.0, 1e300, f64::INFINITY].map(colour), [SCALE[7]; 3]);
    }

    #[test]
    fn a_map_tells_errors_ghosts_holes_and_background_apart() {
        let projection = Projection::Orthographic { y_mag: 0.5, near: 0.1, far: 9.0 };
        let camera = Camera { transform: DAffine3::IDENTITY, projection };
        let aov = |depth: [f32; 5]| Aov { depth: depth.into(), ..Aov::missed(5, 1) };
        let miss = f32::INFINITY;
        // A footprint is 2 · 0.5 / 1 = 1.
        let heat = map(&aov([2.0, 3.0, 2.0, miss, miss]), &aov([2.0, 2.0, miss, 2.0, miss]), &camera);
        let colours: Vec<[u8; 3]> = heat.pixels.iter().map(|p| [p[0], p[1], p[2]]).collect();
        assert_eq!(colours, [SCALE[0], SCALE[6], GHOST, HOLE, BACKGROUND]);
    }

    #[test]
    fn no_colour_means_two_things() {
        let strip = strip([4096, 1]);
        for special in [BACKGROUND, GHOST, HOLE] {
            let near = |p: &[u8; 4]| (0..3).all(|k| p[k].abs_diff(special[k]) < 24);
            assert!(!strip.pixels.iter().any(near), "{special:?} looks like an error");
        }
        assert_eq!((strip.pixels[0], strip.pixels[4095]), ([0, 0, 4, 255], [252, 255, 164, 255]));
    }
}
