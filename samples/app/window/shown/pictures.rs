//! Pictures that are not the next frame's: exhibits and screenshots.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

use prism_engine::{
    error::Result,
    gpu::{Context, Frames, vk},
    settings::{Settings, View},
};

use super::{super::gallery::Subject, Shown};
use crate::app::{
    animation::{self, Animation, Kind},
    console,
    drawing::Drawing,
    error_map::ErrorMap,
    job::Job,
    offscreen::Offscreen,
    picture::Picture,
    png,
    sample::{Drawn, Exhibit, Moment},
};

impl Shown<'_> {
    /// What a frame is made into before it is shown.
    pub(super) fn exhibited(&self) -> Option<&'static dyn Exhibit> {
        exhibit(&self.job, self.drawing.renderer().settings())
    }

    /// What an exhibit of this frame would show.
    pub(super) fn subject(&self, moment: &Moment, size: [u32; 2]) -> Subject {
        let settings = self.drawing.renderer().settings().clone();
        let (name, lights) = (self.drawing.loaded().name.clone(), moment.lights.clone());
        let transforms = moment.transforms.clone();
        Subject { name, camera: moment.pose.camera, transforms, lights, settings, size }
    }

    /// Begins an exhibit if the sample has one and the picture has come to rest.
    pub(super) fn exhibit(&mut self, moment: &Moment, subject: &Subject) -> Result<()> {
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

    /// What is seen. The frame is drawn once more, to an image that can be read back: a window's images often cannot.
    fn seen(&mut self, moment: &Moment, subject: &Subject) -> Result<Picture> {
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
        Ok(picture)
    }

    /// Begins to keep every frame as a picture, or ends it.
    pub(super) fn keep_frames(&mut self) {
        if let Some(kept) = self.kept.take() {
            if let Err(error) = kept.finish() {
                self.tell(error);
            }
        } else {
            let id = self.job.sample.id();
            let mut names = (1u64..).map(|number| PathBuf::from(format!("{id}-frames-{number}.png")));
            let path = names.find(|path| !animation::numbered(path, 0).exists());
            self.kept = path.map(|path| Animation::new(&path, Kind::Sequence));
        }
        self.clock.keep_to(self.kept.as_ref().map(|_| animation::STEP));
        self.set_title();
    }

    /// Keeps this frame, if frames are kept.
    pub(super) fn keep(&mut self, moment: &Moment, subject: &Subject) -> Result<()> {
        if self.kept.is_some() {
            let picture = self.seen(moment, subject)?;
            // A folder that cannot be written to is no reason to close the window.
            if let Some(Err(error)) = self.kept.as_mut().map(|kept| kept.add(picture)) {
                self.tell(error);
                self.kept = None;
                self.clock.keep_to(None);
                self.set_title();
            }
        }
        Ok(())
    }

    /// Saves what is seen.
    pub(super) fn save_screenshot(&mut self, moment: &Moment, subject: &Subject) -> Result<String> {
        let picture = self.seen(moment, subject)?;
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
pub(super) fn exhibit(job: &Job<'_>, settings: &Settings) -> Option<&'static dyn Exhibit> {
    if settings.view == View::Error { Some(&ErrorMap) } else { job.sample.exhibit() }
}

/// `SAMPLE-1.png` in the current folder, or the first number that is not taken; and so with other endings.
pub(super) fn free_name(id: &str, ending: &str) -> PathBuf {
    let mut names = (1u64..).map(|number| PathBuf::from(format!("{id}-{number}.{ending}")));
    names.find(|path| !Path::exists(path)).unwrap_or_else(|| PathBuf::from(format!("{id}.{ending}")))
}
