#version 460
#extension GL_GOOGLE_include_directive : require
// One point a prism; the geometry stage fetches the rest by id.
#ifdef CULLED
#include "render/kept_items.glsl"
#endif

layout(location = 0) flat out uint out_item;

void main() {
#ifdef CULLED
    out_item = kept.item[gl_VertexIndex];
#else
    out_item = gl_VertexIndex;
#endif
    gl_Position = vec4(0.0);
}
