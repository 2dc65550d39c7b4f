// The march's settings out of the material's block.
#ifndef RENDER_MARCH_SETTINGS_GLSL
#define RENDER_MARCH_SETTINGS_GLSL

#include "render/interface.glsl"
#include "render/ray_fade.glsl"
#include "shell/march.glsl"

MarchSettings march_settings() {
    MarchSettings settings;
    settings.scale = height_share * material.displacement.x;
    settings.midlevel = material.displacement.y;
    settings.min_steps = int(material.march.x);
    settings.max_steps = int(material.march.y);
    settings.refine_steps = int(material.march.z);
    settings.tolerance = material.classic.x;
    settings.map_size = height_size();
    settings.two_sided = hits_from_behind();
    settings.step_limit = int(material.march.w >> 1);
    return settings;
}

#endif
