// The height fields of a primitive's neighbours that are not its own: OTHER_FIELDS of them, 7 at most (MAX_OTHERS of
// shell/prisms.rs). OTHER_0_PROCEDURE and so on name those that are functions. A binding for each map, not an array, so
// that no device feature for indexing one is needed.
#ifndef RENDER_OTHER_FIELDS_GLSL
#define RENDER_OTHER_FIELDS_GLSL
#ifdef OTHER_FIELDS

#include "render/ray_fade.glsl"
#include "shell/height_map.glsl"
#include "shell/procedures.glsl"

#if OTHER_FIELDS > 0 && !OTHER_0_PROCEDURE
layout(set = 1, binding = 24) uniform sampler2D other_map_0;
#endif
#if OTHER_FIELDS > 1 && !OTHER_1_PROCEDURE
layout(set = 1, binding = 25) uniform sampler2D other_map_1;
#endif
#if OTHER_FIELDS > 2 && !OTHER_2_PROCEDURE
layout(set = 1, binding = 26) uniform sampler2D other_map_2;
#endif
#if OTHER_FIELDS > 3 && !OTHER_3_PROCEDURE
layout(set = 1, binding = 27) uniform sampler2D other_map_3;
#endif
#if OTHER_FIELDS > 4 && !OTHER_4_PROCEDURE
layout(set = 1, binding = 28) uniform sampler2D other_map_4;
#endif
#if OTHER_FIELDS > 5 && !OTHER_5_PROCEDURE
layout(set = 1, binding = 29) uniform sampler2D other_map_5;
#endif
#if OTHER_FIELDS > 6 && !OTHER_6_PROCEDURE
layout(set = 1, binding = 30) uniform sampler2D other_map_6;
#endif

float other_height(uint other, vec2 size, vec2 uv) {
    switch (other) {
#if OTHER_0_PROCEDURE
    case 0u:
        return procedure_height(OTHER_0_PROCEDURE, uv);
#elif OTHER_FIELDS > 0
    case 0u:
        return map_height(other_map_0, size, uv);
#endif
#if OTHER_1_PROCEDURE
    case 1u:
        return procedure_height(OTHER_1_PROCEDURE, uv);
#elif OTHER_FIELDS > 1
    case 1u:
        return map_height(other_map_1, size, uv);
#endif
#if OTHER_2_PROCEDURE
    case 2u:
        return procedure_height(OTHER_2_PROCEDURE, uv);
#elif OTHER_FIELDS > 2
    case 2u:
        return map_height(other_map_2, size, uv);
#endif
#if OTHER_3_PROCEDURE
    case 3u:
        return procedure_height(OTHER_3_PROCEDURE, uv);
#elif OTHER_FIELDS > 3
    case 3u:
        return map_height(other_map_3, size, uv);
#endif
#if OTHER_4_PROCEDURE
    case 4u:
        return procedure_height(OTHER_4_PROCEDURE, uv);
#elif OTHER_FIELDS > 4
    case 4u:
        return map_height(other_map_4, size, uv);
#endif
#if OTHER_5_PROCEDURE
    case 5u:
        return procedure_height(OTHER_5_PROCEDURE, uv);
#elif OTHER_FIELDS > 5
    case 5u:
        return map_height(other_map_5, size, uv);
#endif
#if OTHER_6_PROCEDURE
    case 6u:
        return procedure_height(OTHER_6_PROCEDURE, uv);
#elif OTHER_FIELDS > 6
    case 6u:
        return map_height(other_map_6, size, uv);
#endif
    }
    return 0.0;
}

// The level of the surface there. The operations are those of its own primitive's shader, so that both sides of a wall
// agree on it.
float other_level(uint other, vec2 uv) {
    vec4 field = material.others[other];
    return (other_height(other, field.zw, uv) - field.y) * (height_share * field.x);
}

#endif
#endif
