// Cobbles, 8 by 8 in a UV unit: a paraboloid for each stone, the highest one counts, over a flat bed at height 0; see
// scene/procedure/cobbles.rs, whose names these are.
#ifndef SHELL_COBBLES_GLSL
#define SHELL_COBBLES_GLSL

#include "shell/procedures/common.glsl"

const int COBBLE_COUNT = 8;
const vec2 COBBLE_PLACE = vec2(0.25, 0.5);
const vec2 COBBLE_TOP = vec2(0.75, 0.25);
const float COBBLE_DROP = 2.0;

vec2 cobbles_size() {
    return vec2(128.0);
}

// The stone of a cell: its middle from the cell's low corner, in cells, and the height there.
vec3 cobble(ivec2 cell) {
    ivec2 id = cell & (COBBLE_COUNT - 1);
    vec3 random = scrambled_fractions(uint(id.y * COBBLE_COUNT + id.x));
    return vec3(COBBLE_PLACE.x + COBBLE_PLACE.y * random.xy, COBBLE_TOP.x + COBBLE_TOP.y * random.z);
}

// The highest stone's height, or the bed's, and the way to the stone's middle in cells.
vec3 highest_cobble(vec2 uv) {
    vec2 at = uv * float(COBBLE_COUNT), low = floor(at), within = at - low;
    vec3 best = vec3(0.0);
    for (int i = 0; i < 9; ++i) {
        ivec2 step = ivec2(i % 3, i / 3) - 1;
        vec3 stone = cobble(ivec2(low) + step);
        vec2 way = vec2(step) + stone.xy - within;
        float h = stone.z - COBBLE_DROP * dot(way, way);
        best = h > best.x ? vec3(h, way) : best;
    }
    return best;
}

float cobbles_height(vec2 uv) {
    return highest_cobble(uv).x;
}

vec2 cobbles_gradient(vec2 uv) {
    return 2.0 * COBBLE_DROP * float(COBBLE_COUNT) * highest_cobble(uv).yz;
}

vec4 cobbles_bounds(vec2 low, vec2 high) {
    vec2 a = low * float(COBBLE_COUNT), b = high * float(COBBLE_COUNT);
    ivec2 first = ivec2(floor(a)), cells = ivec2(floor(b)) - first;
    // A box of more than a cell holds a stone or most of one, and a joint.
    if (any(greaterThan(cells, ivec2(1)))) {
        return vec4(-HEIGHT_PAD, 1.0 + HEIGHT_PAD, 0.0, 0.0);
    }
    // Less the slope, 2 COBBLE_DROP `lean`, of what is highest in the middle.
    vec2 centre = box_centre(low, high), middle = centre * float(COBBLE_COUNT) - vec2(first);
    vec2 reach = box_reach(low, high) * float(COBBLE_COUNT), lean = highest_cobble(centre).yz;
    float flat_room = 2.0 * COBBLE_DROP * dot(abs(lean), reach);
    vec2 bounds = vec2(-flat_room, flat_room);
    for (int y = -1; y <= cells.y + 1; ++y) {
        for (int x = -1; x <= cells.x + 1; ++x) {
            // At `d` from the middle: top - drop (way^2 + 2 d . (lean - way) + d^2), a parabola along each axis.
            vec3 stone = cobble(first + ivec2(x, y));
            vec2 way = vec2(x, y) + stone.xy - middle, side = way - lean;
            vec2 peak = clamp(side, -reach, reach), greatest = peak * (2.0 * side - peak);
            vec2 least = -reach * (2.0 * abs(side) + reach);
            float h = stone.z - COBBLE_DROP * dot(way, way);
            bounds = max(bounds, h + COBBLE_DROP * vec2(least.x + least.y, greatest.x + greatest.y));
        }
    }
    return vec4(bounds + vec2(-HEIGHT_PAD, HEIGHT_PAD), 2.0 * COBBLE_DROP * float(COBBLE_COUNT) * lean);
}

#endif
