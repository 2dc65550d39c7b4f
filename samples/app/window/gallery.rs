//! A sample's exhibit in a window: composed on a thread of its own, and shown in place of the frame once it is there
//! and nothing has changed since.

use std::{
    sync::{
        Arc,
        atomic::{AtomicUsize, Ordering},
        mpsc,
    },
    thread,
};

use glam::DAffine3;
use prism_engine::{
    error::Result,
    gpu::{Access, CommandEncoder, Context, Image, ImageDesc, Uploader, vk},
    scene::{Camera, Light, Scene},
    settings::Settings,
};
use winit::window::Window;

use crate::app::{
    picture::Picture,
    sample::{Drawn, Exhibit, Shot},
};

/// What an exhibit shows: it stays right until this changes.
#[derive(Clone, Debug, PartialEq)]
pub struct Subject {
    /// The scene's name.
    pub name: String,
    /// Where from.
    pub camera: Camera,
    /// Instances that have moved.
    pub transforms: Vec<(usize, DAffine3)>,
    /// Lights that have changed.
    pub lights: Vec<(usize, Light)>,
    /// How it is drawn.
    pub settings: Settings,
    /// The window's pixels.
    pub size: [u32; 2],
}

/// An exhibit that is there.
struct Hung {
    subject: Subject,
    picture: Picture,
    figures: String,
    image: Image,
}

/// An exhibit that is being composed.
struct UnderWay {
    subject: Subject,
    ready: mpsc::Receiver<(Picture, String)>,
    /// Pixels of its reference that are done.
    done: Arc<AtomicUsize>,
}

/// The exhibit in the window.
pub struct Gallery {
    exhibit: &'static dyn Exhibit,
    /// Of the last frame.
    last: Option<Subject>,
    under_way: Option<UnderWay>,
    hung: Option<Hung>,
}

impl Gallery {
    /// With nothing in it yet.
    pub fn new(exhibit: &'static dyn Exhibit) -> Gallery {
        Gallery { exhibit, last: None, under_way: None, hung: None }
    }

    /// Takes what has become ready and returns its figures, if the user has not gone on meanwhile.
    pub fn collect(&mut self, ctx: &Context, now: &Subject) -> Result<Option<String>> {
        let Some(ready) = self.under_way.as_ref().map(|way| way.ready.try_recv()) else { return Ok(None) };
        if matches!(ready, Err(mpsc::TryRecvError::Empty)) {
            return Ok(None);
        }
        let subject = self.under_way.take().map(|way| way.subject);
        let (Some(subject), Ok((picture, figures))) = (subject.filter(|s| s == now), ready) else { return Ok(None) };
        let mut uploader = Uploader::new(ctx)?;
        let desc = ImageDesc {
            name: "exhibit",
            extent: picture.size,
            format: vk::Format::R8G8B8A8_SRGB,
            usage: vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_SRC,
            ..ImageDesc::default()
        };
        let image = uploader.image(&desc, picture.pixels.as_flattened())?;
        uploader.finish()?;
        self.hung = Some(Hung { subject, picture, figures: figures.clone(), image });
        Ok(Some(figures))
    }

    /// How much of the reference that the exhibit under way waits for is done, 0 to 1.
    pub fn progress(&self) -> Option<f64> {
        let way = self.under_way.as_ref()?;
        let [width, height] = self.frame_size(&way.subject)?;
        Some(way.done.load(Ordering::Relaxed) as f64 / (f64::from(width) * f64::from(height)))
    }

    /// The exhibit of `now`, if it is there, and its figures.
    pub fn shown(&self, now: &Subject) -> Option<(&Picture, &str)> {
        self.hung.as_ref().filter(|hung| hung.subject == *now).map(|hung| (&hung.picture, hung.figures.as_str()))
    }

    /// Copies the exhibit of `now` to `target` (at [`Access::ACQUIRED`]; then at [`Access::COLOR_WRITE`]), if it is there
    /// and the window system lets its images be copied to. Whether it did.
    pub fn record(&self, cmd: &mut CommandEncoder, now: &Subject, target: &Image) -> bool {
        let Some(hung) = self.hung.as_ref().filter(|hung| hung.subject == *now) else { return false };
        if !target.usage().contains(vk::ImageUsageFlags::TRANSFER_DST) {
            return false;
        }
        cmd.image_barrier(target, Access::ACQUIRED, Access::TRANSFER_DST);
        cmd.image_barrier(&hung.image, Access::SHADER_READ, Access::TRANSFER_SRC);
        cmd.blit(&hung.image, 0, target, 0, vk::Filter::NEAREST);
        cmd.image_barrier(&hung.image, Access::TRANSFER_SRC, Access::SHADER_READ);
        cmd.image_barrier(target, Access::TRANSFER_DST, Access::COLOR_WRITE);
        true
    }

    /// Whether anything is yet to be done for `now`: then one more frame is due.
    pub fn wants_frame(&self, now: &Subject) -> bool {
        self.under_way.is_none() && self.shown(now).is_none() && self.frame_size(now).is_some()
    }

    /// The size of the frame that is wanted now for an exhibit: none before the picture has come to rest.
    pub fn wants_shot(&mut self, now: &Subject) -> Option<[u32; 2]> {
        let rests = self.last.replace(now.clone()).as_ref() == Some(now);
        self.frame_size(now).filter(|_| rests && self.wants_frame(now))
    }

    /// None where the window is too small for an exhibit.
    fn frame_size(&self, now: &Subject) -> Option<[u32; 2]> {
        self.exhibit.frame_size(now.size).ok()
    }

    /// Begins to compose `subject`'s exhibit, and has `window` drawn again when it is done.
    pub fn begin(
        &mut self,
        subject: Subject,
        scene: Arc<Scene>,
        drawn: Drawn,
        variants: Vec<Drawn>,
        window: Arc<Window>,
    ) {
        let (sender, receiver) = mpsc::channel();
        let (exhibit, wanted) = (self.exhibit, subject.clone());
        let done = Arc::new(AtomicUsize::new(0));
        let counted = done.clone();
        thread::spawn(move || {
            let Subject { name, camera, size, .. } = &wanted;
            let Drawn { frame, aov, .. } = &drawn;
            let shot = Shot { name, scene: &scene, camera, frame, aov, variants: &variants, done: &counted };
            // A window that has been closed meanwhile waits for nothing.
            let _ = sender.send(exhibit.compose(&shot, *size));
            window.request_redraw();
        });
        self.under_way = Some(UnderWay { subject, ready: receiver, done });
    }
}
