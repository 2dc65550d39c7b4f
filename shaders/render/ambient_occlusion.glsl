// The part of the sky that the height field leaves to its points (shell/occlusion.rs), over the height map's coordinates.
#ifndef RENDER_AMBIENT_OCCLUSION_GLSL
#define RENDER_AMBIENT_OCCLUSION_GLSL
#ifdef AMBIENT_OCCLUSION
#include "render/material.glsl"

layout(set = 1, binding = 20) uniform sampler2D ambient_occlusion_map;

float ambient_occlusion(TexturePoint at) {
    return textureGrad(ambient_occlusion_map, at.uv, at.dx, at.dy).r;
}

#endif
#endif
