// What the passes over a deforming mesh share. Its vertices, triangles and welded vertices are numbered across its
// primitives. Every sum runs over a list made once, in its order, so that a frame repeats to the bit.
#ifndef RENDER_DEFORM_GLSL
#define RENDER_DEFORM_GLSL

#include "layout.glsl"

layout(local_size_x = 64) in;

layout(push_constant) uniform PassBlock { DeformPass deform; };

layout(std430, set = 0, binding = 0) readonly buffer MeshVertexBlock { DeformVertex item[]; } mesh_vertices;
layout(std430, set = 0, binding = 1) readonly buffer TriangleBlock { DeformTriangle item[]; } triangles;
// Lists of corners (4 · triangle + corner) around welded vertices, smoothing groups and vertices; before them where
// each begins.
layout(std430, set = 0, binding = 2) readonly buffer FanBlock { uint item[]; } fans;
// The pose: of each vertex position (rebased), shading normal and tangent.
layout(std430, set = 0, binding = 3) buffer PosedBlock { DeformFrame item[]; } posed;
// Shell normal of each welded vertex; w: 0 where it is zero, else 1.
layout(std430, set = 0, binding = 4) buffer ShellNormalBlock { vec4 item[]; } shell_normals;
// Of each welded vertex a bit a round in which its normal was halved, and LEANS; then for each round whether any was;
// then how many triangles still fold after the last.
layout(std430, set = 0, binding = 5) buffer FoldBlock { uint item[]; } folds;
// 1 for each triangle that is not displaced.
layout(std430, set = 0, binding = 6) buffer PlainBlock { uint item[]; } plains;

// Of a word of `folds`; the rounds take the lower bits.
const uint LEANS = 1u << 31;

// The angle between two vectors. GLSL's own arc tangent may be off by 4096 ulp; this one is by 2e-8 (Abramowitz and
// Stegun, 4.4.49).
float angle_between(vec3 a, vec3 b) {
    float y = length(cross(a, b)), x = dot(a, b), ax = abs(x);
    float larger = max(ax, y);
    if (larger == 0.0) {
        return 0.0;
    }
    float z = min(ax, y) / larger, s = z * z;
    float series = 0.0028662257;
    series = series * s - 0.0161657367;
    series = series * s + 0.0429096138;
    series = series * s - 0.0752896400;
    series = series * s + 0.1065626393;
    series = series * s - 0.1420889944;
    series = series * s + 0.1999355085;
    series = series * s - 0.3333314528;
    float angle = z * (series * s + 1.0);
    angle = y > ax ? 1.57079632679 - angle : angle;
    return x < 0.0 ? 3.14159265359 - angle : angle;
}

vec3 unit_or_zero(vec3 v) {
    float size = length(v);
    return size > 0.0 ? v / size : vec3(0.0);
}

// r of a welded vertex, after the rounds in `word`.
float fold_factor(uint weld, uint word) {
    uint halved = uint(bitCount(word & ((1u << deform.rounds) - 1u)));
    // 2^-halved, exactly.
    float factor = halved > 6u ? 0.0 : uintBitsToFloat((127u - halved) << 23);
    return factor * shell_normals.item[weld].w;
}

// First entry and end of a list of corners.
uvec2 fan_of(uint lists, uint index) {
    return uvec2(fans.item[lists + index], fans.item[lists + index + 1u]);
}

#endif
