// The LOD of a base surface's height field in a pixel, and how much of the field shows there.
#ifndef RENDER_HEIGHT_LOD_GLSL
#define RENDER_HEIGHT_LOD_GLSL

// The LOD of the height field in a pixel. x, y: what its coordinates gain by a pixel right and down. It is Vulkan's, of the
// larger of both (section "Scale Factor Operation, Level-of-Detail Operation and Image Level(s) Selection").
float height_lod(vec2 x, vec2 y) {
    x *= height_size();
    y *= height_size();
    return 0.5 * log2(max(max(dot(x, x), dot(y, y)), 1e-30));
}

#ifdef LOD_FADE
// 1 up to the LOD that --lod-fade names, 0 from one above it on, so that nothing pops.
float lod_fade(vec2 x, vec2 y) {
    return clamp(1.0 - (height_lod(x, y) - material.classic.w), 0.0, 1.0);
}
#endif
#endif
