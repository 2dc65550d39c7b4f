//! Barriers and copies of a [`CommandEncoder`].

use ash::vk;

use super::{
    access::Access,
    encoder::CommandEncoder,
    memory::{Buffer, Image},
};

impl CommandEncoder {
    /// All mips: waits for `from`, makes its writes visible to `to`, changes the layout.
    pub fn image_barrier(&mut self, image: &Image, from: Access, to: Access) {
        self.image_barrier_mips(image, 0, image.mips(), from, to);
    }

    /// [`Self::image_barrier`] for `count` mips from `base` on.
    pub fn image_barrier_mips(&mut self, image: &Image, base: u32, count: u32, from: Access, to: Access) {
        let range = image.all().base_mip_level(base).level_count(count);
        let barrier = [vk::ImageMemoryBarrier2::default()
            .src_stage_mask(from.stage)
            .src_access_mask(from.access)
            .old_layout(from.layout)
            .dst_stage_mask(to.stage)
            .dst_access_mask(to.access)
            .new_layout(to.layout)
            .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .image(image.handle())
            .subresource_range(range)];
        self.barrier(&vk::DependencyInfo::default().image_memory_barriers(&barrier));
    }

    /// The whole buffer: waits for `from`, makes its writes visible to `to`.
    pub fn buffer_barrier(&mut self, buffer: &Buffer, from: Access, to: Access) {
        let barrier = [vk::BufferMemoryBarrier2::default()
            .src_stage_mask(from.stage)
            .src_access_mask(from.access)
            .dst_stage_mask(to.stage)
            .dst_access_mask(to.access)
            .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .buffer(buffer.handle())
            .size(vk::WHOLE_SIZE)];
        self.barrier(&vk::DependencyInfo::default().buffer_memory_barriers(&barrier));
    }

    /// Everything: waits for `from`, makes its writes visible to `to`.
    pub fn memory_barrier(&mut self, from: Access, to: Access) {
        let barrier = [vk::MemoryBarrier2::default()
            .src_stage_mask(from.stage)
            .src_access_mask(from.access)
            .dst_stage_mask(to.stage)
            .dst_access_mask(to.access)];
        self.barrier(&vk::DependencyInfo::default().memory_barriers(&barrier));
    }

    fn barrier(&mut self, info: &vk::DependencyInfo<'_>) {
        // SAFETY: recording, outside a pass; the resources are alive.
        unsafe { self.context().device().cmd_pipeline_barrier2(self.raw(), info) };
    }

    /// Mip 0 of an image (at [`Access::TRANSFER_SRC`]), tightly packed, to the buffer's start.
    pub fn copy_image_to_buffer(&mut self, image: &Image, buffer: &Buffer) {
        let [width, height] = image.extent();
        let regions = [vk::BufferImageCopy2::default().image_subresource(image.level(0)).image_extent(vk::Extent3D {
            width,
            height,
            depth: 1,
        })];
        let info = vk::CopyImageToBufferInfo2::default()
            .src_image(image.handle())
            .src_image_layout(Access::TRANSFER_SRC.layout)
            .dst_buffer(buffer.handle())
            .regions(&regions);
        // SAFETY: recording, outside a pass; both are alive.
        unsafe { self.context().device().cmd_copy_image_to_buffer2(self.raw(), &info) };
    }

    /// Tightly packed rows from `offset` of the buffer to the rows `first_row..first_row + rows` of mip 0 of an image
    /// (at [`Access::TRANSFER_DST`]).
    pub fn copy_buffer_to_image(&mut self, buffer: &Buffer, offset: u64, image: &Image, first_row: u32, rows: u32) {
        let regions = [vk::BufferImageCopy2::default()
            .buffer_offset(offset)
            .image_subresource(image.level(0))
            .image_offset(vk::Offset3D { x: 0, y: first_row as i32, z: 0 })
            .image_extent(vk::Extent3D { width: image.extent()[0], height: rows, depth: 1 })];
        let info = vk::CopyBufferToImageInfo2::default()
            .src_buffer(buffer.handle())
            .dst_image(image.handle())
            .dst_image_layout(Access::TRANSFER_DST.layout)
            .regions(&regions);
        // SAFETY: recording, outside a pass; both are alive.
        unsafe { self.context().device().cmd_copy_buffer_to_image2(self.raw(), &info) };
    }

    /// `size` bytes between two buffers.
    pub fn copy_buffer(&mut self, from: &Buffer, from_offset: u64, to: &Buffer, to_offset: u64, size: u64) {
        let regions = [vk::BufferCopy2::default().src_offset(from_offset).dst_offset(to_offset).size(size)];
        let info = vk::CopyBufferInfo2::default().src_buffer(from.handle()).dst_buffer(to.handle()).regions(&regions);
        // SAFETY: recording, outside a pass; both are alive.
        unsafe { self.context().device().cmd_copy_buffer2(self.raw(), &info) };
    }

    /// The whole buffer becomes this word.
    pub fn fill_buffer(&mut self, buffer: &Buffer, word: u32) {
        // SAFETY: recording, outside a pass; the buffer is alive.
        unsafe { self.context().device().cmd_fill_buffer(self.raw(), buffer.handle(), 0, vk::WHOLE_SIZE, word) };
    }

    /// Scales a whole mip of one image (at [`Access::TRANSFER_SRC`]) to a whole mip of another, or of the same (at
    /// [`Access::TRANSFER_DST`]).
    pub fn blit(&mut self, from: &Image, from_mip: u32, to: &Image, to_mip: u32, filter: vk::Filter) {
        let corners = |[width, height]: [u32; 2]| {
            [vk::Offset3D::default(), vk::Offset3D { x: width as i32, y: height as i32, z: 1 }]
        };
        let regions = [vk::ImageBlit2::default()
            .src_subresource(from.level(from_mip))
            .src_offsets(corners(from.level_extent(from_mip)))
            .dst_subresource(to.level(to_mip))
            .dst_offsets(corners(to.level_extent(to_mip)))];
        let info = vk::BlitImageInfo2::default()
            .src_image(from.handle())
            .src_image_layout(Access::TRANSFER_SRC.layout)
            .dst_image(to.handle())
            .dst_image_layout(Access::TRANSFER_DST.layout)
            .regions(&regions)
            .filter(filter);
        // SAFETY: recording, outside a pass; both are alive.
        unsafe { self.context().device().cmd_blit_image2(self.raw(), &info) };
    }

    /// Copies the part of an image (at [`Access::TRANSFER_SRC`]) right of column `from_column` to the same place of another
    /// of its size and format (at [`Access::TRANSFER_DST`]).
    pub fn copy_right(&mut self, from: &Image, to: &Image, from_column: u32) {
        let [width, height] = from.extent();
        if from_column >= width {
            return;
        }
        let at = vk::Offset3D { x: from_column as i32, y: 0, z: 0 };
        let regions = [vk::ImageCopy2::default()
            .src_subresource(from.level(0))
            .src_offset(at)
            .dst_subresource(to.level(0))
            .dst_offset(at)
            .extent(vk::Extent3D { width: width - from_column, height, depth: 1 })];
        let info = vk::CopyImageInfo2::default()
            .src_image(from.handle())
            .src_image_layout(Access::TRANSFER_SRC.layout)
            .dst_image(to.handle())
            .dst_image_layout(Access::TRANSFER_DST.layout)
            .regions(&regions);
        // SAFETY: recording, outside a pass; both are alive.
        unsafe { self.context().device().cmd_copy_image2(self.raw(), &info) };
    }
}
