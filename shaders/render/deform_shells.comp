#version 460
#extension GL_GOOGLE_include_directive : require
// A welded vertex's shell normal: the mean of the vertex normals there, weighted by corner angle.
#include "render/deform.glsl"

// A sum shorter than this, per unit of weight, has no direction worth the name: f32's rounding.
const float LEAST_MEAN = 1e-5;

void main() {
    uint weld = gl_GlobalInvocationID.x;
    if (weld >= deform.count) {
        return;
    }
    vec3 sum = vec3(0.0);
    float weight = 0.0;
    uvec2 fan = fan_of(deform.weld_fans, weld);
    for (uint i = fan.x; i < fan.y; ++i) {
        uint corner = fans.item[i] & 3u;
        uvec4 at = triangles.item[fans.item[i] >> 2].corners;
        vec3 p = posed.item[at[corner]].position.xyz;
        float angle = angle_between(posed.item[at[(corner + 1u) % 3u]].position.xyz - p,
                                    posed.item[at[(corner + 2u) % 3u]].position.xyz - p);
        sum += angle * posed.item[at[corner]].normal.xyz;
        weight += angle;
    }
    float size = length(sum);
    shell_normals.item[weld] = size > LEAST_MEAN * weight ? vec4(sum / size, 1.0) : vec4(0.0);
}
