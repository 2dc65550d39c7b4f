#version 460
#extension GL_GOOGLE_include_directive : require
// The base surface: plain, or with a classic parallax technique in its tangent plane (--shell off).
#include "render/interface.glsl"
#include "render/material.glsl"
#ifndef DEPTH_ONLY
#include "render/ambient_occlusion.glsl"
#include "render/brdf.glsl"
#include "render/output.glsl"
#ifdef SHADOW_MAPS
#define RASTERISED
#include "render/shadow_map.glsl"
#endif
#endif

// What the raster tells of a point, in mesh space.
struct SurfacePoint {
    vec3 position;
    vec3 normal;             // authored
    vec3 geometric;          // of the triangle, of any length and either side
    vec4 uvs, uvs_x, uvs_y;  // both UV sets, and their change to the next pixel right and down
    bool front;
};

#ifdef VISIBILITY
#include "baseline/nearest_triangle.glsl"
#else
layout(location = 0) PER_SAMPLE in vec3 in_position;
layout(location = 1) PER_SAMPLE in vec3 in_normal;
#ifdef VERTEX_UVS
layout(location = 2) PER_SAMPLE in vec4 in_uvs;
#else
const vec4 in_uvs = vec4(0.0);
#endif
#ifdef VERTEX_TANGENTS
layout(location = 3) PER_SAMPLE in vec4 in_tangent;
#endif
#ifdef HAS_HEIGHT
layout(location = 4) PER_SAMPLE in vec2 in_height_uv;
#include "render/height_field.glsl"
#ifdef SOFT_SHADOW
#include "shell/soft.glsl"
#endif
#include "shell/plane.glsl"
#include "shell/normals.glsl"
#include "render/height_lod.glsl"
#endif
#ifdef MESH_TANGENTS
layout(location = 5) PER_SAMPLE in float in_shear;
#endif

SurfacePoint rastered_point() {
    return SurfacePoint(in_position, in_normal, cross(dFdx(in_position), dFdy(in_position)), in_uvs, dFdx(in_uvs),
                        dFdy(in_uvs), gl_FrontFacing);
}
#endif
#include "render/dither.glsl"

#if defined(DEPTH_OFFSET) || defined(DEPTH_SHIFT)
// A depth pre-pass and the shading after it are to agree on it.
#ifdef DEPTH_BEHIND
layout(depth_less) invariant out float gl_FragDepth;
#else
invariant gl_FragDepth;
#endif

// Where the surface lies behind the raster's depth it is said so, and rounding may not make it a lie.
float surface_depth(float view_depth) {
    float depth = buffer_depth(view_depth);
#ifdef DEPTH_BEHIND
    depth = min(depth, gl_FragCoord.z);
#endif
    return depth;
}
#endif

vec3 toward_eye(Object object, vec3 position) {
    return object.eye.w != 0.0 ? object.eye.xyz - position : object.eye.xyz;
}

void shade_point(Object object, SurfacePoint point) {
    vec3 position = point.position;
    float facing = point.front ? 1.0 : -1.0;
    vec3 base_normal = facing * normalize(point.normal), normal = base_normal;
    vec3 geometric = point.geometric;
    TexturePoint at[2] = TexturePoint[2](TexturePoint(point.uvs.xy, point.uvs_x.xy, point.uvs_y.xy),
                                         TexturePoint(point.uvs.zw, point.uvs_x.zw, point.uvs_y.zw));
    float level = 0.0;
#ifndef DEPTH_ONLY
    Visibility visibility = all_lights_visible();
#endif
#ifdef HAS_HEIGHT
#ifdef MESH_TANGENTS
    mat3x2 jacobian = frame_jacobian(normalize(in_normal), in_tangent, in_shear);
#else
    mat3x2 jacobian = uv_jacobian(dFdx(in_position), dFdy(in_position), dFdx(in_height_uv), dFdy(in_height_uv), normal);
#endif
    // Seen from behind, heights turn inside out.
    float scale = facing * material.displacement.x;
    vec2 range = facing * material.displacement.zw;
    vec2 height_uv = in_height_uv;
    // Of the point itself, the same all along the ray: derivatives of where a ray ends would jump from pixel to pixel.
#ifdef HEIGHT_MIPS
    float lod = max(height_lod(dFdx(in_height_uv), dFdy(in_height_uv)), 0.0);
#else
    const float lod = 0.0;
#endif
#ifdef LOD_FADE
    float fade = lod_fade(dFdx(in_height_uv), dFdy(in_height_uv));
    scale *= fade;
    range *= fade;
#endif
#ifdef MARCH_MOVES
    PlaneMarch march = PlaneMarch(scale, material.displacement.y, min(range.x, range.y), max(range.x, range.y),
                                  int(material.march.x), int(material.march.y), int(material.march.z),
                                  int(material.march.w >> 1), material.classic.x, lod);
    vec3 direction = normalize(-toward_eye(object, position));
    PlaneRay ray = plane_ray(height_uv, jacobian, direction, normal, material.classic.y);
#ifdef LOD_FADE
    PlaneHit hit = PlaneHit(0.0, height_uv, 0);
    if (fade > 0.0) {
        hit = plane_trace(march, ray);
    }
#else
    PlaneHit hit = plane_trace(march, ray);
#endif
    count_limits(hit.limits);
#ifdef HORIZON
    // Where the base surface turns edge-on only what is high enough stands out before what lies behind it.
    float turned = clamp(1.0 - abs(dot(direction, normal)) / max(material.horizon.z, 1e-3), 0.0, 1.0);
    float cut = clamp(pow(turned, material.horizon.w) * material.horizon.x, 0.0, 1.0);
#ifdef LOD_FADE
    cut *= fade;
#endif
    if (height_at(hit.uv, lod) - material.horizon.y < cut) {
        discard;
    }
#endif
#ifdef UV_BOUNDS
    if (any(lessThan(hit.uv, material.uv_bounds.xy)) || any(greaterThan(hit.uv, material.uv_bounds.zw))) {
        discard;
    }
#endif
    // The textures follow the height map's coordinates through the plane.
    vec2 moved = hit.uv - height_uv;
    mat2 height_linear = mat2(dFdx(in_height_uv), dFdy(in_height_uv));
    vec2 pixels = abs(determinant(height_linear)) > 0.0 ? inverse(height_linear) * moved : vec2(0.0);
    for (int i = 0; i < 2; ++i) {
        at[i].uv += pixels.x * at[i].dx + pixels.y * at[i].dy;
    }
    height_uv = hit.uv;
#ifdef MARCH_TRACES
    level = facing * hit.t;
    geometric = normal - scale * height_gradient(height_uv, lod) * jacobian;
#endif
#ifdef SELF_SHADOW
    vec3 world = transform_point(object.world_x, object.world_y, object.world_z, position);
    for (int i = 0; i < SHADOWED_LIGHTS; ++i) {
        vec3 toward;
        light_arriving(lights[i], world, toward);
        vec3 toward_mesh = mat3(object.normal_x.xyz, object.normal_y.xyz, object.normal_z.xyz) * toward;
        // What looks away from a light does not see it.
        if (min(dot(toward_mesh, normal), dot(toward_mesh, geometric)) <= 0.0) {
            visibility.light[i] = 0.0;
            continue;
        }
#ifdef SOFT_SHADOW
        toward_mesh = normalize(toward_mesh);
        float tilt = penumbra_tilt(material.shadow.x, dot(toward_mesh, normal));
        toward_mesh += tilt * normal;
        float spread = 2.0 * tilt / length(toward_mesh);
        // The field's own plane hides what of the disc is below it, before the first step.
        float least = clamp(dot(toward_mesh, geometric) / (2.0 * tilt), 0.0, 1.0);
        penumbra = Penumbra(true, spread, material.shadow.y, 0.0, 1e30, 0.0, least, vec3(0.0));
#endif
        PlaneRay way = plane_ray(height_uv, jacobian, toward_mesh, normal, 1e-3);
#ifdef SHADOW_STEPS
        int steps = int(material.shadow.z);
#else
        int steps = plane_steps(march, way.cosine);
#endif
        visibility.light[i] = plane_lit(march, hit, way, steps);
    }
#endif
#ifdef DEPTH_OFFSET
    float along = dot(direction, normal);
    position += direction * hit.t / (along < 0.0 ? min(along, -1e-3) : max(along, 1e-3));
#endif
#endif
    normal = normalize(normal - scale * shading_gradient(height_uv, lod) * jacobian);
    count_reads();
#endif
    geometric *= dot(geometric, toward_eye(object, position)) < 0.0 ? -1.0 : 1.0;
    MaterialPoint m = material_at(at);
#ifdef ALPHA_MASK
    if (m.base_color.a < material.emissive.w) {
        discard;
    }
#endif
#ifndef DEPTH_ONLY
#ifdef NORMAL_UV
    normal = mapped_normal(m.normal, normal, in_tangent);
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
    float open = ambient_occlusion(TexturePoint(height_uv, dFdx(in_height_uv), dFdy(in_height_uv)));
#ifdef LOD_FADE
    open = mix(1.0, open, fade);
#endif
    surface.occlusion *= open;
#endif
#endif
    float view_depth = dot(object.depth.xyz, position) + object.depth.w;
#ifdef DEPTH_OFFSET
    if (view_depth < frame.lens.z || view_depth > frame.lens.w) {
        discard;
    }
    gl_FragDepth = surface_depth(view_depth);
#endif
#ifdef DEPTH_SHIFT
    // Along the ray, away from the eye; what is shaded stays where it is.
    float share = 1.0;
#ifdef DITHER
    share = pixel_noise();
#endif
    vec3 from_eye = transform_point(object.world_x, object.world_y, object.world_z, position);
    float along_view = object.eye.w != 0.0 ? dot(normalize(from_eye), frame.forward.xyz) : 1.0;
    gl_FragDepth = surface_depth(max(view_depth + share * material.classic.z * along_view, frame.lens.z));
#endif
#ifndef DEPTH_ONLY
#ifdef HAS_HEIGHT
    float height = level / material.displacement.x + material.displacement.y;
#else
    float height = material.displacement.y;
#endif
#ifdef SHADOW_MAPS
    Receiver receiver = NO_RECEIVER;
#if defined(MARCH_TRACES) && defined(DEPTH_OFFSET)
    receiver.followed = true;
    receiver.uv = height_uv;
    receiver.level = level;
    receiver.scale = material.displacement.x;
    // The inverse of what u, v and the level gain by a displacement.
    vec3 to_u = vec3(jacobian[0].x, jacobian[1].x, jacobian[2].x);
    vec3 to_v = vec3(jacobian[0].y, jacobian[1].y, jacobian[2].y);
    receiver.axes = inverse(transpose(mat3(to_u, to_v, facing * base_normal)));
    for (int i = 0; i < 3; ++i) {
        receiver.axes[i] = transform_direction(object.world_x, object.world_y, object.world_z, receiver.axes[i]);
    }
    receiver.uvs = mat2(1.0);
#endif
    visibility = mapped_visibility(visibility, surface, receiver);
#endif
    write_outputs(surface, visibility, at[AOV_UV].uv, view_depth, height);
#endif
}

void main() {
    Object object = drawn;
#ifdef VISIBILITY
    SurfacePoint point;
    if (named_point(object, ivec2(gl_FragCoord.xy), pixel_ndc(gl_FragCoord.xy), point)) {
        shade_point(object, point);
    } else {
        discard;
    }
#else
    shade_point(object, rastered_point());
#endif
}
