//! A job's scene on a device, ready to be drawn at any time of its sample: what window and headless run share.

use prism_engine::{
    error::Result,
    gpu::{CommandEncoder, Context, ContextDesc, Feature, Image, PassTime, PassTimers, ShaderCompiler},
    render::{self, Features, Output, Renderer},
    scene::Scene,
};

use super::{
    console,
    job::Job,
    sample::{Moment, Pose},
    stats,
    timings::{self, FrameRow, PassRow},
};

/// More passes than any frame of this build has.
const MAX_PASSES: usize = 16;

/// The renderer, the sample's motion, and what was measured.
pub struct Drawing<'a> {
    job: &'a Job<'a>,
    scene: Scene,
    start: Pose,
    renderer: Renderer,
    compiler: ShaderCompiler,
    timers: Option<PassTimers>,
    /// Number and time of the frame that was last recorded in each slot.
    pending: Vec<Option<(u64, f64)>>,
    rows: Vec<FrameRow>,
    /// Loops that reached their limit in the measured frames, where they are counted.
    limits: Option<u64>,
    /// Last, so that it outlives what was made from it.
    ctx: Context,
}

/// The features that the job needs. `interactive`: keys may change the settings.
pub fn features(job: &Job<'_>, scene: &Scene, interactive: bool) -> Features {
    let mut features = render::features(scene, &job.settings, interactive);
    if measures(job) {
        features.optional.push(Feature::PipelineStatistics);
    }
    features
}

/// What the job asks of a device.
pub fn context_desc<'a>(job: &'a Job<'_>, features: &'a Features) -> ContextDesc<'a> {
    ContextDesc {
        app: job.sample.id(),
        validation: job.common.session.validation,
        selector: job.common.session.gpu.as_deref(),
        required: &features.required,
        optional: &features.optional,
        ..ContextDesc::default()
    }
}

/// Whether passes are timed at all: queries are created only for whoever reads them.
fn measures(job: &Job<'_>) -> bool {
    job.common.session.stats || job.common.session.csv.is_some()
}

impl<'a> Drawing<'a> {
    /// Puts the scene on the device.
    pub fn new(
        job: &'a Job<'a>,
        scene: Scene,
        start: Pose,
        ctx: &Context,
        output: Output,
        in_flight: usize,
    ) -> Result<Drawing<'a>> {
        let compiler = render::shader_compiler(job.common.session.shader_dir.as_deref())?;
        let renderer = Renderer::new(ctx, &compiler, &scene, &job.settings, output)?;
        let timers = measures(job).then(|| PassTimers::new(ctx, MAX_PASSES, in_flight)).transpose()?;
        let drawing = Drawing {
            job,
            scene,
            start,
            renderer,
            compiler,
            timers,
            pending: vec![None; in_flight],
            rows: Vec::new(),
            limits: None,
            ctx: ctx.clone(),
        };
        drawing.tell_notices();
        Ok(drawing)
    }

    /// The sample's picture at `time`.
    pub fn moment(&self, time: f64) -> Moment {
        self.job.sample.at(&self.scene, &self.start, time)
    }

    /// The renderer.
    pub fn renderer(&self) -> &Renderer {
        &self.renderer
    }

    /// Draws with other settings from the next frame on; on failure the old ones stay in force.
    #[cfg(feature = "window")]
    pub fn set_settings(&mut self, settings: &prism_engine::settings::Settings) -> Result<()> {
        self.renderer.set_settings(&self.compiler, settings)?;
        self.tell_notices();
        Ok(())
    }

    /// Records a frame in a slot whose last frame has run. With a number and a time it is measured as that frame.
    pub fn record(
        &mut self,
        cmd: &mut CommandEncoder,
        slot: usize,
        measured: Option<(u64, f64)>,
        moment: &Moment,
        target: &Image,
    ) -> Result<()> {
        self.collect(slot)?;
        for &(instance, transform) in &moment.transforms {
            self.renderer.set_instance_transform(instance, transform);
        }
        self.pending[slot] = measured;
        let timers = self.timers.as_mut().filter(|_| measured.is_some());
        self.renderer.record(cmd, slot, &moment.pose.camera, target, timers)
    }

    /// Keeps the measurements of the slot's last frame, which has run.
    fn collect(&mut self, slot: usize) -> Result<()> {
        if let (Some(timers), Some((frame, time))) = (&mut self.timers, self.pending[slot].take()) {
            let passes = timers.resolve(slot).into_iter().map(row).collect();
            self.rows.push(FrameRow { frame, time, passes });
            if let Some(reached) = self.renderer.limits_reached(slot)? {
                *self.limits.get_or_insert(0) += u64::from(reached);
            }
        }
        Ok(())
    }

    /// Writes and prints what was measured. All frames have run.
    pub fn finish(&mut self) -> Result<()> {
        for slot in 0..self.pending.len() {
            self.collect(slot)?;
        }
        // Slots take turns, so the last frames may come in the other order.
        self.rows.sort_by_key(|row| row.frame);
        let session = &self.job.common.session;
        if let Some(path) = &session.csv {
            timings::write_csv(path, &self.rows)?;
            console::notice(format_args!("wrote {}", path.display()));
        }
        if session.stats {
            console::data(&stats::report(&self.ctx, &self.compiler, &self.renderer, &self.rows, self.limits))?;
        }
        Ok(())
    }

    fn tell_notices(&self) {
        for notice in &self.renderer.plan().notices {
            console::notice(notice);
        }
    }
}

fn row(pass: PassTime) -> PassRow {
    let counts = pass.statistics;
    // Fragments come from primitives: a driver that reports none (lavapipe, for mesh stages) does not count them.
    let counted = counts.filter(|counts| counts.clipping_invocations > 0 || counts.fragment_invocations == 0);
    PassRow {
        pass: pass.name,
        gpu_ms: pass.gpu_ms,
        invocations: counts.map(|counts| counts.fragment_invocations),
        primitives: counted.map(|counts| counts.clipping_invocations),
    }
}
