// The draw's height field: a procedure, or our height map with its pyramid or cones.
#ifndef RENDER_HEIGHT_FIELD_GLSL
#define RENDER_HEIGHT_FIELD_GLSL

#ifdef HEIGHT_PROCEDURE
#include "shell/procedures.glsl"
#ifdef MARCH_EXACT
#include "shell/exact_procedural.glsl"
#endif
#else
layout(set = 1, binding = 3) uniform sampler2D height_map;
#define HEIGHT_MAP height_map
#ifdef HEIGHT_MIPS
#undef HEIGHT_MIPS
layout(set = 1, binding = 31) uniform sampler2D height_mips;
#define HEIGHT_MIPS height_mips
#endif
#include "shell/height.glsl"

vec2 height_size() {
    return material.height_size.xy;
}

#include "render/pyramid_access.glsl"
#ifdef MARCH_CONE
layout(set = 1, binding = 22) uniform sampler2D cone_map;
#define CONE_MAP cone_map
#include "shell/cone.glsl"
#endif
#endif

#endif
