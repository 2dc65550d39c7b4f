//! The samples of a pixel become one colour.
//!
//! By a pass of our own, not by a resolve attachment: lavapipe (Mesa 25.0) makes its resolves with a draw, and with a
//! mesh pipeline bound that draw reads one texel for all.

use crate::error::Result;
use crate::gpu::{
    Access, Attachment, Binding, CommandEncoder, Context, DescriptorSet, GraphicsDesc, Image, ImageDesc, Load,
    Pipeline, RenderingDesc, Sampler, SamplerDesc, ShaderCompiler, ShaderStage, vk,
};

/// The pipeline.
pub struct Resolve {
    pipeline: Pipeline,
    sampler: Sampler,
}

impl Resolve {
    /// To a target of this format.
    pub fn new(ctx: &Context, compiler: &ShaderCompiler, format: vk::Format) -> Result<Self> {
        let vertex = compiler.compile("render/resolve.vert", ShaderStage::Vertex, &[])?;
        let fragment = compiler.compile("render/resolve.frag", ShaderStage::Fragment, &[])?;
        let pipeline = Pipeline::graphics(
            ctx,
            &GraphicsDesc {
                name: "resolve",
                shaders: &[&vertex, &fragment],
                color_formats: &[format],
                ..GraphicsDesc::default()
            },
        )?;
        Ok(Resolve { pipeline, sampler: Sampler::new(ctx, &SamplerDesc::default())? })
    }

    /// What is drawn to before. samples: a pixel.
    pub fn target(
        &self,
        ctx: &Context,
        extent: [u32; 2],
        format: vk::Format,
        samples: vk::SampleCountFlags,
    ) -> Result<Samples> {
        let usage = vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::SAMPLED;
        let image = Image::new(ctx, &ImageDesc { name: "samples", extent, format, mips: 1, samples, usage })?;
        let bindings = [("samples", Binding::Image(&image, &self.sampler))];
        let set = DescriptorSet::new(ctx, &self.pipeline, 0, &bindings)?;
        Ok(Samples { image, set })
    }

    /// `samples`, drawn to before, into `target`, both in the layout of [`Access::COLOR_WRITE`] before.
    pub fn record(&self, cmd: &mut CommandEncoder, samples: &Samples, target: &Image) {
        cmd.image_barrier(&samples.image, Access::COLOR_WRITE, Access::FRAGMENT_READ);
        let color = [Attachment { image: target, load: Load::DontCare, store: true, resolve: None }];
        let extent = target.extent();
        cmd.begin_rendering(&RenderingDesc { name: "resolve", color: &color, depth: None, extent });
        cmd.bind_pipeline(&self.pipeline);
        cmd.bind_set(&self.pipeline, 0, &samples.set);
        cmd.draw(3, 1, 0, 0);
        cmd.end_rendering();
    }
}

/// An image of several samples a pixel.
pub struct Samples {
    /// Drawn to.
    pub image: Image,
    set: DescriptorSet,
}
