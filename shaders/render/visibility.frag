#version 460
#extension GL_GOOGLE_include_directive : require
#ifdef MESH_STAGE
#extension GL_EXT_mesh_shader : require
#endif
// Names the lid; the depth test keeps the nearest.
#include "render/nearest_lid.glsl"

#ifdef MESH_STAGE
layout(location = 0) perprimitiveEXT flat in uint in_prism;
#else
layout(location = 0) flat in uint in_prism;
#endif
layout(location = 1) in float in_level;

layout(location = 0) out uvec2 out_lid;

void main() {
    out_lid = lid_name(in_prism, in_level);
}
