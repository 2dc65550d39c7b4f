//! Images of the file: found, decoded and kept once per use.

use std::{collections::HashMap, io::Cursor};

use gltf::json::{self, Index};
use image::{DynamicImage, ImageFormat, ImageReader, Limits};

use super::{
    ColorImage, HeightMap, HeightTexels,
    accessor::{Buffers, folder},
    document::{Document, label},
    uri::{self, Refusal},
};
use crate::error::{Error, Result};

/// Beyond any device's limit; keeps a few bytes of a hostile file from asking for terabytes.
const MOST_TEXELS_PER_AXIS: u32 = 32_768;

/// Enough for 16384² texels of 16-bit RGBA.
const MOST_BYTES: u64 = 2 << 30;

/// The images that materials have asked for so far.
pub(super) struct Images<'a> {
    doc: &'a Document,
    buffers: &'a Buffers<'a>,
    /// Becomes [`super::Scene::images`].
    pub colors: Vec<ColorImage>,
    /// Becomes [`super::Scene::height_maps`].
    pub heights: Vec<HeightMap>,
    /// By the file's image and whether it is sRGB: as colour and as data it is stored twice.
    color_index: HashMap<(usize, bool), usize>,
    height_index: HashMap<usize, usize>,
}

impl<'a> Images<'a> {
    /// Nothing decoded yet.
    pub fn new(doc: &'a Document, buffers: &'a Buffers<'a>) -> Self {
        Images {
            doc,
            buffers,
            colors: Vec::new(),
            heights: Vec::new(),
            color_index: HashMap::new(),
            height_index: HashMap::new(),
        }
    }

    /// Index of a colour image, decoded at its first use. The index is one of the document's.
    pub fn color(&mut self, index: Index<json::Image>, srgb: bool) -> Result<usize> {
        let key = (index.value(), srgb);
        if let Some(&known) = self.color_index.get(&key) {
            return Ok(known);
        }
        let image = self.decode(index.value(), &[ImageFormat::Png, ImageFormat::Jpeg])?.into_rgba8();
        self.colors.push(ColorImage {
            name: self.name(index.value()),
            width: image.width(),
            height: image.height(),
            rgba: image.into_raw(),
            srgb,
        });
        self.color_index.insert(key, self.colors.len() - 1);
        Ok(self.colors.len() - 1)
    }

    /// Index of a height map, decoded at its first use. The index is one of the document's.
    pub fn height(&mut self, index: Index<json::Image>) -> Result<usize> {
        if let Some(&known) = self.height_index.get(&index.value()) {
            return Ok(known);
        }
        let image = self.decode(index.value(), &[ImageFormat::Png])?;
        self.heights.push(HeightMap {
            name: self.name(index.value()),
            width: image.width(),
            height: image.height(),
            texels: HeightTexels::of(&image),
        });
        self.height_index.insert(index.value(), self.heights.len() - 1);
        Ok(self.heights.len() - 1)
    }

    fn decode(&self, index: usize, allowed: &[ImageFormat]) -> Result<DynamicImage> {
        decode(&self.bytes(index)?, allowed).map_err(|refusal| self.error(index, refusal.problem, refusal.mend))
    }

    fn bytes(&self, index: usize) -> Result<Vec<u8>> {
        let image = &self.doc.images[index];
        match (&image.uri, image.buffer_view) {
            (Some(uri), _) => uri::read(folder(&self.doc.file), uri)
                .map_err(|refusal| self.error(index, refusal.problem, refusal.mend)),
            (None, Some(view)) => Ok(self.buffers.view(view, &self.object(index))?.to_vec()),
            (None, None) => Err(self.error(index, "has neither 'uri' nor 'bufferView'", "give it one of them")),
        }
    }

    fn error(&self, index: usize, problem: impl Into<String>, mend: impl Into<String>) -> Error {
        self.doc.error(self.object(index), problem, mend)
    }

    fn object(&self, index: usize) -> String {
        let image = &self.doc.images[index];
        let name = image.uri.as_deref().and_then(uri::file_name);
        label("image", index, name.as_deref().or(image.name.as_deref()))
    }

    /// The file's name, else the image's, else its index.
    fn name(&self, index: usize) -> String {
        let image = &self.doc.images[index];
        let file = image.uri.as_deref().and_then(uri::file_name);
        file.or_else(|| image.name.clone()).unwrap_or_else(|| format!("image {index}"))
    }
}

/// The image in a file's bytes, in one of the formats allowed.
pub(super) fn decode(bytes: &[u8], allowed: &[ImageFormat]) -> std::result::Result<DynamicImage, Refusal> {
    let refuse = |problem: String, mend: &str| Refusal { problem, mend: mend.to_owned() };
    // The bytes decide: files with the wrong ending or MIME type are common.
    let format = match image::guess_format(bytes) {
        Ok(format) if allowed.contains(&format) => format,
        other => {
            let found = other.map_or("is no image that is known".to_owned(), |format| format!("is {format:?}"));
            let height = if allowed.len() == 1 { " as a height map" } else { "" };
            let mend = if allowed.len() == 1 { "save it as PNG" } else { "save it as PNG or JPEG" };
            return Err(refuse(format!("{found}, which cannot be read{height}"), mend));
        }
    };
    let mut limits = Limits::default();
    limits.max_image_width = Some(MOST_TEXELS_PER_AXIS);
    limits.max_image_height = Some(MOST_TEXELS_PER_AXIS);
    limits.max_alloc = Some(MOST_BYTES);
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    reader.limits(limits);
    let image = reader.decode().map_err(|error| {
        let problem = format!("cannot be decoded ({error})");
        match error {
            image::ImageError::Limits(_) => {
                refuse(problem, &format!("use at most {MOST_TEXELS_PER_AXIS} texels per axis and 2 GiB"))
            }
            _ => refuse(problem, "save it again; it may be truncated or corrupt"),
        }
    })?;
    if image.width() == 0 || image.height() == 0 {
        return Err(refuse("has no texels".to_owned(), "save it again"));
    }
    Ok(image)
}
