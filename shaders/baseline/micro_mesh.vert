#version 460
#extension GL_GOOGLE_include_directive : require
// A vertex of a pre-tessellated mesh, for the same material shader as any plain surface.
#include "render/interface.glsl"
#include "baseline/micro_vertex.glsl"

// With a visibility buffer or without, the same pixels are covered.
invariant gl_Position;

layout(location = 0) in vec3 in_position;
layout(location = 1) in vec2 in_normal; // octahedral
layout(location = 2) in vec2 in_uv;

layout(location = 0) out vec3 out_position; // mesh space
layout(location = 1) out vec3 out_normal;
layout(location = 2) out vec4 out_uvs;

void main() {
    Object object = drawn;
    vec3 clip = transform_point(object.clip_x, object.clip_y, object.clip_w, in_position);
    float view_depth = dot(object.depth.xyz, in_position) + object.depth.w;
    gl_Position = vec4(clip.xy, frame.lens.x * view_depth + frame.lens.y, clip.z);
    out_position = in_position;
    out_normal = unfolded(in_normal);
    // Read or not: what is in the layout and no shader takes is a message of the validation layer.
    out_uvs = in_uv.xyxy;
}
