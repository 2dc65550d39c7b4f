#version 460
#extension GL_GOOGLE_include_directive : require
// A vertex of a patch that the tessellator divided.
#define MOST_STEPS 64
#include "baseline/dicing.glsl"

// Whole steps, so that which of them a vertex is can be told, and with it the place that both sides of an edge agree on.
// Clockwise as Vulkan has it, whose domain begins at the upper left: then triangles wind as the patch's corners do.
layout(triangles, equal_spacing, cw) in;

layout(location = 0) patch in uint in_triangle;
layout(location = 1) patch in ivec3 in_corners[3];
layout(location = 4) patch in ivec2 in_shares[3];
layout(location = 7) patch in ivec4 in_edges[3];

layout(location = 0) out vec3 out_position; // mesh space
layout(location = 1) out vec3 out_normal;
#ifdef VERTEX_UVS
layout(location = 2) out vec4 out_uvs;
#endif
#ifdef VERTEX_TANGENTS
layout(location = 3) out vec4 out_tangent;
#endif

void main() {
    Patch patch_;
    patch_.triangle = in_triangle;
    for (int k = 0; k < 3; ++k) {
        patch_.corners[k] = in_corners[k];
        patch_.shares[k] = in_shares[k];
        patch_.edges[k] = PatchEdge(in_edges[k].x, in_edges[k].y, in_edges[k].z, in_edges[k].w);
    }
    DicedTriangle triangle = diced_triangles.item[in_triangle];
    vec3 at = gl_TessCoord;
    Place place = patch_inside(patch_, triangle, at);
    for (int k = 0; k < 3; ++k) {
        if (at[k] == 0.0) {
            int steps = patch_.edges[k].steps;
            place = patch_edge(patch_, triangle, k, int(round(at[(k + 2) % 3] * float(steps))));
        }
    }
    DicedVertex vertex = diced_vertex(triangle, place);
    gl_Position = clip_position(drawn, vertex.position);
    out_position = vertex.position;
    out_normal = vertex.normal;
#ifdef VERTEX_UVS
    out_uvs = vertex.uvs;
#endif
#ifdef VERTEX_TANGENTS
    out_tangent = vertex.tangent;
#endif
}
