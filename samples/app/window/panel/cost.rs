//! What a frame costs: GPU time of each pass as a rolling graph, what it counted, and the memory by name.

use std::collections::VecDeque;

use egui::{CollapsingHeader, Color32, Grid, Pos2, Rect, Sense, Stroke, Ui, Vec2, pos2};

use super::Facts;
use crate::app::timings::FrameRow;

/// Frames that the graph shows.
const SHOWN: usize = 160;
/// Allocations that are listed.
const LISTED: usize = 24;
/// Okabe and Ito's colours, which the colour-blind tell apart.
const COLOURS: [Color32; 7] = [
    Color32::from_rgb(230, 159, 0),
    Color32::from_rgb(86, 180, 233),
    Color32::from_rgb(0, 158, 115),
    Color32::from_rgb(240, 228, 66),
    Color32::from_rgb(0, 114, 178),
    Color32::from_rgb(213, 94, 0),
    Color32::from_rgb(204, 121, 167),
];

/// The last frames.
#[derive(Default)]
pub struct Cost {
    frames: VecDeque<FrameRow>,
}

impl Cost {
    /// Takes the last measured frame in, if it is a new one.
    pub fn add(&mut self, latest: Option<&FrameRow>) {
        let Some(latest) = latest else { return };
        if self.frames.back().is_some_and(|last| last.frame == latest.frame) {
            return;
        }
        if self.frames.len() == SHOWN {
            self.frames.pop_front();
        }
        self.frames.push_back(latest.clone());
    }

    /// Shows it.
    pub fn show(&self, ui: &mut Ui, facts: &Facts<'_>) {
        CollapsingHeader::new("cost").default_open(true).show(ui, |ui| {
            self.graph(ui);
            self.passes(ui);
            ui.label(facts.device);
        });
        let total: u64 = facts.memory.iter().map(|(_, bytes)| bytes).sum();
        CollapsingHeader::new(format!("memory {}", size(total))).id_salt("memory").show(ui, |ui| {
            Grid::new("allocations").striped(true).show(ui, |ui| {
                for (name, bytes) in facts.memory.iter().take(LISTED) {
                    ui.label(if name.is_empty() { "panel" } else { name });
                    ui.label(size(*bytes));
                    ui.end_row();
                }
            });
        });
    }

    /// GPU time over the last frames, the passes one on the other.
    fn graph(&self, ui: &mut Ui) {
        let (area, _) = ui.allocate_exact_size(Vec2::new(ui.available_width(), 70.0), Sense::hover());
        let painter = ui.painter_at(area);
        painter.rect_filled(area, 2.0, Color32::from_black_alpha(160));
        let total = |frame: &FrameRow| frame.passes.iter().filter_map(|pass| pass.gpu_ms).sum::<f64>();
        let most = self.frames.iter().map(total).fold(0.0, f64::max);
        if most <= 0.0 {
            return;
        }
        let width = area.width() / SHOWN as f32;
        let tall = |ms: f64| (ms / most) as f32 * (area.height() - 14.0);
        for (i, frame) in self.frames.iter().enumerate() {
            let x = area.right() - width * (self.frames.len() - i) as f32;
            let mut floor = area.bottom();
            for (k, pass) in frame.passes.iter().enumerate() {
                let top = floor - tall(pass.gpu_ms.unwrap_or_default());
                let bar = Rect::from_min_max(pos2(x, top), pos2(x + width.max(1.0), floor));
                painter.rect_filled(bar, 0.0, COLOURS[k % COLOURS.len()]);
                floor = top;
            }
        }
        let line = area.bottom() - tall(most);
        let ends = [Pos2::new(area.left(), line), Pos2::new(area.right(), line)];
        painter.line_segment(ends, Stroke::new(1.0, Color32::from_gray(120)));
        let text = format!("{most:.2} ms");
        let font = egui::FontId::proportional(10.0);
        painter.text(area.left_top() + Vec2::new(4.0, 1.0), egui::Align2::LEFT_TOP, text, font, Color32::WHITE);
    }

    /// The last frame's passes: time, fragments, primitives.
    fn passes(&self, ui: &mut Ui) {
        let Some(last) = self.frames.back() else { return };
        Grid::new("passes").striped(true).show(ui, |ui| {
            for title in ["pass", "ms", "fragments", "primitives"] {
                ui.strong(title);
            }
            ui.end_row();
            for (k, pass) in last.passes.iter().enumerate() {
                let unknown = || "unknown".to_owned();
                ui.colored_label(COLOURS[k % COLOURS.len()], &pass.pass);
                ui.label(pass.gpu_ms.map_or_else(unknown, |ms| format!("{ms:.2}")));
                ui.label(pass.invocations.map_or_else(unknown, |count| count.to_string()));
                ui.label(pass.primitives.map_or_else(unknown, |count| count.to_string()));
                ui.end_row();
            }
        });
    }
}

fn size(bytes: u64) -> String {
    match bytes {
        0..1024 => format!("{bytes} B"),
        1024..1_048_576 => format!("{:.1} KiB", bytes as f64 / 1024.0),
        _ => format!("{:.1} MiB", bytes as f64 / 1_048_576.0),
    }
}
