#version 460
// A line's colour, scene-linear as the target takes it.
layout(location = 0) flat in vec3 in_line;
layout(location = 0) out vec4 out_color;

void main() {
    out_color = vec4(in_line, 1.0);
}
