//! Texture references: UV set, `KHR_texture_transform`, sampler, image.

use glam::{DAffine2, DMat2, DVec2};
use gltf::json::{
    self, Index,
    extensions::texture::TextureTransform,
    image::Image,
    texture::{self, MagFilter, MinFilter, WrappingMode},
    validation::Checked,
};
use serde_json::Value;

use super::{Sampler, Wrap, document::Document};
use crate::error::Result;

/// The extension's name.
pub(super) const TRANSFORM: &str = "KHR_texture_transform";

/// A reference to a texture, as far as it can be read without the texture.
pub(super) struct Info {
    /// The texture.
    pub index: Index<json::Texture>,
    /// UV set, 0 or 1.
    pub tex_coord: usize,
    /// uv' = transform · uv.
    pub transform: DAffine2,
}

impl Info {
    /// A texture reference of `by` ("material 2 'wall'") whose role is `role` ("base colour texture").
    pub fn new(
        doc: &Document,
        by: &str,
        role: &str,
        index: Index<json::Texture>,
        tex_coord: u32,
        transform: Option<&TextureTransform>,
    ) -> Result<Self> {
        // The extension may replace the UV set.
        let tex_coord = transform.and_then(|transform| transform.tex_coord).unwrap_or(tex_coord);
        if tex_coord > 1 {
            return Err(doc.error(
                by,
                format!("its {role} reads TEXCOORD_{tex_coord}, but only UV sets 0 and 1 are supported"),
                "move the coordinates to TEXCOORD_0 or TEXCOORD_1",
            ));
        }
        let transform = transform.map_or(DAffine2::IDENTITY, matrix);
        if !transform.is_finite() {
            return Err(doc.error(by, format!("its {role} has a {TRANSFORM} that is not finite"), "correct it"));
        }
        Ok(Info { index, tex_coord: tex_coord as usize, transform })
    }
}

/// Reads `KHR_texture_transform` where the `gltf` crate leaves an `extensions` object untyped.
pub(super) fn transform_in(
    doc: &Document,
    by: &str,
    role: &str,
    extension: Option<&Value>,
) -> Result<Option<TextureTransform>> {
    let parse = |value: &Value| {
        serde_json::from_value(value.clone())
            .map_err(|error| doc.error(by, format!("its {role} has a broken {TRANSFORM} ({error})"), "correct it"))
    };
    extension.map(parse).transpose()
}

/// The extension's matrix: translation · rotation · scale. The rotation is counter-clockwise as seen on the image, whose
/// v points down: that is what the extension's text and its example say (offset [0, 1], rotation π/2 and scale 1/2 show
/// the lower left quadrant) and what its viewers do; its GLSL, read in column order, would turn the other way.
fn matrix(transform: &TextureTransform) -> DAffine2 {
    let offset = DVec2::from(transform.offset.0.map(f64::from));
    let scale = DVec2::from(transform.scale.0.map(f64::from));
    let rotation = DMat2::from_angle(-f64::from(transform.rotation.0));
    DAffine2::from_mat2_translation(rotation * DMat2::from_diagonal(scale), offset)
}

/// The image and the sampler behind a reference. `by` and `role` as in [`Info::new`].
pub(super) fn resolve(
    doc: &Document,
    by: &str,
    role: &str,
    index: Index<json::Texture>,
) -> Result<(Index<Image>, Sampler)> {
    let texture = doc.lookup(&doc.textures, index, "texture", &format!("{by}, {role}"))?;
    let object = super::document::label("texture", index.value(), texture.name.as_deref());
    // The `gltf` crate's value for a texture without `source`.
    if texture.source.value() == u32::MAX as usize {
        return Err(doc.error(object, "has no 'source'", "give it an image in PNG or JPEG"));
    }
    doc.lookup(&doc.images, texture.source, "image", &object)?;
    let sampler = match texture.sampler {
        Some(index) => sampler(doc, index, &object)?,
        None => Sampler::default(),
    };
    Ok((texture.source, sampler))
}

fn sampler(doc: &Document, index: Index<texture::Sampler>, by: &str) -> Result<Sampler> {
    let sampler = doc.lookup(&doc.samplers, index, "sampler", by)?;
    let unknown = |what: &str| {
        doc.error(format!("sampler {}", index.value()), format!("its {what} is none of glTF's"), "correct the number")
    };
    let wrap = |mode, what| match mode {
        Checked::Valid(WrappingMode::Repeat) => Ok(Wrap::Repeat),
        Checked::Valid(WrappingMode::MirroredRepeat) => Ok(Wrap::Mirror),
        Checked::Valid(WrappingMode::ClampToEdge) => Ok(Wrap::Clamp),
        Checked::Invalid => Err(unknown(what)),
    };
    Ok(Sampler {
        wrap: [wrap(sampler.wrap_s, "wrapS")?, wrap(sampler.wrap_t, "wrapT")?],
        nearest: match sampler.mag_filter {
            Some(Checked::Invalid) => return Err(unknown("magFilter")),
            Some(Checked::Valid(filter)) => filter == MagFilter::Nearest,
            None => false,
        },
        no_mips: match sampler.min_filter {
            Some(Checked::Invalid) => return Err(unknown("minFilter")),
            Some(Checked::Valid(filter)) => {
                matches!(filter, MinFilter::Nearest | MinFilter::Linear)
            }
            None => false,
        },
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn transform(json: &str) -> DAffine2 {
        matrix(&serde_json::from_str(json).expect("a valid extension"))
    }

    #[test]
    fn scale_comes_first_offset_last() {
        let m = transform(r#"{"offset": [0.25, 0.5], "rotation": 1.5707963267948966, "scale": [2, 4]}"#);
        // (1, 0) → scaled (2, 0) → turned (0, -2) → moved.
        assert!((m.transform_point2(DVec2::new(1.0, 0.0)) - DVec2::new(0.25, -1.5)).length() < 1e-6);
        // (0, 1) → scaled (0, 4) → turned (4, 0) → moved.
        assert!((m.transform_point2(DVec2::new(0.0, 1.0)) - DVec2::new(4.25, 0.5)).length() < 1e-6);
    }

    #[test]
    fn the_extension_s_own_example_shows_the_lower_left_quadrant() {
        let m = transform(r#"{"offset": [0, 1], "rotation": 1.57079632679, "scale": [0.5, 0.5]}"#);
        for corner in [DVec2::ZERO, DVec2::X, DVec2::Y, DVec2::ONE] {
            let uv = m.transform_point2(corner);
            assert!((-1e-6..=0.5 + 1e-6).contains(&uv.x) && (0.5 - 1e-6..=1.0 + 1e-6).contains(&uv.y), "{uv}");
        }
    }

    #[test]
    fn absent_parts_are_identity() {
        assert_eq!(transform("{}"), DAffine2::IDENTITY);
        assert_eq!(transform(r#"{"scale": [3, 3]}"#).transform_point2(DVec2::new(1.0, 2.0)), DVec2::new(3.0, 6.0));
    }
}
