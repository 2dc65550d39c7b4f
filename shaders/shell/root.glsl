// The last step of both exact marches: the root between two points of the curve.
//
// The includer gives before: struct Place, which says where in the field the piece lies, and
//     float clearance(Curve curve, Powers powers, Field field, Place place, float p)
// the signed height over the field, positive on the side the ray is on.
#ifndef SHELL_ROOT_GLSL
#define SHELL_ROOT_GLSL

#include "shell/curve.glsl"

// The root between a (clear) and b (not): regula falsi with the Illinois rule, until the clearance is rounding noise.
float refined_root(Curve curve, Powers powers, Field field, Place place, float a, float b) {
    float fa = clearance(curve, powers, field, place, a), fb = clearance(curve, powers, field, place, b);
    float noise = 1e-7 * (abs(field.scale) + abs(level_at(curve, a)));
    int stays = 0;
    for (int i = 0; i < 12 && b - a > LEAST_STEP && fa > noise && fb < -noise; ++i) {
        float m = clamp(a + (b - a) * fa / (fa - fb), a, b);
        float fm = clearance(curve, powers, field, place, m);
        if (abs(fm) <= noise) {
            return m;
        }
        // An end that stays for a second time weighs half.
        if (fm < 0.0) {
            b = m;
            fb = fm;
            fa *= stays < 0 ? 0.5 : 1.0;
            stays = -1;
        } else {
            a = m;
            fa = fm;
            fb *= stays > 0 ? 0.5 : 1.0;
            stays = 1;
        }
    }
    return fa <= 0.0 ? a : fb >= 0.0 ? b : clamp(a + (b - a) * fa / (fa - fb), a, b);
}

#endif
