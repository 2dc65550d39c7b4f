// What a view shows in the shaded colour's place (settings.rs, View).
#ifndef RENDER_VIEW_GLSL
#define RENDER_VIEW_GLSL
#ifdef VIEW

#include "shell/work.glsl"

// The target puts sRGB's curve on a colour; undone here, so that the picture's bytes are what is shown.
vec3 displayed(vec3 color) {
    vec3 curved = pow((color + 0.055) / 1.055, vec3(2.4));
    return mix(color / 12.92, curved, greaterThan(color, vec3(0.04045)));
}

#ifdef VIEW_PRISMS
// The one that is seen.
uint seen_prism = 0xffffffffu;

// A colour that its neighbours are unlikely to have: pcg3d (Jarzynski and Olano 2020).
vec3 prism_color(uint salt, uint prism) {
    uvec3 v = uvec3(salt, prism, 0u) * 1664525u + 1013904223u;
    for (int i = 0; i < 2; ++i) {
        v.x += v.y * v.z;
        v.y += v.z * v.x;
        v.z += v.x * v.y;
        v ^= v >> 16u;
    }
    return 0.2 + 0.8 * vec3(v >> 8u & 255u) / 255.0;
}
#endif

#if defined(VIEW_WALK) || defined(VIEW_GATHERS)
// Black at 0; from 1 to 256 the colours of samples/app/heat.rs.
vec3 count_color(uint count) {
    const vec3 scale[8] = vec3[8](vec3(0, 0, 4), vec3(40, 11, 84), vec3(101, 21, 110), vec3(159, 42, 99),
                                  vec3(212, 72, 66), vec3(245, 125, 21), vec3(250, 193, 39), vec3(252, 255, 164));
    float at = clamp(7.0 / 8.0 * log2(max(float(count), 1.0)), 0.0, 7.0);
    int below = min(int(at), 6);
    return count == 0u ? vec3(0.0) : mix(scale[below], scale[below + 1], at - float(below)) / 255.0;
}
#endif

vec3 view_color(Surface surface, Visibility visibility, vec2 uv, float view_depth, float height) {
    vec3 color = vec3(0.5);
#if defined(VIEW_PRISMS)
    color = seen_prism == 0xffffffffu ? color : prism_color(draw.prism_count, seen_prism);
#elif defined(VIEW_WALK) || defined(VIEW_GATHERS)
    color = count_color(work);
#elif defined(VIEW_LIMITS)
    color = limits_reached > 0u ? vec3(1.0, 0.0, 0.0) : vec3(0.15 + 0.3 * dot(surface.geometric, surface.view));
#elif defined(VIEW_UV)
    vec2 tile = floor(uv);
    color = vec3(uv - tile, 0.5 * mod(tile.x + tile.y, 2.0));
#elif defined(VIEW_HEIGHT)
    color = vec3(clamp(height, 0.0, 1.0));
#elif defined(VIEW_NORMAL)
    color = 0.5 + 0.5 * surface.geometric;
#elif defined(VIEW_DEPTH)
    color = vec3(1.0 - fract(log2(view_depth)));
#elif defined(VIEW_SHADOW)
    color = vec3(light_visible(visibility, 0u));
#endif
    return displayed(color);
}

#endif
#endif
