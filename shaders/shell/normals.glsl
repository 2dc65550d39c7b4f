// The height's gradient for shading, of a quality of one's choice. Needs the height hook.
//
// By default it is the hook's own: the true slope of the surface, with a crease at each texel. NORMALS_4_TAP and
// NORMALS_SOBEL smooth over the texels around, at the price of four and eight heights.
#ifndef SHELL_NORMALS_GLSL
#define SHELL_NORMALS_GLSL

vec2 shading_gradient(vec2 uv, float lod) {
#if defined(NORMALS_4_TAP)
    // Central differences.
    vec2 texel = 1.0 / height_size();
    float left = height_at(uv - vec2(texel.x, 0.0), lod), right = height_at(uv + vec2(texel.x, 0.0), lod);
    float above = height_at(uv - vec2(0.0, texel.y), lod), below = height_at(uv + vec2(0.0, texel.y), lod);
    return 0.5 * height_size() * vec2(right - left, below - above);
#elif defined(NORMALS_SOBEL)
    // Sobel and Feldman's 3 x 3 operator: central differences, each the mean of three rows weighted 1, 2, 1.
    vec2 texel = 1.0 / height_size(), sum = vec2(0.0);
    for (int y = -1; y <= 1; ++y) {
        for (int x = -1; x <= 1; ++x) {
            vec2 weight = vec2(x * (2 - abs(y)), y * (2 - abs(x)));
            if (x != 0 || y != 0) {
                sum += weight * height_at(uv + vec2(x, y) * texel, lod);
            }
        }
    }
    return 0.125 * height_size() * sum;
#else
    return height_gradient(uv, lod);
#endif
}

#endif
