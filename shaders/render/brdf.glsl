// glTF's metallic-roughness model: GGX distribution, height-correlated Smith visibility, Schlick Fresnel
// (glTF 2.0 specification, appendix B; Heitz 2014; Walter et al. 2007), its reflection as KHR_materials_specular has it,
// and the lights.
#ifndef RENDER_BRDF_GLSL
#define RENDER_BRDF_GLSL

const float PI = 3.14159265358979;

struct Surface {
    vec3 position;  // camera-relative world
    vec3 normal;    // shading normal, unit
    vec3 geometric; // normal of the surface itself, unit, toward the viewer
    vec3 view;      // unit, toward the viewer
    vec3 base_color;
    vec4 reflectance; // at normal incidence, by colour; w: at grazing
    float metallic;
    float roughness;
    float occlusion;
    vec3 emissive;
};

// What a surface point sees of each light that casts shadows, 0 to 1: of the first SHADOWED_LIGHTS of them.
struct Visibility {
#ifdef SHADOWED_LIGHTS
    float light[SHADOWED_LIGHTS];
#else
    float all;
#endif
};

Visibility all_lights_visible() {
    Visibility visibility;
#ifdef SHADOWED_LIGHTS
    for (int i = 0; i < SHADOWED_LIGHTS; ++i) {
        visibility.light[i] = 1.0;
    }
#else
    visibility.all = 1.0;
#endif
    return visibility;
}

float light_visible(Visibility visibility, uint light) {
#ifdef SHADOWED_LIGHTS
    return light < SHADOWED_LIGHTS ? visibility.light[light] : 1.0;
#else
    return visibility.all;
#endif
}

vec3 reflected(Surface surface, vec3 light) {
    float alpha = max(surface.roughness * surface.roughness, 1e-3);
    float a2 = alpha * alpha;
    vec3 middle = normalize(light + surface.view);
    float nl = dot(surface.normal, light);
    if (nl <= 0.0) {
        return vec3(0.0);
    }
    float nv = max(dot(surface.normal, surface.view), 1e-4);
    float nh = clamp(dot(surface.normal, middle), 0.0, 1.0), vh = clamp(dot(surface.view, middle), 0.0, 1.0);
    float d = nh * nh * (a2 - 1.0) + 1.0;
    float distribution = a2 / (PI * d * d);
    float visibility = 0.5 / (nl * sqrt(nv * nv * (1.0 - a2) + a2) + nv * sqrt(nl * nl * (1.0 - a2) + a2));
    vec3 f0 = surface.reflectance.rgb;
    float grazing = 1.0 - vh, squared = grazing * grazing;
    vec3 fresnel = f0 + (surface.reflectance.w - f0) * (squared * squared * grazing);
#ifdef SPECULAR
    // Of a coloured reflection the complement is not to show.
    vec3 passed = vec3(1.0 - max(fresnel.r, max(fresnel.g, fresnel.b)));
#else
    vec3 passed = 1.0 - fresnel;
#endif
    vec3 diffuse = passed * (1.0 - surface.metallic) * surface.base_color / PI;
    return nl * (diffuse + fresnel * distribution * visibility);
}

// Direction toward light `i` (unit) and its irradiance on a surface facing it.
vec3 light_arriving(Light light, vec3 position, out vec3 toward) {
    toward = -light.direction.xyz;
    vec3 arriving = light.intensity.rgb;
    if (light.intensity.w > 0.0) {
        // Point or spot: inverse square, windowed to its range (KHR_lights_punctual).
        vec3 offset = light.position.xyz - position;
        float squared = max(dot(offset, offset), 1e-12);
        toward = offset * inversesqrt(squared);
        float window = clamp(1.0 - squared * squared * light.position.w, 0.0, 1.0);
        float cone = clamp(dot(-toward, light.direction.xyz) * light.spot.x + light.spot.y, 0.0, 1.0);
        arriving *= window * cone * cone / squared;
    }
    return arriving;
}

// Irradiance / pi from everywhere on what faces `normal`: a quadratic form a colour (scene/ambient.rs).
vec3 ambient_irradiance(vec3 normal) {
    vec4 v = vec4(normal, 1.0);
    vec3 irradiance;
    for (int c = 0; c < 3; ++c) {
        mat4 form = mat4(frame.ambient[4 * c], frame.ambient[4 * c + 1], frame.ambient[4 * c + 2],
                         frame.ambient[4 * c + 3]);
        irradiance[c] = max(dot(v, form * v), 0.0);
    }
    return irradiance;
}

// What is not lit directly still has form.
vec3 ambient(Surface surface) {
    vec3 irradiance = ambient_irradiance(surface.normal);
    vec3 albedo = surface.base_color * (1.0 - surface.metallic) + surface.reflectance.rgb;
    return surface.occlusion * irradiance * albedo;
}

// Scene-linear radiance toward the viewer.
vec3 shade(Surface surface, Visibility visibility) {
    vec3 sum = ambient(surface) + surface.emissive;
#ifdef LIGHTS
#ifdef OCCLUSION_LIGHT
    float direct = mix(1.0, surface.occlusion, frame.origin.z);
#else
    const float direct = 1.0;
#endif
    for (uint i = 0u; i < LIGHTS; ++i) {
        vec3 toward;
        vec3 arriving = light_arriving(lights[i], surface.position, toward);
        sum += direct * light_visible(visibility, i) * arriving * reflected(surface, toward);
    }
#endif
    return sum;
}

// Khronos PBR Neutral tone mapper: base colours below the shoulder come out as authored.
vec3 tone_map(vec3 color) {
    const float start = 0.8 - 0.04, desaturation = 0.15;
    float low = min(color.r, min(color.g, color.b));
    color -= low < 0.08 ? low - 6.25 * low * low : 0.04;
    float peak = max(color.r, max(color.g, color.b));
    if (peak < start) {
        return color;
    }
    float room = 1.0 - start;
    float compressed = 1.0 - room * room / (peak + room - start);
    float gray = 1.0 - 1.0 / (desaturation * (peak - compressed) + 1.0);
    return mix(color * compressed / peak, vec3(compressed), gray);
}

#endif
