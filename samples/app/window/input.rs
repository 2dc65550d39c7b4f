//! From the window system's events to what the user wants.

use glam::DVec2;
use prism_engine::settings::View;
use winit::{
    event::{ElementState, KeyEvent, MouseButton, MouseScrollDelta, WindowEvent},
    keyboard::{Key, ModifiersState, NamedKey},
};

/// Printed when a window opens; `prism run --help` has the same in a sentence.
pub const KEYS: &str = "\
keys: U panel, S stage, H shell on/off, M march, X anti-aliasing, Space pause, R reset camera, F12 or P screenshot, I every frame from now on, or no more, Esc or Q quit
      V next view, 1 to 9 and 0 the first ten views, E error against the reference, K compare two settings
      F11 or F RenderDoc takes the next frame, where it is loaded
      D dithered start, L self-shadow, W shadow maps, A ambient occlusion; shell off: C clipped outline, G normals
mouse: a click probes a pixel's ray, left drag turns, right or middle drag (or Shift and left drag) moves sideways, wheel zooms";

/// Printed after them where there are several scenes.
pub const WALK_KEYS: &str = "scenes: N next, B back";

/// Pixels that a press may move and still be a click, before the screen's scale.
const CLICK: f64 = 3.0;
/// How near to the line between two pictures a press holds it, likewise.
const GRIP: f64 = 6.0;
/// Pixels of a trackpad's scroll that count as one notch of a wheel, before the screen's scale.
const PIXELS_PER_NOTCH: f64 = 40.0;
/// A pinch to twice the size comes as near as this many notches: 0.9^6.6 ≈ 1/2.
const NOTCHES_PER_PINCH: f64 = 6.6;

/// One thing that the user wants.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Wish {
    /// The panel shown or put away.
    Panel,
    /// The next stage.
    Stage,
    /// The shell on or off.
    Shell,
    /// The next march.
    March,
    /// The next view.
    NextView,
    /// This view.
    View(View),
    /// Dithered starts on or off.
    Dither,
    /// The next self-shadowing.
    SelfShadow,
    /// Shadow maps on or off.
    ShadowMap,
    /// Ambient occlusion on or off.
    AmbientOcclusion,
    /// The next clipping of the base surface.
    Silhouette,
    /// The next shading normals of the base surface.
    Normals,
    /// One sample a pixel, or four.
    Samples,
    /// The sample's time stopped, or going on.
    Pause,
    /// The next scene.
    Next,
    /// The scene before.
    Back,
    /// The sample's own camera.
    ResetCamera,
    /// A picture of what is seen.
    Screenshot,
    /// Every frame as a picture from now on, or no more.
    Sequence,
    /// The next frame, for RenderDoc.
    Capture,
    /// The end.
    Quit,
    /// The camera turned by a drag of so many pixels.
    Turn(DVec2),
    /// The camera moved sideways by a drag of so many pixels.
    Shift(DVec2),
    /// A second picture beside the first, with the settings in force, or no more.
    Compare,
    /// The line between the two at this column.
    MoveLine(f64),
    /// What the ray of this pixel does.
    Probe(DVec2),
    /// The camera nearer by so many notches of a wheel.
    Zoom(f64),
}

/// The left button, down.
struct Press {
    at: DVec2,
    /// It has moved too far for a click.
    drags: bool,
    /// It began on the line between two pictures.
    holds_line: bool,
}

/// What is held down, and where the pointer was.
#[derive(Default)]
pub struct Input {
    pointer: Option<DVec2>,
    left: Option<Press>,
    /// Column of the line between two pictures.
    line: Option<f64>,
    right_or_middle: bool,
    modifiers: ModifiersState,
}

impl Input {
    /// Where the line between two pictures is, if there are two.
    pub fn set_line(&mut self, column: Option<f64>) {
        self.line = column;
    }

    /// What this event asks for, if anything. `scale` is the screen's, in pixels per logical pixel.
    pub fn wish(&mut self, event: &WindowEvent, scale: f64) -> Option<Wish> {
        match event {
            WindowEvent::CloseRequested => Some(Wish::Quit),
            WindowEvent::KeyboardInput { event, .. } => key(event),
            WindowEvent::ModifiersChanged(modifiers) => {
                self.modifiers = modifiers.state();
                None
            }
            WindowEvent::MouseInput { state, button, .. } => {
                let down = *state == ElementState::Pressed;
                match button {
                    MouseButton::Left if down => {
                        let at = self.pointer?;
                        let holds_line = self.line.is_some_and(|line| (at.x - line).abs() <= GRIP * scale);
                        self.left = Some(Press { at, drags: false, holds_line });
                    }
                    MouseButton::Left => {
                        let press = self.left.take()?;
                        return (!press.drags && !press.holds_line).then_some(Wish::Probe(press.at));
                    }
                    MouseButton::Right | MouseButton::Middle => self.right_or_middle = down,
                    _ => {}
                }
                None
            }
            WindowEvent::CursorMoved { position, .. } => self.moved(DVec2::new(position.x, position.y), scale),
            WindowEvent::Focused(false) => {
                // The release of a button may go to another window.
                *self = Input { line: self.line, ..Input::default() };
                None
            }
            WindowEvent::MouseWheel { delta, .. } => Some(Wish::Zoom(notches(*delta, scale))),
            WindowEvent::PinchGesture { delta, .. } => Some(Wish::Zoom(delta * NOTCHES_PER_PINCH)),
            _ => None,
        }
        .filter(|wish| *wish != Wish::Zoom(0.0))
    }

    fn moved(&mut self, to: DVec2, scale: f64) -> Option<Wish> {
        let mut by = to - self.pointer.replace(to)?;
        if self.right_or_middle {
            return Some(Wish::Shift(by));
        }
        let press = self.left.as_mut()?;
        if press.holds_line {
            return Some(Wish::MoveLine(to.x));
        }
        if !press.drags {
            if to.distance(press.at) <= CLICK * scale {
                return None;
            }
            press.drags = true;
            by = to - press.at;
        }
        Some(if self.modifiers.shift_key() { Wish::Shift(by) } else { Wish::Turn(by) })
    }
}

fn key(event: &KeyEvent) -> Option<Wish> {
    if event.state != ElementState::Pressed || event.repeat {
        return None;
    }
    wish_of(&event.logical_key)
}

/// By the letter that the layout puts on the key: what is printed on it is what is meant.
fn wish_of(key: &Key) -> Option<Wish> {
    match key {
        Key::Named(NamedKey::Space) => Some(Wish::Pause),
        Key::Named(NamedKey::Escape) => Some(Wish::Quit),
        Key::Named(NamedKey::F1) => Some(Wish::Panel),
        Key::Named(NamedKey::F11) => Some(Wish::Capture),
        Key::Named(NamedKey::F12) => Some(Wish::Screenshot),
        Key::Character(text) => match text.to_lowercase().as_str() {
            "u" => Some(Wish::Panel),
            "s" => Some(Wish::Stage),
            "h" => Some(Wish::Shell),
            "m" => Some(Wish::March),
            "v" => Some(Wish::NextView),
            "k" => Some(Wish::Compare),
            "e" => Some(Wish::View(View::Error)),
            "d" => Some(Wish::Dither),
            "l" => Some(Wish::SelfShadow),
            "w" => Some(Wish::ShadowMap),
            "a" => Some(Wish::AmbientOcclusion),
            "c" => Some(Wish::Silhouette),
            "g" => Some(Wish::Normals),
            "x" => Some(Wish::Samples),
            "r" => Some(Wish::ResetCamera),
            "p" => Some(Wish::Screenshot),
            "f" => Some(Wish::Capture),
            "i" => Some(Wish::Sequence),
            "n" => Some(Wish::Next),
            "b" => Some(Wish::Back),
            "q" => Some(Wish::Quit),
            // The first view is 1, the tenth 0.
            digit => {
                let number: usize = digit.parse().ok().filter(|number| *number < 10)?;
                View::ALL.get((number + 9) % 10).copied().map(Wish::View)
            }
        },
        _ => None,
    }
}

fn notches(delta: MouseScrollDelta, scale: f64) -> f64 {
    match delta {
        MouseScrollDelta::LineDelta(_, lines) => f64::from(lines),
        MouseScrollDelta::PixelDelta(pixels) => pixels.y / (PIXELS_PER_NOTCH * scale),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use winit::{dpi::PhysicalPosition, event::DeviceId};

    fn moved(x: f64, y: f64) -> WindowEvent {
        WindowEvent::CursorMoved { device_id: DeviceId::dummy(), position: PhysicalPosition::new(x, y) }
    }

    fn button(button: MouseButton, state: ElementState) -> WindowEvent {
        WindowEvent::MouseInput { device_id: DeviceId::dummy(), state, button }
    }

    #[test]
    fn a_drag_is_what_moves_while_a_button_is_down() {
        let mut input = Input::default();
        assert_eq!(input.wish(&moved(10.0, 10.0), 1.0), None);
        assert_eq!(input.wish(&moved(20.0, 10.0), 1.0), None, "no button");
        input.wish(&button(MouseButton::Left, ElementState::Pressed), 1.0);
        assert_eq!(input.wish(&moved(25.0, 8.0), 1.0), Some(Wish::Turn(DVec2::new(5.0, -2.0))));
        input.wish(&button(MouseButton::Right, ElementState::Pressed), 1.0);
        assert_eq!(input.wish(&moved(26.0, 8.0), 1.0), Some(Wish::Shift(DVec2::new(1.0, 0.0))));
        input.wish(&WindowEvent::Focused(false), 1.0);
        assert_eq!(input.wish(&moved(0.0, 0.0), 1.0), None, "released elsewhere");
    }

    #[test]
    fn a_press_that_hardly_moves_is_a_click_and_one_on_the_line_moves_it() {
        let mut input = Input::default();
        input.wish(&moved(50.0, 10.0), 1.0);
        input.wish(&button(MouseButton::Left, ElementState::Pressed), 1.0);
        assert_eq!(input.wish(&moved(52.0, 10.0), 1.0), None, "a hand trembles");
        let released = button(MouseButton::Left, ElementState::Released);
        assert_eq!(input.wish(&released, 1.0), Some(Wish::Probe(DVec2::new(50.0, 10.0))));
        input.set_line(Some(55.0));
        input.wish(&button(MouseButton::Left, ElementState::Pressed), 1.0);
        assert_eq!(input.wish(&moved(80.0, 30.0), 1.0), Some(Wish::MoveLine(80.0)));
        assert_eq!(input.wish(&released, 1.0), None);
    }

    #[test]
    fn wheel_and_trackpad_zoom() {
        assert_eq!(notches(MouseScrollDelta::LineDelta(0.0, 2.0), 2.0), 2.0);
        assert_eq!(notches(MouseScrollDelta::PixelDelta(PhysicalPosition::new(0.0, 80.0)), 2.0), 1.0);
    }

    #[test]
    fn every_key_that_is_printed_does_something() {
        for letter in
            ["S", "H", "M", "V", "E", "K", "X", "F", "D", "L", "W", "A", "C", "G", "R", "P", "I", "Q", "N", "B"]
        {
            let printed = |keys: &str| keys.contains(&format!(" {letter} "));
            assert!(printed(KEYS) || printed(WALK_KEYS), "{letter}");
            assert!(wish_of(&Key::Character(letter.into())).is_some(), "{letter}");
        }
    }
}
