//! Shadow maps: the scene as each light sees it, through the same tracer as the camera's picture, tiles of one atlas.
//! What a receiver makes of them stands in `shaders/render/shadow_map.glsl`.

pub mod fit;

use glam::DVec3;

use self::fit::Sphere;
use super::layout::{self, ShadowView};
use super::plan::ShadowPlan;
use super::resources::Slot;
use super::view::View;
use super::{DEPTH_FORMAT, Renderer};
use crate::error::Result;
use crate::gpu::{
    Access, Binding, CommandEncoder, Context, DepthAttachment, DescriptorSet, Image, ImageDesc, PassTimers,
    RenderingDesc, Sampler, SamplerDesc, vk,
};
use crate::scene::{Ambient, Camera, Light};
use crate::settings::Settings;

/// How far a mesh that changes shape may reach beyond its pose at rest, in radii of that: where a pose reaches is known
/// on the GPU only.
const POSED_REACH: f64 = 2.0;

/// Maps that a light has under these settings.
pub fn maps(light: &Light, settings: &Settings) -> u32 {
    fit::most_maps(light, settings.cascades)
}

/// Texels of an image with room for `count` maps of `size` texels a side, where an image may have `most`.
pub fn atlas(count: u32, size: u32, most: u32) -> [u32; 2] {
    // Few tiles that nothing is drawn to, then as square as can be.
    let fits = (1..=count).filter(|columns| columns * size <= most);
    let shape =
        |columns: &u32| (columns * count.div_ceil(*columns) - count, columns.abs_diff(count.div_ceil(*columns)));
    let columns = fits.min_by_key(shape).unwrap_or(1);
    [columns * size, count.div_ceil(columns) * size]
}

/// The maps of a renderer.
pub struct ShadowMaps {
    atlas: Image,
    sampler: Sampler,
    /// Texels a side of a tile.
    size: u32,
    /// Tiles in a row.
    columns: u32,
    /// Set 1 of each draw.
    pub sets: Vec<DescriptorSet>,
    /// Of each frame in flight, of each map.
    slots: Vec<Vec<Slot>>,
}

impl ShadowMaps {
    /// Room for the maps of a plan. sets: set 1 of each of its draws.
    pub fn new(ctx: &Context, plan: &ShadowPlan, settings: &Settings, sets: Vec<DescriptorSet>) -> Result<Self> {
        let size = settings.shadow_map_size;
        let extent = atlas(plan.count(), size, ctx.max_image_2d());
        let atlas = Image::new(
            ctx,
            &ImageDesc {
                name: "shadow maps",
                extent,
                format: DEPTH_FORMAT,
                usage: vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT | vk::ImageUsageFlags::SAMPLED,
                ..ImageDesc::default()
            },
        )?;
        let sampler = Sampler::new(
            ctx,
            &SamplerDesc { wrap: [vk::SamplerAddressMode::CLAMP_TO_EDGE; 2], ..SamplerDesc::nearest() },
        )?;
        Ok(ShadowMaps { atlas, sampler, size, columns: extent[0] / size, sets, slots: Vec::new() })
    }

    /// What the receivers read.
    pub fn binding(&self) -> (&'static str, Binding<'_>) {
        ("shadow_atlas", Binding::Image(&self.atlas, &self.sampler))
    }

    /// First texel of a tile.
    fn origin(&self, tile: u32) -> [u32; 2] {
        [tile % self.columns * self.size, tile / self.columns * self.size]
    }
}

/// The maps of one frame.
#[derive(Default)]
pub struct Mapped {
    /// All of them.
    pub views: Vec<ShadowView>,
    /// First and number of each light's.
    pub of_light: Vec<[u32; 2]>,
}

impl Renderer {
    /// Draws the maps of a frame that `camera` sees.
    pub(super) fn record_shadow_maps(
        &mut self,
        cmd: &mut CommandEncoder,
        slot: usize,
        camera: &Camera,
        extent: [u32; 2],
        timers: Option<&mut PassTimers>,
    ) -> Result<Mapped> {
        let mut mapped = Mapped::default();
        let Some(mut maps) = self.shadow_maps.take() else { return Ok(mapped) };
        let result = self.draw_shadow_maps(&mut maps, cmd, slot, camera, extent, timers, &mut mapped);
        self.shadow_maps = Some(maps);
        result.map(|()| mapped)
    }

    #[allow(clippy::too_many_arguments)]
    fn draw_shadow_maps(
        &self,
        maps: &mut ShadowMaps,
        cmd: &mut CommandEncoder,
        slot: usize,
        camera: &Camera,
        extent: [u32; 2],
        mut timers: Option<&mut PassTimers>,
        mapped: &mut Mapped,
    ) -> Result<()> {
        let Some(plan) = &self.plan.shadow_maps else { return Ok(()) };
        if let Some(timers) = timers.as_deref_mut() {
            timers.begin(cmd, slot, "shadow maps");
        }
        cmd.image_barrier(&maps.atlas, Access::FRAGMENT_READ.discarded(), Access::DEPTH_WRITE);
        let depth = DepthAttachment { image: &maps.atlas, clear: Some(0.0), store: true };
        let whole = maps.atlas.extent();
        cmd.begin_rendering(&RenderingDesc { name: "shadow maps", color: &[], depth: Some(depth), extent: whole });
        while maps.slots.len() <= slot {
            maps.slots.push(Vec::new());
        }
        let (bounds, aspect) = (self.bounds(), f64::from(extent[0]) / f64::from(extent[1]));
        let eye = camera.transform.translation;
        let mut first = 0;
        for (light, most) in self.lights.iter().zip(&plan.maps) {
            let lenses = fit::lenses(light, self.settings.cascades, maps.size, camera, aspect, bounds);
            mapped.of_light.push([mapped.views.len() as u32, lenses.len() as u32]);
            for (tile, lens) in (first..).zip(&lenses) {
                let view = View::new(lens, [maps.size; 2]);
                let origin = maps.origin(tile);
                mapped.views.push(view.shadow_view(eye, origin, whole));
                cmd.set_viewport(origin, [maps.size; 2]);
                self.draw_shadow_map(maps, cmd, slot, tile as usize, &view, origin)?;
            }
            first += most;
        }
        cmd.end_rendering();
        cmd.image_barrier(&maps.atlas, Access::DEPTH_WRITE, Access::FRAGMENT_READ);
        if let Some(timers) = timers {
            timers.end(cmd);
        }
        Ok(())
    }

    fn draw_shadow_map(
        &self,
        maps: &mut ShadowMaps,
        cmd: &mut CommandEncoder,
        slot: usize,
        tile: usize,
        view: &View,
        origin: [u32; 2],
    ) -> Result<()> {
        let Some(plan) = &self.plan.shadow_maps else { return Ok(()) };
        let slots = &mut maps.slots[slot];
        while slots.len() <= tile {
            let label = format!("slot {slot}, shadow map {}", slots.len());
            slots.push(Slot::new(&self.ctx, &label, plan.draws.len(), 0, 0, [false; 2])?);
        }
        let slots = &mut slots[tile];
        let (objects, cut) = self.objects(view, &plan.draws);
        let mut frame = view.frame(&Ambient::default());
        frame.origin = glam::Vec4::new(origin[0] as f32, origin[1] as f32, 0.0, 0.0);
        slots.write(&frame, &objects, &[], &[])?;
        // Loops that give up here are counted with the picture's.
        let counters = self.slots[slot].counters();
        let extra: Vec<_> = counters.map(|counters| ("counters", Binding::Buffer(counters))).into_iter().collect();
        for (index, draw) in plan.draws.iter().enumerate() {
            slots.prepare(&self.ctx, &draw.variant, index, &self.pipelines[&draw.variant], &extra)?;
        }
        // Surfaces first: they are cheap, and their depth spares the shells' fragments behind them.
        for shells in [false, true] {
            for (index, draw) in plan.draws.iter().enumerate().filter(|(_, draw)| draw.is_shell() == shells) {
                let sets = [slots.set(&draw.variant, index), &maps.sets[index]];
                let push = self.push(draw, index, cut[index]);
                self.record_draw(cmd, draw, &draw.variant, sets, index, &frame, &objects[index], &push);
            }
        }
        Ok(())
    }

    /// A sphere around all that is drawn, shells included.
    fn bounds(&self) -> Sphere {
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for draw in &self.plan.draws {
            let primitive = &self.primitives[draw.primitive];
            let reach = if primitive.rest.is_some() { POSED_REACH } else { 1.0 } * primitive.extent;
            for corner in 0..8 {
                let sign = |bit: u32| if corner >> bit & 1 == 0 { -1.0 } else { 1.0 };
                let at = primitive.center + reach * DVec3::new(sign(0), sign(1), sign(2));
                let at = self.transforms[draw.instance].transform_point3(at);
                (low, high) = (low.min(at), high.max(at));
            }
        }
        // Not quite tight: what lies on it is inside.
        Sphere { center: 0.5 * (low + high), radius: 0.501 * (high - low).length() }
    }
}

impl layout::Light {
    /// Says which maps are its.
    pub fn set_maps(&mut self, [first, count]: [u32; 2]) {
        (self.spot.z, self.spot.w) = (first as f32, count as f32);
    }
}
