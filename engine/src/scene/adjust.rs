//! Other values for what a file's displaced materials say, before anything is made of them: so every technique, baseline
//! and reference sees the same surface.

use glam::{DAffine2, DVec2};
use half::f16;

use super::{Channel, HeightMap, HeightSource, HeightTexels, Material, Scene, TextureRef, Wrap};
use crate::error::{Error, Result};

/// How textures go on beyond their edges: as glTF has it, or not at all.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Beyond {
    /// As this mode has it.
    Wrap(Wrap),
    /// Height maps end in height 0, half a texel beyond their edges; the other textures are clamped.
    Border,
}

impl Beyond {
    /// Every way.
    pub const ALL: &'static [Beyond] =
        &[Beyond::Wrap(Wrap::Repeat), Beyond::Wrap(Wrap::Mirror), Beyond::Wrap(Wrap::Clamp), Beyond::Border];

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Beyond::Wrap(wrap) => wrap.name(),
            Beyond::Border => "border",
        }
    }

    /// The sampler's part in it.
    fn wrap(self) -> Wrap {
        match self {
            Beyond::Wrap(wrap) => wrap,
            Beyond::Border => Wrap::Clamp,
        }
    }
}

/// The texels in which height maps are kept.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum HeightFormat {
    /// Those of the file: 8 or 16 bits.
    #[default]
    Auto,
    /// 8 bits: half of the memory of 16, off by 1/510 at most.
    R8,
    /// 16 bits.
    R16,
    /// Half floats: 11 significant bits, so that heights above 1/2 are off by 1/4096 at most, lower ones by less. On
    /// devices without 16-bit integers to sample, half of the memory of [`HeightFormat::R16`].
    R16F,
}

impl HeightFormat {
    /// Every format.
    pub const ALL: &'static [HeightFormat] =
        &[HeightFormat::Auto, HeightFormat::R8, HeightFormat::R16, HeightFormat::R16F];

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            HeightFormat::Auto => "auto",
            HeightFormat::R8 => "r8",
            HeightFormat::R16 => "r16",
            HeightFormat::R16F => "r16f",
        }
    }
}

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
    pub wrap: Option<Beyond>,
    /// Halvings of the height maps.
    pub height_lod: u32,
    /// Texels of the height maps.
    pub height_format: HeightFormat,
    /// [`Material::roughness_channel`].
    pub roughness_channel: Option<Channel>,
    /// [`Material::metallic_channel`].
    pub metallic_channel: Option<Channel>,
    /// [`Material::specular`], 0 to 1.
    pub specular: Option<f32>,
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
        if adjustment.height_flip {
            self.height_maps.iter_mut().for_each(|map| flip(&mut map.texels));
        }
        if adjustment.height_lod > 0 {
            self.height_maps.iter_mut().for_each(|map| *map = halved(map, adjustment.height_lod));
        }
        let sizes: Vec<[u32; 2]> = self.height_maps.iter().map(|map| [map.width, map.height]).collect();
        if adjustment.wrap == Some(Beyond::Border) {
            self.height_maps.iter_mut().for_each(|map| *map = bordered(map));
        }
        if adjustment.height_format != HeightFormat::Auto {
            self.height_maps.iter_mut().for_each(|map| map.texels = kept_as(map, adjustment.height_format));
        }
        let displaced = |material: &&mut Material| material.displacement.is_some();
        let mut any = false;
        for material in self.materials.iter_mut().filter(displaced) {
            any = true;
            let mapped = adjustment.height_flip
                || adjustment.wrap.is_some()
                || adjustment.height_lod > 0
                || adjustment.height_format != HeightFormat::Auto
                || adjustment.moves_uvs();
            material.roughness_channel = adjustment.roughness_channel.unwrap_or(material.roughness_channel);
            material.metallic_channel = adjustment.metallic_channel.unwrap_or(material.metallic_channel);
            material.specular = adjustment.specular.unwrap_or(material.specular);
            let Some(displacement) = &mut material.displacement else { continue };
            if mapped && matches!(displacement.source, HeightSource::Procedure(_)) {
                return Err(Error::input(
                    &self.file,
                    format!("material '{}'", material.name),
                    "a function gives its heights, which has neither UV transform nor wrap nor LOD nor texels and is not turned around",
                    "leave these out, or give it a height map",
                ));
            }
            let moved = adjustment.uv_transform();
            displacement.transform = moved * displacement.transform;
            displacement.scale = adjustment.height_scale.unwrap_or(displacement.scale);
            displacement.relative = adjustment.relative.unwrap_or(displacement.relative);
            displacement.midlevel = adjustment.midlevel.unwrap_or(displacement.midlevel);
            displacement.wrap = adjustment.wrap.map_or(displacement.wrap, |beyond| [beyond.wrap(); 2]);
            if let (Some(Beyond::Border), HeightSource::Map(map)) = (adjustment.wrap, displacement.source) {
                displacement.transform = into_border(sizes[map]) * displacement.transform;
            }
            for texture in textures(material) {
                texture.transform = moved * texture.transform;
                texture.sampler.wrap = adjustment.wrap.map_or(texture.sampler.wrap, |beyond| [beyond.wrap(); 2]);
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
    [
        material.base_color.as_mut(),
        material.metallic_roughness.as_mut(),
        normal,
        occlusion,
        material.emissive.as_mut(),
        material.specular_map.as_mut(),
        material.specular_color.as_mut(),
    ]
    .into_iter()
    .flatten()
}

fn flip(texels: &mut HeightTexels) {
    match texels {
        HeightTexels::U8(texels) => texels.iter_mut().for_each(|texel| *texel = u8::MAX - *texel),
        HeightTexels::U16(texels) => texels.iter_mut().for_each(|texel| *texel = u16::MAX - *texel),
        HeightTexels::F16(texels) => texels.iter_mut().for_each(|h| *h = f16::from_f64(1.0 - h.to_f64())),
    }
}

/// A map's texels in another format, each rounded to the nearest that it has.
fn kept_as(map: &HeightMap, format: HeightFormat) -> HeightTexels {
    let heights = (0..map.height).flat_map(|y| (0..map.width).map(move |x| map.height(x, y)));
    match format {
        HeightFormat::Auto => map.texels.clone(),
        HeightFormat::R8 => HeightTexels::U8(heights.map(|h| (h * f64::from(u8::MAX)).round() as u8).collect()),
        HeightFormat::R16 => HeightTexels::U16(heights.map(|h| (h * f64::from(u16::MAX)).round() as u16).collect()),
        HeightFormat::R16F => HeightTexels::F16(heights.map(nearest_half).collect()),
    }
}

/// The half float nearest to a height. The library's own conversion cuts an f64 to 20 bits before it rounds, so that next
/// to the middle between two it may take the farther one.
fn nearest_half(height: f64) -> f16 {
    let about = f16::from_f64(height).to_bits();
    let off = |half: &f16| (half.to_f64() - height).abs();
    let near = [about, about.saturating_sub(1), about + 1].map(f16::from_bits);
    near.into_iter().min_by(|a, b| off(a).total_cmp(&off(b))).expect("there are three")
}

/// The map at mip `lod`, of half the size so many times: each texel the mean over its area, at 16 bits.
fn halved(map: &HeightMap, lod: u32) -> HeightMap {
    let half = |n: u32| n.checked_shr(lod).unwrap_or(0).max(1);
    let [width, height] = [half(map.width), half(map.height)];
    // The share of each texel of a row of `from` in texel `i` of a row of `to`.
    let shares = |i: u32, from: u32, to: u32| {
        let ratio = f64::from(from) / f64::from(to);
        let [low, high] = [f64::from(i) * ratio, f64::from(i + 1) * ratio];
        let texels = low.floor() as u32..(high.ceil() as u32).min(from);
        texels.map(move |t| (t, (high.min(f64::from(t + 1)) - low.max(f64::from(t))).max(0.0) / ratio))
    };
    let narrow: Vec<f64> = (0..map.height)
        .flat_map(|y| {
            (0..width).map(move |x| shares(x, map.width, width).map(|(t, share)| share * map.height(t, y)).sum())
        })
        .collect();
    let mean = |x: u32, y: u32| -> f64 {
        shares(y, map.height, height).map(|(t, share)| share * narrow[(t * width + x) as usize]).sum()
    };
    let texels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let texels = texels.map(|(x, y)| (mean(x, y) * f64::from(u16::MAX)).round() as u16).collect();
    HeightMap { name: map.name.clone(), width, height, texels: HeightTexels::U16(texels) }
}

/// The map within a border of zeros, one texel wide: clamped, it is 0 everywhere beyond.
fn bordered(map: &HeightMap) -> HeightMap {
    fn around<T: Copy + Default>(texels: &[T], width: usize) -> Vec<T> {
        let beyond = vec![T::default(); width + 2];
        let rows = texels.chunks_exact(width).flat_map(|row| [&[T::default()], row, &[T::default()]].concat());
        beyond.iter().copied().chain(rows).chain(beyond.iter().copied()).collect()
    }
    let texels = match &map.texels {
        HeightTexels::U8(texels) => HeightTexels::U8(around(texels, map.width as usize)),
        HeightTexels::U16(texels) => HeightTexels::U16(around(texels, map.width as usize)),
        HeightTexels::F16(texels) => HeightTexels::F16(around(texels, map.width as usize)),
    };
    HeightMap { name: map.name.clone(), width: map.width + 2, height: map.height + 2, texels }
}

/// From coordinates of a map of `size` to those of it within its border.
fn into_border(size: [u32; 2]) -> DAffine2 {
    let [within, whole] = [size.map(f64::from), size.map(|n| f64::from(n + 2))].map(DVec2::from);
    DAffine2::from_scale_angle_translation(within / whole, 0.0, whole.recip())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_halved_map_holds_the_means_of_its_areas() {
        let texels = HeightTexels::U8(vec![0, 255, 51, 102, 153, 0]);
        let map = HeightMap { name: String::new(), width: 3, height: 2, texels };
        let heights = |lod: u32| {
            let map = halved(&map, lod);
            let texel = |i: u32| (map.height(i % map.width, i / map.width) * 1e4).round() / 1e4;
            ([map.width, map.height], (0..map.width * map.height).map(texel).collect::<Vec<_>>())
        };
        // 561 of 6 · 255; one texel is left however often it is halved.
        assert_eq!(heights(1), ([1, 1], vec![0.3667]));
        assert_eq!(heights(1), heights(40));
        let texels = HeightTexels::U16((0..5).map(|i| i * 10000).collect());
        let map = HeightMap { name: String::new(), width: 5, height: 1, texels };
        // Two texels and a half each: (0 + 1 + 2 / 2) / 2.5 and (2 / 2 + 3 + 4) / 2.5.
        assert!(matches!(halved(&map, 1).texels, HeightTexels::U16(texels) if texels == [8000, 32000]));
    }

    /// The loss that [`HeightFormat`] states, over every 16-bit height.
    #[test]
    fn formats_lose_what_they_say() {
        let texels = HeightTexels::U16((0..=u16::MAX).collect());
        let map = HeightMap { name: String::new(), width: 256, height: 256, texels };
        let most_off = |format: HeightFormat| {
            let kept = HeightMap { texels: kept_as(&map, format), ..map.clone() };
            let off = |i: u32| (kept.height(i % 256, i / 256) - map.height(i % 256, i / 256)).abs();
            (0..1 << 16).map(off).fold(0.0, f64::max)
        };
        assert_eq!(most_off(HeightFormat::R16), 0.0);
        assert!((0.99..=1.0).contains(&(most_off(HeightFormat::R8) * 510.0)));
        assert!((0.95..=1.0).contains(&(most_off(HeightFormat::R16F) * 4096.0)));
        // 8 bits are kept by 16 of either kind well enough to be had back.
        let eight = HeightTexels::U8((0..=u8::MAX).collect());
        let map = HeightMap { name: String::new(), width: 16, height: 16, texels: eight };
        let half = HeightMap { texels: kept_as(&map, HeightFormat::R16F), ..map.clone() };
        let back = kept_as(&half, HeightFormat::R8);
        assert!(matches!((back, map.texels), (HeightTexels::U8(back), HeightTexels::U8(texels)) if back == texels));
    }
}
