//! The picture: an 8-bit sRGB PNG.

use std::{io::Write, path::Path};

use image::{RgbImage, codecs::png::PngEncoder};
use prism_engine::error::Result;

use super::{
    files::{self, WriteResult},
    picture::Picture,
};

/// Writes an opaque PNG: a frame's alpha means nothing to a viewer.
pub fn write(path: &Path, picture: &Picture) -> Result<()> {
    files::replace(path, "picture", |file| encode(file, picture))
}

/// The same into anything that is written to.
pub fn encode(to: impl Write, picture: &Picture) -> WriteResult {
    let Picture { size, pixels } = picture;
    let rgb = pixels.iter().flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
    let picture = RgbImage::from_raw(size[0], size[1], rgb).ok_or("fewer pixels than the picture's size")?;
    Ok(picture.write_with_encoder(PngEncoder::new(to))?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("frame.png");
        write(&path, &Picture::from_bytes([2, 1], &[255, 0, 0, 9, 1, 2, 3, 0])).unwrap();
        let read = image::open(&path).unwrap();
        assert_eq!(read.color(), image::ColorType::Rgb8);
        assert_eq!((read.width(), read.height()), (2, 1));
        assert_eq!(read.into_rgb8().into_raw(), [255, 0, 0, 1, 2, 3]);
    }

    #[test]
    fn too_few_pixels_are_an_error() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("frame.png");
        assert!(write(&path, &Picture::from_bytes([2, 2], &[0; 4])).is_err());
        assert!(!path.exists());
    }
}
