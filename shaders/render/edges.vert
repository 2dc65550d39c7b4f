#version 460
#extension GL_GOOGLE_include_directive : require
// Ends of lines over the picture: edges of base triangles, or (PRISM_EDGES) the nine edges of each prism, between the
// lowest and the highest level of its surface.
#include "render/interface.glsl"
#include "render/surface_vertices.glsl"
#include "shell/prism_bits.glsl"

layout(location = 0) flat out vec3 out_line;

void main() {
    Object object = drawn;
#ifdef PRISM_EDGES
    PrismData prism = prisms.item[gl_VertexIndex / 18];
    int edge = gl_VertexIndex % 18 / 2, end = gl_VertexIndex & 1;
    // Three of the top, three of the bottom, three between them.
    bool upright = edge >= 6;
    Vertex vertex = vertices.item[prism.corners[upright ? edge - 6 : (edge + end) % 3]];
    bool top = upright ? end == 0 : edge < 3;
    vec3 at = vertex.position.xyz + (top ? prism.range.y : prism.range.x) * vertex.shell.xyz;
    out_line = upright ? vec3(0.35) : top ? vec3(0.9, 0.35, 0.02) : vec3(0.02, 0.25, 0.7);
#else
    vec3 at = surface_vertex(gl_VertexIndex).position.xyz;
    out_line = vec3(0.9, 0.35, 0.02);
#endif
    vec3 clip = transform_point(object.clip_x, object.clip_y, object.clip_w, at);
    float view_depth = dot(object.depth.xyz, at) + object.depth.w;
    gl_Position = vec4(clip.xy, frame.lens.x * view_depth + frame.lens.y, clip.z);
#ifdef PRISM_EDGES
    // A triangle that is not displaced has no prism.
    if (is_plain(prism.corners.w)) {
        gl_Position = vec4(0.0, 0.0, 2.0, 1.0);
    }
#endif
}
