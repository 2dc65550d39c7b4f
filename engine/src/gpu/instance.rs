//! The Vulkan loader, one instance, and its debug messenger.

use std::ffi::{CStr, CString, c_char};

use ash::{ext, vk};

use super::validation::{LAYER, ValidationLog};
use crate::{
    error::{Error, Result},
    settings::Validation,
};

/// An instance that destroys itself, after everything made from it, unless it is a host's.
pub(super) struct Instance {
    pub raw: ash::Instance,
    /// Keeps the loader's library open.
    pub entry: ash::Entry,
    pub log: ValidationLog,
    /// Whether objects and regions can be named.
    pub has_debug_utils: bool,
    owned: bool,
    messenger: Option<(ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT)>,
}

const NO_DRIVER: &str = "install a Vulkan 1.3 driver (without a GPU: Mesa's lavapipe, package mesa-vulkan-drivers)";

impl Instance {
    /// `surface_extensions` are those that the window system needs; empty when rendering offscreen.
    pub fn new(app: &str, validation: Validation, surface_extensions: &[*const c_char]) -> Result<Self> {
        // SAFETY: the system's Vulkan loader runs its initialisers; `Instance` keeps it loaded while in use.
        let entry = unsafe { ash::Entry::load() }
            .map_err(|e| Error::unsupported(format!("no Vulkan loader on this machine: {e}"), NO_DRIVER))?;
        // SAFETY: no requirements beyond a loaded entry.
        let version = unsafe { entry.try_enumerate_instance_version() };
        let version = version.ok().flatten().unwrap_or(vk::API_VERSION_1_0);
        if version < vk::API_VERSION_1_3 {
            let have = super::select::version(version);
            return Err(Error::unsupported(format!("the Vulkan loader is version {have}, 1.3 is needed"), NO_DRIVER));
        }
        let has_debug_utils = has_extension(&entry, None, ext::debug_utils::NAME);
        let mut extensions = surface_extensions.to_vec();
        if has_debug_utils {
            extensions.push(ext::debug_utils::NAME.as_ptr());
        }
        let mut layers = Vec::new();
        if validation != Validation::Off {
            require_layer(&entry, validation)?;
            layers.push(LAYER.as_ptr());
        }
        if validation == Validation::Sync {
            extensions.push(ext::validation_features::NAME.as_ptr());
        }
        let log = ValidationLog::default();
        let name = CString::new(app.replace('\0', "")).expect("no NUL is left");
        let app_info = vk::ApplicationInfo::default()
            .application_name(&name)
            .engine_name(c"Prism Shell")
            .api_version(vk::API_VERSION_1_3);
        let mut info = vk::InstanceCreateInfo::default()
            .application_info(&app_info)
            .enabled_layer_names(&layers)
            .enabled_extension_names(&extensions);
        let mut messenger_info = log.messenger_info();
        let mut sync = vk::ValidationFeaturesEXT::default()
            .enabled_validation_features(&[vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION]);
        if validation != Validation::Off {
            // Chained here too, so that the creation and destruction of the instance itself are heard.
            info = info.push_next(&mut messenger_info);
        }
        if validation == Validation::Sync {
            info = info.push_next(&mut sync);
        }
        // SAFETY: every pointer in `info` lives until the call returns; `log` lives in the result.
        let raw = unsafe { entry.create_instance(&info, None) }.map_err(|e| match e {
            vk::Result::ERROR_INCOMPATIBLE_DRIVER => Error::unsupported("no Vulkan driver on this machine", NO_DRIVER),
            vk::Result::ERROR_EXTENSION_NOT_PRESENT => Error::unsupported(
                "the Vulkan driver cannot draw to this window system",
                "render without a window (--headless), or install a driver that can",
            ),
            e => Error::gpu("creating the Vulkan instance", e),
        })?;
        let mut instance = Instance { raw, entry, log, has_debug_utils, owned: true, messenger: None };
        if validation != Validation::Off {
            let utils = ext::debug_utils::Instance::new(&instance.entry, &instance.raw);
            // SAFETY: the log that the messenger writes to lives in `instance`, which destroys the messenger first.
            let messenger = unsafe { utils.create_debug_utils_messenger(&instance.log.messenger_info(), None) }
                .map_err(|e| Error::gpu("creating the debug messenger", e))?;
            instance.messenger = Some((utils, messenger));
        }
        Ok(instance)
    }

    /// A host's instance. What the validation layer says is the host's to hear: the log stays empty.
    pub fn from_host(entry: &ash::Entry, raw: &ash::Instance, has_debug_utils: bool) -> Self {
        let log = ValidationLog::default();
        Instance { raw: raw.clone(), entry: entry.clone(), log, has_debug_utils, owned: false, messenger: None }
    }
}

impl Drop for Instance {
    fn drop(&mut self) {
        if let Some((utils, messenger)) = self.messenger.take() {
            // SAFETY: created from this instance, destroyed once.
            unsafe { utils.destroy_debug_utils_messenger(messenger, None) };
        }
        if self.owned {
            // SAFETY: owners of child objects hold this struct, so none is left.
            unsafe { self.raw.destroy_instance(None) };
        }
    }
}

/// Whether the instance, or one of its layers, has an extension.
fn has_extension(entry: &ash::Entry, layer: Option<&CStr>, name: &CStr) -> bool {
    // SAFETY: no requirements beyond a loaded entry.
    let list = unsafe { entry.enumerate_instance_extension_properties(layer) };
    list.unwrap_or_default().iter().any(|e| e.extension_name_as_c_str() == Ok(name))
}

fn require_layer(entry: &ash::Entry, validation: Validation) -> Result<()> {
    // SAFETY: no requirements beyond a loaded entry.
    let layers = unsafe { entry.enumerate_instance_layer_properties() }.unwrap_or_default();
    if !layers.iter().any(|l| l.layer_name_as_c_str() == Ok(LAYER)) {
        return Err(Error::unsupported(
            format!("the layer {} is not installed", LAYER.to_string_lossy()),
            "install it (package vulkan-validationlayers), or pass --validation off",
        ));
    }
    if !has_extension(entry, Some(LAYER), ext::debug_utils::NAME) && !has_extension(entry, None, ext::debug_utils::NAME)
    {
        return Err(Error::unsupported("VK_EXT_debug_utils is missing", "update the validation layer"));
    }
    if validation == Validation::Sync && !has_extension(entry, Some(LAYER), ext::validation_features::NAME) {
        return Err(Error::unsupported(
            "this validation layer has no synchronization checks (VK_EXT_validation_features)",
            "update it, or pass --validation core",
        ));
    }
    Ok(())
}
