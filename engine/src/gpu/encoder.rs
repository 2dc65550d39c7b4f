//! Commands into one command buffer.

use std::ffi::CString;

use ash::vk;
use bytemuck::Pod;

use super::{
    access::Access,
    descriptors::DescriptorSet,
    device::Context,
    memory::{Buffer, Image},
    pipeline::Pipeline,
};

/// What an attachment holds before the pass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Load {
    /// This colour.
    Clear([f32; 4]),
    /// What it held.
    Keep,
    /// Anything: every pixel will be written.
    DontCare,
}

/// A colour target, in the layout of [`Access::COLOR_WRITE`].
#[derive(Clone, Copy)]
pub struct Attachment<'a> {
    /// Drawn to.
    pub image: &'a Image,
    /// Before the pass.
    pub load: Load,
    /// Whether the result is kept (a multisampled image that is resolved need not be).
    pub store: bool,
    /// Receives the average of the samples, in the layout of [`Access::COLOR_WRITE`].
    pub resolve: Option<&'a Image>,
}

/// The depth target, in the layout of [`Access::DEPTH_WRITE`].
#[derive(Clone, Copy)]
pub struct DepthAttachment<'a> {
    /// Tested and written.
    pub image: &'a Image,
    /// Depth before the pass; `None` keeps what it held.
    pub clear: Option<f32>,
    /// Whether the result is kept.
    pub store: bool,
}

/// A pass of dynamic rendering.
#[derive(Clone, Copy)]
pub struct RenderingDesc<'a> {
    /// Region name in debuggers and validation messages.
    pub name: &'a str,
    /// Colour targets by location.
    pub color: &'a [Attachment<'a>],
    /// Depth target.
    pub depth: Option<DepthAttachment<'a>>,
    /// Drawn area in pixels, from the top left corner.
    pub extent: [u32; 2],
}

/// Records into a command buffer that someone else begins, ends and submits ([`super::Frames`], or a host).
///
/// Resources that are named in a command must live until it has run; the engine's own are, through the deletion queue
/// and the [`super::Ticket`] of the recording.
pub struct CommandEncoder {
    ctx: Context,
    raw: vk::CommandBuffer,
}

impl CommandEncoder {
    /// Records into a host's command buffer, which must be in the recording state, of a pool of the context's queue
    /// family, and used by no other thread meanwhile. The host holds a [`Context::ticket`] until it has run.
    pub fn from_raw(ctx: &Context, raw: vk::CommandBuffer) -> Self {
        CommandEncoder { ctx: ctx.clone(), raw }
    }

    /// The command buffer, for a caller's own Vulkan calls.
    pub fn raw(&self) -> vk::CommandBuffer {
        self.raw
    }

    /// The context recorded for.
    pub fn context(&self) -> &Context {
        &self.ctx
    }

    /// Begins a pass, with viewport and scissor over its whole area.
    pub fn begin_rendering(&mut self, desc: &RenderingDesc<'_>) {
        self.begin_region(desc.name);
        let color: Vec<_> = desc.color.iter().map(color_info).collect();
        let depth = desc.depth.as_ref().map(|depth| {
            let load = if depth.clear.is_some() { vk::AttachmentLoadOp::CLEAR } else { vk::AttachmentLoadOp::LOAD };
            let value = vk::ClearDepthStencilValue { depth: depth.clear.unwrap_or_default(), stencil: 0 };
            vk::RenderingAttachmentInfo::default()
                .image_view(depth.image.view())
                .image_layout(Access::DEPTH_WRITE.layout)
                .load_op(load)
                .store_op(store_op(depth.store))
                .clear_value(vk::ClearValue { depth_stencil: value })
        });
        let [width, height] = desc.extent;
        let area = vk::Rect2D { offset: vk::Offset2D::default(), extent: vk::Extent2D { width, height } };
        let mut info = vk::RenderingInfo::default().render_area(area).layer_count(1).color_attachments(&color);
        if let Some(depth) = &depth {
            info = info.depth_attachment(depth);
        }
        // SAFETY: recording; the views are alive and in the layouts that the attachment types document.
        unsafe { self.ctx.device().cmd_begin_rendering(self.raw, &info) };
        self.set_viewport([0, 0], desc.extent);
    }

    /// Ends the pass.
    pub fn end_rendering(&mut self) {
        // SAFETY: recording, inside a pass.
        unsafe { self.ctx.device().cmd_end_rendering(self.raw) };
        self.end_region();
    }

    /// Viewport and scissor over `extent` from the pixel `origin` on, y down, depth 0 to 1.
    pub fn set_viewport(&mut self, origin: [u32; 2], extent: [u32; 2]) {
        let [[x, y], [width, height]] = [origin, extent];
        let viewport = vk::Viewport {
            x: x as f32,
            y: y as f32,
            width: width as f32,
            height: height as f32,
            min_depth: 0.0,
            max_depth: 1.0,
        };
        // SAFETY: recording.
        unsafe { self.ctx.device().cmd_set_viewport(self.raw, 0, &[viewport]) };
        self.set_scissor(origin, extent);
    }

    /// Draws only within `extent` from the pixel `origin` on.
    pub fn set_scissor(&mut self, [x, y]: [u32; 2], [width, height]: [u32; 2]) {
        let offset = vk::Offset2D { x: x as i32, y: y as i32 };
        let scissor = vk::Rect2D { offset, extent: vk::Extent2D { width, height } };
        // SAFETY: recording.
        unsafe { self.ctx.device().cmd_set_scissor(self.raw, 0, &[scissor]) };
    }

    /// Draws or dispatches with this pipeline from now on.
    pub fn bind_pipeline(&mut self, pipeline: &Pipeline) {
        // SAFETY: recording; the pipeline is alive.
        unsafe { self.ctx.device().cmd_bind_pipeline(self.raw, pipeline.bind_point(), pipeline.handle()) };
    }

    /// Binds a set that was made for this pipeline and index.
    pub fn bind_set(&mut self, pipeline: &Pipeline, index: u32, set: &DescriptorSet) {
        // SAFETY: recording; set and layout are alive and compatible if the set was made for the pipeline.
        unsafe {
            self.ctx.device().cmd_bind_descriptor_sets(
                self.raw,
                pipeline.bind_point(),
                pipeline.layout(),
                index,
                &[set.handle()],
                &[],
            );
        }
    }

    /// Push constants for all stages of the pipeline that read them. `T` mirrors the shader's block; what lies past
    /// the block's end is left out, so a variant that reads none ignores them.
    pub fn push<T: Pod>(&mut self, pipeline: &Pipeline, value: &T) {
        let (stages, size) = pipeline.push_range();
        let bytes = bytemuck::bytes_of(value);
        debug_assert!(
            bytes.len() as u32 >= pipeline.push_constant_size(),
            "push constants of '{}': {} bytes given, {} read",
            pipeline.name(),
            bytes.len(),
            pipeline.push_constant_size(),
        );
        let bytes = &bytes[..bytes.len().min(size as usize)];
        if bytes.is_empty() {
            return;
        }
        // SAFETY: recording; stages and range are the layout's own.
        unsafe { self.ctx.device().cmd_push_constants(self.raw, pipeline.layout(), stages, 0, bytes) };
    }

    /// Vertices for a pipeline with a [`super::VertexLayout`], from the buffer's start.
    pub fn bind_vertex_buffer(&mut self, buffer: &Buffer) {
        // SAFETY: recording; the buffer is alive.
        unsafe { self.ctx.device().cmd_bind_vertex_buffers(self.raw, 0, &[buffer.handle()], &[0]) };
    }

    /// Indices for [`Self::draw_indexed`], from the buffer's start.
    pub fn bind_index_buffer(&mut self, buffer: &Buffer, index_type: vk::IndexType) {
        // SAFETY: recording; the buffer is alive.
        unsafe { self.ctx.device().cmd_bind_index_buffer(self.raw, buffer.handle(), 0, index_type) };
    }

    /// Draws without indices.
    pub fn draw(&mut self, vertices: u32, instances: u32, first_vertex: u32, first_instance: u32) {
        // SAFETY: recording, inside a pass; what is bound is checked by the validation layer.
        unsafe { self.ctx.device().cmd_draw(self.raw, vertices, instances, first_vertex, first_instance) };
    }

    /// Draws with the bound index buffer.
    pub fn draw_indexed(&mut self, indices: u32, instances: u32, first_index: u32, offset: i32, first_instance: u32) {
        // SAFETY: recording, inside a pass; what is bound is checked by the validation layer.
        unsafe {
            self.ctx.device().cmd_draw_indexed(self.raw, indices, instances, first_index, offset, first_instance);
        }
    }

    /// Draws with the bound index buffer what the command in `buffer` says.
    pub fn draw_indexed_indirect(&mut self, buffer: &Buffer) {
        // SAFETY: recording, inside a pass; what is bound is checked by the validation layer.
        unsafe { self.ctx.device().cmd_draw_indexed_indirect(self.raw, buffer.handle(), 0, 1, 0) };
    }

    /// Draws without indices what each of the first `commands` commands in `buffer` says, in their order: a call each, as
    /// several in one would take a feature.
    pub fn draw_indirect(&mut self, buffer: &Buffer, commands: u32) {
        for command in 0..commands {
            let offset = u64::from(command) * size_of::<vk::DrawIndirectCommand>() as u64;
            // SAFETY: recording, inside a pass; what is bound is checked by the validation layer.
            unsafe { self.ctx.device().cmd_draw_indirect(self.raw, buffer.handle(), offset, 1, 0) };
        }
    }

    /// Runs x·y·z mesh (or task) workgroups.
    ///
    /// # Panics
    /// Without [`super::Feature::MeshShader`]; a mesh pipeline cannot have been made then.
    pub fn draw_mesh_tasks(&mut self, x: u32, y: u32, z: u32) {
        let mesh = self.ctx.inner().mesh.as_ref().expect("a mesh pipeline exists, so the extension is enabled");
        // SAFETY: recording, inside a pass, with the extension enabled.
        unsafe { mesh.cmd_draw_mesh_tasks(self.raw, x, y, z) };
    }

    /// Runs x·y·z compute workgroups.
    pub fn dispatch(&mut self, x: u32, y: u32, z: u32) {
        // SAFETY: recording, outside a pass; what is bound is checked by the validation layer.
        unsafe { self.ctx.device().cmd_dispatch(self.raw, x, y, z) };
    }

    /// Records `body` under a name that debuggers and validation messages show.
    pub fn region<R>(&mut self, name: &str, body: impl FnOnce(&mut Self) -> R) -> R {
        self.begin_region(name);
        let result = body(self);
        self.end_region();
        result
    }

    fn begin_region(&mut self, name: &str) {
        self.ctx.begins_pass(name);
        let Some(debug) = &self.ctx.inner().debug else { return };
        let name = CString::new(name.replace('\0', "")).expect("no NUL is left");
        // SAFETY: recording; the string lives until the call returns.
        unsafe { debug.cmd_begin_debug_utils_label(self.raw, &vk::DebugUtilsLabelEXT::default().label_name(&name)) };
    }

    fn end_region(&mut self) {
        if let Some(debug) = &self.ctx.inner().debug {
            // SAFETY: recording; every end here follows a begin.
            unsafe { debug.cmd_end_debug_utils_label(self.raw) };
        }
    }
}

fn color_info<'a>(color: &Attachment<'_>) -> vk::RenderingAttachmentInfo<'a> {
    let (load, float32) = match color.load {
        Load::Clear(value) => (vk::AttachmentLoadOp::CLEAR, value),
        Load::Keep => (vk::AttachmentLoadOp::LOAD, [0.0; 4]),
        Load::DontCare => (vk::AttachmentLoadOp::DONT_CARE, [0.0; 4]),
    };
    let info = vk::RenderingAttachmentInfo::default()
        .image_view(color.image.view())
        .image_layout(Access::COLOR_WRITE.layout)
        .load_op(load)
        .store_op(store_op(color.store))
        .clear_value(vk::ClearValue { color: vk::ClearColorValue { float32 } });
    match color.resolve {
        None => info,
        Some(resolve) => info
            .resolve_mode(vk::ResolveModeFlags::AVERAGE)
            .resolve_image_view(resolve.view())
            .resolve_image_layout(Access::COLOR_WRITE.layout),
    }
}

fn store_op(store: bool) -> vk::AttachmentStoreOp {
    if store { vk::AttachmentStoreOp::STORE } else { vk::AttachmentStoreOp::DONT_CARE }
}
