//! Triangles through every kind of geometry stage, with exact pixels.

use super::*;

const SIZE: [u32; 2] = [8, 8];
const FORMAT: vk::Format = vk::Format::R8G8B8A8_UNORM;

/// Covers the pixels whose centre is left of x + y = 8: those with column + row < 7; the diagonal itself is left out,
/// by lying on a right edge.
const VERTEX: &str = "#version 460
void main() {
    vec2 corners[3] = vec2[](vec2(-1, -1), vec2(-1, 1), vec2(1, -1));
    gl_Position = vec4(corners[gl_VertexIndex], 0.5, 1);
}";

const POINT: &str = "#version 460
void main() { gl_Position = vec4(-1, -1, 0.5, 1); }";

const GEOMETRY: &str = "#version 460
layout(points) in;
layout(triangle_strip, max_vertices = 3) out;
void main() {
    vec2 steps[3] = vec2[](vec2(0, 0), vec2(0, 2), vec2(2, 0));
    for (int i = 0; i < 3; ++i) {
        gl_Position = gl_in[0].gl_Position + vec4(steps[i], 0, 0);
        EmitVertex();
    }
    EndPrimitive();
}";

const MESH: &str = "#version 460
#extension GL_EXT_mesh_shader : require
layout(local_size_x = 3) in;
layout(triangles, max_vertices = 3, max_primitives = 1) out;
void main() {
    vec2 corners[3] = vec2[](vec2(-1, -1), vec2(-1, 1), vec2(1, -1));
    SetMeshOutputsEXT(3, 1);
    gl_MeshVerticesEXT[gl_LocalInvocationIndex].gl_Position = vec4(corners[gl_LocalInvocationIndex], 0.5, 1);
    if (gl_LocalInvocationIndex == 0) gl_PrimitiveTriangleIndicesEXT[0] = uvec3(0, 1, 2);
}";

const TASK: &str = "#version 460
#extension GL_EXT_mesh_shader : require
layout(local_size_x = 1) in;
void main() { EmitMeshTasksEXT(1, 1, 1); }";

const FRAGMENT: &str = "#version 460
layout(push_constant) uniform Push { vec4 color; } push;
layout(location = 0) out vec4 color;
void main() { color = push.color; }";

fn pixel(rgba: [u8; 4]) -> u32 {
    u32::from_le_bytes(rgba)
}

fn target(ctx: &Context, name: &str, samples: vk::SampleCountFlags) -> Image {
    let usage = vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::TRANSFER_SRC;
    Image::new(ctx, &ImageDesc { name, extent: SIZE, format: FORMAT, samples, usage, ..ImageDesc::default() }).unwrap()
}

/// Draws with `record` into a cleared target with a depth buffer, and checks every pixel.
fn draw_and_check(ctx: &Context, pipeline: &Pipeline, record: impl FnOnce(&mut CommandEncoder)) -> Vec<PassTime> {
    let color = target(ctx, "target", vk::SampleCountFlags::TYPE_1);
    let depth = Image::new(
        ctx,
        &ImageDesc {
            name: "depth",
            extent: SIZE,
            format: vk::Format::D32_SFLOAT,
            usage: vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT | vk::ImageUsageFlags::TRANSFER_SRC,
            ..ImageDesc::default()
        },
    )
    .unwrap();
    let mut frames = Frames::new(ctx, 2).unwrap();
    let mut timers = PassTimers::new(ctx, 4, frames.in_flight()).unwrap();
    let mut frame = frames.begin().unwrap();
    let slot = frame.slot();
    let cmd = &mut frame.cmd;
    cmd.image_barrier(&color, Access::UNDEFINED, Access::COLOR_WRITE);
    cmd.image_barrier(&depth, Access::UNDEFINED, Access::DEPTH_WRITE);
    timers.begin(cmd, slot, "triangle");
    cmd.begin_rendering(&RenderingDesc {
        name: "triangle",
        color: &[Attachment { image: &color, load: Load::Clear([0.0, 0.0, 0.0, 1.0]), store: true, resolve: None }],
        depth: Some(DepthAttachment { image: &depth, clear: Some(0.0), store: true }),
        extent: SIZE,
    });
    cmd.bind_pipeline(pipeline);
    cmd.push(pipeline, &[1.0f32, 0.2, 0.0, 1.0]);
    record(cmd);
    cmd.end_rendering();
    timers.end(cmd);
    frames.submit_and_wait(frame).unwrap();

    let pixels: Vec<u32> = bytemuck::pod_collect_to_vec(&read_image(ctx, &color, Access::COLOR_WRITE).unwrap());
    let depths: Vec<f32> = bytemuck::pod_collect_to_vec(&read_image(ctx, &depth, Access::DEPTH_WRITE).unwrap());
    for (i, (pixel_at, depth_at)) in pixels.into_iter().zip(depths).enumerate() {
        let inside = i % 8 + i / 8 < 7;
        let expected = if inside { pixel([255, 51, 0, 255]) } else { pixel([0, 0, 0, 255]) };
        assert_eq!(pixel_at, expected, "column {}, row {}", i % 8, i / 8);
        assert_eq!(depth_at, if inside { 0.5 } else { 0.0 });
    }
    timers.resolve(slot)
}

fn graphics(ctx: &Context, shaders: &[&std::sync::Arc<Shader>], topology: vk::PrimitiveTopology) -> Pipeline {
    Pipeline::graphics(
        ctx,
        &GraphicsDesc {
            name: "triangle",
            shaders,
            color_formats: &[FORMAT],
            depth_format: Some(vk::Format::D32_SFLOAT),
            depth: DepthState::REVERSED,
            cull: vk::CullModeFlags::BACK,
            topology,
            ..GraphicsDesc::default()
        },
    )
    .unwrap()
}

#[test]
fn a_vertex_and_a_fragment_shader_draw_a_triangle() {
    let dir = TempDir::new("triangle");
    let compiler = compiler(&dir, &[("t.vert", VERTEX), ("t.frag", FRAGMENT)]);
    let ctx = context(&[Feature::PipelineStatistics]);
    let vertex = compiler.compile("t.vert", ShaderStage::Vertex, &[]).unwrap();
    let fragment = compiler.compile("t.frag", ShaderStage::Fragment, &[]).unwrap();
    let pipeline = graphics(&ctx, &[&vertex, &fragment], vk::PrimitiveTopology::TRIANGLE_LIST);
    assert_eq!(pipeline.execution_models(), [ShaderStage::Vertex, ShaderStage::Fragment]);
    let times = draw_and_check(&ctx, &pipeline, |cmd| cmd.draw(3, 1, 0, 0));
    assert_eq!(times.len(), 1);
    assert_eq!(times[0].name, "triangle");
    assert!(times[0].gpu_ms.unwrap() > 0.0);
    let counts = times[0].statistics.unwrap();
    assert_eq!((counts.input_vertices, counts.input_primitives, counts.clipping_primitives), (3, 1, 1));
    assert!(counts.fragment_invocations >= 28, "{counts:?}");
    assert_eq!((counts.geometry_primitives, counts.mesh_invocations), (None, None));
    drop(pipeline);
    assert_clean(ctx);
}

#[test]
fn a_geometry_shader_draws_the_same() {
    let dir = TempDir::new("geometry");
    let compiler = compiler(&dir, &[("t.vert", POINT), ("t.geom", GEOMETRY), ("t.frag", FRAGMENT)]);
    let ctx = context(&[Feature::GeometryShader, Feature::PipelineStatistics]);
    let vertex = compiler.compile("t.vert", ShaderStage::Vertex, &[]).unwrap();
    let geometry = compiler.compile("t.geom", ShaderStage::Geometry, &[]).unwrap();
    let fragment = compiler.compile("t.frag", ShaderStage::Fragment, &[]).unwrap();
    let pipeline = graphics(&ctx, &[&vertex, &geometry, &fragment], vk::PrimitiveTopology::POINT_LIST);
    let times = draw_and_check(&ctx, &pipeline, |cmd| cmd.draw(1, 1, 0, 0));
    let counts = times[0].statistics.unwrap();
    assert_eq!((counts.geometry_invocations, counts.geometry_primitives), (Some(1), Some(1)));
    assert!(ctx.enabled_extensions().is_empty(), "the geometry path enables no mesh shaders");
    drop(pipeline);
    assert_clean(ctx);
}

#[test]
fn a_mesh_shader_draws_the_same() {
    let dir = TempDir::new("mesh");
    let compiler = compiler(&dir, &[("t.mesh", MESH), ("t.frag", FRAGMENT)]);
    let ctx = context(&[Feature::MeshShader, Feature::PipelineStatistics, Feature::MeshShaderQueries]);
    let mesh = compiler.compile("t.mesh", ShaderStage::Mesh, &[]).unwrap();
    assert_eq!(mesh.reflection.local_size, Some([3, 1, 1]));
    let fragment = compiler.compile("t.frag", ShaderStage::Fragment, &[]).unwrap();
    let pipeline = graphics(&ctx, &[&mesh, &fragment], vk::PrimitiveTopology::TRIANGLE_LIST);
    assert_eq!(pipeline.execution_models(), [ShaderStage::Mesh, ShaderStage::Fragment]);
    let times = draw_and_check(&ctx, &pipeline, |cmd| cmd.draw_mesh_tasks(1, 1, 1));
    assert_eq!(times[0].statistics.unwrap().mesh_invocations, Some(3));
    assert_eq!(ctx.enabled_extensions(), ["VK_EXT_mesh_shader"]);
    assert!(ctx.mesh_limits().unwrap().max_output_vertices >= 256);
    drop(pipeline);
    assert_clean(ctx);
}

#[test]
fn a_task_shader_launches_the_mesh_shader() {
    let dir = TempDir::new("task");
    let compiler = compiler(&dir, &[("t.task", TASK), ("t.mesh", MESH), ("t.frag", FRAGMENT)]);
    let ctx = context(&[Feature::MeshShader, Feature::TaskShader]);
    let task = compiler.compile("t.task", ShaderStage::Task, &[]).unwrap();
    let mesh = compiler.compile("t.mesh", ShaderStage::Mesh, &[]).unwrap();
    let fragment = compiler.compile("t.frag", ShaderStage::Fragment, &[]).unwrap();
    let pipeline = graphics(&ctx, &[&task, &mesh, &fragment], vk::PrimitiveTopology::TRIANGLE_LIST);
    let times = draw_and_check(&ctx, &pipeline, |cmd| cmd.draw_mesh_tasks(1, 1, 1));
    assert_eq!(times[0].statistics, None, "not asked for");
    drop(pipeline);
    assert_clean(ctx);
}

#[test]
fn four_samples_resolve_to_their_mean() {
    let dir = TempDir::new("msaa");
    let compiler = compiler(&dir, &[("t.vert", VERTEX), ("t.frag", FRAGMENT)]);
    let ctx = context(&[]);
    let vertex = compiler.compile("t.vert", ShaderStage::Vertex, &[]).unwrap();
    let fragment = compiler.compile("t.frag", ShaderStage::Fragment, &[]).unwrap();
    let samples = vk::SampleCountFlags::TYPE_4;
    let desc = GraphicsDesc {
        name: "triangle of 4 samples",
        shaders: &[&vertex, &fragment],
        color_formats: &[FORMAT],
        samples,
        ..GraphicsDesc::default()
    };
    let pipeline = Pipeline::graphics(&ctx, &desc).unwrap();
    let many = target(&ctx, "samples", samples);
    let one = target(&ctx, "resolved", vk::SampleCountFlags::TYPE_1);
    run_once(&ctx, |cmd| {
        cmd.image_barrier(&many, Access::UNDEFINED, Access::COLOR_WRITE);
        cmd.image_barrier(&one, Access::UNDEFINED, Access::COLOR_WRITE);
        let color = Attachment { image: &many, load: Load::Clear([0.0; 4]), store: false, resolve: Some(&one) };
        cmd.begin_rendering(&RenderingDesc { name: "samples", color: &[color], depth: None, extent: SIZE });
        cmd.bind_pipeline(&pipeline);
        cmd.push(&pipeline, &[1.0f32; 4]);
        cmd.draw(3, 1, 0, 0);
        cmd.end_rendering();
        Ok(())
    })
    .unwrap();
    let bytes = read_image(&ctx, &one, Access::COLOR_WRITE).unwrap();
    let red = |column: usize, row: usize| bytes[(row * 8 + column) * 4];
    assert_eq!((red(0, 0), red(7, 7)), (255, 0));
    assert!((1..255).contains(&red(3, 4)), "the diagonal crosses this pixel: {}", red(3, 4));
    drop((pipeline, many, one));
    assert_clean(ctx);
}
