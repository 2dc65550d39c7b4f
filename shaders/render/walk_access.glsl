// The walk's view of our buffers.
#ifndef RENDER_WALK_ACCESS_GLSL
#define RENDER_WALK_ACCESS_GLSL

#include "render/adjacency.glsl"
#include "render/lid_growth.glsl"
#include "render/ray_fade.glsl"

// Base and lid level of each vertex.
layout(std430, set = 1, binding = 11) readonly buffer LidBlock { vec2 item[]; } lids;

uvec4 walk_corners(uint prism) {
    return prisms.item[prism].corners;
}

vec4 walk_range(uint prism) {
    vec4 range = prisms.item[prism].range;
    return vec4(height_share * range.xy, fading_range(range.zw));
}

uint walk_neighbour(uint prism, int wall) {
    return adjacency.item[3u * prism + uint(wall)];
}

vec4 walk_neighbour_uv(uint prism, int wall) {
    return prisms.item[prism].neighbour_uv[wall];
}

vec2 walk_lids(uint vertex) {
    return fading_range(lids.item[vertex]);
}

float walk_growth(uint vertex) {
    Vertex v = vertices.item[vertex];
    return lid_growth(drawn, v.position.xyz, v.shell.xyz);
}

vec3 walk_position(uint vertex) {
    return vertices.item[vertex].position.xyz;
}

vec3 walk_shell(uint vertex) {
    return vertices.item[vertex].shell.xyz;
}

vec2 walk_uv(uint vertex) {
    return height_uv_of(vertices.item[vertex]);
}

#endif
