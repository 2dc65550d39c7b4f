// The exact march under a procedural height: the first point where the ray's curve leaves the side of the field it is
// on.
//
// A piece of the curve lies in the box of its three control points, over which the procedure bounds its heights less a
// slope. The levels less that slope are a rational cubic along the piece, within the span of its control points; where
// the two spans are apart the piece is clear, and the next one is twice as long; else it is a quarter. A piece is too
// small for bounds where the spans together are below RESOLUTION of the height range, or below what the rounding of its
// UVs makes of the heights, and where it is LEAST_STEP long: there the sign at its end decides, so a graze that dips in
// by less can be missed, and no other. The cells of the curve are the texels of a map of height_size(); powers of two,
// so that f32 turns them into UV without rounding.
//
// Needs height_at, height_bounds_uv and height_size of shell/procedures.glsl.
#ifndef SHELL_EXACT_PROCEDURAL_GLSL
#define SHELL_EXACT_PROCEDURAL_GLSL

#include "shell/curve.glsl"
#ifdef SOFT_SHADOW
#include "shell/soft.glsl"

// A clearance is known well enough to this share of the disc's width.
const float PENUMBRA_RESOLUTION = 4e-3;
// Of the clearance along an interval, before any bounds.
const int PENUMBRA_SAMPLES = 16;
// Bounds of slopes are loose across creases, and clearances take more pieces than a hit: so many times its limit.
const int PENUMBRA_STEPS = 4;
#endif

// Of the height range, the bounds' padding included.
const float RESOLUTION = 4.0 * HEIGHT_PAD;

// UV of the curve's cell (0, 0), in cells; whole periods are of no account, and the nearer to 0, the more bits are
// left.
vec2 curve_offset(Curve curve) {
    ivec2 size = ivec2(height_size());
    return vec2(((curve.origin + size / 2) & (size - 1)) - size / 2) + 0.5;
}

// `curve_offset` of the curve.
struct Place {
    vec2 offset;
};

// Signed height over the field, positive on the side the ray is on.
float clearance(Curve curve, Powers powers, Field field, Place place, float p) {
    vec2 uv = (curve_at(powers, p) + place.offset) / height_size();
    return field.side * (level_at(curve, p) - field_level(field, height_at(uv, 0.0)));
}

#include "shell/root.glsl"

// Least and greatest of t - slope . (cells - middle) over the piece [p, q] with control points x / y and weights w:
// times the denominator it is a cubic, whose control points over those of the denominator bound the quotient.
vec2 levels_less(Curve curve, vec2 slope, vec2 middle, vec3 x, vec3 y, vec3 w, float p, float q) {
    vec3 less = w * (slope.x * (x - middle.x) + slope.y * (y - middle.y));
    float a = level_at(curve, p), b = level_at(curve, q);
    float f1 = (w.x * b + 2.0 * w.y * a - less.x - 2.0 * less.y) / (w.x + 2.0 * w.y);
    float f2 = (2.0 * w.y * b + w.z * a - 2.0 * less.y - less.z) / (2.0 * w.y + w.z);
    float f0 = a - less.x / w.x, f3 = b - less.z / w.z;
    return vec2(min(min(f0, f1), min(f2, f3)), max(max(f0, f1), max(f2, f3)));
}

// The first p at which the curve hits the field, or 2. `field.side` says where it starts and, on return, where it ends.
// `limit` bounds the steps; 0 on return says that it was reached.
float exact_hit(Curve curve, inout Field field, inout int limit) {
    Powers powers = powers_of(curve);
    Place place = Place(curve_offset(curve));
    vec2 offset = place.offset, size = height_size();
    float p = 0.0, step = 1.0;
#ifdef SOFT_SHADOW
    // Nearly the least clearance first: what is not near it is then passed in long steps. Denser next to the start, where
    // the disc is narrow.
    for (int i = 1; penumbra.open && i <= PENUMBRA_SAMPLES; ++i) {
        float at = float(i * i) / float(PENUMBRA_SAMPLES * PENUMBRA_SAMPLES);
        penumbra_see(clearance(curve, powers, field, place, at), penumbra_distance(at));
    }
    limit *= penumbra.open ? PENUMBRA_STEPS : 1;
#endif
    while (p < 1.0 && limit > 0) {
        --limit;
        float q = min(p + step, 1.0);
        vec3 a = point_at(powers, p), m = control_between(powers, p, q), b = point_at(powers, q);
        vec3 w = vec3(a.z, m.z, b.z);
        bool bounded = min(w.x, min(w.y, w.z)) > 0.0 || max(w.x, max(w.y, w.z)) < 0.0;
        if (!bounded && q - p > 64.0 * LEAST_STEP) {
            step = 0.25 * (q - p);
            continue;
        }
        vec3 x = vec3(a.x, m.x, b.x) / w, y = vec3(a.y, m.y, b.y) / w;
        if (!bounded) {
            // Too short a piece to stray between its ends.
            x.y = x.x;
            y.y = y.x;
        }
        vec2 low = vec2(min(x.x, min(x.y, x.z)), min(y.x, min(y.y, y.z)));
        vec2 high = vec2(max(x.x, max(x.y, x.z)), max(y.x, max(y.y, y.z)));
        vec2 room = 4e-7 * max(abs(low), abs(high)) + 2e-7 * max(abs(low + offset), abs(high + offset));
        vec4 bounds = height_bounds_uv((low + offset - room) / size, (high + offset + room) / size);
        vec2 slope = field.scale * bounds.zw / size;
        float rounding = dot(abs(slope), room);
        vec2 levels = levels_less(curve, slope, 0.5 * (low + high), x, y, w, p, q);
        // With a negative scale the lower height is the higher level.
        vec2 surface = vec2(field_level(field, bounds.x), field_level(field, bounds.y));
        surface = vec2(min(surface.x, surface.y) - rounding, max(surface.x, surface.y) + rounding);
#ifdef SOFT_SHADOW
        float gap = field.side > 0.0 ? levels.x - surface.y : surface.x - levels.y;
        if (gap > 0.0 && penumbra.open) {
            // Clear; and what it hides of the light is known, or found out by a shorter piece.
            float width = penumbra_width(penumbra_distance(q));
            if (gap < penumbra.least * width) {
                penumbra_see(clearance(curve, powers, field, place, q), penumbra_distance(q));
            }
            // Next to the start the bounds' padding is more than that share.
            float known = gap + penumbra.rounding;
            if (known < (penumbra.least - PENUMBRA_RESOLUTION) * width && step > LEAST_STEP) {
                step = max(0.25 * min(step, q - p), LEAST_STEP);
                continue;
            }
        }
#endif
        if (field.side > 0.0 ? levels.x > surface.y : levels.y < surface.x) {
            p = q;
            step *= 2.0;
            continue;
        }
        float level_span = levels.y - levels.x, surface_span = surface.y - surface.x;
        // At a crease the bounds know the slope of one side only; there the box itself says when it is all rounding.
        bool tiny = level_span + surface_span <= RESOLUTION * abs(field.scale) + 4.0 * rounding ||
            (level_span <= surface_span && all(lessThanEqual(high - low, room)));
        if (!tiny && step > LEAST_STEP) {
            // By the step, not by q - p, which its rounding can make a longer one for ever.
            step = max(0.25 * min(step, q - p), LEAST_STEP);
            continue;
        }
        if (clearance(curve, powers, field, place, q) < 0.0) {
            if (field.side > 0.0 || field.two_sided) {
                return refined_root(curve, powers, field, place, p, q);
            }
            field.side = -field.side;
        }
        p = q;
        step *= 2.0;
    }
    return 2.0;
}

#endif
