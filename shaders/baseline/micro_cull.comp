#version 460
#extension GL_GOOGLE_include_directive : require
// Keeps the triangles of a micro-mesh that can show: those that face the eye and may cover a pixel centre in the picture.
#include "baseline/unseen.glsl"

layout(local_size_x = 64) in;

layout(std430, set = 0, binding = 0) readonly buffer VertexBlock { float item[]; } micro_vertices; // 6 words each
layout(std430, set = 0, binding = 1) readonly buffer IndexBlock { uint item[]; } micro_indices;    // two to a word
layout(std430, set = 0, binding = 2) writeonly buffer KeptBlock { uint item[]; } kept;
layout(std430, set = 0, binding = 3) buffer CommandBlock { uint index_count; } command;

layout(push_constant) uniform CullBlock {
    vec4 clip_x, clip_y, clip_w; // rows of mesh to clip
    vec2 viewport;
    uint first_index, triangles, first_vertex;
    float facing; // sign of the area of what faces away, 0 if both sides show
} cull;

uint index_at(uint i) {
    return cull.first_vertex + bitfieldExtract(micro_indices.item[i >> 1], int(i & 1u) * 16, 16);
}

// Place in the picture, in pixels, and clip w.
vec3 projected(uint id) {
    vec4 p = vec4(micro_vertices.item[6 * id], micro_vertices.item[6 * id + 1], micro_vertices.item[6 * id + 2], 1.0);
    float w = dot(cull.clip_w, p);
    return vec3((vec2(dot(cull.clip_x, p), dot(cull.clip_y, p)) / w * 0.5 + 0.5) * cull.viewport, w);
}

void main() {
    uint triangle = gl_GlobalInvocationID.x;
    if (triangle >= cull.triangles) {
        return;
    }
    uvec3 ids;
    vec3 corners[3];
    for (uint k = 0u; k < 3u; ++k) {
        ids[k] = index_at(cull.first_index + 3u * triangle + k);
        corners[k] = projected(ids[k]);
    }
    if (is_unseen(corners, cull.viewport, cull.facing)) {
        return;
    }
    uint at = atomicAdd(command.index_count, 3u);
    for (uint k = 0u; k < 3u; ++k) {
        kept.item[at + k] = ids[k];
    }
}
