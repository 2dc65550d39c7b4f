// The visibility buffer of pre-tessellated meshes: the small triangle that each pixel sees. x: one more than the number of
// its draw, 0 where there is none; y: its place among the triangles that the draw's indices make.
#ifndef BASELINE_NEAREST_TRIANGLE_GLSL
#define BASELINE_NEAREST_TRIANGLE_GLSL

#include "render/interface.glsl"

uvec2 triangle_name(uint triangle) {
    return uvec2(draw.object + 1u, triangle);
}

layout(std430, set = 1, binding = 37) readonly buffer MicroVertexBlock { uint item[]; } micro_vertices; // 6 words each
layout(std430, set = 1, binding = 38) readonly buffer MicroIndexBlock { uint item[]; } micro_indices;

// Position of the vertex that begins at a word.
vec3 micro_position(uint at) {
    return uintBitsToFloat(uvec3(micro_vertices.item[at], micro_vertices.item[at + 1u], micro_vertices.item[at + 2u]));
}

#ifdef VISIBILITY
#include "baseline/micro_vertex.glsl"

layout(set = 0, binding = 8) uniform usampler2D nearest_triangles;

// What the raster would interpolate at a pixel's centre. False where it sees no triangle of this draw.
bool named_point(Object object, ivec2 pixel, vec2 ndc, out SurfacePoint point) {
    uvec2 name = texelFetch(nearest_triangles, pixel, 0).xy;
    if (name.x != draw.object + 1u) {
        return false;
    }
    vec3 position[3], normal[3], toward[3];
    vec2 uv[3];
    for (uint k = 0u; k < 3u; ++k) {
        uint at = 6u * micro_indices.item[3u * name.y + k];
        position[k] = micro_position(at);
        normal[k] = unfolded(unpackSnorm2x16(micro_vertices.item[at + 3u]));
        uv[k] = uintBitsToFloat(uvec2(micro_vertices.item[at + 4u], micro_vertices.item[at + 5u]));
        // Relative to the pixel before anything is multiplied: small triangles keep their digits.
        vec3 clip = transform_point(object.clip_x, object.clip_y, object.clip_w, position[k]);
        toward[k] = vec3(clip.xy - ndc * clip.z, clip.z);
    }
    // Of the edge that faces each corner: how its function changes with NDC x and y, and its value here. They are the
    // corners' weights, perspective and all, but for their sum (Olano and Greer 1997, "Triangle scan conversion using 2D
    // homogeneous coordinates").
    mat3 edges = mat3(cross(toward[1], toward[2]), cross(toward[2], toward[0]), cross(toward[0], toward[1]));
    vec3 sum = edges[0] + edges[1] + edges[2];
    float part = sum.z != 0.0 ? 1.0 / sum.z : 0.0;
    // The raster's grid lets a triangle cover pixel centres right beside it.
    vec3 inside = max(vec3(edges[0].z, edges[1].z, edges[2].z) * part, 0.0);
    float total = inside.x + inside.y + inside.z;
    vec3 weights = total > 0.0 ? inside / total : vec3(1.0 / 3.0);
    vec2 pixel_step = 2.0 * frame.viewport.zw * part;
    vec3 weights_x = pixel_step.x * (vec3(edges[0].x, edges[1].x, edges[2].x) - sum.x * weights);
    vec3 weights_y = pixel_step.y * (vec3(edges[0].y, edges[1].y, edges[2].y) - sum.y * weights);
    mat3 corners = mat3(position[0], position[1], position[2]);
    mat3x2 uvs = mat3x2(uv[0], uv[1], uv[2]);
    point.position = corners * weights;
    point.normal = mat3(normal[0], normal[1], normal[2]) * weights;
    point.geometric = cross(position[1] - position[0], position[2] - position[0]);
    point.uvs = (uvs * weights).xyxy;
    point.uvs_x = (uvs * weights_x).xyxy;
    point.uvs_y = (uvs * weights_y).xyxy;
    // Window coordinates grow downwards, so what is counter-clockwise on screen has a negative area.
    point.front = sum.z * object.handedness.x < 0.0;
    return true;
}
#endif

#endif
