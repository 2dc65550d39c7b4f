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
mod split;
mod switch;

use prism_engine::{
    error::{Error, Result},
    gpu::ValidationLog,
};
use winit::{
    application::ApplicationHandler,
    error::EventLoopError,
    event::{ElementState, StartCause, WindowEvent},
    event_loop::{ActiveEventLoop, ControlFlow, EventLoop},
    window::WindowId,
};

use super::{
    console,
    job::Job,
    load::{self, Loaded},
};
use input::{Input, KEYS, WALK_KEYS, Wish};
use shown::{After, Shown};

/// Shows the job in a window until the user, or its number of frames, ends it.
pub fn run(job: &Job<'_>) -> Result<()> {
    // The display first: a machine without one need not load a scene to say so.
    let events = EventLoop::new().map_err(|e| shown::no_window(&e))?;
    // Nothing is drawn unless something changes; a frame that moves asks for the next one.
    events.set_control_flow(ControlFlow::Wait);
    let scenes = load::load(job, u64::MAX)?;
    let mut app = App { job, scenes: Some(scenes), shown: None, input: Input::default(), log: None, outcome: Ok(()) };
    let ended = events.run_app(&mut app);
    app.outcome?;
    ended.map_err(event_loop_failed)?;
    app.log.map_or(Ok(()), |log| log.check())
}

fn event_loop_failed(cause: EventLoopError) -> Error {
    Error::gpu("handling the window's events", cause)
}

struct App<'a> {
    job: &'a Job<'a>,
    /// Until the window is there.
    scenes: Option<Vec<Loaded>>,
    shown: Option<Shown<'a>>,
    input: Input,
    log: Option<ValidationLog>,
    outcome: Result<()>,
}

impl App<'_> {
    /// Runs `body` on what is shown; an error ends the loop.
    fn with_shown(&mut self, events: &ActiveEventLoop, body: impl FnOnce(&mut Shown<'_>) -> Result<After>) {
        let Some(shown) = &mut self.shown else { return };
        match body(shown) {
            Ok(After::Wait) => events.set_control_flow(ControlFlow::Wait),
            Ok(After::At(time)) => events.set_control_flow(ControlFlow::WaitUntil(time)),
            Ok(After::Redraw) => shown.request_redraw(),
            Ok(After::Quit) => events.exit(),
            Err(error) => self.fail(events, error),
        }
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
        let walks = scenes.len() > 1;
        match Shown::open(events, self.job, scenes) {
            Ok(shown) => {
                console::line(KEYS);
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
