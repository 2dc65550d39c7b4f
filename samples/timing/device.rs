//! One device: draws a scene once to be measured, or many times to be timed.

use std::collections::HashMap;

use prism_engine::{
    aov::Aov,
    error::{Error, Result},
    gpu::{Context, ContextDesc, Feature, Frames, PassTimers, ShaderCompiler},
    render::{self, Output, Pipelines, Renderer},
    scene::{Camera, Scene},
    settings::{Dicer, Settings},
};

use crate::app::{cli::DeviceArgs, offscreen, offscreen::Offscreen, picture::Picture};

/// More passes than any way to draw has.
const MAX_PASSES: usize = 8;

/// A baseline's memory on the CPU, as a table names it.
pub const CULLS_BY: &str = "on the CPU, to cull by";

/// From where, and how large.
#[derive(Clone, Copy, Debug)]
pub struct View {
    /// The camera.
    pub camera: Camera,
    /// Of the picture, in pixels.
    pub size: [u32; 2],
}

/// A frame that is measured.
#[derive(Clone)]
pub struct Drawn {
    /// As a viewer sees it.
    pub picture: Picture,
    /// What it shows.
    pub surface: Aov,
    /// Reads of height maps, where they are counted.
    pub height_reads: Option<u32>,
}

/// What a frame took.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cost {
    /// Between its timestamps, milliseconds.
    pub ms: f64,
    /// Fragment shader invocations, where the device counts them.
    pub fragments: Option<u64>,
}

/// The device and what all variants share.
pub struct Device {
    frames: Frames,
    timers: PassTimers,
    /// By size.
    targets: HashMap<[u32; 2], Offscreen>,
    compiler: ShaderCompiler,
    /// lavapipe takes seconds for one of a walk.
    pipelines: Pipelines,
    /// Last, so that it outlives what was made from it.
    pub ctx: Context,
}

impl Device {
    /// The device that the flags name, for a command. `statistics`: count what the stages do, too.
    pub fn new(app: &'static str, args: &DeviceArgs, statistics: bool) -> Result<Device> {
        let mut optional = vec![
            Feature::MeshShader,
            Feature::TaskShader,
            Feature::GeometryShader,
            Feature::TessellationShader,
            Feature::SampleRateShading,
        ];
        if statistics {
            optional.extend([Feature::PipelineStatistics, Feature::FragmentStoresAndAtomics]);
        }
        let desc = ContextDesc {
            app,
            validation: args.validation,
            selector: args.gpu.as_deref(),
            optional: &optional,
            ..ContextDesc::default()
        };
        let ctx = Context::new(&desc)?;
        Ok(Device {
            frames: Frames::new(&ctx, 1)?,
            timers: PassTimers::new(&ctx, MAX_PASSES, 1)?,
            targets: HashMap::new(),
            compiler: render::shader_compiler(args.shader_dir.as_deref())?,
            pipelines: Pipelines::default(),
            ctx,
        })
    }

    /// The stages that can dice here.
    pub fn dicers(&self) -> Vec<Dicer> {
        let has = |by: &Dicer| render::dicer_features(*by).iter().all(|feature| self.ctx.has(*feature));
        Dicer::ALL.iter().copied().filter(has).collect()
    }

    /// A renderer for timing: it writes the picture and nothing else.
    pub fn renderer(&mut self, scene: &Scene, settings: &Settings) -> Result<Renderer> {
        self.renderer_of(scene, settings, false)
    }

    fn renderer_of(&mut self, scene: &Scene, settings: &Settings, aov: bool) -> Result<Renderer> {
        let output = Output { color_format: offscreen::FORMAT, aov };
        Renderer::sharing(&self.ctx, &self.compiler, scene, settings, output, &mut self.pipelines)
    }

    /// Draws one frame, timed or not, and returns its slot.
    fn draw(&mut self, renderer: &mut Renderer, view: &View, timed: bool) -> Result<usize> {
        if !self.targets.contains_key(&view.size) {
            self.targets.insert(view.size, Offscreen::new(&self.ctx, view.size, offscreen::FORMAT)?);
        }
        let target = &self.targets[&view.size];
        let mut frame = self.frames.begin()?;
        let slot = frame.slot();
        target.prepare(&mut frame.cmd);
        let timers = timed.then_some(&mut self.timers);
        renderer.record(&mut frame.cmd, slot, &view.camera, target.image(), timers)?;
        self.frames.submit_and_wait(frame)?;
        Ok(slot)
    }

    /// One frame's cost.
    pub fn time(&mut self, renderer: &mut Renderer, view: &View) -> Result<Cost> {
        let slot = self.draw(renderer, view, true)?;
        let passes = self.timers.resolve(slot);
        let ms = passes.iter().map(|pass| pass.gpu_ms).sum::<Option<f64>>().ok_or_else(|| {
            let what = format!("'{}' has no timestamps", self.ctx.device_name());
            Error::unsupported(what, "choose another device with --gpu")
        })?;
        Ok(Cost { ms, fragments: passes.iter().map(|pass| Some(pass.statistics?.fragment_invocations)).sum() })
    }

    /// One frame and its surface data.
    pub fn shot(&mut self, scene: &Scene, settings: &Settings, view: &View) -> Result<Drawn> {
        let mut renderer = self.measuring(scene, settings)?;
        self.shot_by(&mut renderer, view)
    }

    /// The same by a renderer for surface data.
    pub fn shot_by(&mut self, renderer: &mut Renderer, view: &View) -> Result<Drawn> {
        let slot = self.draw(renderer, view, false)?;
        Ok(Drawn {
            picture: self.targets[&view.size].read()?,
            surface: renderer.read_aov()?,
            height_reads: renderer.height_reads(slot)?,
        })
    }

    /// One frame's surface data.
    pub fn surface(&mut self, scene: &Scene, settings: &Settings, view: &View) -> Result<Aov> {
        let mut renderer = self.measuring(scene, settings)?;
        self.draw(&mut renderer, view, false)?;
        renderer.read_aov()
    }

    /// A renderer for surface data.
    pub fn measuring(&mut self, scene: &Scene, settings: &Settings) -> Result<Renderer> {
        self.renderer_of(scene, settings, true)
    }

    /// Surface data of one frame under other settings.
    pub fn surface_with(&mut self, renderer: &mut Renderer, settings: &Settings, view: &View) -> Result<Aov> {
        renderer.set_settings(&self.compiler, settings)?;
        self.draw(renderer, view, false)?;
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

    /// MiB by name of what a scene's settings have on the device, and of what the baseline culls by; the largest first.
    pub fn footprint(
        &mut self,
        scene: &Scene,
        settings: &Settings,
        counts: impl Fn(&str) -> bool,
    ) -> Result<Vec<(String, f64)>> {
        let before = self.memory();
        let renderer = self.renderer(scene, settings)?;
        let mut after: HashMap<String, u64> = self.memory();
        after.insert(CULLS_BY.to_owned(), renderer.baseline_host_bytes());
        let mut bytes: Vec<_> =
            grown(&before, &after).filter(|(name, _)| counts(name)).map(|(name, bytes)| (bytes, name)).collect();
        bytes.sort_by(|a, b| b.cmp(a));
        Ok(bytes.into_iter().map(|(bytes, name)| (name.to_owned(), mib(bytes))).collect())
    }
}

/// What came to be between two reports of [`Device::memory`]: names, and bytes more than before.
pub fn grown<'a>(
    before: &'a HashMap<String, u64>,
    after: &'a HashMap<String, u64>,
) -> impl Iterator<Item = (&'a str, u64)> {
    let more = |(name, bytes): (&'a String, &u64)| {
        (name.as_str(), bytes.saturating_sub(before.get(name).copied().unwrap_or(0)))
    };
    after.iter().map(more).filter(|(_, bytes)| *bytes > 0)
}

/// MiB of bytes.
pub fn mib(bytes: u64) -> f64 {
    bytes as f64 / f64::from(1 << 20)
}
