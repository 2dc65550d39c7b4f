#version 460
#extension GL_GOOGLE_include_directive : require
// The pose of one primitive's vertices, as the renderer reads them.
#include "render/deform.glsl"

layout(std430, set = 0, binding = 9) readonly buffer RestVertexBlock { Vertex item[]; } rest_vertices;
layout(std430, set = 0, binding = 10) writeonly buffer VertexBlock { Vertex item[]; } vertices;
#ifdef VERTEX_TANGENTS
layout(std430, set = 0, binding = 20) writeonly buffer TangentBlock { vec4 item[]; } tangents;
#endif

void main() {
    uint index = gl_GlobalInvocationID.x;
    if (index >= deform.count) {
        return;
    }
    DeformFrame frame = posed.item[deform.first + index];
    Vertex vertex = rest_vertices.item[index];
    uint weld = mesh_vertices.item[deform.first + index].ids.x;
    vertex.position = frame.position;
    vertex.shell.xyz = fold_factor(weld, folds.item[weld]) * shell_normals.item[weld].xyz;
    vertex.normal.xyz = frame.normal.xyz;
    vertices.item[index] = vertex;
#ifdef VERTEX_TANGENTS
    tangents.item[index] = frame.tangent;
#endif
}
