#version 460
#extension GL_GOOGLE_include_directive : require
// Lid and base of one vertex, for the geometry stage to choose from.
#include "render/lids.glsl"
#ifdef CULLED
#include "render/kept_items.glsl"
#endif

layout(location = 0) out vec4 out_lid;
layout(location = 1) out vec4 out_base;
layout(location = 2) out vec2 out_levels;
#ifdef CULLED
layout(location = 3) flat out uint out_prism;
#endif

void main() {
#ifdef VISIBILITY
    if (draw.resolves != 0u) {
        // The geometry stage makes a triangle over the picture.
        out_lid = out_base = gl_Position = vec4(0.0);
        out_levels = vec2(0.0);
#ifdef CULLED
        out_prism = 0u;
#endif
        return;
    }
#endif
    Object object = drawn;
#ifdef CULLED
    // Without indices: three vertices a prism.
    out_prism = kept.item[gl_VertexIndex / 3];
    uint index = prisms.item[out_prism].corners[gl_VertexIndex % 3];
#else
    uint index = gl_VertexIndex;
#endif
    Vertex vertex = vertices.item[index];
    vec2 levels = lids_of(index);
    levels = vec2(grown_level(object, vertex, levels.x, -1.0), grown_level(object, vertex, levels.y, 1.0));
    out_base = lid_position(object, vertex, levels.x);
    out_lid = lid_position(object, vertex, levels.y);
    out_levels = levels;
    gl_Position = vec4(0.0);
}
