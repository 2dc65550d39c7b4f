// The height hook over a height map.
//
// The including shader defines HEIGHT_MAP (a sampler2D with the map's wrap modes) and `height_size`; or it gives its own
// `height_at`, `height_gradient` and `height_size`, as shell/procedures.glsl does, and does not include this file.
#ifndef SHELL_HEIGHT_GLSL
#define SHELL_HEIGHT_GLSL

#include "shell/height_map.glsl"

// The includer's: texels of the map. What is smaller than one is of no account to a march with steps.
vec2 height_size();

// The texels of cell `cell`: see map_cell.
vec4 height_cell(ivec2 cell) {
    return map_cell(HEIGHT_MAP, height_size(), cell);
}

// The height in [0, 1] at `uv`. One gather.
float height_at(vec2 uv, float lod) {
    return map_height(HEIGHT_MAP, height_size(), uv);
}

// dh/du and dh/dv of the bilinear patch at `uv`: the true slope of what `height_at` gives. One gather.
vec2 height_gradient(vec2 uv, float lod) {
    vec2 f, size = height_size();
    vec4 h = map_texels(HEIGHT_MAP, size, uv, f);
    return size * vec2(mix(h.y - h.x, h.w - h.z, f.y), mix(h.z - h.x, h.w - h.y, f.x));
}

#endif
