#version 460
#extension GL_GOOGLE_include_directive : require
// One round of the fold rule over the triangles: the shell normals of those that may fold are halved. The pass after
// the last round tells which triangles are plain.
#include "render/deform.glsl"
#include "shell/certificate.glsl"

void main() {
    uint index = gl_GlobalInvocationID.x;
    if (index >= deform.count) {
        return;
    }
    bool last = deform.round == deform.rounds;
    if (deform.round > 0u && !last && folds.item[deform.welds + deform.round - 1u] == 0u) {
        return; // all hold
    }
    DeformTriangle triangle = triangles.item[index];
    if (triangle.corners.w == 0u) {
        plains.item[index] = 1u;
        return;
    }
    uvec3 weld;
    vec3 p[3], n[3], r;
    for (int k = 0; k < 3; ++k) {
        weld[k] = mesh_vertices.item[triangle.corners[k]].ids.x;
        p[k] = posed.item[triangle.corners[k]].position.xyz;
        n[k] = shell_normals.item[weld[k]].xyz;
        // Others may write this round's bit meanwhile.
        uint earlier = atomicOr(folds.item[weld[k]], 0u) & ((1u << deform.round) - 1u);
        r[k] = fold_factor(weld[k], earlier);
    }
    // Two corners at one welded vertex: no inside on any level, so nothing to fold.
    bool collapsed = weld.x == weld.y || weld.y == weld.z || weld.z == weld.x;
    bool flat_shell = r == vec3(0.0);
    bool holds = collapsed || flat_shell || certified(p, n, r, triangle.range.xy);
    if (last) {
        plains.item[index] = flat_shell || !holds ? 1u : 0u;
        if (!holds) {
            atomicAdd(folds.item[deform.welds + deform.rounds], 1u);
        }
        return;
    }
    if (!holds) {
        for (int k = 0; k < 3; ++k) {
            atomicOr(folds.item[weld[k]], 1u << deform.round);
        }
        atomicOr(folds.item[deform.welds + deform.round], 1u);
    }
}
