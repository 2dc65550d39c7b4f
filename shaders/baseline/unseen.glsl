// Which small triangles cover no pixel centre.
#ifndef BASELINE_UNSEEN_GLSL
#define BASELINE_UNSEEN_GLSL

// Rasterisers snap vertices to a grid, of 1/16 pixel at the coarsest and mostly of 1/256: what is nearer to the limit
// than this, in pixels, is kept.
const float MARGIN = 1.0 / 16.0;

// Whether a triangle is outside the picture, between pixel centres or, by the sign of the area of what faces away, seen
// from behind. Corners: place in the picture, in pixels, and clip w.
bool is_unseen(vec3 corners[3], vec2 viewport, float facing) {
    // What reaches behind the eye has no place in the picture: clipping decides.
    if (min(corners[0].z, min(corners[1].z, corners[2].z)) <= 0.0) {
        return false;
    }
    vec2 a = corners[0].xy, b = corners[1].xy, c = corners[2].xy;
    vec2 low = min(a, min(b, c)) - MARGIN, high = max(a, max(b, c)) + MARGIN;
    vec2 extent = high - low;
    bool outside = any(lessThan(high, vec2(0.0))) || any(greaterThan(low, viewport));
    bool between = any(greaterThan(ceil(low - 0.5), floor(high - 0.5)));
    bool away = facing * determinant(mat2(b - a, c - a)) > MARGIN * (extent.x + extent.y);
    return outside || between || away;
}

#endif
