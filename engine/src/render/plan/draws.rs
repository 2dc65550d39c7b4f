//! The draws of each primitive, and the shader variants that they take.

use std::ops::Range;

use super::fade::{self, Span};
use super::ledger::Need;
use super::lights::shadowed_lights;
use super::{Draw, Plan, needs, primitive_name, tangents};
use crate::render::variant::{Geometry, Height, Pass, READ_TOGETHER, TEXTURE_NAMES, Variant};
use crate::scene::{DepthOffset, Displacement, Instance, Material, Scene};
use crate::settings::{Baseline, March, Normals, SelfShadow, Settings, Shell, Silhouette, Stage, View};
use crate::shell::prisms::{self, MAX_OTHERS};

#[allow(clippy::too_many_arguments)]
pub(super) fn plan_draws(
    scene: &Scene,
    settings: &Settings,
    stage: Stage,
    aov: bool,
    index: usize,
    instance: &Instance,
    planned: usize,
    plan: &mut Plan,
) {
    let geometry = &plan.primitives[planned];
    let primitive = &scene.meshes[instance.mesh].primitives[geometry.primitive];
    let material = &scene.materials[primitive.material];
    let displacement = prisms::displacement(scene, primitive);
    let of = primitive_name(scene, instance.mesh, geometry.primitive);
    let of_material = format!("material '{}'", material.name);
    let ledger = &mut plan.ledger;
    let mut textures = textures(material);
    let (needed, mut read_together) = needs::textures(material);
    for ((texture, what), need) in textures.iter_mut().zip(TEXTURE_NAMES).zip(needed) {
        *texture = texture.filter(|_| ledger.decide(&of_material, what, need));
    }
    for (together, (_, second, _)) in read_together.iter_mut().zip(READ_TOGETHER) {
        *together = *together && textures[second].is_none();
    }
    let shifts = |offset: &DepthOffset| {
        let need = Need::when(offset.distance > 0.0, "it moves the depth", "its distance is 0");
        settings.depth_offset && ledger.decide(&of_material, "depth offset", need)
    };
    let depth_shift = material.depth_offset.filter(shifts).map(|offset| offset.dither);
    let alpha_mask = ledger.decide(&of_material, "alphaMode MASK", needs::alpha_mask(scene, material));
    let plain = Variant {
        geometry: Geometry::Surface,
        textures,
        read_together,
        specular: ledger.decide(&of_material, "specular", needs::specular(material)),
        channels: [material.roughness_channel, material.metallic_channel],
        occludes_light: settings.occlusion_light > 0.0 && !scene.lights.is_empty(),
        height: None,
        depth_shift,
        // Away from the eye.
        depth_behind: depth_shift.is_some() && !settings.keep_all,
        alpha_mask,
        double_sided: material.double_sided,
        mirrored: instance.transform.matrix3.determinant() < 0.0,
        lights: scene.lights.len() as u32,
        pass: Pass::Shade,
        depth_stands: false,
        shadowed_lights: 0,
        shadow_maps: false,
        aov,
        samples: 1,
        per_sample: false,
        aov_uv: displacement.map_or(0, |d| d.tex_coord as u8),
        height_uvs: geometry.derived.uvs,
        normals_along_shell: false,
        deforms: false,
        surface_vertices: false,
        cull: None,
        visibility: false,
        // Of the others some add to the shaded picture.
        view: match settings.view {
            View::Base | View::Wireframe | View::Error => View::Shaded,
            own => own,
        },
    };
    let prisms = geometry.shell.prisms.len() as u32;
    let mut push_in = |span: Option<Span>, variant: Variant, range: Range<u32>| {
        if !range.is_empty() {
            plan.draws.push(Draw {
                instance: index,
                primitive: planned,
                variant,
                depth: None,
                cull: None,
                visibility: None,
                range,
                span,
            });
        }
    };
    let mut push = |variant: Variant, range: Range<u32>| push_in(None, variant, range);
    let baseline = settings.baseline.filter(|_| geometry.shell.is_displaced());
    if let (Some(baseline), Some(d)) = (baseline, &displacement) {
        push(baseline_variant(baseline, d, plain), 0..prisms);
    } else if prisms > 0 {
        let shown = displacement.filter(|_| geometry.shell.is_displaced());
        let others = geometry.shell.others.len() as u8;
        let mut other_procedures = [None; MAX_OTHERS];
        for (slot, other) in other_procedures.iter_mut().zip(&geometry.shell.others) {
            *slot = other.source.procedure();
        }
        let height = shown.map(|d| {
            let mesh = &scene.meshes[instance.mesh];
            let steps = ledger.decide(&of, "steps at walls", needs::steps(&geometry.shell, geometry.deforms));
            let plain = needs::plain_prisms(&geometry.shell, geometry.deforms);
            let shadow = needs::self_shadow(scene, instance, primitive, mesh, settings, steps);
            let field = height(&d, settings, true);
            let self_shadow = ledger.decide(&of, "self-shadow", shadow) && field.self_shadow;
            Height {
                others,
                other_procedures,
                steps,
                plain: ledger.decide(&of, "plain prisms", plain),
                one_heights: ledger.decide(&of, "one step", needs::one_heights(&geometry.shell, settings)),
                self_shadow,
                soft_shadow: self_shadow && field.soft_shadow && geometry.headroom > 0.0,
                shadow_steps: self_shadow && field.shadow_steps,
                reenters: self_shadow && geometry.hierarchy,
                ..field
            }
        });
        let shadows = settings.self_shadow != SelfShadow::Off;
        let far = Variant { depth_shift: None, depth_behind: false, ..plain };
        let plain = Variant { shadowed_lights: if shadows { shadowed_lights(scene) } else { 0 }, ..plain };
        if plain.depth_shift.is_some() {
            plan.notices.push(format!("material '{}': its depth offset is left out beside a shell", material.name));
        }
        let fades = fade::fades(settings, aov);
        let spans: &[_] = if fades { &[Some(Span::Near), Some(Span::Fading)] } else { &[None] };
        for span in spans {
            let height = height.map(|h| Height { lod_fade: *span == Some(Span::Fading), ..h });
            // The raster's depth lies before all that a fragment can hit.
            let shelled = Variant {
                height,
                depth_shift: None,
                depth_behind: !settings.keep_all,
                normals_along_shell: geometry.derived.normals,
                ..plain
            };
            let outlines = Variant { mirrored: false, double_sided: false, ..shelled };
            if settings.resolved_shell() == Shell::Walk && geometry.walk.is_some() {
                // Front faces only: a lid seen from behind is where rays leave.
                let deforms = geometry.deforms && stage == Stage::Mesh;
                let lids = Variant { geometry: Geometry::Lids(stage), double_sided: false, deforms, ..shelled };
                push_in(*span, lids, 0..prisms);
                push_in(*span, Variant { geometry: Geometry::Borders(stage), ..outlines }, 0..prisms);
            } else {
                push_in(*span, Variant { geometry: Geometry::Shell(stage), ..outlines }, 0..prisms);
            }
        }
        if fades {
            push_in(Some(Span::Far), far, 0..primitive.triangles.len() as u32);
        }
    } else {
        let parallax =
            settings.baseline.is_none() && settings.resolved_shell() == Shell::Off && settings.march != March::None;
        let height = displacement.filter(|_| parallax).map(|d| height(&d, settings, false)).map(|h| Height {
            self_shadow: h.self_shadow && plain.lights > 0,
            mesh_tangents: tangents::from_mesh(material, primitive, settings) && !geometry.deforms,
            soft_shadow: h.soft_shadow && plain.lights > 0,
            shadow_steps: h.shadow_steps && plain.lights > 0,
            // Surface data are of the whole field.
            lod_fade: settings.lod_fade.is_some() && !aov,
            ..h
        });
        let shadowed = if height.is_some_and(|h| h.self_shadow) { shadowed_lights(scene) } else { 0 };
        let offsets = height.is_some_and(|h| h.depth_offset) && !material.double_sided && !settings.keep_all;
        // No part of the field stands before the base surface.
        let depth_behind = plain.depth_behind || (offsets && scene.displacement_range(primitive).1 <= 0.0);
        let triangles = primitive.triangles.len() as u32;
        push(Variant { height, depth_behind, shadowed_lights: shadowed, ..plain }, 0..triangles);
    }
}

/// What draws a displaced primitive as a baseline does. `plain`: its variant without displacement.
fn baseline_variant(baseline: Baseline, displacement: &Displacement, plain: Variant) -> Variant {
    match baseline {
        // Its vertices are its own.
        Baseline::MicroMesh { .. } => Variant { geometry: Geometry::MicroMesh, height_uvs: None, ..plain },
        Baseline::Diced { by, culls, .. } => {
            let unmarched = Settings { march: March::None, ..Settings::default() };
            let height = Some(height(displacement, &unmarched, true));
            Variant { geometry: Geometry::Diced { by, culls }, height, ..plain }
        }
    }
}

/// Whether self-shadow has a penumbra.
pub(super) fn soft(settings: &Settings) -> bool {
    settings.self_shadow == SelfShadow::Soft && settings.shadow_softness > 0.0
}

fn height(displacement: &Displacement, settings: &Settings, shell: bool) -> Height {
    let traces = settings.march.traces();
    let parallax = !shell && traces;
    Height {
        procedure: displacement.source.procedure(),
        wrap: displacement.wrap,
        others: 0,
        steps: false,
        plain: false,
        one_heights: false,
        other_procedures: [None; MAX_OTHERS],
        march: settings.march,
        uv_bounds: parallax && settings.silhouette == Silhouette::UvBounds,
        horizon: parallax && settings.silhouette == Silhouette::Horizon,
        dither: settings.dither && settings.march.steps(),
        normals: if shell { Normals::Gather } else { settings.normals },
        mesh_tangents: false,
        pixel_lod: !shell && settings.pixel_lod && settings.march.reads_lods(),
        depth_offset: parallax && settings.depth_offset,
        lod_fade: false,
        self_shadow: traces && settings.self_shadow != SelfShadow::Off,
        soft_shadow: traces && soft(settings),
        shadow_steps: traces && settings.self_shadow != SelfShadow::Off && settings.shadow_steps.is_some(),
        ambient_occlusion: settings.ambient_occlusion,
        reenters: false,
        // Linear searches end by themselves.
        count_limits: settings.count_limits && (settings.march == March::Exact || settings.march.reads_cones()),
        count_reads: settings.count_reads,
    }
}

/// UV set of each texture slot.
fn textures(material: &Material) -> [Option<u8>; 7] {
    material.textures().map(|t| t.map(|t| t.tex_coord as u8))
}
