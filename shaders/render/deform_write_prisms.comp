#version 460
#extension GL_GOOGLE_include_directive : require
// What of one primitive's prisms depends on the pose: which are plain, irregular or at a border, and so how the surface
// goes on across their walls.
#include "render/deform.glsl"
#include "shell/prism_bits.glsl"

layout(std430, set = 0, binding = 11) readonly buffer RestPrismBlock { PrismData item[]; } rest_prisms;
layout(std430, set = 0, binding = 12) writeonly buffer PrismBlock { PrismData item[]; } prisms;
#ifdef WALKED
layout(std430, set = 0, binding = 13) readonly buffer RestAdjacencyBlock { uint item[]; } rest_adjacency;
layout(std430, set = 0, binding = 14) writeonly buffer AdjacencyBlock { uint item[]; } adjacency;
#endif

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
        bool plain_across = triangle.across[k] != NO_NEIGHBOUR && plains.item[triangle.across[k]] != 0u;
        if (plain || plain_across) {
            bits = with_wall_kind(bits, k, plain ? WALL_OPEN : WALL_PLAIN);
        }
#ifdef WALKED
        border = border || at_brink(bits, k);
        uint neighbour = plain || plain_across ? NO_NEIGHBOUR : rest_adjacency.item[3u * index + uint(k)];
        adjacency.item[3u * index + uint(k)] = neighbour;
        border = border || neighbour == NO_NEIGHBOUR;
        irregular = irregular || (folds.item[mesh_vertices.item[triangle.corners[k]].ids.x] & LEANS) != 0u;
#endif
    }
    bits = with_flag(with_flag(bits, PLAIN, plain), IRREGULAR, irregular);
    bits = with_flag(bits, BORDER, border || irregular);
    prism.corners.w = bits;
    prisms.item[index] = prism;
}
