//! Materials: glTF's metallic-roughness model, and what displaces them.

use glam::{Vec3, Vec4};
use gltf::json::{
    self, Index, extensions::texture::TextureTransform, material::AlphaMode, texture, validation::Checked,
};

use super::{
    Channel, Material, TextureRef, displacement,
    document::Document,
    image::Images,
    texture::{Info, TRANSFORM, resolve, transform_in},
};
use crate::error::Result;

/// The material of primitives that name none: glTF's defaults.
impl Default for Material {
    fn default() -> Self {
        Material {
            name: "default material".to_owned(),
            base_color_factor: Vec4::ONE,
            base_color: None,
            metallic: 1.0,
            roughness: 1.0,
            metallic_roughness: None,
            roughness_channel: Channel::G,
            metallic_channel: Channel::B,
            specular: 1.0,
            specular_map: None,
            specular_color_factor: Vec3::ONE,
            specular_color: None,
            normal: None,
            occlusion: None,
            emissive_factor: Vec3::ZERO,
            emissive: None,
            alpha_cutoff: None,
            double_sided: false,
            displacement: None,
            depth_offset: None,
        }
    }
}

/// Imports a material with its images. One that nothing of the scene uses keeps its place in the list, but neither
/// textures nor displacement: its images need not exist.
pub(super) fn import(
    doc: &Document,
    index: usize,
    used: bool,
    images: &mut Images,
    notices: &mut Vec<String>,
) -> Result<Material> {
    let source = &doc.materials[index];
    let by = doc.material_label(index);
    let name = source.name.clone().unwrap_or_else(|| format!("material {index}"));
    if !used {
        return Ok(Material { name, ..Material::default() });
    }
    let pbr = &source.pbr_metallic_roughness;
    let mut user = User { doc, by: &by, images };
    let normal = match &source.normal_texture {
        Some(normal) => {
            let extension = normal.extensions.as_ref().and_then(|extensions| extensions.others.get(TRANSFORM));
            let transform = transform_in(doc, &by, "normal texture", extension)?;
            let scale = user.finite("normalTexture.scale", [normal.scale])?[0];
            let data = user.texture("normal texture", normal.index, normal.tex_coord, transform.as_ref(), false)?;
            Some((data, scale))
        }
        None => None,
    };
    let occlusion = match &source.occlusion_texture {
        Some(occlusion) => {
            let extension = occlusion.extensions.as_ref().and_then(|extensions| extensions.others.get(TRANSFORM));
            let transform = transform_in(doc, &by, "occlusion texture", extension)?;
            let strength = user.finite("occlusionTexture.strength", [occlusion.strength.0])?[0];
            let data =
                user.texture("occlusion texture", occlusion.index, occlusion.tex_coord, transform.as_ref(), false)?;
            Some((data, strength))
        }
        None => None,
    };
    let base_color_factor = user.finite("baseColorFactor", pbr.base_color_factor.0)?;
    let [metallic, roughness] =
        user.finite("metallicFactor or roughnessFactor", [pbr.metallic_factor.0, pbr.roughness_factor.0])?;
    let emissive_factor = user.finite("emissiveFactor", source.emissive_factor.0)?;
    let base_color = user.info("base colour texture", pbr.base_color_texture.as_ref(), true)?;
    let metallic_roughness = user.info("metallic-roughness texture", pbr.metallic_roughness_texture.as_ref(), false)?;
    let emissive = user.info("emissive texture", source.emissive_texture.as_ref(), true)?;
    let extension = source.extensions.as_ref().and_then(|extensions| extensions.specular.clone()).unwrap_or_default();
    let [specular] = user.finite("specularFactor", [extension.specular_factor.0])?;
    let specular_color_factor = user.finite("specularColorFactor", extension.specular_color_factor.0)?;
    // Alpha is linear in an sRGB image too, and so it can be one image with the colours.
    let specular_map = user.info("specular texture", extension.specular_texture.as_ref(), true)?;
    let specular_color = user.info("specular colour texture", extension.specular_color_texture.as_ref(), true)?;
    let alpha_cutoff = alpha_cutoff(source, &user, notices)?;
    let (displacement, depth_offset) = match &source.extras {
        Some(extras) => displacement::import(doc, &by, extras, images, notices)?,
        None => (None, None),
    };
    Ok(Material {
        name,
        base_color_factor: base_color_factor.into(),
        base_color,
        metallic,
        roughness,
        metallic_roughness,
        roughness_channel: Channel::G,
        metallic_channel: Channel::B,
        specular,
        specular_map,
        specular_color_factor: specular_color_factor.into(),
        specular_color,
        normal,
        occlusion,
        emissive_factor: emissive_factor.into(),
        emissive,
        alpha_cutoff,
        double_sided: source.double_sided,
        displacement,
        depth_offset,
    })
}

fn alpha_cutoff(source: &json::Material, user: &User, notices: &mut Vec<String>) -> Result<Option<f32>> {
    match source.alpha_mode {
        Checked::Valid(AlphaMode::Opaque) => Ok(None),
        Checked::Valid(AlphaMode::Mask) => {
            let [cutoff] = user.finite("alphaCutoff", [source.alpha_cutoff.unwrap_or_default().0])?;
            Ok(Some(cutoff))
        }
        Checked::Valid(AlphaMode::Blend) => {
            notices.push(format!("{}: alphaMode BLEND is not supported, it is drawn opaque", user.by));
            Ok(None)
        }
        Checked::Invalid => {
            Err(user.doc.error(user.by, "its alphaMode is none of glTF's", "use OPAQUE, MASK or BLEND"))
        }
    }
}

/// A material that asks for its textures.
struct User<'a, 'b> {
    doc: &'a Document,
    by: &'a str,
    images: &'a mut Images<'b>,
}

impl User<'_, '_> {
    fn info(&mut self, role: &str, info: Option<&texture::Info>, srgb: bool) -> Result<Option<TextureRef>> {
        let Some(info) = info else { return Ok(None) };
        let transform = info.extensions.as_ref().and_then(|extensions| extensions.texture_transform.as_ref());
        self.texture(role, info.index, info.tex_coord, transform, srgb).map(Some)
    }

    fn texture(
        &mut self,
        role: &str,
        index: Index<json::Texture>,
        tex_coord: u32,
        transform: Option<&TextureTransform>,
        srgb: bool,
    ) -> Result<TextureRef> {
        let info = Info::new(self.doc, self.by, role, index, tex_coord, transform)?;
        let (image, sampler) = resolve(self.doc, self.by, role, info.index)?;
        let image = self.images.color(image, srgb)?;
        Ok(TextureRef { image, sampler, tex_coord: info.tex_coord, transform: info.transform })
    }

    /// JSON has no infinity, but numbers beyond `f32` become it.
    fn finite<const N: usize>(&self, what: &str, values: [f32; N]) -> Result<[f32; N]> {
        if values.iter().all(|value| value.is_finite()) {
            return Ok(values);
        }
        Err(self.doc.error(self.by, format!("its {what} is not finite"), "correct the number"))
    }
}
