//! Descriptor sets, filled by the names that the shaders give their variables.

use ash::vk;

use super::{
    device::{Context, lock},
    memory::{Buffer, Image, Sampler},
    pipeline::Pipeline,
    retire::Retired,
    shader::BindingInfo,
};
use crate::error::{Error, Result};

/// What is bound to a name.
#[derive(Clone, Copy)]
pub enum Binding<'a> {
    /// A whole uniform or storage buffer.
    Buffer(&'a Buffer),
    /// Part of one: offset and size in bytes.
    BufferRange(&'a Buffer, u64, u64),
    /// A sampled image, in the layout of [`super::Access::SHADER_READ`].
    Image(&'a Image, &'a Sampler),
    /// A storage image, in the layout of [`super::Access::COMPUTE_WRITE`].
    StorageImage(&'a Image),
}

/// One descriptor set for one pipeline. It keeps nothing alive: whoever records with it owns what it names. Dropped,
/// it returns to its pool when no recording can use it; making one per frame is cheap.
pub struct DescriptorSet {
    ctx: Context,
    pool: vk::DescriptorPool,
    raw: vk::DescriptorSet,
}

impl DescriptorSet {
    /// Set `index` of the pipeline, with exactly the names that its shaders use.
    ///
    /// # Errors
    /// A name that is missing, or that no shader of the pipeline uses, or of another kind; each names pipeline, set and
    /// binding.
    pub fn new(ctx: &Context, pipeline: &Pipeline, index: u32, bindings: &[(&str, Binding<'_>)]) -> Result<Self> {
        Self::with_optional(ctx, pipeline, index, bindings, &[])
    }

    /// [`Self::new`], with further names that variants of the shaders may leave out.
    pub fn with_optional(
        ctx: &Context,
        pipeline: &Pipeline,
        index: u32,
        bindings: &[(&str, Binding<'_>)],
        optional: &[(&str, Binding<'_>)],
    ) -> Result<Self> {
        let fail = |cause: String| Error::gpu(format!("filling set {index} of pipeline '{}'", pipeline.name()), cause);
        let used: Vec<_> = pipeline.bindings().iter().filter(|b| b.set == index).collect();
        for (name, _) in bindings {
            if !used.iter().any(|b| b.name == *name) {
                let names: Vec<_> = used.iter().map(|b| b.name.as_str()).collect();
                return Err(fail(format!("no shader uses '{name}'; used are: {}", names.join(", "))));
            }
        }
        let mut resources = Vec::new();
        for info in used {
            let given = bindings.iter().chain(optional).find(|(name, _)| *name == info.name);
            let (_, binding) = given.ok_or_else(|| {
                fail(format!("binding {} '{}' ({:?}) was not given", info.binding, info.name, info.ty))
            })?;
            let resource = resource(info, binding)
                .map_err(|cause| fail(format!("binding {} '{}': {cause}", info.binding, info.name)))?;
            resources.push((info, resource));
        }
        let layout = pipeline.set_layouts().get(index as usize);
        let layout = *layout.ok_or_else(|| fail("the pipeline has no such set".to_owned()))?;
        let (pool, raw) = lock(&ctx.inner().pools).allocate(ctx.device(), layout).map_err(|e| fail(e.to_string()))?;
        ctx.set_name(raw, &format!("{}: set {index}", pipeline.name()));
        let writes: Vec<_> = resources.iter().map(|(info, resource)| write(raw, info, resource)).collect();
        // SAFETY: the set is new, so nothing uses it; kinds and usages were checked, handles are alive.
        unsafe { ctx.device().update_descriptor_sets(&writes, &[]) };
        Ok(DescriptorSet { ctx: ctx.clone(), pool, raw })
    }

    /// The Vulkan handle.
    pub fn handle(&self) -> vk::DescriptorSet {
        self.raw
    }
}

impl Drop for DescriptorSet {
    fn drop(&mut self) {
        self.ctx.retire(Retired::Set(self.pool, self.raw));
    }
}

enum Resource {
    Buffer([vk::DescriptorBufferInfo; 1]),
    Image([vk::DescriptorImageInfo; 1]),
}

fn write<'a>(set: vk::DescriptorSet, info: &BindingInfo, resource: &'a Resource) -> vk::WriteDescriptorSet<'a> {
    let write = vk::WriteDescriptorSet::default().dst_set(set).dst_binding(info.binding).descriptor_type(info.ty);
    match resource {
        Resource::Buffer(buffer) => write.buffer_info(buffer),
        Resource::Image(image) => write.image_info(image),
    }
}

/// What to write, if the shader's variable and the resource fit.
fn resource(info: &BindingInfo, binding: &Binding<'_>) -> std::result::Result<Resource, String> {
    use vk::{BufferUsageFlags as B, DescriptorType as D, ImageUsageFlags as I};
    if info.count != 1 {
        return Err(format!("an array of {} descriptors, which this engine does not fill", info.count));
    }
    let lacks = |name: &str, usage: &dyn std::fmt::Debug| Err(format!("'{name}' lacks the usage {usage:?}"));
    match (*binding, info.ty) {
        (Binding::Buffer(buffer), _) => resource(info, &Binding::BufferRange(buffer, 0, buffer.size())),
        (Binding::BufferRange(buffer, offset, size), ty @ (D::UNIFORM_BUFFER | D::STORAGE_BUFFER)) => {
            let usage = if ty == D::UNIFORM_BUFFER { B::UNIFORM_BUFFER } else { B::STORAGE_BUFFER };
            if !buffer.usage().contains(usage) {
                return lacks(buffer.name(), &usage);
            }
            if size == 0 || offset.checked_add(size).is_none_or(|end| end > buffer.size()) {
                return Err(format!("'{}' of {} bytes has no {size} at {offset}", buffer.name(), buffer.size()));
            }
            Ok(Resource::Buffer([vk::DescriptorBufferInfo { buffer: buffer.handle(), offset, range: size }]))
        }
        (Binding::Image(image, sampler), D::COMBINED_IMAGE_SAMPLER) => {
            if !image.usage().contains(I::SAMPLED) {
                return lacks(image.name(), &I::SAMPLED);
            }
            Ok(Resource::Image([vk::DescriptorImageInfo {
                sampler: sampler.handle(),
                image_view: image.view(),
                image_layout: vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL,
            }]))
        }
        (Binding::StorageImage(image), D::STORAGE_IMAGE) => {
            if !image.usage().contains(I::STORAGE) {
                return lacks(image.name(), &I::STORAGE);
            }
            Ok(Resource::Image([vk::DescriptorImageInfo {
                sampler: vk::Sampler::null(),
                image_view: image.view(),
                image_layout: vk::ImageLayout::GENERAL,
            }]))
        }
        (given, ty) => {
            let given = match given {
                Binding::Buffer(_) | Binding::BufferRange(..) => "a buffer",
                Binding::Image(..) => "a sampled image",
                Binding::StorageImage(_) => "a storage image",
            };
            Err(format!("the shader wants {ty:?}, {given} was given"))
        }
    }
}

/// Pools of sets; another is made when all are full.
#[derive(Default)]
pub(super) struct Pools(Vec<vk::DescriptorPool>);

/// Sets in a pool.
const SETS: u32 = 256;

impl Pools {
    fn allocate(
        &mut self,
        device: &ash::Device,
        layout: vk::DescriptorSetLayout,
    ) -> std::result::Result<(vk::DescriptorPool, vk::DescriptorSet), vk::Result> {
        // The newest first: the others are full, unless sets of theirs were freed.
        for pool in self.0.iter().rev() {
            match allocate_from(device, *pool, layout) {
                Ok(set) => return Ok((*pool, set)),
                Err(vk::Result::ERROR_OUT_OF_POOL_MEMORY | vk::Result::ERROR_FRAGMENTED_POOL) => {}
                Err(e) => return Err(e),
            }
        }
        // A set of this engine holds a few buffers and up to a dozen images.
        let size = |ty, each: u32| vk::DescriptorPoolSize { ty, descriptor_count: SETS * each };
        let sizes = [
            size(vk::DescriptorType::UNIFORM_BUFFER, 2),
            size(vk::DescriptorType::STORAGE_BUFFER, 8),
            size(vk::DescriptorType::COMBINED_IMAGE_SAMPLER, 8),
            size(vk::DescriptorType::STORAGE_IMAGE, 2),
        ];
        let info = vk::DescriptorPoolCreateInfo::default()
            .flags(vk::DescriptorPoolCreateFlags::FREE_DESCRIPTOR_SET)
            .max_sets(SETS)
            .pool_sizes(&sizes);
        // SAFETY: the info is complete.
        let pool = unsafe { device.create_descriptor_pool(&info, None) }?;
        self.0.push(pool);
        allocate_from(device, pool, layout).map(|set| (pool, set))
    }

    /// The device must be idle.
    pub fn destroy(&mut self, device: &ash::Device) {
        for pool in self.0.drain(..) {
            // SAFETY: no set is in use.
            unsafe { device.destroy_descriptor_pool(pool, None) };
        }
    }
}

fn allocate_from(
    device: &ash::Device,
    pool: vk::DescriptorPool,
    layout: vk::DescriptorSetLayout,
) -> std::result::Result<vk::DescriptorSet, vk::Result> {
    let layouts = [layout];
    let info = vk::DescriptorSetAllocateInfo::default().descriptor_pool(pool).set_layouts(&layouts);
    // SAFETY: pool and layout are alive, and the pool is locked.
    unsafe { device.allocate_descriptor_sets(&info) }.map(|sets| sets[0])
}
