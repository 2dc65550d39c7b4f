//! The context: one device, one queue, and what every resource needs of them.

use std::{
    collections::HashMap,
    ffi::{CStr, CString},
    mem::ManuallyDrop,
    ops::Deref,
    path::PathBuf,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
};

use ash::{ext, vk};
use gpu_allocator::{
    AllocationSizes,
    vulkan::{Allocator, AllocatorCreateDesc},
};
#[cfg(feature = "window")]
use raw_window_handle::{RawDisplayHandle, RawWindowHandle};

use super::{
    cache,
    descriptors::Pools,
    feature::{self, Feature, Masks},
    instance::Instance,
    memory::SamplerDesc,
    retire::{self, Retired, Retirement, Ticket},
    select,
    validation::ValidationLog,
};
use crate::{
    error::{Error, Result},
    settings::Validation,
};

/// What is asked of a device.
#[derive(Clone, Copy)]
pub struct ContextDesc<'a> {
    /// The application's name, for drivers and tools.
    pub app: &'a str,
    /// How closely the validation layer looks.
    pub validation: Validation,
    /// Index, or part of the device's name in any case. `None`: discrete before integrated before virtual before CPU.
    pub selector: Option<&'a str>,
    /// A device without one of these is not used.
    pub required: &'a [Feature],
    /// Enabled where present; ask [`Context::has`].
    pub optional: &'a [Feature],
    /// Of these the first that is present, unless one is asked for already; ask [`Context::has`].
    pub alternatives: &'a [Feature],
    /// Pretended to be absent, for tests. `PRISM_MASK_FEATURES` adds to these.
    pub masked: &'a [Feature],
    /// The window to present to. It must outlive the context.
    #[cfg(feature = "window")]
    pub surface: Option<(RawDisplayHandle, RawWindowHandle)>,
}

impl Default for ContextDesc<'_> {
    fn default() -> Self {
        ContextDesc {
            app: "prism",
            validation: Validation::default(),
            selector: None,
            required: &[],
            optional: &[],
            alternatives: &[],
            masked: &[],
            #[cfg(feature = "window")]
            surface: None,
        }
    }
}

/// A Vulkan device and everything that is shared by its resources. Cloning is cheap; the device lives until the last
/// clone and the last resource are gone.
#[derive(Clone)]
pub struct Context(Arc<Inner>);

/// Fields drop in this order: the device after what was made from it, the instance last.
pub(super) struct Inner {
    retirement: Mutex<Retirement>,
    /// The pass that was recorded last.
    last_pass: Mutex<String>,
    pub samplers: Mutex<HashMap<SamplerDesc, vk::Sampler>>,
    pub pools: Mutex<Pools>,
    pub pipeline_cache: vk::PipelineCache,
    pipeline_cache_file: Option<PathBuf>,
    /// Shared with what draws the window's panel, which holds the context too.
    allocator: ManuallyDrop<Arc<Mutex<Allocator>>>,
    queue: Mutex<vk::Queue>,
    pub queue_family: u32,
    pub timestamp_bits: u32,
    properties: vk::PhysicalDeviceProperties,
    mesh_limits: Option<MeshLimits>,
    max_image_2d: u32,
    name: String,
    driver: String,
    enabled: Vec<Feature>,
    extensions: Vec<String>,
    pub physical: vk::PhysicalDevice,
    pub mesh: Option<ext::mesh_shader::Device>,
    pub debug: Option<ext::debug_utils::Device>,
    pub device: Device,
    #[cfg(feature = "window")]
    pub surface: Option<super::swapchain::Surface>,
    pub instance: Instance,
}

/// Why a lost device is no good any more.
fn lost(pass: &str) -> String {
    let pass = if pass.is_empty() { "none" } else { pass };
    format!(
        "the device was lost; the last pass recorded for it: {pass}. It ran too long, or the driver failed; try a smaller \
         --size, another --march or --gpu, or --validation sync"
    )
}

/// Limits of the mesh and task stages that the engine sizes its workgroups by.
#[derive(Clone, Copy, Debug)]
pub struct MeshLimits {
    /// Vertices one mesh workgroup may emit.
    pub max_output_vertices: u32,
    /// Primitives one mesh workgroup may emit.
    pub max_output_primitives: u32,
    /// Bytes of output of one mesh workgroup.
    pub max_output_memory: u32,
    /// Invocations of one mesh workgroup.
    pub max_invocations: u32,
    /// Workgroups in x, y and z of one draw.
    pub max_group_count: [u32; 3],
    /// Workgroups of one draw altogether.
    pub max_group_total: u32,
}

/// A device that destroys itself, unless it is a host's.
pub(super) struct Device {
    raw: ash::Device,
    owned: bool,
}

impl Deref for Device {
    type Target = ash::Device;

    fn deref(&self) -> &ash::Device {
        &self.raw
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        if self.owned {
            // SAFETY: owners of child objects hold the context, so none is left.
            unsafe { self.raw.destroy_device(None) };
        }
    }
}

/// The device of an engine that has one already, for [`Context::from_host`].
#[derive(Clone, Copy)]
pub struct Host<'a> {
    /// Loader.
    pub entry: &'a ash::Entry,
    /// Instance, made for Vulkan 1.3.
    pub instance: &'a ash::Instance,
    /// Whether the instance was made with `VK_EXT_debug_utils`: objects and passes then get names.
    pub debug_utils: bool,
    /// Physical device, of Vulkan 1.3.
    pub physical: vk::PhysicalDevice,
    /// Device.
    pub device: &'a ash::Device,
    /// A family with graphics and compute.
    pub queue_family: u32,
    /// A queue of that family: uploads and read-backs are submitted to it at once.
    pub queue: vk::Queue,
    /// What of the features that [`crate::render::features`] names the device was made with.
    pub features: &'a [Feature],
}

/// The Vulkan objects behind a [`Context`], for code that records with its own Vulkan calls.
#[derive(Clone, Copy)]
pub struct Raw<'a> {
    /// Loader.
    pub entry: &'a ash::Entry,
    /// Instance.
    pub instance: &'a ash::Instance,
    /// Device.
    pub device: &'a ash::Device,
    /// Physical device.
    pub physical: vk::PhysicalDevice,
    /// The family of the only queue: graphics, compute and presentation.
    pub queue_family: u32,
}

impl Context {
    /// Finds a device and makes it ready.
    ///
    /// # Errors
    /// [`Error::Unsupported`] where the machine lacks a loader, a device, a required feature or the validation layer;
    /// [`Error::Usage`] for a mask in the environment that names nothing.
    pub fn new(desc: &ContextDesc<'_>) -> Result<Self> {
        let masks = Masks::new(desc.masked)?;
        #[cfg(feature = "window")]
        let (instance, surface) = {
            let needed = desc.surface.map(|(display, _)| super::swapchain::instance_extensions(display)).transpose()?;
            let instance = Instance::new(desc.app, desc.validation, needed.unwrap_or_default())?;
            let surface = desc.surface.map(|(d, w)| super::swapchain::Surface::new(&instance, d, w)).transpose()?;
            (instance, surface)
        };
        #[cfg(not(feature = "window"))]
        let instance = Instance::new(desc.app, desc.validation, &[])?;

        #[cfg(feature = "window")]
        let candidates = {
            let can_present = surface.as_ref().map(|s| |physical, family| s.supports(physical, family));
            let can_present = can_present.as_ref().map(|can| can as select::CanPresent<'_>);
            select::candidates(&instance, &masks, desc.required, can_present)?
        };
        #[cfg(not(feature = "window"))]
        let candidates = select::candidates(&instance, &masks, desc.required, None)?;
        let chosen = select::choose(candidates, desc.selector)?;

        let has = |feature: &&Feature| chosen.supported.contains(feature);
        let asked = |feature: &Feature| desc.required.contains(feature) || desc.optional.contains(feature);
        let either = desc.alternatives.iter().find(has).filter(|_| !desc.alternatives.iter().any(asked));
        let enabled = Feature::ALL.iter().filter(|feature| asked(feature) || either == Some(feature));
        let enabled: Vec<_> = enabled.filter(has).copied().collect();
        let has_mesh = enabled.iter().any(|f| f.needs_mesh_extension());
        let mut extensions = Vec::new();
        if has_mesh {
            extensions.push(ext::mesh_shader::NAME);
        }
        #[cfg(feature = "window")]
        if surface.is_some() {
            extensions.push(ash::khr::swapchain::NAME);
        }
        let device = create_device(&instance, &chosen, &enabled, has_mesh, &extensions)?;
        // SAFETY: the family is the one the device was created with, with one queue.
        let queue = unsafe { device.get_device_queue(chosen.queue_family, 0) };
        let parts = Parts {
            queue,
            max_image_2d: masks.max_image_2d(chosen.properties.limits.max_image_dimension2_d),
            chosen,
            enabled,
            extensions,
            device,
            #[cfg(feature = "window")]
            surface,
            instance,
        };
        parts.assemble()
    }

    /// Makes the device of another engine ready for ours. Neither it nor its instance is destroyed with the context.
    ///
    /// # Errors
    /// [`Error::Unsupported`] below Vulkan 1.3 and for a queue family without graphics and compute.
    ///
    /// # Safety
    /// - Instance and device outlive the context and everything that is made with it.
    /// - The device was made with the features `dynamicRendering`, `synchronization2` and `maintenance4` of Vulkan 1.3,
    ///   with all of `features`, and with `VK_EXT_mesh_shader` if one of the mesh features is among these.
    /// - `queue` is a queue of the device, of the family `queue_family`, and is used by no other thread while one is in a
    ///   call of the engine: [`Context::queue`] locks it for the engine's own submissions.
    pub unsafe fn from_host(host: &Host<'_>) -> Result<Self> {
        let instance = Instance::from_host(host.entry, host.instance, host.debug_utils);
        let chosen = select::host(&instance, host.physical, host.queue_family)?;
        let has_mesh = host.features.iter().any(|f| f.needs_mesh_extension());
        let parts = Parts {
            queue: host.queue,
            max_image_2d: chosen.properties.limits.max_image_dimension2_d,
            chosen,
            enabled: host.features.to_vec(),
            extensions: if has_mesh { vec![ext::mesh_shader::NAME] } else { Vec::new() },
            device: Device { raw: host.device.clone(), owned: false },
            #[cfg(feature = "window")]
            surface: None,
            instance,
        };
        parts.assemble()
    }

    /// Whether the feature is enabled: asked for, present and not masked.
    pub fn has(&self, feature: Feature) -> bool {
        self.0.enabled.contains(&feature)
    }

    /// Exactly what was enabled beyond what every Vulkan 1.3 device has: dynamic rendering, synchronization2 and maintenance4.
    pub fn enabled_features(&self) -> &[Feature] {
        &self.0.enabled
    }

    /// Device extensions that were enabled.
    pub fn enabled_extensions(&self) -> &[String] {
        &self.0.extensions
    }

    /// The driver's name for the device.
    pub fn device_name(&self) -> &str {
        &self.0.name
    }

    /// Driver name and version text.
    pub fn driver(&self) -> &str {
        &self.0.driver
    }

    /// Whether the device is a software renderer.
    pub fn is_cpu(&self) -> bool {
        self.0.properties.device_type == vk::PhysicalDeviceType::CPU
    }

    /// The device's limits, masks not applied.
    pub fn limits(&self) -> &vk::PhysicalDeviceLimits {
        &self.0.properties.limits
    }

    /// Limits of the mesh stage; `None` unless it is enabled.
    pub fn mesh_limits(&self) -> Option<MeshLimits> {
        self.0.mesh_limits
    }

    /// Largest width and height of a 2D image, in texels; `PRISM_MASK_LIMITS` may lower it.
    pub fn max_image_2d(&self) -> u32 {
        self.0.max_image_2d
    }

    /// Whether images of this format with optimal tiling have all of `features`.
    pub fn supports_format(&self, format: vk::Format, features: vk::FormatFeatureFlags) -> bool {
        // SAFETY: the physical device comes from this instance.
        let properties = unsafe { self.0.instance.raw.get_physical_device_format_properties(self.0.physical, format) };
        properties.optimal_tiling_features.contains(features)
    }

    /// Waits until the GPU has nothing left to do.
    pub fn wait_idle(&self) -> Result<()> {
        let queue = self.queue();
        // SAFETY: the queue is locked, as the call demands. A host's other queues are none of ours.
        unsafe { self.0.device.queue_wait_idle(*queue) }.map_err(|e| self.failure("waiting for the device", e))
    }

    /// A pass is recorded.
    pub(super) fn begins_pass(&self, name: &str) {
        name.clone_into(&mut lock(&self.0.last_pass));
    }

    /// What a driver's answer means; a lost device is told with the last pass that was recorded for it.
    pub(super) fn failure(&self, doing: impl Into<String>, cause: vk::Result) -> Error {
        match cause {
            vk::Result::ERROR_DEVICE_LOST => Error::gpu(doing, lost(&lock(&self.0.last_pass))),
            _ => Error::gpu(doing, cause),
        }
    }

    /// Warnings and errors of the validation layer so far.
    pub fn validation_messages(&self) -> Vec<String> {
        self.0.instance.log.messages()
    }

    /// [`Error::Validation`] if the validation layer said anything.
    pub fn check_validation(&self) -> Result<()> {
        self.0.instance.log.check()
    }

    /// The log itself, to read what is said while the context is torn down.
    pub fn validation_log(&self) -> ValidationLog {
        self.0.instance.log.clone()
    }

    /// Every live allocation: name and bytes, the largest first.
    pub fn memory_report(&self) -> Vec<(String, u64)> {
        let report = self.allocator().generate_report();
        let mut list: Vec<_> = report.allocations.into_iter().map(|a| (a.name, a.size)).collect();
        list.sort_by(|a, b| b.1.cmp(&a.1).then_with(|| a.0.cmp(&b.0)));
        list
    }

    /// Holds back the destruction of everything that is alive now; see [`Ticket`].
    pub fn ticket(&self) -> Ticket {
        Ticket::new(self)
    }

    /// The Vulkan objects, for code that records with its own Vulkan calls.
    pub fn raw(&self) -> Raw<'_> {
        Raw {
            entry: &self.0.instance.entry,
            instance: &self.0.instance.raw,
            device: &self.0.device,
            physical: self.0.physical,
            queue_family: self.0.queue_family,
        }
    }

    /// The only queue, locked: submissions and presents need it to themselves.
    pub fn queue(&self) -> MutexGuard<'_, vk::Queue> {
        lock(&self.0.queue)
    }

    pub(super) fn inner(&self) -> &Inner {
        &self.0
    }

    pub(super) fn device(&self) -> &ash::Device {
        &self.0.device
    }

    pub(super) fn allocator(&self) -> MutexGuard<'_, Allocator> {
        lock(&self.0.allocator)
    }

    #[cfg(feature = "panel")]
    pub(super) fn shared_allocator(&self) -> Arc<Mutex<Allocator>> {
        Arc::clone(&self.0.allocator)
    }

    pub(super) fn retirement(&self) -> MutexGuard<'_, Retirement> {
        lock(&self.0.retirement)
    }

    /// Destroys the object as soon as no recording can use it.
    pub(super) fn retire(&self, object: Retired) {
        self.retirement().push(object);
        self.collect();
    }

    pub(super) fn collect(&self) {
        let free = self.retirement().take_free();
        if free.is_empty() {
            return;
        }
        // Freed sets go back to their pools, which must not be in use meanwhile.
        let _pools = lock(&self.0.pools);
        // SAFETY: no recording that began before an object was dropped is left, and later ones cannot name it.
        unsafe { retire::destroy(&self.0.device, &self.0.allocator, free) };
    }

    /// Names a Vulkan object for validation messages and debuggers.
    pub(super) fn set_name<T: vk::Handle>(&self, object: T, name: &str) {
        let Some(debug) = &self.0.debug else { return };
        let name = CString::new(name.replace('\0', "")).expect("no NUL is left");
        let info = vk::DebugUtilsObjectNameInfoEXT::default().object_handle(object).object_name(&name);
        // SAFETY: the object is alive and made by this device. Out of memory here costs a name, nothing else.
        let _ = unsafe { debug.set_debug_utils_object_name(&info) };
    }
}

impl Drop for Inner {
    fn drop(&mut self) {
        let queue = *lock(&self.queue);
        // SAFETY: this is the last user of the queue; a lost device is idle too.
        let _ = unsafe { self.device.queue_wait_idle(queue) };
        let rest = lock(&self.retirement).take_all();
        // SAFETY: the device is idle and every owner is gone.
        unsafe { retire::destroy(&self.device, &self.allocator, rest) };
        lock(&self.pools).destroy(&self.device);
        for (_, sampler) in lock(&self.samplers).drain() {
            // SAFETY: the device is idle and every owner is gone.
            unsafe { self.device.destroy_sampler(sampler, None) };
        }
        // SAFETY: the cache is alive and used by no other thread.
        let data = unsafe { self.device.get_pipeline_cache_data(self.pipeline_cache) };
        if let (Some(file), Ok(data)) = (&self.pipeline_cache_file, data) {
            cache::store(file, &data);
        }
        // SAFETY: no pipeline is being created; destroyed once.
        unsafe { self.device.destroy_pipeline_cache(self.pipeline_cache, None) };
        for leak in lock(&self.allocator).generate_report().allocations {
            tracing::error!("memory of '{}' was not freed", leak.name);
        }
        // SAFETY: dropped once, here, before the device that its memory comes from.
        unsafe { ManuallyDrop::drop(&mut self.allocator) };
    }
}

/// What a context is made of.
struct Parts {
    queue: vk::Queue,
    max_image_2d: u32,
    chosen: select::Candidate,
    enabled: Vec<Feature>,
    extensions: Vec<&'static CStr>,
    device: Device,
    #[cfg(feature = "window")]
    surface: Option<super::swapchain::Surface>,
    instance: Instance,
}

impl Parts {
    fn assemble(self) -> Result<Context> {
        // Locals are dropped in reverse, should one of the steps fail.
        let Parts {
            instance,
            #[cfg(feature = "window")]
            surface,
            device,
            extensions,
            enabled,
            chosen,
            max_image_2d,
            queue,
        } = self;
        let has_mesh = enabled.iter().any(|f| f.needs_mesh_extension());
        let allocator = Allocator::new(&AllocatorCreateDesc {
            instance: instance.raw.clone(),
            device: device.raw.clone(),
            physical_device: chosen.physical,
            debug_settings: Default::default(),
            buffer_device_address: false,
            // Small first blocks: most scenes here are far below the default 256 MiB.
            allocation_sizes: AllocationSizes::new(16 << 20, 8 << 20)
                .with_max_device_memblock_size(256 << 20)
                .with_max_host_memblock_size(64 << 20),
        })
        .map_err(|e| Error::gpu("creating the memory allocator", e))?;
        let (pipeline_cache, pipeline_cache_file) = load_pipeline_cache(&device, &chosen.properties)?;
        let debug = instance.has_debug_utils.then(|| ext::debug_utils::Device::new(&instance.raw, &device));
        let context = Context(Arc::new(Inner {
            retirement: Mutex::default(),
            last_pass: Mutex::default(),
            samplers: Mutex::default(),
            pools: Mutex::default(),
            pipeline_cache,
            pipeline_cache_file,
            allocator: ManuallyDrop::new(Arc::new(Mutex::new(allocator))),
            queue: Mutex::new(queue),
            queue_family: chosen.queue_family,
            timestamp_bits: chosen.timestamp_bits,
            mesh_limits: has_mesh.then(|| mesh_limits(&instance, chosen.physical)),
            max_image_2d,
            properties: chosen.properties,
            name: chosen.report.name,
            driver: chosen.report.driver,
            enabled,
            extensions: extensions.iter().map(|e| e.to_string_lossy().into_owned()).collect(),
            physical: chosen.physical,
            mesh: has_mesh.then(|| ext::mesh_shader::Device::new(&instance.raw, &device)),
            debug,
            device,
            #[cfg(feature = "window")]
            surface,
            instance,
        }));
        context.set_name(queue, "queue");
        context.set_name(pipeline_cache, "pipeline cache");
        tracing::debug!("device: {}, {}", context.device_name(), context.driver());
        Ok(context)
    }
}

/// A panic in another thread leaves the data of these locks usable.
pub(super) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

fn create_device(
    instance: &Instance,
    chosen: &select::Candidate,
    enabled: &[Feature],
    has_mesh: bool,
    extensions: &[&CStr],
) -> Result<Device> {
    let queues =
        [vk::DeviceQueueCreateInfo::default().queue_family_index(chosen.queue_family).queue_priorities(&[1.0])];
    let (core, mut mesh) = feature::feature_structs(enabled);
    // Every Vulkan 1.3 device has these. Maintenance4 is for `LocalSizeId`, which glslang writes for SPIR-V 1.6.
    let mut v13 =
        vk::PhysicalDeviceVulkan13Features::default().dynamic_rendering(true).synchronization2(true).maintenance4(true);
    let mut features = vk::PhysicalDeviceFeatures2::default().features(core).push_next(&mut v13);
    if has_mesh {
        features = features.push_next(&mut mesh);
    }
    let names: Vec<_> = extensions.iter().map(|e| e.as_ptr()).collect();
    let info = vk::DeviceCreateInfo::default()
        .queue_create_infos(&queues)
        .enabled_extension_names(&names)
        .push_next(&mut features);
    // SAFETY: everything in the chain lives until the call returns and was reported as supported.
    let device = unsafe { instance.raw.create_device(chosen.physical, &info, None) };
    device
        .map(|raw| Device { raw, owned: true })
        .map_err(|e| Error::gpu(format!("creating a device on {}", chosen.report.name), e))
}

fn mesh_limits(instance: &Instance, physical: vk::PhysicalDevice) -> MeshLimits {
    let mut mesh = vk::PhysicalDeviceMeshShaderPropertiesEXT::default();
    let mut all = vk::PhysicalDeviceProperties2::default().push_next(&mut mesh);
    // SAFETY: called only where the device has the extension.
    unsafe { instance.raw.get_physical_device_properties2(physical, &mut all) };
    MeshLimits {
        max_output_vertices: mesh.max_mesh_output_vertices,
        max_output_primitives: mesh.max_mesh_output_primitives,
        max_output_memory: mesh.max_mesh_output_memory_size,
        max_invocations: mesh.max_mesh_work_group_invocations,
        max_group_count: mesh.max_mesh_work_group_count,
        max_group_total: mesh.max_mesh_work_group_total_count,
    }
}

/// The cache of this device and driver version, empty where there is none yet.
fn load_pipeline_cache(
    device: &Device,
    properties: &vk::PhysicalDeviceProperties,
) -> Result<(vk::PipelineCache, Option<PathBuf>)> {
    let uuid: String = properties.pipeline_cache_uuid.iter().map(|b| format!("{b:02x}")).collect();
    let name = format!("pipelines-{uuid}-{:x}.bin", properties.driver_version);
    let file = cache::default_cache_dir().map(|dir| dir.join(name));
    let data = file.as_deref().and_then(cache::load).unwrap_or_default();
    let info = vk::PipelineCacheCreateInfo::default().initial_data(&data);
    // SAFETY: the data are whole (checksum) and were written by this driver version for this device.
    let pipelines = unsafe { device.create_pipeline_cache(&info, None) };
    Ok((pipelines.map_err(|e| Error::gpu("creating the pipeline cache", e))?, file))
}
