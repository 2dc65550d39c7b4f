#version 460
#extension GL_GOOGLE_include_directive : require
// A corner of a small triangle, looked up by its place: so its number is known, which the raster counts only where there is a
// geometry stage, and lavapipe copies every corner to do.
#include "baseline/nearest_triangle.glsl"

// With a visibility buffer or without, the same pixels are covered.
invariant gl_Position;

layout(location = 0) flat out uint out_triangle;

void main() {
    Object object = drawn;
    vec3 position = micro_position(6u * micro_indices.item[gl_VertexIndex]);
    vec3 clip = transform_point(object.clip_x, object.clip_y, object.clip_w, position);
    float view_depth = dot(object.depth.xyz, position) + object.depth.w;
    gl_Position = vec4(clip.xy, frame.lens.x * view_depth + frame.lens.y, clip.z);
    out_triangle = uint(gl_VertexIndex) / 3u;
}
