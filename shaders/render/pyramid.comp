#version 460
#extension GL_GOOGLE_include_directive : require
// One level of the min-max pyramid: level 0 from the map, each further level from the one below.
layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 0) uniform sampler2D height_map;
layout(std430, set = 0, binding = 1) buffer PyramidBlock { uint item[]; } pyramid;
layout(push_constant) uniform LevelBlock { int level; };

#define HEIGHT_MAP height_map
#include "shell/height.glsl"

vec2 height_size() {
    return vec2(textureSize(height_map, 0));
}

#include "shell/pyramid.glsl"

vec2 from_texels(ivec2 node) {
    vec4 h = height_cell(node - pyramid_shift());
    return vec2(min(min(h.x, h.y), min(h.z, h.w)), max(max(h.x, h.y), max(h.z, h.w)));
}

// First node of the level below that a child index means, and whether its successor is needed too: past the level's end
// the map begins anew, in general not at a node's border.
ivec2 wrapped_child(int child, int count, int period, const int mode) {
    if (child < count) {
        return ivec2(child, 0);
    }
    if (mode == 2) {
        return ivec2(count - 1, 0);
    }
    return ivec2(((child << (level - 1)) - period) >> (level - 1), 1);
}

void main() {
    ivec2 size = textureSize(height_map, 0);
    ivec2 count = pyramid_nodes(size, level);
    ivec2 node = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(node, count))) {
        return;
    }
    vec2 bounds = vec2(1.0, 0.0);
    if (level == 0) {
        bounds = from_texels(node);
    } else {
        ivec2 below = pyramid_nodes(size, level - 1), period = pyramid_period(size);
        uint offset = pyramid.item[level - 1];
        for (int j = 0; j < 2; ++j) {
            ivec2 y = wrapped_child(2 * node.y + j, below.y, period.y, HEIGHT_WRAP_V);
            for (int i = 0; i < 2; ++i) {
                ivec2 x = wrapped_child(2 * node.x + i, below.x, period.x, HEIGHT_WRAP_U);
                for (int row = y.x; row <= y.x + y.y; ++row) {
                    for (int column = x.x; column <= x.x + x.y; ++column) {
                        vec2 child = pyramid_unpack(pyramid.item[offset + uint(row * below.x + column)]);
                        bounds = vec2(min(bounds.x, child.x), max(bounds.y, child.y));
                    }
                }
            }
        }
    }
    pyramid.item[pyramid.item[level] + uint(node.y * count.x + node.x)] = pyramid_pack(bounds);
}
