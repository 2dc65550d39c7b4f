// Bricks in running bond, 4 bricks by 8 courses in a UV unit, the joints at height 0: see scene/procedure/bricks.rs,
// whose names these are. A brick's own coordinates are in courses from its middle, 3 by 1.
#ifndef SHELL_BRICKS_GLSL
#define SHELL_BRICKS_GLSL

#include "shell/procedures/common.glsl"

const vec2 BRICK_COUNT = vec2(4.0, 8.0);
const vec2 BRICK_SIZE = vec2(3.0, 1.0);
const float BRICK_JOINT = 0.0625;
const float BRICK_BEVEL = 0.125;
const vec2 BRICK_CROWN = vec2(0.84, 0.11);
const vec2 BRICK_TILT = vec2(0.02, 0.04);

vec2 bricks_size() {
    return vec2(256.0);
}

// A place in the bond, per axis and in cells. f32 has the distance from the nearest border to the last bit.
struct BrickPlace {
    vec2 cell;
    vec2 local;  // from the middle, within a half
    vec2 inside; // of the nearest border
};

BrickPlace brick_place(vec2 uv) {
    vec2 at = uv * BRICK_COUNT, whole = floor(at + 0.5), past = at - whole;
    vec2 before = mix(vec2(0.0), vec2(1.0), lessThan(past, vec2(0.0)));
    BrickPlace place = BrickPlace(whole - before, past - 0.5 + before, abs(past));
    if ((int(place.cell.y) & 1) != 0) {
        // Moved by half a brick.
        place.cell.x = whole.x;
        place.local.x = past.x;
        place.inside.x = 0.5 - abs(past.x);
    }
    return place;
}

// A brick's face: height in the middle and slopes.
vec3 brick_face(vec2 cell) {
    ivec2 id = ivec2(cell) & (ivec2(BRICK_COUNT) - 1);
    vec3 random = scrambled_fractions(uint(id.y * int(BRICK_COUNT.x) + id.x));
    return vec3(BRICK_CROWN.x + BRICK_CROWN.y * random.x, BRICK_TILT * (2.0 * random.yz - 1.0));
}

// How far into the bevel, per axis, is a point so many cells inside of its brick's border.
vec2 brick_into_bevel(vec2 inside) {
    return max(BRICK_JOINT + BRICK_BEVEL - inside * BRICK_SIZE, 0.0);
}

// Share of the face's height so far into the bevel.
float brick_share(float depth) {
    float s = clamp(1.0 - depth / BRICK_BEVEL, 0.0, 1.0);
    return s * s * (3.0 - 2.0 * s);
}

// Height and its slopes.
vec3 brick_at(vec2 uv) {
    BrickPlace at = brick_place(uv);
    vec2 local = at.local * BRICK_SIZE, bevel = brick_into_bevel(at.inside);
    vec3 face = brick_face(at.cell);
    float crown = face.x + dot(face.yz, local), depth = length(bevel), share = brick_share(depth);
    vec2 slope = share * face.yz;
    if (depth > 0.0) {
        float s = clamp(1.0 - depth / BRICK_BEVEL, 0.0, 1.0);
        slope -= crown * 6.0 * s * (1.0 - s) / (BRICK_BEVEL * depth) * bevel * sign(local);
    }
    return vec3(share * crown, slope * BRICK_SIZE * BRICK_COUNT);
}

float bricks_height(vec2 uv) {
    return brick_at(uv).x;
}

vec2 bricks_gradient(vec2 uv) {
    return brick_at(uv).yz;
}

// Least and greatest distance inside of the nearest border, in cells, on one axis from place `a` to place `b`.
vec2 brick_inside(BrickPlace a, BrickPlace b, int axis) {
    float cells = b.cell[axis] - a.cell[axis], inside_a = a.inside[axis], inside_b = b.inside[axis];
    bool from_first_half = a.local[axis] <= 0.0, to_second_half = b.local[axis] >= 0.0;
    bool middle = cells == 0.0 ? from_first_half && to_second_half
                               : cells > 1.0 || from_first_half || to_second_half;
    return vec2(cells == 0.0 ? min(inside_a, inside_b) : 0.0, middle ? 0.5 : max(inside_a, inside_b));
}

vec4 bricks_bounds(vec2 low, vec2 high) {
    BrickPlace a = brick_place(low), b = brick_place(high);
    bool one_course = a.cell.y == b.cell.y;
    vec2 across = one_course ? brick_inside(a, b, 0) : vec2(0.0, 0.5);
    vec2 along = brick_inside(a, b, 1);
    float deepest = length(brick_into_bevel(vec2(across.x, along.x)));
    float shallowest = length(brick_into_bevel(vec2(across.y, along.y)));
    float most = 0.5 * dot(BRICK_TILT, BRICK_SIZE);
    vec2 bounds = vec2(brick_share(deepest) * (BRICK_CROWN.x - most),
                       brick_share(shallowest) * (BRICK_CROWN.x + BRICK_CROWN.y + most));
    vec2 slope = vec2(0.0);
    // Taylor's expansion about the middle. The height has slopes everywhere; they change by the share's second
    // derivative, 6 / BEVEL^2 at most and across the bevel only, and by the tilt times its first, 1.5 / BEVEL.
    vec2 reach = box_reach(low, high) * BRICK_SIZE * BRICK_COUNT;
    vec2 into = mix(vec2(0.0), reach / BRICK_BEVEL, greaterThan(brick_into_bevel(vec2(across.x, along.x)), vec2(0.0)));
    float room = 3.0 * dot(into, into) + 1.5 * length(into) * dot(BRICK_TILT, reach);
    if (2.0 * room < bounds.y - bounds.x) {
        vec3 middle = brick_at(box_centre(low, high));
        bounds = vec2(middle.x - room, middle.x + room);
        slope = middle.yz;
    }
    return vec4(bounds + vec2(-HEIGHT_PAD, HEIGHT_PAD), slope);
}

#endif
