// What procedures share.
#ifndef SHELL_PROCEDURES_COMMON_GLSL
#define SHELL_PROCEDURES_COMMON_GLSL

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

#endif
