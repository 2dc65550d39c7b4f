// The fold certificate of a prism in f32: whether its shell map keeps its hand over a range of levels.
#ifndef SHELL_CERTIFICATE_GLSL
#define SHELL_CERTIFICATE_GLSL

// A coefficient counts as positive above this share of the squared edges: what lies below is f32's rounding.
const float CERTIFICATE_POSITIVE = 1e-6;

// Corners p, shell normals n (unit or zero), factors r, lowest and highest level. The volume element is linear across
// the triangle and quadratic in the level, so nine Bernstein coefficients bound it from below.
bool certified(vec3 p[3], vec3 n[3], vec3 r, vec2 range) {
    vec3 low[3], high[3];
    for (int k = 0; k < 3; ++k) {
        low[k] = p[k] + range.x * r[k] * n[k];
        high[k] = p[k] + range.y * r[k] * n[k];
    }
    vec3 a1 = low[1] - low[0], a2 = low[2] - low[0], b1 = high[1] - high[0], b2 = high[2] - high[0];
    vec3 first = cross(a1, a2), middle = 0.5 * (cross(a1, b2) + cross(b1, a2)), last = cross(b1, b2);
    float size = max(length(a1) + length(a2), length(b1) + length(b2));
    float least = CERTIFICATE_POSITIVE * size * size;
    for (int k = 0; k < 3; ++k) {
        if (r[k] > 0.0 && n[k] != vec3(0.0)
            && !(dot(first, n[k]) > least && dot(middle, n[k]) > least && dot(last, n[k]) > least)) {
            return false;
        }
    }
    return true;
}

#endif
