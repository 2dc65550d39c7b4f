//! The controls. What the command line would refuse cannot be reached: see [`switch::fitting`].

use std::fmt::Display;

use egui::{ComboBox, DragValue, Response, Slider, Ui};
use prism_engine::render::plan;
use prism_engine::settings::{
    DepthPrepass, March, Normals, SelfShadow, Settings, Shell, Silhouette, Stage, Tangents, View, VisibilityBuffer,
};

use super::{Action, Facts, tips::Tips};
use crate::app::{
    cli::CameraArgs,
    light::LightArgs,
    surface::{HeightLod, SurfaceArgs},
    window::switch,
};

/// The flags that have a control.
#[cfg(test)]
pub const FLAGS: &[&str] = &[
    "scene",
    "view",
    "stage",
    "shell",
    "march",
    "min-steps",
    "max-steps",
    "refine-steps",
    "dither",
    "height-scale",
    "midlevel",
    "height-lod",
    "depth-offset",
    "silhouette",
    "normals",
    "tangents",
    "lod-fade",
    "self-shadow",
    "shadow-softness",
    "shadow-steps",
    "shadow-map",
    "occlusion-light",
    "sun",
    "light-intensity",
    "target",
    "fov-y",
    "shadow-map-size",
    "cascades",
    "ambient-occlusion",
    "msaa",
    "depth-prepass",
    "visibility-buffer",
    "eye",
];

/// Shows all of them. `surface`: the values of the displaced materials while the pointer moves them.
pub fn show(ui: &mut Ui, facts: &Facts<'_>, tips: &Tips, surface: &mut SurfaceArgs, actions: &mut Vec<Action>) {
    ui.heading(facts.sample.id()).on_hover_text(facts.sample.summary());
    ui.horizontal_wrapped(|ui| {
        let mut button = |ui: &mut Ui, text: &str, tip: &str, action: Action| {
            if ui.button(text).on_hover_text(tip).clicked() {
                actions.push(action);
            }
        };
        button(ui, "copy as command line", "Copies the prism call that shows what is on screen.", Action::CopyLine);
        button(ui, "screenshot", "Saves what is seen as a PNG in the current folder.", Action::Screenshot);
        button(ui, "save view", "Keeps settings and camera in a JSON file in the current folder.", Action::SaveView);
        button(ui, "load view", "Takes settings and camera from the last such file.", Action::LoadView);
        let (text, tip) = match facts.keeps_frames {
            false => ("keep frames", "Saves every frame from now on as a PNG in the current folder."),
            true => ("keep no more", "Saves no more frames."),
        };
        button(ui, text, tip, Action::Sequence);
    });
    let mut chosen = facts.sample.id();
    if !facts.samples.is_empty() {
        let list = ComboBox::from_label("sample").selected_text(chosen).show_ui(ui, |ui| {
            for sample in facts.samples {
                ui.selectable_value(&mut chosen, sample.id(), sample.id()).on_hover_text(sample.summary());
            }
        });
        list.response.on_hover_text("Shows another sample, as its own settings have it.\nprism run SAMPLE");
    }
    if chosen != facts.sample.id() {
        actions.push(Action::Sample(chosen));
    }
    let (scenes, current) = facts.scenes;
    if scenes.len() > 1 {
        let mut chosen = current;
        ComboBox::from_label("scene")
            .selected_text(scenes[current])
            .show_ui(ui, |ui| {
                for (i, name) in scenes.iter().enumerate() {
                    ui.selectable_value(&mut chosen, i, *name);
                }
            })
            .response
            .on_hover_text(tips.of("scene"));
        if chosen != current {
            actions.push(Action::Scene(chosen));
        }
    }

    ui.add_enabled_ui(facts.views, |ui| {
        ui.horizontal(|ui| {
            let (text, tip) = match facts.split {
                None => ("compare", "Keeps these settings on the right of a line; what you change is on its left."),
                Some(_) => ("compare no more", "Shows the first settings alone."),
            };
            if ui.button(text).on_hover_text(tip).clicked() {
                actions.push(Action::Compare(facts.split.is_none()));
            }
            if facts.split.is_some() && ui.button("swap").on_hover_text("Exchanges left and right.").clicked() {
                actions.push(Action::Swap);
            }
        })
    });
    let mut now = facts.settings.clone();
    if facts.views {
        let allowed = |view| switch::with_view(facts.settings, view).view == view;
        choice(ui, "view", &mut now.view, View::ALL, allowed, tips);
    }
    ui.separator();
    technique(ui, &mut now, facts.marches, tips);
    ui.separator();
    let mut done = false;
    if let Some(own) = facts.displaced {
        done |= displacement(ui, facts, own, tips, surface);
        ui.separator();
    }
    shading(ui, &mut now, facts, tips);
    ui.separator();
    done |= lights(ui, facts, tips, surface);
    ui.separator();
    camera(ui, facts, tips, actions);
    if done {
        let taken = std::mem::take(surface);
        let own = facts.surface;
        actions.push(Action::Surface(SurfaceArgs {
            height_scale: taken.height_scale.or(own.height_scale),
            midlevel: taken.midlevel.or(own.midlevel),
            height_lod: taken.height_lod.or(own.height_lod),
            light: LightArgs {
                sun: taken.light.sun.or(own.light.sun),
                light_intensity: taken.light.light_intensity.or(own.light.light_intensity),
            },
            ..own.clone()
        }));
    }
    if now != *facts.settings {
        actions.push(Action::Settings(now));
    }
}

fn technique(ui: &mut Ui, now: &mut Settings, marches: &[March], tips: &Tips) {
    let shelled = |s: &Settings| s.resolved_shell() != Shell::Off;
    let mut shell = now.shell;
    choice(ui, "shell", &mut shell, Shell::ALL, |_| true, tips);
    if shell != now.shell {
        *now = switch::with_shell(now, shell);
    }
    ui.add_enabled_ui(shelled(now), |ui| choice(ui, "stage", &mut now.stage, Stage::ALL, |_| true, tips));
    let mut march = now.march;
    let in_shell = shelled(now);
    choice(ui, "march", &mut march, marches, |march| !in_shell || march.traces(), tips);
    if march != now.march {
        *now = switch::with_march(now, march);
    }
    ui.add_enabled_ui(now.march.steps(), |ui| {
        let most = now.max_steps;
        number(ui, "min-steps", &mut now.min_steps, 1..=most, tips);
    });
    ui.add_enabled_ui(now.march.traces() && now.march != March::Exact, |ui| {
        let least = now.min_steps;
        number(ui, "max-steps", &mut now.max_steps, least..=256.max(least), tips);
    });
    ui.add_enabled_ui(now.march.refines(), |ui| number(ui, "refine-steps", &mut now.refine_steps, 0..=64, tips));
    ui.add_enabled_ui(now.march.steps(), |ui| tick(ui, "dither", &mut now.dither, tips));
}

/// Whether the pointer lets go of a value that it has changed.
fn lets_go(response: &Response) -> bool {
    response.drag_stopped() || response.lost_focus()
}

/// Scale, midlevel and LOD of the heights. Whether they are to be taken over: when the pointer lets go.
fn displacement(
    ui: &mut Ui,
    facts: &Facts<'_>,
    [scale, midlevel]: [f64; 2],
    tips: &Tips,
    surface: &mut SurfaceArgs,
) -> bool {
    let mut value = surface.height_scale.or(facts.surface.height_scale).unwrap_or(scale);
    let slider =
        DragValue::new(&mut value).range(0.0..=f64::MAX).speed(0.002 * scale.max(1e-3)).prefix("height-scale ");
    let response = ui.add(slider).on_hover_text(tips.of("height-scale"));
    if response.changed() {
        surface.height_scale = Some(value);
    }
    let mut done = lets_go(&response);
    let mut value = surface.midlevel.or(facts.surface.midlevel).unwrap_or(midlevel);
    let response = ui.add(Slider::new(&mut value, 0.0..=1.0).text("midlevel")).on_hover_text(tips.of("midlevel"));
    if response.changed() {
        surface.midlevel = Some(value);
    }
    done |= lets_go(&response);
    let lod = surface.height_lod.or(facts.surface.height_lod);
    let mut auto = facts.settings.pixel_lod;
    let reads = facts.settings.resolved_shell() == Shell::Off && facts.settings.march.reads_lods();
    let of_pixel = ui.add_enabled(reads, egui::Checkbox::new(&mut auto, "height-lod auto"));
    if of_pixel.on_hover_text(tips.of("height-lod")).changed() {
        surface.height_lod = Some(if auto { HeightLod::Auto } else { HeightLod::Mip(0) });
        done = true;
    }
    ui.add_enabled_ui(!auto, |ui| {
        let mut value = match lod {
            Some(HeightLod::Mip(mip)) => mip,
            Some(HeightLod::Auto) | None => 0,
        };
        let response = ui.add(Slider::new(&mut value, 0..=8).text("height-lod")).on_hover_text(tips.of("height-lod"));
        if response.changed() {
            surface.height_lod = Some(HeightLod::Mip(value));
        }
        done |= lets_go(&response);
    });
    done
}

/// Where the sun stands and how strong the lights are. Whether it is to be taken over: when the pointer lets go.
fn lights(ui: &mut Ui, facts: &Facts<'_>, tips: &Tips, surface: &mut SurfaceArgs) -> bool {
    let mut done = false;
    ui.add_enabled_ui(facts.lights_fixed, |ui| {
        if let Some(own) = facts.sun {
            let mut sun = surface.light.sun.or(facts.surface.light.sun).unwrap_or(own);
            for (k, reach, text) in [(0, 180.0, "sun, around"), (1, 90.0, "sun, above")] {
                let response = ui.add(Slider::new(&mut sun[k], -reach..=reach).text(text).suffix("°"));
                let response = response.on_hover_text(tips.of("sun"));
                if response.changed() {
                    surface.light.sun = Some(sun);
                }
                done |= lets_go(&response);
            }
        }
        let mut factor = surface.light.light_intensity.or(facts.surface.light.light_intensity).unwrap_or(1.0);
        let response = ui.add(Slider::new(&mut factor, 0.0..=8.0).text("light-intensity"));
        let response = response.on_hover_text(tips.of("light-intensity"));
        if response.changed() {
            surface.light.light_intensity = Some(factor);
        }
        done |= lets_go(&response);
    });
    done
}

/// The camera's place, what it looks at, and how wide.
fn camera(ui: &mut Ui, facts: &Facts<'_>, tips: &Tips, actions: &mut Vec<Action>) {
    let CameraArgs { eye, target, fov_y } = facts.camera;
    let (mut eye, mut target) = (eye.unwrap_or_default(), target.unwrap_or_default());
    let reach = (0..3).map(|k| (eye[k] - target[k]).abs()).fold(1e-3, f64::max);
    let mut changed = false;
    for (flag, point) in [("eye", &mut eye), ("target", &mut target)] {
        ui.horizontal(|ui| {
            for value in point {
                changed |= ui.add(DragValue::new(value).speed(0.005 * reach).max_decimals(3)).changed();
            }
            ui.label(flag).on_hover_text(tips.of(flag));
        });
    }
    let mut fov_y = fov_y;
    if let Some(degrees) = &mut fov_y {
        let slider = Slider::new(degrees, 1.0..=150.0).text("fov-y").suffix("°");
        changed |= ui.add(slider).on_hover_text(tips.of("fov-y")).changed();
    }
    if changed {
        actions.push(Action::Camera(CameraArgs { eye: Some(eye), target: Some(target), fov_y }));
    }
    if ui.button("reset camera").on_hover_text("Goes back to the sample's own camera.").clicked() {
        actions.push(Action::ResetCamera);
    }
}

fn shading(ui: &mut Ui, now: &mut Settings, facts: &Facts<'_>, tips: &Tips) {
    let base_only = now.resolved_shell() == Shell::Off;
    let traced_base = base_only && now.march.traces();
    ui.add_enabled_ui(traced_base, |ui| {
        tick(ui, "depth-offset", &mut now.depth_offset, tips);
        choice(ui, "silhouette", &mut now.silhouette, Silhouette::ALL, |_| true, tips);
    });
    ui.add_enabled_ui(now.march != March::None, |ui| {
        ui.add_enabled_ui(base_only, |ui| {
            choice(ui, "normals", &mut now.normals, Normals::ALL, |_| true, tips);
            choice(ui, "tangents", &mut now.tangents, Tangents::ALL, |_| true, tips);
        });
        ui.add_enabled_ui(!now.shadow_map, |ui| {
            let mut fades = now.lod_fade.is_some();
            tick(ui, "lod-fade", &mut fades, tips);
            now.lod_fade = fades.then(|| now.lod_fade.unwrap_or(2.0));
            if let Some(start) = &mut now.lod_fade {
                ui.add(Slider::new(start, -4.0..=8.0).text("from LOD")).on_hover_text(tips.of("lod-fade"));
            }
        });
    });
    ui.separator();
    ui.add_enabled_ui(now.march.traces(), |ui| {
        let cones = !base_only && now.march.reads_cones();
        let allowed = |shadow| shadow != SelfShadow::Soft || !cones;
        choice(ui, "self-shadow", &mut now.self_shadow, SelfShadow::ALL, allowed, tips);
    });
    ui.add_enabled_ui(now.self_shadow == SelfShadow::Soft, |ui| {
        let softness = Slider::new(&mut now.shadow_softness, 0.0..=1.0).logarithmic(true).text("shadow-softness");
        ui.add(softness).on_hover_text(tips.of("shadow-softness"));
    });
    ui.add_enabled_ui(now.self_shadow != SelfShadow::Off && (base_only || now.march.steps()), |ui| {
        let mut own = now.shadow_steps.is_some();
        tick(ui, "shadow-steps", &mut own, tips);
        now.shadow_steps = own.then(|| now.shadow_steps.unwrap_or(now.max_steps));
        if let Some(steps) = &mut now.shadow_steps {
            let most = 256.max(*steps);
            ui.add(Slider::new(steps, 1..=most).text("at most")).on_hover_text(tips.of("shadow-steps"));
        }
    });
    ui.add_enabled_ui(now.lod_fade.is_none(), |ui| tick(ui, "shadow-map", &mut now.shadow_map, tips));
    ui.add_enabled_ui(now.shadow_map, |ui| {
        number(ui, "shadow-map-size", &mut now.shadow_map_size, 64..=4096, tips);
        number(ui, "cascades", &mut now.cascades, 1..=6, tips);
    });
    ui.add_enabled_ui(now.march != March::None, |ui| tick(ui, "ambient-occlusion", &mut now.ambient_occlusion, tips));
    let occludes = facts.sun.is_some() && (now.ambient_occlusion || facts.occluded);
    ui.add_enabled_ui(occludes, |ui| {
        let slider = Slider::new(&mut now.occlusion_light, 0.0..=1.0).text("occlusion-light");
        ui.add(slider).on_hover_text(tips.of("occlusion-light"));
    });
    if !occludes {
        now.occlusion_light = 0.0;
    }
    let mut four = now.msaa == 4;
    ui.checkbox(&mut four, "msaa 4").on_hover_text(tips.of("msaa"));
    now.msaa = if four { 4 } else { 1 };
    choice(ui, "depth-prepass", &mut now.depth_prepass, DepthPrepass::ALL, |_| true, tips);
    ui.add_enabled_ui(plan::may_name_lids(now), |ui| {
        choice(ui, "visibility-buffer", &mut now.visibility_buffer, VisibilityBuffer::ALL, |_| true, tips);
    });
    *now = switch::fitting(now.clone());
}

fn choice<T: Copy + PartialEq + Display>(
    ui: &mut Ui,
    flag: &str,
    value: &mut T,
    all: &[T],
    allowed: impl Fn(T) -> bool,
    tips: &Tips,
) {
    let shown = ComboBox::from_label(flag).selected_text(value.to_string()).show_ui(ui, |ui| {
        for &each in all.iter().filter(|each| allowed(**each)) {
            ui.selectable_value(value, each, each.to_string());
        }
    });
    shown.response.on_hover_text(tips.of(flag));
}

fn tick(ui: &mut Ui, flag: &str, value: &mut bool, tips: &Tips) {
    ui.checkbox(value, flag).on_hover_text(tips.of(flag));
}

fn number(ui: &mut Ui, flag: &str, value: &mut u32, range: std::ops::RangeInclusive<u32>, tips: &Tips) {
    ui.add(Slider::new(value, range).text(flag)).on_hover_text(tips.of(flag));
}
