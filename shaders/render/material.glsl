// The material's textures at one surface point. Samplers exist only for textures that the material has.
#ifndef RENDER_MATERIAL_GLSL
#define RENDER_MATERIAL_GLSL

#ifdef BASE_COLOR_UV
layout(set = 1, binding = 4) uniform sampler2D base_color_map;
#endif
#ifdef METALLIC_ROUGHNESS_UV
layout(set = 1, binding = 5) uniform sampler2D metallic_roughness_map;
#endif
#ifdef NORMAL_UV
layout(set = 1, binding = 6) uniform sampler2D normal_map;
#endif
#ifdef OCCLUSION_UV
layout(set = 1, binding = 7) uniform sampler2D occlusion_map;
#endif
#ifdef EMISSIVE_UV
layout(set = 1, binding = 8) uniform sampler2D emissive_map;
#endif
#ifdef SPECULAR_UV
layout(set = 1, binding = 32) uniform sampler2D specular_map;
#endif
#ifdef SPECULAR_COLOR_UV
layout(set = 1, binding = 33) uniform sampler2D specular_color_map;
#endif

// One UV set with its change to the next pixel right and down.
struct TexturePoint {
    vec2 uv, dx, dy;
};

vec4 sample_map(sampler2D map, vec4 transform[2], TexturePoint at) {
    vec2 uv = vec2(dot(transform[0].xy, at.uv) + transform[0].z, dot(transform[1].xy, at.uv) + transform[1].z);
    mat2 linear = mat2(transform[0].x, transform[1].x, transform[0].y, transform[1].y);
    return textureGrad(map, uv, linear * at.dx, linear * at.dy);
}

struct MaterialPoint {
    vec4 base_color;
    float metallic, roughness, occlusion;
    vec4 reflectance; // at normal incidence, by colour; w: at grazing
    vec3 emissive;
    vec3 normal; // tangent space, unit; (0, 0, 1) without a normal map
};

MaterialPoint material_at(TexturePoint at[2]) {
    MaterialPoint m;
    m.base_color = material.base_color;
    m.roughness = material.factors.x;
    m.metallic = material.factors.y;
    m.occlusion = 1.0;
    m.emissive = material.emissive.rgb;
    m.normal = vec3(0.0, 0.0, 1.0);
#ifdef BASE_COLOR_UV
    m.base_color *= sample_map(base_color_map, material.base_color_uv, at[BASE_COLOR_UV]);
#endif
#ifdef METALLIC_ROUGHNESS_UV
    vec4 mr = sample_map(metallic_roughness_map, material.metallic_roughness_uv, at[METALLIC_ROUGHNESS_UV]);
    m.roughness *= mr.ROUGHNESS_CHANNEL;
    m.metallic *= mr.METALLIC_CHANNEL;
#endif
#ifdef NORMAL_UV
    vec3 n = sample_map(normal_map, material.normal_uv, at[NORMAL_UV]).xyz * 2.0 - 1.0;
    m.normal = normalize(n * vec3(material.factors.zz, 1.0));
#endif
    m.reflectance = vec4(vec3(0.04), 1.0);
#ifdef SPECULAR
    // KHR_materials_specular.
    vec4 specular = material.specular;
#ifdef SPECULAR_UV
    vec4 reflects = sample_map(specular_map, material.specular_uv, at[SPECULAR_UV]);
    specular.w *= reflects.a;
#endif
#if defined(SPECULAR_COLOR_WITH_SPECULAR)
    specular.rgb *= reflects.rgb;
#elif defined(SPECULAR_COLOR_UV)
    specular.rgb *= sample_map(specular_color_map, material.specular_color_uv, at[SPECULAR_COLOR_UV]).rgb;
#endif
    m.reflectance = specular.w * vec4(min(0.04 * specular.rgb, 1.0), 1.0);
#endif
    m.reflectance = mix(m.reflectance, vec4(m.base_color.rgb, 1.0), m.metallic);
#if defined(OCCLUSION_WITH_METALLIC_ROUGHNESS)
    m.occlusion = 1.0 + material.factors.w * (mr.r - 1.0);
#elif defined(OCCLUSION_UV)
    m.occlusion = 1.0 + material.factors.w * (sample_map(occlusion_map, material.occlusion_uv, at[OCCLUSION_UV]).r - 1.0);
#endif
#ifdef EMISSIVE_UV
    m.emissive *= sample_map(emissive_map, material.emissive_uv, at[EMISSIVE_UV]).rgb;
#endif
    return m;
}

// The material's normal in the frame of a (perturbed) normal and the mesh's tangent, of any length, all in one space.
vec3 mapped_normal(vec3 tangent_space, vec3 normal, vec4 tangent) {
#ifdef NORMAL_UV
    vec3 t = tangent.xyz - normal * dot(normal, tangent.xyz);
    float squared = dot(t, t);
    if (squared > 1e-12 * dot(tangent.xyz, tangent.xyz)) {
        t *= inversesqrt(squared);
        vec3 b = sign(tangent.w) * cross(normal, t);
        return normalize(tangent_space.x * t + tangent_space.y * b + tangent_space.z * normal);
    }
#endif
    return normal;
}

#endif
