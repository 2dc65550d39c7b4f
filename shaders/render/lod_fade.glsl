// How much of its height field a base surface shows: all where a pixel spans few texels, nothing where it spans many.
#ifndef RENDER_LOD_FADE_GLSL
#define RENDER_LOD_FADE_GLSL
#ifdef LOD_FADE

// 1 up to the LOD that --lod-fade names, 0 from one above it on, so that nothing pops. x, y: what the height field's
// coordinates gain by a pixel right and down. The LOD is Vulkan's, of the larger of both (section "Scale Factor
// Operation, Level-of-Detail Operation and Image Level(s) Selection").
float lod_fade(vec2 x, vec2 y) {
    x *= height_size();
    y *= height_size();
    float lod = 0.5 * log2(max(max(dot(x, x), dot(y, y)), 1e-30));
    return clamp(1.0 - (lod - material.classic.w), 0.0, 1.0);
}

#endif
#endif
