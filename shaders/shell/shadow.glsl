// Shadow rays: from a point of the surface toward a light, through the shell that the point lies in and into every prism
// that the way meets again.
//
// First the walk, from the prism of the point: over shared walls it carries the side of the surface it is on, so nothing
// is asked anew where rounding could answer wrongly, next to the start. Then, with SHADOW_REENTRY, a hierarchy of boxes
// finds the prisms that the ray enters from outside, behind a dent or on another part of the mesh.
//
// The start lies on the surface by rounding only. Its own crossing is divided out by a shift of the surface that brings
// it to the start, as the march itself finds the two in the first prism: their difference is 0 there and grows with the
// ray's sine, so that what a grazing ray meets next is told from what it leaves. It serves every march.
//
// Needs shell/walk.glsl. With SHADOW_REENTRY the includer gives
//     ShadowBox shadow_box(uint index)
// in depth-first order, the first box that of all, `shadow_boxes()` of them.
#ifndef SHELL_SHADOW_GLSL
#define SHELL_SHADOW_GLSL

// How far the start is cleared above that, as a part of the height range: by two roundings of a height, or by what the
// march of a function's heights may take for one.
#ifdef HEIGHT_PROCEDURE
const float LEAST_CLEARANCE = 2e-6;
#else
const float LEAST_CLEARANCE = 1e-7;
#endif

#ifdef SHADOW_REENTRY
struct ShadowBox {
    vec3 low, high;
    uint next;  // the box to go on with where the ray misses this one
    uint prism; // NO_PRISM where the boxes that follow divide it
};

ShadowBox shadow_box(uint index);
uint shadow_boxes();
#endif

// Where a shadow ray starts.
struct ShadowStart {
    vec3 position; // mesh space
    uint prism;
    vec3 lambda;   // in it
    float t;
    int wall;      // of the prism, or -1 on the height field
    float side;    // of the surface: +1 above
};

// The way to a light.
struct ShadowWay {
    vec3 toward; // mesh space, unit
    float reach; // distance of the light
};

// The ray along a unit direction. Two axes across it, with e0 x e1 along it (Duff et al. 2017).
WalkRay shadow_ray(vec3 origin, vec3 lambda, vec3 toward) {
    float turned = toward.z < 0.0 ? -1.0 : 1.0;
    float a = -1.0 / (turned + toward.z), b = toward.x * toward.y * a;
    vec3 e0 = vec3(1.0 + turned * toward.x * toward.x * a, turned * b, -turned * toward.x);
    vec3 e1 = vec3(b, turned + toward.y * toward.y * a, -toward.y);
    return WalkRay(vec4(e0, 0.0), vec4(e1, 0.0), vec4(0.0), vec2(0.0), 1.0, true, origin, lambda);
}

// The march's settings for a ray that starts in `at`: see above.
MarchSettings shadow_settings(MarchSettings settings, ShadowStart start, Standing at) {
    float clear = LEAST_CLEARANCE;
    if (start.wall < 0) {
        uvec3 corners = walk_turned(walk_corners(at.prism).xyz, at.entry);
        // By the ray's own path, which within a level there is none.
        vec3 lambda = walk_in_level(at, start.t) ? start.lambda : walk_lambda(at, EXIT_NONE, start.t);
        vec2 uv = lambda.x * walk_uv(corners.x) + lambda.y * walk_uv(corners.y) + lambda.z * walk_uv(corners.z);
        clear += start.side * (surface_level(settings, uv) - start.t) / settings.scale;
    }
    settings.midlevel += start.side * clear;
    return settings;
}

// How far along the way a point of a prism lies.
float shadow_distance(ShadowStart start, ShadowWay way, uint prism, vec3 lambda, float t) {
    uvec3 corners = walk_corners(prism).xyz;
    vec3 moved = vec3(0.0);
    for (int k = 0; k < 3; ++k) {
        moved += lambda[k] * (walk_position(corners[k]) - start.position + t * walk_shell(corners[k]));
    }
    return dot(moved, way.toward);
}

// Whether something in one prism lies on the way, farther than `near`.
bool prism_blocks(WalkRay ray, ShadowWay way, MarchSettings settings, uint id, float near, inout int limits) {
    uvec4 corners = walk_corners(id);
    ProjectedPrism projected;
    Prism prism;
    vec3 distance, slope;
    for (int k = 0; k < 3; ++k) {
        walk_across(ray, corners[k], projected.p[k], projected.q[k]);
        projected.descending[k] = wall_descends(corners.w, k);
        distance[k] = dot(walk_position(corners[k]) - ray.origin, way.toward);
        slope[k] = dot(walk_shell(corners[k]), way.toward);
        prism.uv[k] = walk_uv(corners[k]);
        prism.neighbour_uv[k] = walk_neighbour_uv(id, k);
        prism.wall[k] = wall_kind(corners.w, k);
        prism.field[k] = wall_field(corners.w, k);
        prism.behind[k] = true;
    }
    vec4 range = walk_range(id);
    prism.t0 = range.x;
    prism.t1 = range.y;
#ifdef SOFT_SHADOW
    prism.t1 += penumbra.open ? penumbra.headroom : 0.0;
#endif
    prism.plain = is_plain(corners.w);
    enter_prism(corners.w);
    ShellHit hit = prism_trace(projected, prism, settings, distance, slope, near, ray.handedness);
    limits += hit.limits;
    return hit.hit && hit.depth < way.reach;
}

// Whether the surface hides the light at the end of the way. `limit`: see walk. While a penumbra is open it takes down
// the clearances of a way that nothing blocks.
bool shadow_blocked(ShadowStart start, ShadowWay way, MarchSettings settings, int limit, inout int limits) {
    WalkRay ray = shadow_ray(start.position, start.lambda, way.toward);
    WalkTrail trail = NO_TRAIL;
    float left = 0.0;
    settings.two_sided = true;
    if (is_plain(walk_corners(start.prism).w)) {
        walk_pass(start.prism, trail);
    } else {
        bool on_wall = start.wall >= 0;
        Standing at = walk_stand(ray, start.prism, on_wall ? start.wall : 2);
        walk_pass(at.prism, trail);
        bool inside = true;
        if (on_wall && at.ab.y + 2.0 * start.t * at.ab.z < 0.0) {
            // Off the wall on its other side: by the slope, which rounding cannot turn as it does the root.
            uint neighbour = walk_neighbour(at.prism, at.entry);
            inside = neighbour != NO_NEIGHBOUR;
            if (inside) {
                walk_over(ray, neighbour, EXIT_AB, at);
            }
        }
        settings = shadow_settings(settings, start, at);
        if (inside) {
            vec3 weights = walk_weights(at, start.t);
            float front = weights.x + weights.y + weights.z < 0.0 ? -1.0 : 1.0;
            WalkHit hit = walk(ray, settings, at, WalkStart(start.t, front, on_wall, true), limit, trail);
            limits += hit.limits;
            if (hit.hit) {
                return shadow_distance(start, way, hit.prism, hit.lambda, hit.t) < way.reach;
            }
            float end = shadow_distance(start, way, trail.prism, trail.lambda, trail.t);
            left = end > 0.0 ? end : 0.0;
        }
    }
#ifdef SHADOW_REENTRY
    uvec3 corners = walk_corners(start.prism).xyz;
    vec3 first = walk_position(corners.x);
    float pad = 1e-5 * max(length(walk_position(corners.y) - first), length(walk_position(corners.z) - first));
    // A finite inverse: nothing is told from 0 x infinity.
    vec3 inverse = 1.0 / mix(way.toward, vec3(1e-20), lessThan(abs(way.toward), vec3(1e-20)));
    for (uint index = 0u; index < shadow_boxes();) {
        ShadowBox box = shadow_box(index);
        vec3 a = (box.low - start.position) * inverse, b = (box.high - start.position) * inverse;
        vec3 enters = min(a, b), leaves = max(a, b);
        float from = max(max(enters.x, enters.y), max(enters.z, pad));
        float to = min(min(leaves.x, leaves.y), min(leaves.z, way.reach));
        if (from > to) {
            index = box.next;
            continue;
        }
        ++index;
        if (box.prism == NO_PRISM) {
            continue;
        }
        // What the walk has passed is clear as far as the walk went.
        float near = walk_passed(box.prism, trail) ? left + pad : pad;
        if (to > near && prism_blocks(ray, way, settings, box.prism, near, limits)) {
            return true;
        }
    }
#endif
    return false;
}

#endif
