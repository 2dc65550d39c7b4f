#version 460
// One point a prism; the geometry stage fetches the rest by id.
layout(location = 0) flat out uint out_item;

void main() {
    out_item = gl_VertexIndex;
    gl_Position = vec4(0.0);
}
