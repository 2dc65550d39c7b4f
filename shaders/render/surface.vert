#version 460
#extension GL_GOOGLE_include_directive : require
#include "render/interface.glsl"
#include "render/surface_vertices.glsl"
#include "render/vertex_streams.glsl"

// A depth pre-pass and the shading after it are to agree on it.
invariant gl_Position;

layout(location = 0) out vec3 out_position; // mesh space
layout(location = 1) out vec3 out_normal;   // authored, mesh space
#ifdef VERTEX_UVS
layout(location = 2) out vec4 out_uvs;
#endif
#ifdef VERTEX_TANGENTS
layout(location = 3) out vec4 out_tangent;
#endif
#ifdef HAS_HEIGHT
layout(location = 4) out vec2 out_height_uv;
#endif
#ifdef MESH_TANGENTS
layout(location = 5) out float out_shear;
#endif

void main() {
    SurfaceVertex vertex = surface_vertex(gl_VertexIndex);
    Object object = drawn;
    vec3 clip = transform_point(object.clip_x, object.clip_y, object.clip_w, vertex.position.xyz);
    float view_depth = dot(object.depth.xyz, vertex.position.xyz) + object.depth.w;
    gl_Position = vec4(clip.xy, frame.lens.x * view_depth + frame.lens.y, clip.z);
    vec2 height_uv = vec2(vertex.position.w, vertex.normal.w);
    out_position = vertex.position.xyz;
    out_normal = vertex.normal.xyz;
#ifdef VERTEX_UVS
    out_uvs = vertex_uvs(gl_VertexIndex, height_uv);
#endif
#ifdef VERTEX_TANGENTS
    out_tangent = tangents.item[gl_VertexIndex];
#endif
#ifdef MESH_TANGENTS
    out_shear = vertices.item[gl_VertexIndex].position.w;
#endif
#ifdef HAS_HEIGHT
    out_height_uv = height_uv;
#endif
}
