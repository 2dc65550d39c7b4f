//! Height maps: PNG in, the red channel out, at the file's depth.

use std::{fs, path::Path};

use image::{DynamicImage, ImageFormat};
use rayon::prelude::*;

use super::{HeightMap, HeightTexels, image as images};
use crate::error::{Error, Result};

/// Texels that one thread looks through at a time.
const PART: usize = 1 << 16;

impl HeightMap {
    /// Reads a PNG that no scene names.
    pub fn read(path: &Path) -> Result<Self> {
        let bytes = fs::read(path)
            .map_err(|error| Error::input(path, "height map", format!("cannot be read: {error}"), "name a PNG file"))?;
        let image = images::decode(&bytes, &[ImageFormat::Png])
            .map_err(|refusal| Error::input(path, "height map", refusal.problem, refusal.mend))?;
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        Ok(HeightMap { name, width: image.width(), height: image.height(), texels: HeightTexels::of(&image) })
    }

    /// The height of one texel, in [0, 1].
    ///
    /// # Panics
    ///
    /// Where the texel lies outside: wrapping is the sampler's business ([`super::Displacement::wrap`]).
    pub fn height(&self, x: u32, y: u32) -> f64 {
        assert!(x < self.width && y < self.height, "texel ({x}, {y}) outside {}×{}", self.width, self.height);
        let index = y as usize * self.width as usize + x as usize;
        match &self.texels {
            HeightTexels::U8(texels) => fraction_u8(texels[index]),
            HeightTexels::U16(texels) => fraction_u16(texels[index]),
            HeightTexels::F16(texels) => texels[index].to_f64(),
        }
    }

    /// The lowest and the highest texel: what bilinear filtering can return lies between them.
    pub fn min_max(&self) -> (f64, f64) {
        match &self.texels {
            HeightTexels::U8(texels) => extremes(texels, fraction_u8),
            HeightTexels::U16(texels) => extremes(texels, fraction_u16),
            HeightTexels::F16(texels) => {
                let heights = texels.iter().map(|h| h.to_f64());
                heights.fold((1.0, 0.0), |(low, high): (f64, f64), h| (low.min(h), high.max(h)))
            }
        }
    }

    /// All its heights in f32, row by row.
    pub fn heights(&self) -> Vec<f32> {
        match &self.texels {
            HeightTexels::U8(texels) => texels.par_iter().map(|texel| fraction_u8(*texel) as f32).collect(),
            HeightTexels::U16(texels) => texels.par_iter().map(|texel| fraction_u16(*texel) as f32).collect(),
            HeightTexels::F16(texels) => texels.par_iter().map(|texel| texel.to_f32()).collect(),
        }
    }
}

impl HeightTexels {
    /// The red channel of a decoded image.
    pub(super) fn of(image: &DynamicImage) -> Self {
        // Grey counts as red; the other channels are passed over.
        let step = usize::from(image.color().channel_count());
        match image {
            DynamicImage::ImageLuma16(_)
            | DynamicImage::ImageLumaA16(_)
            | DynamicImage::ImageRgb16(_)
            | DynamicImage::ImageRgba16(_) => {
                // The decoder has put the samples into the machine's byte order.
                let sample = |bytes: &[u8]| u16::from_ne_bytes([bytes[0], bytes[1]]);
                HeightTexels::U16(image.as_bytes().chunks_exact(2 * step).map(sample).collect())
            }
            _ => HeightTexels::U8(image.as_bytes().iter().step_by(step).copied().collect()),
        }
    }
}

fn fraction_u8(value: u8) -> f64 {
    f64::from(value) / f64::from(u8::MAX)
}

fn fraction_u16(value: u16) -> f64 {
    f64::from(value) / f64::from(u16::MAX)
}

/// Of an image's texels, of which there is at least one: decoders refuse empty images.
fn extremes<T: Copy + Ord + Send + Sync>(texels: &[T], fraction: fn(T) -> f64) -> (f64, f64) {
    let parts = || texels.par_chunks(PART);
    let low = parts().filter_map(|part| part.iter().copied().min()).min();
    let high = parts().filter_map(|part| part.iter().copied().max()).max();
    (low.map_or(0.0, fraction), high.map_or(0.0, fraction))
}

#[cfg(test)]
mod tests {
    use image::{ImageBuffer, Luma, Rgba};

    use super::*;

    fn map(width: u32, texels: HeightTexels) -> HeightMap {
        HeightMap { name: "test".to_owned(), width, height: 2, texels }
    }

    #[test]
    fn heights_are_fractions_of_the_depth() {
        let eight = map(2, HeightTexels::U8(vec![0, 51, 255, 102]));
        assert_eq!(eight.height(1, 0), 0.2);
        assert_eq!(eight.height(0, 1), 1.0);
        assert_eq!(eight.min_max(), (0.0, 1.0));
        let sixteen = map(1, HeightTexels::U16(vec![13107, 26214]));
        assert_eq!(sixteen.min_max(), (0.2, 0.4));
    }

    #[test]
    fn the_red_channel_is_kept_at_its_depth() {
        let grey = DynamicImage::ImageLuma16(ImageBuffer::from_pixel(1, 1, Luma([0x1234])));
        assert!(matches!(HeightTexels::of(&grey), HeightTexels::U16(texels) if texels == [0x1234]));
        let colour = DynamicImage::ImageRgba16(ImageBuffer::from_pixel(2, 1, Rgba([0x4321, 1, 2, 3])));
        assert!(matches!(HeightTexels::of(&colour), HeightTexels::U16(texels) if texels == [0x4321; 2]));
        let colour = DynamicImage::ImageRgba8(ImageBuffer::from_pixel(2, 1, Rgba([7, 1, 2, 3])));
        assert!(matches!(HeightTexels::of(&colour), HeightTexels::U8(texels) if texels == [7; 2]));
    }
}
