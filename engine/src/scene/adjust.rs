//! Other values for what a file's displaced materials say, before anything is made of them: so every technique, baseline
//! and reference sees the same surface.

use glam::{DAffine2, DVec2};

use super::{HeightSource, HeightTexels, Material, Scene, TextureRef, Wrap};
use crate::error::{Error, Result};

/// What replaces the displaced materials' own values; `None` and the default leave them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Adjustment {
    /// Factor of all the materials' UVs, above 0.
    pub uv_scale: Option<[f64; 2]>,
    /// Added to them after that.
    pub uv_offset: Option<[f64; 2]>,
    /// Turns heights around: 1 - h.
    pub height_flip: bool,
    /// [`super::Displacement::scale`], at least 0.
    pub height_scale: Option<f64>,
    /// [`super::Displacement::relative`].
    pub relative: Option<bool>,
    /// [`super::Displacement::midlevel`].
    pub midlevel: Option<f64>,
    /// Wrap of all the materials' textures, along u and v.
    pub wrap: Option<Wrap>,
}

impl Scene {
    /// Applies an adjustment to every material that asks for displacement.
    ///
    /// # Errors
    /// None asks for it; what a height function cannot do; a relative scale of a primitive without an area in UV.
    pub fn adjust(&mut self, adjustment: &Adjustment) -> Result<()> {
        if *adjustment == Adjustment::default() {
            return Ok(());
        }
        let displaced = |material: &&mut Material| material.displacement.is_some();
        let mut any = false;
        for material in self.materials.iter_mut().filter(displaced) {
            any = true;
            let mapped = adjustment.height_flip || adjustment.wrap.is_some() || adjustment.moves_uvs();
            let Some(displacement) = &mut material.displacement else { continue };
            if mapped && matches!(displacement.source, HeightSource::Procedure(_)) {
                return Err(Error::input(
                    &self.file,
                    format!("material '{}'", material.name),
                    "a function gives its heights, which has neither UV transform nor wrap and is not turned around",
                    "leave these out, or give it a height map",
                ));
            }
            let moved = adjustment.uv_transform();
            displacement.transform = moved * displacement.transform;
            displacement.scale = adjustment.height_scale.unwrap_or(displacement.scale);
            displacement.relative = adjustment.relative.unwrap_or(displacement.relative);
            displacement.midlevel = adjustment.midlevel.unwrap_or(displacement.midlevel);
            displacement.wrap = adjustment.wrap.map_or(displacement.wrap, |wrap| [wrap; 2]);
            for texture in textures(material) {
                texture.transform = moved * texture.transform;
                texture.sampler.wrap = adjustment.wrap.map_or(texture.sampler.wrap, |wrap| [wrap; 2]);
            }
        }
        if !any {
            return Err(Error::input(
                &self.file,
                "its materials",
                "none asks for displacement, so that there is nothing to adjust",
                "give one an extras.displacement, or leave the flags out",
            ));
        }
        if adjustment.height_flip {
            self.height_maps.iter_mut().for_each(|map| flip(&mut map.texels));
        }
        self.rescale()
    }

    /// What the primitives keep of their materials' scale.
    fn rescale(&mut self) -> Result<()> {
        for mesh in &mut self.meshes {
            for primitive in &mut mesh.primitives {
                let material = &self.materials[primitive.material];
                let Some(displacement) = material.displacement else { continue };
                let mut scale = displacement.scale;
                if displacement.relative && scale > 0.0 {
                    let (surface, uv) = primitive.areas(displacement.tex_coord);
                    scale *= (surface / uv).sqrt();
                }
                if !scale.is_finite() {
                    return Err(Error::input(
                        &self.file,
                        format!("mesh '{}'", mesh.name),
                        format!("its UVs cover no area, to which material '{}' has a relative scale", material.name),
                        "unwrap the mesh, or let the scale be absolute",
                    ));
                }
                primitive.displacement_scale = scale;
            }
        }
        Ok(())
    }
}

impl Adjustment {
    fn moves_uvs(&self) -> bool {
        self.uv_scale.is_some() || self.uv_offset.is_some()
    }

    fn uv_transform(&self) -> DAffine2 {
        let scale = DVec2::from(self.uv_scale.unwrap_or([1.0; 2]));
        DAffine2::from_scale_angle_translation(scale, 0.0, self.uv_offset.unwrap_or_default().into())
    }
}

fn textures(material: &mut Material) -> impl Iterator<Item = &mut TextureRef> {
    let normal = material.normal.as_mut().map(|(texture, _)| texture);
    let occlusion = material.occlusion.as_mut().map(|(texture, _)| texture);
    [material.base_color.as_mut(), material.metallic_roughness.as_mut(), normal, occlusion, material.emissive.as_mut()]
        .into_iter()
        .flatten()
}

fn flip(texels: &mut HeightTexels) {
    match texels {
        HeightTexels::U8(texels) => texels.iter_mut().for_each(|texel| *texel = u8::MAX - *texel),
        HeightTexels::U16(texels) => texels.iter_mut().for_each(|texel| *texel = u16::MAX - *texel),
    }
}
