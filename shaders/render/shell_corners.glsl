// Fetching a prism: what the geometry, mesh and fragment stages share.
#ifndef RENDER_SHELL_CORNERS_GLSL
#define RENDER_SHELL_CORNERS_GLSL

#include "shell/outline.glsl"
#include "shell/prism_bits.glsl"
#include "render/ray_fade.glsl"

#ifdef WALK_BORDERS
#include "render/lid_growth.glsl"

// Prisms that a ray may enter from outside the shell, then all others, which matter where the near plane cuts them.
layout(std430, set = 1, binding = 12) readonly buffer BorderBlock { uint item[]; } borders;
// A walk meets a border up to the lid and down to the base.
const int LEVELS = 2;
#else
const int LEVELS = 0;
#endif

// Clip x, y, w and view depth of the six corners: three at the lowest level, three at the highest.
void prism_corners(Object object, PrismData data, out vec4 corners[6]) {
    vec2 range = fading_range(vec2(data.range[LEVELS], data.range[LEVELS + 1]));
    for (int k = 0; k < 3; ++k) {
        Vertex vertex = vertices.item[data.corners[k]];
        for (int level = 0; level < 2; ++level) {
            vec3 at = vertex.position.xyz + range[level] * vertex.shell.xyz;
            vec3 clip = transform_point(object.clip_x, object.clip_y, object.clip_w, at);
            corners[3 * level + k] = vec4(clip, dot(object.depth.xyz, at) + object.depth.w);
        }
    }
}

// The prism that the draw's item `index` stands for.
uint outlined_prism(uint index) {
#ifdef WALK_BORDERS
    return borders.item[index];
#else
    return index;
#endif
}

// The outline of the draw's item `index`.
Outline outline_of(uint index) {
    vec4 corners[6];
    PrismData data = prisms.item[outlined_prism(index)];
    prism_corners(drawn, data, corners);
#ifdef WALK_BORDERS
    if (!has_flag(data.corners.w, BORDER)) {
        float nearest = corners[0].w;
        for (int i = 1; i < 6; ++i) {
            nearest = min(nearest, corners[i].w);
        }
        if (nearest >= frame.lens.z * NEAR_REACH) {
            Outline nothing;
            nothing.count = 0;
            return nothing;
        }
    }
#endif
    return prism_outline(corners, frame.lens.z, 2.0 * frame.viewport.zw);
}

// Outline vertex `i` at the prism's nearest depth, a little nearer still: the hit may not lie before the raster depth
// where the conservative-depth qualifier promises so.
vec4 outline_position(Outline outline, int i) {
    float depth = max(outline.nearest * (1.0 - 1e-5), frame.lens.z);
    return vec4(outline.ndc[i], min(buffer_depth(depth), 1.0), 1.0);
}

#endif
