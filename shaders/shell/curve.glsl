// What the exact marches share: the ray's curve through the height field's cells, and the side of the field it is on.
#ifndef SHELL_CURVE_GLSL
#define SHELL_CURVE_GLSL

// Least step along p: 4 ulp of 1.
const float LEAST_STEP = 2.5e-7;

struct Curve {
    vec3 x, y, w; // numerators (cells, relative to `origin`) and denominator: Bernstein control points
    vec2 t;       // level at p = 0 and at p = 1
    ivec2 origin; // cell
};

// How heights become levels, and which side the ray is on.
struct Field {
    float scale, midlevel;
    float side;     // +1 above the field, -1 below
    bool two_sided; // leaving it from below is a hit too
};

// The curve by powers of p: (x, y, w) = c0 + p (c1 + p c2).
struct Powers {
    vec3 c0, c1, c2;
};

Powers powers_of(Curve curve) {
    vec3 a = vec3(curve.x.x, curve.y.x, curve.w.x), b = vec3(curve.x.y, curve.y.y, curve.w.y);
    vec3 c = vec3(curve.x.z, curve.y.z, curve.w.z);
    return Powers(a, 2.0 * (b - a), (a - b) + (c - b));
}

vec3 point_at(Powers powers, float p) {
    return powers.c0 + p * (powers.c1 + p * powers.c2);
}

// The middle control point of the piece [a, b]; the others are its ends.
vec3 control_between(Powers powers, float a, float b) {
    return powers.c0 + 0.5 * (a + b) * powers.c1 + (a * b) * powers.c2;
}

vec2 curve_at(Powers powers, float p) {
    vec3 at = point_at(powers, p);
    return at.xy / at.z;
}

float level_at(Curve curve, float p) {
    return mix(curve.t.x, curve.t.y, p);
}

float field_level(Field field, float h) {
    return (h - field.midlevel) * field.scale;
}

#endif
