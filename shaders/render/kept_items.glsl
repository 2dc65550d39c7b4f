// The items of a draw that its culling pass has kept.
#ifndef RENDER_KEPT_ITEMS_GLSL
#define RENDER_KEPT_ITEMS_GLSL

layout(std430, set = 1, binding = 18) readonly buffer KeptBlock { uint item[]; } kept;

#endif
