// The height hook over a height map.
//
// The including shader defines HEIGHT_MAP (a sampler2D) and HEIGHT_WRAP_U, HEIGHT_WRAP_V (see height_map.glsl), or
// gives its own `height_at` and `height_gradient`, e.g. of a procedure, and does not include this file.
#ifndef SHELL_HEIGHT_GLSL
#define SHELL_HEIGHT_GLSL

#include "shell/height_map.glsl"

// The texels of cell `cell`: see map_cell.
vec4 height_cell(ivec2 cell, int lod) {
    return map_cell(HEIGHT_MAP, ivec2(HEIGHT_WRAP_U, HEIGHT_WRAP_V), cell, lod);
}

// The height in [0, 1] at `uv`. Four texel fetches.
float height_at(vec2 uv, float lod) {
    return map_height(HEIGHT_MAP, ivec2(HEIGHT_WRAP_U, HEIGHT_WRAP_V), uv, int(lod));
}

// dh/du and dh/dv of the bilinear patch at `uv`: the true slope of what `height_at` gives. Four texel fetches.
vec2 height_gradient(vec2 uv, float lod) {
    vec2 f, size;
    vec4 h = map_texels(HEIGHT_MAP, ivec2(HEIGHT_WRAP_U, HEIGHT_WRAP_V), uv, int(lod), f, size);
    return size * vec2(mix(h.y - h.x, h.w - h.z, f.y), mix(h.z - h.x, h.w - h.y, f.x));
}

#endif
