//! Shaders edited while the window is open: what a change touches is made anew beside the frames.

use std::{
    path::{Path, PathBuf},
    sync::{Arc, mpsc},
    thread,
    time::Duration,
};

use notify::{EventKind, RecommendedWatcher, RecursiveMode, Watcher};
use prism_engine::{
    error::{Error, Result},
    render::{self, reload::Rebuilt, reload::Recipe},
};
use winit::window::Window;

/// Editors write a file in several steps; so long after the first one they are done.
const SETTLE: Duration = Duration::from_millis(80);

/// Watches a shader folder.
pub struct Reload {
    dir: PathBuf,
    changes: mpsc::Receiver<()>,
    under_way: Option<mpsc::Receiver<Result<Rebuilt>>>,
    window: Arc<Window>,
    /// Ends with this.
    _watcher: RecommendedWatcher,
}

impl Reload {
    /// Watches `dir`, and has `window` drawn when something in it changes.
    pub fn new(dir: &Path, window: Arc<Window>) -> Result<Reload> {
        let failed =
            |e: notify::Error| Error::input(dir, "shader folder", format!("cannot be watched: {e}"), "name another");
        let (sender, changes) = mpsc::channel();
        let woken = window.clone();
        let told = move |event: notify::Result<notify::Event>| {
            // Reading is no change: the compiler itself reads.
            if event.is_ok_and(|event| !matches!(event.kind, EventKind::Access(_))) && sender.send(()).is_ok() {
                woken.request_redraw();
            }
        };
        let mut watcher = notify::recommended_watcher(told).map_err(failed)?;
        watcher.watch(dir, RecursiveMode::Recursive).map_err(failed)?;
        Ok(Reload { dir: dir.to_owned(), changes, under_way: None, window, _watcher: watcher })
    }

    /// What has become ready, if anything. Begins to make the pipelines of `recipe` where a file has changed.
    pub fn poll(&mut self, recipe: impl FnOnce() -> Recipe) -> Option<Result<Rebuilt>> {
        let ready = self.under_way.as_ref().and_then(|ready| ready.try_recv().ok());
        if ready.is_some() {
            self.under_way = None;
        }
        // What changes while others are being made is looked at after them.
        if self.under_way.is_none() && self.changes.try_iter().count() > 0 {
            self.under_way = Some(self.begin(recipe()));
        }
        ready
    }

    fn begin(&self, recipe: Recipe) -> mpsc::Receiver<Result<Rebuilt>> {
        let (sender, receiver) = mpsc::channel();
        let (dir, window) = (self.dir.clone(), self.window.clone());
        thread::spawn(move || {
            thread::sleep(SETTLE);
            let rebuilt = render::shader_compiler(Some(&dir)).and_then(|compiler| recipe.rebuild(&compiler));
            // A window that has been closed meanwhile waits for nothing.
            let _ = sender.send(rebuilt);
            window.request_redraw();
        });
        receiver
    }
}
