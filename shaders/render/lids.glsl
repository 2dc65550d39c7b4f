// The outside of a shell: lids over it and bases under it, each vertex at the least level that clears every surface
// around it, so that they are continuous across triangles.
#ifndef RENDER_LIDS_GLSL
#define RENDER_LIDS_GLSL

#include "render/interface.glsl"
#include "render/lid_growth.glsl"
#include "render/picture_triangle.glsl"
#include "render/ray_fade.glsl"
#include "shell/prism_bits.glsl"

// Base and lid level of each vertex.
layout(std430, set = 1, binding = 11) readonly buffer LidBlock { vec2 item[]; } lids;

// Base and lid of a vertex.
vec2 lids_of(uint vertex) {
    return fading_range(lids.item[vertex]);
}

// A lid's or base's level as it is drawn: pushed outward (`side` +1) or inward (-1).
float grown_level(Object object, Vertex vertex, float level, float side) {
    vec3 at = vertex.position.xyz + level * vertex.shell.xyz;
    return level + side * lid_growth(object, at, vertex.shell.xyz);
}

vec4 lid_position(Object object, Vertex vertex, float level) {
    vec3 at = vertex.position.xyz + level * vertex.shell.xyz;
    vec3 clip = transform_point(object.clip_x, object.clip_y, object.clip_w, at);
    float depth = dot(object.depth.xyz, at) + object.depth.w;
    return vec4(clip.xy, frame.lens.x * depth + frame.lens.y, clip.z);
}

#endif
