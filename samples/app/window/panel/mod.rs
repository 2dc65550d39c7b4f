//! The panel over the picture: every control of the command line, what a frame costs, and the words that show it again.

mod controls;
mod cost;
mod tips;

use std::{sync::Arc, time::Duration};

use egui::{ClippedPrimitive, Color32, Panel as Side, RichText, ScrollArea, ViewportId};
use prism_engine::{
    error::Result,
    gpu::{CommandEncoder, Context, Image, Overlay, vk},
    settings::{March, Settings},
};
use winit::{event::WindowEvent, window::Window};

use super::probed::{self, Done};
use crate::app::{cli::CameraArgs, probe::sketch::Sketch, sample::Sample, surface::SurfaceArgs, timings::FrameRow};
use cost::Cost;
use tips::Tips;

/// Windows narrower than this, in logical pixels, open without it.
const ROOMY: f64 = 900.0;

/// What the panel shows of the window it is in.
pub struct Facts<'a> {
    /// What is shown.
    pub sample: &'a dyn Sample,
    /// What the user may go on to, the sample itself among them.
    pub samples: &'a [&'a dyn Sample],
    /// Names of its scenes, and which one is shown.
    pub scenes: (&'a [&'a str], usize),
    /// In force.
    pub settings: &'a Settings,
    /// What the scene can be drawn with.
    pub marches: &'a [March],
    /// Whether it may be shown otherwise than shaded.
    pub views: bool,
    /// In force.
    pub surface: &'a SurfaceArgs,
    /// The displaced materials' own scale and midlevel, where there is one.
    pub displaced: Option<[f64; 2]>,
    /// The device.
    pub device: &'a str,
    /// The last frame that was measured.
    pub latest: Option<&'a FrameRow>,
    /// Of a comparison: the line's column, and the second picture's GPU time in milliseconds once it is known.
    pub split: Option<(u32, Option<f64>)>,
    /// The ray of the pixel that was clicked.
    pub probed: Option<&'a Sketch>,
    /// Live allocations.
    pub memory: &'a [(String, u64)],
    /// Degrees of the sun, where a light is one; see [`crate::app::light::LightArgs::sun`].
    pub sun: Option<[f32; 2]>,
    /// Whether the lights are the scene's own: a sample may move them.
    pub lights_fixed: bool,
    /// Whether a texture says what is occluded.
    pub occluded: bool,
    /// Whether every frame is kept.
    pub keeps_frames: bool,
    /// Where the camera is.
    pub camera: CameraArgs,
}

/// What the user did in the panel.
#[derive(Debug)]
pub enum Action {
    /// Shows the sample of this name.
    Sample(&'static str),
    /// Draws so.
    Settings(Settings),
    /// Displaces so; scenes are read again.
    Surface(SurfaceArgs),
    /// Shows this scene.
    Scene(usize),
    /// The sample's own camera.
    ResetCamera,
    /// This camera.
    Camera(CameraArgs),
    /// A second picture with the settings in force beside the first, or no more.
    Compare(bool),
    /// Exchanges the two's settings.
    Swap,
    /// The drawing of a pixel's ray into a file, or put away.
    Probe(Done),
    /// A picture of what is seen.
    Screenshot,
    /// Every frame as a picture, or no more.
    Sequence,
    /// The `prism` call of what is seen, to the clipboard.
    CopyLine,
    /// Settings and camera into a file, and out of it.
    SaveView,
    LoadView,
}

/// A panel that was laid out for the next frame.
pub struct Laid {
    primitives: Vec<ClippedPrimitive>,
    pixels_per_point: f32,
    /// When it wants to be laid out again without the user's doing; at once where it is 0.
    pub repaint_after: Duration,
    /// What the user did.
    pub actions: Vec<Action>,
}

/// The panel of a window.
pub struct Panel {
    egui: egui::Context,
    input: egui_winit::State,
    overlay: Overlay,
    tips: Tips,
    cost: Cost,
    open: bool,
    /// Why the shaders on disk are not those in use; shown whether the panel is open or not.
    fault: Option<String>,
    /// Whether a probe's drawing is there to be clicked on.
    asks: bool,
    /// What the user waits for; shown like a fault.
    note: Option<String>,
    /// What the last action came to.
    status: String,
    /// Values under the pointer that are taken over once it lets go: each means reading scenes again.
    surface: SurfaceArgs,
}

impl Panel {
    /// For a window that shows pictures of `format`; where `open` does not say it, its width does.
    pub fn new(
        window: &Window,
        ctx: &Context,
        format: vk::Format,
        in_flight: usize,
        open: Option<bool>,
    ) -> Result<Panel> {
        let egui = egui::Context::default();
        egui.set_visuals(egui::Visuals::dark());
        let scale = window.scale_factor();
        let side = ctx.max_image_2d() as usize;
        let input =
            egui_winit::State::new(egui.clone(), ViewportId::ROOT, window, Some(scale as f32), None, Some(side));
        Ok(Panel {
            egui,
            input,
            overlay: Overlay::new(ctx, format, in_flight)?,
            tips: Tips::new(),
            cost: Cost::default(),
            open: open.unwrap_or(f64::from(window.inner_size().width) >= ROOMY * scale),
            fault: None,
            note: None,
            asks: false,
            status: String::new(),
            surface: SurfaceArgs::default(),
        })
    }

    /// Whether it is to be seen.
    pub fn is_open(&self) -> bool {
        self.open
    }

    /// Whether it, a shader's fault, or what is waited for is to be seen.
    pub fn shows(&self) -> bool {
        self.open || self.fault.is_some() || self.note.is_some()
    }

    /// Shows what the user waits for, or no more.
    pub fn set_note(&mut self, note: Option<String>) {
        self.note = note;
    }

    /// Shows it, or puts it away.
    pub fn toggle(&mut self) {
        self.open = !self.open;
        // Nothing told it of the pointer meanwhile.
        self.input.egui_input_mut().events.push(egui::Event::PointerGone);
        // It forgets the pointer one frame later.
        self.egui.request_repaint();
    }

    /// Shows why the shaders on disk are not those in use, or that they are.
    pub fn set_fault(&mut self, fault: Option<String>) {
        self.fault = fault;
        // The first frame only finds out how tall the text is.
        self.egui.request_repaint();
    }

    /// Tells the user what came of an action.
    pub fn tell(&mut self, status: impl std::fmt::Display) {
        self.status = status.to_string();
    }

    /// Wants one more frame.
    pub fn repaint(&self) {
        self.egui.request_repaint();
    }

    /// Puts text on the clipboard.
    pub fn copy(&mut self, text: String) {
        self.input.set_clipboard_text(text);
    }

    /// Lets the panel see an event first. Whether it was for the panel alone, and whether a new frame is due.
    pub fn take(&mut self, window: &Window, event: &WindowEvent) -> (bool, bool) {
        if !self.open && !self.asks && !matches!(event, WindowEvent::ScaleFactorChanged { .. }) {
            return (false, false);
        }
        let response = self.input.on_window_event(window, event);
        (response.consumed, response.repaint && !matches!(event, WindowEvent::RedrawRequested))
    }

    fn wanted(&self, facts: &Facts<'_>) -> bool {
        self.shows() || facts.split.is_some() || facts.probed.is_some()
    }

    /// Lays it out; nothing where it is closed.
    pub fn lay_out(&mut self, window: &Arc<Window>, facts: &Facts<'_>) -> Result<Option<Laid>> {
        self.asks = facts.probed.is_some();
        if !self.wanted(facts) {
            return Ok(None);
        }
        self.cost.add(facts.latest);
        let input = self.input.take_egui_input(window);
        let egui = self.egui.clone();
        let mut actions = Vec::new();
        let output = egui.run_ui(input, |ui| {
            if let Some(fault) = &self.fault {
                Side::bottom("fault")
                    .show(ui, |ui| ui.colored_label(Color32::LIGHT_RED, RichText::new(fault).monospace()));
            }
            if let Some(sketch) = facts.probed {
                match probed::show(ui, sketch) {
                    Done::Nothing => {}
                    done => actions.push(Action::Probe(done)),
                }
            }
            if let Some((column, second)) = facts.split {
                line(ui, column, [facts.latest.and_then(FrameRow::gpu_ms), second]);
            }
            if let Some(note) = &self.note {
                Side::bottom("note").show(ui, |ui| ui.label(note));
            }
            if !self.open {
                return;
            }
            Side::left("panel").default_size(290.0).show(ui, |ui| {
                ScrollArea::vertical().show(ui, |ui| {
                    controls::show(ui, facts, &self.tips, &mut self.surface, &mut actions);
                    self.cost.show(ui, facts);
                    if !self.status.is_empty() {
                        ui.separator();
                        ui.label(&self.status);
                    }
                });
            });
        });
        self.input.handle_platform_output(window, output.platform_output);
        self.overlay.update(output.textures_delta)?;
        let root = output.viewport_output.get(&ViewportId::ROOT);
        Ok(Some(Laid {
            primitives: egui.tessellate(output.shapes, output.pixels_per_point),
            pixels_per_point: output.pixels_per_point,
            repaint_after: root.map_or(Duration::MAX, |root| root.repaint_delay),
            actions,
        }))
    }

    /// Draws it over `target`, at [`prism_engine::gpu::Access::COLOR_WRITE`].
    pub fn record(&mut self, cmd: &mut CommandEncoder, target: &Image, laid: &Laid) -> Result<()> {
        self.overlay.record(cmd, target, laid.pixels_per_point, &laid.primitives)
    }
}

/// The line between two pictures, and the GPU time of each beside it.
fn line(ui: &egui::Ui, column: u32, times: [Option<f64>; 2]) {
    let painter = ui.ctx().layer_painter(egui::LayerId::background());
    let area = ui.ctx().content_rect();
    let x = column as f32 / ui.ctx().pixels_per_point();
    painter.vline(x, area.y_range(), egui::Stroke::new(2.0, Color32::WHITE));
    let sides = [(egui::Align2::RIGHT_TOP, -8.0, "A"), (egui::Align2::LEFT_TOP, 8.0, "B")];
    for ((align, aside, name), time) in sides.into_iter().zip(times) {
        let text = time.map_or_else(|| name.to_owned(), |ms| format!("{name} {ms:.2} ms"));
        let at = egui::pos2(x + aside, area.top() + 6.0);
        let font = egui::FontId::proportional(14.0);
        let shown = painter.layout_no_wrap(text, font, Color32::WHITE);
        let place = align.anchor_size(at, shown.size());
        painter.rect_filled(place.expand(3.0), 2.0, Color32::from_black_alpha(170));
        painter.galley(place.min, shown, Color32::WHITE);
    }
}
