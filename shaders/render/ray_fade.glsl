// How much of their heights the shells along a pixel's ray show: LOD_FADE, else all.
//
// It is one number for the whole ray and for all prisms of a mesh, so that they meet as ever: no crack, no double. It
// follows the depth at which the ray enters the mesh's box, no farther than what it hits.
#ifndef RENDER_RAY_FADE_GLSL
#define RENDER_RAY_FADE_GLSL

#include "render/interface.glsl"

#ifdef LOD_FADE
// A field of no height at all has no inside for a ray to come in by; so little of it is none on a screen.
const float LEAST_SHARE = 1.0 / 1024.0;

float height_share = 1.0;

// 1 up to the LOD that --lod-fade names, next to nothing from one above it on: a mesh that far is drawn plain.
void fade_heights(Object object, vec2 ndc) {
    precise float depth = 1.0;
    if (object.eye.w != 0.0) {
        precise vec3 way = cross(object.clip_x.xyz - ndc.x * object.clip_w.xyz, object.clip_y.xyz - ndc.y * object.clip_w.xyz);
        precise float deepening = dot(object.depth.xyz, way);
        way = mix(vec3(1e-30), way, greaterThan(abs(way), vec3(1e-30)));
        way /= deepening;
        precise vec3 a = (-object.fade.xyz - object.eye.xyz) / way, b = (object.fade.xyz - object.eye.xyz) / way;
        vec3 entry = min(a, b);
        depth = max(max(entry.x, entry.y), max(entry.z, frame.lens.z));
    }
    height_share = clamp(1.0 - log2(depth * object.fade.w), LEAST_SHARE, 1.0);
}

// Levels that hold a field whatever part of it is shown.
vec2 fading_range(vec2 range) {
    return vec2(min(range.x, 0.0), max(range.y, 0.0));
}
#else
const float height_share = 1.0;

vec2 fading_range(vec2 range) {
    return range;
}
#endif

#endif
