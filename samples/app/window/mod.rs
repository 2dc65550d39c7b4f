//! The window: an event loop around the same drawing that runs headless.

mod capture;
mod clock;
mod gallery;
mod input;
mod orbit;
mod panel;
mod probed;
mod reload;
mod shown;
mod sight;
mod split;
mod switch;

use std::{rc::Rc, sync::Arc};

use prism_engine::{
    error::{Error, Result},
    gpu::ValidationLog,
};
use winit::{
    application::ApplicationHandler,
    error::EventLoopError,
    event::{ElementState, StartCause, WindowEvent},
    event_loop::{ActiveEventLoop, ControlFlow, EventLoop},
    window::{Window, WindowId},
};

use super::{
    console,
    job::Job,
    load::{self, Loaded},
    sample::Sample,
};
use input::{Input, KEYS, WALK_KEYS, Wish};
use shown::{After, Shown};

/// Shows the job in a window until the user, or its number of frames, ends it. `samples`: those that the user may go on to.
pub fn run<'a>(job: Rc<Job<'a>>, samples: &'a [&'a dyn Sample]) -> Result<()> {
    // The display first: a machine without one need not load a scene to say so.
    let events = EventLoop::new().map_err(|e| shown::no_window(&e))?;
    // Nothing is drawn unless something changes; a frame that moves asks for the next one.
    events.set_control_flow(ControlFlow::Wait);
    let scenes = load::load(&job, u64::MAX)?;
    let input = Input::default();
    let mut app = App { job, samples, scenes: Some(scenes), shown: None, input, log: None, outcome: Ok(()) };
    let ended = events.run_app(&mut app);
    app.outcome?;
    ended.map_err(event_loop_failed)?;
    app.log.map_or(Ok(()), |log| log.check())
}

fn event_loop_failed(cause: EventLoopError) -> Error {
    Error::gpu("handling the window's events", cause)
}

struct App<'a> {
    job: Rc<Job<'a>>,
    samples: &'a [&'a dyn Sample],
    /// Until the window is there.
    scenes: Option<Vec<Loaded>>,
    shown: Option<Shown<'a>>,
    input: Input,
    log: Option<ValidationLog>,
    outcome: Result<()>,
}

impl<'a> App<'a> {
    /// Runs `body` on what is shown; an error ends the loop.
    fn with_shown(&mut self, events: &ActiveEventLoop, body: impl FnOnce(&mut Shown<'a>) -> Result<After>) {
        let Some(shown) = &mut self.shown else { return };
        match body(shown) {
            Ok(After::Wait) => events.set_control_flow(ControlFlow::Wait),
            Ok(After::At(time)) => events.set_control_flow(ControlFlow::WaitUntil(time)),
            Ok(After::Redraw) => shown.request_redraw(),
            Ok(After::Quit) => events.exit(),
            Ok(After::Sample(id)) => self.go_on_to(events, id),
            Err(error) => self.fail(events, error),
        }
    }

    /// Shows the job in this window, with the panel open where it has been.
    fn show(&mut self, events: &ActiveEventLoop, window: Arc<Window>, panel: Option<bool>, scenes: Vec<Loaded>) {
        let walks = scenes.len() > 1;
        match Shown::open(window, self.job.clone(), self.samples, panel, scenes) {
            Ok(shown) => {
                if walks {
                    console::line(WALK_KEYS);
                }
                self.log = Some(shown.validation_log());
                shown.request_redraw();
                self.shown = Some(shown);
            }
            Err(error) => self.fail(events, error),
        }
    }

    /// Shows another sample in the same window, or says why not and stays.
    fn go_on_to(&mut self, events: &ActiveEventLoop, id: &str) {
        let Some(shown) = &mut self.shown else { return };
        let next = self.job.beside(id, shown.size(), self.samples);
        let loaded = next.and_then(|job| load::load(&job, u64::MAX).map(|scenes| (job, scenes)));
        let (job, scenes) = match loaded {
            Ok(loaded) => loaded,
            Err(error) => {
                shown.tell(error);
                return shown.request_redraw();
            }
        };
        let (window, panel) = (shown.window(), shown.has_panel());
        // A window is drawn to by one device at a time.
        let closed = self.shown.take().map_or(Ok(()), Shown::finish);
        let closed = closed.and_then(|()| self.log.take().map_or(Ok(()), |log| log.check()));
        if let Err(error) = closed {
            return self.fail(events, error);
        }
        self.job = Rc::new(job);
        self.show(events, window, Some(panel), scenes);
    }

    fn fail(&mut self, events: &ActiveEventLoop, error: Error) {
        // The first error is the cause of those that follow.
        if self.outcome.is_ok() {
            self.outcome = Err(error);
        }
        events.exit();
    }
}

impl ApplicationHandler for App<'_> {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        let Some(scenes) = self.scenes.take() else { return };
        match shown::window(events, &self.job) {
            Ok(window) => {
                console::line(KEYS);
                self.show(events, window, None, scenes);
            }
            Err(error) => self.fail(events, error),
        }
    }

    fn new_events(&mut self, _events: &ActiveEventLoop, cause: StartCause) {
        if let (StartCause::ResumeTimeReached { .. }, Some(shown)) = (cause, &self.shown) {
            shown.request_redraw();
        }
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _window: WindowId, event: WindowEvent) {
        let Some(shown) = &mut self.shown else { return };
        let (taken, changed) = shown.panel_takes(&event);
        if changed {
            shown.request_redraw();
        }
        // A button let go of over the panel is let go of all the same.
        if taken && !matches!(event, WindowEvent::MouseInput { state: ElementState::Released, .. }) {
            return;
        }
        self.input.set_line(shown.split_line());
        if let Some(wish) = self.input.wish(&event, shown.scale()) {
            return self.with_shown(events, |shown| match wish {
                Wish::Quit => Ok(After::Quit),
                wish => shown.grant(wish).map(|()| After::Redraw),
            });
        }
        match event {
            WindowEvent::Resized(size) => self.with_shown(events, |shown| {
                shown.resized([size.width, size.height]);
                Ok(After::Redraw)
            }),
            WindowEvent::Occluded(hidden) => self.with_shown(events, |shown| {
                shown.occluded(hidden);
                Ok(After::Redraw)
            }),
            WindowEvent::RedrawRequested => self.with_shown(events, |shown| shown.draw()),
            _ => {}
        }
    }

    fn exiting(&mut self, _events: &ActiveEventLoop) {
        // Here and not after the loop: what draws to the window must go while the display's connection is open.
        if let Some(shown) = self.shown.take() {
            let finished = shown.finish();
            if self.outcome.is_ok() {
                self.outcome = finished;
            }
        }
    }
}
