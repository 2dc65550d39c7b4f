#version 460
#extension GL_GOOGLE_include_directive : require
// What of one primitive's prisms depends on the pose: which are plain, irregular or at a border, and so how the surface
// goes on across their walls.
#include "render/deform.glsl"

layout(std430, set = 0, binding = 11) readonly buffer RestPrismBlock { PrismData item[]; } rest_prisms;
layout(std430, set = 0, binding = 12) writeonly buffer PrismBlock { PrismData item[]; } prisms;
#ifdef WALKED
layout(std430, set = 0, binding = 13) readonly buffer RestAdjacencyBlock { uint item[]; } rest_adjacency;
layout(std430, set = 0, binding = 14) writeonly buffer AdjacencyBlock { uint item[]; } adjacency;
#endif

// The numbers of `Wall` in engine/src/shell/prisms.rs.
const uint WALL_PLAIN = 2u;
const uint WALL_OPEN = 3u;

void main() {
    uint index = gl_GlobalInvocationID.x;
    if (index >= deform.count) {
        return;
    }
    DeformTriangle triangle = triangles.item[deform.first + index];
    PrismData prism = rest_prisms.item[index];
    uint bits = prism.corners.w;
    bool plain = plains.item[deform.first + index] != 0u;
    bool border = plain, irregular = false;
    for (int k = 0; k < 3; ++k) {
        bool plain_across = triangle.across[k] != NONE && plains.item[triangle.across[k]] != 0u;
        if (plain || plain_across) {
            bits = bitfieldInsert(bits, plain ? WALL_OPEN : WALL_PLAIN, 3 * k, 3);
        }
#ifdef WALKED
        uint neighbour = plain || plain_across ? NONE : rest_adjacency.item[3u * index + uint(k)];
        adjacency.item[3u * index + uint(k)] = neighbour;
        border = border || neighbour == NONE;
        irregular = irregular || (folds.item[mesh_vertices.item[triangle.corners[k]].ids.x] & LEANS) != 0u;
#endif
    }
    bits = bitfieldInsert(bits, plain ? 1u : 0u, 12, 1);
    bits = bitfieldInsert(bits, irregular ? 1u : 0u, 13, 1);
    bits = bitfieldInsert(bits, border || irregular ? 1u : 0u, 26, 1);
    prism.corners.w = bits;
    prisms.item[index] = prism;
}
