//! The buffers that a frame in flight writes, and the descriptor sets that name them.

use std::collections::HashMap;

use crate::error::Result;
use crate::gpu::{
    Access, Binding, Buffer, BufferDesc, CommandEncoder, Context, DescriptorSet, MemoryLocation, Pipeline, vk,
};
use crate::render::culling::Counts;
use crate::render::layout::{Counters, Frame, Light, Object, ShadowView};
use crate::render::variant::{UNIFORM_LIGHTS, Variant};

/// What one frame in flight writes.
pub struct Slot {
    frame: Buffer,
    objects: Buffer,
    lights: Option<Buffer>,
    shadow_views: Option<Buffer>,
    /// What fragments count, if anything.
    counters: Option<Buffer>,
    /// [`Counts`] of the culled prisms, where they are.
    culled: Option<Buffer>,
    /// By variant and by the number of the object.
    sets: HashMap<(Variant, usize), DescriptorSet>,
}

impl Slot {
    /// Room for `objects` draws, `lights` lights and `shadow_views` shadow maps, and counters, of loops and of culled
    /// prisms, if asked for. label: what its buffers are named after.
    pub fn new(
        ctx: &Context,
        label: &str,
        objects: usize,
        lights: usize,
        shadow_views: usize,
        [counters, culled]: [bool; 2],
    ) -> Result<Self> {
        use vk::BufferUsageFlags as U;
        let buffer_in = |location, what: &str, size: usize, usage| {
            let name = format!("{what} of {label}");
            Buffer::new(ctx, &BufferDesc { name: &name, size: size as u64, usage, location })
        };
        let buffer = |what: &str, size, usage| buffer_in(MemoryLocation::CpuToGpu, what, size, usage);
        Ok(Slot {
            frame: buffer("frame", size_of::<Frame>(), U::UNIFORM_BUFFER)?,
            objects: buffer("objects", size_of::<Object>() * objects.max(1), U::UNIFORM_BUFFER)?,
            lights: (lights > 0)
                .then(|| {
                    let usage = if lights > UNIFORM_LIGHTS { U::STORAGE_BUFFER } else { U::UNIFORM_BUFFER };
                    buffer("lights", size_of::<Light>() * lights, usage)
                })
                .transpose()?,
            shadow_views: (shadow_views > 0)
                .then(|| buffer("shadow views", size_of::<ShadowView>() * shadow_views, U::STORAGE_BUFFER))
                .transpose()?,
            counters: counters
                .then(|| buffer_in(MemoryLocation::GpuToCpu, "counters", size_of::<Counters>(), U::STORAGE_BUFFER))
                .transpose()?,
            culled: culled
                .then(|| buffer_in(MemoryLocation::GpuToCpu, "culled prisms", size_of::<Counts>(), U::STORAGE_BUFFER))
                .transpose()?,
            sets: HashMap::new(),
        })
    }

    /// Writes the frame's data; the GPU must be done with the slot's last frame.
    pub fn write(&self, frame: &Frame, objects: &[Object], lights: &[Light], views: &[ShadowView]) -> Result<()> {
        self.frame.write(0, std::slice::from_ref(frame))?;
        self.objects.write(0, objects)?;
        if let Some(buffer) = &self.lights {
            buffer.write(0, lights)?;
        }
        if let Some(buffer) = &self.shadow_views {
            buffer.write(0, views)?;
        }
        if let Some(buffer) = &self.counters {
            buffer.write(0, &[Counters::default()])?;
        }
        if let Some(buffer) = &self.culled {
            buffer.write(0, &[Counts::default()])?;
        }
        Ok(())
    }

    /// Makes what the frame counted visible to the CPU; recorded after its last pass. `culler`: who culls prisms.
    pub fn end(&self, cmd: &mut CommandEncoder, culler: Access) {
        if let Some(buffer) = &self.counters {
            cmd.buffer_barrier(buffer, Access::FRAGMENT_WRITE, Access::HOST_READ);
        }
        if let Some(buffer) = &self.culled {
            cmd.buffer_barrier(buffer, culler, Access::HOST_READ);
        }
    }

    /// Prisms of the slot's last frame, which has run; `None` where none are culled, or not counted.
    pub fn culled(&self) -> Result<Option<Counts>> {
        let Some(buffer) = &self.culled else { return Ok(None) };
        Ok(buffer.read::<Counts>()?.first().copied())
    }

    /// Between two that count culled prisms.
    pub fn recount(&self, cmd: &mut CommandEncoder, culler: Access) {
        if let Some(buffer) = &self.culled {
            cmd.buffer_barrier(buffer, culler, culler);
        }
    }

    /// What the fragments of the slot's last frame, which has run, counted; `None` where they do not.
    pub fn counted(&self) -> Result<Option<Counters>> {
        let Some(buffer) = &self.counters else { return Ok(None) };
        Ok(buffer.read::<Counters>()?.first().copied())
    }

    /// Where they count, if they do.
    pub fn counters(&self) -> Option<&Buffer> {
        self.counters.as_ref()
    }

    /// Makes set 0 for a variant's pipeline and an object, if it is not made yet. extra: what it reads besides.
    pub fn prepare(
        &mut self,
        ctx: &Context,
        variant: &Variant,
        object: usize,
        pipeline: &Pipeline,
        extra: &[(&str, Binding<'_>)],
    ) -> Result<()> {
        if self.sets.contains_key(&(*variant, object)) {
            return Ok(());
        }
        let size = size_of::<Object>() as u64;
        let mut bindings = vec![
            ("FrameBlock", Binding::Buffer(&self.frame)),
            ("ObjectBlock", Binding::BufferRange(&self.objects, object as u64 * size, size)),
        ];
        bindings.extend(self.lights.as_ref().map(|lights| ("LightBlock", Binding::Buffer(lights))));
        bindings.extend(self.shadow_views.as_ref().map(|views| ("shadow_views", Binding::Buffer(views))));
        bindings.extend(extra);
        bindings.extend(self.counters.as_ref().map(|counters| ("counters", Binding::Buffer(counters))));
        bindings.extend(self.culled.as_ref().map(|culled| ("culled", Binding::Buffer(culled))));
        let set = DescriptorSet::with_optional(ctx, pipeline, 0, &[], &bindings)?;
        self.sets.insert((*variant, object), set);
        Ok(())
    }

    /// Set 0, prepared before.
    pub fn set(&self, variant: &Variant, object: usize) -> &DescriptorSet {
        &self.sets[&(*variant, object)]
    }
}
