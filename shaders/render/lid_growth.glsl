// How far lids and bases are drawn beyond their levels.
#ifndef RENDER_LID_GROWTH_GLSL
#define RENDER_LID_GROWTH_GLSL

#include "render/interface.glsl"
#include "shell/lean.glsl"

// In pixels. It keeps the rasteriser's snapping (1/512 pixel) from dropping pixels at the outline also where the normal
// leans; the trace clips to the exact shell.
const float GROWTH = 0.125;

// Prisms up to this many near depths away count as cut by the near plane: it may clip their lids, which are drawn grown.
const float NEAR_REACH = 1.01;

// The growth as levels, for a corner at `at` with shell normal `shell`.
float lid_growth(Object object, vec3 at, vec3 shell) {
    float w = abs(dot(object.clip_w.xyz, at) + object.clip_w.w);
    float pixel = 2.0 * w * max(frame.viewport.z / length(object.clip_x.xyz), frame.viewport.w / length(object.clip_y.xyz));
    return GROWTH * pixel / max(length(shell), LEAST_NORMAL);
}

#endif
