// The exact march: the first point where the ray's curve leaves the side of the height field it is on, to f32 rounding.
//
// The curve is a rational quadratic in p in [0, 1] over the map's cells, so each piece lies in the box of its two ends and
// one control point between them. A piece whose box the pyramid clears is skipped; near the field the curve goes cell by
// cell, where W^2 (t - S(h)) is a polynomial of degree 5 whose six Bernstein coefficients show whether it can change
// sign: tangent hits are not lost (DESIGN section 4; Thonat et al. 2021 for the hierarchy).
//
// Needs height_cell of shell/height.glsl.
#ifndef SHELL_EXACT_GLSL
#define SHELL_EXACT_GLSL

#include "shell/curve.glsl"
#ifdef SOFT_SHADOW
#include "shell/soft.glsl"
#endif

// The includer's: least and greatest height over the cells from `first` to `last`, both included, or looser ones.
vec2 height_bounds(ivec2 first, ivec2 last);

// What a ray must rise over the field to have passed it, as a part of the height's scale: the rounding of a path of a
// hundred cells.
const float LEAST_RISE = 1e-5;
const float NO_RISE = -1.0;

// A cell and the heights of its texels.
struct Place {
    ivec2 cell;
    vec4 h;
};

// The level of a range of heights that the ray comes to first: a negative scale turns heights over.
float nearest_level(Field field, float low, float high) {
    return field_level(field, field.side * field.scale > 0.0 ? high : low);
}

// Signed height over the bilinear patch, positive on the side the ray is on.
float clearance(Curve curve, Powers powers, Field field, Place place, float p) {
    vec2 f = curve_at(powers, p) - vec2(place.cell);
    vec4 h = place.h;
    return field.side * (level_at(curve, p) - field_level(field, mix(mix(h.x, h.y, f.x), mix(h.z, h.w, f.x), f.y)));
}

// Where the boundary a + b p + c p^2 (positive inside) is crossed outward after `p`; 2 if never.
float outward_crossing(float a, float b, float c, float p) {
    float discriminant = b * b - 4.0 * a * c;
    // The root with falling slope, in the form without cancellation; NaN where the boundary is never met.
    float root = sqrt(discriminant);
    float fall = b > 0.0 ? -(b + root) / (2.0 * c) : 2.0 * a / (root - b);
    if (fall > p) {
        return fall;
    }
    // Behind p (or nowhere): outward now if p lies beyond it and the curve has not come back in.
    bool outside = discriminant >= 0.0 && (a + p * (b + p * c) < 0.0 || (fall == fall && b + 2.0 * c * p < 0.0));
    return outside ? p : 2.0;
}

// Where the curve leaves a cell after `p`.
float cell_exit(Powers powers, ivec2 cell, float p) {
    float orientation = point_at(powers, p).z < 0.0 ? -1.0 : 1.0;
    vec2 low = vec2(cell), high = low + 1.0;
    // w x' - x and x - w x', for the boundary x' of either side.
    vec2 a0 = orientation * (high * powers.c0.z - powers.c0.xy), b0 = orientation * (powers.c0.xy - low * powers.c0.z);
    vec2 a1 = orientation * (high * powers.c1.z - powers.c1.xy), b1 = orientation * (powers.c1.xy - low * powers.c1.z);
    vec2 a2 = orientation * (high * powers.c2.z - powers.c2.xy), b2 = orientation * (powers.c2.xy - low * powers.c2.z);
    return min(min(outward_crossing(a0.x, a1.x, a2.x, p), outward_crossing(b0.x, b1.x, b2.x, p)),
               min(outward_crossing(a0.y, a1.y, a2.y, p), outward_crossing(b0.y, b1.y, b2.y, p)));
}

// Bernstein coefficients, times the side, of W^2 (t - S(h)) over [a, b] in one cell.
void clearance_coefficients(Curve curve, Powers powers, Field field, Place place, float a, float b, out float f[6]) {
    vec4 h = place.h;
    vec3 first = point_at(powers, a), middle = control_between(powers, a, b), last = point_at(powers, b);
    vec3 w = vec3(first.z, middle.z, last.z);
    vec3 x = vec3(first.x, middle.x, last.x) - float(place.cell.x) * w;
    vec3 y = vec3(first.y, middle.y, last.y) - float(place.cell.y) * w;
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

#include "shell/root.glsl"

// The first p in [a, b] at which the curve leaves its side of the field, within one cell; 2 if it does not.
float first_root(Curve curve, Powers powers, Field field, Place place, float a, float b) {
    float low = a, size = b - a;
    uint at = 0u;
    int depth = 0;
    // Dyadic pieces from left to right; 64 is more than four full descents.
    for (int i = 0; i < 64; ++i) {
        float high = depth == 0 ? b : low + size;
        float f[6];
        clearance_coefficients(curve, powers, field, place, low, high, f);
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
            return refined_root(curve, powers, field, place, low, high);
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
    Powers powers = powers_of(curve);
    float p = 0.0, step = 1.0, inch = LEAST_STEP, rose = NO_RISE;
    while (p < 1.0 && limit > 0) {
        // Boxes, until one is small enough for its cells: lanes that march together stay together so.
        bool cells = false;
        while (!cells && p < 1.0 && limit > 0) {
            --limit;
            float q = min(p + step, 1.0);
            vec3 a = point_at(powers, p), m = control_between(powers, p, q), b = point_at(powers, q);
            bool bounded = min(a.z, min(m.z, b.z)) > 0.0 || max(a.z, max(m.z, b.z)) < 0.0;
            a.xy /= a.z;
            m.xy /= m.z;
            b.xy /= b.z;
            vec2 low = min(a.xy, min(m.xy, b.xy)), high = max(a.xy, max(m.xy, b.xy));
            vec2 room = 1e-3 + 4e-7 * max(abs(low), abs(high));
            ivec2 first = ivec2(floor(low - room)), last = ivec2(floor(high + room));
            if (!bounded) {
                cells = q - p <= 64.0 * LEAST_STEP;
                step = 0.25 * (q - p);
            } else {
                vec2 bounds = height_bounds(curve.origin + first, curve.origin + last);
                float bound = nearest_level(field, bounds.x, bounds.y);
                float from = field.side * (level_at(curve, p) - bound), to = field.side * (level_at(curve, q) - bound);
#ifdef SOFT_SHADOW
                float spare = penumbra_spare(q);
                from -= spare;
                to -= spare;
#endif
                if (from > 0.0 && to > 0.0) {
                    p = q;
                    step *= 2.0;
                } else if (all(lessThanEqual(last - first, ivec2(1)))) {
                    cells = true;
                } else {
                    step = 0.25 * (q - p);
                    // Clear as far as the bound; less a little for rounding.
                    p += from > 0.0 ? max((q - p) * (from / (from - to)) * 0.999 - LEAST_STEP, 0.0) : 0.0;
                }
            }
        }
        if (!cells) {
            break;
        }

        // Few cells, or none that a box can bound: the cell at p, to where the curve leaves it.
        ivec2 cell = ivec2(floor(curve_at(powers, p)));
        float leave = min(cell_exit(powers, cell, p), 1.0);
        if (leave - p < LEAST_STEP) {
            // Within rounding of a border the cell may be the old one still. Its patch serves there too; further on it
            // takes more than an inch to see the new one.
            leave = min(p + inch, 1.0);
            inch *= 2.0;
        } else {
            inch = LEAST_STEP;
        }
        Place place = Place(cell, height_cell(curve.origin + cell));
        vec4 h = place.h;
        float from = p;
        // At most one hit from each side, so at most three pieces: a below-above-below passes twice.
        for (int pass = 0; pass < 3; ++pass) {
            float ta = level_at(curve, from), tb = level_at(curve, leave);
            float nearest = nearest_level(field, min(min(h.x, h.y), min(h.z, h.w)), max(max(h.x, h.y), max(h.z, h.w)));
            bool clear = field.side > 0.0 ? min(ta, tb) > nearest : max(ta, tb) < nearest;
            float root = clear ? 2.0 : first_root(curve, powers, field, place, from, leave);
            if (root > 1.0) {
                break;
            }
            if (field.side > 0.0 || field.two_sided) {
                return root;
            }
            // Past the root by a little, where the new side's clearance is no longer lost in rounding.
            field.side = -field.side;
            rose = root;
            from = min(root + max(4.0 * LEAST_STEP, 1e-3 * (leave - root)), leave);
        }
#ifdef SOFT_SHADOW
        if (penumbra.open) {
            float middle = 0.5 * (p + leave);
            penumbra_see_piece(vec3(clearance(curve, powers, field, place, p),
                                    clearance(curve, powers, field, place, middle),
                                    clearance(curve, powers, field, place, leave)), p, leave);
        }
#endif
        step = 2.0 * (leave - p);
        p = leave;
    }
    // A ray on its way out that meets the field where it meets the wall may seem to have passed it, by rounding alone;
    // the next prism finds it below still. One that rose by nothing has not risen, or it would seem to fall back: a hit.
    if (rose != NO_RISE) {
        float between = 0.5 * (rose + 1.0);
        ivec2 cell = ivec2(floor(curve_at(powers, between)));
        float least = LEAST_RISE * max(abs(field.scale), max(abs(curve.t.x), abs(curve.t.y)));
        if (clearance(curve, powers, field, Place(cell, height_cell(curve.origin + cell)), between) < least) {
            field.side = -field.side;
        }
    }
    return 2.0;
}

#endif
