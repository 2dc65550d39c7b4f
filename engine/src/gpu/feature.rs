//! Device features by name: asked for, masked, and only then enabled.

use std::fmt;

use ash::vk;

use crate::error::{Error, Result};

/// Something that a device may lack. Enabled only where a [`super::ContextDesc`] asks for it.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Feature {
    /// The classic geometry stage.
    GeometryShader,
    /// The two stages of hardware tessellation.
    TessellationShader,
    /// `VK_EXT_mesh_shader` with its mesh stage.
    MeshShader,
    /// The task stage before the mesh stage.
    TaskShader,
    /// Statistics that count mesh and task invocations.
    MeshShaderQueries,
    /// Polygon modes other than fill.
    FillModeNonSolid,
    /// Pipeline statistics queries.
    PipelineStatistics,
    /// Anisotropic filtering.
    SamplerAnisotropy,
    /// Storage writes and atomics in fragment shaders.
    FragmentStoresAndAtomics,
    /// Fragment shaders that run once for each sample.
    SampleRateShading,
}

impl Feature {
    /// Every feature, in the order of reports.
    pub const ALL: &'static [Feature] = &[
        Feature::GeometryShader,
        Feature::TessellationShader,
        Feature::MeshShader,
        Feature::TaskShader,
        Feature::MeshShaderQueries,
        Feature::FillModeNonSolid,
        Feature::PipelineStatistics,
        Feature::SamplerAnisotropy,
        Feature::FragmentStoresAndAtomics,
        Feature::SampleRateShading,
    ];

    /// The name in reports and in `PRISM_MASK_FEATURES`.
    pub fn name(self) -> &'static str {
        match self {
            Feature::GeometryShader => "geometry",
            Feature::TessellationShader => "tessellation",
            Feature::MeshShader => "mesh",
            Feature::TaskShader => "task",
            Feature::MeshShaderQueries => "mesh-queries",
            Feature::FillModeNonSolid => "fill-mode-non-solid",
            Feature::PipelineStatistics => "pipeline-statistics",
            Feature::SamplerAnisotropy => "anisotropy",
            Feature::FragmentStoresAndAtomics => "fragment-stores",
            Feature::SampleRateShading => "sample-rate-shading",
        }
    }

    /// Whether the feature comes with `VK_EXT_mesh_shader`.
    pub(super) fn needs_mesh_extension(self) -> bool {
        matches!(self, Feature::MeshShader | Feature::TaskShader | Feature::MeshShaderQueries)
    }
}

impl fmt::Display for Feature {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// What tests pretend to be absent or smaller than it is.
#[derive(Clone, Debug, Default)]
pub(super) struct Masks {
    features: Vec<Feature>,
    max_image_2d: Option<u32>,
}

impl Masks {
    /// The caller's masks and those of the environment (see [`crate::gpu`]).
    pub fn new(masked: &[Feature]) -> Result<Self> {
        let features = std::env::var("PRISM_MASK_FEATURES").unwrap_or_default();
        let limits = std::env::var("PRISM_MASK_LIMITS").unwrap_or_default();
        Self::parse(masked, &features, &limits)
    }

    fn parse(masked: &[Feature], features: &str, limits: &str) -> Result<Self> {
        let mut masks = Masks { features: masked.to_vec(), max_image_2d: None };
        for word in words(features) {
            let known = Feature::ALL.iter().find(|f| f.name() == word);
            masks.features.push(*known.ok_or_else(|| {
                let names: Vec<_> = Feature::ALL.iter().map(|f| f.name()).collect();
                Error::Usage(format!("PRISM_MASK_FEATURES: no feature '{word}'; there are {}", names.join(", ")))
            })?);
        }
        for word in words(limits) {
            let value = word.strip_prefix("maxImageDimension2D=").and_then(|v| v.parse().ok());
            masks.max_image_2d = Some(value.ok_or_else(|| {
                Error::Usage(format!("PRISM_MASK_LIMITS: '{word}' is not maxImageDimension2D=NUMBER"))
            })?);
        }
        Ok(masks)
    }

    /// Whether the feature counts as absent. Without the mesh stage nothing else of its extension is of use.
    pub fn hides(&self, feature: Feature) -> bool {
        self.features.contains(&feature)
            || feature.needs_mesh_extension() && self.features.contains(&Feature::MeshShader)
    }

    /// The lower of the device's limit and the mask.
    pub fn max_image_2d(&self, real: u32) -> u32 {
        self.max_image_2d.map_or(real, |masked| masked.min(real))
    }
}

fn words(list: &str) -> impl Iterator<Item = &str> {
    list.split(',').map(str::trim).filter(|word| !word.is_empty())
}

/// The features that the device has, masked ones included.
pub(super) fn supported(
    instance: &ash::Instance,
    physical: vk::PhysicalDevice,
    has_mesh_extension: bool,
) -> Vec<Feature> {
    let mut mesh = vk::PhysicalDeviceMeshShaderFeaturesEXT::default();
    let mut all = vk::PhysicalDeviceFeatures2::default();
    if has_mesh_extension {
        all = all.push_next(&mut mesh);
    }
    // SAFETY: `physical` comes from `instance` and is at least Vulkan 1.3; the chain holds only known structs.
    unsafe { instance.get_physical_device_features2(physical, &mut all) };
    let core = all.features;
    let has = |feature: &Feature| match feature {
        Feature::GeometryShader => core.geometry_shader,
        Feature::TessellationShader => core.tessellation_shader,
        Feature::MeshShader => mesh.mesh_shader,
        Feature::TaskShader => mesh.task_shader,
        Feature::MeshShaderQueries => mesh.mesh_shader_queries,
        Feature::FillModeNonSolid => core.fill_mode_non_solid,
        Feature::PipelineStatistics => core.pipeline_statistics_query,
        Feature::SamplerAnisotropy => core.sampler_anisotropy,
        Feature::FragmentStoresAndAtomics => core.fragment_stores_and_atomics,
        Feature::SampleRateShading => core.sample_rate_shading,
    };
    Feature::ALL.iter().copied().filter(|f| has(f) == vk::TRUE).collect()
}

/// The structs that enable exactly `wanted`. A host adds what it needs itself; without a feature of the mesh stage it
/// leaves the second one out.
pub fn feature_structs(
    wanted: &[Feature],
) -> (vk::PhysicalDeviceFeatures, vk::PhysicalDeviceMeshShaderFeaturesEXT<'static>) {
    let on = |feature| wanted.contains(&feature);
    let core = vk::PhysicalDeviceFeatures::default()
        .geometry_shader(on(Feature::GeometryShader))
        .tessellation_shader(on(Feature::TessellationShader))
        .fill_mode_non_solid(on(Feature::FillModeNonSolid))
        .pipeline_statistics_query(on(Feature::PipelineStatistics))
        .sampler_anisotropy(on(Feature::SamplerAnisotropy))
        .fragment_stores_and_atomics(on(Feature::FragmentStoresAndAtomics))
        .sample_rate_shading(on(Feature::SampleRateShading));
    let mesh = vk::PhysicalDeviceMeshShaderFeaturesEXT::default()
        .mesh_shader(on(Feature::MeshShader))
        .task_shader(on(Feature::TaskShader))
        .mesh_shader_queries(on(Feature::MeshShaderQueries));
    (core, mesh)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn masks_are_words_and_unknown_ones_are_refused() {
        let masks = Masks::parse(&[], "mesh, geometry", "maxImageDimension2D=256").unwrap();
        assert!(masks.hides(Feature::TaskShader) && masks.hides(Feature::GeometryShader));
        assert!(!masks.hides(Feature::SamplerAnisotropy));
        assert_eq!((masks.max_image_2d(4096), masks.max_image_2d(128)), (256, 128));
        assert_eq!(Masks::parse(&[], "meshes", "").unwrap_err().exit_code(), 2);
        assert_eq!(Masks::parse(&[], "", "maxImageDimension2D=big").unwrap_err().exit_code(), 2);
    }
}
