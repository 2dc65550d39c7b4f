// The visibility buffer: the lid that each pixel's ray meets first. x: one more than the lid's number, 0 where there is
// none; y: the bits of the level at which it is met.
#ifndef RENDER_NEAREST_LID_GLSL
#define RENDER_NEAREST_LID_GLSL

#include "render/interface.glsl"

const uint LID_PRISM_BITS = 24u;

uvec2 lid_name(uint prism, float level) {
    return uvec2((draw.object << LID_PRISM_BITS | prism) + 1u, floatBitsToUint(level));
}

#ifdef VISIBILITY
layout(set = 0, binding = 8) uniform usampler2D nearest_lids;
// Of the passes before the one that draws the rest.
layout(set = 0, binding = 9) uniform sampler2D depth_so_far;

// Whether a walk begins in this fragment, and from which lid: in the pass over the picture from the one named, if it is
// of this draw; then from the rasterised one where it is another, and may be seen in front of what is drawn so far.
bool begins_walk(inout uint prism, inout float level) {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    uvec2 nearest = texelFetch(nearest_lids, pixel, 0).xy;
    if (draw.resolves == 0u) {
        return nearest != lid_name(prism, level) && gl_FragCoord.z > texelFetch(depth_so_far, pixel, 0).x;
    }
    uint number = nearest.x - 1u;
    prism = bitfieldExtract(number, 0, int(LID_PRISM_BITS));
    level = uintBitsToFloat(nearest.y);
    return nearest.x != 0u && number >> LID_PRISM_BITS == draw.object;
}
#endif

#endif
