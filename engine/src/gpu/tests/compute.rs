//! Compute, descriptors, uploads and lifetimes.

use super::*;

const DOUBLE: &str = "#version 460
layout(local_size_x = 4) in;
layout(set = 0, binding = 0) readonly buffer Source { uint items[]; } source;
layout(set = 0, binding = 1) writeonly buffer Sink { uint items[]; } sink;
layout(set = 1, binding = 0) uniform sampler2D tint;
void main() {
    uint i = gl_GlobalInvocationID.x;
    sink.items[i] = 2 * source.items[i] + uint(textureLod(tint, vec2(0.5), 0).r * 255.0 + 0.5);
}";

struct Setup {
    ctx: Context,
    pipeline: Pipeline,
    source: Buffer,
    sink: Buffer,
    tint: Image,
    sampler: Sampler,
}

fn setup(test: &str) -> Setup {
    let dir = TempDir::new(test);
    let shader = compiler(&dir, &[("d.comp", DOUBLE)]).compile("d.comp", ShaderStage::Compute, &[]).unwrap();
    let ctx = context(&[]);
    let pipeline = Pipeline::compute(&ctx, "double", &shader).unwrap();
    let mut uploader = Uploader::new(&ctx).unwrap();
    let source = uploader.buffer("source", vk::BufferUsageFlags::STORAGE_BUFFER, &[1u32, 2, 3, 4]).unwrap();
    let desc = ImageDesc { name: "tint", format: vk::Format::R8_UNORM, ..ImageDesc::default() };
    let tint = uploader.image(&desc, &[5]).unwrap();
    uploader.finish().unwrap();
    let sink = Buffer::new(
        &ctx,
        &BufferDesc {
            name: "sink",
            size: 16,
            usage: vk::BufferUsageFlags::STORAGE_BUFFER,
            location: MemoryLocation::GpuToCpu,
        },
    )
    .unwrap();
    let sampler = Sampler::new(&ctx, &SamplerDesc::default()).unwrap();
    Setup { ctx, pipeline, source, sink, tint, sampler }
}

#[test]
fn a_compute_shader_doubles_a_buffer() {
    let Setup { ctx, pipeline, source, sink, tint, sampler } = setup("compute");
    let buffers = [("source", Binding::Buffer(&source)), ("sink", Binding::Buffer(&sink))];
    let set0 = DescriptorSet::new(&ctx, &pipeline, 0, &buffers).unwrap();
    let set1 = DescriptorSet::new(&ctx, &pipeline, 1, &[("tint", Binding::Image(&tint, &sampler))]).unwrap();
    run_once(&ctx, |cmd| {
        cmd.bind_pipeline(&pipeline);
        cmd.bind_set(&pipeline, 0, &set0);
        cmd.bind_set(&pipeline, 1, &set1);
        cmd.dispatch(1, 1, 1);
        cmd.buffer_barrier(&sink, Access::COMPUTE_WRITE, Access::HOST_READ);
        Ok(())
    })
    .unwrap();
    assert_eq!(sink.read::<u32>().unwrap(), [7, 9, 11, 13]);
    let report = ctx.memory_report();
    assert!(report.iter().any(|(name, bytes)| name == "sink" && *bytes >= 16), "{report:?}");
    drop((pipeline, source, sink, tint, set0, set1));
    assert!(ctx.memory_report().is_empty());
    assert_clean(ctx);
}

#[test]
fn a_wrong_name_or_kind_names_pipeline_set_and_binding() {
    let Setup { ctx, pipeline, source, sink, tint, sampler } = setup("names");
    let image = Binding::Image(&tint, &sampler);
    let (from, to) = (("source", Binding::Buffer(&source)), ("sink", Binding::Buffer(&sink)));
    let error = |set, bindings: &[(&str, Binding<'_>)]| {
        let text = DescriptorSet::new(&ctx, &pipeline, set, bindings).err().unwrap().to_string();
        assert!(text.contains("'double'") && text.contains(&format!("set {set}")), "{text}");
        text
    };
    assert!(error(0, &[from]).contains("binding 1 'sink'"));
    assert!(error(0, &[from, to, ("other", image)]).contains("no shader uses 'other'; used are: source, sink"));
    assert!(error(1, &[("tint", from.1)]).contains("binding 0 'tint': the shader wants COMBINED_IMAGE_SAMPLER"));
    assert!(error(0, &[from, ("sink", Binding::BufferRange(&sink, 8, 16))]).contains("binding 1"));
    assert!(DescriptorSet::with_optional(&ctx, &pipeline, 0, &[from, to], &[("other", image)]).is_ok());
    drop((pipeline, source, sink, tint));
    assert_clean(ctx);
}

#[test]
fn what_is_dropped_while_a_frame_may_use_it_lives_on() {
    let Setup { ctx, pipeline, source, sink, tint, sampler } = setup("lifetimes");
    let mut frames = Frames::new(&ctx, 2).unwrap();
    for _ in 0..600 {
        // More sets than a pool holds; each is dropped before its frame is even submitted.
        let mut frame = frames.begin().unwrap();
        let scratch = Buffer::new(
            &ctx,
            &BufferDesc {
                name: "scratch",
                size: 16,
                usage: vk::BufferUsageFlags::STORAGE_BUFFER,
                location: MemoryLocation::GpuOnly,
            },
        )
        .unwrap();
        let buffers = [("source", Binding::Buffer(&source)), ("sink", Binding::Buffer(&scratch))];
        let set0 = DescriptorSet::new(&ctx, &pipeline, 0, &buffers).unwrap();
        let set1 = DescriptorSet::new(&ctx, &pipeline, 1, &[("tint", Binding::Image(&tint, &sampler))]).unwrap();
        frame.cmd.bind_pipeline(&pipeline);
        frame.cmd.bind_set(&pipeline, 0, &set0);
        frame.cmd.bind_set(&pipeline, 1, &set1);
        frame.cmd.dispatch(1, 1, 1);
        drop((scratch, set0, set1));
        frames.submit(frame).unwrap();
    }
    let count = || ctx.memory_report().iter().filter(|(name, _)| name == "scratch").count();
    assert!((1..=2).contains(&count()), "{} scratch buffers for 2 frames in flight", count());
    frames.wait().unwrap();
    assert_eq!(count(), 0);
    let held: Vec<_> = (0..600)
        .map(|_| DescriptorSet::new(&ctx, &pipeline, 1, &[("tint", Binding::Image(&tint, &sampler))]).unwrap())
        .collect();
    drop((held, frames, pipeline, source, sink, tint));
    assert_clean(ctx);
}

#[test]
fn a_frame_that_is_not_submitted_frees_its_slot() {
    let ctx = context(&[]);
    let mut frames = Frames::new(&ctx, 1).unwrap();
    let first = frames.begin().unwrap();
    assert!(frames.begin().is_err(), "the only slot is still being recorded");
    drop(first);
    let second = frames.begin().unwrap();
    frames.submit_and_wait(second).unwrap();
    drop(frames);
    assert_clean(ctx);
}

#[test]
fn uploads_larger_than_the_staging_memory_arrive_whole() {
    let ctx = context(&[]);
    let words: Vec<u32> = (0..5 << 20).collect();
    let mut uploader = Uploader::new(&ctx).unwrap();
    let usage = vk::BufferUsageFlags::STORAGE_BUFFER | vk::BufferUsageFlags::TRANSFER_SRC;
    let big = uploader.buffer("big", usage, &words).unwrap();
    let usage = vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_SRC;
    let format = vk::Format::R32_UINT;
    let desc = ImageDesc { name: "big image", extent: [2560, 2048], format, usage, ..ImageDesc::default() };
    let image = uploader.image(&desc, bytemuck::cast_slice(&words)).unwrap();
    uploader.finish().unwrap();
    let back = Buffer::new(
        &ctx,
        &BufferDesc {
            name: "back",
            size: big.size(),
            usage: vk::BufferUsageFlags::TRANSFER_DST,
            location: MemoryLocation::GpuToCpu,
        },
    )
    .unwrap();
    run_once(&ctx, |cmd| {
        cmd.copy_buffer(&big, 0, &back, 0, big.size());
        cmd.buffer_barrier(&back, Access::TRANSFER_DST, Access::HOST_READ);
        Ok(())
    })
    .unwrap();
    assert!(back.read::<u32>().unwrap() == words);
    assert!(read_image(&ctx, &image, Access::SHADER_READ).unwrap() == bytemuck::cast_slice::<u32, u8>(&words));
    drop((big, image, back));
    assert_clean(ctx);
}

#[test]
fn mips_are_averages_also_of_srgb() {
    let ctx = context(&[]);
    let mut uploader = Uploader::new(&ctx).unwrap();
    let usage = vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_SRC;
    for (format, mean) in [(vk::Format::R8G8B8A8_UNORM, 128), (vk::Format::R8G8B8A8_SRGB, 188)] {
        // Black and white columns: their mean in linear light is 188 as sRGB.
        let texels = [0u32, !0].repeat(8 * 4);
        let desc = ImageDesc { name: "stripes", extent: [8, 8], format, usage, ..ImageDesc::default() };
        let image = uploader.image_with_mips(&desc, bytemuck::cast_slice(&texels)).unwrap();
        assert_eq!(image.mips(), 4);
        let small = ImageDesc { name: "mip 3", extent: [1, 1], ..desc };
        let small = Image::new(&ctx, &ImageDesc { usage: usage | vk::ImageUsageFlags::TRANSFER_DST, ..small }).unwrap();
        std::mem::replace(&mut uploader, Uploader::new(&ctx).unwrap()).finish().unwrap();
        run_once(&ctx, |cmd| {
            cmd.image_barrier(&image, Access::SHADER_READ, Access::TRANSFER_SRC);
            cmd.image_barrier(&small, Access::UNDEFINED, Access::TRANSFER_DST);
            cmd.blit(&image, 3, &small, 0, vk::Filter::NEAREST);
            Ok(())
        })
        .unwrap();
        let texel = read_image(&ctx, &small, Access::TRANSFER_DST).unwrap();
        assert!(texel[0].abs_diff(mean) <= 1, "{format:?}: {texel:?}");
    }
    drop(uploader);
    assert_clean(ctx);
}
