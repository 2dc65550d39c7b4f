// The height hook over a height map.
//
// The including shader defines HEIGHT_MAP (a sampler2D with the map's wrap modes) and `height_size`; or it gives its own
// `height_at`, `height_gradient` and `height_size`, as shell/procedures.glsl does, and does not include this file.
//
// LODs are of no account, unless it defines HEIGHT_MIPS too: a sampler2D of the same map that filters, with all mips.
#ifndef SHELL_HEIGHT_GLSL
#define SHELL_HEIGHT_GLSL

#include "shell/height_map.glsl"

// The includer's: texels of the map. What is smaller than one is of no account to a march with steps.
vec2 height_size();

// The texels of cell `cell`: see map_cell.
vec4 height_cell(ivec2 cell) {
    return map_cell(HEIGHT_MAP, height_size(), cell);
}

// The height in [0, 1] at `uv`. One gather; with HEIGHT_MIPS one filtered read above LOD 1, both below.
float height_at(vec2 uv, float lod) {
#ifdef HEIGHT_MIPS
    // The sampler's filter has 8-bit fractions: steps where a texel is larger than a pixel, so not for LOD 0.
    if (lod >= 1.0) {
        count_read();
        return textureLod(HEIGHT_MIPS, uv, lod).r;
    }
    if (lod > 0.0) {
        count_read();
        return mix(map_height(HEIGHT_MAP, height_size(), uv), textureLod(HEIGHT_MIPS, uv, 1.0).r, lod);
    }
#endif
    return map_height(HEIGHT_MAP, height_size(), uv);
}

// dh/du and dh/dv of the bilinear patch at `uv`: the true slope of what `height_at` gives. One gather; with HEIGHT_MIPS
// above LOD 0 central differences over a texel of the LOD, four heights.
vec2 height_gradient(vec2 uv, float lod) {
    vec2 f, size = height_size();
#ifdef HEIGHT_MIPS
    if (lod > 0.0) {
        vec2 texel = exp2(lod) / size, h = 0.5 * texel;
        vec2 across = vec2(height_at(uv + vec2(h.x, 0.0), lod) - height_at(uv - vec2(h.x, 0.0), lod),
                           height_at(uv + vec2(0.0, h.y), lod) - height_at(uv - vec2(0.0, h.y), lod));
        return across / texel;
    }
#endif
    vec4 h = map_texels(HEIGHT_MAP, size, uv, f);
    return size * vec2(mix(h.y - h.x, h.w - h.z, f.y), mix(h.z - h.x, h.w - h.y, f.x));
}

#endif
