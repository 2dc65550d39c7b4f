//! The validation layer's voice: collected, logged, and never lost.

use std::{
    ffi::{CStr, c_void},
    sync::{Arc, Mutex, PoisonError},
};

use ash::vk;

use crate::error::{Error, Result};

/// The layer that checks our calls.
pub(super) const LAYER: &CStr = c"VK_LAYER_KHRONOS_validation";

/// A message that is wrong, and why we may pass over it.
struct FalsePositive {
    vuid: &'static str,
    /// The layer's version that the message was seen with.
    layer: &'static str,
    reason: &'static str,
}

/// The only place where a message may be silenced.
const FALSE_POSITIVES: &[FalsePositive] = &[];

/// Warnings and errors of one context. Outlives the context, so that messages of its teardown can be read.
#[derive(Clone, Debug, Default)]
pub struct ValidationLog(Arc<Messages>);

#[derive(Debug, Default)]
struct Messages(Mutex<Vec<String>>);

impl ValidationLog {
    /// Every message so far, oldest first.
    pub fn messages(&self) -> Vec<String> {
        self.0.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// [`Error::Validation`] if there is any message.
    pub fn check(&self) -> Result<()> {
        let messages = self.messages();
        match messages.first() {
            None => Ok(()),
            Some(first) => Err(Error::Validation { count: messages.len(), first: first.clone() }),
        }
    }

    /// What a messenger needs to write here, a host's too. `self`, or a clone of it, must outlive that messenger.
    pub fn messenger_info(&self) -> vk::DebugUtilsMessengerCreateInfoEXT<'static> {
        use vk::{DebugUtilsMessageSeverityFlagsEXT as Severity, DebugUtilsMessageTypeFlagsEXT as Type};
        let mut info = vk::DebugUtilsMessengerCreateInfoEXT::default()
            .message_severity(Severity::WARNING | Severity::ERROR)
            // GENERAL is left out: the loader reports other vendors' broken drivers there, which is not our fault.
            .message_type(Type::VALIDATION | Type::PERFORMANCE)
            .pfn_user_callback(Some(on_message));
        info.p_user_data = Arc::as_ptr(&self.0).cast_mut().cast();
        info
    }
}

/// Called by the layer, on the thread whose call it objects to.
unsafe extern "system" fn on_message(
    severity: vk::DebugUtilsMessageSeverityFlagsEXT,
    _types: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    user: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: the layer passes a valid struct for the time of the call.
    let data = unsafe { &*data };
    // SAFETY: `user` is the `Messages` of a log that outlives its messengers; they are only ever shared.
    let log = unsafe { &*user.cast::<Messages>() };
    // SAFETY: both strings are null or null-terminated and live for the time of the call.
    let (id, text) = unsafe { (data.message_id_name_as_c_str(), data.message_as_c_str()) };
    let id = id.map(CStr::to_string_lossy).unwrap_or_default();
    let text = text.map(CStr::to_string_lossy).unwrap_or_default();
    if let Some(known) = FALSE_POSITIVES.iter().find(|known| known.vuid == id) {
        tracing::debug!("passed over {id} (layer {}): {}", known.layer, known.reason);
        return vk::FALSE;
    }
    if severity.contains(vk::DebugUtilsMessageSeverityFlagsEXT::ERROR) {
        tracing::error!("validation: {text}");
    } else {
        tracing::warn!("validation: {text}");
    }
    // The layer's text usually begins with the id; those that do not still need it.
    let message = if text.contains(&*id) { text.into_owned() } else { format!("{id}: {text}") };
    log.0.lock().unwrap_or_else(PoisonError::into_inner).push(message);
    vk::FALSE
}
