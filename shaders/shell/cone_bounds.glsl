// How steep a cone has to be: the bounds of engine/src/shell/cones.rs, for pairs of cells and for whole nodes of cells.
//
// Heights per UV; offsets in cells; CONE_RELAXED chooses the promise. No bindings.
#ifndef SHELL_CONE_BOUNDS_GLSL
#define SHELL_CONE_BOUNDS_GLSL

// Heights of a cell's corners, row by row.
vec2 cell_range(vec4 h) {
    return vec2(min(min(h.x, h.y), min(h.z, h.w)), max(max(h.x, h.y), max(h.z, h.w)));
}

// Least and greatest slope along u (xy) and along v (zw), heights per texel.
vec4 cell_slopes(vec4 h) {
    vec2 u = vec2(h.y - h.x, h.w - h.z), v = vec2(h.z - h.x, h.w - h.y);
    return vec4(min(u.x, u.y), max(u.x, u.y), min(v.x, v.y), max(v.x, v.y));
}

// The steepest climb among slopes along one axis, walked in one direction, or in both for 0.
float climb(vec2 slopes, int toward) {
    return toward == 0 ? max(abs(slopes.x), abs(slopes.y)) : max(toward > 0 ? slopes.y : -slopes.x, 0.0);
}

float steepest(vec4 slopes, ivec2 toward, vec2 size) {
    return length(vec2(climb(slopes.xy, toward.x), climb(slopes.zw, toward.y)) * size);
}

// From a cell to itself; `h` its corners.
float own_steepness(vec4 h, vec2 size) {
#ifdef CONE_RELAXED
    return abs(h.x - h.y - h.z + h.w) / length(1.0 / size);
#else
    return steepest(cell_slopes(h), ivec2(0), size);
#endif
}

// From a cell to one that touches it, past the two beside both.
float near_steepness(vec4 cell, vec4 beyond, vec4 side_u, vec4 side_v, ivec2 toward, vec2 size) {
    if (cell_range(beyond).y <= cell_range(cell).x) {
        return 0.0;
    }
    vec4 own = cell_slopes(cell), slopes = cell_slopes(beyond), u = cell_slopes(side_u), v = cell_slopes(side_v);
    float bound = max(max(steepest(own, ivec2(0), size), steepest(slopes, toward, size)),
                      max(steepest(u, toward, size), steepest(v, toward, size)));
#ifdef CONE_RELAXED
    vec4 low = min(min(own, slopes), min(u, v)), high = max(max(own, slopes), max(u, v));
    bound = min(bound, steepest(vec4(low.x - slopes.y, high.y - slopes.x, low.z - slopes.w, high.w - slopes.z), toward,
                                size));
#endif
    return bound;
}

// From heights not under `low` to cells at offsets `first` to `last`, not over `high`, of such slopes. As large as need
// be where they touch.
float node_steepness(float low, float high, vec4 slopes, ivec2 first, ivec2 last, vec2 size) {
    float rise = high - low;
#ifdef CONE_RELAXED
    vec2 from = vec2(first - 1), to = vec2(last + 1);
    vec2 u = min(slopes.xy * from.x, slopes.xy * to.x), v = min(slopes.zw * from.y, slopes.zw * to.y);
    rise = min(rise, rise - min(u.x, u.y) - min(v.x, v.y));
#endif
    vec2 gap = vec2(max(max(first - 1, -last - 1), ivec2(0))) / size;
    return rise <= 0.0 ? 0.0 : rise / max(length(gap), 1e-20);
}

// From a cell p to a cell q that does not touch it, beside what node_steepness finds.
float far_steepness(vec4 p, vec4 q, ivec2 offset, vec2 size) {
    vec2 along = normalize(vec2(offset) / size);
    float chord = 0.0, tangent = 0.0;
    for (int j = 0; j < 4; ++j) {
        vec2 slope = vec2(j < 2 ? q.y - q.x : q.w - q.z, (j & 1) == 0 ? q.z - q.x : q.w - q.y);
        for (int i = 0; i < 4; ++i) {
            vec2 way = vec2(offset + ivec2((j & 1) - (i & 1), (j >> 1) - (i >> 1)));
            float away = dot(way / size, along), rise = q[j] - p[i];
            chord = max(chord, rise / away);
            tangent = max(tangent, (rise - dot(slope, way)) / away);
        }
    }
#ifdef CONE_RELAXED
    return min(chord, tangent);
#else
    return chord;
#endif
}

#endif
