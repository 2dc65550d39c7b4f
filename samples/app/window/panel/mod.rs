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

use crate::app::{surface::SurfaceArgs, timings::FrameRow};
use cost::Cost;
use tips::Tips;

/// Windows narrower than this, in logical pixels, open without it.
const ROOMY: f64 = 900.0;

/// What the panel shows of the window it is in.
pub struct Facts<'a> {
    /// The sample's name and summary.
    pub sample: [&'a str; 2],
    /// Names of its scenes, and which one is shown.
    pub scenes: (&'a [&'a str], usize),
    /// In force.
    pub settings: &'a Settings,
    /// What the scene can be drawn with.
    pub marches: &'a [March],
    /// In force.
    pub surface: &'a SurfaceArgs,
    /// The displaced materials' own scale and midlevel, where there is one.
    pub displaced: Option<[f64; 2]>,
    /// The device.
    pub device: &'a str,
    /// The last frame that was measured.
    pub latest: Option<&'a FrameRow>,
    /// Live allocations.
    pub memory: &'a [(String, u64)],
    /// Where the camera is.
    pub eye: [f64; 3],
}

/// What the user did in the panel.
#[derive(Debug)]
pub enum Action {
    /// Draws so.
    Settings(Settings),
    /// Displaces so; scenes are read again.
    Surface(SurfaceArgs),
    /// Shows this scene.
    Scene(usize),
    /// The sample's own camera.
    ResetCamera,
    /// A picture of what is seen.
    Screenshot,
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
    /// What the last action came to.
    status: String,
    /// Values under the pointer that are taken over once it lets go: each means reading scenes again.
    surface: SurfaceArgs,
}

impl Panel {
    /// For a window that shows pictures of `format`.
    pub fn new(window: &Window, ctx: &Context, format: vk::Format, in_flight: usize) -> Result<Panel> {
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
            open: f64::from(window.inner_size().width) >= ROOMY * scale,
            fault: None,
            status: String::new(),
            surface: SurfaceArgs::default(),
        })
    }

    /// Whether it is to be seen.
    pub fn is_open(&self) -> bool {
        self.open
    }

    /// Whether it, or a shader's fault, is to be seen.
    pub fn shows(&self) -> bool {
        self.open || self.fault.is_some()
    }

    /// Shows it, or puts it away.
    pub fn toggle(&mut self) {
        self.open = !self.open;
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

    /// Puts text on the clipboard.
    pub fn copy(&mut self, text: String) {
        self.input.set_clipboard_text(text);
    }

    /// Lets the panel see an event first. Whether it was for the panel alone, and whether a new frame is due.
    pub fn take(&mut self, window: &Window, event: &WindowEvent) -> (bool, bool) {
        if !self.open && !matches!(event, WindowEvent::ScaleFactorChanged { .. }) {
            return (false, false);
        }
        let response = self.input.on_window_event(window, event);
        (response.consumed, response.repaint && !matches!(event, WindowEvent::RedrawRequested))
    }

    /// Lays it out; nothing where it is closed.
    pub fn lay_out(&mut self, window: &Arc<Window>, facts: &Facts<'_>) -> Result<Option<Laid>> {
        if !self.open && self.fault.is_none() {
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
