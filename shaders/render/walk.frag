#version 460
#extension GL_GOOGLE_include_directive : require
#ifdef MESH_STAGE
#extension GL_EXT_mesh_shader : require
#endif
// The pixel's ray through the shell, from the lid, base or border that the raster names to its first hit.
#include "render/interface.glsl"

#include "shell/prism.glsl"
#include "render/height_field.glsl"
#include "render/other_fields.glsl"
#include "shell/march.glsl"
#include "render/dither.glsl"
#include "render/march_settings.glsl"
#include "render/walk_access.glsl"
#include "shell/walk.glsl"
#ifdef WALK_BORDERS
#include "render/walk_border.glsl"
#endif
#include "render/shell_shade.glsl"

#ifdef MESH_STAGE
layout(location = 0) perprimitiveEXT flat in uint in_prism;
#else
layout(location = 0) flat in uint in_prism;
#endif
#ifdef WALK_LIDS
layout(location = 1) PER_SAMPLE in float in_level;
#endif

// The first hit of the pixel's ray.
WalkHit first_hit(Object object, MarchSettings settings, vec2 ndc) {
    WalkRay ray = pixel_ray(object.clip_x, object.clip_y, object.clip_w, ndc, object.handedness.x);
    int limit = 64 + 2 * int(draw.prism_count);
#ifdef WALK_LIDS
    Standing at = walk_stand(ray, in_prism, 2);
    WalkStart start = walk_start(ray, in_level, at);
    WalkHit hit = WalkHit(false, in_prism, 0.0, vec3(0.0), -1, 0);
    if (start.found) {
        WalkTrail trail = NO_TRAIL;
        hit = walk(ray, settings, at, start, limit, trail);
    }
    return hit;
#else
    return border_hit(in_prism, ray, object, settings, limit);
#endif
}

void main() {
    Object object = objects.item[draw.object];
    vec2 ndc = pixel_ndc(ray_point());
#ifdef LOD_FADE
    fade_heights(object, ndc);
#endif
    MarchSettings settings = march_settings();
    WalkHit hit = first_hit(object, settings, ndc);
    count_limits(hit.limits);
    // What misses is discarded at the end: before it, lavapipe would run all that follows for no fragment.
    bool shown = hit.hit;
#ifdef VIEW_PRISMS
    seen_prism = hit.prism;
#endif
    if (shown) {
        uvec4 corners = prisms.item[hit.prism].corners;
        Vertex v[3] = Vertex[3](vertices.item[corners[0]], vertices.item[corners[1]], vertices.item[corners[2]]);
        Prism shaded;
        vec3 depth, slope;
        for (int k = 0; k < 3; ++k) {
            shaded.uv[k] = vec2(v[k].shell.w, v[k].normal.w);
            depth[k] = dot(object.depth.xyz, v[k].position.xyz) + object.depth.w;
            slope[k] = dot(object.depth.xyz, v[k].shell.xyz);
        }
        shaded.plain = is_plain(corners.w);
        float hit_depth = depth_at(hit.lambda, hit.t, depth, slope);
        shown = hit_depth >= frame.lens.z && hit_depth <= frame.lens.w;
        if (shown) {
            ShellHit shell_hit = ShellHit(true, hit_depth, hit.t, hit.lambda, hit.wall, hit.limits);
            shade_hit(object, hit.prism, corners.xyz, v, ndc, shaded, settings, shell_hit);
        }
    }
    count_reads();
    if (!shown) {
        if (write_missed()) {
            return;
        }
        discard;
    }
}
