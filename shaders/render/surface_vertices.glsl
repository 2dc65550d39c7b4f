// What a base surface reads of its vertices: a buffer of that alone where its primitive has no use for shell normals.
#ifndef RENDER_SURFACE_VERTICES_GLSL
#define RENDER_SURFACE_VERTICES_GLSL

#include "render/interface.glsl"

#ifdef SURFACE_VERTICES
layout(std430, set = 1, binding = 37) readonly buffer SurfaceVertexBlock { SurfaceVertex item[]; } surface_vertices;
#endif

SurfaceVertex surface_vertex(uint index) {
#ifdef SURFACE_VERTICES
    return surface_vertices.item[index];
#else
    Vertex vertex = vertices.item[index];
    return SurfaceVertex(vec4(vertex.position.xyz, vertex.shell.w), vertex.normal);
#endif
}

#endif
