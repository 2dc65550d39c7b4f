//! The buffers and images that a plan has created, by their names on the device. `tests/plan.rs` compares them with what
//! is really allocated.

use std::collections::{BTreeMap, BTreeSet};

use serde::Serialize;

use super::Situation;
use crate::gpu::{format_bytes, full_mip_count, vk};
use crate::render::aov::AovTargets;
use crate::render::geometry::PrimitiveData;
use crate::render::layout::{Counters, Frame, Light, Object, ShadowView};
use crate::render::plan::{self, Plan};
use crate::render::{
    DEPTH_FORMAT, baseline, blue_noise, culling, deform, depth_tiles, pyramid, resources, shadow, visibility,
};
use crate::scene::{HeightTexels, Scene, Wrap};
use crate::settings::{March, Settings};
use crate::shell::occlusion;

/// One buffer.
#[derive(Clone, Debug, Serialize)]
pub struct BufferFact {
    /// Debug name.
    pub name: String,
    /// Its content.
    pub bytes: u64,
}

/// One image.
#[derive(Clone, Debug, Serialize)]
pub struct ImageFact {
    /// Debug name.
    pub name: String,
    /// Texels.
    pub extent: [u32; 2],
    /// Vulkan's format.
    pub format: String,
    /// Mip levels.
    pub mips: u32,
    /// Samples a texel.
    pub samples: u32,
    /// Of all mips and samples.
    pub bytes: u64,
}

/// Buffers; what a frame in flight writes is listed once, for the first slot. Of a mesh that deforms as long as it has its
/// file's pose. A baseline that cannot be made has none of its own.
pub fn buffers(scene: &Scene, settings: &Settings, plan: &Plan, situation: &Situation) -> Vec<BufferFact> {
    let mut buffers = Vec::new();
    let mut add = |name: String, bytes: usize| {
        if bytes > 0 {
            buffers.push(BufferFact { name, bytes: bytes as u64 });
        }
    };
    for (index, planned) in plan.primitives.iter().enumerate() {
        let name = plan::primitive_name(scene, planned.mesh, planned.primitive);
        let data = PrimitiveData::new(scene, planned, settings);
        for (what, bytes) in data.buffers(planned.deforms) {
            add(format!("{name} {what}"), bytes);
        }
        if let Some(baseline) = settings.baseline.filter(|_| planned.shell.is_displaced()) {
            let named = plan.names_triangles(index);
            let own = baseline::buffers(scene, planned, &name, baseline, named).unwrap_or_default();
            own.into_iter().for_each(|(name, bytes)| add(name, bytes));
        }
    }
    deform::buffers(scene, plan).into_iter().for_each(|(name, bytes)| add(name, bytes));
    for (map, wrap) in pyramids(scene, plan) {
        let map = &scene.height_maps[map];
        add(format!("{} pyramid", map.name), pyramid::bytes([map.width, map.height], wrap));
    }
    let maps = plan.shadow_maps.as_ref().map_or(0, |maps| maps.count() as usize);
    add("frame of slot 0".into(), size_of::<Frame>());
    add("objects of slot 0".into(), size_of::<Object>() * plan.draws.len().max(1));
    add("lights of slot 0".into(), size_of::<Light>() * scene.lights.len());
    add("shadow views of slot 0".into(), size_of::<ShadowView>() * maps);
    for map in 0..maps {
        add(format!("frame of slot 0, shadow map {map}"), size_of::<Frame>());
        add(format!("objects of slot 0, shadow map {map}"), size_of::<Object>() * plan.draws.len());
    }
    for (index, draw) in plan.draws.iter().enumerate() {
        for (name, bytes) in culling::buffers(index, draw) {
            add(name, bytes);
        }
    }
    if plan.hides() {
        add(depth_tiles::NAME.into(), depth_tiles::bytes(situation.extent));
    }
    let counts = plan.draws.iter().any(|draw| draw.variant.cull.is_some_and(|cull| cull.counted));
    add("culled prisms of slot 0".into(), if counts { size_of::<culling::Counts>() } else { 0 });
    add("counters of slot 0".into(), if settings.counts() { size_of::<Counters>() } else { 0 });
    buffers
}

/// Height maps, with their wrap, that an exact march reads.
fn pyramids(scene: &Scene, plan: &Plan) -> Vec<(usize, [Wrap; 2])> {
    let mut maps = Vec::new();
    for draw in &plan.draws {
        let Some(height) = draw.variant.height.filter(|height| height.march == March::Exact) else { continue };
        let material = &scene.materials[plan::source(scene, &plan.primitives[draw.primitive]).material];
        let key = material.displacement.and_then(|d| Some((d.source.map()?, height.wrap)));
        maps.extend(key.filter(|key| !maps.contains(key)));
    }
    maps
}

/// Images, the picture's own among them.
pub fn images(scene: &Scene, settings: &Settings, plan: &Plan, situation: &Situation) -> Vec<ImageFact> {
    let mut images = Vec::new();
    let mut add = |name: String, extent: [u32; 2], format: vk::Format, mips: u32, samples: u32| {
        let texels: u64 = (0..mips).map(|mip| extent.map(|n| u64::from(n >> mip).max(1)).iter().product::<u64>()).sum();
        let bytes = texels * format_bytes(format).unwrap_or(0) * u64::from(samples);
        images.push(ImageFact { name, extent, format: format!("{format:?}"), mips, samples, bytes });
    };
    let mut colors = BTreeSet::new();
    let mut occlusions = BTreeMap::new();
    let mut cones = BTreeSet::new();
    for draw in &plan.draws {
        let planned = &plan.primitives[draw.primitive];
        let primitive = plan::source(scene, planned);
        let material = &scene.materials[primitive.material];
        for (texture, set) in material.textures().into_iter().zip(draw.variant.textures) {
            if let Some(texture) = texture.filter(|_| set.is_some()) {
                colors.insert(texture.image);
            }
        }
        let Some(height) = draw.variant.height else { continue };
        let Some(displacement) = material.displacement else { continue };
        if height.ambient_occlusion {
            let extent = occlusion::texels(scene, displacement.source).map(|n| n as u32);
            occlusions.insert([planned.mesh, planned.primitive], extent);
        }
        if let Some(map) = displacement.source.map().filter(|_| height.march.reads_cones()) {
            cones.insert((map, height.wrap.map(Wrap::name), height.march.name()));
        }
    }
    for index in colors {
        let image = &scene.images[index];
        let extent = [image.width, image.height];
        let mips = if plan.mips.contains(&index) { full_mip_count(extent) } else { 1 };
        add(image.name.clone(), extent, resources::color_format(image), mips, 1);
    }
    for (index, map) in scene.height_maps.iter().enumerate() {
        let extent = [map.width, map.height];
        let of = format!("height map '{}'", map.name);
        let kept = |what: &str| plan.ledger.find(&of, what).is_some_and(|decision| decision.kept);
        if kept("image") {
            let format = match &map.texels {
                HeightTexels::F16(_) => vk::Format::R16_SFLOAT,
                HeightTexels::U16(_) if plan.sixteen_bits.contains(&index) => vk::Format::R16_UNORM,
                HeightTexels::U16(_) | HeightTexels::U8(_) => vk::Format::R8_UNORM,
            };
            add(map.name.clone(), extent, format, 1, 1);
        }
        if kept("mips") {
            add(resources::height_mips_name(map), extent, vk::Format::R16_UNORM, full_mip_count(extent), 1);
        }
    }
    for (map, ..) in cones {
        let map = &scene.height_maps[map];
        add(format!("{} cones", map.name), [map.width, map.height], vk::Format::R16_UNORM, 1, 1);
    }
    for ([mesh, primitive], extent) in occlusions {
        let name = format!("{} ambient occlusion", plan::primitive_name(scene, mesh, primitive));
        add(name, extent, vk::Format::R8_UNORM, full_mip_count(extent), 1);
    }
    if plan.draws.iter().any(|draw| draw.variant.dithers()) {
        add("blue noise".into(), [blue_noise::SIDE as u32; 2], vk::Format::R8_UNORM, 1, 1);
    }
    if let Some(maps) = &plan.shadow_maps {
        let extent = shadow::atlas(maps.count(), settings.shadow_map_size, situation.max_image_2d);
        add("shadow maps".into(), extent, DEPTH_FORMAT, 1, 1);
    }
    let Situation { extent, output, .. } = *situation;
    add("picture".into(), extent, output.color_format, 1, 1);
    add("depth".into(), extent, DEPTH_FORMAT, 1, settings.msaa);
    for (name, format) in plan.named().map_or(&[][..], visibility::images) {
        add((*name).into(), extent, *format, 1, 1);
    }
    if settings.msaa > 1 {
        add("samples".into(), extent, output.color_format, 1, settings.msaa);
    }
    if output.aov {
        for (name, format) in AovTargets::targets() {
            add(name.into(), extent, format, 1, 1);
        }
        if settings.msaa > 1 {
            add("depth of AOVs".into(), extent, DEPTH_FORMAT, 1, 1);
        }
    }
    images
}
