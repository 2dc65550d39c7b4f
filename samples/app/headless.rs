//! Frames without a window: draws them all, keeps the last.

use std::{
    f64::consts::TAU,
    path::Path,
    rc::Rc,
    sync::{Arc, atomic::AtomicUsize},
};

use indicatif::{ProgressBar, ProgressStyle};
use prism_engine::{
    error::Result,
    gpu::{Context, Frames},
    render::Output,
    settings::View,
};

use super::{
    animation::{Animation, Kind},
    console,
    drawing::{self, Drawing},
    error_map::ErrorMap,
    exr,
    job::Job,
    load::{self, Loaded},
    offscreen::{self, Offscreen},
    picture::Picture,
    png,
    sample::{Drawn, Embedding, Exhibit, Shot},
};

/// Draws the job's frames and writes its files.
pub fn run(job: &Rc<Job<'_>>) -> Result<()> {
    // A turntable stays with its first scene.
    let scenes = if turns(job) { 1 } else { job.frames.unwrap_or(1) };
    let scenes = load::load(job, scenes)?;
    if let Some(draw) = job.sample.embedding() {
        return embed(job, &scenes[0], draw);
    }
    let features = drawing::features(job, &scenes, false);
    let ctx = Context::new(&drawing::context_desc(job, &features))?;
    let log = ctx.validation_log();
    draw(job, scenes, ctx)?;
    // Everything is destroyed now: what the layer has to say about that counts too.
    log.check()
}

/// Lets the sample draw on a device of its own, and writes its picture.
fn embed(job: &Job<'_>, loaded: &Loaded, draw: fn(&Embedding<'_>) -> Result<Picture>) -> Result<()> {
    let session = &job.common.session;
    let picture = draw(&Embedding {
        scene: &loaded.scene,
        camera: &loaded.start.camera,
        settings: &job.settings,
        size: job.size(),
        validation: session.validation,
        shader_dir: session.shader_dir.as_deref(),
    })?;
    job.out.as_ref().map_or(Ok(()), |path| write_picture(path, &picture))
}

/// Whether the camera goes around.
fn turns(job: &Job<'_>) -> bool {
    job.common.session.turntable.is_some()
}

fn write_picture(path: &Path, picture: &Picture) -> Result<()> {
    png::write(path, picture)?;
    console::notice(format_args!("wrote {}", path.display()));
    Ok(())
}

fn draw(job: &Rc<Job<'_>>, scenes: Vec<Loaded>, ctx: Context) -> Result<()> {
    let session = &job.common.session;
    let judged = job.settings.view == View::Error;
    let exhibit = if judged { Some(&ErrorMap as &dyn Exhibit) } else { job.sample.exhibit() };
    let extent = exhibit.map_or(Ok(job.size()), |exhibit| exhibit.frame_size(job.size()))?;
    // First, because a size that the device cannot do needs no shader compiled to be told.
    let picture = Offscreen::new(&ctx, extent, offscreen::FORMAT)?;
    let output = Output { color_format: offscreen::FORMAT, aov: session.aov.is_some() || exhibit.is_some() };
    let mut drawing = Drawing::new(job.clone(), scenes, &ctx, output, 1)?;
    let mut frames = Frames::new(&ctx, 1)?;

    let count = job.frames.unwrap_or(1);
    let progress = progress(count);
    let mut composed = None;
    let (flag, path) = if turns(job) { ("--out", &job.out) } else { ("--sequence", &job.sequence) };
    let mut animation = None;
    if let Some(path) = path {
        animation = Some(Animation::new(path, Kind::of(flag, path)?));
    }
    for number in 0..count {
        let time = number as f64 * job.time_step.unwrap_or_default();
        if !turns(job) {
            drawing.walk_to(number)?;
        }
        let mut moment = drawing.moment(time);
        if turns(job) {
            moment.pose = moment.pose.orbited(TAU * number as f64 / count as f64);
        }
        let mut frame = frames.begin()?;
        let slot = frame.slot();
        picture.prepare(&mut frame.cmd);
        drawing.record(&mut frame.cmd, slot, Some((number, time)), &moment, picture.image())?;
        // One after the other: frames that overlap would be timed together.
        frames.submit_and_wait(frame)?;
        if let Some(exhibit) = exhibit {
            let (frame, aov) = (picture.read()?, drawing.renderer().read_aov()?);
            let mut variants = Vec::new();
            for (i, settings) in exhibit.variants(&job.settings).iter().enumerate() {
                let moment = moment.seen_from(exhibit.seen_from(i, &moment.pose));
                drawing.set_settings(settings)?;
                let mut frame = frames.begin()?;
                let slot = frame.slot();
                picture.prepare(&mut frame.cmd);
                drawing.record(&mut frame.cmd, slot, None, &moment, picture.image())?;
                frames.submit_and_wait(frame)?;
                let camera = moment.pose.camera;
                variants.push(Drawn { camera, frame: picture.read()?, aov: drawing.renderer().read_aov()? });
            }
            if !variants.is_empty() {
                drawing.set_settings(&job.settings)?;
            }
            let Loaded { name, scene, .. } = drawing.loaded();
            let camera = &moment.pose.camera;
            let scene = if judged { Arc::new(moment.placed(scene)?) } else { scene.clone() };
            let done = &AtomicUsize::new(0);
            let shot = Shot { name, scene: &scene, camera, frame: &frame, aov: &aov, variants: &variants, done };
            let (picture, figures) = exhibit.compose(&shot, job.size());
            progress.suspend(|| console::data(&format!("{figures}\n")))?;
            composed = Some(picture);
        }
        if let Some(animation) = &mut animation {
            animation.add(composed.clone().map_or_else(|| picture.read(), Ok)?)?;
        }
        progress.inc(1);
    }
    progress.finish_and_clear();

    if let Some(animation) = animation {
        animation.finish()?;
    }
    if let Some(path) = job.out.as_ref().filter(|_| !turns(job)) {
        write_picture(path, &composed.map_or_else(|| picture.read(), Ok)?)?;
    }
    if let Some(path) = &session.aov {
        if extent != job.size() {
            // The last frame once more, in the size that was asked for.
            let whole = Offscreen::new(&ctx, job.size(), offscreen::FORMAT)?;
            let moment = drawing.moment((count - 1) as f64 * job.time_step.unwrap_or_default());
            let mut frame = frames.begin()?;
            let slot = frame.slot();
            whole.prepare(&mut frame.cmd);
            drawing.record(&mut frame.cmd, slot, None, &moment, whole.image())?;
            frames.submit_and_wait(frame)?;
        }
        exr::write(path, &drawing.renderer().read_aov()?)?;
        console::notice(format_args!("wrote {}", path.display()));
    }
    drawing.finish()
}

/// A bar on stderr, if that is a terminal and there is something to wait for.
fn progress(count: u64) -> ProgressBar {
    if count < 2 {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{bar:40} {pos}/{len} frames, {eta} left");
    ProgressBar::new(count).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}
