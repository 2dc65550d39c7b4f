//! How different two pictures look: FLIP (Andersson et al. 2020), by its authors' own code.

use nv_flip::{DEFAULT_PIXELS_PER_DEGREE, FlipImageRgb8, FlipPool, flip, magma_lut};

use crate::app::picture::Picture;

/// What sets two pictures apart for an eye that sees 67 pixels a degree.
pub struct Difference {
    /// Mean over the picture: 0 none, 1 black against white.
    pub mean: f64,
    /// Where: dark to bright.
    pub map: Picture,
}

/// Compares two pictures of one size.
pub fn between(test: &Picture, reference: &Picture) -> Difference {
    let [width, height] = test.size;
    let rgb = |picture: &Picture| {
        let bytes: Vec<u8> = picture.pixels.iter().flat_map(|p| [p[0], p[1], p[2]]).collect();
        FlipImageRgb8::with_data(width, height, &bytes)
    };
    let errors = flip(rgb(reference), rgb(test), DEFAULT_PIXELS_PER_DEGREE);
    let mean = f64::from(FlipPool::from_image(&errors).mean());
    let colours = errors.apply_color_lut(&magma_lut()).to_vec();
    let map = Picture::of(test.size, |i| [colours[3 * i], colours[3 * i + 1], colours[3 * i + 2]]);
    Difference { mean, map }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_pictures_do_not_differ_and_black_and_white_do_most() {
        let [black, white] = [[0; 3], [255; 3]].map(|colour| Picture::filled([24, 16], colour));
        assert_eq!(between(&black, &black).mean, 0.0);
        let most = between(&white, &black);
        assert!(most.mean > 0.9 && most.mean <= 1.0, "{}", most.mean);
        assert!(most.map.pixels[0][0] > 200, "bright where they differ");
        // Half of the picture differs; an eye blurs where.
        let half = Picture::of([24, 16], |i| if i < 24 * 8 { [0; 3] } else { [255; 3] });
        let share = between(&half, &black).mean / most.mean;
        assert!((0.25..0.95).contains(&share), "{share}");
    }
}
