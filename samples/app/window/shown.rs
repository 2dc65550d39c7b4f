//! What is in the window: the drawing, the user's camera and keys, and the pictures on their way to the screen.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
    time::Instant,
};

use prism_engine::{
    error::{Error, Result},
    gpu::{Access, Context, ContextDesc, Feature, Frames, Swapchain, ValidationLog},
    render::{Output, plan},
    settings::{Normals, SelfShadow, Settings, Shell, Silhouette, Stage},
};
use winit::{
    dpi::PhysicalSize,
    event_loop::ActiveEventLoop,
    raw_window_handle::{HasDisplayHandle, HasWindowHandle},
    window::{Window, WindowAttributes},
};

use super::{
    clock::{Clock, Pace},
    gallery::{Gallery, Subject},
    input::Wish,
    orbit::Orbit,
    switch,
};
use crate::app::{
    console,
    drawing::{self, Drawing},
    job::Job,
    load::Loaded,
    offscreen::Offscreen,
    picture::Picture,
    png,
    sample::{Drawn, Moment, Pose},
};

/// Two: the CPU records one frame while the GPU runs the other; more would only add delay to the mouse.
const IN_FLIGHT: usize = 2;

/// What the event loop does after an event.
pub enum After {
    /// Waits for the next event.
    Wait,
    /// Draws.
    Redraw,
    /// Ends.
    Quit,
}

/// An open window. Fields drop in this order: the window after everything that draws to it.
pub struct Shown<'a> {
    job: &'a Job<'a>,
    drawing: Drawing<'a>,
    gallery: Option<Gallery>,
    swapchain: Swapchain,
    frames: Frames,
    ctx: Context,
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
    hidden: bool,
    screenshot: bool,
    window: Arc<Window>,
}

impl<'a> Shown<'a> {
    /// Opens the window and puts the scene on a device that can present to it.
    pub fn open(events: &ActiveEventLoop, job: &'a Job<'a>, scenes: Vec<Loaded>) -> Result<Shown<'a>> {
        let size = job.common.session.size;
        let attributes = WindowAttributes::default()
            .with_title(job.sample.id())
            .with_inner_size(PhysicalSize::new(size.width, size.height));
        let window = events.create_window(attributes).map_err(|e| no_window(&e))?;
        let features = drawing::features(job, &scenes, true);
        let display = window.display_handle().map_err(|e| no_window(&e))?.as_raw();
        let handle = window.window_handle().map_err(|e| no_window(&e))?.as_raw();
        let desc = ContextDesc { surface: Some((display, handle)), ..drawing::context_desc(job, &features) };
        let ctx = Context::new(&desc)?;

        // The window system may have given another size than was asked for.
        let size = window.inner_size().into();
        let swapchain = Swapchain::new(&ctx, size, true)?;
        let output = Output { color_format: swapchain.format(), aov: job.sample.exhibit().is_some() };
        let drawing = Drawing::new(job, scenes, &ctx, output, IN_FLIGHT)?;
        let shown = Shown {
            job,
            drawing,
            gallery: job.sample.exhibit().map(Gallery::new),
            swapchain,
            frames: Frames::new(&ctx, IN_FLIGHT)?,
            ctx,
            orbit: Orbit::default(),
            clock: Clock::new(job.time_step),
            pace: Pace::default(),
            count: 0,
            frame_ms: None,
            figures: None,
            size,
            hidden: false,
            screenshot: false,
            window: Arc::new(window),
        };
        shown.set_title();
        Ok(shown)
    }

    /// The validation layer's messages, which outlive the window.
    pub fn validation_log(&self) -> ValidationLog {
        self.ctx.validation_log()
    }

    /// Pixels per logical pixel.
    pub fn scale(&self) -> f64 {
        self.window.scale_factor()
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
        if self.hidden || self.size.contains(&0) {
            // The window system tells when there is something to draw to again.
            self.clock.skip();
            self.pace.reset();
            return Ok(After::Wait);
        }
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
            frame.cmd.image_barrier(image, Access::COLOR_WRITE, Access::PRESENT);
        }
        self.window.pre_present_notify();
        self.swapchain.submit_and_present(&mut self.frames, frame, target)?;
        self.count += 1;

        if std::mem::take(&mut self.screenshot) {
            self.save_screenshot(&moment, &subject)?;
        }
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
        let unfinished = self.gallery.as_ref().is_some_and(|gallery| gallery.wants_frame(&subject));
        if self.job.frames.is_some() || self.moves() || unfinished {
            return Ok(After::Redraw);
        }
        self.pace.reset();
        Ok(After::Wait)
    }

    /// Does what the user wants.
    pub fn grant(&mut self, wish: Wish) -> Result<()> {
        let settings = self.drawing.renderer().settings().clone();
        match wish {
            Wish::Stage => self.switch(switch::with_next_stage(&settings, &self.stages())),
            Wish::Shell => self.switch(switch::with_shell(&settings, self.other_shell(&settings))),
            Wish::March => {
                let scene = &self.drawing.loaded().scene;
                let next = switch::with_next_march(&settings, |march| plan::allows(scene, march));
                self.switch(next);
            }
            Wish::Dither => self.switch(switch::with_dither(&settings, !settings.dither)),
            Wish::SelfShadow => self.switch(switch::with_next_self_shadow(&settings)),
            Wish::ShadowMap => self.switch(switch::with_shadow_map(&settings, !settings.shadow_map)),
            Wish::AmbientOcclusion => {
                self.switch(switch::with_ambient_occlusion(&settings, !settings.ambient_occlusion));
            }
            Wish::Silhouette => self.switch(switch::with_next_silhouette(&settings)),
            Wish::Normals => self.switch(switch::with_next_normals(&settings)),
            Wish::Samples => self.switch(switch::with_other_samples(&settings)),
            Wish::Pause => {
                self.clock.toggle_pause();
                self.set_title();
            }
            Wish::Next => self.walk_on(false)?,
            Wish::Back => self.walk_on(true)?,
            Wish::ResetCamera => self.orbit = Orbit::default(),
            Wish::Screenshot => self.screenshot = true,
            Wish::Turn(pixels) => self.orbit.turn(&self.pose(), pixels, self.height()),
            Wish::Shift(pixels) => self.orbit.shift(&self.pose(), pixels, self.height()),
            Wish::Zoom(notches) => self.orbit.zoom(notches),
            Wish::Quit => {}
        }
        Ok(())
    }

    /// Waits for the frames under way, tells what was measured and closes the window.
    pub fn finish(mut self) -> Result<()> {
        self.frames.wait()?;
        self.drawing.finish()
    }

    fn moves(&self) -> bool {
        self.job.sample.moves() && !self.clock.paused()
    }

    /// The sample's picture, seen as the user has turned it.
    fn moment(&self, time: f64) -> Moment {
        let moment = self.drawing.moment(time);
        Moment { pose: self.orbit.apply(&moment.pose), ..moment }
    }

    /// The sample's own pose in the last frame.
    fn pose(&self) -> Pose {
        self.drawing.moment(self.clock.time()).pose
    }

    fn height(&self) -> f64 {
        f64::from(self.size[1].max(1))
    }

    fn stages(&self) -> Vec<Stage> {
        let stages = [(Stage::Mesh, Feature::MeshShader), (Stage::Geometry, Feature::GeometryShader)];
        stages.into_iter().filter(|(_, feature)| self.ctx.has(*feature)).map(|(stage, _)| stage).collect()
    }

    fn other_shell(&self, settings: &Settings) -> Shell {
        match (settings.resolved_shell(), self.job.settings.resolved_shell()) {
            (Shell::Off, Shell::Off) => Shell::Auto,
            (Shell::Off, own) => own,
            _ => Shell::Off,
        }
    }

    /// Draws with other settings from now on, or says why not and goes on as before.
    fn switch(&mut self, settings: Settings) {
        // A baseline honours none of the keys.
        if settings.baseline.is_some() {
            return;
        }
        if let Err(error) = self.drawing.set_settings(&settings) {
            console::notice(error);
        }
        self.pace.reset();
        self.set_title();
    }

    /// Shows the next scene, or the one before, or says why not and stays.
    fn walk_on(&mut self, back: bool) -> Result<()> {
        self.frames.wait()?;
        match self.drawing.walk_on(back) {
            Ok(()) => self.orbit = Orbit::default(),
            Err(error) => console::notice(error),
        }
        self.pace.reset();
        self.set_title();
        Ok(())
    }

    /// What an exhibit of this frame would show.
    fn subject(&self, moment: &Moment, size: [u32; 2]) -> Subject {
        let settings = self.drawing.renderer().settings().clone();
        let (name, lights) = (self.drawing.loaded().name.clone(), moment.lights.clone());
        Subject { name, camera: moment.pose.camera, lights, settings, size }
    }

    /// Begins an exhibit if the sample has one and the picture has come to rest.
    fn exhibit(&mut self, moment: &Moment, subject: &Subject) -> Result<()> {
        let Some(size) = self.gallery.as_mut().and_then(|gallery| gallery.wants_shot(subject)) else { return Ok(()) };
        let frame = self.draw_offscreen(moment, size)?;
        let aov = self.drawing.renderer().read_aov()?;
        let mut variants = Vec::new();
        let settings = &subject.settings;
        if let Some(exhibit) = self.job.sample.exhibit() {
            for (i, variant) in exhibit.variants(settings).iter().enumerate() {
                let moment = moment.seen_from(exhibit.seen_from(i, &moment.pose));
                self.drawing.set_settings(variant)?;
                let frame = self.draw_offscreen(&moment, size)?;
                let camera = moment.pose.camera;
                variants.push(Drawn { camera, frame, aov: self.drawing.renderer().read_aov()? });
            }
        }
        if !variants.is_empty() {
            self.drawing.set_settings(settings)?;
        }
        let scene = self.drawing.loaded().scene.clone();
        if let Some(gallery) = &mut self.gallery {
            gallery.begin(
                subject.clone(),
                scene,
                Drawn { camera: subject.camera, frame, aov },
                variants,
                self.window.clone(),
            );
        }
        Ok(())
    }

    /// Draws a frame that can be read back, and waits for it.
    fn draw_offscreen(&mut self, moment: &Moment, size: [u32; 2]) -> Result<Picture> {
        let picture = Offscreen::new(&self.ctx, size, self.swapchain.format())?;
        let mut frame = self.frames.begin()?;
        let slot = frame.slot();
        picture.prepare(&mut frame.cmd);
        self.drawing.record(&mut frame.cmd, slot, None, moment, picture.image())?;
        self.frames.submit_and_wait(frame)?;
        picture.read()
    }

    /// Sample, scene of several, stage, shell, march, what else is switched on, time per frame.
    fn set_title(&self) {
        let settings = self.drawing.renderer().settings();
        let stage = match self.drawing.renderer().plan().stage {
            Some(stage) if settings.stage == Stage::Auto => format!("stage auto ({stage})"),
            Some(stage) => format!("stage {stage}"),
            None => "no shell stage".to_owned(),
        };
        let scene = match self.drawing.scenes() {
            1 => String::new(),
            _ => format!(" · {}", self.drawing.loaded().name),
        };
        let mut title = format!(
            "{}{scene} · {stage} · shell {} · march {}",
            self.job.sample.id(),
            settings.resolved_shell(),
            settings.march
        );
        title += &switched_on(settings);
        if let Some(ms) = self.frame_ms {
            title += &format!(" · {ms:.1} ms");
        }
        if let Some(figures) = &self.figures {
            title += &format!(" · {figures}");
        }
        if self.clock.paused() {
            title += " · paused";
        }
        self.window.set_title(&title);
    }

    /// Draws the frame once more, to an image that can be read back: a window's images often cannot.
    fn save_screenshot(&mut self, moment: &Moment, subject: &Subject) -> Result<()> {
        let exhibit = self.gallery.as_ref().and_then(|gallery| gallery.shown(subject));
        let picture = match exhibit {
            Some((picture, _)) => picture.clone(),
            None => self.draw_offscreen(moment, self.swapchain.extent())?,
        };
        let path = free_name(self.job.sample.id());
        // A folder that cannot be written to is no reason to close the window.
        match png::write(&path, &picture) {
            Ok(()) => console::notice(format_args!("wrote {}", path.display())),
            Err(error) => console::notice(error),
        }
        // The time this took is not the sample's.
        self.clock.skip();
        self.pace.reset();
        Ok(())
    }
}

/// What a window's title says of the settings that are not their defaults.
fn switched_on(settings: &Settings) -> String {
    let mut text = String::new();
    let mut add = |on: bool, what: &str| {
        if on {
            text += &format!(" · {what}");
        }
    };
    add(settings.dither, "dither");
    add(settings.silhouette != Silhouette::None, &format!("silhouette {}", settings.silhouette));
    add(settings.normals != Normals::Gather, &format!("normals {}", settings.normals));
    add(settings.self_shadow != SelfShadow::Off, &format!("self-shadow {}", settings.self_shadow));
    add(settings.shadow_map, "shadow map");
    add(settings.ambient_occlusion, "ambient occlusion");
    text
}

/// `SAMPLE-1.png` in the current folder, or the first number that is not taken.
fn free_name(id: &str) -> PathBuf {
    let names = (1u64..).map(|number| PathBuf::from(format!("{id}-{number}.png")));
    names.into_iter().find(|path| !Path::exists(path)).unwrap_or_else(|| PathBuf::from(format!("{id}.png")))
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
