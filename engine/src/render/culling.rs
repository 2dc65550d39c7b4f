//! Drops the prisms that no pixel can show before the stage that makes them: `shaders/render/culling.glsl` has the tests.
//! For the mesh stage a task stage asks them, for the geometry stage a pass, into lists and indirect draws.

use bytemuck::{Pod, Zeroable};

use super::layout;
use super::plan::Draw;
use crate::error::Result;
use crate::gpu::{
    Access, Binding, Buffer, BufferDesc, CommandEncoder, Context, DescriptorSet, MemoryLocation, Pipeline, Uploader, vk,
};

/// Items of a workgroup of `render/cull.comp`, and so of an indirect draw.
const CHUNK: u32 = 512;

/// What the tests have found in one frame, over all draws: prisms, those of a walk once as lids and once as borders.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct Counts {
    /// Drawn.
    pub shown: u32,
    /// Outside the view.
    pub outside: u32,
    /// Lids that face away and, where the hidden are dropped, prisms behind the horizon of their shell.
    pub away: u32,
    /// Behind what is nearer.
    pub hidden: u32,
}

/// What culling keeps of one draw.
pub struct Culled {
    /// Where a pass lists what is kept: the list, and the commands that draw it.
    list: Option<[Buffer; 2]>,
    /// Which prisms the last frame showed, where the hidden are dropped.
    seen: Option<Buffer>,
}

/// Its buffers by name, for draw `index`, and their bytes.
pub fn buffers(index: usize, draw: &Draw) -> [(String, usize); 3] {
    let prisms = draw.range.end as usize;
    let of = |what: &str, each: usize, count: usize, there: bool| {
        (format!("{what} of draw {index}"), if there { each * count } else { 0 })
    };
    let commands = prisms.div_ceil(CHUNK as usize);
    [
        of("kept prisms", size_of::<u32>(), prisms, draw.cull.is_some()),
        of("commands", size_of::<vk::DrawIndirectCommand>(), commands, draw.cull.is_some()),
        of("seen prisms", size_of::<u32>(), prisms, draw.hides()),
    ]
}

impl Culled {
    /// For draw `index` of a plan.
    pub fn new(ctx: &Context, uploader: &mut Uploader, index: usize, draw: &Draw) -> Result<Self> {
        use vk::BufferUsageFlags as U;
        let [kept, commands, seen] = buffers(index, draw);
        let buffer = |(name, bytes): &(String, usize), usage: U| {
            let size = *bytes as u64;
            Buffer::new(ctx, &BufferDesc { name, size, usage, location: MemoryLocation::GpuOnly })
        };
        let list = draw.cull.map(|_| {
            Ok([buffer(&kept, U::STORAGE_BUFFER)?, buffer(&commands, U::STORAGE_BUFFER | U::INDIRECT_BUFFER)?])
        });
        let (name, bytes) = seen;
        // None at first: then all are drawn in the second round.
        let seen = (bytes > 0).then(|| uploader.buffer(&name, U::STORAGE_BUFFER, &vec![0u8; bytes])).transpose()?;
        Ok(Culled { list: list.transpose()?, seen })
    }

    /// Its buffers by their names in the shaders.
    pub fn bindings(&self) -> Vec<(&str, Binding<'_>)> {
        let list = self.list.iter().flat_map(|[kept, commands]| [("kept", kept), ("commands", commands)]);
        list.chain(self.seen.iter().map(|seen| ("seen", seen)))
            .map(|(name, buffer)| (name, Binding::Buffer(buffer)))
            .collect()
    }

    /// Before a task stage reads what the last one wrote.
    pub fn before_tasks(&self, cmd: &mut CommandEncoder) {
        if let (Some(seen), None) = (&self.seen, &self.list) {
            cmd.buffer_barrier(seen, Access::TASK_WRITE, Access::TASK_WRITE);
        }
    }

    /// Records the pass that lists what is to be drawn, outside of any other. `push`: of the draw.
    pub fn record(
        &self,
        cmd: &mut CommandEncoder,
        pipeline: &Pipeline,
        sets: [&DescriptorSet; 2],
        push: &layout::Draw,
    ) {
        let Some([kept, commands]) = &self.list else { return };
        cmd.buffer_barrier(kept, Access::SHADER_READ, Access::COMPUTE_WRITE);
        cmd.buffer_barrier(commands, Access::INDIRECT_READ, Access::COMPUTE_WRITE);
        if let Some(seen) = &self.seen {
            cmd.buffer_barrier(seen, Access::COMPUTE_WRITE, Access::COMPUTE_WRITE);
        }
        cmd.bind_pipeline(pipeline);
        for (number, set) in (0..).zip(sets) {
            cmd.bind_set(pipeline, number, set);
        }
        cmd.push(pipeline, push);
        cmd.dispatch(push.count.div_ceil(CHUNK), 1, 1);
        cmd.buffer_barrier(kept, Access::COMPUTE_WRITE, Access::SHADER_READ);
        cmd.buffer_barrier(commands, Access::COMPUTE_WRITE, Access::INDIRECT_READ);
    }

    /// Draws what was listed of so many items.
    pub fn draw(&self, cmd: &mut CommandEncoder, items: u32) {
        if let Some([_, commands]) = &self.list {
            cmd.draw_indirect(commands, items.div_ceil(CHUNK));
        }
    }
}
