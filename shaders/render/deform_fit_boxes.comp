#version 460
#extension GL_GOOGLE_include_directive : require
// The boxes over one primitive's prisms, fitted to the pose: those that hold a prism, then all whose parts are fitted.
#include "render/deform.glsl"
#include "shell/prism_bits.glsl"

layout(std430, set = 0, binding = 15) readonly buffer VertexBlock { Vertex item[]; } vertices;
layout(std430, set = 0, binding = 16) readonly buffer PrismBlock { PrismData item[]; } prisms;
layout(std430, set = 0, binding = 17) buffer BoxBlock { BoxNode item[]; } boxes;
layout(std430, set = 0, binding = 18) readonly buffer OrderBlock { uint item[]; } order;
layout(std140, set = 0, binding = 19) uniform MaterialBlock { Material material; };

// Rounding of positions in f32, relative to their size.
const float BOX_ROOM = 1e-6;

void main() {
    if (gl_GlobalInvocationID.x >= deform.count) {
        return;
    }
    uint index = order.item[deform.first + gl_GlobalInvocationID.x], prism = boxes.item[index].high.w;
    vec3 low = vec3(1e30), high = vec3(-1e30);
    if (prism == NO_PRISM) {
        uint parts[2] = uint[2](index + 1u, boxes.item[index + 1u].low.w);
        for (int i = 0; i < 2; ++i) {
            low = min(low, uintBitsToFloat(boxes.item[parts[i]].low.xyz));
            high = max(high, uintBitsToFloat(boxes.item[parts[i]].high.xyz));
        }
    } else {
        // The base surface too: a pose may leave the prism plain, or what it meets.
        uvec4 corners = prisms.item[prism].corners;
        vec2 range = prisms.item[prism].range.xy;
        vec2 levels = vec2(min(range.x, 0.0), max(range.y, 0.0) + material.shadow.y);
        for (int k = 0; k < 3; ++k) {
            Vertex v = vertices.item[corners[k]];
            for (int end = 0; end < 2; ++end) {
                vec3 corner = v.position.xyz + levels[end] * v.shell.xyz;
                low = min(low, corner);
                high = max(high, corner);
            }
        }
        vec3 size = max(abs(low), abs(high));
        float room = BOX_ROOM * max(size.x, max(size.y, size.z));
        low -= room;
        high += room;
    }
    boxes.item[index].low.xyz = floatBitsToUint(low);
    boxes.item[index].high.xyz = floatBitsToUint(high);
}
