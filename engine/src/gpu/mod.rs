//! Explicit Vulkan 1.3: device, memory, images, pipelines, shaders, frames, queries, swapchain. Knows no scene.
//!
//! Every resource owns its Vulkan objects, has a debug name, and may be dropped at any time: the deletion queue
//! destroys it once no recording that could use it is left ([`Ticket`]). Dynamic rendering and synchronization2 are
//! used throughout; any feature that a Vulkan 1.3 device may lack is enabled only where [`ContextDesc`] asks for it.
//!
//! Two environment variables let tests pretend that a device is lesser than it is:
//!
//! - `PRISM_MASK_FEATURES=mesh,geometry` hides features by their [`Feature::name`];
//! - `PRISM_MASK_LIMITS=maxImageDimension2D=256` lowers [`Context::max_image_2d`].

mod access;
mod cache;
mod descriptors;
mod device;
mod encoder;
mod feature;
mod frame;
mod instance;
mod memory;
mod pipeline;
mod queries;
mod readback;
mod retire;
mod select;
mod shader;
#[cfg(feature = "window")]
mod swapchain;
#[cfg(test)]
mod tests;
mod transfer;
mod validation;

pub use access::Access;
pub use ash::vk;
pub use cache::default_cache_dir;
pub use descriptors::{Binding, DescriptorSet};
pub use device::{Context, ContextDesc, Host, MeshLimits, Raw};
pub use encoder::{Attachment, CommandEncoder, DepthAttachment, Load, RenderingDesc};
pub use feature::{Feature, feature_structs};
pub use frame::{Frame, Frames, run_once};
pub use memory::{
    Buffer, BufferDesc, Image, ImageDesc, MemoryLocation, Sampler, SamplerDesc, Uploader, format_bytes, full_mip_count,
};
pub use pipeline::{Creation, DepthState, GraphicsDesc, Pipeline, VertexLayout};
pub use queries::{PassTime, PassTimers, Statistics};
pub use readback::{read_buffer, read_image, readback_buffer};
pub use retire::Ticket;
pub use select::{DeviceReport, chosen_device, list_devices, supported_features};
pub use shader::{BindingInfo, BlockMember, CompileStats, Reflection, Shader, ShaderCompiler, ShaderStage};
#[cfg(feature = "window")]
pub use swapchain::{Swapchain, Target};
pub use validation::ValidationLog;
