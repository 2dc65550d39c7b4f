// A height map under any wrap modes (0 repeat, 1 mirror, 2 clamp): bilinear in f32, with the texels chosen by the
// shader, as the sampler's own filter works in 8-bit fractions. No bindings.
#ifndef SHELL_HEIGHT_MAP_GLSL
#define SHELL_HEIGHT_MAP_GLSL

int wrap_texel(int i, int n, const int mode) {
    if (mode == 2) {
        return clamp(i, 0, n - 1);
    }
    const int period = mode == 1 ? 2 * n : n;
    int at = i - period * int(floor(float(i) / float(period)));
    // float division may be one off for large i; one correction is enough
    at = at < 0 ? at + period : at >= period ? at - period : at;
    return mode == 1 && at >= n ? period - 1 - at : at;
}

// The texels of cell `cell`, which spans texel centres `cell` and `cell` + 1: row by row, wrapped one by one.
vec4 map_cell(sampler2D map, const ivec2 mode, ivec2 cell, int lod) {
    ivec2 n = textureSize(map, lod);
    int x0 = wrap_texel(cell.x, n.x, mode.x), x1 = wrap_texel(cell.x + 1, n.x, mode.x);
    int y0 = wrap_texel(cell.y, n.y, mode.y), y1 = wrap_texel(cell.y + 1, n.y, mode.y);
    return vec4(texelFetch(map, ivec2(x0, y0), lod).r, texelFetch(map, ivec2(x1, y0), lod).r,
                texelFetch(map, ivec2(x0, y1), lod).r, texelFetch(map, ivec2(x1, y1), lod).r);
}

// The four texels around `uv`, the position between them and the size of the map.
vec4 map_texels(sampler2D map, const ivec2 mode, vec2 uv, int lod, out vec2 between, out vec2 size) {
    size = vec2(textureSize(map, lod));
    vec2 at = uv * size - 0.5;
    vec2 low = floor(at);
    between = at - low;
    return map_cell(map, mode, ivec2(low), lod);
}

// The height in [0, 1] at `uv`. Four texel fetches.
float map_height(sampler2D map, const ivec2 mode, vec2 uv, int lod) {
    vec2 f, size;
    vec4 h = map_texels(map, mode, uv, lod, f, size);
    return mix(mix(h.x, h.y, f.x), mix(h.z, h.w, f.x), f.y);
}

#endif
