#version 460
#extension GL_GOOGLE_include_directive : require
#include "render/picture_triangle.glsl"

void main() {
    gl_Position = picture_corner(gl_VertexIndex);
}
