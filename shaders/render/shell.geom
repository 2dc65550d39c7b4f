#version 460
#extension GL_GOOGLE_include_directive : require
// A prism becomes the polygon of its outline: at most 10 vertices of 5 components.
#include "render/interface.glsl"
#include "render/shell_corners.glsl"

layout(points) in;
layout(triangle_strip, max_vertices = MAX_OUTLINE) out;

layout(location = 0) flat in uint in_item[];
layout(location = 0) flat out uint out_prism;

void main() {
    Outline outline = outline_of(in_item[0]);
    // A convex polygon as a strip: 0, 1, n-1, 2, n-2, ...
    int low = 1, high = outline.count - 1;
    for (int i = 0; i < outline.count; ++i) {
        int at = i == 0 ? 0 : (i & 1) == 1 ? low++ : high--;
        out_prism = outlined_prism(in_item[0]);
        gl_Position = outline_position(outline, at);
        EmitVertex();
    }
    EndPrimitive();
}
