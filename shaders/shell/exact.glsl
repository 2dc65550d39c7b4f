// The exact march: the first point where the ray's curve leaves the side of the height field it is on, to f32 rounding.
//
// The curve is a rational quadratic in p in [0, 1], held as Bernstein control points in the map's cells, so any piece of
// it is a blossom away and lies in the box of three points. A piece whose box the pyramid clears is skipped; near the
// field the curve goes cell by cell, where W^2 (t - S(h)) is a polynomial of degree 5 whose six Bernstein coefficients
// show whether it can change sign: tangent hits are not lost (DESIGN section 4; Thonat et al. 2021 for the hierarchy).
//
// Needs height_cell of shell/height.glsl.
#ifndef SHELL_EXACT_GLSL
#define SHELL_EXACT_GLSL

#include "shell/curve.glsl"

// The includer's: least and greatest height over the cells from `first` to `last`, both included, or looser ones.
vec2 height_bounds(ivec2 first, ivec2 last);

// Signed height over the bilinear patch, positive on the side the ray is on.
float clearance(Curve curve, Field field, ivec2 cell, vec4 h, float p) {
    vec2 f = curve_at(curve, p) - vec2(cell);
    return field.side * (level_at(curve, p) - field_level(field, mix(mix(h.x, h.y, f.x), mix(h.z, h.w, f.x), f.y)));
}

// Where the boundary q (control points over [0, 1], positive inside) is crossed outward after `p`; 2 if never.
float outward_crossing(vec3 q, float p) {
    float a = q.x - 2.0 * q.y + q.z, b = 2.0 * (q.y - q.x), c = q.x;
    float discriminant = b * b - 4.0 * a * c;
    if (discriminant < 0.0) {
        return 2.0;
    }
    // The root with falling slope, in the form without cancellation.
    float root = sqrt(discriminant);
    float fall = b > 0.0 ? -(b + root) / (2.0 * a) : 2.0 * c / (root - b);
    if (fall > p) {
        return fall;
    }
    // Behind p (or nowhere): outward now if p lies beyond it and the curve has not come back in.
    bool outside = c + p * (b + p * a) < 0.0 || (fall == fall && b + 2.0 * a * p < 0.0 && fall <= p);
    return outside ? p : 2.0;
}

// Bernstein coefficients, times the side, of W^2 (t - S(h)) over [a, b] in one cell.
void clearance_coefficients(Curve curve, Field field, ivec2 cell, vec4 h, float a, float b, out float f[6]) {
    vec3 w = piece(curve.w, a, b);
    vec3 x = piece(curve.x, a, b) - float(cell.x) * w, y = piece(curve.y, a, b) - float(cell.y) * w;
    float slope_x = field.scale * (h.y - h.x), slope_y = field.scale * (h.z - h.x);
    float twist = field.scale * (h.x - h.y - h.z + h.w);
    // W^2 and X (slope_x W + twist Y) + slope_y Y W, both of degree 4.
    vec3 k = slope_x * w + twist * y, l = slope_y * w;
    float ww[5] = float[5](w.x * w.x, w.x * w.y, (w.x * w.z + 2.0 * w.y * w.y) / 3.0, w.y * w.z, w.z * w.z);
    float hw[5] = float[5](
        x.x * k.x + y.x * l.x,
        0.5 * (x.x * k.y + x.y * k.x + y.x * l.y + y.y * l.x),
        (x.x * k.z + 4.0 * x.y * k.y + x.z * k.x + y.x * l.z + 4.0 * y.y * l.y + y.z * l.x) / 6.0,
        0.5 * (x.y * k.z + x.z * k.y + y.y * l.z + y.z * l.y),
        x.z * k.z + y.z * l.z);
    float base = field_level(field, h.x);
    float d0 = field.side * (level_at(curve, a) - base), d1 = field.side * (level_at(curve, b) - base);
    f[0] = d0 * ww[0] - field.side * hw[0];
    for (int i = 1; i < 5; ++i) {
        f[i] = (float(5 - i) * (d0 * ww[i] - field.side * hw[i]) +
                float(i) * (d1 * ww[i - 1] - field.side * hw[i - 1])) / 5.0;
    }
    f[5] = d1 * ww[4] - field.side * hw[4];
}

// The root between a (clear) and b (not): regula falsi with the Illinois rule.
float refined_root(Curve curve, Field field, ivec2 cell, vec4 h, float a, float b) {
    float fa = clearance(curve, field, cell, h, a), fb = clearance(curve, field, cell, h, b);
    for (int i = 0; i < 12 && b - a > LEAST_STEP && fa > 0.0 && fb < 0.0; ++i) {
        float m = clamp(a + (b - a) * fa / (fa - fb), a, b);
        float fm = clearance(curve, field, cell, h, m);
        if (fm < 0.0) {
            b = m;
            fb = fm;
            fa *= 0.5;
        } else {
            a = m;
            fa = fm;
            fb *= 0.5;
        }
    }
    return fa <= 0.0 ? a : fb >= 0.0 ? b : clamp(a + (b - a) * fa / (fa - fb), a, b);
}

// The first p in [a, b] at which the curve leaves its side of the field, within one cell; 2 if it does not.
float first_root(Curve curve, Field field, ivec2 cell, vec4 h, float a, float b) {
    float low = a, size = b - a;
    uint at = 0u;
    int depth = 0;
    // Dyadic pieces from left to right; 64 is more than four full descents.
    for (int i = 0; i < 64; ++i) {
        float high = depth == 0 ? b : low + size;
        float f[6];
        clearance_coefficients(curve, field, cell, h, low, high, f);
        bool clear = true;
        int changes = 0;
        for (int k = 1; k < 6; ++k) {
            clear = clear && f[k] >= 0.0;
            changes += (f[k - 1] < 0.0) != (f[k] < 0.0) ? 1 : 0;
        }
        if (f[0] < 0.0) {
            // On the wrong side at the start by rounding alone, and on its way to the right one: nothing is hit.
            return changes == 1 && depth == 0 ? 2.0 : low;
        }
        if (changes == 1 && f[5] < 0.0) {
            return refined_root(curve, field, cell, h, low, high);
        }
        if (!clear && depth < 12 && size > LEAST_STEP) {
            ++depth;
            at <<= 1;
            size *= 0.5;
            continue;
        }
        if (f[5] < 0.0) {
            return high;
        }
        ++at;
        low = high;
        while (depth > 0 && (at & 1u) == 0u) {
            --depth;
            at >>= 1;
            size *= 2.0;
        }
        if (depth == 0) {
            return 2.0;
        }
    }
    return 2.0;
}

// The first p at which the curve hits the field, or 2. `field.side` says where it starts and, on return, where it ends.
// `limit` bounds the steps; 0 on return says that it was reached.
float exact_hit(Curve curve, inout Field field, inout int limit) {
    float p = 0.0, step = 1.0, inch = LEAST_STEP;
    while (p < 1.0 && limit > 0) {
        --limit;
        float q = min(p + step, 1.0);
        vec3 w = piece(curve.w, p, q);
        bool bounded = min(w.x, min(w.y, w.z)) > 0.0 || max(w.x, max(w.y, w.z)) < 0.0;
        if (!bounded && q - p > 64.0 * LEAST_STEP) {
            step = 0.25 * (q - p);
            continue;
        }
        if (bounded) {
            vec3 x = piece(curve.x, p, q) / w, y = piece(curve.y, p, q) / w;
            vec2 low = vec2(min(x.x, min(x.y, x.z)), min(y.x, min(y.y, y.z)));
            vec2 high = vec2(max(x.x, max(x.y, x.z)), max(y.x, max(y.y, y.z)));
            vec2 room = 1e-3 + 4e-7 * max(abs(low), abs(high));
            ivec2 first = ivec2(floor(low - room)), last = ivec2(floor(high + room));
            if (any(greaterThan(last - first, ivec2(1)))) {
                vec2 bounds = height_bounds(curve.origin + first, curve.origin + last);
                float ta = level_at(curve, p), tb = level_at(curve, q);
                bool skip = field.side > 0.0 ? min(ta, tb) > field_level(field, bounds.y)
                                             : max(ta, tb) < field_level(field, bounds.x);
                if (skip) {
                    p = q;
                    step *= 2.0;
                } else {
                    step = 0.25 * (q - p);
                }
                continue;
            }
        }

        // Few cells, or none that a box can bound: the cell at p, to where the curve leaves it.
        ivec2 cell = ivec2(floor(curve_at(curve, p)));
        vec3 right = (float(cell.x) + 1.0) * curve.w - curve.x, left = curve.x - float(cell.x) * curve.w;
        vec3 down = (float(cell.y) + 1.0) * curve.w - curve.y, up = curve.y - float(cell.y) * curve.w;
        float orientation = blossom(curve.w, p, p) < 0.0 ? -1.0 : 1.0;
        float leave = min(min(outward_crossing(orientation * right, p), outward_crossing(orientation * left, p)),
                          min(outward_crossing(orientation * down, p), outward_crossing(orientation * up, p)));
        leave = min(leave, 1.0);
        if (leave - p < LEAST_STEP) {
            // Within rounding of a border the cell may be the old one still. Its patch serves there too; further on it
            // takes more than an inch to see the new one.
            leave = min(p + inch, 1.0);
            inch *= 2.0;
        } else {
            inch = LEAST_STEP;
        }
        vec4 h = height_cell(curve.origin + cell, 0);
        float from = p;
        // At most one hit from each side, so at most three pieces: a below-above-below passes twice.
        for (int pass = 0; pass < 3; ++pass) {
            float ta = level_at(curve, from), tb = level_at(curve, leave);
            bool clear = field.side > 0.0
                ? min(ta, tb) > field_level(field, max(max(h.x, h.y), max(h.z, h.w)))
                : max(ta, tb) < field_level(field, min(min(h.x, h.y), min(h.z, h.w)));
            float root = clear ? 2.0 : first_root(curve, field, cell, h, from, leave);
            if (root > 1.0) {
                break;
            }
            if (field.side > 0.0 || field.two_sided) {
                return root;
            }
            // Past the root by a little, where the new side's clearance is no longer lost in rounding.
            field.side = -field.side;
            from = min(root + max(4.0 * LEAST_STEP, 1e-3 * (leave - root)), leave);
        }
        step = 2.0 * (leave - p);
        p = leave;
    }
    return 2.0;
}

#endif
