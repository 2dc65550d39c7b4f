//! Our shell renderer in another engine: that engine is this file, written with `ash` alone. It has its own instance,
//! device, queue, command buffer and image, lends them to the renderer, and goes on recording.
//! README.md says what to copy.

use std::ffi::c_char;

use ash::{Device, Entry, Instance, ext, prelude::VkResult, vk};
use prism_engine::{
    error::{Error, Result},
    gpu::{
        Access, CommandEncoder, Context, Feature, Host, Image, ImageDesc, ValidationLog, feature_structs,
        supported_features,
    },
    render::{self, Features, Output, Renderer},
    settings::Validation,
};

use crate::app::{
    picture::Picture,
    sample::{Embedding, Sample, Source},
};

/// Rows of the bar that the host draws at the picture's foot.
const BAR: u32 = 8;
/// Its colour.
const ORANGE: [f32; 4] = [1.0, 0.4, 0.05, 1.0];
/// Of the image that both draw to.
const FORMAT: vk::Format = vk::Format::R8G8B8A8_SRGB;
/// Drawn to, then copied to the CPU.
const USAGE: vk::ImageUsageFlags = vk::ImageUsageFlags::from_raw(
    vk::ImageUsageFlags::COLOR_ATTACHMENT.as_raw() | vk::ImageUsageFlags::TRANSFER_SRC.as_raw(),
);

/// `prism run integration`.
pub struct Integration;

impl Sample for Integration {
    fn id(&self) -> &'static str {
        "integration"
    }

    fn summary(&self) -> &'static str {
        "One file, nothing but ash and the shell renderer: drawn within another engine's command buffer; no window"
    }

    fn scene(&self) -> Source {
        Source::Asset("prism_shell.gltf")
    }

    fn moves(&self) -> bool {
        false
    }

    fn embedding(&self) -> Option<fn(&Embedding<'_>) -> Result<Picture>> {
        Some(draw)
    }
}

/// What the renderer draws, and over it the host's bar.
fn draw(job: &Embedding<'_>) -> Result<Picture> {
    // 1. The host's device, made with what the renderer needs for this scene besides what the host needs.
    let needed = render::features(job.scene, job.settings, false);
    let log = ValidationLog::default();
    let mut engine = Engine::new(job.validation, &log, &needed)?;
    engine.make_target(job.size).map_err(fail("making the host's image"))?;
    let picture = draw_with(&engine, job);
    // 6. The renderer is gone with its context; now the host may go.
    drop(engine);
    log.check()?;
    picture
}

fn draw_with(engine: &Engine, job: &Embedding<'_>) -> Result<Picture> {
    // 2. The renderer, on the host's device.
    let host = Host {
        entry: &engine.vulkan.entry,
        instance: &engine.vulkan.instance,
        debug_utils: engine.vulkan.messenger.is_some(),
        physical: engine.physical,
        device: &engine.device,
        queue_family: engine.family,
        queue: engine.queue,
        features: &engine.features,
    };
    // SAFETY: the engine was made as `Host` demands, and outlives the context and all that is made with it here.
    let ctx = unsafe { Context::from_host(&host) }?;
    let compiler = render::shader_compiler(job.shader_dir)?;
    let output = Output { color_format: FORMAT, aov: false };
    let mut renderer = Renderer::new(&ctx, &compiler, job.scene, job.settings, output)?;
    let desc = ImageDesc { name: "target", extent: job.size, format: FORMAT, usage: USAGE, ..ImageDesc::default() };
    // SAFETY: the engine made the image so, and keeps it.
    let target = unsafe { Image::from_host(&ctx, &desc, engine.image.0) }?;

    // 3. Until the ticket is dropped nothing that the commands use is destroyed.
    let _ticket = ctx.ticket();
    let cmd = engine.begin().map_err(fail("beginning the host's commands"))?;
    // 4. The target's layout is the host's to see to, before and after.
    engine.barrier(cmd, Access::UNDEFINED, Access::COLOR_WRITE);
    renderer.record(&mut CommandEncoder::from_raw(&ctx, cmd), 0, job.camera, &target, None)?;
    // 5. The host goes on with commands of its own.
    engine.barrier(cmd, Access::COLOR_WRITE, Access::COLOR_WRITE);
    engine.draw_bar(cmd, target.view(), job.size);
    engine.barrier(cmd, Access::COLOR_WRITE, Access::TRANSFER_SRC);
    engine.copy(cmd, job.size);
    engine.finish(cmd).map_err(fail("running the host's commands"))?;
    let bytes = engine.read(job.size).map_err(fail("reading the host's picture"))?;
    Ok(Picture::from_bytes(job.size, &bytes))
}

/// Says what was being done when a Vulkan call failed.
fn fail(what: &'static str) -> impl Fn(vk::Result) -> Error {
    move |e| Error::gpu(what, e)
}

/// The loader, an instance, and its messenger if the layer is loaded.
struct Vulkan {
    entry: Entry,
    instance: Instance,
    messenger: Option<(ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT)>,
}

impl Vulkan {
    fn new(validation: Validation, log: &ValidationLog) -> Result<Vulkan> {
        // SAFETY: the loader is kept in the result.
        let entry =
            unsafe { Entry::load() }.map_err(|e| Error::unsupported(e.to_string(), "install a Vulkan loader"))?;
        let mut names: Vec<*const c_char> = Vec::new();
        let mut layers = Vec::new();
        if validation != Validation::Off {
            names.extend([ext::debug_utils::NAME.as_ptr(), ext::validation_features::NAME.as_ptr()]);
            layers.push(c"VK_LAYER_KHRONOS_validation".as_ptr());
        }
        let sync = [vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];
        let enables = if validation == Validation::Sync { &sync[..] } else { &[] };
        let mut checks = vk::ValidationFeaturesEXT::default().enabled_validation_features(enables);
        let app = vk::ApplicationInfo::default().application_name(c"a host").api_version(vk::API_VERSION_1_3);
        let mut info = vk::InstanceCreateInfo::default()
            .application_info(&app)
            .enabled_layer_names(&layers)
            .enabled_extension_names(&names);
        if validation != Validation::Off {
            info = info.push_next(&mut checks);
        }
        // SAFETY: all that `info` points to lives until the call returns.
        let instance = unsafe { entry.create_instance(&info, None) }.map_err(|e| match e {
            vk::Result::ERROR_LAYER_NOT_PRESENT => Error::unsupported(
                "the layer VK_LAYER_KHRONOS_validation is not installed",
                "install it (package vulkan-validationlayers), or pass --validation off",
            ),
            e => Error::gpu("creating the host's instance", e),
        })?;
        let mut vulkan = Vulkan { entry, instance, messenger: None };
        if validation != Validation::Off {
            let utils = ext::debug_utils::Instance::new(&vulkan.entry, &vulkan.instance);
            // SAFETY: the caller keeps the log for longer than the result.
            let messenger = unsafe { utils.create_debug_utils_messenger(&log.messenger_info(), None) };
            vulkan.messenger = Some((utils, messenger.map_err(fail("creating the host's messenger"))?));
        }
        Ok(vulkan)
    }
}

impl Drop for Vulkan {
    fn drop(&mut self) {
        // SAFETY: nothing made from the instance is left but the messenger.
        unsafe {
            if let Some((utils, messenger)) = self.messenger.take() {
                utils.destroy_debug_utils_messenger(messenger, None);
            }
            self.instance.destroy_instance(None);
        }
    }
}

/// The host: as little of an engine as shows where ours fits in. Its methods are given its own handles, alive, and
/// command buffers that are recording; that is what makes the calls in them sound.
struct Engine {
    physical: vk::PhysicalDevice,
    device: Device,
    family: u32,
    queue: vk::Queue,
    /// What of the renderer's features the device was made with.
    features: Vec<Feature>,
    pool: vk::CommandPool,
    image: (vk::Image, vk::DeviceMemory),
    readback: (vk::Buffer, vk::DeviceMemory),
    /// Last, as it is to be destroyed last.
    vulkan: Vulkan,
}

impl Engine {
    fn new(validation: Validation, log: &ValidationLog, needed: &Features) -> Result<Engine> {
        let vulkan = Vulkan::new(validation, log)?;
        let instance = &vulkan.instance;
        let both = vk::QueueFlags::GRAPHICS | vk::QueueFlags::COMPUTE;
        // SAFETY: the handles come from this instance; of those below 1.3 only the version is asked.
        let found = unsafe {
            let devices = instance.enumerate_physical_devices().map_err(fail("listing the devices"))?;
            let v13 =
                |d: &vk::PhysicalDevice| instance.get_physical_device_properties(*d).api_version >= vk::API_VERSION_1_3;
            devices.into_iter().filter(v13).find_map(|physical| {
                let supported = supported_features(instance, physical);
                let families = instance.get_physical_device_queue_family_properties(physical);
                let family = families.iter().position(|f| f.queue_flags.contains(both))?;
                let able = needed.required.iter().all(|f| supported.contains(f));
                able.then_some((physical, family as u32, supported))
            })
        };
        let (physical, family, supported) = found.ok_or_else(|| {
            let features: Vec<_> = needed.required.iter().map(|f| f.name()).collect();
            let what = format!("no Vulkan 1.3 device with what this scene needs ({})", features.join(", "));
            Error::unsupported(what, "`prism devices` shows what each has; ask for another --stage, or --shell off")
        })?;
        let either = needed.alternatives.iter().find(|f| supported.contains(f));
        let wanted = needed.required.iter().chain(&needed.optional).chain(either);
        let features: Vec<_> = wanted.filter(|f| supported.contains(f)).copied().collect();
        let (core, mut mesh) = feature_structs(&features);
        let mut v13 = vk::PhysicalDeviceVulkan13Features::default()
            .dynamic_rendering(true)
            .synchronization2(true)
            .maintenance4(true);
        let mut chain = vk::PhysicalDeviceFeatures2::default().features(core).push_next(&mut v13);
        let mut extensions = Vec::new();
        if features.contains(&Feature::MeshShader) {
            chain = chain.push_next(&mut mesh);
            extensions.push(ext::mesh_shader::NAME.as_ptr());
        }
        let queues = [vk::DeviceQueueCreateInfo::default().queue_family_index(family).queue_priorities(&[1.0])];
        let info = vk::DeviceCreateInfo::default()
            .queue_create_infos(&queues)
            .enabled_extension_names(&extensions)
            .push_next(&mut chain);
        // SAFETY: all that `info` points to lives until the call returns, and was reported as supported.
        let device = unsafe { instance.create_device(physical, &info, None) };
        let device = device.map_err(fail("creating the host's device"))?;
        // SAFETY: the device was made with this queue.
        let queue = unsafe { device.get_device_queue(family, 0) };
        let (pool, image, readback) = Default::default();
        Ok(Engine { physical, device, family, queue, features, pool, image, readback, vulkan })
    }

    /// What the host draws with: a command pool, an image, and a buffer that the CPU can read.
    fn make_target(&mut self, [width, height]: [u32; 2]) -> VkResult<()> {
        let pool = vk::CommandPoolCreateInfo::default().queue_family_index(self.family);
        let image = vk::ImageCreateInfo::default()
            .image_type(vk::ImageType::TYPE_2D)
            .format(FORMAT)
            .extent(vk::Extent3D { width, height, depth: 1 })
            .mip_levels(1)
            .array_layers(1)
            .samples(vk::SampleCountFlags::TYPE_1)
            .usage(USAGE);
        let bytes = 4 * u64::from(width) * u64::from(height);
        let buffer = vk::BufferCreateInfo::default().size(bytes).usage(vk::BufferUsageFlags::TRANSFER_DST);
        let visible = vk::MemoryPropertyFlags::HOST_VISIBLE | vk::MemoryPropertyFlags::HOST_COHERENT;
        // SAFETY: see `Engine`. What is made is kept at once, so that it is destroyed whatever fails after it.
        unsafe {
            self.pool = self.device.create_command_pool(&pool, None)?;
            self.image.0 = self.device.create_image(&image, None)?;
            let need = self.device.get_image_memory_requirements(self.image.0);
            self.image.1 = self.memory(need, vk::MemoryPropertyFlags::empty())?;
            self.device.bind_image_memory(self.image.0, self.image.1, 0)?;
            self.readback.0 = self.device.create_buffer(&buffer, None)?;
            let need = self.device.get_buffer_memory_requirements(self.readback.0);
            self.readback.1 = self.memory(need, visible)?;
            self.device.bind_buffer_memory(self.readback.0, self.readback.1, 0)
        }
    }

    /// Memory of its own for one resource, of the first type that serves.
    fn memory(&self, need: vk::MemoryRequirements, flags: vk::MemoryPropertyFlags) -> VkResult<vk::DeviceMemory> {
        // SAFETY: see `Engine`.
        let memory = unsafe { self.vulkan.instance.get_physical_device_memory_properties(self.physical) };
        let serves = |(i, kind): &(usize, &vk::MemoryType)| {
            need.memory_type_bits >> i & 1 == 1 && kind.property_flags.contains(flags)
        };
        let (index, _) = memory
            .memory_types_as_slice()
            .iter()
            .enumerate()
            .find(serves)
            .ok_or(vk::Result::ERROR_OUT_OF_DEVICE_MEMORY)?;
        let info = vk::MemoryAllocateInfo::default().allocation_size(need.size).memory_type_index(index as u32);
        // SAFETY: see `Engine`.
        unsafe { self.device.allocate_memory(&info, None) }
    }

    fn begin(&self) -> VkResult<vk::CommandBuffer> {
        let info = vk::CommandBufferAllocateInfo::default().command_pool(self.pool).command_buffer_count(1);
        let once = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: see `Engine`.
        unsafe {
            let cmd = self.device.allocate_command_buffers(&info)?[0];
            self.device.begin_command_buffer(cmd, &once)?;
            Ok(cmd)
        }
    }

    /// What the host draws over the picture: a bar at its foot.
    fn draw_bar(&self, cmd: vk::CommandBuffer, view: vk::ImageView, [width, height]: [u32; 2]) {
        let bar = BAR.min(height);
        let target = [vk::RenderingAttachmentInfo::default()
            .image_view(view)
            .image_layout(Access::COLOR_WRITE.layout)
            .load_op(vk::AttachmentLoadOp::CLEAR)
            .clear_value(vk::ClearValue { color: vk::ClearColorValue { float32: ORANGE } })
            .store_op(vk::AttachmentStoreOp::STORE)];
        let offset = vk::Offset2D { x: 0, y: (height - bar) as i32 };
        let area = vk::Rect2D { offset, extent: vk::Extent2D { width, height: bar } };
        let info = vk::RenderingInfo::default().render_area(area).layer_count(1).color_attachments(&target);
        // SAFETY: see `Engine`.
        unsafe {
            self.device.cmd_begin_rendering(cmd, &info);
            self.device.cmd_end_rendering(cmd);
        }
    }

    /// The picture into the buffer.
    fn copy(&self, cmd: vk::CommandBuffer, [width, height]: [u32; 2]) {
        let layer = vk::ImageSubresourceLayers::default().aspect_mask(vk::ImageAspectFlags::COLOR).layer_count(1);
        let extent = vk::Extent3D { width, height, depth: 1 };
        let all = vk::BufferImageCopy::default().image_subresource(layer).image_extent(extent);
        let seen = [vk::MemoryBarrier2::default()
            .src_stage_mask(Access::TRANSFER_DST.stage)
            .src_access_mask(Access::TRANSFER_DST.access)
            .dst_stage_mask(Access::HOST_READ.stage)
            .dst_access_mask(Access::HOST_READ.access)];
        let layout = Access::TRANSFER_SRC.layout;
        // SAFETY: see `Engine`.
        unsafe {
            self.device.cmd_copy_image_to_buffer(cmd, self.image.0, layout, self.readback.0, &[all]);
            self.device.cmd_pipeline_barrier2(cmd, &vk::DependencyInfo::default().memory_barriers(&seen));
        }
    }

    fn barrier(&self, cmd: vk::CommandBuffer, from: Access, to: Access) {
        let whole = vk::ImageSubresourceRange::default().aspect_mask(vk::ImageAspectFlags::COLOR);
        let barrier = [vk::ImageMemoryBarrier2::default()
            .image(self.image.0)
            .subresource_range(whole.level_count(1).layer_count(1))
            .src_stage_mask(from.stage)
            .src_access_mask(from.access)
            .old_layout(from.layout)
            .dst_stage_mask(to.stage)
            .dst_access_mask(to.access)
            .new_layout(to.layout)];
        // SAFETY: see `Engine`.
        unsafe {
            self.device.cmd_pipeline_barrier2(cmd, &vk::DependencyInfo::default().image_memory_barriers(&barrier))
        };
    }

    /// Submits, and waits: the queue is idle afterwards, and the renderer may be dropped.
    fn finish(&self, cmd: vk::CommandBuffer) -> VkResult<()> {
        let commands = [vk::CommandBufferSubmitInfo::default().command_buffer(cmd)];
        let submit = [vk::SubmitInfo2::default().command_buffer_infos(&commands)];
        // SAFETY: see `Engine`; no other thread uses the queue.
        unsafe {
            self.device.end_command_buffer(cmd)?;
            self.device.queue_submit2(self.queue, &submit, vk::Fence::null())?;
            self.device.queue_wait_idle(self.queue)
        }
    }

    fn read(&self, [width, height]: [u32; 2]) -> VkResult<Vec<u8>> {
        // SAFETY: the memory is coherent, mapped once, at least of this size, and the commands that fill it have run.
        unsafe {
            let start = self.device.map_memory(self.readback.1, 0, vk::WHOLE_SIZE, vk::MemoryMapFlags::empty())?;
            let bytes = std::slice::from_raw_parts(start.cast::<u8>(), 4 * width as usize * height as usize).to_vec();
            self.device.unmap_memory(self.readback.1);
            Ok(bytes)
        }
    }
}

impl Drop for Engine {
    fn drop(&mut self) {
        // SAFETY: no command runs, and the context is gone. What was never made is null, which may be destroyed.
        unsafe {
            self.device.destroy_command_pool(self.pool, None);
            self.device.destroy_buffer(self.readback.0, None);
            self.device.destroy_image(self.image.0, None);
            self.device.free_memory(self.readback.1, None);
            self.device.free_memory(self.image.1, None);
            self.device.destroy_device(None);
        }
    }
}
