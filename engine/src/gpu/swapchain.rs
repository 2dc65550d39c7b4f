//! The window's images.

use std::ffi::c_char;

use ash::{khr, vk};
use raw_window_handle::{RawDisplayHandle, RawWindowHandle};

use super::{
    device::Context,
    frame::{Frame, Frames},
    instance::Instance,
    memory::{Image, ImageDesc},
    retire::Retired,
};
use crate::error::{Error, Result};

/// The instance extensions that a window system needs.
pub(super) fn instance_extensions(display: RawDisplayHandle) -> Result<&'static [*const c_char]> {
    ash_window::enumerate_required_extensions(display).map_err(|e| {
        Error::unsupported(
            format!("Vulkan cannot draw to this window system: {e}"),
            "render without a window (--headless)",
        )
    })
}

/// What Vulkan knows of the window.
pub(super) struct Surface {
    fns: khr::surface::Instance,
    raw: vk::SurfaceKHR,
}

impl Surface {
    pub fn new(instance: &Instance, display: RawDisplayHandle, window: RawWindowHandle) -> Result<Self> {
        // SAFETY: the window outlives the context, as `ContextDesc::surface` demands; the instance has the extensions.
        let raw = unsafe { ash_window::create_surface(&instance.entry, &instance.raw, display, window, None) };
        let raw = raw.map_err(|e| Error::gpu("creating the window's surface", e))?;
        Ok(Surface { fns: khr::surface::Instance::new(&instance.entry, &instance.raw), raw })
    }

    /// Whether the queue family can present to the window.
    pub fn supports(&self, physical: vk::PhysicalDevice, family: u32) -> bool {
        // SAFETY: the surface is alive; device and family come from the same instance.
        unsafe { self.fns.get_physical_device_surface_support(physical, family, self.raw) }.unwrap_or(false)
    }
}

impl Drop for Surface {
    fn drop(&mut self) {
        // SAFETY: swapchains hold the context that holds this, so none is left.
        unsafe { self.fns.destroy_surface(self.raw, None) };
    }
}

/// The images of the window, made anew when its size changes.
pub struct Swapchain {
    ctx: Context,
    fns: khr::swapchain::Device,
    raw: vk::SwapchainKHR,
    format: vk::SurfaceFormatKHR,
    vsync: bool,
    images: Vec<Image>,
    /// Signalled by a frame's commands, awaited by its present. One per image: only acquiring the image again proves
    /// that the present is done with it, a frame's fence does not.
    rendered: Vec<vk::Semaphore>,
    /// Signalled by acquires, reused in turn by frame slot.
    acquired: Vec<vk::Semaphore>,
    /// The window's size when the images were last made. They may differ: the window system has the last word.
    requested: [u32; 2],
    /// The images no longer fit the window.
    stale: bool,
}

/// An image to draw a frame to. Begin with a barrier from [`super::Access::ACQUIRED`], end with one to
/// [`super::Access::PRESENT`], then hand both to [`Swapchain::submit_and_present`].
#[derive(Clone, Copy, Debug)]
#[must_use = "an acquired image must be presented"]
pub struct Target {
    index: u32,
    slot: usize,
}

impl Swapchain {
    /// For a context with a surface. `size` is the window's, in pixels; 0 waits for a size. Without `vsync` frames are
    /// shown at once, where the window system can.
    pub fn new(ctx: &Context, size: [u32; 2], vsync: bool) -> Result<Self> {
        let mut chain = Swapchain {
            ctx: ctx.clone(),
            fns: khr::swapchain::Device::new(&ctx.inner().instance.raw, ctx.device()),
            raw: vk::SwapchainKHR::null(),
            format: pick_format(ctx)?,
            vsync,
            images: Vec::new(),
            rendered: Vec::new(),
            acquired: Vec::new(),
            requested: [0, 0],
            stale: true,
        };
        chain.recreate(size)?;
        Ok(chain)
    }

    /// Texel format of the images; sRGB where the window system has it.
    pub fn format(&self) -> vk::Format {
        self.format.format
    }

    /// Size of the images in pixels; 0 before the window first had a size.
    pub fn extent(&self) -> [u32; 2] {
        self.images.first().map_or([0, 0], Image::extent)
    }

    /// The image behind a target.
    pub fn image(&self, target: Target) -> &Image {
        &self.images[target.index as usize]
    }

    /// Whether frames wait for the display from now on.
    pub fn set_vsync(&mut self, vsync: bool) {
        self.stale |= self.vsync != vsync;
        self.vsync = vsync;
    }

    /// The next image for `frame`. `size` is the window's, in pixels. `None` while there is nothing to draw to: the
    /// window is minimised, or changed just now; drop the frame and try with the next one.
    pub fn acquire(&mut self, frame: &Frame, size: [u32; 2]) -> Result<Option<Target>> {
        if size[0] == 0 || size[1] == 0 {
            return Ok(None);
        }
        if self.stale || self.requested != size {
            self.recreate(size)?;
        }
        if self.stale {
            return Ok(None);
        }
        let slot = frame.slot();
        while self.acquired.len() <= slot {
            let semaphore = self.semaphore(&format!("acquired, frame slot {}", self.acquired.len()))?;
            self.acquired.push(semaphore);
        }
        // SAFETY: the slot's last frame has run, so its wait on this semaphore is over.
        let result = unsafe { self.fns.acquire_next_image(self.raw, u64::MAX, self.acquired[slot], vk::Fence::null()) };
        match result {
            Ok((index, suboptimal)) => {
                // The image is ours and its semaphore will be signalled, so this frame is still shown.
                self.stale |= suboptimal;
                Ok(Some(Target { index, slot }))
            }
            Err(vk::Result::ERROR_OUT_OF_DATE_KHR) => {
                self.stale = true;
                Ok(None)
            }
            Err(e) => Err(self.ctx.failure("acquiring the window's next image", e)),
        }
    }

    /// Submits the frame that draws to `target`, and shows it.
    pub fn submit_and_present(&mut self, frames: &mut Frames, frame: Frame, target: Target) -> Result<()> {
        let wait = [vk::SemaphoreSubmitInfo::default()
            .semaphore(self.acquired[target.slot])
            .stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS)];
        let rendered = [self.rendered[target.index as usize]];
        let signal = [vk::SemaphoreSubmitInfo::default()
            .semaphore(rendered[0])
            .stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS)];
        frames.submit_with(frame, &wait, &signal)?;
        let chains = [self.raw];
        let indices = [target.index];
        let info = vk::PresentInfoKHR::default().wait_semaphores(&rendered).swapchains(&chains).image_indices(&indices);
        let queue = self.ctx.queue();
        // SAFETY: the queue is locked; the image was acquired, and the commands just submitted signal the semaphore.
        match unsafe { self.fns.queue_present(*queue, &info) } {
            Ok(suboptimal) => self.stale |= suboptimal,
            Err(vk::Result::ERROR_OUT_OF_DATE_KHR) => self.stale = true,
            Err(e) => return Err(self.ctx.failure("presenting to the window", e)),
        }
        Ok(())
    }

    fn recreate(&mut self, size: [u32; 2]) -> Result<()> {
        let fail = |e: vk::Result| Error::gpu(format!("making the window's images of {}x{}", size[0], size[1]), e);
        self.stale = true;
        // Resizing is rare: waiting is simpler than knowing when the last present is over.
        self.ctx.wait_idle()?;
        let surface = surface(&self.ctx)?;
        let physical = self.ctx.inner().physical;
        // SAFETY: the surface is alive and supported by the device.
        let caps =
            unsafe { surface.fns.get_physical_device_surface_capabilities(physical, surface.raw) }.map_err(fail)?;
        // SAFETY: as above.
        let modes =
            unsafe { surface.fns.get_physical_device_surface_present_modes(physical, surface.raw) }.map_err(fail)?;
        let extent = pick_extent(&caps, size);
        if extent.width == 0 || extent.height == 0 {
            return Ok(());
        }
        let free_running = [vk::PresentModeKHR::MAILBOX, vk::PresentModeKHR::IMMEDIATE];
        let free_running = free_running.into_iter().find(|mode| !self.vsync && modes.contains(mode));
        let most = if caps.max_image_count == 0 { u32::MAX } else { caps.max_image_count };
        let wanted = vk::ImageUsageFlags::COLOR_ATTACHMENT
            | vk::ImageUsageFlags::TRANSFER_DST
            | vk::ImageUsageFlags::TRANSFER_SRC;
        let usage = wanted & caps.supported_usage_flags;
        let alpha = [vk::CompositeAlphaFlagsKHR::OPAQUE, vk::CompositeAlphaFlagsKHR::INHERIT];
        let alpha = alpha.into_iter().find(|a| caps.supported_composite_alpha.contains(*a));
        let info = vk::SwapchainCreateInfoKHR::default()
            .surface(surface.raw)
            .min_image_count((caps.min_image_count + 1).min(most))
            .image_format(self.format.format)
            .image_color_space(self.format.color_space)
            .image_extent(extent)
            .image_array_layers(1)
            .image_usage(usage)
            .pre_transform(caps.current_transform)
            .composite_alpha(alpha.unwrap_or(vk::CompositeAlphaFlagsKHR::PRE_MULTIPLIED))
            .present_mode(free_running.unwrap_or(vk::PresentModeKHR::FIFO))
            .clipped(true)
            .old_swapchain(self.raw);
        // SAFETY: the info follows the surface's capabilities.
        let made = unsafe { self.fns.create_swapchain(&info, None) };
        // The old chain is retired even if this failed.
        self.retire();
        self.raw = made.map_err(fail)?;
        self.ctx.set_name(self.raw, "swapchain");
        // SAFETY: the chain was just made.
        let images = unsafe { self.fns.get_swapchain_images(self.raw) }.map_err(fail)?;
        for (index, raw) in images.into_iter().enumerate() {
            let desc = ImageDesc {
                name: &format!("swapchain image {index}"),
                extent: [extent.width, extent.height],
                format: self.format.format,
                usage,
                ..ImageDesc::default()
            };
            // SAFETY: an image of the chain, which is retired after its views.
            self.images.push(unsafe { Image::from_host(&self.ctx, &desc, raw) }?);
            let semaphore = self.semaphore(&format!("rendered, image {index}"))?;
            self.rendered.push(semaphore);
        }
        self.requested = size;
        self.stale = false;
        Ok(())
    }

    fn semaphore(&self, name: &str) -> Result<vk::Semaphore> {
        // SAFETY: no requirements.
        let semaphore = unsafe { self.ctx.device().create_semaphore(&vk::SemaphoreCreateInfo::default(), None) };
        let semaphore = semaphore.map_err(|e| Error::gpu(format!("creating the semaphore '{name}'"), e))?;
        self.ctx.set_name(semaphore, name);
        Ok(semaphore)
    }

    /// Drops the chain, its images and all semaphores: an acquire that was never submitted leaves its semaphore
    /// signalled, so those are made anew too. Goes through the deletion queue, in order: views before their images.
    fn retire(&mut self) {
        self.images.clear();
        for semaphore in self.rendered.drain(..).chain(self.acquired.drain(..)) {
            self.ctx.retire(Retired::Semaphore(semaphore));
        }
        let chain = std::mem::take(&mut self.raw);
        if chain != vk::SwapchainKHR::null() {
            self.ctx.retire(Retired::Swapchain(self.fns.clone(), chain));
        }
    }
}

impl Drop for Swapchain {
    fn drop(&mut self) {
        if let Err(e) = self.ctx.wait_idle() {
            tracing::error!("{e}");
        }
        self.retire();
    }
}

fn surface(ctx: &Context) -> Result<&Surface> {
    ctx.inner().surface.as_ref().ok_or_else(|| Error::gpu("making the window's images", "the context has no surface"))
}

fn pick_extent(caps: &vk::SurfaceCapabilitiesKHR, size: [u32; 2]) -> vk::Extent2D {
    // The window system decides, unless it leaves it to us (Wayland) with this value.
    if caps.current_extent.width != u32::MAX {
        return caps.current_extent;
    }
    let (min, max) = (caps.min_image_extent, caps.max_image_extent);
    vk::Extent2D { width: size[0].clamp(min.width, max.width), height: size[1].clamp(min.height, max.height) }
}

fn pick_format(ctx: &Context) -> Result<vk::SurfaceFormatKHR> {
    let surface = surface(ctx)?;
    // SAFETY: the surface is alive and supported by the device.
    let formats = unsafe { surface.fns.get_physical_device_surface_formats(ctx.inner().physical, surface.raw) };
    let formats = formats.map_err(|e| Error::gpu("listing the window's formats", e))?;
    let wanted = [vk::Format::B8G8R8A8_SRGB, vk::Format::R8G8B8A8_SRGB];
    let find = |format| {
        let fits = |f: &&vk::SurfaceFormatKHR| f.format == format && f.color_space == vk::ColorSpaceKHR::SRGB_NONLINEAR;
        formats.iter().find(fits).copied()
    };
    wanted.into_iter().find_map(find).or_else(|| formats.first().copied()).ok_or_else(|| {
        Error::unsupported("the window has no format to draw in", "render without a window (--headless)")
    })
}
