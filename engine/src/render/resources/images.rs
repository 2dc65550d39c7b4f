//! The images that a plan's draws read, and their samplers.

use std::collections::{HashMap, hash_map::Entry};
use std::path::Path;

use half::f16;

use crate::error::{Error, Result};
use crate::gpu::{Binding, Buffer, Context, Image, ImageDesc, Sampler, SamplerDesc, ShaderCompiler, Uploader, vk};
use crate::render::blue_noise;
use crate::render::plan::{Plan, PlannedPrimitive, source};
use crate::render::variant::{Height, OTHER_NAMES, TEXTURE_NAMES, Variant};
use crate::render::{cones, pyramid};
use crate::scene::{ColorImage, HeightMap, HeightTexels, Material, Sampler as SceneSampler, Scene, Wrap};
use crate::settings::March;
use crate::shell::{cones::ConeKind, occlusion};

/// Largest anisotropy of colour textures, where the device has the feature.
const ANISOTROPY: f32 = 8.0;

/// The images that the plan's draws read, and their samplers.
#[derive(Default)]
pub struct Images {
    color: HashMap<usize, Image>,
    heights: HashMap<usize, Image>,
    /// The same with mips, where each pixel reads them at its own LOD.
    height_mips: HashMap<usize, Image>,
    samplers: HashMap<SceneSampler, Sampler>,
    /// For gathers: the filter is the shader's own.
    height_samplers: HashMap<[Wrap; 2], Sampler>,
    /// Blue noise, where something is dithered.
    noise: Option<(Image, Sampler)>,
    /// Min-max pyramids of height maps, for the exact march.
    pyramids: HashMap<(usize, [Wrap; 2]), Buffer>,
    /// Ambient occlusion of height fields, by mesh and primitive: it follows from their scale and proportions too.
    occlusions: HashMap<[usize; 2], Image>,
    /// And for height maps with mips.
    smooth_samplers: HashMap<[Wrap; 2], Sampler>,
    /// Cone maps of height maps, for the cone marches.
    cones: HashMap<(usize, [Wrap; 2], ConeKind), Image>,
}

impl Images {
    /// Uploads what `plan` reads and is not here yet.
    pub fn complete(&mut self, ctx: &Context, compiler: &ShaderCompiler, scene: &Scene, plan: &Plan) -> Result<()> {
        let mut uploader = Uploader::new(ctx)?;
        for draw in &plan.draws {
            let primitive = source(scene, &plan.primitives[draw.primitive]);
            let material = &scene.materials[primitive.material];
            let read = |(texture, set): (Option<_>, Option<u8>)| texture.filter(|_| set.is_some());
            for texture in material.textures().into_iter().zip(draw.variant.textures).filter_map(read) {
                let (image, mips) = (texture.image, plan.mips.contains(&texture.image));
                // What had no use for mips may have by now.
                if self.color.get(&image).is_none_or(|made| mips && made.mips() == 1) {
                    self.color.insert(image, upload_color(ctx, &mut uploader, scene, image, mips)?);
                }
                if let Entry::Vacant(entry) = self.samplers.entry(texture.sampler) {
                    entry.insert(sampler(ctx, texture.sampler)?);
                }
            }
            for (map, wrap) in height_maps(scene, &plan.primitives[draw.primitive], &draw.variant) {
                if let Entry::Vacant(entry) = self.heights.entry(map) {
                    let narrow = !plan.sixteen_bits.contains(&map);
                    entry.insert(upload_height(ctx, &mut uploader, &scene.file, &scene.height_maps[map], narrow)?);
                }
                if let Entry::Vacant(entry) = self.height_samplers.entry(wrap) {
                    entry.insert(height_sampler(ctx, wrap)?);
                }
            }
            if draw.variant.height.is_some_and(|height| height.ambient_occlusion) {
                let planned = &plan.primitives[draw.primitive];
                if let Entry::Vacant(entry) = self.occlusions.entry([planned.mesh, planned.primitive]) {
                    entry.insert(bake_occlusion(&mut uploader, scene, planned)?);
                }
            }
            let smooth = |height: &Height| height.ambient_occlusion || height.pixel_lod;
            if let Some(height) = draw.variant.height.filter(smooth)
                && let Entry::Vacant(entry) = self.smooth_samplers.entry(height.wrap)
            {
                let desc = SamplerDesc { wrap: address_modes(height.wrap), ..SamplerDesc::default() };
                entry.insert(Sampler::new(ctx, &desc)?);
            }
            if let (Some(true), Some(map)) = (draw.variant.height.map(|h| h.pixel_lod), own_map(material))
                && let Entry::Vacant(entry) = self.height_mips.entry(map)
            {
                entry.insert(upload_height_mips(ctx, &mut uploader, &scene.height_maps[map])?);
            }
        }
        if self.noise.is_none() && plan.draws.iter().any(|draw| draw.variant.dithers()) {
            let desc = image_desc("blue noise", [blue_noise::SIDE as u32; 2], vk::Format::R8_UNORM);
            let image = uploader.image(&desc, &blue_noise::texels())?;
            self.noise = Some((image, height_sampler(ctx, [Wrap::Repeat; 2])?));
        }
        uploader.finish()?;
        for draw in &plan.draws {
            let material = &scene.materials[source(scene, &plan.primitives[draw.primitive]).material];
            let (Some(height), Some(map)) = (draw.variant.height, own_map(material)) else { continue };
            let (image, sampler) = (&self.heights[&map], &self.height_samplers[&height.wrap]);
            let key = (map, height.wrap);
            if height.march == March::Exact && !self.pyramids.contains_key(&key) {
                let pyramid = pyramid::build(ctx, compiler, image, sampler, height.wrap)?;
                self.pyramids.insert(key, pyramid);
                continue;
            }
            let Some(kind) = cone_kind(height.march) else { continue };
            if let Entry::Vacant(entry) = self.cones.entry((map, height.wrap, kind)) {
                let heights = &scene.height_maps[map];
                let roots = cones::build(ctx, compiler, heights, (image, sampler), height.wrap, kind, |_| ())?;
                let mut uploader = Uploader::new(ctx)?;
                let name = format!("{} cones", heights.name);
                let cones = upload_16_bits(ctx, &mut uploader, &name, image.extent(), &roots)?;
                uploader.finish()?;
                entry.insert(cones);
            }
        }
        Ok(())
    }

    /// A height map and its sampler, uploaded before.
    fn height(&self, map: usize, wrap: [Wrap; 2]) -> (&Image, &Sampler) {
        (&self.heights[&map], &self.height_samplers[&wrap])
    }

    /// The image bindings of one draw.
    pub(super) fn bindings(
        &self,
        scene: &Scene,
        planned: &PlannedPrimitive,
        variant: &Variant,
    ) -> Vec<(&str, Binding<'_>)> {
        let material = &scene.materials[source(scene, planned).material];
        let mut bindings: Vec<_> = TEXTURE_NAMES
            .into_iter()
            .zip(material.textures())
            .zip(variant.textures)
            .filter_map(|((name, texture), set)| {
                let texture = texture.filter(|_| set.is_some())?;
                Some((name, Binding::Image(&self.color[&texture.image], &self.samplers[&texture.sampler])))
            })
            .collect();
        if let Some((image, sampler)) = self.noise.as_ref().filter(|_| variant.dithers()) {
            bindings.push(("blue_noise", Binding::Image(image, sampler)));
        }
        if let (Some(height), Some(map)) = (variant.height, own_map(material)) {
            let (image, sampler) = self.height(map, height.wrap);
            bindings.push(("height_map", Binding::Image(image, sampler)));
            if height.pixel_lod {
                let smooth = &self.smooth_samplers[&height.wrap];
                bindings.push(("height_mips", Binding::Image(&self.height_mips[&map], smooth)));
            }
            let pyramid = self.pyramids.get(&(map, height.wrap));
            bindings.extend(pyramid.map(|buffer| ("pyramid", Binding::Buffer(buffer))));
            let cones = cone_kind(height.march).and_then(|kind| self.cones.get(&(map, height.wrap, kind)));
            bindings.extend(cones.map(|cones| ("cone_map", Binding::Image(cones, sampler))));
        }
        if let Some(height) = variant.height.filter(|height| height.ambient_occlusion) {
            let image = &self.occlusions[&[planned.mesh, planned.primitive]];
            let sampler = &self.smooth_samplers[&height.wrap];
            bindings.push(("ambient_occlusion_map", Binding::Image(image, sampler)));
        }
        if variant.height.is_some() {
            for (name, other) in OTHER_NAMES.into_iter().zip(&planned.shell.others) {
                let map = other.source.map().map(|map| self.height(map, other.wrap));
                bindings.extend(map.map(|(image, sampler)| (name, Binding::Image(image, sampler))));
            }
        }
        bindings
    }
}

/// The cones that a march reads.
fn cone_kind(march: March) -> Option<ConeKind> {
    match march {
        March::Cone => Some(ConeKind::Plain),
        March::RelaxedCone => Some(ConeKind::Relaxed),
        _ => None,
    }
}

/// The map that a material's displacement reads; a procedure reads none.
fn own_map(material: &Material) -> Option<usize> {
    material.displacement?.source.map()
}

/// The maps that a draw reads, with their wrap: its own field's and those of its neighbours.
fn height_maps(scene: &Scene, planned: &PlannedPrimitive, variant: &Variant) -> Vec<(usize, [Wrap; 2])> {
    if variant.height.is_none() {
        return Vec::new();
    }
    let own = scene.materials[source(scene, planned).material].displacement.map(|d| (d.source, d.wrap));
    let others = planned.shell.others.iter().map(|other| (other.source, other.wrap));
    own.into_iter().chain(others).filter_map(|(source, wrap)| Some((source.map()?, wrap))).collect()
}

/// Refuses an image that the device cannot hold.
fn check_size(ctx: &Context, file: &Path, name: &str, extent: [u32; 2]) -> Result<()> {
    let most = ctx.max_image_2d();
    if extent.iter().all(|n| *n <= most) {
        return Ok(());
    }
    Err(Error::input(
        file,
        format!("image '{name}'"),
        format!("{} x {} texels, and '{}' holds at most {most} a side", extent[0], extent[1], ctx.device_name()),
        "scale the image down",
    ))
}

fn upload_color(ctx: &Context, uploader: &mut Uploader, scene: &Scene, index: usize, mips: bool) -> Result<Image> {
    let image = &scene.images[index];
    let extent = [image.width, image.height];
    check_size(ctx, &scene.file, &image.name, extent)?;
    let desc = image_desc(&image.name, extent, color_format(image));
    if mips { uploader.image_with_mips(&desc, &image.rgba) } else { uploader.image(&desc, &image.rgba) }
}

/// The format of a colour image.
pub fn color_format(image: &ColorImage) -> vk::Format {
    if image.srgb { vk::Format::R8G8B8A8_SRGB } else { vk::Format::R8G8B8A8_UNORM }
}

/// At the depth of its file, or `narrow`, at 8 bits, which hold its heights exactly; where the device cannot sample
/// 16-bit integers, as f32, which holds them exactly too.
pub fn upload_height(
    ctx: &Context,
    uploader: &mut Uploader,
    file: &Path,
    map: &HeightMap,
    narrow: bool,
) -> Result<Image> {
    let extent = [map.width, map.height];
    check_size(ctx, file, &map.name, extent)?;
    match &map.texels {
        HeightTexels::U8(texels) => uploader.image(&image_desc(&map.name, extent, vk::Format::R8_UNORM), texels),
        HeightTexels::U16(texels) if narrow => {
            let texels: Vec<u8> = texels.iter().map(|texel| (texel / 257) as u8).collect();
            uploader.image(&image_desc(&map.name, extent, vk::Format::R8_UNORM), &texels)
        }
        HeightTexels::U16(texels) => upload_16_bits(ctx, uploader, &map.name, extent, texels),
        HeightTexels::F16(texels) => {
            uploader.image(&image_desc(&map.name, extent, vk::Format::R16_SFLOAT), bytemuck::cast_slice(texels))
        }
    }
}

/// A height map with all its mips, for the LOD of each pixel: 16 bits, of whatever kind the device scales and filters.
fn upload_height_mips(ctx: &Context, uploader: &mut Uploader, map: &HeightMap) -> Result<Image> {
    let heights = (0..map.height).flat_map(|y| (0..map.width).map(move |x| map.height(x, y)));
    let scales = vk::FormatFeatureFlags::BLIT_SRC
        | vk::FormatFeatureFlags::BLIT_DST
        | vk::FormatFeatureFlags::SAMPLED_IMAGE_FILTER_LINEAR;
    let name = height_mips_name(map);
    let extent = [map.width, map.height];
    if ctx.supports_format(vk::Format::R16_UNORM, scales) {
        let texels: Vec<u16> = heights.map(|h| (h * f64::from(u16::MAX)).round() as u16).collect();
        let desc = image_desc(&name, extent, vk::Format::R16_UNORM);
        return uploader.image_with_mips(&desc, bytemuck::cast_slice(&texels));
    }
    let texels: Vec<f16> = heights.map(f16::from_f64).collect();
    uploader.image_with_mips(&image_desc(&name, extent, vk::Format::R16_SFLOAT), bytemuck::cast_slice(&texels))
}

/// What that image is called.
pub fn height_mips_name(map: &HeightMap) -> String {
    format!("{} mips", map.name)
}

/// The occlusion map of a displaced primitive, computed on the CPU.
fn bake_occlusion(uploader: &mut Uploader, scene: &Scene, planned: &PlannedPrimitive) -> Result<Image> {
    let primitive = source(scene, planned);
    let map = occlusion::of_primitive(scene, primitive);
    let name = format!("{}.{} ambient occlusion", scene.meshes[planned.mesh].name, planned.primitive);
    let extent = map.size.map(|n| n as u32);
    uploader.image_with_mips(&image_desc(&name, extent, vk::Format::R8_UNORM), &map.texels)
}

fn upload_16_bits(
    ctx: &Context,
    uploader: &mut Uploader,
    name: &str,
    extent: [u32; 2],
    texels: &[u16],
) -> Result<Image> {
    if ctx.supports_format(vk::Format::R16_UNORM, vk::FormatFeatureFlags::SAMPLED_IMAGE) {
        return uploader.image(&image_desc(name, extent, vk::Format::R16_UNORM), bytemuck::cast_slice(texels));
    }
    let texels: Vec<f32> = texels.iter().map(|t| f32::from(*t) / 65535.0).collect();
    uploader.image(&image_desc(name, extent, vk::Format::R32_SFLOAT), bytemuck::cast_slice(&texels))
}

fn image_desc(name: &str, extent: [u32; 2], format: vk::Format) -> ImageDesc<'_> {
    let samples = vk::SampleCountFlags::TYPE_1;
    ImageDesc { name, extent, format, mips: 1, samples, usage: vk::ImageUsageFlags::SAMPLED }
}

fn address_modes(wrap: [Wrap; 2]) -> [vk::SamplerAddressMode; 2] {
    wrap.map(|wrap| match wrap {
        Wrap::Repeat => vk::SamplerAddressMode::REPEAT,
        Wrap::Mirror => vk::SamplerAddressMode::MIRRORED_REPEAT,
        Wrap::Clamp => vk::SamplerAddressMode::CLAMP_TO_EDGE,
    })
}

/// A sampler for gathers from a height map that wraps so.
pub fn height_sampler(ctx: &Context, wrap: [Wrap; 2]) -> Result<Sampler> {
    Sampler::new(ctx, &SamplerDesc { wrap: address_modes(wrap), ..SamplerDesc::nearest() })
}

fn sampler(ctx: &Context, sampler: SceneSampler) -> Result<Sampler> {
    Sampler::new(
        ctx,
        &SamplerDesc {
            mag: if sampler.nearest { vk::Filter::NEAREST } else { vk::Filter::LINEAR },
            wrap: address_modes(sampler.wrap),
            max_lod: if sampler.no_mips { 0.0 } else { vk::LOD_CLAMP_NONE },
            anisotropy: if sampler.nearest { 1.0 } else { ANISOTROPY },
            ..SamplerDesc::default()
        },
    )
}
