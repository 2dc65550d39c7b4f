//! The window's title.

use prism_engine::settings::{Normals, SelfShadow, Settings, Silhouette, Stage, View};

use super::Shown;

impl Shown<'_> {
    /// Sample, scene of several, stage, shell, march, what else is switched on, time per frame.
    pub(super) fn set_title(&self) {
        let settings = self.drawing.renderer().settings();
        let stage = match self.drawing.renderer().plan().stage {
            Some(stage) if settings.stage == Stage::Auto => format!("stage auto ({stage})"),
            Some(stage) => format!("stage {stage}"),
            None => "no shell stage".to_owned(),
        };
        let scene = match self.drawing.scenes() {
            1 => String::new(),
            _ => format!(" · {}", self.drawing.loaded().name),
        };
        let mut title = format!(
            "{}{scene} · {stage} · shell {} · march {}",
            self.job.sample.id(),
            settings.resolved_shell(),
            settings.march
        );
        title += &switched_on(settings);
        if let Some(ms) = self.frame_ms {
            title += &format!(" · {ms:.1} ms");
        }
        if let Some(figures) = &self.figures {
            title += &format!(" · {figures}");
        }
        if self.kept.is_some() {
            title += " · keeps frames";
        }
        if self.clock.paused() {
            title += " · paused";
        }
        self.window.set_title(&title);
    }
}

/// What a window's title says of the settings that are not their defaults.
fn switched_on(settings: &Settings) -> String {
    let mut text = String::new();
    let mut add = |on: bool, what: &str| {
        if on {
            text += &format!(" · {what}");
        }
    };
    add(settings.dither, "dither");
    add(settings.silhouette != Silhouette::None, &format!("silhouette {}", settings.silhouette));
    add(settings.normals != Normals::Gather, &format!("normals {}", settings.normals));
    add(settings.self_shadow != SelfShadow::Off, &format!("self-shadow {}", settings.self_shadow));
    add(settings.shadow_map, "shadow map");
    add(settings.ambient_occlusion, "ambient occlusion");
    add(settings.view != View::Shaded, &format!("view {}", settings.view));
    text
}
