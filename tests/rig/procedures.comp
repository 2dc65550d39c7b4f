#version 460
#extension GL_GOOGLE_include_directive : require
// A procedure at the low corners of boxes, its bounds over them, and its extremes on a grid in each; see
// tests/procedures.rs.
layout(local_size_x = 64) in;

#include "shell/procedures.glsl"

layout(std430, set = 0, binding = 0) readonly buffer Boxes { vec4 item[]; } boxes; // low, high
struct Result {
    vec4 low;    // height and gradient at the low corner; least of the grid's heights less the bounds' slope
    vec4 bounds;
    float greatest; // of the same
};
layout(std430, set = 0, binding = 1) writeonly buffer Results { Result item[]; } results;

const int GRID = 16;

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= uint(boxes.item.length())) {
        return;
    }
    vec2 low = boxes.item[i].xy, high = boxes.item[i].zw;
    vec2 found = vec2(1e30, -1e30), middle = box_centre(low, high);
    vec4 bounds = height_bounds_uv(low, high);
    for (int k = 0; k < (GRID + 1) * (GRID + 1); ++k) {
        // Rounding may not take a point out of its box.
        vec2 at = clamp(mix(low, high, vec2(k % (GRID + 1), k / (GRID + 1)) / float(GRID)), low, high);
        float h = height_at(at, 0.0) - dot(bounds.zw, at - middle);
        found = vec2(min(found.x, h), max(found.y, h));
    }
    results.item[i] = Result(vec4(height_at(low, 0.0), height_gradient(low, 0.0), found.x), bounds, found.y);
}
