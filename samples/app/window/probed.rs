//! A clicked pixel: its ray is probed beside the frames, and drawn over the picture.

use std::{
    sync::{Arc, mpsc},
    thread,
};

use egui::{Color32, FontId, Pos2, Rect, Sense, Shape, Stroke, Ui, Vec2, pos2};
use prism_engine::{
    error::Result,
    scene::{Camera, Scene},
    settings::Settings,
};
use winit::window::Window;

use crate::app::probe::{self, Pixel, sketch::Sketch};

/// The ray.
const RAY: Color32 = Color32::from_rgb(215, 38, 61);
/// The surface.
const SURFACE: Color32 = Color32::from_rgb(200, 182, 166);
/// Borders of prisms and triangles.
const FAINT: Color32 = Color32::from_gray(120);

/// The last click.
#[derive(Default)]
pub struct Probed {
    under_way: Option<mpsc::Receiver<Result<Sketch>>>,
    shown: Option<Sketch>,
}

impl Probed {
    /// Probes a pixel, and has `window` drawn when it is done.
    pub fn begin(
        &mut self,
        name: String,
        scene: Arc<Scene>,
        camera: Camera,
        pixel: Pixel,
        settings: Settings,
        window: Arc<Window>,
    ) {
        let (sender, receiver) = mpsc::channel();
        self.under_way = Some(receiver);
        thread::spawn(move || {
            // A window that has been closed meanwhile waits for nothing.
            let _ = sender.send(probe::sketch(&name, &scene, &camera, pixel, &settings));
            window.request_redraw();
        });
    }

    /// Takes what has become ready: whether there is news, or why there is nothing to show.
    pub fn collect(&mut self) -> Result<bool> {
        let Some(ready) = self.under_way.as_ref().and_then(|ready| ready.try_recv().ok()) else { return Ok(false) };
        self.under_way = None;
        self.shown = Some(ready?);
        Ok(true)
    }

    /// What is to be seen.
    pub fn sketch(&self) -> Option<&Sketch> {
        self.shown.as_ref()
    }

    /// Puts it away.
    pub fn close(&mut self) {
        *self = Probed::default();
    }
}

/// What the user did with the drawing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Done {
    /// Nothing.
    Nothing,
    /// Wants it as a file.
    Save,
    /// Has seen enough.
    Close,
}

/// Draws it in a window of its own.
pub fn show(ui: &Ui, sketch: &Sketch) -> Done {
    let (mut open, mut done) = (true, Done::Nothing);
    let window = egui::Window::new(&sketch.title).id("probe".into()).open(&mut open).resizable(false);
    window.anchor(egui::Align2::RIGHT_BOTTOM, Vec2::splat(-8.0)).show(ui.ctx(), |ui| {
        ui.horizontal(|ui| {
            let (area, _) = ui.allocate_exact_size(Vec2::new(300.0, 180.0), Sense::hover());
            profile(ui, area, sketch);
            let (area, _) = ui.allocate_exact_size(Vec2::splat(180.0), Sense::hover());
            map(ui, area, sketch);
        });
        egui::Grid::new("marches").striped(true).show(ui, |ui| {
            for march in &sketch.marches {
                ui.colored_label(hex(march.colour), march.name);
                ui.label(&march.verdict);
                ui.end_row();
            }
        });
        if ui.button("save as SVG").on_hover_text("What prism probe draws of this pixel.").clicked() {
            done = Done::Save;
        }
    });
    if open { done } else { Done::Close }
}

/// The ray's level against the surface's, over the way.
fn profile(ui: &Ui, area: Rect, sketch: &Sketch) {
    let painter = ui.painter_at(area);
    painter.rect_filled(area, 2.0, Color32::from_black_alpha(200));
    let [low, high] = sketch.profile;
    let place = |[x, y]: [f64; 2]| {
        let share = |v: f64, k: usize| ((v - low[k]) / (high[k] - low[k])) as f32;
        pos2(area.left() + share(x, 0) * area.width(), area.bottom() - share(y, 1) * area.height())
    };
    let line = |points: &[[f64; 2]], colour, width| {
        painter.add(Shape::line(points.iter().map(|p| place(*p)).collect(), Stroke::new(width, colour)));
    };
    for prism in &sketch.prisms {
        line(&prism.surface, SURFACE, 2.0);
        line(&prism.ray, RAY, 1.5);
        if let Some(end) = prism.ray.last() {
            painter.vline(place(*end).x, area.y_range(), Stroke::new(0.5, FAINT));
        }
    }
    for march in sketch.marches.iter().rev() {
        for sample in &march.samples {
            painter.circle_stroke(place(*sample), 2.0, Stroke::new(1.0, hex(march.colour)));
        }
    }
    for march in &sketch.marches {
        if let Some(hit) = march.hit {
            painter.circle_filled(place(hit), 4.0, hex(march.colour));
        }
    }
    painter.circle_stroke(place(sketch.hit), 7.0, Stroke::new(2.0, Color32::WHITE));
    words(ui, area, &format!("level over {:.4} world units; the ring is the true hit", high[0] - low[0]));
}

/// The ray's curved path over the texture, and the base triangles that it passes.
fn map(ui: &Ui, area: Rect, sketch: &Sketch) {
    let painter = ui.painter_at(area);
    painter.rect_filled(area, 2.0, Color32::from_black_alpha(200));
    let points = || sketch.prisms.iter().flat_map(|prism| &prism.path);
    let range = |k: usize| points().map(|p| p[k]).fold([f64::MAX, f64::MIN], |[a, b], v| [a.min(v), b.max(v)]);
    let [u, v] = [range(0), range(1)];
    let side = 1.3 * (u[1] - u[0]).max(v[1] - v[0]).max(1e-9);
    let middle = [0.5 * (u[0] + u[1]), 0.5 * (v[0] + v[1])];
    let place = |p: [f64; 2]| -> Pos2 {
        let share = |k: usize| (0.5 + (p[k] - middle[k]) / side) as f32;
        pos2(area.left() + share(0) * area.width(), area.top() + share(1) * area.height())
    };
    for prism in &sketch.prisms {
        let corners = prism.corners.map(place).to_vec();
        painter.add(Shape::closed_line(corners, Stroke::new(1.0, FAINT)));
    }
    for prism in &sketch.prisms {
        painter.add(Shape::line(prism.path.iter().map(|p| place(*p)).collect(), Stroke::new(2.0, RAY)));
    }
    painter.circle_stroke(place(sketch.hit_uv), 6.0, Stroke::new(2.0, Color32::WHITE));
    words(ui, area, "its path over the texture");
}

fn words(ui: &Ui, area: Rect, text: &str) {
    let at = area.left_top() + Vec2::new(4.0, 2.0);
    ui.painter_at(area).text(at, egui::Align2::LEFT_TOP, text, FontId::proportional(10.0), Color32::WHITE);
}

fn hex(colour: &str) -> Color32 {
    // The drawing's inks are for paper: those that are dark there are light here.
    let colour = Color32::from_hex(colour).unwrap_or(Color32::WHITE);
    colour.lerp_to_gamma(Color32::WHITE, 0.35)
}
