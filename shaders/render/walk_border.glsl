// Where a ray enters the shell through a border, or begins in it at the near plane.
#ifndef RENDER_WALK_BORDER_GLSL
#define RENDER_WALK_BORDER_GLSL

#include "render/lid_growth.glsl"
#include "shell/walk.glsl"

// View depth where the ray crosses a wall, or an end of the levels.
float crossing_depth(ProjectedPrism projected, vec3 s[3], float t, int wall, vec3 depth, vec3 slope) {
    if (wall != AT_LEVEL) {
        return depth_at(wall_barycentrics(projected, wall, wall_weight(projected, wall, t)), t, depth, slope);
    }
    return depth_at(path_lambda(s, t), t, depth, slope);
}

// How near a border, in pixels, the rasteriser's grid may have dropped the lid; and how near a corner of it rounding may
// tell each of two prisms that the ray comes in through the other.
const float GRID_REACH = 2.0;
const float ROUNDING_REACH = 0.25;

// Whether the ray is within so many pixels of a border at level t: of a wall without neighbour, or of a corner between
// two such walls of other prisms.
bool beside_border(ProjectedPrism projected, vec3 s[3], uint id, uint bits, float t, float view_depth, float pixels) {
    float reach = 2.0 * pixels * max(frame.viewport.z, frame.viewport.w) * (frame.projection.x != 0u ? view_depth : 1.0);
    bool beside = false;
    for (int k = 0; k < 3; ++k) {
        ivec2 c = wall_corners(projected, k);
        vec2 edge = projected.p[c.y] + t * projected.q[c.y] - projected.p[c.x] - t * projected.q[c.x];
        beside = beside || (at_brink(bits, k) && length(projected.p[k] + t * projected.q[k]) <= reach);
        beside = beside || (walk_neighbour(id, k) == NO_NEIGHBOUR && abs(quadratic(s[k], t)) <= reach * length(edge));
    }
    return beside;
}

// The first hit of what enters the prism `id` from outside the shell.
WalkHit border_hit(uint id, WalkRay ray, Object object, MarchSettings settings, int limit) {
    uvec4 corners = walk_corners(id);
    vec4 range = walk_range(id);
    ProjectedPrism projected;
    vec3 depth, slope, canonical[3], s[3];
    for (int k = 0; k < 3; ++k) {
        walk_across(ray, corners[k], projected.p[k], projected.q[k]);
        projected.descending[k] = wall_descends(corners.w, k);
        depth[k] = dot(object.depth.xyz, walk_position(corners[k])) + object.depth.w;
        slope[k] = dot(object.depth.xyz, walk_shell(corners[k]));
    }
    for (int k = 0; k < 3; ++k) {
        canonical[k] = wall_quadratic(projected, k);
        s[k] = canonical[k] * wall_sign(projected, k);
    }
    WalkHit best = WalkHit(false, id, 0.0, vec3(0.0), -1, 0);
    float near = frame.lens.z, best_depth = 1e30;
    if (is_plain(corners.w)) {
        ShellHit plain = plain_trace(projected, settings.two_sided, depth, near, ray.handedness);
        return WalkHit(plain.hit, id, 0.0, plain.lambda, -1, 0);
    }
    bool irregular = has_flag(corners.w, IRREGULAR);
    // Where the near plane clips lids, rays come in through them here.
    for (int k = 0; k < 3; ++k) {
        irregular = irregular || depth[k] + min(range.z * slope[k], range.w * slope[k]) < NEAR_REACH * near;
    }
    vec3 sides;
    Crossings crossings = prism_crossings(projected, canonical, range.z, range.w, sides);
    for (int i = crossings.count - 2; i >= 0; --i) {
        Stretch stretch = stretch_below(crossings, i, ray.handedness, sides);
        if (!stretch.inside) {
            continue;
        }
        int from = stretch.from, to = stretch.to;
        float entry_depth = crossing_depth(projected, s, crossings.t[from], crossings.wall[from], depth, slope);
        float leave_depth = crossing_depth(projected, s, crossings.t[to], crossings.wall[to], depth, slope);
        if (leave_depth < near || entry_depth >= best_depth) {
            continue;
        }
        bool cut = entry_depth < near;
        int wall = cut ? AT_LEVEL : crossings.wall[from];
        bool enters = wall == AT_LEVEL ? cut || irregular : walk_neighbour(id, wall) == NO_NEIGHBOUR;
        float pixels = wall == AT_LEVEL ? GRID_REACH : ROUNDING_REACH;
        if (!enters && !beside_border(projected, s, id, corners.w, crossings.t[from], entry_depth, pixels)) {
            continue;
        }
        WalkStart start;
        start.t = cut ? near_level(s, crossings.t[from], crossings.t[to], depth, slope, near) : crossings.t[from];
        start.front = stretch.front ? 1.0 : -1.0;
        start.on_wall = wall != AT_LEVEL;
        start.found = true;
        WalkTrail trail = NO_TRAIL;
        Standing at = walk_stand(ray, id, start.on_wall ? wall : 2);
        WalkHit hit = walk(ray, settings, at, start, limit, trail);
        int limits = best.limits + hit.limits;
        if (hit.hit) {
            uvec3 ends = at.corners.xyz;
            float hit_depth = 0.0;
            for (int k = 0; k < 3; ++k) {
                vec3 place = walk_position(ends[k]) + hit.t * walk_shell(ends[k]);
                hit_depth += hit.lambda[k] * (dot(object.depth.xyz, place) + object.depth.w);
            }
            if (hit_depth < best_depth) {
                best = hit;
                best_depth = hit_depth;
            }
        }
        best.limits = limits;
    }
    return best;
}

#endif
