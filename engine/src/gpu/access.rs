//! Who touches a resource, how, and in which layout: the two sides of a barrier.

use ash::vk::{AccessFlags2 as A, ImageLayout as L, PipelineStageFlags2 as S};

/// One side of a barrier. For buffers the layout is ignored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Access {
    /// Pipeline stages.
    pub stage: S,
    /// Kinds of access within them.
    pub access: A,
    /// Image layout.
    pub layout: L,
}

impl Access {
    /// As `from`: earlier content is not needed. Nothing is waited for, so only for an image's first use ever.
    pub const UNDEFINED: Access = Access::new(S::NONE, A::NONE, L::UNDEFINED);
    /// A colour attachment, blended or cleared, also the target of a resolve.
    pub const COLOR_WRITE: Access = Access::new(
        S::COLOR_ATTACHMENT_OUTPUT,
        A::from_raw(A::COLOR_ATTACHMENT_WRITE.as_raw() | A::COLOR_ATTACHMENT_READ.as_raw()),
        L::COLOR_ATTACHMENT_OPTIMAL,
    );
    /// The depth attachment, tested and written.
    pub const DEPTH_WRITE: Access = Access::new(
        S::from_raw(S::EARLY_FRAGMENT_TESTS.as_raw() | S::LATE_FRAGMENT_TESTS.as_raw()),
        A::from_raw(A::DEPTH_STENCIL_ATTACHMENT_WRITE.as_raw() | A::DEPTH_STENCIL_ATTACHMENT_READ.as_raw()),
        L::DEPTH_STENCIL_ATTACHMENT_OPTIMAL,
    );
    /// Sampled, or read from a buffer, by a fragment shader.
    pub const FRAGMENT_READ: Access = Access::shader_read(S::FRAGMENT_SHADER);
    /// Sampled, or read from a buffer, by a compute shader.
    pub const COMPUTE_READ: Access = Access::shader_read(S::COMPUTE_SHADER);
    /// Read by any graphics or compute shader.
    pub const SHADER_READ: Access =
        Access::shader_read(S::from_raw(S::ALL_GRAPHICS.as_raw() | S::COMPUTE_SHADER.as_raw()));
    /// A storage image or buffer of a compute shader.
    pub const COMPUTE_WRITE: Access = Access::shader_write(S::COMPUTE_SHADER);
    /// A storage buffer of a task shader.
    pub const TASK_WRITE: Access = Access::shader_write(S::TASK_SHADER_EXT);
    /// A storage image or buffer of a fragment shader.
    pub const FRAGMENT_WRITE: Access = Access::shader_write(S::FRAGMENT_SHADER);
    /// Source of a copy or blit.
    pub const TRANSFER_SRC: Access = Access::new(S::ALL_TRANSFER, A::TRANSFER_READ, L::TRANSFER_SRC_OPTIMAL);
    /// Target of a copy, blit or fill.
    pub const TRANSFER_DST: Access = Access::new(S::ALL_TRANSFER, A::TRANSFER_WRITE, L::TRANSFER_DST_OPTIMAL);
    /// Index buffer.
    pub const INDEX_READ: Access = Access::new(S::INDEX_INPUT, A::INDEX_READ, L::UNDEFINED);
    /// Indirect commands.
    pub const INDIRECT_READ: Access = Access::new(S::DRAW_INDIRECT, A::INDIRECT_COMMAND_READ, L::UNDEFINED);
    /// Read by the CPU after the submission's fence.
    pub const HOST_READ: Access = Access::new(S::HOST, A::HOST_READ, L::GENERAL);
    /// Shown on screen. The present waits for a semaphore, so as `to` no stage is named.
    pub const PRESENT: Access = Access::new(S::NONE, A::NONE, L::PRESENT_SRC_KHR);
    /// A swapchain image just acquired, old content dropped: waits where the acquire semaphore is waited for.
    pub const ACQUIRED: Access = Access::new(S::ALL_COMMANDS, A::NONE, L::UNDEFINED);

    /// Any combination.
    pub const fn new(stage: S, access: A, layout: L) -> Access {
        Access { stage, access, layout }
    }

    /// Sampled, or read from a buffer, in `stage`.
    pub const fn shader_read(stage: S) -> Access {
        Access::new(stage, A::SHADER_READ, L::SHADER_READ_ONLY_OPTIMAL)
    }

    /// Storage in `stage`, read and written.
    pub const fn shader_write(stage: S) -> Access {
        Access::new(stage, A::from_raw(A::SHADER_READ.as_raw() | A::SHADER_WRITE.as_raw()), L::GENERAL)
    }

    /// The same access, but the content is dropped: the layout of `from` becomes undefined. For a target that is
    /// written anew each frame.
    pub const fn discarded(self) -> Access {
        Access::new(self.stage, self.access, L::UNDEFINED)
    }
}
