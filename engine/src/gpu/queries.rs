//! GPU time and pipeline statistics by pass.

use ash::vk;

use super::{Feature, access::Access, device::Context, encoder::CommandEncoder, retire::Retired};
use crate::error::{Error, Result};

/// One pass of one frame, measured.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PassTime {
    /// As given to [`PassTimers::begin`].
    pub name: String,
    /// Milliseconds on the GPU. `None` if the queue has no timestamps, the frame was not submitted or has not run, or
    /// there were more passes than the timers were made for.
    pub gpu_ms: Option<f64>,
    /// Counts, where [`Feature::PipelineStatistics`] is enabled.
    pub statistics: Option<Statistics>,
}

/// What a pass's pipelines did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Statistics {
    /// Vertices fetched; none by mesh pipelines.
    pub input_vertices: u64,
    /// Primitives assembled; none by mesh pipelines.
    pub input_primitives: u64,
    /// Vertex shader runs.
    pub vertex_invocations: u64,
    /// Geometry shader runs, where [`Feature::GeometryShader`] is enabled.
    pub geometry_invocations: Option<u64>,
    /// Primitives that the geometry stage emitted, where [`Feature::GeometryShader`] is enabled.
    pub geometry_primitives: Option<u64>,
    /// Primitives that came to clipping.
    pub clipping_invocations: u64,
    /// Primitives that left it.
    pub clipping_primitives: u64,
    /// Fragment shader runs.
    pub fragment_invocations: u64,
    /// Compute shader runs.
    pub compute_invocations: u64,
    /// Task shader runs, where [`Feature::MeshShaderQueries`] is enabled.
    pub task_invocations: Option<u64>,
    /// Mesh shader runs, where [`Feature::MeshShaderQueries`] is enabled.
    pub mesh_invocations: Option<u64>,
}

/// Timers for a number of passes in each frame in flight.
pub struct PassTimers {
    ctx: Context,
    timestamps: Option<vk::QueryPool>,
    statistics: Option<vk::QueryPool>,
    flags: vk::QueryPipelineStatisticFlags,
    max_passes: usize,
    /// Names of the passes begun in each slot since it was last resolved.
    slots: Vec<Vec<String>>,
    open: Option<(usize, usize)>,
}

impl PassTimers {
    /// Timers for up to `max_passes` passes in each of `in_flight` frames.
    pub fn new(ctx: &Context, max_passes: usize, in_flight: usize) -> Result<Self> {
        use vk::QueryPipelineStatisticFlags as F;
        let count = (max_passes * in_flight) as u32;
        let mut timers = PassTimers {
            ctx: ctx.clone(),
            timestamps: None,
            statistics: None,
            flags: F::INPUT_ASSEMBLY_VERTICES
                | F::INPUT_ASSEMBLY_PRIMITIVES
                | F::VERTEX_SHADER_INVOCATIONS
                | F::CLIPPING_INVOCATIONS
                | F::CLIPPING_PRIMITIVES
                | F::FRAGMENT_SHADER_INVOCATIONS
                | F::COMPUTE_SHADER_INVOCATIONS,
            max_passes,
            slots: vec![Vec::new(); in_flight],
            open: None,
        };
        let make = |name: &str, info: vk::QueryPoolCreateInfo<'_>| {
            // SAFETY: the info asks for no query whose feature is not enabled.
            let pool = unsafe { ctx.device().create_query_pool(&info, None) };
            let pool = pool.map_err(|e| Error::gpu(format!("creating the query pool '{name}'"), e))?;
            ctx.set_name(pool, name);
            Ok::<_, Error>(pool)
        };
        if ctx.inner().timestamp_bits > 0 {
            let info = vk::QueryPoolCreateInfo::default().query_type(vk::QueryType::TIMESTAMP).query_count(2 * count);
            timers.timestamps = Some(make("pass timestamps", info)?);
        }
        if ctx.has(Feature::PipelineStatistics) {
            if ctx.has(Feature::GeometryShader) {
                timers.flags |= F::GEOMETRY_SHADER_INVOCATIONS | F::GEOMETRY_SHADER_PRIMITIVES;
            }
            if ctx.has(Feature::MeshShaderQueries) {
                timers.flags |= F::TASK_SHADER_INVOCATIONS_EXT | F::MESH_SHADER_INVOCATIONS_EXT;
            }
            let info = vk::QueryPoolCreateInfo::default()
                .query_type(vk::QueryType::PIPELINE_STATISTICS)
                .query_count(count)
                .pipeline_statistics(timers.flags);
            timers.statistics = Some(make("pass statistics", info)?);
        }
        Ok(timers)
    }

    /// Begins to measure a pass of the frame in `slot`, outside of rendering. Passes do not nest.
    pub fn begin(&mut self, cmd: &mut CommandEncoder, slot: usize, name: &str) {
        debug_assert!(self.open.is_none(), "pass '{name}' begins inside another");
        let pass = self.slots[slot].len();
        self.slots[slot].push(name.to_owned());
        if pass >= self.max_passes {
            tracing::warn!("pass '{name}' is not timed: there are timers for {} passes only", self.max_passes);
            return;
        }
        self.open = Some((slot, pass));
        let query = self.query(slot, pass);
        let device = self.ctx.device();
        // SAFETY: recording, outside of rendering; the frame that last used these queries was waited for.
        unsafe {
            if let Some(pool) = self.timestamps {
                device.cmd_reset_query_pool(cmd.raw(), pool, 2 * query, 2);
                device.cmd_write_timestamp2(cmd.raw(), vk::PipelineStageFlags2::ALL_COMMANDS, pool, 2 * query);
            }
            if let Some(pool) = self.statistics {
                device.cmd_reset_query_pool(cmd.raw(), pool, query, 1);
                device.cmd_begin_query(cmd.raw(), pool, query, vk::QueryControlFlags::empty());
            }
        }
        self.settle(cmd);
    }

    /// Ends the pass that was begun last, outside of rendering.
    pub fn end(&mut self, cmd: &mut CommandEncoder) {
        let Some((slot, pass)) = self.open.take() else { return };
        let query = self.query(slot, pass);
        let device = self.ctx.device();
        // SAFETY: recording, outside of rendering; the queries were begun in this command buffer.
        unsafe {
            if let Some(pool) = self.statistics {
                device.cmd_end_query(cmd.raw(), pool, query);
            }
            if let Some(pool) = self.timestamps {
                device.cmd_write_timestamp2(cmd.raw(), vk::PipelineStageFlags2::ALL_COMMANDS, pool, 2 * query + 1);
            }
        }
        self.settle(cmd);
    }

    /// On a CPU device, lets the timestamp just written be taken before anything later begins.
    ///
    /// llvmpipe writes a timestamp as a command of each tile of the scene that it is collecting, and draws recorded
    /// after it join that scene: what is read is then the time at which the last tile began. A barrier ends the scene.
    fn settle(&self, cmd: &mut CommandEncoder) {
        if self.ctx.is_cpu() {
            let all = vk::PipelineStageFlags2::ALL_COMMANDS;
            let access = vk::AccessFlags2::MEMORY_READ | vk::AccessFlags2::MEMORY_WRITE;
            let any = Access::new(all, access, vk::ImageLayout::UNDEFINED);
            cmd.memory_barrier(any, any);
        }
    }

    /// The passes of the last frame in `slot`, in order, and forgets them. Never waits: call it when the slot's frame
    /// has run, that is after [`super::Frames::begin`] has given the slot again, or after a wait.
    pub fn resolve(&mut self, slot: usize) -> Vec<PassTime> {
        let names = std::mem::take(&mut self.slots[slot]);
        let measure = |(pass, name)| {
            let timed = pass < self.max_passes;
            PassTime {
                name,
                gpu_ms: timed.then(|| self.milliseconds(slot, pass)).flatten(),
                statistics: timed.then(|| self.counts(slot, pass)).flatten(),
            }
        };
        names.into_iter().enumerate().map(measure).collect()
    }

    fn query(&self, slot: usize, pass: usize) -> u32 {
        (slot * self.max_passes + pass) as u32
    }

    fn milliseconds(&self, slot: usize, pass: usize) -> Option<f64> {
        let mut ticks = [0u64; 2];
        let first = 2 * self.query(slot, pass);
        // SAFETY: the range is the pool's own.
        unsafe {
            self.ctx.device().get_query_pool_results(self.timestamps?, first, &mut ticks, vk::QueryResultFlags::TYPE_64)
        }
        .ok()?;
        // The upper bits are undefined; the difference is right even if the counter wrapped between.
        let mask = u64::MAX >> (64 - self.ctx.inner().timestamp_bits.min(64));
        let elapsed = ticks[1].wrapping_sub(ticks[0]) & mask;
        Some(elapsed as f64 * f64::from(self.ctx.limits().timestamp_period) * 1e-6)
    }

    fn counts(&self, slot: usize, pass: usize) -> Option<Statistics> {
        use vk::QueryPipelineStatisticFlags as F;
        // Room for every counter there is; the driver packs those that were asked for, in the order of their bits.
        let mut packed = [[0u64; 16]];
        let query = self.query(slot, pass);
        let flags = vk::QueryResultFlags::TYPE_64;
        // SAFETY: the range is the pool's own, and the element is at least as large as the counters.
        unsafe { self.ctx.device().get_query_pool_results(self.statistics?, query, &mut packed, flags) }.ok()?;
        let get = |flag: F| {
            let below = self.flags.as_raw() & (flag.as_raw() - 1);
            self.flags.contains(flag).then(|| packed[0][below.count_ones() as usize])
        };
        let always = |flag| get(flag).unwrap_or_default();
        Some(Statistics {
            input_vertices: always(F::INPUT_ASSEMBLY_VERTICES),
            input_primitives: always(F::INPUT_ASSEMBLY_PRIMITIVES),
            vertex_invocations: always(F::VERTEX_SHADER_INVOCATIONS),
            geometry_invocations: get(F::GEOMETRY_SHADER_INVOCATIONS),
            geometry_primitives: get(F::GEOMETRY_SHADER_PRIMITIVES),
            clipping_invocations: always(F::CLIPPING_INVOCATIONS),
            clipping_primitives: always(F::CLIPPING_PRIMITIVES),
            fragment_invocations: always(F::FRAGMENT_SHADER_INVOCATIONS),
            compute_invocations: always(F::COMPUTE_SHADER_INVOCATIONS),
            task_invocations: get(F::TASK_SHADER_INVOCATIONS_EXT),
            mesh_invocations: get(F::MESH_SHADER_INVOCATIONS_EXT),
        })
    }
}

impl Drop for PassTimers {
    fn drop(&mut self) {
        for pool in self.timestamps.into_iter().chain(self.statistics) {
            self.ctx.retire(Retired::QueryPool(pool));
        }
    }
}
