// The outside of a shell: lids over it and bases under it, each vertex at the least level that clears every surface
// around it, so that they are continuous across triangles.
#ifndef RENDER_LIDS_GLSL
#define RENDER_LIDS_GLSL

#include "render/interface.glsl"

// Base and lid level of each vertex.
layout(std430, set = 1, binding = 11) readonly buffer LidBlock { vec2 item[]; } lids;

// Outward growth in pixels. It keeps the rasteriser's snapping (1/512 pixel) from dropping pixels at the outline also
// where the normal leans; the trace clips to the exact shell.
const float GROWTH = 0.125;

// A vertex at `level`, pushed outward (`side` +1) or inward (-1).
vec4 lid_position(Object object, Vertex vertex, float level, float side) {
    vec3 at = vertex.position.xyz + level * vertex.shell.xyz;
    float w = dot(object.clip_w.xyz, at) + object.clip_w.w;
    float pixel = 2.0 * abs(w) * max(frame.viewport.z / length(object.clip_x.xyz),
                                     frame.viewport.w / length(object.clip_y.xyz));
    float size = length(vertex.shell.xyz);
    at += size > 0.0 ? (side * GROWTH * pixel / size) * vertex.shell.xyz : vec3(0.0);
    vec3 clip = transform_point(object.clip_x, object.clip_y, object.clip_w, at);
    float depth = dot(object.depth.xyz, at) + object.depth.w;
    return vec4(clip.xy, frame.lens.x * depth + frame.lens.y, clip.z);
}

#endif
