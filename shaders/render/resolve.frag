#version 460
// The mean of a pixel's samples: linear light, as an sRGB image is read and written.

layout(set = 0, binding = 0) uniform sampler2DMS samples;

layout(location = 0) out vec4 out_color;

void main() {
    ivec2 at = ivec2(gl_FragCoord.xy);
    vec4 sum = vec4(0.0);
    for (int i = 0; i < 4; ++i) {
        sum += texelFetch(samples, at, i);
    }
    out_color = 0.25 * sum;
}
