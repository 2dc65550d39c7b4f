// A height map, bilinear in f32: the sampler's own filter works in 8-bit fractions, so it only chooses the texels, wrapped
// one by one. No bindings.
#ifndef SHELL_HEIGHT_MAP_GLSL
#define SHELL_HEIGHT_MAP_GLSL

#include "shell/work.glsl"

// The texels of cell `cell`, which spans texel centres `cell` and `cell` + 1, row by row: gathered from the middle of the
// four, where rounding cannot choose others.
vec4 map_cell(sampler2D map, vec2 size, ivec2 cell) {
    count_read();
    return textureGather(map, (vec2(cell) + 1.0) * (1.0 / size)).wzxy;
}

// The four texels around `uv` and the position between them.
vec4 map_texels(sampler2D map, vec2 size, vec2 uv, out vec2 between) {
    vec2 at = uv * size - 0.5;
    vec2 low = floor(at);
    between = at - low;
    return map_cell(map, size, ivec2(low));
}

// The height in [0, 1] at `uv`. One gather.
float map_height(sampler2D map, vec2 size, vec2 uv) {
    vec2 f;
    vec4 h = map_texels(map, size, uv, f);
    return mix(mix(h.x, h.y, f.x), mix(h.z, h.w, f.x), f.y);
}

#endif
