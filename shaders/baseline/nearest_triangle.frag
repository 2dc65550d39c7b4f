#version 460
#extension GL_GOOGLE_include_directive : require
// Names the triangle; the depth test keeps the nearest.
#include "baseline/nearest_triangle.glsl"

layout(location = 0) flat in uint in_triangle;

layout(location = 0) out uvec2 out_triangle;

void main() {
    out_triangle = triangle_name(in_triangle);
}
