// Shading a shell's hit: the surface's frame, the textures' footprints, shadows, all outputs.
#ifndef RENDER_SHELL_SHADE_GLSL
#define RENDER_SHELL_SHADE_GLSL

#include "render/interface.glsl"
#include "render/material.glsl"
#include "render/ray_fade.glsl"
#include "render/vertex_streams.glsl"
#ifndef DEPTH_ONLY
#include "render/brdf.glsl"
#include "render/output.glsl"
#include "render/ambient_occlusion.glsl"
#ifdef SHADOW_MAPS
#include "render/shadow_map.glsl"
#endif
#endif
#ifdef HAS_HEIGHT
#include "shell/march.glsl"
#else
#include "shell/plain.glsl"
#endif
#ifndef DEPTH_ONLY
#include "render/shell_shadow.glsl"
#endif

// A depth pre-pass and the shading after it are to agree on it.
#ifdef DEPTH_BEHIND
// The raster depth is nearer than all that the fragment can hit, so in reversed depth the hit's is less.
layout(depth_less) invariant out float gl_FragDepth;
#else
invariant gl_FragDepth;
#endif

// The target's point whose ray the fragment traces: the pixel's centre, or that of the sample which it is alone for.
vec2 ray_point() {
#ifdef SAMPLE_SHADING
    return floor(gl_FragCoord.xy) + gl_SamplePosition;
#else
    return gl_FragCoord.xy;
#endif
}

// Change of the barycentric weights of corners 1 and 2 when a point of the triangle's plane moves by `moved`.
vec2 barycentric_step(vec3 moved, vec3 e1, vec3 e2) {
    float g11 = dot(e1, e1), g12 = dot(e1, e2), g22 = dot(e2, e2);
    float det = g11 * g22 - g12 * g12;
    vec2 d = vec2(dot(moved, e1), dot(moved, e2));
    return det > 0.0 ? vec2(g22 * d.x - g12 * d.y, g11 * d.y - g12 * d.x) / det : vec2(0.0);
}

#if defined(SHADOW_MAPS) && defined(HAS_HEIGHT)
// A hit in prism `id` as a shadow map's receiver; one on a wall in the prism before it, on the side that `facing` points
// to.
Receiver shell_receiver(uint id, Vertex v[3], ShellHit hit, vec3 position, vec3 facing) {
    Receiver receiver = NO_RECEIVER;
    vec3 lambda = hit.lambda;
#ifndef NO_STEPS
    receiver.on_wall = hit.wall >= 0;
    if (receiver.on_wall && dot(facing, v[hit.wall].position.xyz + hit.t * v[hit.wall].shell.xyz - position) < 0.0) {
        uint across = adjacency.item[3u * id + uint(hit.wall)];
        if (across == NO_NEIGHBOUR || wall_field(prisms.item[id].corners.w, hit.wall) != 0u) {
            return NO_RECEIVER;
        }
        lambda = weights_across(lambda, hit.wall, int(across & 3u));
        id = across >> 2u;
    }
#endif
    receiver.followed = receiver_stands(receiver, id, lambda, hit.t, true);
    return receiver;
}
#endif

// What is to be shaded, and where.
struct Shaded {
    vec3 position; // mesh space
#ifndef DEPTH_ONLY
    Surface surface;
    Visibility visibility;
    float side; // +1 where it is seen from above
    vec2 uv;    // that of the AOV
#endif
};

// The surface in the pixel at `ndc`, whose ray hits prism `id` of `object` with corners `v`, vertices `corners`. slope:
// what the level gains from corner 0 to corners 1 and 2 by the height's gradient at the hit. displaced: the hit is on the
// height field, or on a wall. DEPTH_ONLY: nothing but what alphaMode MASK cuts out.
Shaded shaded_at(Object object, uint id, uvec3 corners, Vertex v[3], vec2 ndc, ShellHit hit, vec2 slope, bool displaced) {
    // The level's triangle and the surface's two tangents there (DESIGN section 4).
    vec3 s0 = v[0].position.xyz + hit.t * v[0].shell.xyz;
    vec3 e1 = v[1].position.xyz + hit.t * v[1].shell.xyz - s0;
    vec3 e2 = v[2].position.xyz + hit.t * v[2].shell.xyz - s0;
    vec3 level_normal = cross(e1, e2);
    vec3 along = hit.lambda.x * v[0].shell.xyz + hit.lambda.y * v[1].shell.xyz + hit.lambda.z * v[2].shell.xyz;
    vec3 position = s0 + hit.lambda.y * e1 + hit.lambda.z * e2;
    vec3 eye = object.eye.w != 0.0 ? object.eye.xyz - position : object.eye.xyz;
    vec3 geometric = level_normal + slope.x * cross(along, e2) + slope.y * cross(e1, along);
#ifdef NORMALS_ALONG_SHELL
    vec3 authored = normalize(along);
#else
    vec3 authored = hit.lambda.x * v[0].normal.xyz + hit.lambda.y * v[1].normal.xyz + hit.lambda.z * v[2].normal.xyz;
    authored = normalize(authored);
#endif
    vec3 normal = length(level_normal) * authored + slope.x * cross(authored, e2) + slope.y * cross(e1, authored);
    if (hit.wall >= 0) {
        // A wall stands on its edge along the shell normals.
        vec3 edge = hit.wall == 0 ? e2 - e1 : hit.wall == 1 ? e2 : e1;
        geometric = cross(edge, along);
        normal = geometric;
    }
    float side = dot(geometric, eye) < 0.0 ? -1.0 : 1.0;
    geometric *= side;
    normal *= dot(normal, hit.wall >= 0 ? eye : geometric) < 0.0 ? -1.0 : 1.0;
    normal = normalize(normal);

    // One pixel right and one down on the level's plane: the textures take the gradients of the un-displaced surface.
    // row . moved = w * (change of ndc) within the plane and with the other row's product zero.
    float w = dot(object.clip_w.xyz, position) + object.clip_w.w;
    vec3 row_x = object.clip_x.xyz - ndc.x * object.clip_w.xyz, row_y = object.clip_y.xyz - ndc.y * object.clip_w.xyz;
    vec3 across = cross(row_y, level_normal), down = cross(level_normal, row_x);
    // A plane seen edge-on has no footprint: foreshortening is cut at about 1:20.
    float least = 0.05 * length(row_x) * length(row_y) * length(level_normal);
    float volume = dot(row_x, across);
    volume = volume < 0.0 ? min(volume, -least) : max(volume, least);
    across *= 2.0 * frame.viewport.z * w / volume;
    down *= 2.0 * frame.viewport.w * w / volume;
    vec2 step_x = barycentric_step(across, e1, e2);
    vec2 step_y = barycentric_step(down, e1, e2);
    TexturePoint at[2];
    vec4 uvs[3];
    for (int k = 0; k < 3; ++k) {
        uvs[k] = vertex_uvs(corners[k], height_uv_of(v[k]));
    }
    for (int i = 0; i < 2; ++i) {
        vec2 a = i == 0 ? uvs[0].xy : uvs[0].zw;
        vec2 b = (i == 0 ? uvs[1].xy : uvs[1].zw) - a;
        vec2 c = (i == 0 ? uvs[2].xy : uvs[2].zw) - a;
        at[i] = TexturePoint(a + hit.lambda.y * b + hit.lambda.z * c, step_x.x * b + step_x.y * c,
                             step_y.x * b + step_y.y * c);
    }
    MaterialPoint m = material_at(at);
#ifdef ALPHA_MASK
    if (m.base_color.a < material.emissive.w) {
        discard;
    }
#endif
    Shaded shaded;
    shaded.position = position;
#ifndef DEPTH_ONLY
#ifdef NORMAL_UV
    vec4 tangent = hit.lambda.x * tangents.item[corners[0]] + hit.lambda.y * tangents.item[corners[1]] +
                   hit.lambda.z * tangents.item[corners[2]];
    normal = mapped_normal(m.normal, normal, tangent);
#endif

    Surface surface;
    surface.position = transform_point(object.world_x, object.world_y, object.world_z, position);
    surface.view = normalize(object.eye.w != 0.0 ? -surface.position : -frame.forward.xyz);
    surface.normal = normalize(transform_direction(object.normal_x, object.normal_y, object.normal_z, normal));
    surface.geometric = normalize(transform_direction(object.normal_x, object.normal_y, object.normal_z, geometric));
    surface.base_color = m.base_color.rgb;
    surface.reflectance = m.reflectance;
    surface.metallic = m.metallic;
    surface.roughness = m.roughness;
    surface.occlusion = m.occlusion;
    surface.emissive = m.emissive;
#ifdef AMBIENT_OCCLUSION
    vec2 corner = height_uv_of(v[0]), b = height_uv_of(v[1]) - corner, c = height_uv_of(v[2]) - corner;
    float open = ambient_occlusion(TexturePoint(corner + hit.lambda.y * b + hit.lambda.z * c,
                                                step_x.x * b + step_x.y * c, step_y.x * b + step_y.y * c));
    surface.occlusion *= mix(1.0, open, height_share);
#endif
    shaded.surface = surface;
    shaded.visibility = facing_lights(surface);
#ifdef SHADOW_MAPS
#ifdef HAS_HEIGHT
    Receiver receiver = shell_receiver(id, v, hit, position, geometric);
#else
    Receiver receiver = NO_RECEIVER;
#endif
    shaded.visibility = mapped_visibility(shaded.visibility, surface, receiver);
#endif
    shaded.side = side;
    shaded.uv = at[AOV_UV].uv;
#endif
    return shaded;
}

// Whether a ray without a hit is shown all the same: where a view tells the loops that gave up, what it may have missed
// lies over all.
bool write_missed() {
#if defined(VIEW_LIMITS) && !defined(AOV)
    if (limits_reached > 0u) {
        out_color = vec4(1.0, 0.0, 0.0, 1.0);
        gl_FragDepth = gl_FragCoord.z;
        return true;
    }
#endif
    return false;
}

void write_shaded(Shaded shaded, ShellHit hit, float height) {
    gl_FragDepth = buffer_depth(hit.depth);
#ifndef DEPTH_ONLY
    write_outputs(shaded.surface, shaded.visibility, shaded.uv, hit.depth, height);
#endif
}

#ifdef HAS_HEIGHT
// Shades a hit in prism `id`, whose vertices are `corners`.
void shade_hit(Object object, uint id, uvec3 corners, Vertex v[3], vec2 ndc, Prism prism, MarchSettings settings,
               ShellHit hit) {
    vec2 uv1 = prism.uv[1] - prism.uv[0], uv2 = prism.uv[2] - prism.uv[0];
    vec2 height_uv = prism.uv[0] + hit.lambda.y * uv1 + hit.lambda.z * uv2;
#ifdef MARCH_NONE
    bool displaced = false;
#else
    bool displaced = !prism.plain;
#endif
    vec2 gradient = displaced ? settings.scale * height_gradient(height_uv, 0.0) : vec2(0.0);
    vec2 slope = vec2(dot(gradient, uv1), dot(gradient, uv2));
    Shaded shaded = shaded_at(object, id, corners, v, ndc, hit, slope, displaced);
#ifdef SELF_SHADOW
    // A wall is seen from where its lower surface begins: from above that.
    float side = hit.wall < 0 ? shaded.side : 1.0;
    ShadowStart start = ShadowStart(shaded.position, id, hit.lambda, hit.t, hit.wall, side);
    int limit = 64 + 2 * int(draw.prism_count), limits = 0;
#ifdef SHADOW_STEPS
    settings.max_steps = int(material.shadow.z);
    settings.min_steps = min(settings.min_steps, settings.max_steps);
#endif
#ifdef SOFT_SHADOW
    mat3 to_mesh = mat3(object.world_x.xyz, object.world_y.xyz, object.world_z.xyz);
    vec3 field_normal = hit.wall < 0 && displaced ? to_mesh * shaded.surface.geometric : vec3(0.0);
#endif
    for (int i = 0; i < SHADOWED_LIGHTS; ++i) {
        if (shaded.visibility.light[i] > 0.0) {
            ShadowWay way = way_to_light(object, shaded.surface, i);
#ifdef SOFT_SHADOW
            way = toward_limb(way, v, hit.lambda, field_normal, side);
#endif
            float seen = shadow_blocked(start, way, settings, limit, limits) ? 0.0 : 1.0;
#ifdef SOFT_SHADOW
            seen *= penumbra_seen();
            penumbra.open = false;
#endif
            shaded.visibility.light[i] *= seen;
        }
    }
    count_limits(limits);
#endif
#if defined(LOD_FADE) && defined(SHADOWED_LIGHTS) && !defined(DEPTH_ONLY)
    // What stands in its place at last has no shadows of its own.
    for (int i = 0; i < SHADOWED_LIGHTS; ++i) {
        shaded.visibility.light[i] = mix(1.0, shaded.visibility.light[i], height_share);
    }
#endif
    write_shaded(shaded, hit, hit.t / settings.scale + settings.midlevel);
}
#endif

#endif
