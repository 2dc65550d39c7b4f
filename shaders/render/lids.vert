#version 460
#extension GL_GOOGLE_include_directive : require
// Lid and base of one vertex, for the geometry stage to choose from.
#include "render/lids.glsl"

layout(location = 0) out vec4 out_lid;
layout(location = 1) out vec4 out_base;
layout(location = 2) out vec2 out_levels;

void main() {
    Object object = objects.item[draw.object];
    Vertex vertex = vertices.item[gl_VertexIndex];
    vec2 levels = lids_of(gl_VertexIndex);
    levels = vec2(grown_level(object, vertex, levels.x, -1.0), grown_level(object, vertex, levels.y, 1.0));
    out_base = lid_position(object, vertex, levels.x);
    out_lid = lid_position(object, vertex, levels.y);
    out_levels = levels;
    gl_Position = vec4(0.0);
}
