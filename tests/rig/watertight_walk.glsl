// The walk's view of the mesh of rig/watertight.comp, and what a hit of it must be.

// The corners are relative to it, as in a renderer's own space.
vec3 walk_origin;
// Growth of the lids.
float walk_pixel;

uvec4 walk_corners(uint prism) {
    // All walls go on in the same field.
    return uvec4(prisms.item[prism].corners.xyz, 0u);
}

vec4 walk_range(uint prism) {
    return prisms.item[prism].range;
}

uint walk_neighbour(uint prism, int wall) {
    return adjacency.item[3u * prism + uint(wall)];
}

vec4 walk_neighbour_uv(uint prism, int wall) {
    return vec4(0.0);
}

vec2 walk_lids(uint vertex) {
    return lids.item[vertex];
}

float walk_growth(uint vertex) {
    return walk_pixel;
}

vec3 walk_position(uint vertex) {
    return corners.item[vertex].position.xyz - walk_origin;
}

vec3 walk_shell(uint vertex) {
    return corners.item[vertex].normal.xyz;
}

vec2 walk_uv(uint vertex) {
    return vec2(corners.item[vertex].position.w, corners.item[vertex].normal.w);
}

#include "shell/walk.glsl"

// Whether it is the one front hit that the ray has: on the surface, on the ray, ahead, seen from the front.
bool walk_true(WalkRay ray, MarchSettings settings, WalkHit hit, vec4 depth_row) {
    uvec3 at = walk_corners(hit.prism).xyz;
    vec3 point = vec3(0.0);
    vec2 uv = vec2(0.0);
    for (int k = 0; k < 3; ++k) {
        point += hit.lambda[k] * (walk_position(at[k]) + hit.t * walk_shell(at[k]));
        uv += hit.lambda[k] * walk_uv(at[k]);
    }
    vec4 row_x = ray.x - ray.ndc.x * ray.w, row_y = ray.y - ray.ndc.y * ray.w;
    vec2 across = vec2(dot(row_x.xyz, point) + row_x.w, dot(row_y.xyz, point) + row_y.w);
    vec3 weights = walk_weights(walk_stand(ray, hit.prism, 2), hit.t);
    bool on_ray = all(lessThan(abs(across), 5e-4 * size * vec2(length(row_x.xyz), length(row_y.xyz))));
    bool on_surface = abs(hit.t - surface_level(settings, uv)) < 1e-4 * size && hit.wall < 0;
    bool inside = all(greaterThan(hit.lambda, vec3(-1e-3)));
    bool front = (weights.x + weights.y + weights.z) * ray.handedness < 0.0;
    return on_ray && on_surface && inside && front && dot(depth_row.xyz, point) + depth_row.w > 0.0;
}
