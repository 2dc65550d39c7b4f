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
#include "render/nearest_lid.glsl"
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

// The first hit of the pixel's ray, from the lid of `prism` at `level`, or from its border, and the prism `at` it.
WalkHit first_hit(Object object, MarchSettings settings, vec2 ndc, uint prism, float level, out Standing at) {
    WalkRay ray = pixel_ray(object.clip_x, object.clip_y, object.clip_w, ndc, object.handedness.x);
    int limit = 64 + 2 * int(draw.prism_count);
#ifdef WALK_LIDS
    at = walk_stand(ray, prism, 2);
    WalkStart start = walk_start(ray, level, at);
    WalkHit hit = WalkHit(false, prism, 0.0, vec3(0.0), -1, 0);
    if (start.found) {
        WalkTrail trail = NO_TRAIL;
        hit = walk(ray, settings, at, start, limit, trail);
    }
    return hit;
#else
    WalkHit hit = border_hit(prism, ray, object, settings, limit);
    at = walk_stand(ray, hit.prism, 2);
    return hit;
#endif
}

// Traces and shades; false if nothing is hit.
bool shows(uint prism, float level) {
    Object object = drawn;
    vec2 ndc = pixel_ndc(ray_point());
#ifdef LOD_FADE
    fade_heights(object, ndc);
#endif
    MarchSettings settings = march_settings();
    Standing at;
    WalkHit hit = first_hit(object, settings, ndc, prism, level, at);
    count_limits(hit.limits);
    // What misses is discarded at the end: before it, lavapipe would run all that follows for no fragment.
    bool shown = hit.hit;
#ifdef VIEW_PRISMS
    seen_prism = hit.prism;
#endif
    if (shown) {
        uvec4 corners = at.corners;
        Vertex v[3] = Vertex[3](vertices.item[corners[0]], vertices.item[corners[1]], vertices.item[corners[2]]);
        Prism shaded;
        vec3 depth, slope;
        for (int k = 0; k < 3; ++k) {
            // The walk has it: not to be read again.
            shaded.uv[k] = walk_corner_uv(at, k);
            v[k].shell.w = shaded.uv[k].x;
            v[k].normal.w = shaded.uv[k].y;
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
    return shown;
}

void main() {
    uint prism = in_prism;
#ifdef WALK_LIDS
    float level = in_level;
#else
    float level = 0.0;
#endif
    // What only fills up a quad has no derivative to give, and would trace as far as the others.
    bool begins = !gl_HelperInvocation;
#ifdef VISIBILITY
    begins = begins && begins_walk(prism, level);
#endif
    bool shown = false;
    if (begins) {
        shown = shows(prism, level);
    }
    if (!shown) {
        if (write_missed()) {
            return;
        }
        discard;
    }
}
