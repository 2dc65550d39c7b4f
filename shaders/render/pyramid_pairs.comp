#version 460
#extension GL_GOOGLE_include_directive : require
// One level of pairs: each node with its successors along both axes, so that a box across four nodes takes one read.
layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 0) uniform sampler2D height_map;
layout(std430, set = 0, binding = 1) readonly buffer PyramidBlock { uint item[]; } pyramid;
layout(std430, set = 0, binding = 2) writeonly buffer PairBlock { uint item[]; } pairs;
layout(push_constant) uniform LevelBlock { int level; };

#include "shell/pyramid.glsl"

void main() {
    ivec2 count = pyramid_nodes(textureSize(height_map, 0), level);
    ivec2 node = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(node, count))) {
        return;
    }
    uint offset = pyramid.item[level];
    uint low = 0xffffu, high = 0u;
    for (int i = 0; i < 4; ++i) {
        // No box starts in the last node: it holds what lies beyond the map's end.
        ivec2 at = min(node + ivec2(i & 1, i >> 1), count - 1);
        uint item = pyramid.item[offset + uint(at.y * count.x + at.x)];
        low = min(low, item & 0xffffu);
        high = max(high, item >> 16);
    }
    pairs.item[offset + uint(node.y * count.x + node.x)] = low | high << 16;
}
