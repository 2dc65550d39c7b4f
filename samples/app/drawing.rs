//! A job's scene on a device, ready to be drawn at any time of its sample: what window and headless run share.

use std::rc::Rc;

use prism_engine::{
    error::{Error, Result},
    gpu::{CommandEncoder, Context, ContextDesc, Feature, Image, PassTime, PassTimers, ShaderCompiler},
    render::{
        self, Features, Output, Renderer,
        culling::Counts,
        deform::{Pose, Vectors},
    },
};

#[cfg(feature = "window")]
use prism_engine::render::reload::Rebuilt;

use super::{
    console,
    job::Job,
    load::Loaded,
    sample::Moment,
    stats,
    timings::{self, FrameRow, PassRow},
};

/// More passes than any frame of this build has.
const MAX_PASSES: usize = 16;

/// The renderer, the sample's motion, and what was measured.
pub struct Drawing<'a> {
    job: Rc<Job<'a>>,
    scenes: Vec<Loaded>,
    /// The one that is drawn.
    current: usize,
    output: Output,
    renderer: Renderer,
    compiler: ShaderCompiler,
    timers: Option<PassTimers>,
    /// Number and time of the frame that was last recorded in each slot.
    pending: Vec<Option<(u64, f64)>>,
    rows: Vec<FrameRow>,
    /// The last measured frame.
    #[cfg(feature = "window")]
    latest: Option<FrameRow>,
    /// Loops that reached their limit in the measured frames, where they are counted.
    limits: Option<u64>,
    /// Prisms of the last measured frame, where unseen ones are dropped.
    culled: Option<Counts>,
    /// Last, so that it outlives what was made from it.
    ctx: Context,
}

/// The features that the job needs for any of its scenes. `interactive`: keys may change the settings.
pub fn features(job: &Job<'_>, scenes: &[Loaded], interactive: bool) -> Features {
    let mut features = Features::default();
    let mut wanted = job.sample.exhibit().map_or_else(Vec::new, |exhibit| exhibit.variants(&job.settings));
    wanted.push(job.settings.clone());
    for (loaded, settings) in scenes.iter().flat_map(|loaded| wanted.iter().map(move |settings| (loaded, settings))) {
        let needed = render::features(&loaded.scene, settings, interactive);
        for (list, more) in [
            (&mut features.required, needed.required),
            (&mut features.optional, needed.optional),
            (&mut features.alternatives, needed.alternatives),
        ] {
            for feature in more {
                if !list.contains(&feature) {
                    list.push(feature);
                }
            }
        }
    }
    if measures(job) || interactive {
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
        alternatives: &features.alternatives,
        ..ContextDesc::default()
    }
}

/// Whether passes are timed at all: queries are created only for whoever reads them.
fn measures(job: &Job<'_>) -> bool {
    job.common.session.stats || job.common.session.csv.is_some()
}

impl<'a> Drawing<'a> {
    /// Puts the first scene on the device.
    pub fn new(
        job: Rc<Job<'a>>,
        scenes: Vec<Loaded>,
        ctx: &Context,
        output: Output,
        in_flight: usize,
    ) -> Result<Drawing<'a>> {
        let compiler = render::shader_compiler(job.common.session.shader_dir.as_deref())?;
        let renderer = Renderer::new(ctx, &compiler, &scenes[0].scene, &job.settings, output)?;
        let timers = measures(&job).then(|| PassTimers::new(ctx, MAX_PASSES, in_flight)).transpose()?;
        let drawing = Drawing {
            job,
            scenes,
            current: 0,
            output,
            renderer,
            compiler,
            timers,
            pending: vec![None; in_flight],
            rows: Vec::new(),
            #[cfg(feature = "window")]
            latest: None,
            limits: None,
            culled: None,
            ctx: ctx.clone(),
        };
        drawing.tell_notices();
        Ok(drawing)
    }

    /// A second drawing of the same, with the settings in force, to be compared with it; always measured.
    #[cfg(feature = "window")]
    pub fn beside(&self) -> Result<Drawing<'a>> {
        let compiler = render::shader_compiler(self.job.common.session.shader_dir.as_deref())?;
        let output = Output { aov: false, ..self.output };
        let scene = &self.loaded().scene;
        let renderer = Renderer::new(&self.ctx, &compiler, scene, self.renderer.settings(), output)?;
        let in_flight = self.pending.len();
        Ok(Drawing {
            job: self.job.clone(),
            scenes: self.scenes.clone(),
            current: self.current,
            output,
            renderer,
            compiler,
            timers: Some(PassTimers::new(&self.ctx, MAX_PASSES, in_flight)?),
            pending: vec![None; in_flight],
            rows: Vec::new(),
            latest: None,
            limits: None,
            culled: None,
            ctx: self.ctx.clone(),
        })
    }

    /// The sample's picture at `time`.
    pub fn moment(&self, time: f64) -> Moment {
        let loaded = self.loaded();
        self.job.sample.at(&loaded.scene, &loaded.start, time)
    }

    /// Draws the next scene, or the one before, as [`Self::walk_to`] does.
    #[cfg(feature = "window")]
    pub fn walk_on(&mut self, back: bool) -> Result<()> {
        self.walk_to((self.current + if back { self.scenes.len() - 1 } else { 1 }) as u64)
    }

    /// How many scenes there are.
    #[cfg(feature = "window")]
    pub fn scenes(&self) -> usize {
        self.scenes.len()
    }

    /// What the scenes are called, and which one is drawn.
    #[cfg(feature = "window")]
    pub fn names(&self) -> (Vec<&str>, usize) {
        (self.scenes.iter().map(|loaded| loaded.name.as_str()).collect(), self.current)
    }

    /// The run through the scene starts here from now on.
    #[cfg(feature = "window")]
    pub fn start_at(&mut self, start: super::sample::Pose) {
        self.scenes[self.current].start = start;
    }

    /// The scene that is drawn.
    pub fn loaded(&self) -> &Loaded {
        &self.scenes[self.current]
    }

    /// Draws another scene of the walk from now on, counted from its beginning and around; with the settings in force.
    /// All frames so far have run.
    pub fn walk_to(&mut self, index: u64) -> Result<()> {
        let next = (index % self.scenes.len() as u64) as usize;
        if next == self.current {
            return Ok(());
        }
        for slot in 0..self.pending.len() {
            self.collect(slot)?;
        }
        let settings = self.renderer.settings().clone();
        self.renderer = Renderer::new(&self.ctx, &self.compiler, &self.scenes[next].scene, &settings, self.output)?;
        self.current = next;
        self.tell_notices();
        Ok(())
    }

    /// Draws the same scene of another set, read again; with the settings in force. All frames so far have run.
    #[cfg(feature = "window")]
    pub fn replace(&mut self, scenes: Vec<Loaded>) -> Result<()> {
        for slot in 0..self.pending.len() {
            self.collect(slot)?;
        }
        let settings = self.renderer.settings().clone();
        let renderer = Renderer::new(&self.ctx, &self.compiler, &scenes[self.current].scene, &settings, self.output)?;
        (self.renderer, self.scenes) = (renderer, scenes);
        self.tell_notices();
        Ok(())
    }

    /// Keeps surface data from now on, or no more. All frames so far have run.
    #[cfg(feature = "window")]
    pub fn keep_aov(&mut self, on: bool) -> Result<()> {
        if on == self.output.aov {
            return Ok(());
        }
        for slot in 0..self.pending.len() {
            self.collect(slot)?;
        }
        let output = Output { aov: on, ..self.output };
        let settings = self.renderer.settings().clone();
        self.renderer = Renderer::new(&self.ctx, &self.compiler, &self.loaded().scene, &settings, output)?;
        self.output = output;
        Ok(())
    }

    /// Measures frames from now on, or no more, unless the job asks for it anyway. All frames so far have run.
    #[cfg(feature = "window")]
    pub fn measure(&mut self, on: bool) -> Result<()> {
        if on != self.timers.is_some() && !measures(&self.job) {
            self.pending.fill(None);
            self.latest = None;
            self.timers = on.then(|| PassTimers::new(&self.ctx, MAX_PASSES, self.pending.len())).transpose()?;
        }
        Ok(())
    }

    /// The last measured frame that has run.
    #[cfg(feature = "window")]
    pub fn latest(&self) -> Option<&FrameRow> {
        self.latest.as_ref()
    }

    /// The renderer.
    pub fn renderer(&self) -> &Renderer {
        &self.renderer
    }

    /// Draws with other settings from the next frame on; on failure the old ones stay in force.
    pub fn set_settings(&mut self, settings: &prism_engine::settings::Settings) -> Result<()> {
        self.renderer.set_settings(&self.compiler, settings)?;
        self.tell_notices();
        Ok(())
    }

    /// Draws with pipelines that were made anew; on failure the old ones stay.
    #[cfg(feature = "window")]
    pub fn adopt(&mut self, rebuilt: Rebuilt) -> Result<()> {
        self.renderer.adopt(&self.compiler, rebuilt)
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
        for &(index, light) in &moment.lights {
            self.renderer.set_light(index, light);
        }
        self.pending[slot] = measured;
        let mut timers = self.timers.as_mut().filter(|_| measured.is_some());
        if self.job.settings.baseline.is_some() && !moment.poses.is_empty() {
            let sample = self.job.sample.id();
            return Err(Error::Usage(format!(
                "--baseline: {sample} changes shape, and a baseline's mesh is made once; drop it"
            )));
        }
        for (mesh, positions) in &moment.poses {
            let pose = Pose { positions: Vectors::Slice(positions), normals: None };
            self.renderer.deform(cmd, slot, *mesh, &pose, timers.as_deref_mut())?;
        }
        self.renderer.record(cmd, slot, &moment.pose.camera, target, timers)
    }

    /// Keeps the measurements of the slot's last frame, which has run.
    fn collect(&mut self, slot: usize) -> Result<()> {
        if let (Some(timers), Some((frame, time))) = (&mut self.timers, self.pending[slot].take()) {
            let passes = timers.resolve(slot).into_iter().map(row).collect();
            let row = FrameRow { frame, time, passes };
            #[cfg(feature = "window")]
            {
                self.latest = Some(row.clone());
            }
            // A window may measure for its panel alone, without end.
            if measures(&self.job) {
                self.rows.push(row);
            }
            if let Some(reached) = self.renderer.limits_reached(slot)? {
                *self.limits.get_or_insert(0) += u64::from(reached);
            }
            self.culled = self.renderer.culled(slot)?;
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
            console::data(&stats::report(
                &self.ctx,
                &self.compiler,
                &self.renderer,
                &self.rows,
                self.limits,
                self.culled,
            ))?;
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
