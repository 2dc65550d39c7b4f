//! Samplers, one per distinct description.

use std::hash::{Hash, Hasher};

use ash::vk;

use crate::{
    error::{Error, Result},
    gpu::{
        Feature,
        device::{Context, lock},
    },
};

/// How an image is filtered and wrapped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SamplerDesc {
    /// Filter where a texel covers more than a pixel.
    pub mag: vk::Filter,
    /// Filter where it covers less.
    pub min: vk::Filter,
    /// Between mips.
    pub mip: vk::SamplerMipmapMode,
    /// Wrap mode along u and v.
    pub wrap: [vk::SamplerAddressMode; 2],
    /// Highest mip that is read; 0 keeps to the full image.
    pub max_lod: f32,
    /// Largest anisotropy; 1 for none. Clamped to the device's, and none where the feature is not enabled.
    pub anisotropy: f32,
    /// For shadow maps: reads give the comparison's result.
    pub compare: Option<vk::CompareOp>,
}

impl SamplerDesc {
    /// The nearest texel of the nearest mip; repeating.
    pub fn nearest() -> Self {
        SamplerDesc {
            mag: vk::Filter::NEAREST,
            min: vk::Filter::NEAREST,
            mip: vk::SamplerMipmapMode::NEAREST,
            ..SamplerDesc::default()
        }
    }
}

impl Default for SamplerDesc {
    /// Trilinear, repeating.
    fn default() -> Self {
        SamplerDesc {
            mag: vk::Filter::LINEAR,
            min: vk::Filter::LINEAR,
            mip: vk::SamplerMipmapMode::LINEAR,
            wrap: [vk::SamplerAddressMode::REPEAT; 2],
            max_lod: vk::LOD_CLAMP_NONE,
            anisotropy: 1.0,
            compare: None,
        }
    }
}

// Floats are compared as the values they are: NaN has no place in a sampler.
impl Eq for SamplerDesc {}

impl Hash for SamplerDesc {
    fn hash<H: Hasher>(&self, state: &mut H) {
        (self.mag, self.min, self.mip, self.wrap, self.compare).hash(state);
        // 0.0 and -0.0 are equal, so they must hash alike.
        [self.max_lod, self.anisotropy].map(|x| (x + 0.0).to_bits()).hash(state);
    }
}

/// A sampler. The context keeps it for its lifetime, so clones are free.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sampler(vk::Sampler);

impl Sampler {
    /// The sampler of this description, made on first use.
    pub fn new(ctx: &Context, desc: &SamplerDesc) -> Result<Self> {
        let mut samplers = lock(&ctx.inner().samplers);
        if let Some(raw) = samplers.get(desc) {
            return Ok(Sampler(*raw));
        }
        let anisotropy = desc.anisotropy.min(ctx.limits().max_sampler_anisotropy);
        let info = vk::SamplerCreateInfo::default()
            .mag_filter(desc.mag)
            .min_filter(desc.min)
            .mipmap_mode(desc.mip)
            .address_mode_u(desc.wrap[0])
            .address_mode_v(desc.wrap[1])
            .max_lod(desc.max_lod)
            .anisotropy_enable(anisotropy > 1.0 && ctx.has(Feature::SamplerAnisotropy))
            .max_anisotropy(anisotropy)
            .compare_enable(desc.compare.is_some())
            .compare_op(desc.compare.unwrap_or_default());
        // SAFETY: the info is complete and asks for no feature that is not enabled.
        let raw = unsafe { ctx.device().create_sampler(&info, None) }
            .map_err(|e| Error::gpu(format!("creating a sampler: {desc:?}"), e))?;
        ctx.set_name(raw, &format!("{desc:?}"));
        samplers.insert(*desc, raw);
        Ok(Sampler(raw))
    }

    /// The Vulkan handle.
    pub fn handle(&self) -> vk::Sampler {
        self.0
    }
}
