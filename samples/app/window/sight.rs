//! Whether the window is on the screen. Most window systems tell winit, and winit tells of it; of X11 it passes on only
//! that other windows cover this one, not that it was minimised or that its desktop was left.

use std::sync::{
    Arc,
    atomic::{AtomicBool, Ordering},
};

use winit::window::Window;

/// What an X server says of a window.
pub struct Sight {
    gone: Arc<AtomicBool>,
}

impl Sight {
    /// Watches `window`, and has it drawn when it goes or comes back.
    pub fn new(window: &Arc<Window>) -> Sight {
        let sight = Sight { gone: Arc::default() };
        #[cfg(all(unix, not(target_os = "macos")))]
        x11::watch(window, &sight.gone);
        #[cfg(not(all(unix, not(target_os = "macos"))))]
        let _ = window;
        sight
    }

    /// Whether nobody can see it.
    pub fn is_gone(&self) -> bool {
        self.gone.load(Ordering::Relaxed)
    }
}

#[cfg(all(unix, not(target_os = "macos")))]
mod x11 {
    use std::{
        error::Error,
        sync::{
            Arc, Weak,
            atomic::{AtomicBool, Ordering},
        },
        thread,
    };

    use winit::{
        raw_window_handle::{HasWindowHandle, RawWindowHandle},
        window::Window,
    };
    use x11rb::{
        connection::Connection,
        protocol::{
            Event,
            xproto::{AtomEnum, ChangeWindowAttributesAux, ConnectionExt, EventMask, MapState},
        },
    };

    /// Begins to watch a window of an X server, on a connection of its own: events go to each client that asks for them.
    pub fn watch(window: &Arc<Window>, gone: &Arc<AtomicBool>) {
        let id = match window.window_handle().map(|handle| handle.as_raw()) {
            Ok(RawWindowHandle::Xlib(handle)) => handle.window as u32,
            Ok(RawWindowHandle::Xcb(handle)) => handle.window.get(),
            _ => return,
        };
        let (window, gone) = (Arc::downgrade(window), Arc::downgrade(gone));
        thread::spawn(move || {
            // Where the server does not answer, the window is taken to be seen.
            if follow(id, &window, &gone).is_err()
                && let Some(gone) = gone.upgrade()
            {
                gone.store(false, Ordering::Relaxed);
            }
        });
    }

    /// Keeps `gone` true while the window, or what holds it, is not mapped or says that it is hidden: of a minimised one
    /// window managers do the first, the second, or both. Ends once nobody asks any more.
    fn follow(id: u32, window: &Weak<Window>, gone: &Weak<AtomicBool>) -> Result<(), Box<dyn Error>> {
        let (x, _) = x11rb::connect(None)?;
        let atom = |name: &str| Ok::<_, Box<dyn Error>>(x.intern_atom(false, name.as_bytes())?.reply()?.atom);
        let [manager, states, hidden] = [atom("WM_STATE")?, atom("_NET_WM_STATE")?, atom("_NET_WM_STATE_HIDDEN")?];
        let events = EventMask::STRUCTURE_NOTIFY | EventMask::VISIBILITY_CHANGE | EventMask::PROPERTY_CHANGE;
        x.change_window_attributes(id, &ChangeWindowAttributesAux::new().event_mask(events))?.check()?;
        loop {
            let mapped = x.get_window_attributes(id)?.reply()?.map_state == MapState::VIEWABLE;
            let said = x.get_property(false, id, states, AtomEnum::ATOM, 0, 64)?.reply()?;
            let hides = said.value32().is_some_and(|mut states| states.any(|state| state == hidden));
            let now = !mapped || hides;
            if tell(gone, window, now).is_none() {
                return Ok(());
            }
            // Its title changes twice a second.
            while let Event::PropertyNotify(event) = x.wait_for_event()?
                && event.atom != manager
                && event.atom != states
            {}
        }
    }

    /// None where nobody listens any more.
    fn tell(gone: &Weak<AtomicBool>, window: &Weak<Window>, now: bool) -> Option<()> {
        let (gone, window) = (gone.upgrade()?, window.upgrade()?);
        if gone.swap(now, Ordering::Relaxed) != now {
            window.request_redraw();
        }
        Some(())
    }
}
