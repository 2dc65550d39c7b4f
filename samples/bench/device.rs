//! One device, one view: draws a variant once to be measured, or many times to be timed.

use std::collections::HashMap;

use prism_engine::{
    aov::Aov,
    error::{Error, Result},
    gpu::{Context, ContextDesc, Feature, Frames, PassTimers, ShaderCompiler},
    render::{self, Output, Renderer},
    scene::{Camera, Scene},
    settings::{Dicer, Settings},
};

use crate::app::{cli::BenchArgs, offscreen, offscreen::Offscreen};

/// More passes than any variant has.
const MAX_PASSES: usize = 4;

/// The device and what all variants share.
pub struct Device {
    frames: Frames,
    timers: PassTimers,
    target: Offscreen,
    compiler: ShaderCompiler,
    /// Last, so that it outlives what was made from it.
    pub ctx: Context,
}

impl Device {
    /// The device that the flags name.
    pub fn new(args: &BenchArgs) -> Result<Device> {
        let desc = ContextDesc {
            app: "prism bench",
            validation: args.device.validation,
            selector: args.device.gpu.as_deref(),
            optional: &[Feature::MeshShader, Feature::TaskShader, Feature::GeometryShader, Feature::TessellationShader],
            ..ContextDesc::default()
        };
        let ctx = Context::new(&desc)?;
        let size = args.pixels();
        Ok(Device {
            frames: Frames::new(&ctx, 1)?,
            timers: PassTimers::new(&ctx, MAX_PASSES, 1)?,
            target: Offscreen::new(&ctx, size, offscreen::FORMAT)?,
            compiler: render::shader_compiler(args.device.shader_dir.as_deref())?,
            ctx,
        })
    }

    /// The stages that can dice here.
    pub fn dicers(&self) -> Vec<Dicer> {
        let has = |by: &Dicer| render::dicer_features(*by).iter().all(|feature| self.ctx.has(*feature));
        Dicer::ALL.iter().copied().filter(has).collect()
    }

    /// A renderer for timing: it writes the picture and nothing else.
    pub fn renderer(&self, scene: &Scene, settings: &Settings) -> Result<Renderer> {
        let output = Output { color_format: offscreen::FORMAT, aov: false };
        Renderer::new(&self.ctx, &self.compiler, scene, settings, output)
    }

    /// Draws one frame, timed or not, and returns its slot.
    fn draw(&mut self, renderer: &mut Renderer, camera: &Camera, timed: bool) -> Result<usize> {
        let mut frame = self.frames.begin()?;
        let slot = frame.slot();
        self.target.prepare(&mut frame.cmd);
        let timers = timed.then_some(&mut self.timers);
        renderer.record(&mut frame.cmd, slot, camera, self.target.image(), timers)?;
        self.frames.submit_and_wait(frame)?;
        Ok(slot)
    }

    /// One frame's GPU time, milliseconds.
    pub fn time(&mut self, renderer: &mut Renderer, camera: &Camera) -> Result<f64> {
        let slot = self.draw(renderer, camera, true)?;
        self.timers.resolve(slot).into_iter().map(|pass| pass.gpu_ms).sum::<Option<f64>>().ok_or_else(|| {
            let what = format!("'{}' has no timestamps", self.ctx.device_name());
            Error::unsupported(what, "choose another device with --gpu")
        })
    }

    /// One frame's surface data.
    pub fn surface(&mut self, scene: &Scene, settings: &Settings, camera: &Camera) -> Result<Aov> {
        let mut renderer = self.measuring(scene, settings)?;
        self.draw(&mut renderer, camera, false)?;
        renderer.read_aov()
    }

    /// A renderer for surface data.
    pub fn measuring(&self, scene: &Scene, settings: &Settings) -> Result<Renderer> {
        let output = Output { color_format: offscreen::FORMAT, aov: true };
        Renderer::new(&self.ctx, &self.compiler, scene, settings, output)
    }

    /// Surface data of one frame under other settings.
    pub fn surface_with(&mut self, renderer: &mut Renderer, settings: &Settings, camera: &Camera) -> Result<Aov> {
        renderer.set_settings(&self.compiler, settings)?;
        self.draw(renderer, camera, false)?;
        renderer.read_aov()
    }

    /// Bytes by name of everything on the device.
    pub fn memory(&self) -> HashMap<String, u64> {
        // What was dropped is destroyed when a recording ends.
        drop(self.ctx.ticket());
        let mut memory = HashMap::new();
        for (name, bytes) in self.ctx.memory_report() {
            *memory.entry(name).or_default() += bytes;
        }
        memory
    }
}
