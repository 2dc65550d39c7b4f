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

float level_at(Curve curve, float p) {
    return mix(curve.t.x, curve.t.y, p);
}

float field_level(Field field, float h) {
    return (h - field.midlevel) * field.scale;
}

#endif
