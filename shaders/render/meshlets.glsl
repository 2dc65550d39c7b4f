// The lids' meshlets, and what the task stage hands on of one.
#ifndef RENDER_MESHLETS_GLSL
#define RENDER_MESHLETS_GLSL

// First vertex, first triangle, vertices, triangles.
layout(std430, set = 1, binding = 13) readonly buffer MeshletBlock { uvec4 item[]; } meshlets;
layout(std430, set = 1, binding = 14) readonly buffer MeshletVertexBlock { uint item[]; } meshlet_vertices;
// Prism; its three corners in the meshlet, 8 bits each.
layout(std430, set = 1, binding = 15) readonly buffer MeshletTriangleBlock { uvec2 item[]; } meshlet_triangles;

#ifdef CULLED
// A bit for each of at most 124 triangles.
const uint MESHLET_WORDS = 4u;

struct KeptTriangles {
    uint meshlet;
    uint triangles[MESHLET_WORDS];
};
taskPayloadSharedEXT KeptTriangles kept;

// Triangles of the meshlet that are kept, before number `end`.
uint kept_before(uint end) {
    uint count = 0u;
    for (uint i = 0u; i < MESHLET_WORDS; ++i) {
        uint bits = min(max(end, 32u * i) - 32u * i, 32u);
        count += uint(bitCount(bitfieldExtract(kept.triangles[i], 0, int(bits))));
    }
    return count;
}
#endif

#endif
