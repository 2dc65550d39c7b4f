//! What the panel is told, and what is done in it.

use std::{
    path::{Path, PathBuf},
    rc::Rc,
};

use prism_engine::{
    error::Result,
    render::plan,
    scene::LightKind,
    settings::{March, Settings},
};

use super::{
    super::{
        gallery::{Gallery, Subject},
        orbit::Orbit,
        panel::{Action, Facts, Laid},
        probed::Done,
        switch,
    },
    Shown,
    pictures::free_name,
};
use crate::app::{
    camera, choices,
    cli::CameraArgs,
    console, light, load, probe,
    sample::{Moment, Source},
    spelled,
    surface::{HeightLod, SurfaceArgs},
    walk,
};

impl Shown<'_> {
    /// The panel of the next frame, if it is to be seen.
    pub(super) fn lay_out(&mut self) -> Result<Option<Laid>> {
        if !self.panel.shows() && self.split.is_none() && self.probed.sketch().is_none() {
            return Ok(None);
        }
        let moment = self.moment(self.clock.time());
        let memory = self.ctx.memory_report();
        let (names, current) = self.scenes();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let scene = &self.drawing.loaded().scene;
        let marches: Vec<March> = March::ALL.iter().copied().filter(|&march| plan::allows(scene, march)).collect();
        let displaced = scene.materials.iter().find_map(|material| material.displacement);
        let facts = Facts {
            sample: self.job.sample,
            samples: &self.samples,
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
            keeps_frames: self.kept.is_some(),
            camera: spelled::camera_args(&moment.pose),
        };
        self.panel.lay_out(&self.window, &facts)
    }

    /// Does what the user did in the panel.
    pub(super) fn act(&mut self, action: Action, moment: &Moment, subject: &Subject) -> Result<()> {
        match action {
            // The window is for another sample then.
            Action::Sample(_) => {}
            Action::Settings(settings) => self.switch(settings),
            Action::Surface(surface) => self.displace(surface)?,
            Action::Scene(index) => {
                self.frames.wait()?;
                let shown = match self.files.get(index).cloned() {
                    Some(file) => self.show_file(file),
                    None => self.drawing.walk_to(index as u64).and_then(|()| self.follow()),
                };
                match shown {
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
                self.frames.wait()?;
                if let Err(error) = self.swap() {
                    self.panel.tell(error);
                }
            }
            Action::Screenshot => {
                let told = self.save_screenshot(moment, subject)?;
                self.panel.tell(told);
            }
            Action::Sequence => self.keep_frames(),
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

    /// Exchanges the settings, materials and lights of the two pictures. All frames so far have run.
    fn swap(&mut self) -> Result<()> {
        let Some(split) = &mut self.split else { return Ok(()) };
        let (first, second) = (self.drawing.renderer().settings().clone(), split.settings().clone());
        split.set_settings(&first)?;
        let (left, right) = (self.surface.clone(), split.surface().clone());
        if left != right {
            split.replace(load::again(&self.job, &left)?, left)?;
            self.displace(right)?;
        }
        self.switch(second);
        Ok(())
    }

    /// Displaces the materials otherwise: their scenes are read again. Those of a comparison keep what they have.
    fn displace(&mut self, surface: SurfaceArgs) -> Result<()> {
        self.frames.wait()?;
        match load::again(&self.job, &surface).and_then(|scenes| self.drawing.replace(scenes)) {
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

    /// Shows another file, drawn as this one is.
    fn show_file(&mut self, file: PathBuf) -> Result<()> {
        let job = self.job.of_file(file);
        self.drawing.replace(load::again(&job, &self.surface)?)?;
        if let Some(split) = &mut self.split {
            let surface = split.surface().clone();
            split.replace(load::again(&job, &surface)?, surface)?;
        }
        self.job = Rc::new(job);
        Ok(())
    }

    /// What may be shown is called, and which one is.
    fn scenes(&self) -> (Vec<String>, usize) {
        if self.files.is_empty() {
            let (names, current) = self.drawing.names();
            return (names.into_iter().map(str::to_owned).collect(), current);
        }
        let shown = self.job.walk.files(1).next();
        let current = self.files.iter().position(|file| Some(file.as_path()) == shown);
        (self.files.iter().map(|file| walk::name(file)).collect(), current.unwrap_or(0))
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
}

/// `SAMPLE-view-1.json` in the current folder, and so on.
fn views(id: &str) -> impl Iterator<Item = PathBuf> {
    (1u64..).map(move |number| PathBuf::from(format!("{id}-view-{number}.json")))
}
