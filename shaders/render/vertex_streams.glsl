// What only some variants read of vertices, each in a buffer of its own: where nothing reads one, nobody made it.
#ifndef RENDER_VERTEX_STREAMS_GLSL
#define RENDER_VERTEX_STREAMS_GLSL

#ifdef VERTEX_UVS_0
layout(std430, set = 1, binding = 34) readonly buffer Uvs0Block { vec2 item[]; } uvs_0;
#endif
#ifdef VERTEX_UVS_1
layout(std430, set = 1, binding = 35) readonly buffer Uvs1Block { vec2 item[]; } uvs_1;
#endif
#ifdef VERTEX_TANGENTS
// Shading tangent and handedness. With lengths, where they frame the parallax.
layout(std430, set = 1, binding = 36) readonly buffer TangentBlock { vec4 item[]; } tangents;
#endif

// UV sets 0 and 1 of a vertex, as in the file; zero where nothing reads them. One that is `height_uv` itself has no buffer.
vec4 vertex_uvs(uint vertex, vec2 height_uv) {
    vec4 uvs = vec4(0.0);
#ifdef HEIGHT_UVS_0
    uvs.xy = height_uv;
#elif defined(VERTEX_UVS_0)
    uvs.xy = uvs_0.item[vertex];
#endif
#ifdef HEIGHT_UVS_1
    uvs.zw = height_uv;
#elif defined(VERTEX_UVS_1)
    uvs.zw = uvs_1.item[vertex];
#endif
    return uvs;
}

#endif
