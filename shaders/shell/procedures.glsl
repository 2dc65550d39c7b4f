// Procedural heights: the one that HEIGHT_PROCEDURE names, behind the height hook, and those that OTHER_0_PROCEDURE to
// OTHER_6_PROCEDURE name, behind procedure_height. No other is in the code.
//
// A procedure is continuous, repeats with period 1 along u and v, and gives, by names of its own,
//
//     float NAME_height(vec2 uv)                the height in [0, 1]
//     vec2 NAME_gradient(vec2 uv)               dh/du and dh/dv; at a crease those of one side
//     vec4 NAME_bounds(vec2 low, vec2 high)     over a box of UV: a slope (z, w) of the procedure's choice, and the least
//                                               and greatest height less that slope times the way from
//                                               box_centre(low, high), or looser ones (x, y), padded by HEIGHT_PAD for
//                                               f32; away from creases they close in with the square of the box, by
//                                               the slope of the middle
//     vec2 NAME_size()                          texels, powers of two, of a map that would hold its features
//
// scene/procedure/ has the same in f64, and tests/procedures.rs holds the two to each other.
#ifndef SHELL_PROCEDURES_GLSL
#define SHELL_PROCEDURES_GLSL

#include "shell/work.glsl"

// 0, an undefined name's value, is none.
#define PROCEDURE_BRICKS 1
#define PROCEDURE_COBBLES 2
#define PROCEDURE_WAVES 3

#define IS_PROCEDURE(name) \
    (HEIGHT_PROCEDURE == name || OTHER_0_PROCEDURE == name || OTHER_1_PROCEDURE == name || \
     OTHER_2_PROCEDURE == name || OTHER_3_PROCEDURE == name || OTHER_4_PROCEDURE == name || \
     OTHER_5_PROCEDURE == name || OTHER_6_PROCEDURE == name)

#if IS_PROCEDURE(PROCEDURE_BRICKS)
#include "shell/procedures/bricks.glsl"
#endif
#if IS_PROCEDURE(PROCEDURE_COBBLES)
#include "shell/procedures/cobbles.glsl"
#endif
#if IS_PROCEDURE(PROCEDURE_WAVES)
#include "shell/procedures/waves.glsl"
#endif

// The height of the procedure of this number, one that a define names.
float procedure_height(const int procedure, vec2 uv) {
    count_read();
#if IS_PROCEDURE(PROCEDURE_BRICKS)
    if (procedure == PROCEDURE_BRICKS) {
        return bricks_height(uv);
    }
#endif
#if IS_PROCEDURE(PROCEDURE_COBBLES)
    if (procedure == PROCEDURE_COBBLES) {
        return cobbles_height(uv);
    }
#endif
#if IS_PROCEDURE(PROCEDURE_WAVES)
    if (procedure == PROCEDURE_WAVES) {
        return waves_height(uv);
    }
#endif
    return 0.0;
}

#ifdef HEIGHT_PROCEDURE
#if HEIGHT_PROCEDURE == PROCEDURE_BRICKS
#define OWN_GRADIENT bricks_gradient
#define OWN_BOUNDS bricks_bounds
#define OWN_SIZE bricks_size
#elif HEIGHT_PROCEDURE == PROCEDURE_COBBLES
#define OWN_GRADIENT cobbles_gradient
#define OWN_BOUNDS cobbles_bounds
#define OWN_SIZE cobbles_size
#elif HEIGHT_PROCEDURE == PROCEDURE_WAVES
#define OWN_GRADIENT waves_gradient
#define OWN_BOUNDS waves_bounds
#define OWN_SIZE waves_size
#else
#error HEIGHT_PROCEDURE names none of the procedures
#endif

// `lod` is of no account.
float height_at(vec2 uv, float lod) {
    return procedure_height(HEIGHT_PROCEDURE, uv);
}

vec2 height_gradient(vec2 uv, float lod) {
    count_read();
    return OWN_GRADIENT(uv);
}

vec4 height_bounds_uv(vec2 low, vec2 high) {
    count_read();
    return OWN_BOUNDS(low, high);
}

vec2 height_size() {
    return OWN_SIZE();
}
#endif

#endif
