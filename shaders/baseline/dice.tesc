#version 460
#extension GL_GOOGLE_include_directive : require
// How finely a patch is divided.
#define MOST_STEPS 64
#include "baseline/dicing.glsl"

layout(vertices = 1) out;

layout(location = 0) flat in uint in_item[];
layout(location = 0) patch out uint out_triangle;
layout(location = 1) patch out ivec3 out_corners[3];
layout(location = 4) patch out ivec2 out_shares[3];
layout(location = 7) patch out ivec4 out_edges[3];

void main() {
    Patch patch_ = patch_of(in_item[0]);
    out_triangle = patch_.triangle;
    int most = 1;
    for (int k = 0; k < 3; ++k) {
        PatchEdge edge = patch_.edges[k];
        out_corners[k] = patch_.corners[k];
        out_shares[k] = patch_.shares[k];
        out_edges[k] = ivec4(edge.steps, edge.first, edge.last, edge.whole);
        gl_TessLevelOuter[k] = float(max(edge.steps, 1));
        most = max(most, edge.steps);
    }
    gl_TessLevelInner[0] = float(most);
#ifdef CULLS
    // Rings of triangles lie askew even where all edges have as many steps.
    if (is_hidden(patch_, steepness(patch_, 4.0, 0.0))) {
        gl_TessLevelOuter[0] = 0.0;
    }
#endif
}
