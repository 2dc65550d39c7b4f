//! What is in the window: the drawing, the user's camera and keys, and the pictures on their way to the screen.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
    time::{Duration, Instant},
};

use prism_engine::{
    error::{Error, Result},
    gpu::{Access, Context, ContextDesc, Feature, Frames, Swapchain, ValidationLog, vk},
    render::{Output, plan},
    scene::LightKind,
    settings::{March, Normals, SelfShadow, Settings, Shell, Silhouette, Stage, View},
};
use winit::{
    dpi::PhysicalSize,
    event::WindowEvent,
    event_loop::ActiveEventLoop,
    raw_window_handle::{HasDisplayHandle, HasWindowHandle},
    window::{Window, WindowAttributes},
};

use super::{
    capture,
    clock::{Clock, Pace},
    gallery::{Gallery, Subject},
    input::Wish,
    orbit::Orbit,
    panel::{Action, Facts, Laid, Panel},
    probed::{Done, Probed},
    reload::Reload,
    split::Split,
    switch,
};
use crate::app::{
    camera, choices,
    cli::CameraArgs,
    console,
    drawing::{self, Drawing},
    error_map::ErrorMap,
    job::Job,
    light,
    load::{self, Loaded},
    offscreen::Offscreen,
    picture::Picture,
    png,
    probe::{self, Pixel},
    sample::{Drawn, Exhibit, Moment, Pose, Source},
    spelled,
    surface::{HeightLod, SurfaceArgs},
};

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
    /// Ends.
    Quit,
}

/// An open window. Fields drop in this order: the window after everything that draws to it.
pub struct Shown<'a> {
    job: &'a Job<'a>,
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
        let output = Output { color_format: swapchain.format(), aov: exhibit(job, &job.settings).is_some() };
        let mut drawing = Drawing::new(job, scenes, &ctx, output, IN_FLIGHT)?;
        let panel = Panel::new(&window, &ctx, swapchain.format(), IN_FLIGHT)?;
        drawing.measure(panel.is_open())?;
        let window = Arc::new(window);
        let dir = job.common.session.shader_dir.as_deref();
        let reload = dir.map(|dir| Reload::new(dir, window.clone())).transpose()?;
        let mut clock = Clock::new(job.time_step);
        if job.settings.view == View::Error && job.sample.moves() {
            // It shows one moment.
            clock.toggle_pause();
        }
        let shown = Shown {
            job,
            drawing,
            gallery: exhibit(job, &job.settings).map(Gallery::new),
            split: None,
            probed: Probed::default(),
            panel,
            reload,
            surface: job.common.surface.clone(),
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
            screenshot: false,
            window,
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
        if self.hidden || self.size.contains(&0) {
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

    /// Does what the user wants.
    pub fn grant(&mut self, wish: Wish) -> Result<()> {
        let settings = self.drawing.renderer().settings().clone();
        match wish {
            Wish::Panel => {
                self.frames.wait()?;
                self.panel.toggle();
                self.drawing.measure(self.measures())?;
            }
            Wish::Stage => self.switch(switch::with_next_stage(&settings, &self.stages())),
            Wish::Shell => self.switch(switch::with_shell(&settings, self.other_shell(&settings))),
            Wish::March => {
                let scene = &self.drawing.loaded().scene;
                let next = switch::with_next_march(&settings, |march| plan::allows(scene, march));
                self.switch(next);
            }
            Wish::NextView if self.views() => self.switch(switch::with_next_view(&settings)),
            Wish::View(view) if self.views() => self.switch(switch::with_view(&settings, view)),
            Wish::NextView | Wish::View(_) => {}
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
            Wish::ResetCamera => self.reset_camera(),
            Wish::Screenshot => self.screenshot = true,
            Wish::Capture => self.tell(capture::next_frame()),
            Wish::Turn(pixels) => self.orbit.turn(&self.pose(), pixels, self.height()),
            Wish::Shift(pixels) => self.orbit.shift(&self.pose(), pixels, self.height()),
            Wish::Zoom(notches) => self.orbit.zoom(notches),
            Wish::Compare if self.views() => self.compare(self.split.is_none())?,
            Wish::MoveLine(column) => {
                if let Some(split) = &mut self.split {
                    split.move_to(column, self.size[0]);
                }
            }
            Wish::Probe(at) if self.views() => self.probe([at.x.max(0.0) as u32, at.y.max(0.0) as u32]),
            Wish::Compare | Wish::Probe(_) | Wish::Quit => {}
        }
        Ok(())
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

    /// The panel of the next frame, if it is to be seen.
    fn lay_out(&mut self) -> Result<Option<Laid>> {
        if !self.panel.shows() && self.split.is_none() && self.probed.sketch().is_none() {
            return Ok(None);
        }
        let moment = self.moment(self.clock.time());
        let memory = self.ctx.memory_report();
        let (names, current) = self.drawing.names();
        let scene = &self.drawing.loaded().scene;
        let marches: Vec<March> = March::ALL.iter().copied().filter(|&march| plan::allows(scene, march)).collect();
        let displaced = scene.materials.iter().find_map(|material| material.displacement);
        let facts = Facts {
            sample: [self.job.sample.id(), self.job.sample.summary()],
            scenes: (&names, current),
            settings: self.drawing.renderer().settings(),
            marches: &marches,
            views: self.views(),
            surface: &self.surface,
            displaced: displaced.map(|displacement| [displacement.scale, displacement.midlevel]),
            device: self.ctx.device_name(),
            latest: self.drawing.latest(),
            split: self.split.as_ref().map(|split| (split.column(self.size[0]), split.gpu_ms())),
            probed: self.probed.sketch(),
            memory: &memory,
            sun: scene
                .lights
                .iter()
                .find(|l| matches!(l.kind, LightKind::Directional))
                .map(|l| light::degrees(l.direction)),
            lights_fixed: moment.lights.is_empty(),
            occluded: scene.materials.iter().any(|material| material.occlusion.is_some()),
            camera: spelled::camera_args(&moment.pose),
        };
        self.panel.lay_out(&self.window, &facts)
    }

    /// Does what the user did in the panel.
    fn act(&mut self, action: Action, moment: &Moment, subject: &Subject) -> Result<()> {
        match action {
            Action::Settings(settings) => self.switch(settings),
            Action::Surface(surface) => self.displace(surface)?,
            Action::Scene(index) => {
                self.frames.wait()?;
                match self.drawing.walk_to(index as u64).and_then(|()| self.follow()) {
                    Ok(()) => self.reset_camera(),
                    Err(error) => self.panel.tell(error),
                }
                self.set_title();
            }
            Action::ResetCamera => self.reset_camera(),
            Action::Camera(args) => {
                let now = moment.pose.camera;
                match camera::start(&args, &self.drawing.loaded().scene, &now) {
                    Ok(pose) => (self.held, self.orbit) = (Some(pose), Orbit::default()),
                    Err(error) => self.panel.tell(error),
                }
            }
            Action::Probe(Done::Close) => self.probed.close(),
            Action::Probe(_) => {
                let path = free_name(self.job.sample.id(), "svg");
                let drawing = self.probed.sketch().map(|sketch| sketch.svg.as_str()).unwrap_or_default();
                match probe::write_drawing(&path, drawing) {
                    Ok(()) => self.panel.tell(format_args!("wrote {}", path.display())),
                    Err(error) => self.panel.tell(error),
                }
            }
            Action::Compare(on) => self.compare(on)?,
            Action::Swap => {
                let first = self.drawing.renderer().settings().clone();
                if let Some(split) = &mut self.split {
                    let second = split.settings().clone();
                    if let Err(error) = split.set_settings(&first) {
                        self.panel.tell(error);
                    }
                    self.switch(second);
                }
            }
            Action::Screenshot => {
                let told = self.save_screenshot(moment, subject)?;
                self.panel.tell(told);
            }
            Action::CopyLine => {
                let line = spelled::line(&self.line());
                self.panel.tell(format_args!("copied: {line}"));
                console::notice(format_args!("copied: {line}"));
                self.panel.copy(line);
            }
            Action::SaveView => {
                let path = views(self.job.sample.id()).find(|path| !path.exists());
                let Some(path) = path else { return Ok(()) };
                match spelled::write(&path, &self.view()) {
                    Ok(()) => self.panel.tell(format_args!("wrote {}", path.display())),
                    Err(error) => self.panel.tell(error),
                }
            }
            Action::LoadView => {
                let Some(path) = views(self.job.sample.id()).take_while(|path| path.exists()).last() else {
                    self.panel.tell("no view has been saved in this folder");
                    return Ok(());
                };
                match self.load_view(&path) {
                    Ok(()) => self.panel.tell(format_args!("as in {}", path.display())),
                    Err(error) => self.panel.tell(error),
                }
            }
        }
        Ok(())
    }

    /// Displaces the materials otherwise: their scenes are read again.
    fn displace(&mut self, surface: SurfaceArgs) -> Result<()> {
        self.frames.wait()?;
        let replaced = load::again(self.job, &surface).and_then(|scenes| {
            if let Some(split) = &mut self.split {
                split.drawing().replace(scenes.clone())?;
            }
            self.drawing.replace(scenes)
        });
        match replaced {
            Ok(()) => {
                let pixel_lod = surface.height_lod == Some(HeightLod::Auto);
                let settings = self.drawing.renderer().settings().clone();
                self.switch(switch::fitting(Settings { pixel_lod, ..settings }));
                self.surface = surface;
                self.gallery = self.exhibited().map(Gallery::new);
            }
            Err(error) => self.panel.tell(error),
        }
        Ok(())
    }

    /// The flags of what is on screen: settings, materials, camera.
    fn view(&self) -> Vec<String> {
        let start = load::start(&self.drawing.loaded().scene, self.job.size(), &CameraArgs::default());
        let now = self.orbit.apply(&self.held.unwrap_or(self.drawing.loaded().start));
        let mut words = spelled::settings(self.drawing.renderer().settings(), &self.job.sample.settings());
        // A key may have left the LOD of each pixel without a meaning.
        let per_pixel = self.drawing.renderer().settings().pixel_lod;
        let height_lod = self.surface.height_lod.filter(|lod| *lod != HeightLod::Auto || per_pixel);
        words.extend(spelled::surface(&SurfaceArgs { height_lod, ..self.surface.clone() }));
        words.extend(start.map(|start| spelled::camera(&now, &start)).unwrap_or_default());
        words
    }

    /// The call of `prism` that shows it again; of a sample that moves, as it is at time 0.
    fn line(&self) -> Vec<String> {
        let mut words: Vec<String> = ["prism", "run", self.job.sample.id()].map(str::to_owned).into();
        let (names, current) = self.drawing.names();
        let file = self.job.walk.files(1).next().filter(|_| matches!(self.job.sample.scene(), Source::Chosen { .. }));
        let scene =
            if names.len() > 1 { Some(names[current].to_owned()) } else { file.map(|f| f.display().to_string()) };
        words.extend(scene.into_iter().flat_map(|scene| ["--scene".to_owned(), scene]));
        words.extend(self.view());
        words.extend(["--size".to_owned(), format!("{}x{}", self.size[0], self.size[1])]);
        words
    }

    /// Shows what a file keeps.
    fn load_view(&mut self, path: &Path) -> Result<()> {
        let args = spelled::load(path)?;
        let mut settings = choices::settings(&args.look, &args.classic, &self.job.sample.settings())?;
        args.surface.apply(&mut settings)?;
        self.displace(args.surface)?;
        let Settings { count_limits, still, .. } = self.job.settings;
        self.switch_drawing(&Settings { count_limits, still, ..settings })?;
        self.gallery = self.exhibited().map(Gallery::new);
        let start = load::start(&self.drawing.loaded().scene, self.job.size(), &args.camera)?;
        self.drawing.start_at(start);
        self.reset_camera();
        self.set_title();
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
        Moment { pose: self.orbit.apply(&self.held.unwrap_or(moment.pose)), ..moment }
    }

    /// The sample's own pose in the last frame.
    fn pose(&self) -> Pose {
        self.held.unwrap_or_else(|| self.drawing.moment(self.clock.time()).pose)
    }

    /// Back to the sample's own camera.
    fn reset_camera(&mut self) {
        (self.held, self.orbit) = (None, Orbit::default());
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

    /// Whether the picture may be shown otherwise than shaded: not where the sample makes its own of it.
    fn views(&self) -> bool {
        self.job.sample.exhibit().is_none()
    }

    /// What a frame is made into before it is shown.
    fn exhibited(&self) -> Option<&'static dyn Exhibit> {
        exhibit(self.job, self.drawing.renderer().settings())
    }

    /// Draws with other settings from now on, or says why not and goes on as before.
    fn switch(&mut self, settings: Settings) {
        // A baseline honours none of the keys.
        if settings.baseline.is_some() {
            return;
        }
        let judged = self.drawing.renderer().settings().view == View::Error;
        if let Err(error) = self.switch_drawing(&settings) {
            self.panel.tell(&error);
            console::notice(error);
        }
        if judged != (self.drawing.renderer().settings().view == View::Error) {
            self.gallery = self.exhibited().map(Gallery::new);
        }
        self.pace.reset();
        self.set_title();
    }

    fn switch_drawing(&mut self, settings: &Settings) -> Result<()> {
        if settings.view == View::Error {
            let moment = self.moment(self.clock.time());
            moment.placed(&self.drawing.loaded().scene)?;
            // It shows one moment.
            if self.moves() {
                self.clock.toggle_pause();
            }
        }
        self.drawing.set_settings(settings)?;
        self.frames.wait()?;
        self.drawing.keep_aov(exhibit(self.job, settings).is_some())
    }

    /// Probes a pixel of the window, seen as it is now. What has been probed before goes.
    fn probe(&mut self, at: [u32; 2]) {
        self.probed.close();
        let moment = self.moment(self.clock.time());
        let loaded = self.drawing.loaded();
        let scene = match moment.placed(&loaded.scene) {
            Ok(scene) => Arc::new(scene),
            Err(error) => return self.tell(error),
        };
        let settings = self.drawing.renderer().settings().clone();
        let pixel = Pixel { at, size: self.size };
        let name = loaded.name.clone();
        self.probed.begin(name, scene, moment.pose.camera, pixel, settings, self.window.clone());
    }

    /// Tells the user, in the panel and where the program was started.
    fn tell(&mut self, text: impl std::fmt::Display) {
        self.panel.tell(&text);
        console::notice(text);
    }

    /// Whether GPU times are to be seen.
    fn measures(&self) -> bool {
        self.panel.is_open() || self.split.is_some()
    }

    /// Shows a second picture beside the first, or no more.
    fn compare(&mut self, on: bool) -> Result<()> {
        self.frames.wait()?;
        let split = on.then(|| Split::new(&self.drawing)).transpose();
        match split {
            Ok(split) => self.split = split,
            Err(error) => self.panel.tell(error),
        }
        self.drawing.measure(self.measures())
    }

    /// The second picture is of the same scene as the first.
    fn follow(&mut self) -> Result<()> {
        let (_, current) = self.drawing.names();
        self.split.as_mut().map_or(Ok(()), |split| split.drawing().walk_to(current as u64))
    }

    /// Shows the next scene, or the one before, or says why not and stays.
    fn walk_on(&mut self, back: bool) -> Result<()> {
        self.frames.wait()?;
        match self.drawing.walk_on(back).and_then(|()| self.follow()) {
            Ok(()) => self.reset_camera(),
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
        let transforms = moment.transforms.clone();
        Subject { name, camera: moment.pose.camera, transforms, lights, settings, size }
    }

    /// Begins an exhibit if the sample has one and the picture has come to rest.
    fn exhibit(&mut self, moment: &Moment, subject: &Subject) -> Result<()> {
        let Some(size) = self.gallery.as_mut().and_then(|gallery| gallery.wants_shot(subject)) else { return Ok(()) };
        let frame = self.draw_offscreen(moment, size)?;
        let aov = self.drawing.renderer().read_aov()?;
        let mut variants = Vec::new();
        let settings = &subject.settings;
        if let Some(exhibit) = self.exhibited() {
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
        let mut scene = self.drawing.loaded().scene.clone();
        if settings.view == View::Error {
            scene = Arc::new(moment.placed(&scene)?);
        }
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
        offscreen(&self.ctx, &mut self.frames, &mut self.drawing, self.swapchain.format(), moment, size)
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
    fn save_screenshot(&mut self, moment: &Moment, subject: &Subject) -> Result<String> {
        let exhibit = self.gallery.as_ref().and_then(|gallery| gallery.shown(subject));
        let mut picture = match exhibit {
            Some((picture, _)) => picture.clone(),
            None => self.draw_offscreen(moment, self.swapchain.extent())?,
        };
        if let Some(split) = &mut self.split {
            let second =
                offscreen(&self.ctx, &mut self.frames, split.drawing(), self.swapchain.format(), moment, picture.size)?;
            picture.paste_right(&second, split.column(picture.size[0]));
        }
        let path = free_name(self.job.sample.id(), "png");
        // A folder that cannot be written to is no reason to close the window.
        let told = match png::write(&path, &picture) {
            Ok(()) => format!("wrote {}", path.display()),
            Err(error) => error.to_string(),
        };
        console::notice(&told);
        // The time this took is not the sample's.
        self.clock.skip();
        self.pace.reset();
        Ok(told)
    }
}

fn offscreen(
    ctx: &Context,
    frames: &mut Frames,
    drawing: &mut Drawing<'_>,
    format: vk::Format,
    moment: &Moment,
    size: [u32; 2],
) -> Result<Picture> {
    let picture = Offscreen::new(ctx, size, format)?;
    let mut frame = frames.begin()?;
    let slot = frame.slot();
    picture.prepare(&mut frame.cmd);
    drawing.record(&mut frame.cmd, slot, None, moment, picture.image())?;
    frames.submit_and_wait(frame)?;
    picture.read()
}

/// What a frame of these settings is made into before it is shown.
fn exhibit(job: &Job<'_>, settings: &Settings) -> Option<&'static dyn Exhibit> {
    if settings.view == View::Error { Some(&ErrorMap) } else { job.sample.exhibit() }
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
    add(settings.view != View::Shaded, &format!("view {}", settings.view));
    text
}

/// `SAMPLE-view-1.json` in the current folder, and so on.
fn views(id: &str) -> impl Iterator<Item = PathBuf> {
    (1u64..).map(move |number| PathBuf::from(format!("{id}-view-{number}.json")))
}

/// `SAMPLE-1.png` in the current folder, or the first number that is not taken; and so with other endings.
fn free_name(id: &str, ending: &str) -> PathBuf {
    let mut names = (1u64..).map(|number| PathBuf::from(format!("{id}-{number}.{ending}")));
    names.find(|path| !Path::exists(path)).unwrap_or_else(|| PathBuf::from(format!("{id}.{ending}")))
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
