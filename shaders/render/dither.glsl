// Blue noise by pixel (render/blue_noise.rs). Where a linear search begins with it, what the steps cannot resolve becomes
// fine grain in place of layers; where depth moves by it, surfaces blend.
#ifndef RENDER_DITHER_GLSL
#define RENDER_DITHER_GLSL

#ifdef DITHER
layout(set = 1, binding = 23) uniform sampler2D blue_noise;

// Between 0 and 1, by pixel.
float pixel_noise() {
    ivec2 at = ivec2(gl_FragCoord.xy) % textureSize(blue_noise, 0);
    return (255.0 * texelFetch(blue_noise, at, 0).r + 0.5) / 256.0;
}
#endif

#ifdef DITHERED_START
float search_start() {
    return pixel_noise();
}
#endif

#endif
