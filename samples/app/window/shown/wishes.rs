//! What keys and mouse ask for.

use std::sync::Arc;

use prism_engine::{
    error::Result,
    render::{self, plan},
    settings::{Settings, Shell, View},
};

use super::{
    super::{capture, gallery::Gallery, input::Wish, orbit::Orbit, split::Split, switch},
    Shown,
    pictures::exhibit,
};
use crate::app::{console, probe::Pixel, sample::Pose};

impl Shown<'_> {
    /// Does what the user wants.
    pub fn grant(&mut self, wish: Wish) -> Result<()> {
        let settings = self.drawing.renderer().settings().clone();
        match wish {
            Wish::Panel => {
                self.frames.wait()?;
                self.panel.toggle();
                self.drawing.measure(self.measures())?;
            }
            Wish::Stage => self.switch(switch::with_next_stage(&settings, &render::shell_stages(&self.ctx))),
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
            Wish::Sequence => self.keep_frames(),
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

    /// The sample's own pose in the last frame.
    pub(super) fn pose(&self) -> Pose {
        self.held.unwrap_or_else(|| self.drawing.moment(self.clock.time()).pose)
    }

    /// Back to the sample's own camera.
    pub(super) fn reset_camera(&mut self) {
        (self.held, self.orbit) = (None, Orbit::default());
    }

    fn height(&self) -> f64 {
        f64::from(self.size[1].max(1))
    }

    fn other_shell(&self, settings: &Settings) -> Shell {
        match (settings.resolved_shell(), self.job.settings.resolved_shell()) {
            (Shell::Off, Shell::Off) => Shell::Auto,
            (Shell::Off, own) => own,
            _ => Shell::Off,
        }
    }

    /// Draws with other settings from now on, or says why not and goes on as before.
    pub(super) fn switch(&mut self, settings: Settings) {
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

    pub(super) fn switch_drawing(&mut self, settings: &Settings) -> Result<()> {
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
        self.drawing.keep_aov(exhibit(&self.job, settings).is_some())
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
    pub fn tell(&mut self, text: impl std::fmt::Display) {
        self.panel.tell(&text);
        console::notice(text);
    }

    /// Shows a second picture beside the first, or no more.
    pub(super) fn compare(&mut self, on: bool) -> Result<()> {
        self.frames.wait()?;
        let split = on.then(|| Split::new(&self.drawing, self.surface.clone())).transpose();
        match split {
            Ok(split) => self.split = split,
            Err(error) => self.panel.tell(error),
        }
        self.drawing.measure(self.measures())
    }

    /// The second picture is of the same scene as the first.
    pub(super) fn follow(&mut self) -> Result<()> {
        let (_, current) = self.drawing.names();
        self.split.as_mut().map_or(Ok(()), |split| split.drawing().walk_to(current as u64))
    }

    /// Shows the next scene, or the one before, or says why not and stays.
    pub(super) fn walk_on(&mut self, back: bool) -> Result<()> {
        self.frames.wait()?;
        match self.drawing.walk_on(back).and_then(|()| self.follow()) {
            Ok(()) => self.reset_camera(),
            Err(error) => console::notice(error),
        }
        self.pace.reset();
        self.set_title();
        Ok(())
    }
}
