// Bilinear heights in f32, with the texels chosen by the shader: the sampler's own filter works in 8-bit fractions.
//
// The including shader defines HEIGHT_MAP (a sampler2D) and HEIGHT_WRAP_U, HEIGHT_WRAP_V (0 repeat, 1 mirror, 2 clamp),
// or gives its own `height_at`, `height_gradient` and `height_size`, as shell/procedures.glsl does, and does not
// include this file.
#ifndef SHELL_HEIGHT_GLSL
#define SHELL_HEIGHT_GLSL

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
vec4 height_cell(ivec2 cell, int lod) {
    ivec2 n = textureSize(HEIGHT_MAP, lod);
    int x0 = wrap_texel(cell.x, n.x, HEIGHT_WRAP_U), x1 = wrap_texel(cell.x + 1, n.x, HEIGHT_WRAP_U);
    int y0 = wrap_texel(cell.y, n.y, HEIGHT_WRAP_V), y1 = wrap_texel(cell.y + 1, n.y, HEIGHT_WRAP_V);
    return vec4(texelFetch(HEIGHT_MAP, ivec2(x0, y0), lod).r, texelFetch(HEIGHT_MAP, ivec2(x1, y0), lod).r,
                texelFetch(HEIGHT_MAP, ivec2(x0, y1), lod).r, texelFetch(HEIGHT_MAP, ivec2(x1, y1), lod).r);
}

// The four texels around `uv`, the position between them and the size of the map.
vec4 height_texels(vec2 uv, int lod, out vec2 between, out vec2 size) {
    size = vec2(textureSize(HEIGHT_MAP, lod));
    vec2 at = uv * size - 0.5;
    vec2 low = floor(at);
    between = at - low;
    return height_cell(ivec2(low), lod);
}

// Texels of the map: what is smaller than one is of no account to a march with steps.
vec2 height_size() {
    return vec2(textureSize(HEIGHT_MAP, 0));
}

// The height in [0, 1] at `uv`. Four texel fetches.
float height_at(vec2 uv, float lod) {
    vec2 f, size;
    vec4 h = height_texels(uv, int(lod), f, size);
    return mix(mix(h.x, h.y, f.x), mix(h.z, h.w, f.x), f.y);
}

// dh/du and dh/dv of the bilinear patch at `uv`: the true slope of what `height_at` gives. Four texel fetches.
vec2 height_gradient(vec2 uv, float lod) {
    vec2 f, size;
    vec4 h = height_texels(uv, int(lod), f, size);
    return size * vec2(mix(h.y - h.x, h.w - h.z, f.y), mix(h.z - h.x, h.w - h.y, f.x));
}

#endif
