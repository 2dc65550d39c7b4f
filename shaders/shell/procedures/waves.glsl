// Waves: a sum of six sines, each with a whole number of waves per UV unit along both axes; see
// scene/procedure/waves.rs.
#ifndef SHELL_WAVES_GLSL
#define SHELL_WAVES_GLSL

#include "shell/procedures/common.glsl"

const int WAVE_COUNT = 6;
// Waves per UV unit along u and v, amplitude, phase in turns.
const vec4 WAVES[WAVE_COUNT] = vec4[WAVE_COUNT](
    vec4(1.0, 2.0, 0.14, 0.0), vec4(3.0, 1.0, 0.11, 0.375), vec4(-2.0, 3.0, 0.09, 0.703125),
    vec4(4.0, -1.0, 0.07, 0.125), vec4(5.0, 4.0, 0.05, 0.59375), vec4(-3.0, 6.0, 0.04, 0.828125));

const float WAVE_TURN = 6.283185307;

vec2 waves_size() {
    return vec2(64.0);
}

// sin and cos of angles in turns, to 2e-7: Vulkan promises no more than 2^-11 of its own.
vec2 wave_sin_cos(float turns) {
    // To within a quarter turn of 0, by sin(pi - x) = sin x; the polynomial is Taylor's.
    vec2 x = vec2(turns, turns + 0.25);
    x -= floor(x + 0.5);
    x = mix(x, sign(x) * 0.5 - x, greaterThan(abs(x), vec2(0.25)));
    x *= WAVE_TURN;
    vec2 s = x * x;
    vec2 tail = s * (1.0 / 362880.0 - s * (1.0 / 39916800.0 - s / 6227020800.0));
    return x + x * s * (-1.0 / 6.0 + s * (1.0 / 120.0 + s * (-1.0 / 5040.0 + tail)));
}

// Height, and its slopes along u and v.
vec3 wave_sum(vec2 uv) {
    vec2 at = uv - floor(uv + 0.5);
    vec3 sum = vec3(0.5, 0.0, 0.0);
    for (int i = 0; i < WAVE_COUNT; ++i) {
        vec4 wave = WAVES[i];
        vec2 sin_cos = wave_sin_cos(dot(wave.xy, at) + wave.w);
        sum += wave.z * vec3(sin_cos.x, WAVE_TURN * sin_cos.y * wave.xy);
    }
    return sum;
}

float waves_height(vec2 uv) {
    return wave_sum(uv).x;
}

vec2 waves_gradient(vec2 uv) {
    return wave_sum(uv).yz;
}

// Taylor's expansion about the middle, and what the second derivatives can add.
vec4 waves_bounds(vec2 low, vec2 high) {
    vec2 reach = box_reach(low, high);
    vec3 middle = wave_sum(box_centre(low, high));
    float room = HEIGHT_PAD;
    for (int i = 0; i < WAVE_COUNT; ++i) {
        float turn = WAVE_TURN * dot(abs(WAVES[i].xy), reach);
        room += 0.5 * WAVES[i].z * turn * turn;
    }
    return vec4(middle.x - room, middle.x + room, middle.yz);
}

#endif
