//! Buffers, images and samplers: owned, named, and destroyed only when the GPU is done with them.

mod buffer;
mod image;
mod sampler;
mod upload;

pub use buffer::{Buffer, BufferDesc};
pub use gpu_allocator::MemoryLocation;
pub use image::{Image, ImageDesc, format_bytes, full_mip_count};
pub use sampler::{Sampler, SamplerDesc};
pub use upload::Uploader;
