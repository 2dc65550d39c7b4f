//! Graphics, mesh and compute pipelines; layouts come from the shaders.

use std::sync::Arc;

use ash::vk;

use super::{
    device::Context,
    retire::Retired,
    shader::{BindingInfo, Shader, ShaderStage},
};
use crate::error::{Error, Result};

/// The depth test.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DepthState {
    /// Whether fragments are tested.
    pub test: bool,
    /// Whether those that pass are written.
    pub write: bool,
    /// Passes if `fragment compare stored`; `GREATER` for reversed Z.
    pub compare: vk::CompareOp,
}

impl DepthState {
    /// Neither tested nor written.
    pub const OFF: DepthState = DepthState { test: false, write: false, compare: vk::CompareOp::ALWAYS };
    /// Reversed Z: nearer is greater.
    pub const REVERSED: DepthState = DepthState { test: true, write: true, compare: vk::CompareOp::GREATER };
}

/// One buffer of vertices, read by the vertex stage's inputs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VertexLayout<'a> {
    /// Bytes from one vertex to the next.
    pub stride: u32,
    /// Format and offset of each location, from 0.
    pub attributes: &'a [(vk::Format, u32)],
}

/// A graphics pipeline. Without a vertex layout shaders fetch from storage buffers.
#[derive(Clone, Copy)]
pub struct GraphicsDesc<'a> {
    /// Debug name.
    pub name: &'a str,
    /// One shader a stage: vertex with or without both of tessellation, with or without geometry, or mesh with or without
    /// task; then fragment if any.
    pub shaders: &'a [&'a Arc<Shader>],
    /// What [`super::CommandEncoder::bind_vertex_buffer`] binds, if the vertex stage has inputs.
    pub vertices: Option<VertexLayout<'a>>,
    /// Formats of the colour targets by location.
    pub color_formats: &'a [vk::Format],
    /// Format of the depth target.
    pub depth_format: Option<vk::Format>,
    /// Depth test.
    pub depth: DepthState,
    /// Faces that are left out.
    pub cull: vk::CullModeFlags,
    /// The winding of front faces, in Vulkan's y-down window.
    pub front_face: vk::FrontFace,
    /// What vertices make; ignored by mesh pipelines. `PATCH_LIST`, of one vertex a patch, with tessellation.
    pub topology: vk::PrimitiveTopology,
    /// Samples of the targets.
    pub samples: vk::SampleCountFlags,
    /// Fill; others need [`super::Feature::FillModeNonSolid`].
    pub polygon_mode: vk::PolygonMode,
    /// Straight alpha over what is there, else replaced.
    pub blend: bool,
    /// Constant and slope factor of a bias added to each triangle's depth.
    pub depth_bias: Option<[f32; 2]>,
}

impl Default for GraphicsDesc<'_> {
    fn default() -> Self {
        GraphicsDesc {
            name: "pipeline",
            shaders: &[],
            vertices: None,
            color_formats: &[],
            depth_format: None,
            depth: DepthState::OFF,
            cull: vk::CullModeFlags::NONE,
            front_face: vk::FrontFace::COUNTER_CLOCKWISE,
            topology: vk::PrimitiveTopology::TRIANGLE_LIST,
            samples: vk::SampleCountFlags::TYPE_1,
            polygon_mode: vk::PolygonMode::FILL,
            blend: false,
            depth_bias: None,
        }
    }
}

/// A pipeline with its layout. Viewport and scissor are dynamic.
pub struct Pipeline {
    ctx: Context,
    raw: vk::Pipeline,
    layout: vk::PipelineLayout,
    set_layouts: Vec<vk::DescriptorSetLayout>,
    bindings: Vec<BindingInfo>,
    push_stages: vk::ShaderStageFlags,
    push_size: u32,
    push_range: u32,
    bind_point: vk::PipelineBindPoint,
    shaders: Vec<Arc<Shader>>,
    name: String,
    creation: Option<Creation>,
}

/// What making a pipeline took, as the driver tells it. Some compile later, at the first draw.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Creation {
    /// Milliseconds.
    pub ms: f64,
    /// It was in the pipeline cache.
    pub cached: bool,
}

impl Creation {
    fn new(feedback: vk::PipelineCreationFeedback) -> Option<Self> {
        let has = |flag| feedback.flags.contains(flag);
        has(vk::PipelineCreationFeedbackFlags::VALID).then(|| Creation {
            ms: feedback.duration as f64 * 1e-6,
            cached: has(vk::PipelineCreationFeedbackFlags::APPLICATION_PIPELINE_CACHE_HIT),
        })
    }
}

impl Pipeline {
    /// Makes a graphics or mesh pipeline.
    pub fn graphics(ctx: &Context, desc: &GraphicsDesc<'_>) -> Result<Self> {
        let mut pipeline = Self::with_layout(ctx, desc.name, desc.shaders, vk::PipelineBindPoint::GRAPHICS)?;
        let modules = Modules::new(ctx, desc.name, desc.shaders)?;
        let stages = modules.stages();
        let bindings = desc.vertices.map(|layout| {
            let rate = vk::VertexInputRate::VERTEX;
            vk::VertexInputBindingDescription { binding: 0, stride: layout.stride, input_rate: rate }
        });
        let attribute = |(location, &(format, offset)): (u32, &(vk::Format, u32))| {
            vk::VertexInputAttributeDescription { location, binding: 0, format, offset }
        };
        let attributes = desc.vertices.map_or(&[][..], |layout| layout.attributes);
        let attributes: Vec<_> = (0..).zip(attributes).map(attribute).collect();
        let vertex_input = vk::PipelineVertexInputStateCreateInfo::default()
            .vertex_binding_descriptions(bindings.as_slice())
            .vertex_attribute_descriptions(&attributes);
        let assembly = vk::PipelineInputAssemblyStateCreateInfo::default().topology(desc.topology);
        let viewport = vk::PipelineViewportStateCreateInfo::default().viewport_count(1).scissor_count(1);
        let mut raster = vk::PipelineRasterizationStateCreateInfo::default()
            .polygon_mode(desc.polygon_mode)
            .cull_mode(desc.cull)
            .front_face(desc.front_face)
            .line_width(1.0);
        if let Some([constant, slope]) = desc.depth_bias {
            raster = raster.depth_bias_enable(true).depth_bias_constant_factor(constant).depth_bias_slope_factor(slope);
        }
        let multisample = vk::PipelineMultisampleStateCreateInfo::default().rasterization_samples(desc.samples);
        let depth = vk::PipelineDepthStencilStateCreateInfo::default()
            .depth_test_enable(desc.depth.test)
            .depth_write_enable(desc.depth.write)
            .depth_compare_op(desc.depth.compare);
        let targets = vec![blend_state(desc.blend); desc.color_formats.len()];
        let blend = vk::PipelineColorBlendStateCreateInfo::default().attachments(&targets);
        let dynamic = [vk::DynamicState::VIEWPORT, vk::DynamicState::SCISSOR];
        let dynamic = vk::PipelineDynamicStateCreateInfo::default().dynamic_states(&dynamic);
        let mut rendering = vk::PipelineRenderingCreateInfo::default()
            .color_attachment_formats(desc.color_formats)
            .depth_attachment_format(desc.depth_format.unwrap_or_default());
        let mut feedback = vk::PipelineCreationFeedback::default();
        let mut told = vk::PipelineCreationFeedbackCreateInfo::default().pipeline_creation_feedback(&mut feedback);
        let mut info = vk::GraphicsPipelineCreateInfo::default()
            .stages(&stages)
            .viewport_state(&viewport)
            .rasterization_state(&raster)
            .multisample_state(&multisample)
            .depth_stencil_state(&depth)
            .color_blend_state(&blend)
            .dynamic_state(&dynamic)
            .layout(pipeline.layout)
            .push_next(&mut rendering)
            .push_next(&mut told);
        // The vertex stage passes on which patch it is; all else is fetched.
        let tessellation = vk::PipelineTessellationStateCreateInfo::default().patch_control_points(1);
        if desc.shaders.iter().any(|s| s.stage == ShaderStage::TessControl) {
            info = info.tessellation_state(&tessellation);
        }
        if !desc.shaders.iter().any(|s| s.stage == ShaderStage::Mesh) {
            info = info.vertex_input_state(&vertex_input).input_assembly_state(&assembly);
        }
        // SAFETY: everything in the chain lives until the call returns.
        let raw = unsafe { ctx.device().create_graphics_pipelines(ctx.inner().pipeline_cache, &[info], None) };
        pipeline.creation = Creation::new(feedback);
        pipeline.finish(raw)?;
        Ok(pipeline)
    }

    /// Makes a compute pipeline.
    pub fn compute(ctx: &Context, name: &str, shader: &Arc<Shader>) -> Result<Self> {
        let mut pipeline = Self::with_layout(ctx, name, &[shader], vk::PipelineBindPoint::COMPUTE)?;
        let modules = Modules::new(ctx, name, &[shader])?;
        let info = vk::ComputePipelineCreateInfo::default().stage(modules.stages()[0]).layout(pipeline.layout);
        // SAFETY: everything in the chain lives until the call returns.
        let raw = unsafe { ctx.device().create_compute_pipelines(ctx.inner().pipeline_cache, &[info], None) };
        pipeline.finish(raw)?;
        Ok(pipeline)
    }

    /// Everything but the pipeline itself.
    fn with_layout(
        ctx: &Context,
        name: &str,
        shaders: &[&Arc<Shader>],
        bind_point: vk::PipelineBindPoint,
    ) -> Result<Self> {
        let doing = || format!("creating pipeline '{name}'");
        if let Some(shader) = shaders.iter().find(|s| s.stage != s.reflection.stage) {
            let cause = format!("{} was asked for as {}, is {}", shader.path, shader.stage, shader.reflection.stage);
            return Err(Error::gpu(doing(), cause));
        }
        let bindings = merge(shaders).map_err(|cause| Error::gpu(doing(), cause))?;
        let pushing = || shaders.iter().filter(|s| s.reflection.push_constant_size > 0);
        let push_stages = pushing().fold(vk::ShaderStageFlags::empty(), |all, s| all | s.stage.flag());
        let push_size = pushing().map(|s| s.reflection.push_constant_size).max().unwrap_or_default();
        // Up to the alignment of the largest GLSL type, so that a padded Rust struct fits.
        let push_range = push_size.next_multiple_of(16).min(ctx.limits().max_push_constants_size);
        let mut pipeline = Pipeline {
            ctx: ctx.clone(),
            raw: vk::Pipeline::null(),
            layout: vk::PipelineLayout::null(),
            set_layouts: Vec::new(),
            bindings,
            push_stages,
            push_size,
            push_range,
            bind_point,
            shaders: shaders.iter().map(|s| (*s).clone()).collect(),
            name: name.to_owned(),
            creation: None,
        };
        let stages = shaders.iter().fold(vk::ShaderStageFlags::empty(), |all, s| all | s.stage.flag());
        pipeline.make_layout(stages).map_err(|e| Error::gpu(doing(), e))?;
        Ok(pipeline)
    }

    fn make_layout(&mut self, stages: vk::ShaderStageFlags) -> std::result::Result<(), vk::Result> {
        let device = self.ctx.device();
        let sets = self.bindings.iter().map(|b| b.set + 1).max().unwrap_or_default();
        for set in 0..sets {
            // All stages of the pipeline see all bindings: which of them do is of no use to a driver.
            let bindings: Vec<_> = self
                .bindings
                .iter()
                .filter(|b| b.set == set)
                .map(|b| {
                    vk::DescriptorSetLayoutBinding::default()
                        .binding(b.binding)
                        .descriptor_type(b.ty)
                        .descriptor_count(b.count)
                        .stage_flags(stages)
                })
                .collect();
            let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
            // SAFETY: the info is complete.
            let layout = unsafe { device.create_descriptor_set_layout(&info, None) }?;
            self.ctx.set_name(layout, &format!("{}: set {set}", self.name));
            self.set_layouts.push(layout);
        }
        let ranges = [vk::PushConstantRange { stage_flags: self.push_stages, offset: 0, size: self.push_range }];
        let mut info = vk::PipelineLayoutCreateInfo::default().set_layouts(&self.set_layouts);
        if self.push_range > 0 {
            info = info.push_constant_ranges(&ranges);
        }
        // SAFETY: the set layouts are alive.
        self.layout = unsafe { device.create_pipeline_layout(&info, None) }?;
        self.ctx.set_name(self.layout, &self.name);
        Ok(())
    }

    fn finish(&mut self, made: std::result::Result<Vec<vk::Pipeline>, (Vec<vk::Pipeline>, vk::Result)>) -> Result<()> {
        let made = made.map_err(|(_, e)| {
            let shaders: Vec<_> = self.shaders.iter().map(|s| s.label()).collect();
            Error::gpu(format!("creating pipeline '{}' of {}", self.name, shaders.join(", ")), e)
        })?;
        self.raw = made[0];
        self.ctx.set_name(self.raw, &self.name);
        Ok(())
    }

    /// The Vulkan handle.
    pub fn handle(&self) -> vk::Pipeline {
        self.raw
    }

    /// Its layout.
    pub fn layout(&self) -> vk::PipelineLayout {
        self.layout
    }

    /// The layouts of its sets, by index; a set that no shader uses has an empty one.
    pub fn set_layouts(&self) -> &[vk::DescriptorSetLayout] {
        &self.set_layouts
    }

    /// Every descriptor that a stage uses, by set and binding.
    pub fn bindings(&self) -> &[BindingInfo] {
        &self.bindings
    }

    /// The execution models of its stages, read from the SPIR-V that was handed to the driver.
    pub fn execution_models(&self) -> Vec<ShaderStage> {
        self.shaders.iter().map(|s| s.reflection.stage).collect()
    }

    /// Its shaders, in the order given.
    pub fn shaders(&self) -> &[Arc<Shader>] {
        &self.shaders
    }

    /// Debug name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// What making it took; none where the driver does not tell, and of compute pipelines.
    pub fn creation(&self) -> Option<Creation> {
        self.creation
    }

    /// Bytes of push constants that the shaders read.
    pub fn push_constant_size(&self) -> u32 {
        self.push_size
    }

    /// Stages and size of the layout's push constant range.
    pub(super) fn push_range(&self) -> (vk::ShaderStageFlags, u32) {
        (self.push_stages, self.push_range)
    }

    /// Graphics or compute.
    pub fn bind_point(&self) -> vk::PipelineBindPoint {
        self.bind_point
    }
}

impl Drop for Pipeline {
    fn drop(&mut self) {
        let sets = std::mem::take(&mut self.set_layouts);
        self.ctx.retire(Retired::Pipeline(self.raw, self.layout, sets));
    }
}

/// The descriptors of all stages. Two stages must agree on what stands at a place.
fn merge(shaders: &[&Arc<Shader>]) -> std::result::Result<Vec<BindingInfo>, String> {
    let mut merged: Vec<BindingInfo> = Vec::new();
    for shader in shaders {
        for new in &shader.reflection.bindings {
            match merged.iter().find(|b| (b.set, b.binding) == (new.set, new.binding)) {
                None => merged.push(new.clone()),
                Some(old) if (&old.name, old.ty, old.count) == (&new.name, new.ty, new.count) => {}
                Some(old) => {
                    return Err(format!(
                        "descriptor {}.{} is '{}' ({:?}) in one stage and '{}' ({:?}) in {}",
                        new.set, new.binding, old.name, old.ty, new.name, new.ty, shader.path
                    ));
                }
            }
        }
    }
    merged.sort_by_key(|b| (b.set, b.binding));
    Ok(merged)
}

fn blend_state(blend: bool) -> vk::PipelineColorBlendAttachmentState {
    vk::PipelineColorBlendAttachmentState::default()
        .blend_enable(blend)
        .src_color_blend_factor(vk::BlendFactor::SRC_ALPHA)
        .dst_color_blend_factor(vk::BlendFactor::ONE_MINUS_SRC_ALPHA)
        .src_alpha_blend_factor(vk::BlendFactor::ONE)
        .dst_alpha_blend_factor(vk::BlendFactor::ONE_MINUS_SRC_ALPHA)
        .color_write_mask(vk::ColorComponentFlags::RGBA)
}

/// Shader modules, needed only while a pipeline is made.
struct Modules<'a> {
    ctx: &'a Context,
    list: Vec<(ShaderStage, vk::ShaderModule)>,
}

impl<'a> Modules<'a> {
    fn new(ctx: &'a Context, name: &str, shaders: &[&Arc<Shader>]) -> Result<Self> {
        let mut modules = Modules { ctx, list: Vec::new() };
        for shader in shaders {
            let fail = |e: vk::Result| Error::gpu(format!("creating pipeline '{name}': module {}", shader.label()), e);
            let info = vk::ShaderModuleCreateInfo::default().code(&shader.spirv);
            // SAFETY: the code is SPIR-V from the compiler, or from the cache with a right checksum.
            let module = unsafe { ctx.device().create_shader_module(&info, None) }.map_err(fail)?;
            ctx.set_name(module, &shader.label());
            modules.list.push((shader.stage, module));
        }
        Ok(modules)
    }

    fn stages(&self) -> Vec<vk::PipelineShaderStageCreateInfo<'static>> {
        let stage = |&(stage, module): &(ShaderStage, vk::ShaderModule)| {
            vk::PipelineShaderStageCreateInfo::default().stage(stage.flag()).module(module).name(c"main")
        };
        self.list.iter().map(stage).collect()
    }
}

impl Drop for Modules<'_> {
    fn drop(&mut self) {
        for (_, module) in &self.list {
            // SAFETY: a pipeline does not need its modules after it is made.
            unsafe { self.ctx.device().destroy_shader_module(*module, None) };
        }
    }
}
