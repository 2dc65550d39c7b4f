//! What is in the window: the drawing, the user's camera and keys, and the pictures on their way to the screen.

mod actions;
mod pictures;
mod title;
mod wishes;

use std::{
    path::PathBuf,
    rc::Rc,
    sync::Arc,
    time::{Duration, Instant},
};

use prism_engine::{
    error::{Error, Result},
    gpu::{Access, Context, ContextDesc, Frames, Swapchain, ValidationLog},
    render::Output,
    settings::View,
};
use winit::{
    dpi::PhysicalSize,
    event::WindowEvent,
    event_loop::ActiveEventLoop,
    raw_window_handle::{HasDisplayHandle, HasWindowHandle},
    window::{Window, WindowAttributes},
};

use super::{
    clock::{Clock, Pace},
    gallery::Gallery,
    orbit::Orbit,
    panel::{Action, Panel},
    probed::Probed,
    reload::Reload,
    sight::Sight,
    split::Split,
};
use crate::app::{
    animation::Animation,
    console,
    drawing::{self, Drawing},
    job::Job,
    load::Loaded,
    sample::{Moment, Pose, Sample, Source},
    surface::SurfaceArgs,
    walk,
};
use pictures::exhibit;

/// Two: the CPU records one frame while the GPU runs the other; more would only add delay to the mouse.
const IN_FLIGHT: usize = 2;

/// How often the user sees how far the reference is.
const PROGRESS_EVERY: Duration = Duration::from_millis(100);

/// What the event loop does after an event.
pub enum After {
    /// Waits for the next event.
    Wait,
    /// Waits for the next event, or draws at this time if none comes.
    At(Instant),
    /// Draws.
    Redraw,
    /// Shows the sample of this name.
    Sample(&'static str),
    /// Ends.
    Quit,
}

/// An open window. Fields drop in this order: the window after everything that draws to it.
pub struct Shown<'a> {
    job: Rc<Job<'a>>,
    /// What the user may go on to: none from a run that is measured.
    samples: Vec<&'a dyn Sample>,
    /// The files that the sample may be shown with, beside its own.
    files: Vec<PathBuf>,
    drawing: Drawing<'a>,
    gallery: Option<Gallery>,
    /// The second settings of a comparison.
    split: Option<Split<'a>>,
    /// What a click has asked about.
    probed: Probed,
    panel: Panel,
    /// Where shaders are read from a folder.
    reload: Option<Reload>,
    /// What the displaced materials have in place of their own values.
    surface: SurfaceArgs,
    swapchain: Swapchain,
    frames: Frames,
    ctx: Context,
    /// A camera that the panel has put in the place of the sample's.
    held: Option<Pose>,
    orbit: Orbit,
    clock: Clock,
    pace: Pace,
    /// Frames presented so far.
    count: u64,
    /// Milliseconds per frame as the title shows them.
    frame_ms: Option<f64>,
    /// Of the exhibit that is shown.
    figures: Option<String>,
    /// In pixels; 0 while minimised.
    size: [u32; 2],
    /// As winit tells.
    hidden: bool,
    sight: Sight,
    screenshot: bool,
    /// Frames that are kept, each as a picture.
    kept: Option<Animation>,
    window: Arc<Window>,
}

impl<'a> Shown<'a> {
    /// Puts the scene on a device that can present to the window. `samples`: all that there are; `panel`: whether it is
    /// open, where that is not for the window's width to say.
    pub fn open(
        window: Arc<Window>,
        job: Rc<Job<'a>>,
        samples: &[&'a dyn Sample],
        panel: Option<bool>,
        scenes: Vec<Loaded>,
    ) -> Result<Shown<'a>> {
        let features = drawing::features(&job, &scenes, true);
        let display = window.display_handle().map_err(|e| no_window(&e))?.as_raw();
        let handle = window.window_handle().map_err(|e| no_window(&e))?.as_raw();
        let desc = ContextDesc { surface: Some((display, handle)), ..drawing::context_desc(&job, &features) };
        let ctx = Context::new(&desc)?;

        // The window system may have given another size than was asked for.
        let size = window.inner_size().into();
        let swapchain = Swapchain::new(&ctx, size, true)?;
        let output = Output { color_format: swapchain.format(), aov: exhibit(&job, &job.settings).is_some() };
        let mut drawing = Drawing::new(job.clone(), scenes, &ctx, output, IN_FLIGHT)?;
        let panel = Panel::new(&window, &ctx, swapchain.format(), IN_FLIGHT, panel)?;
        drawing.measure(panel.is_open())?;
        let dir = job.common.session.shader_dir.as_deref();
        let reload = dir.map(|dir| Reload::new(dir, window.clone())).transpose()?;
        let mut clock = Clock::new(job.time_step);
        if job.settings.view == View::Error && job.sample.moves() {
            // It shows one moment.
            clock.toggle_pause();
        }
        let mut samples = samples.to_vec();
        samples.retain(|sample| sample.embedding().is_none());
        if job.frames.is_some() || job.common.session.stats || job.common.session.csv.is_some() {
            samples.clear();
        }
        let chosen = matches!(job.sample.scene(), Source::Chosen { .. });
        let files = job.walk.files(1).next().filter(|_| chosen).map_or_else(Vec::new, walk::neighbours);
        let shown = Shown {
            samples,
            files,
            drawing,
            gallery: exhibit(&job, &job.settings).map(Gallery::new),
            split: None,
            probed: Probed::default(),
            panel,
            reload,
            surface: job.common.surface.clone(),
            job,
            swapchain,
            frames: Frames::new(&ctx, IN_FLIGHT)?,
            ctx,
            held: None,
            orbit: Orbit::default(),
            clock,
            pace: Pace::default(),
            count: 0,
            frame_ms: None,
            figures: None,
            size,
            hidden: false,
            sight: Sight::new(&window),
            screenshot: false,
            kept: None,
            window,
        };
        shown.set_title();
        Ok(shown)
    }

    /// The validation layer's messages, which outlive the window.
    pub fn validation_log(&self) -> ValidationLog {
        self.ctx.validation_log()
    }

    /// What it is shown in.
    pub fn window(&self) -> Arc<Window> {
        self.window.clone()
    }

    /// Of the window, in pixels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Whether the panel is open.
    pub fn has_panel(&self) -> bool {
        self.panel.is_open()
    }

    /// Pixels per logical pixel.
    pub fn scale(&self) -> f64 {
        self.window.scale_factor()
    }

    /// Column of the line between two pictures, if there are two.
    pub fn split_line(&self) -> Option<f64> {
        self.split.as_ref().map(|split| split.column(self.size[0]).into())
    }

    /// Lets the panel see an event first: whether it was for the panel alone, and whether a frame is due.
    pub fn panel_takes(&mut self, event: &WindowEvent) -> (bool, bool) {
        self.panel.take(&self.window, event)
    }

    /// Asks the window system for a [`Self::draw`] at its convenience.
    pub fn request_redraw(&self) {
        self.window.request_redraw();
    }

    /// The window has another size now.
    pub fn resized(&mut self, size: [u32; 2]) {
        self.size = size;
    }

    /// Nothing of the window can be seen, or something again.
    pub fn occluded(&mut self, hidden: bool) {
        self.hidden = hidden;
    }

    /// Draws a frame and shows it.
    pub fn draw(&mut self) -> Result<After> {
        if self.hidden || self.sight.is_gone() || self.size.contains(&0) {
            // The window system tells when there is something to draw to again.
            self.clock.skip();
            self.pace.reset();
            return Ok(After::Wait);
        }
        self.take_shaders();
        match self.probed.collect() {
            // The first frame only finds out how large the drawing is.
            Ok(true) => self.panel.repaint(),
            Ok(false) => {}
            Err(error) => self.tell(error),
        }
        let progress = self.gallery.as_ref().and_then(Gallery::progress);
        self.panel.set_note(progress.map(|share| format!("reference: {:.0} % of its rays", 100.0 * share)));
        let laid = self.lay_out()?;
        // Of a still picture too: what a frame costs is known some frames later.
        let unmeasured = self.measures() && self.drawing.latest().is_none();
        let unmeasured = unmeasured || self.split.as_ref().is_some_and(|split| split.gpu_ms().is_none());
        let mut frame = self.frames.begin()?;
        let Some(target) = self.swapchain.acquire(&frame, self.size)? else {
            // The window has just changed: its new images come with the next try.
            return Ok(After::Redraw);
        };
        let now = Instant::now();
        let time = self.clock.tick(now);
        let moment = self.moment(time);
        let image = self.swapchain.image(target);
        let slot = frame.slot();
        let subject = self.subject(&moment, image.extent());
        let mut news = None;
        let mut exhibited = false;
        if let Some(gallery) = &mut self.gallery {
            news = gallery.collect(&self.ctx, &subject)?;
            exhibited = gallery.record(&mut frame.cmd, &subject, image);
        }
        if !exhibited {
            frame.cmd.image_barrier(image, Access::ACQUIRED, Access::COLOR_WRITE);
            self.drawing.record(&mut frame.cmd, slot, Some((self.count, time)), &moment, image)?;
        }
        if let Some(split) = &mut self.split {
            split.record(&self.ctx, &mut frame.cmd, slot, (self.count, time), &moment, image)?;
        }
        if let Some(laid) = &laid {
            self.panel.record(&mut frame.cmd, image, laid)?;
        }
        frame.cmd.image_barrier(image, Access::COLOR_WRITE, Access::PRESENT);
        self.window.pre_present_notify();
        self.swapchain.submit_and_present(&mut self.frames, frame, target)?;
        self.count += 1;

        if std::mem::take(&mut self.screenshot) {
            self.save_screenshot(&moment, &subject)?;
        }
        self.keep(&moment, &subject)?;
        if let Some(figures) = news {
            console::data(&format!("{figures}\n"))?;
        }
        let gallery = self.gallery.as_ref();
        let figures = gallery.and_then(|gallery| gallery.shown(&subject)).map(|(_, figures)| figures.to_owned());
        if figures != self.figures {
            self.figures = figures;
            self.set_title();
        }
        self.exhibit(&moment, &subject)?;
        if let Some(ms) = self.pace.frame(now) {
            self.frame_ms = Some(ms);
            self.set_title();
        }
        if self.job.frames.is_some_and(|frames| self.count >= frames) {
            return Ok(After::Quit);
        }
        let mut at = None;
        if let Some(laid) = laid {
            let acted = !laid.actions.is_empty();
            for action in laid.actions {
                if let Action::Sample(id) = action {
                    return Ok(After::Sample(id));
                }
                self.act(action, &moment, &subject)?;
            }
            if acted || laid.repaint_after.is_zero() || unmeasured && !exhibited {
                return Ok(After::Redraw);
            }
            at = now.checked_add(laid.repaint_after);
        }
        if progress.is_some() {
            let next = now + PROGRESS_EVERY;
            at = Some(at.map_or(next, |at: Instant| at.min(next)));
        }
        let unfinished = self.gallery.as_ref().is_some_and(|gallery| gallery.wants_frame(&subject));
        if self.job.frames.is_some() || self.moves() || unfinished {
            return Ok(After::Redraw);
        }
        self.pace.reset();
        Ok(at.map_or(After::Wait, After::At))
    }

    /// Draws with the shaders on disk, if they have changed and can be drawn with.
    fn take_shaders(&mut self) {
        let Some(reload) = &mut self.reload else { return };
        let Some(rebuilt) = reload.poll(|| self.drawing.renderer().recipe()) else { return };
        let count = rebuilt.as_ref().map_or(0, |rebuilt| rebuilt.len());
        match rebuilt.and_then(|rebuilt| self.drawing.adopt(rebuilt)) {
            Ok(()) => {
                console::notice(format_args!("shaders: {count} pipelines made anew"));
                self.panel.set_fault(None);
                // Made of what the folder held then.
                self.split = None;
                self.gallery = self.exhibited().map(Gallery::new);
            }
            Err(error) => {
                console::notice(format_args!("shaders: {error}"));
                self.panel.set_fault(Some(error.to_string()));
            }
        }
    }

    /// Waits for the frames under way, tells what was measured and closes the window.
    pub fn finish(mut self) -> Result<()> {
        if let Some(kept) = self.kept.take() {
            kept.finish()?;
        }
        self.frames.wait()?;
        self.drawing.finish()
    }

    fn moves(&self) -> bool {
        self.job.sample.moves() && !self.clock.paused()
    }

    /// The sample's picture, seen as the user has turned it.
    fn moment(&self, time: f64) -> Moment {
        let moment = self.drawing.moment(time);
        Moment { pose: self.orbit.apply(&self.held.unwrap_or(moment.pose)), ..moment }
    }

    /// Whether the picture may be shown otherwise than shaded: not where the sample makes its own of it.
    fn views(&self) -> bool {
        self.job.sample.exhibit().is_none()
    }

    /// Whether GPU times are to be seen.
    fn measures(&self) -> bool {
        self.panel.is_open() || self.split.is_some()
    }
}

/// A window for the job.
pub fn window(events: &ActiveEventLoop, job: &Job<'_>) -> Result<Arc<Window>> {
    let [width, height] = job.size();
    let attributes =
        WindowAttributes::default().with_title(job.sample.id()).with_inner_size(PhysicalSize::new(width, height));
    events.create_window(named(attributes)).map(Arc::new).map_err(|e| no_window(&e))
}

/// With the name by which a desktop knows the program's windows: their class on X11, their application on Wayland.
fn named(attributes: WindowAttributes) -> WindowAttributes {
    #[cfg(all(unix, not(target_os = "macos")))]
    let attributes = winit::platform::x11::WindowAttributesExtX11::with_name(attributes, "prism", "prism");
    attributes
}

/// What the window system refused. Of winit's message only the cause is kept: before it stands a place in winit.
pub fn no_window(error: &dyn std::error::Error) -> Error {
    let text = error.to_string();
    let cause = text.rsplit(": ").next().unwrap_or(&text);
    Error::unsupported(
        format!("no window can be opened: {cause}"),
        "check DISPLAY and WAYLAND_DISPLAY, or render without a window (--headless)",
    )
}
