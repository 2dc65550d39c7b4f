#version 460
#extension GL_GOOGLE_include_directive : require
// The steepness of a cone over each cell of a tile of the height map: a search for the cell that asks for most.
//
// The nodes that could ask for more than has been found are opened, the child nearest to the cell first: what is near
// is mostly what counts, and soon bounds the rest away (cf. Valasek and Bán, Quick Cone Map Generation on the GPU, 2022).
// Node k of level L covers cells k 2^L to (k + 1) 2^L - 1 of one period of the map, those past its end left out; in a
// clamped map the first one is the cell before the first texel.
layout(local_size_x = 8, local_size_y = 8) in;

// Per node: greatest height; least and greatest slope along u, along v, per texel. Rounded outward.
struct Node {
    uint high, slopes_u, slopes_v;
};

layout(set = 0, binding = 0) uniform sampler2D height_map;
layout(std430, set = 0, binding = 1) readonly buffer NodeBlock { Node item[]; } nodes;
layout(std430, set = 0, binding = 2) writeonly buffer CellBlock { float item[]; } cells;
// `tile`: its first cell, counted from (-1, -1). `offset`: of each level's nodes.
layout(push_constant) uniform TileBlock {
    ivec2 tile;
    int top;
    int side; // cells of a tile along each axis
    uint offset[16];
};

#include "shell/cone_bounds.glsl"
#include "shell/height_map.glsl"
#include "shell/pyramid.glsl"

vec4 cell_at(ivec2 cell) {
    return map_cell(height_map, vec2(textureSize(height_map, 0)), cell);
}

float near_steepness(ivec2 cell, vec4 own, vec2 size) {
    float bound = own_steepness(own, size);
    for (int y = -1; y <= 1; ++y) {
        for (int x = -1; x <= 1; ++x) {
            ivec2 toward = ivec2(x, y);
            if (toward != ivec2(0)) {
                bound = max(bound, near_steepness(own, cell_at(cell + toward), cell_at(cell + ivec2(x, 0)),
                                                  cell_at(cell + ivec2(0, y)), toward, size));
            }
        }
    }
    return bound;
}

// Which child of `parent`, at the level above `level`, is nearest to `cell`.
ivec2 nearest_child(ivec2 parent, int level, ivec2 cell) {
    return ivec2(greaterThanEqual(cell, (2 * parent + 1) << level));
}

// The greater of `steepest` and what the cells of one period ask for; `cell` counts from that period's first.
float search(ivec2 cell, vec4 own, ivec2 period, vec2 size, float steepest) {
    float low = cell_range(own).x;
    int level = top;
    ivec2 node = ivec2(0);
    while (true) {
        ivec2 count = (period + (1 << level) - 1) >> level;
        bool open = false;
        if (all(lessThan(node, count))) {
            ivec2 first = (node << level) - cell, last = min((node + 1) << level, period) - 1 - cell;
            Node n = nodes.item[offset[level] + uint(node.y * count.x + node.x)];
            vec4 slopes = vec4(unpackSnorm2x16(n.slopes_u), unpackSnorm2x16(n.slopes_v));
            open = node_steepness(low, float(n.high) / 65535.0, slopes, first, last, size) > steepest;
            if (open && level == 0) {
                open = false;
                if (max(abs(first.x), abs(first.y)) > 1) {
                    vec4 q = cell_at(node - pyramid_shift());
                    float bound = node_steepness(low, cell_range(q).y, cell_slopes(q), first, first, size);
                    if (bound > steepest) {
                        steepest = max(steepest, min(bound, far_steepness(own, q, first, size)));
                    }
                }
            }
        }
        if (open) {
            --level;
            node = 2 * node + nearest_child(node, level, cell);
            continue;
        }
        // The next child of its parent, or of the first that has one.
        while (true) {
            if (level == top) {
                return steepest;
            }
            ivec2 parent = node >> 1, near = nearest_child(parent, level, cell);
            ivec2 turn = (node & 1) ^ near;
            int next = turn.x + 2 * turn.y + 1;
            if (next < 4) {
                node = 2 * parent + (ivec2(next & 1, next >> 1) ^ near);
                break;
            }
            node = parent;
            ++level;
        }
    }
}

void main() {
    ivec2 texels = textureSize(height_map, 0);
    ivec2 at = tile + ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThan(at, texels)) || any(greaterThanEqual(at - tile, ivec2(side)))) {
        return;
    }
    vec2 size = vec2(texels);
    ivec2 cell = at - 1, period = pyramid_period(texels) + pyramid_shift();
    vec4 own = cell_at(cell);
    float steepest = max(near_steepness(cell, own, size), 1.0);
    // The period around the cell, then those beside it. A clamped map has one: beyond it nothing is nearer or higher.
    ivec2 periods = ivec2(HEIGHT_WRAP_U == 2 ? 1 : 3, HEIGHT_WRAP_V == 2 ? 1 : 3);
    for (int y = 0; y < periods.y; ++y) {
        for (int x = 0; x < periods.x; ++x) {
            ivec2 which = ivec2(x == 2 ? -1 : x, y == 2 ? -1 : y);
            steepest = search(cell + pyramid_shift() - which * period, own, period, size, steepest);
        }
    }
    cells.item[at.y * (texels.x + 1) + at.x] = steepest;
}
