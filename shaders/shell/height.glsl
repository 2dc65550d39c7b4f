// Bilinear heights in f32, with the texels chosen by the shader: the sampler's own filter works in 8-bit fractions.
//
// The including shader defines HEIGHT_MAP (a sampler2D) and HEIGHT_WRAP_U, HEIGHT_WRAP_V (0 repeat, 1 mirror, 2 clamp),
// may define HEIGHT_SIZE (vec2, texels) where it has the size at hand, or gives its own `height_at` and `height_gradient`, e.g. of a procedure, and does not include this file.
#ifndef SHELL_HEIGHT_GLSL
#define SHELL_HEIGHT_GLSL

#ifndef HEIGHT_SIZE
#define HEIGHT_SIZE vec2(textureSize(HEIGHT_MAP, 0))
#endif

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

// The texels of cell `cell`, which spans texel centres `cell` and `cell` + 1: row by row, wrapped one by one by the
// sampler. In the middle of the four, rounding cannot choose others.
vec4 height_cell(ivec2 cell) {
    return textureGather(HEIGHT_MAP, (vec2(cell) + 1.0) / HEIGHT_SIZE).wzxy;
}

// The four texels around `uv`, the position between them and the size of the map.
vec4 height_texels(vec2 uv, out vec2 between, out vec2 size) {
    size = HEIGHT_SIZE;
    vec2 at = uv * size - 0.5;
    vec2 low = floor(at);
    between = at - low;
    return height_cell(ivec2(low));
}

// The height in [0, 1] at `uv`. One gather.
float height_at(vec2 uv, float lod) {
    vec2 f, size;
    vec4 h = height_texels(uv, f, size);
    return mix(mix(h.x, h.y, f.x), mix(h.z, h.w, f.x), f.y);
}

// dh/du and dh/dv of the bilinear patch at `uv`: the true slope of what `height_at` gives. One gather.
vec2 height_gradient(vec2 uv, float lod) {
    vec2 f, size;
    vec4 h = height_texels(uv, f, size);
    return size * vec2(mix(h.y - h.x, h.w - h.z, f.y), mix(h.z - h.x, h.w - h.y, f.x));
}

#endif
