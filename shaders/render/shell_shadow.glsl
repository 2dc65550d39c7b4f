// Self-shadow of a shell's hit: what it sees of each light.
#ifndef RENDER_SHELL_SHADOW_GLSL
#define RENDER_SHELL_SHADOW_GLSL

#include "render/brdf.glsl"
#ifdef SELF_SHADOW
#include "render/walk_access.glsl"
#ifdef SHADOW_REENTRY
layout(std430, set = 1, binding = 16) readonly buffer ShadowBoxBlock { BoxNode item[]; } shadow_hierarchy;
#endif
#include "shell/walk.glsl"
#include "shell/shadow.glsl"

#ifdef SHADOW_REENTRY
ShadowBox shadow_box(uint index) {
    BoxNode node = shadow_hierarchy.item[index];
    return ShadowBox(uintBitsToFloat(node.low.xyz), uintBitsToFloat(node.high.xyz), node.low.w, node.high.w);
}

// Of n prisms and what divides them.
uint shadow_boxes() {
    return 2u * draw.prism_count - 1u;
}
#endif
#endif

// What looks away from a light does not see it.
Visibility facing_lights(Surface surface) {
    Visibility visibility = all_lights_visible();
#ifdef SHADOWED_LIGHTS
    for (int i = 0; i < SHADOWED_LIGHTS; ++i) {
        vec3 toward;
        light_arriving(lights[i], surface.position, toward);
        visibility.light[i] = dot(surface.geometric, toward) > 0.0 ? 1.0 : 0.0;
    }
#endif
    return visibility;
}

#ifdef SELF_SHADOW
// The way from a point of the surface to light `i`.
ShadowWay way_to_light(Object object, Surface surface, int i) {
    Light light = lights[i];
    bool finite = light.intensity.w > 0.0;
    vec3 way = finite ? light.position.xyz - surface.position : -light.direction.xyz;
    // The rows of the inverse transpose are the columns of world to mesh.
    way = mat3(object.normal_x.xyz, object.normal_y.xyz, object.normal_z.xyz) * way;
    float size = length(way);
    return ShadowWay(way / size, finite ? size : 1e30);
}

#ifdef SOFT_SHADOW
// Of a clearance near the start, relative to positions and to the height's scale.
const float PENUMBRA_ROUNDING = 1e-6;

// The way to the upper limb of a round light, whose penumbra is open from then on. A surface seen from below has none:
// prisms are followed above it alone. normal: mesh space, of the field where the way begins; zero on a wall. Its plane
// hides what of the disc is below it, whatever comes after: next to the start clearances are rounding.
ShadowWay toward_limb(ShadowWay way, Vertex v[3], vec3 lambda, vec3 normal, float side) {
    if (side < 0.0) {
        return way;
    }
    vec3 along = lambda.x * v[0].shell.xyz + lambda.y * v[1].shell.xyz + lambda.z * v[2].shell.xyz;
    vec3 flat_normal = cross(v[1].position.xyz - v[0].position.xyz, v[2].position.xyz - v[0].position.xyz);
    vec3 lift = normalize(dot(along, along) > 1e-12 ? along : flat_normal);
    float tilt = penumbra_tilt(material.shadow.x, dot(way.toward, lift));
    vec3 limb = way.toward + tilt * lift;
    float size = length(limb);
    way = ShadowWay(limb / size, way.reach * size);
    float rounding = PENUMBRA_ROUNDING * (length(v[0].position.xyz) + material.displacement.x);
    float spread = 2.0 * tilt / size, rise = dot(normal, lift);
    float least = rise > 0.0 ? clamp(dot(normal, way.toward) / (rise * max(spread, 1e-30)), 0.0, 1.0) : 1.0;
    penumbra = Penumbra(true, spread, material.shadow.y, material.shadow.w, way.reach, rounding, least, vec3(0.0));
    return way;
}
#endif
#endif

#endif
