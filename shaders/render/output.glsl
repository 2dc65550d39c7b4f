// What a fragment leaves: the tone-mapped colour, and with AOV the surface data (DESIGN section 3).
#ifndef RENDER_OUTPUT_GLSL
#define RENDER_OUTPUT_GLSL

#include "render/view.glsl"

layout(location = 0) out vec4 out_color;
#ifdef AOV
layout(location = 1) out vec4 out_linear;         // scene-linear colour, shadow
layout(location = 2) out vec4 out_position_depth; // camera-relative world position, view depth
layout(location = 3) out vec4 out_normal_height;
layout(location = 4) out vec2 out_uv;
#endif

void write_outputs(Surface surface, Visibility visibility, vec2 uv, float view_depth, float height) {
#if !defined(VIEW) || defined(AOV)
    vec3 radiance = shade(surface, visibility);
#endif
#ifdef VIEW
    out_color = vec4(view_color(surface, visibility, uv, view_depth, height), 1.0);
#else
    out_color = vec4(tone_map(radiance), 1.0);
#endif
#ifdef AOV
    out_linear = vec4(radiance, light_visible(visibility, 0u));
    out_position_depth = vec4(surface.position, view_depth);
    out_normal_height = vec4(surface.geometric, height);
    out_uv = uv;
#endif
}

#endif
