// Procedural heights: the one that HEIGHT_PROCEDURE names, behind the height hook.
//
// A procedure is continuous, repeats with period 1 along u and v, and gives
//
//     float height_at(vec2 uv, float lod)           the height in [0, 1]; lod is of no account
//     vec2 height_gradient(vec2 uv, float lod)      dh/du and dh/dv; at a crease those of one side
//     vec4 height_bounds_uv(vec2 low, vec2 high)    over a box of UV: a slope (z, w) of the procedure's choice, and the
//                                                   least and greatest height less that slope times the way from
//                                                   box_centre(low, high), or looser ones (x, y), padded by
//                                                   HEIGHT_PAD for f32; away from creases they close in with the
//                                                   square of the box, by the slope of the middle
//     vec2 height_size()                            texels, powers of two, of a map that would hold its features
//
// scene/procedure/ has the same in f64, and tests/procedures.rs holds the two to each other.
#ifndef SHELL_PROCEDURES_GLSL
#define SHELL_PROCEDURES_GLSL

// More than the rounding of any height or bound in f32, where |uv| is at most 2.
const float HEIGHT_PAD = 1e-6;

vec2 box_centre(vec2 low, vec2 high) {
    return low + 0.5 * (high - low);
}

// From the centre to the sides, with room for the centre's rounding.
vec2 box_reach(vec2 low, vec2 high) {
    return 0.5 * (high - low) + 1.2e-7 * max(abs(low), abs(high));
}

// A number without order, the same for the same `n`: the 32-bit finaliser of C. Wellons (hash-prospector, "lowbias32").
uint scrambled(uint n) {
    n ^= n >> 16;
    n *= 0x7feb352du;
    n ^= n >> 15;
    n *= 0x846ca68bu;
    return n ^ n >> 16;
}

// Its bits in three fractions in [0, 1).
vec3 scrambled_fractions(uint n) {
    uint bits = scrambled(n);
    return vec3(bits & 1023u, bits >> 10 & 1023u, bits >> 20 & 1023u) / 1024.0;
}

#define PROCEDURE_BRICKS 1
#define PROCEDURE_COBBLES 2
#define PROCEDURE_WAVES 3

#if HEIGHT_PROCEDURE == PROCEDURE_BRICKS
#include "shell/procedures/bricks.glsl"
#elif HEIGHT_PROCEDURE == PROCEDURE_COBBLES
#include "shell/procedures/cobbles.glsl"
#elif HEIGHT_PROCEDURE == PROCEDURE_WAVES
#include "shell/procedures/waves.glsl"
#else
#error HEIGHT_PROCEDURE names none of the procedures
#endif

#endif
