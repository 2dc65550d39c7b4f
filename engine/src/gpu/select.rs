//! Which physical device is used, and why another is not.

use std::ffi::CStr;

use ash::{khr, vk};

use super::{
    feature::{self, Feature, Masks},
    instance::Instance,
};
use crate::{
    error::{Error, Result},
    settings::Validation,
};

/// One Vulkan device as `prism devices` shows it.
#[derive(Clone, Debug)]
pub struct DeviceReport {
    /// What `--gpu` takes.
    pub index: usize,
    /// The driver's name for it.
    pub name: String,
    /// "discrete", "integrated", "virtual", "cpu" or "other".
    pub kind: &'static str,
    /// Vulkan version, as in "1.3.289".
    pub api_version: String,
    /// Driver name and version text.
    pub driver: String,
    /// Why the engine cannot use it; `None` if it can.
    pub rejected: Option<String>,
    /// Every feature the engine knows, and whether the device has it, masks applied.
    pub features: Vec<(Feature, bool)>,
}

/// Every Vulkan device of this machine. `required` only adds to the reasons of rejection; it may be empty.
///
/// # Errors
/// [`Error::Unsupported`] without a loader, a driver, any device, or the validation layer if asked for.
pub fn list_devices(validation: Validation, required: &[Feature]) -> Result<Vec<DeviceReport>> {
    let masks = Masks::new(&[])?;
    let instance = Instance::new("prism devices", validation, &[])?;
    Ok(candidates(&instance, &masks, required, None)?.into_iter().map(|c| c.report).collect())
}

/// The device that `selector` names (an index, or part of a name in any case), else the one that is used without it.
///
/// # Errors
/// [`Error::Unsupported`] where there is none.
pub fn chosen_device(selector: Option<&str>) -> Result<DeviceReport> {
    let masks = Masks::new(&[])?;
    let instance = Instance::new("prism explain", Validation::Off, &[])?;
    Ok(choose(candidates(&instance, &masks, &[], None)?, selector)?.report)
}

/// Tells whether a device's queue family can present to the window.
pub(super) type CanPresent<'a> = &'a dyn Fn(vk::PhysicalDevice, u32) -> bool;

pub(super) struct Candidate {
    pub physical: vk::PhysicalDevice,
    pub properties: vk::PhysicalDeviceProperties,
    /// A family with graphics and compute, and presentation if asked for. 0 in a rejected device.
    pub queue_family: u32,
    pub timestamp_bits: u32,
    /// Masks applied.
    pub supported: Vec<Feature>,
    pub report: DeviceReport,
}

pub(super) fn candidates(
    instance: &Instance,
    masks: &Masks,
    required: &[Feature],
    can_present: Option<CanPresent<'_>>,
) -> Result<Vec<Candidate>> {
    // SAFETY: the instance is alive.
    let devices = unsafe { instance.raw.enumerate_physical_devices() }
        .map_err(|e| Error::gpu("listing the Vulkan devices", e))?;
    if devices.is_empty() {
        return Err(Error::unsupported(
            "no Vulkan device on this machine",
            "install a driver (without a GPU: Mesa's lavapipe, package mesa-vulkan-drivers)",
        ));
    }
    let inspect = |(index, &physical)| inspect(instance, masks, required, can_present, index, physical);
    Ok(devices.iter().enumerate().map(inspect).collect())
}

/// The device and queue family of a host.
pub(super) fn host(instance: &Instance, physical: vk::PhysicalDevice, queue_family: u32) -> Result<Candidate> {
    let mut candidate = inspect(instance, &Masks::default(), &[], None, 0, physical);
    let refuse = |reason: &str| {
        let what = format!("the host's Vulkan device '{}': {reason}", candidate.report.name);
        Err(Error::unsupported(what, "give the engine a device and a queue that meet its requirements"))
    };
    if let Some(reason) = &candidate.report.rejected {
        return refuse(reason);
    }
    // SAFETY: `physical` comes from this instance.
    let families = unsafe { instance.raw.get_physical_device_queue_family_properties(physical) };
    let both = vk::QueueFlags::GRAPHICS | vk::QueueFlags::COMPUTE;
    let Some(family) = families.get(queue_family as usize).filter(|family| family.queue_flags.contains(both)) else {
        return refuse(&format!("queue family {queue_family} lacks graphics or compute"));
    };
    (candidate.queue_family, candidate.timestamp_bits) = (queue_family, family.timestamp_valid_bits);
    Ok(candidate)
}

fn inspect(
    instance: &Instance,
    masks: &Masks,
    required: &[Feature],
    can_present: Option<CanPresent<'_>>,
    index: usize,
    physical: vk::PhysicalDevice,
) -> Candidate {
    // SAFETY: `physical` comes from this instance.
    let properties = unsafe { instance.raw.get_physical_device_properties(physical) };
    let name = properties.device_name_as_c_str().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
    let mut candidate = Candidate {
        physical,
        properties,
        queue_family: 0,
        timestamp_bits: 0,
        supported: Vec::new(),
        report: DeviceReport {
            index,
            name,
            kind: kind(properties.device_type),
            api_version: version(properties.api_version),
            driver: format!("driver version {:#x}", properties.driver_version),
            rejected: None,
            features: Vec::new(),
        },
    };
    // Below 1.3 the queries further down are not valid calls.
    let rejected = if properties.api_version < vk::API_VERSION_1_3 {
        Some(format!("Vulkan {}, 1.3 is needed", candidate.report.api_version))
    } else {
        candidate.report.driver = driver(instance, physical);
        let can_swap = has_extension(&instance.raw, physical, khr::swapchain::NAME);
        // SAFETY: `physical` comes from this instance, and is of Vulkan 1.3.
        candidate.supported = unsafe { supported_features(&instance.raw, physical) };
        candidate.supported.retain(|f| !masks.hides(*f));
        let missing: Vec<_> = required.iter().filter(|f| !candidate.supported.contains(f)).map(|f| f.name()).collect();
        match queue_family(instance, physical, can_present) {
            Err(reason) => Some(reason.to_owned()),
            Ok(_) if can_present.is_some() && !can_swap => Some("no VK_KHR_swapchain".to_owned()),
            Ok(_) if !missing.is_empty() => Some(format!("lacks {}", missing.join(", "))),
            Ok((family, bits)) => {
                (candidate.queue_family, candidate.timestamp_bits) = (family, bits);
                None
            }
        }
    };
    candidate.report.rejected = rejected;
    candidate.report.features = Feature::ALL.iter().map(|f| (*f, candidate.supported.contains(f))).collect();
    candidate
}

/// The device that `selector` names (an index, or part of a name in any case), else the fastest kind that is usable.
pub(super) fn choose(candidates: Vec<Candidate>, selector: Option<&str>) -> Result<Candidate> {
    let list = candidates.iter().map(|c| describe(&c.report)).collect::<Vec<_>>().join("; ");
    let matches = |c: &Candidate| match selector {
        None => true,
        Some(text) => match text.parse::<usize>() {
            Ok(index) => index == c.report.index,
            Err(_) => c.report.name.to_lowercase().contains(&text.to_lowercase()),
        },
    };
    let (named, others): (Vec<_>, Vec<_>) = candidates.into_iter().partition(matches);
    if named.is_empty() {
        return Err(Error::unsupported(
            format!("no Vulkan device matches --gpu {}", selector.unwrap_or_default()),
            format!("choose one by index or name: {list}"),
        ));
    }
    let usable = named.into_iter().filter(|c| c.report.rejected.is_none());
    // `min_by_key` keeps the first of equals: the loader's order.
    usable.min_by_key(|c| rank(c.properties.device_type)).ok_or_else(|| {
        let mend = if others.is_empty() {
            "run on a machine with such a device, or ask for less (`prism devices` shows what each has)"
        } else {
            "choose another with --gpu (`prism devices` shows what each has)"
        };
        Error::unsupported(format!("no usable Vulkan device: {list}"), mend)
    })
}

fn describe(report: &DeviceReport) -> String {
    let reason = report.rejected.as_ref().map(|r| format!(" ({r})")).unwrap_or_default();
    format!("{} {}{reason}", report.index, report.name)
}

fn rank(kind: vk::PhysicalDeviceType) -> u32 {
    match kind {
        vk::PhysicalDeviceType::DISCRETE_GPU => 0,
        vk::PhysicalDeviceType::INTEGRATED_GPU => 1,
        vk::PhysicalDeviceType::VIRTUAL_GPU => 2,
        vk::PhysicalDeviceType::CPU => 3,
        _ => 4,
    }
}

fn kind(kind: vk::PhysicalDeviceType) -> &'static str {
    match kind {
        vk::PhysicalDeviceType::DISCRETE_GPU => "discrete",
        vk::PhysicalDeviceType::INTEGRATED_GPU => "integrated",
        vk::PhysicalDeviceType::VIRTUAL_GPU => "virtual",
        vk::PhysicalDeviceType::CPU => "cpu",
        _ => "other",
    }
}

/// "major.minor.patch".
pub(super) fn version(v: u32) -> String {
    format!("{}.{}.{}", vk::api_version_major(v), vk::api_version_minor(v), vk::api_version_patch(v))
}

fn driver(instance: &Instance, physical: vk::PhysicalDevice) -> String {
    let mut driver = vk::PhysicalDeviceDriverProperties::default();
    let mut all = vk::PhysicalDeviceProperties2::default().push_next(&mut driver);
    // SAFETY: the device is at least Vulkan 1.3, where this struct is core.
    unsafe { instance.raw.get_physical_device_properties2(physical, &mut all) };
    let text = |s: std::result::Result<&CStr, ()>| s.map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
    format!(
        "{} {}",
        text(driver.driver_name_as_c_str().map_err(drop)),
        text(driver.driver_info_as_c_str().map_err(drop))
    )
}

fn has_extension(instance: &ash::Instance, physical: vk::PhysicalDevice, name: &CStr) -> bool {
    // SAFETY: `physical` comes from this instance.
    let extensions = unsafe { instance.enumerate_device_extension_properties(physical) }.unwrap_or_default();
    extensions.iter().any(|e| e.extension_name_as_c_str() == Ok(name))
}

/// The features that a device has, for a host that chooses one.
///
/// # Safety
/// `physical` comes from `instance`, and both are of Vulkan 1.3.
pub unsafe fn supported_features(instance: &ash::Instance, physical: vk::PhysicalDevice) -> Vec<Feature> {
    feature::supported(instance, physical, has_extension(instance, physical, ash::ext::mesh_shader::NAME))
}

/// One family for everything: frames here never overlap compute with graphics, so a second queue would buy nothing.
fn queue_family(
    instance: &Instance,
    physical: vk::PhysicalDevice,
    can_present: Option<CanPresent<'_>>,
) -> std::result::Result<(u32, u32), &'static str> {
    // SAFETY: `physical` comes from this instance.
    let families = unsafe { instance.raw.get_physical_device_queue_family_properties(physical) };
    let both = vk::QueueFlags::GRAPHICS | vk::QueueFlags::COMPUTE;
    let mut able = (0u32..).zip(&families).filter(|(_, f)| f.queue_flags.contains(both)).peekable();
    if able.peek().is_none() {
        return Err("no queue with graphics and compute");
    }
    able.find(|(index, _)| can_present.is_none_or(|can| can(physical, *index)))
        .map(|(index, f)| (index, f.timestamp_valid_bits))
        .ok_or("cannot present to this window")
}
