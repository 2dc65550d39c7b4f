//! Recording of a frame: its passes in order, and what each draw binds and pushes.

use std::collections::HashSet;

use glam::DVec3;

use super::Renderer;
use super::depth_tiles;
use super::layout::{self, Frame, Object};
use super::passes::{DrawPass, EDGES, Part, passes};
use super::plan::{
    Draw,
    fade::{self, Span},
};
use super::resources::Slot;
use super::shadow::ShadowMaps;
use super::variant::{Geometry, Variant};
use super::view::View;
use super::visibility::Visibility;
use crate::error::Result;
use crate::gpu::{
    Access, Attachment, Binding, CommandEncoder, DepthAttachment, DescriptorSet, Image, Load, PassTimers,
    RenderingDesc, vk,
};
use crate::scene::Camera;
use crate::settings::Stage;

/// Prisms that one mesh workgroup takes; the constant of the same name in `render/kept_prisms.glsl`.
const PRISMS_PER_GROUP: u32 = 24;

/// Prisms that one task workgroup looks at; the constant of the same name in `render/kept_prisms.glsl`.
const PRISMS_PER_TASK: u32 = 96;

/// Ends of a prism's nine edges; `render/edges.vert` counts on it.
const VERTICES_OF_EDGES: u32 = 18;

/// Scene-linear colour behind everything, before tone mapping.
const BACKGROUND: [f32; 4] = [0.05, 0.06, 0.075, 1.0];

impl Renderer {
    /// Records one frame. `slot` counts the frames in flight: what the frame last recorded with it reads is written
    /// anew. `target` is in the layout of [`Access::COLOR_WRITE`] before and after.
    pub fn record(
        &mut self,
        cmd: &mut CommandEncoder,
        slot: usize,
        camera: &Camera,
        target: &Image,
        mut timers: Option<&mut PassTimers>,
    ) -> Result<()> {
        // Until it is told otherwise, a mesh stands as in its file.
        for deformer in &mut self.deformers {
            deformer.record_rest(&self.ctx, cmd, slot, &self.scene)?;
        }
        let extent = target.extent();
        let view = View::new(camera, extent);
        self.resize(extent)?;
        while self.slots.len() <= slot {
            let index = self.slots.len();
            let (draws, lights) = (self.plan.draws.len(), self.lights.len());
            let maps = self.plan.shadow_maps.as_ref().map_or(0, |maps| maps.count() as usize);
            let label = format!("slot {index}");
            let counted = self.plan.draws.iter().any(|draw| draw.variant.cull.is_some_and(|cull| cull.counted));
            let counts = [self.settings.counts(), counted];
            self.slots.push(Slot::new(&self.ctx, &label, draws, lights, maps, counts)?);
        }
        let mapped = self.record_shadow_maps(cmd, slot, camera, extent, timers.as_deref_mut())?;
        let (mut objects, cut) = self.objects(&view, &self.plan.draws);
        let spans = self.fade(&view, &mut objects);
        let mut lights: Vec<_> = self.lights.iter().map(|light| view.light(light)).collect();
        for (light, maps) in lights.iter_mut().zip(&mapped.of_light) {
            light.set_maps(*maps);
        }
        let mut frame = view.frame(&self.scene.ambient);
        frame.origin.z = self.settings.occlusion_light;
        self.slots[slot].write(&frame, &objects, &lights, &mapped.views)?;
        self.targets.as_mut().expect("resize made them").camera = view.position;
        let targets = self.targets.as_ref().expect("resize made them");
        let mut extra: Vec<_> = self.shadow_maps.iter().map(ShadowMaps::binding).collect();
        extra.extend(targets.visibility.iter().flat_map(Visibility::bindings));
        extra.extend(targets.tiles.iter().map(|tiles| ("depth_tiles", Binding::Buffer(&tiles.tiles))));
        for draws in [&self.plan.draws, &self.plan.aov_draws] {
            for (index, draw) in draws.iter().enumerate() {
                for variant in draw.all_variants() {
                    self.slots[slot].prepare(&self.ctx, &variant, index, &self.pipelines[&variant], &extra)?;
                }
            }
        }

        for depth in std::iter::once(&targets.depth).chain(&targets.aov_depth) {
            cmd.image_barrier(depth, Access::DEPTH_WRITE.discarded(), Access::DEPTH_WRITE);
        }
        if let Some(samples) = &targets.samples {
            cmd.image_barrier(&samples.image, Access::FRAGMENT_READ.discarded(), Access::COLOR_WRITE);
        }
        if let Some(aov) = &targets.aov {
            aov.begin(cmd);
        }
        let mut first = true;
        // Draws whose prisms the frame has tested, by round.
        let mut tested = HashSet::new();
        let culler = if self.plan.stage == Some(Stage::Mesh) { Access::TASK_WRITE } else { Access::COMPUTE_WRITE };
        for of_aov in [true, false] {
            let (draws, sets) = match of_aov {
                true => (&self.plan.aov_draws, &self.aov_sets),
                false => (&self.plan.draws, &self.sets),
            };
            for pass in passes(draws, of_aov) {
                if !first {
                    cmd.memory_barrier(Access::COLOR_WRITE, Access::COLOR_WRITE);
                    cmd.memory_barrier(Access::DEPTH_WRITE, Access::DEPTH_WRITE);
                }
                first = false;
                if let (Some(tile_pass), Some(tiles), 1..) = (&self.tile_pass, &targets.tiles, pass.round) {
                    if let Some(timers) = timers.as_deref_mut() {
                        timers.begin(cmd, slot, depth_tiles::PASS);
                    }
                    tile_pass.record(cmd, &targets.depth, tiles, culler);
                    if let Some(timers) = timers.as_deref_mut() {
                        timers.end(cmd);
                    }
                }
                let shown = |i: &&usize| draws[**i].variant.cull.is_some() && draws[**i].span == spans[**i];
                let fresh: Vec<_> =
                    pass.draws.iter().filter(shown).copied().filter(|i| tested.insert((*i, pass.round))).collect();
                if pass.lists(draws) {
                    if let Some(timers) = timers.as_deref_mut() {
                        timers.begin(cmd, slot, pass.culling());
                    }
                    for index in &fresh {
                        let draw = &draws[*index];
                        let (Some(variant), Some(culled), Some(set)) =
                            (&draw.cull, &self.culled[*index], &self.cull_sets[*index])
                        else {
                            continue;
                        };
                        let push =
                            layout::Draw { round: pass.round, counted: 1, ..self.push(draw, *index, cut[*index]) };
                        self.slots[slot].recount(cmd, culler);
                        culled.record(
                            cmd,
                            &self.pipelines[variant],
                            [self.slots[slot].set(variant, *index), set],
                            &push,
                        );
                    }
                    if let Some(timers) = timers.as_deref_mut() {
                        timers.end(cmd);
                    }
                }
                if let Some(timers) = timers.as_deref_mut() {
                    timers.begin(cmd, slot, pass.name);
                }
                for index in &pass.draws {
                    let draw = &draws[*index];
                    if draw.span != spans[*index] {
                        continue;
                    }
                    let mesh = self.primitives[draw.primitive].micro_mesh.as_ref();
                    if let Some(mesh) = mesh.filter(|_| pass.part != Part::Resolve) {
                        mesh.prepare(cmd, &frame, &objects[*index], draw.variant.sides());
                    }
                }
                for culled in pass.draws.iter().filter_map(|index| self.culled[*index].as_ref()) {
                    culled.before_tasks(cmd);
                    self.slots[slot].recount(cmd, culler);
                }
                if let Some(visibility) = &targets.visibility {
                    visibility.before(cmd, pass.part, (!pass.clear[0]).then_some(&targets.depth));
                }
                self.begin_pass(cmd, &pass, target);
                for index in pass.draws {
                    let draw = &draws[index];
                    if draw.span != spans[index] {
                        continue;
                    }
                    let (variant, set) = match (&draw.depth, &draw.visibility) {
                        (Some(depth), _) if !pass.shades => (depth, self.depth_sets[index].as_ref()),
                        (_, Some(visibility)) if pass.part == Part::Write => {
                            (visibility, self.visibility_sets[index].as_ref())
                        }
                        _ => (&draw.variant, Some(&sets[index])),
                    };
                    let sets = [self.slots[slot].set(variant, index), set.expect("made with the variant")];
                    let counted = u32::from(fresh.contains(&index));
                    let resolves = u32::from(pass.part == Part::Resolve);
                    let push =
                        layout::Draw { round: pass.round, counted, resolves, ..self.push(draw, index, cut[index]) };
                    if resolves != 0 {
                        let Some([origin, extent]) = self.resolved(&view, draw) else { continue };
                        cmd.set_scissor(origin, extent);
                    }
                    self.record_draw(cmd, draw, variant, sets, index, &frame, &objects[index], &push);
                }
                cmd.end_rendering();
                if let Some(timers) = timers.as_deref_mut() {
                    timers.end(cmd);
                }
            }
        }
        if let (Some(resolve), Some(samples)) = (&self.resolve, &targets.samples) {
            resolve.record(cmd, samples, target);
        }
        self.slots[slot].end(cmd, culler);
        Ok(())
    }

    /// Begins a pass over all its targets.
    fn begin_pass(&self, cmd: &mut CommandEncoder, pass: &DrawPass, target: &Image) {
        let targets = self.targets.as_ref().expect("made before the first pass");
        let [clear_depth, clear_color] = pass.clear;
        if let (Some(visibility), Part::Write) = (&targets.visibility, pass.part) {
            return visibility.begin_pass(cmd, &targets.depth, clear_depth);
        }
        let load = if clear_color { Load::Clear(BACKGROUND) } else { Load::Keep };
        let samples = targets.samples.as_ref().filter(|_| !pass.of_aov);
        let mut color = Vec::new();
        if pass.shades {
            let image = samples.map_or(target, |samples| &samples.image);
            color.push(Attachment { image, load, store: true, resolve: None });
            let writes = pass.name != EDGES && (pass.of_aov || targets.samples.is_none());
            let aov = targets.aov.as_ref().filter(|_| writes);
            color.extend(aov.iter().flat_map(|aov| aov.attachments(clear_color)));
        }
        let image = targets.aov_depth.as_ref().filter(|_| pass.of_aov).unwrap_or(&targets.depth);
        let depth = DepthAttachment { image, clear: clear_depth.then_some(0.0), store: true };
        let extent = target.extent();
        cmd.begin_rendering(&RenderingDesc { name: pass.name, color: &color, depth: Some(depth), extent });
    }

    /// What `draws` need of a view: each one's transforms, and whether the near plane may lie within its shell or under it.
    pub(super) fn objects(&self, view: &View, draws: &[Draw]) -> (Vec<Object>, Vec<bool>) {
        let of = |draw: &Draw| {
            let (transform, primitive) = (&self.transforms[draw.instance], &self.primitives[draw.primitive]);
            // Where a pose reaches is known on the GPU only.
            let cut = primitive.rest.is_some() || view.near_plane_meets(transform, primitive.center, primitive.extent);
            (view.object(transform, primitive.center), cut)
        };
        draws.iter().map(of).unzip()
    }

    /// The span that each draw's instance is in, where its shells fade; completes their objects.
    fn fade(&self, view: &View, objects: &mut [Object]) -> Vec<Option<Span>> {
        let start = f64::from(self.settings.lod_fade.unwrap_or_default());
        let of = |(draw, object): (&Draw, &mut Object)| {
            draw.span?;
            let mesh = self.plan.primitives[draw.primitive].mesh;
            let parts = self.plan.primitives.iter().zip(&self.primitives).filter(|(planned, _)| planned.mesh == mesh);
            // The thickest shell of the mesh decides for all of it.
            let (extent, thickness) = parts.fold((DVec3::ZERO, 0.0), |(extent, thickness): (DVec3, f64), (_, part)| {
                (extent.max(part.extent), thickness.max(part.thickness))
            });
            let transform = &self.transforms[draw.instance];
            let fade = view.fade(extent, thickness * fade::stretch(transform), start);
            object.fade = fade.extent.as_vec3().extend(fade.scale as f32);
            let [nearest, farthest] = view.depths(transform, self.primitives[draw.primitive].center, extent);
            Some(fade.span(nearest, farthest))
        };
        self.plan.draws.iter().zip(objects).map(of).collect()
    }

    /// Where a draw's walks may begin, in pixels; nowhere if it lies outside the picture.
    fn resolved(&self, view: &View, draw: &Draw) -> Option<[[u32; 2]; 2]> {
        let primitive = &self.primitives[draw.primitive];
        // Where a pose reaches is known on the GPU only.
        let bounds = primitive.rest.is_none().then_some((primitive.center, primitive.extent));
        view.pixels(&self.transforms[draw.instance], bounds)
    }

    /// The push constants of a draw. `index`: of its object. `cut`: see [`Renderer::objects`].
    pub(super) fn push(&self, draw: &Draw, index: usize, cut: bool) -> layout::Draw {
        let prism_count = draw.range.end;
        let mut push = layout::Draw { object: index as u32, count: prism_count, prism_count, ..Default::default() };
        if let Some(walk) = &self.primitives[draw.primitive].walk {
            push.bases = u32::from(walk.open || cut);
            if matches!(draw.variant.geometry, Geometry::Borders(_)) && !cut {
                push.count = walk.border_count;
            }
        }
        push
    }

    /// `variant`: the draw's, or what draws its depth. `sets`: 0 and 1. `index`: of the draw's object.
    #[allow(clippy::too_many_arguments)]
    pub(super) fn record_draw(
        &self,
        cmd: &mut CommandEncoder,
        draw: &Draw,
        variant: &Variant,
        sets: [&DescriptorSet; 2],
        index: usize,
        frame: &Frame,
        object: &Object,
        push: &layout::Draw,
    ) {
        if push.count == 0 {
            // Some drivers compile at a pipeline's first draw, even of nothing.
            return;
        }
        let pipeline = &self.pipelines[variant];
        let primitive = &self.primitives[draw.primitive];
        cmd.bind_pipeline(pipeline);
        for (number, set) in (0..).zip(sets) {
            cmd.bind_set(pipeline, number, set);
        }
        if let Some(diced) = &primitive.diced {
            return diced.record(cmd, pipeline, push.object, frame, object);
        }
        cmd.push(pipeline, push);
        match draw.variant.geometry {
            // One workgroup, or primitive, makes the triangle over the picture.
            Geometry::Lids(Stage::Mesh) if push.resolves != 0 => cmd.draw_mesh_tasks(1, 1, 1),
            _ if push.resolves != 0 => cmd.draw(3, 1, 0, 0),
            _ if variant.cull.is_some() && draw.cull.is_some() => {
                if let Some(culled) = &self.culled[index] {
                    culled.draw(cmd, push.count);
                }
            }
            Geometry::Lids(Stage::Mesh) => {
                cmd.draw_mesh_tasks(primitive.walk.as_ref().map_or(0, |walk| walk.meshlets), 1, 1);
            }
            Geometry::PrismEdges => cmd.draw(VERTICES_OF_EDGES * push.count, 1, 0, 0),
            Geometry::Surface | Geometry::BaseEdges | Geometry::Lids(_) => {
                if let Some(indices) = &primitive.indices {
                    cmd.bind_index_buffer(indices, vk::IndexType::UINT32);
                    cmd.draw_indexed(3 * draw.range.end, 1, 0, 0, 0);
                }
            }
            Geometry::MicroMesh => {
                if let Some(mesh) = &primitive.micro_mesh {
                    mesh.record(cmd, frame, object, draw.variant.sides());
                }
            }
            Geometry::Diced { .. } => {}
            Geometry::Shell(Stage::Mesh) | Geometry::Borders(Stage::Mesh) => {
                let each = if variant.cull.is_some() { PRISMS_PER_TASK } else { PRISMS_PER_GROUP };
                cmd.draw_mesh_tasks(push.count.div_ceil(each), 1, 1);
            }
            Geometry::Shell(_) | Geometry::Borders(_) => cmd.draw(push.count, 1, 0, 0),
        }
    }
}
