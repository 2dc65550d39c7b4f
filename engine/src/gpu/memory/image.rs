//! 2D images, each with a view of all its mips.

use ash::vk;
use gpu_allocator::{
    MemoryLocation,
    vulkan::{Allocation, AllocationCreateDesc, AllocationScheme},
};

use crate::{
    error::{Error, Result},
    gpu::{device::Context, retire::Retired},
};

/// What an image is for.
#[derive(Clone, Copy, Debug)]
pub struct ImageDesc<'a> {
    /// Debug name, also of its memory.
    pub name: &'a str,
    /// Width and height in texels.
    pub extent: [u32; 2],
    /// Texel format; depth formats get a depth view.
    pub format: vk::Format,
    /// Mip levels, at least 1.
    pub mips: u32,
    /// Samples per texel: 1 or 4.
    pub samples: vk::SampleCountFlags,
    /// How it may be used.
    pub usage: vk::ImageUsageFlags,
}

impl Default for ImageDesc<'_> {
    fn default() -> Self {
        ImageDesc {
            name: "image",
            extent: [1, 1],
            format: vk::Format::R8G8B8A8_UNORM,
            mips: 1,
            samples: vk::SampleCountFlags::TYPE_1,
            usage: vk::ImageUsageFlags::SAMPLED,
        }
    }
}

/// A 2D image with its view, and with its memory unless a swapchain or a host owns that.
pub struct Image {
    ctx: Context,
    raw: vk::Image,
    view: vk::ImageView,
    allocation: Option<Allocation>,
    extent: [u32; 2],
    format: vk::Format,
    mips: u32,
    samples: vk::SampleCountFlags,
    usage: vk::ImageUsageFlags,
    name: String,
}

impl Image {
    /// Makes an image; its content and layout are undefined.
    ///
    /// # Errors
    /// [`Error::Unsupported`] for an extent above [`Context::max_image_2d`]; [`Error::Gpu`] else.
    pub fn new(ctx: &Context, desc: &ImageDesc<'_>) -> Result<Self> {
        let [width, height] = desc.extent;
        let limit = ctx.max_image_2d();
        if width > limit || height > limit {
            return Err(Error::unsupported(
                format!("image '{}' of {width}x{height}: {} takes at most {limit}", desc.name, ctx.device_name()),
                "scale it down, or choose another device",
            ));
        }
        let fail =
            |e: String| Error::gpu(format!("creating image '{}' of {width}x{height}, {:?}", desc.name, desc.format), e);
        if width == 0 || height == 0 {
            return Err(fail("an image needs at least one texel".to_owned()));
        }
        let info = vk::ImageCreateInfo::default()
            .image_type(vk::ImageType::TYPE_2D)
            .format(desc.format)
            .extent(vk::Extent3D { width, height, depth: 1 })
            .mip_levels(desc.mips)
            .array_layers(1)
            .samples(desc.samples)
            .usage(desc.usage);
        // SAFETY: the info is complete; tiling is optimal, sharing exclusive, the layout undefined.
        let raw = unsafe { ctx.device().create_image(&info, None) }.map_err(|e| fail(e.to_string()))?;
        // SAFETY: the image was just made by this device.
        let requirements = unsafe { ctx.device().get_image_memory_requirements(raw) };
        let allocation = ctx.allocator().allocate(&AllocationCreateDesc {
            name: desc.name,
            requirements,
            location: MemoryLocation::GpuOnly,
            linear: false,
            allocation_scheme: AllocationScheme::GpuAllocatorManaged,
        });
        let allocation = match allocation {
            Ok(allocation) => allocation,
            Err(e) => {
                // SAFETY: nothing uses the new image.
                unsafe { ctx.device().destroy_image(raw, None) };
                return Err(fail(e.to_string()));
            }
        };
        // SAFETY: the allocation meets the image's requirements and is bound to nothing else.
        let bound = unsafe { ctx.device().bind_image_memory(raw, allocation.memory(), allocation.offset()) };
        let mut image = Self::without_view(ctx, desc, raw, Some(allocation));
        bound.map_err(|e| fail(e.to_string()))?;
        image.make_view().map_err(|e| fail(e.to_string()))?;
        Ok(image)
    }

    /// Wraps an image that a swapchain or a host owns; only the view is made, and destroyed, here.
    ///
    /// # Safety
    /// `raw` is an image of the context's device, of one layer, bound to memory, as `desc` says, and is not destroyed
    /// before the view is: before this `Image` and all [`crate::gpu::Ticket`]s that were taken in its time are gone.
    pub unsafe fn from_host(ctx: &Context, desc: &ImageDesc<'_>, raw: vk::Image) -> Result<Self> {
        let mut image = Self::without_view(ctx, desc, raw, None);
        image.make_view().map_err(|e| Error::gpu(format!("creating a view of '{}'", desc.name), e))?;
        Ok(image)
    }

    fn without_view(ctx: &Context, desc: &ImageDesc<'_>, raw: vk::Image, allocation: Option<Allocation>) -> Self {
        ctx.set_name(raw, desc.name);
        Image {
            ctx: ctx.clone(),
            raw,
            view: vk::ImageView::null(),
            allocation,
            extent: desc.extent,
            format: desc.format,
            mips: desc.mips,
            samples: desc.samples,
            usage: desc.usage,
            name: desc.name.to_owned(),
        }
    }

    fn make_view(&mut self) -> std::result::Result<(), vk::Result> {
        use vk::ImageUsageFlags as Usage;
        let viewable = Usage::SAMPLED
            | Usage::STORAGE
            | Usage::COLOR_ATTACHMENT
            | Usage::DEPTH_STENCIL_ATTACHMENT
            | Usage::TRANSIENT_ATTACHMENT
            | Usage::INPUT_ATTACHMENT;
        // Vulkan forbids a view of an image that is only copied.
        if !self.usage.intersects(viewable) {
            return Ok(());
        }
        let info = vk::ImageViewCreateInfo::default()
            .image(self.raw)
            .view_type(vk::ImageViewType::TYPE_2D)
            .format(self.format)
            .subresource_range(self.all());
        // SAFETY: the image is alive, has memory, and the range is its own.
        self.view = unsafe { self.ctx.device().create_image_view(&info, None) }?;
        self.ctx.set_name(self.view, &self.name);
        Ok(())
    }

    /// The Vulkan handle.
    pub fn handle(&self) -> vk::Image {
        self.raw
    }

    /// A view of all mips; null for an image that can only be copied.
    pub fn view(&self) -> vk::ImageView {
        self.view
    }

    /// Texel format.
    pub fn format(&self) -> vk::Format {
        self.format
    }

    /// Width and height in texels.
    pub fn extent(&self) -> [u32; 2] {
        self.extent
    }

    /// Mip levels.
    pub fn mips(&self) -> u32 {
        self.mips
    }

    /// Samples per texel.
    pub fn samples(&self) -> vk::SampleCountFlags {
        self.samples
    }

    /// How it may be used.
    pub fn usage(&self) -> vk::ImageUsageFlags {
        self.usage
    }

    /// Debug name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Depth for depth formats, else colour.
    pub fn aspect(&self) -> vk::ImageAspectFlags {
        match self.format {
            vk::Format::D16_UNORM | vk::Format::D32_SFLOAT | vk::Format::X8_D24_UNORM_PACK32 => {
                vk::ImageAspectFlags::DEPTH
            }
            _ => vk::ImageAspectFlags::COLOR,
        }
    }

    /// All mips of the only layer.
    pub(in crate::gpu) fn all(&self) -> vk::ImageSubresourceRange {
        vk::ImageSubresourceRange::default().aspect_mask(self.aspect()).level_count(self.mips).layer_count(1)
    }

    /// One mip of the only layer, for copies.
    pub(in crate::gpu) fn level(&self, mip: u32) -> vk::ImageSubresourceLayers {
        vk::ImageSubresourceLayers::default().aspect_mask(self.aspect()).mip_level(mip).layer_count(1)
    }

    /// Width and height of a mip.
    pub(in crate::gpu) fn level_extent(&self, mip: u32) -> [u32; 2] {
        self.extent.map(|n| (n >> mip).max(1))
    }
}

impl Drop for Image {
    fn drop(&mut self) {
        if self.view != vk::ImageView::null() {
            self.ctx.retire(Retired::View(self.view));
        }
        if let Some(allocation) = self.allocation.take() {
            self.ctx.retire(Retired::Image(self.raw, allocation));
        }
    }
}

/// Mip levels down to one texel.
pub fn full_mip_count(extent: [u32; 2]) -> u32 {
    extent[0].max(extent[1]).max(1).ilog2() + 1
}

/// Bytes of one texel; `None` for formats that the engine neither uploads nor reads back.
pub fn format_bytes(format: vk::Format) -> Option<u64> {
    Some(match format {
        vk::Format::R8_UNORM | vk::Format::R8_UINT => 1,
        vk::Format::R8G8_UNORM
        | vk::Format::R16_UNORM
        | vk::Format::R16_SFLOAT
        | vk::Format::R16_UINT
        | vk::Format::D16_UNORM => 2,
        vk::Format::R8G8B8A8_UNORM
        | vk::Format::R8G8B8A8_SRGB
        | vk::Format::B8G8R8A8_UNORM
        | vk::Format::B8G8R8A8_SRGB
        | vk::Format::R16G16_UNORM
        | vk::Format::R16G16_SFLOAT
        | vk::Format::R32_SFLOAT
        | vk::Format::R32_UINT
        | vk::Format::D32_SFLOAT => 4,
        vk::Format::R16G16B16A16_UNORM
        | vk::Format::R16G16B16A16_SFLOAT
        | vk::Format::R32G32_SFLOAT
        | vk::Format::R32G32_UINT => 8,
        vk::Format::R32G32B32A32_SFLOAT | vk::Format::R32G32B32A32_UINT => 16,
        _ => return None,
    })
}
