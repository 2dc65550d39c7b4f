// The exact march's view of our pyramid: bounds of a range of cells, in one read.
#ifndef RENDER_PYRAMID_ACCESS_GLSL
#define RENDER_PYRAMID_ACCESS_GLSL
#ifdef MARCH_EXACT

#include "shell/pyramid.glsl"
#include "shell/work.glsl"
#include "shell/exact.glsl"

layout(std430, set = 1, binding = 9) readonly buffer PyramidBlock { uint item[]; } pyramid;

vec2 height_bounds(ivec2 first, ivec2 last) {
    count_read();
    ivec2 size = ivec2(height_size()), period = pyramid_period(size), extent = last - first;
    // Where the map is clamped, all cells beyond it are like the outermost.
    ivec2 start;
    for (int axis = 0; axis < 2; ++axis) {
        if ((axis == 0 ? HEIGHT_WRAP_U : HEIGHT_WRAP_V) == 2) {
            start[axis] = clamp(first[axis] + 1, 0, size[axis]);
            extent[axis] = clamp(last[axis] + 1, 0, size[axis]) - start[axis];
        } else {
            start[axis] = wrapped(first[axis], period[axis]);
        }
    }
    int top = pyramid_top(size);
    int level = clamp(findMSB(max(max(extent.x, extent.y), 1) - 1) + 1, 0, top);
    ivec2 end = start + extent;
    // Half the size serves where the box happens to lie in two nodes of it.
    if (level > 0 && all(lessThanEqual((end >> (level - 1)) - (start >> (level - 1)), ivec2(1)))) {
        --level;
    }
    // Beyond the top level's reach the box holds the whole map.
    ivec2 node = max(extent.x, extent.y) > 1 << top ? ivec2(0) : start >> level;
    int columns = pyramid_nodes(size, level).x;
    return pyramid_unpack(pyramid.item[pyramid.item[level] + uint(node.y * columns + node.x)]);
}

#endif
#endif
