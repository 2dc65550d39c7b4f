//! From the window system's events to what the user wants.

use glam::DVec2;
use winit::{
    event::{ElementState, KeyEvent, MouseButton, MouseScrollDelta, WindowEvent},
    keyboard::{Key, ModifiersState, NamedKey},
};

/// Printed when a window opens; `prism run --help` has the same in a sentence.
pub const KEYS: &str = "\
keys: U panel, S stage, H shell on/off, M march, X anti-aliasing, Space pause, R reset camera, F12 or P screenshot, Esc or Q quit
      D dithered start, L self-shadow, W shadow maps, A ambient occlusion; shell off: C clipped outline, G normals
mouse: left drag turns, right or middle drag (or Shift and left drag) moves sideways, wheel zooms";

/// Printed after them where there are several scenes.
pub const WALK_KEYS: &str = "scenes: N next, B back";

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
    /// The end.
    Quit,
    /// The camera turned by a drag of so many pixels.
    Turn(DVec2),
    /// The camera moved sideways by a drag of so many pixels.
    Shift(DVec2),
    /// The camera nearer by so many notches of a wheel.
    Zoom(f64),
}

/// What is held down, and where the pointer was.
#[derive(Default)]
pub struct Input {
    pointer: Option<DVec2>,
    left: bool,
    right_or_middle: bool,
    modifiers: ModifiersState,
}

impl Input {
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
                    MouseButton::Left => self.left = down,
                    MouseButton::Right | MouseButton::Middle => self.right_or_middle = down,
                    _ => {}
                }
                None
            }
            WindowEvent::CursorMoved { position, .. } => self.moved(DVec2::new(position.x, position.y)),
            WindowEvent::Focused(false) => {
                // The release of a button may go to another window.
                *self = Input::default();
                None
            }
            WindowEvent::MouseWheel { delta, .. } => Some(Wish::Zoom(notches(*delta, scale))),
            WindowEvent::PinchGesture { delta, .. } => Some(Wish::Zoom(delta * NOTCHES_PER_PINCH)),
            _ => None,
        }
        .filter(|wish| *wish != Wish::Zoom(0.0))
    }

    fn moved(&mut self, to: DVec2) -> Option<Wish> {
        let by = to - self.pointer.replace(to)?;
        if self.right_or_middle || self.left && self.modifiers.shift_key() {
            Some(Wish::Shift(by))
        } else if self.left {
            Some(Wish::Turn(by))
        } else {
            None
        }
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
        Key::Named(NamedKey::F12) => Some(Wish::Screenshot),
        Key::Character(text) => match text.to_lowercase().as_str() {
            "u" => Some(Wish::Panel),
            "s" => Some(Wish::Stage),
            "h" => Some(Wish::Shell),
            "m" => Some(Wish::March),
            "d" => Some(Wish::Dither),
            "l" => Some(Wish::SelfShadow),
            "w" => Some(Wish::ShadowMap),
            "a" => Some(Wish::AmbientOcclusion),
            "c" => Some(Wish::Silhouette),
            "g" => Some(Wish::Normals),
            "x" => Some(Wish::Samples),
            "r" => Some(Wish::ResetCamera),
            "p" => Some(Wish::Screenshot),
            "n" => Some(Wish::Next),
            "b" => Some(Wish::Back),
            "q" => Some(Wish::Quit),
            _ => None,
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
    fn wheel_and_trackpad_zoom() {
        assert_eq!(notches(MouseScrollDelta::LineDelta(0.0, 2.0), 2.0), 2.0);
        assert_eq!(notches(MouseScrollDelta::PixelDelta(PhysicalPosition::new(0.0, 80.0)), 2.0), 1.0);
    }

    #[test]
    fn every_key_that_is_printed_does_something() {
        for letter in ["S", "H", "M", "X", "D", "L", "W", "A", "C", "G", "R", "P", "Q", "N", "B"] {
            let printed = |keys: &str| keys.contains(&format!(" {letter} "));
            assert!(printed(KEYS) || printed(WALK_KEYS), "{letter}");
            assert!(wish_of(&Key::Character(letter.into())).is_some(), "{letter}");
        }
    }
}
