#version 460
#extension GL_GOOGLE_include_directive : require
// A triangle's lid and, where one may be seen, its base: at most 6 vertices of 6 components.
#include "render/lids.glsl"

layout(triangles) in;
layout(triangle_strip, max_vertices = 6) out;

layout(location = 0) in vec4 in_lid[];
layout(location = 1) in vec4 in_base[];
layout(location = 2) in vec2 in_levels[];
#ifdef CULLED
layout(location = 3) flat in uint in_prism[];
#endif

layout(location = 0) flat out uint out_prism;
layout(location = 1) out float out_level;

void main() {
#ifdef VISIBILITY
    if (draw.resolves != 0u) {
        // Seen from either side: one of them is culled.
        for (uint i = 0u; i < 6u; ++i) {
            out_prism = 0u;
            out_level = 0.0;
            gl_Position = picture_corner(i < 3u ? i : 5u - i);
            EmitVertex();
            if (i == 2u) {
                EndPrimitive();
            }
        }
        EndPrimitive();
        return;
    }
#endif
#ifdef CULLED
    uint prism = in_prism[0];
#else
    uint prism = uint(gl_PrimitiveIDIn);
#endif
    if (is_plain(prisms.item[prism].corners.w)) {
        return;
    }
    for (int i = 0; i < 3; ++i) {
        out_prism = prism;
        out_level = in_levels[i].y;
        gl_Position = in_lid[i];
        EmitVertex();
    }
    EndPrimitive();
    if (draw.bases == 0u) {
        return;
    }
    for (int i = 2; i >= 0; --i) {
        out_prism = prism;
        out_level = in_levels[i].x;
        gl_Position = in_base[i];
        EmitVertex();
    }
    EndPrimitive();
}
