// The walk: from prism to prism through their shared walls, to the first hit or out of the shell.
//
// A line crosses wall k of a prism at the roots of s_k, and which way follows from the slope alone: with `handedness` h
// it leaves the prism at the root where h s_k' < 0 and enters it at the other, whether it sees the level planes from
// the front (s > 0 inside, travel d = h) or from behind (s < 0, d = -h). So each wall has one exit, the nearest one
// beyond the ray's level is taken, and a wall that the ray is already behind is an exit of length zero. The neighbour
// gets the shared wall's quadratic negated, to the bit what it would have computed: no ray slips between two prisms.
//
// Needs shell/march.glsl. The includer gives the adjacency and the mesh:
//     uvec4 walk_corners(uint prism)                 three vertices, packed walls (shell/prism_bits.glsl)
//     vec4 walk_range(uint prism)                    levels of its surface; least base, greatest lid of its corners
//     uint walk_neighbour(uint prism, int wall)      4 * prism + its number of the wall, or NO_NEIGHBOUR
//     vec4 walk_neighbour_uv(uint prism, int wall)   coordinates across, at the wall's canonical corners
//     vec2 walk_lids(uint vertex)                    base and lid level
//     float walk_growth(uint vertex)                 levels that the raster adds to the lid, and takes from the base
//     vec3 walk_position(uint vertex), vec3 walk_shell(uint vertex), vec2 walk_uv(uint vertex)
#ifndef SHELL_WALK_GLSL
#define SHELL_WALK_GLSL

#include "shell/work.glsl"

// Prisms that the one the raster names may lie away from the one the ray is in, and from where the ray came in.
const int WALK_LOCATE_HOPS = 8;
const int WALK_BACK_HOPS = 64;

// A pixel's ray: the rows of mesh to clip x, y and w, and the pixel. Any other: see shadow_ray of shell/shadow.glsl.
struct WalkRay {
    vec4 x, y, w;
    vec2 ndc;
    float handedness;
    bool shadow; // begins at `origin`, on the surface, and both sides of all that it crosses stop it
    vec3 origin; // a shadow's, taken from the mesh's positions before anything else
    vec3 lambda; // of its origin in the first prism
};

WalkRay pixel_ray(vec4 x, vec4 y, vec4 w, vec2 ndc, float handedness) {
    return WalkRay(x, y, w, ndc, handedness, false, vec3(0.0), vec3(0.0));
}

// A prism the ray is in, turned so that corner c faces the wall it came through: c is the prism's corner `entry`, and a
// and b follow it. Each wall by the corners it joins, its quadratic with the prism's own sign.
struct Standing {
    uint prism;
    int entry;
    uvec4 corners; // walk_corners of the prism
    vec4 range;    // walk_range of it
    vec2 pa, qa, pb, qb, pc, qc;
    vec2 uv_a, uv_b, uv_c;
    vec3 bc, ca, ab;
};

// Exits of a standing prism, in its own turn: the wall faces corner a, b or c.
const int EXIT_BC = 0;
const int EXIT_CA = 1;
const int EXIT_AB = 2;
const int EXIT_NONE = 3;

struct WalkHit {
    bool hit;
    uint prism;
    float t;
    vec3 lambda; // of the prism's corners in their own order
    int wall;    // the prism's own number of the wall hit, or -1 for the height field
    int limits;  // loops that gave up
};

// Where a walk that hits nothing has been.
struct WalkTrail {
    uvec4 passed; // a bit for each of its prisms, by the last bits of their numbers
    uint prism;   // the last one, and where the ray leaves its levels
    float t;
    vec3 lambda;
};

const WalkTrail NO_TRAIL = WalkTrail(uvec4(0u), 0u, 0.0, vec3(0.0));

// Takes a prism down as passed.
void walk_pass(uint prism, inout WalkTrail trail) {
    trail.passed[(prism >> 5) & 3u] |= 1u << (prism & 31u);
}

// False where the walk has not been in the prism; true where it has, and in about one of 128 / prisms passed others.
bool walk_passed(uint prism, WalkTrail trail) {
    return (trail.passed[(prism >> 5) & 3u] >> (prism & 31u) & 1u) != 0u;
}

// A wall's or corner's own number, from the turned one (a, b, c = 0, 1, 2).
int walk_number(int entry, int turned) {
    int number = entry + turned + 1;
    return number > 2 ? number - 3 : number;
}

uvec3 walk_turned(uvec3 corners, int entry) {
    return entry == 0 ? corners.yzx : entry == 1 ? corners.zxy : corners;
}

vec3 walk_unturned(vec3 lambda, int entry) {
    return entry == 0 ? lambda.zxy : entry == 1 ? lambda.yzx : lambda;
}

// The height map's coordinates at corner `number`.
vec2 walk_corner_uv(Standing at, int number) {
    return number == at.entry ? at.uv_c : number == walk_number(at.entry, 0) ? at.uv_a : at.uv_b;
}

void walk_across(WalkRay ray, uint vertex, out vec2 p, out vec2 q) {
    vec3 at = walk_position(vertex), shell = walk_shell(vertex);
    at = ray.shadow ? at - ray.origin : at;
    precise vec3 place = vec3(dot(ray.x.xyz, at) + ray.x.w, dot(ray.y.xyz, at) + ray.y.w, dot(ray.w.xyz, at) + ray.w.w);
    precise vec3 direction = vec3(dot(ray.x.xyz, shell), dot(ray.y.xyz, shell), dot(ray.w.xyz, shell));
    p = across_ray(place, ray.ndc);
    q = across_ray(direction, ray.ndc);
}

Standing walk_stand(WalkRay ray, uint prism, int entry) {
    Standing at;
    at.prism = prism;
    at.entry = entry;
    at.corners = walk_corners(prism);
    at.range = walk_range(prism);
    uvec3 corners = walk_turned(at.corners.xyz, entry);
    at.uv_a = walk_uv(corners.x);
    at.uv_b = walk_uv(corners.y);
    at.uv_c = walk_uv(corners.z);
    walk_across(ray, corners.x, at.pa, at.qa);
    walk_across(ray, corners.y, at.pb, at.qb);
    walk_across(ray, corners.z, at.pc, at.qc);
    at.bc = wall_between(at.pb, at.qb, at.pc, at.qc);
    at.ca = wall_between(at.pc, at.qc, at.pa, at.qa);
    at.ab = wall_between(at.pa, at.qa, at.pb, at.qb);
    return at;
}

// Over the wall `turned` into the neighbour, which runs along the shared edge the other way.
void walk_over(WalkRay ray, uint neighbour, int turned, inout Standing at) {
    vec3 shared_wall = turned == EXIT_BC ? at.bc : turned == EXIT_CA ? at.ca : at.ab;
    vec2 pa = turned == EXIT_BC ? at.pc : turned == EXIT_CA ? at.pa : at.pb;
    vec2 qa = turned == EXIT_BC ? at.qc : turned == EXIT_CA ? at.qa : at.qb;
    at.pb = turned == EXIT_BC ? at.pb : turned == EXIT_CA ? at.pc : at.pa;
    at.qb = turned == EXIT_BC ? at.qb : turned == EXIT_CA ? at.qc : at.qa;
    at.pa = pa;
    at.qa = qa;
    vec2 uv_a = turned == EXIT_BC ? at.uv_c : turned == EXIT_CA ? at.uv_a : at.uv_b;
    at.uv_b = turned == EXIT_BC ? at.uv_b : turned == EXIT_CA ? at.uv_c : at.uv_a;
    at.uv_a = uv_a;
    at.prism = neighbour >> 2;
    at.entry = int(neighbour & 3u);
    at.corners = walk_corners(at.prism);
    at.range = walk_range(at.prism);
    uvec3 corners = walk_turned(at.corners.xyz, at.entry);
    walk_across(ray, corners.z, at.pc, at.qc);
    at.uv_c = walk_uv(corners.z);
    if (wall_kind(at.corners.w, at.entry) != WALL_SAME) {
        at.uv_a = walk_uv(corners.x);
        at.uv_b = walk_uv(corners.y);
    }
    at.ab = -shared_wall;
    at.bc = wall_between(at.pb, at.qb, at.pc, at.qc);
    at.ca = wall_between(at.pc, at.qc, at.pa, at.qa);
}

// Level at which a ray leaves through a wall; NaN or infinite where it never does. The root is taken in the form without
// cancellation, so a vanishing square only sends it to infinity.
float exit_level(vec3 s, float handedness) {
    precise float discriminant = s.y * s.y - 4.0 * s.x * s.z;
    float root = handedness * sqrt(discriminant);
    bool larger = handedness * s.y > 0.0;
    return (larger ? -(s.y + root) : 2.0 * s.x) / (larger ? 2.0 * s.z : root - s.y);
}

// Takes the exit through one wall where it is nearer than `leave`.
void walk_exit(vec3 s, int wall, float handedness, float front, float t, inout float leave, inout int turned) {
    float travel = front * handedness, e = exit_level(s, handedness);
    if (travel * (e - t) > 0.0) {
        if (travel * (leave - e) > 0.0) {
            leave = e;
            turned = wall;
        }
    } else if (handedness * (s.y + 2.0 * t * s.z) < 0.0 && (e == e || front * quadratic(s, t) < 0.0)) {
        // Behind the wall already and on the way out: by rounding, next to an edge or a vertex.
        leave = t;
        turned = wall;
    }
}

// The ray's sine with a level's triangle under which t no longer tells its points apart.
const float LEAST_SINE = 1e-4;

// Whether the ray runs within the level of the prism at t: seen along it the triangle is a line.
bool walk_in_level(Standing at, float t) {
    vec2 a = at.pa + t * at.qa, b = at.pb + t * at.qb - a, c = at.pc + t * at.qc - a;
    return abs(cross2(b, c)) < LEAST_SINE * max(dot(b, b), dot(c, c));
}

// The exit of a ray within level t: the wall that it crosses farthest on, but for the one it came through.
void walk_level_exit(WalkRay ray, Standing at, bool from_ab, float t, inout float leave, inout int turned) {
    uvec3 corners = walk_turned(at.corners.xyz, at.entry);
    vec2 across[3] = vec2[3](at.pa + t * at.qa, at.pb + t * at.qb, at.pc + t * at.qc);
    vec3 walls[3] = vec3[3](at.bc, at.ca, at.ab), toward = cross(ray.x.xyz, ray.y.xyz), distance;
    for (int k = 0; k < 3; ++k) {
        distance[k] = dot(walk_position(corners[k]) - ray.origin + t * walk_shell(corners[k]), toward);
    }
    float farthest = -1e30;
    for (int wall = 0; wall < (from_ab ? 2 : 3); ++wall) {
        int i = (wall + 1) % 3, j = (wall + 2) % 3;
        vec2 edge = across[j] - across[i];
        float w = clamp(-dot(across[i], edge) / max(dot(edge, edge), 1e-37), 0.0, 1.0);
        float on = mix(distance[i], distance[j], w);
        if (dot(across[i], across[j]) <= 0.0 && on > farthest) {
            farthest = on;
            turned = wall;
            // The root beside t.
            float change = -quadratic(walls[wall], t) / (walls[wall].y + 2.0 * t * walls[wall].z);
            leave = abs(change) < LEAST_SINE * length(edge) ? t + change : t;
        }
    }
}

vec3 walk_weights(Standing at, float t) {
    return vec3(quadratic(at.bc, t), quadratic(at.ca, t), quadratic(at.ab, t));
}

// Turned weights of the three corners at level t, which is that of `turned` or, without one, inside.
vec3 walk_lambda(Standing at, int turned, float t) {
    if (turned == EXIT_NONE) {
        vec3 weights = walk_weights(at, t);
        return weights / (weights.x + weights.y + weights.z);
    }
    vec2 pi = turned == EXIT_BC ? at.pb : turned == EXIT_CA ? at.pc : at.pa;
    vec2 qi = turned == EXIT_BC ? at.qb : turned == EXIT_CA ? at.qc : at.qa;
    vec2 pj = turned == EXIT_BC ? at.pc : turned == EXIT_CA ? at.pa : at.pb;
    vec2 qj = turned == EXIT_BC ? at.qc : turned == EXIT_CA ? at.qa : at.qb;
    float w = weight_between(pi, qi, pj, qj, t);
    return turned == EXIT_BC ? vec3(0.0, 1.0 - w, w) : turned == EXIT_CA ? vec3(w, 0.0, 1.0 - w)
                                                                        : vec3(1.0 - w, w, 0.0);
}

// Levels beyond the lids and bases at which a ray may still be within their growth.
float walk_margin(uvec4 corners) {
    return 2.0 * max(walk_growth(corners.x), max(walk_growth(corners.y), walk_growth(corners.z)));
}

// Where a walk begins: in `at` at level t, with the level planes seen from the front (+1) or from behind (-1).
struct WalkStart {
    float t;
    float front;
    bool on_wall; // on the wall that `at` is turned to
    bool found;
};

// Turns `at` so that the wall `turned` is the one between a and b.
void walk_turn(int turned, inout Standing at) {
    Standing was = at;
    if (turned == EXIT_BC) {
        at.pa = was.pb; at.qa = was.qb; at.pb = was.pc; at.qb = was.qc; at.pc = was.pa; at.qc = was.qa;
        at.uv_a = was.uv_b; at.uv_b = was.uv_c; at.uv_c = was.uv_a;
        at.ab = was.bc; at.bc = was.ca; at.ca = was.ab;
        at.entry = walk_number(was.entry, EXIT_BC);
    } else if (turned == EXIT_CA) {
        at.pa = was.pc; at.qa = was.qc; at.pb = was.pa; at.qb = was.qa; at.pc = was.pb; at.qc = was.qb;
        at.uv_a = was.uv_c; at.uv_b = was.uv_a; at.uv_c = was.uv_b;
        at.ab = was.ca; at.bc = was.ab; at.ca = was.bc;
        at.entry = walk_number(was.entry, EXIT_CA);
    }
}

// Takes the entry at level t, where the ray is inside by the signs of `sides`, if it is the last one before `level`.
void walk_entry(float t, vec2 sides, float handedness, float level, int wall, inout float least, inout int turned,
                inout WalkStart start) {
    float front = sides.x + sides.y < 0.0 ? -1.0 : 1.0;
    float before = front * handedness * (level - t);
    if (sides.x * sides.y >= 0.0 && before >= 0.0 && before < least) {
        least = before;
        turned = wall;
        start = WalkStart(t, front, wall != EXIT_NONE, true);
    }
}

// Takes the entry through the wall `s`, beside walls `i` and `j`, if it lies between the levels of `reach`.
void walk_wall_entry(vec3 s, vec3 i, vec3 j, int wall, float handedness, float level, vec2 reach, inout float least,
                     inout int turned, inout WalkStart start) {
    // The ray reversed leaves where it enters.
    float t = exit_level(s, -handedness);
    if (t > reach.x && t < reach.y) {
        walk_entry(t, vec2(quadratic(i, t), quadratic(j, t)), handedness, level, wall, least, turned, start);
    }
}

// Where the ray enters the prism `at` on its way to `level`, between the levels of `reach`. Not found if it misses it.
WalkStart walk_enter(WalkRay ray, float level, vec2 reach, inout Standing at) {
    WalkStart start = WalkStart(level, 1.0, false, false);
    float least = 1e30;
    int turned = EXIT_NONE;
    for (int end = 0; end < 2; ++end) {
        vec3 weights = walk_weights(at, reach[end]);
        float low = min(weights.x, min(weights.y, weights.z)), high = max(weights.x, max(weights.y, weights.z));
        float front = low >= 0.0 ? 1.0 : -1.0;
        // In at the top where t falls along the ray, at the bottom where it climbs.
        if ((low >= 0.0 || high <= 0.0) && (front * ray.handedness > 0.0) == (end == 0)) {
            walk_entry(reach[end], vec2(front), ray.handedness, level, EXIT_NONE, least, turned, start);
        }
    }
    // Most rays come in so. If one leaves through a wall and comes back through it, the walk finds that.
    if (!start.found) {
        walk_wall_entry(at.bc, at.ca, at.ab, EXIT_BC, ray.handedness, level, reach, least, turned, start);
        walk_wall_entry(at.ca, at.ab, at.bc, EXIT_CA, ray.handedness, level, reach, least, turned, start);
        walk_wall_entry(at.ab, at.bc, at.ca, EXIT_AB, ray.handedness, level, reach, least, turned, start);
        walk_turn(turned, at);
    }
    return start;
}

// The prism in which the ray is where the raster met a lid or base at about `level`, if not in `at`, and how it enters
// that.
WalkStart walk_locate(WalkRay ray, float level, inout Standing at) {
    WalkStart start = WalkStart(level, 1.0, false, false);
    bool looks = true;
    for (int i = 0; i < WALK_LOCATE_HOPS && looks; ++i) {
        // The raster's neighbour may be the ray's own, and the ray may pass all this prism's lid within its growth.
        vec4 range = at.range;
        float margin = walk_margin(at.corners);
        start = walk_enter(ray, level, range.zw + vec2(-margin, margin), at);
        looks = !start.found;
        if (looks) {
            vec3 weights = walk_weights(at, level);
            weights *= weights.x + weights.y + weights.z < 0.0 ? -1.0 : 1.0;
            // Not back over the wall it came by: next to a vertex two prisms may each hold the ray to be in the other, as
            // a slanted lid's level is not quite the ray's. It goes on around the vertex.
            bool over_ab = i == 0 && weights.z < min(weights.x, weights.y);
            int turned = over_ab ? EXIT_AB : weights.x <= weights.y ? EXIT_BC : EXIT_CA;
            uint neighbour = walk_neighbour(at.prism, walk_number(at.entry, turned));
            // Beyond a border there is nothing to begin in: the border's own prism sees the ray come in.
            looks = neighbour != NO_NEIGHBOUR;
            if (looks) {
                walk_over(ray, neighbour, turned, at);
            }
        }
    }
    return start;
}

// Whether the ray, which comes in through a wall, was under the lid or over the base there already; then it stands where
// it came into the prism before.
bool walk_back(WalkRay ray, inout WalkStart start, inout Standing at) {
    uvec3 corners = walk_turned(at.corners.xyz, at.entry);
    vec2 lids = mix(walk_lids(corners.x), walk_lids(corners.y), weight_between(at.pa, at.qa, at.pb, at.qb, start.t));
    uint neighbour = walk_neighbour(at.prism, at.entry);
    if (start.t <= lids.x || start.t >= lids.y || neighbour == NO_NEIGHBOUR) {
        return false;
    }
    walk_over(ray, neighbour, EXIT_AB, at);
    start.front = quadratic(at.bc, start.t) + quadratic(at.ca, start.t) < 0.0 ? -1.0 : 1.0;
    vec4 range = at.range;
    float end = start.front * ray.handedness > 0.0 ? range.z : range.w, back = end;
    int turned = EXIT_NONE;
    walk_exit(at.bc, EXIT_BC, -ray.handedness, start.front, start.t, back, turned);
    walk_exit(at.ca, EXIT_CA, -ray.handedness, start.front, start.t, back, turned);
    walk_exit(at.ab, EXIT_AB, -ray.handedness, start.front, start.t, back, turned);
    start.t = back;
    start.on_wall = turned != EXIT_NONE;
    walk_turn(turned, at);
    return true;
}

// The start of a walk from the lid or base that the raster met in prism `at`, grown to about `level`: where the ray was
// last outside both. A lid is planar between corners at different levels and walls are not, so that the ray may have
// passed under it in a neighbour already: then back through the prisms to where it had not.
WalkStart walk_start(WalkRay ray, float level, inout Standing at) {
    vec4 range = at.range;
    WalkStart start = walk_enter(ray, level, vec2(min(range.z, level), max(range.w, level)), at);
    if (!start.found) {
        start = walk_locate(ray, level, at);
    }
    for (int i = 0; i < WALK_BACK_HOPS && start.on_wall; ++i) {
        if (!walk_back(ray, start, at)) {
            break;
        }
    }
    return start;
}

// Whether a ray that comes in through the wall it stands on was above the surface there.
bool walk_outside(Standing at, MarchSettings settings, uint bits, float t, bool above) {
    uint kind = wall_kind(bits, at.entry);
    if (kind == WALL_SEAM) {
        vec4 uv = walk_neighbour_uv(at.prism, at.entry);
        float w = weight_between(at.pa, at.qa, at.pb, at.qb, t);
        vec2 across = wall_descends(bits, at.entry) ? mix(uv.zw, uv.xy, w) : mix(uv.xy, uv.zw, w);
        return t >= seam_level(settings, wall_field(bits, at.entry), across);
    }
    // A closed border ends at the lowest level; beyond an open one there is nothing to take a step from.
    return kind == WALL_PLAIN ? t >= 0.0 : kind == WALL_CLOSED || above;
}

#ifdef SOFT_SHADOW
// How far along a shadow ray a turned point of `at` is.
float walk_distance(WalkRay ray, Standing at, vec3 lambda, float t) {
    uvec3 corners = walk_turned(at.corners.xyz, at.entry);
    vec3 moved = vec3(0.0);
    for (int k = 0; k < 3; ++k) {
        moved += lambda[k] * (walk_position(corners[k]) - ray.origin + t * walk_shell(corners[k]));
    }
    return dot(moved, cross(ray.x.xyz, ray.y.xyz));
}
#endif

// Leaves the shell from the prism `at` through `turned`, or through an end of its levels.
void walk_leave(Standing at, int turned, float t, float leave, inout WalkTrail trail) {
    vec4 range = at.range;
    bool climbs = leave > t;
    float end = climbs ? max(t, min(leave, range.w)) : min(t, max(leave, range.z));
    trail.prism = at.prism;
    trail.t = end;
    trail.lambda = walk_unturned(walk_lambda(at, end == leave ? turned : EXIT_NONE, end), at.entry);
}

// The first hit from `start` on; `at` ends in its prism. `limit`: prisms after which it gives up. `trail` begins as
// NO_TRAIL.
WalkHit walk(WalkRay ray, MarchSettings settings, inout Standing at, WalkStart start, int limit,
             inout WalkTrail trail) {
    WalkHit hit = WalkHit(false, 0u, 0.0, vec3(0.0), -1, 0);
    float t = start.t, front = start.front;
    int came = start.on_wall ? EXIT_AB : EXIT_NONE;
    bool above = true, fresh = true;
    // The crossing of the field, and the interval in which it lies.
    bool crossed = false, chord = false;
    Found found;
    UvPath path;
    PathEnd entry, end;
    // The ray's height over the field where it came in, if the last prism knows it.
    float clear = 0.0;
    bool clear_known = false;
    bool walks = true;
    do {
        vec4 range = at.range;
#ifdef SOFT_SHADOW
        if (ray.shadow && penumbra.open) {
            range.y += penumbra.headroom;
            range.w = max(range.w, penumbra.highest + penumbra.headroom);
        }
#endif
        walk_pass(at.prism, trail);
        if (!ray.shadow) {
            count_prism();
        }

        float travel = front * ray.handedness, leave = travel * 1e30;
        int turned = EXIT_NONE;
        bool in_level = ray.shadow && walk_in_level(at, t);
        if (in_level) {
            walk_level_exit(ray, at, came == EXIT_AB, t, leave, turned);
            in_level = turned != EXIT_NONE;
        }
        if (in_level) {
            travel = leave < t ? -1.0 : 1.0;
        } else {
            walk_exit(at.bc, EXIT_BC, ray.handedness, front, t, leave, turned);
            walk_exit(at.ca, EXIT_CA, ray.handedness, front, t, leave, turned);
            walk_exit(at.ab, EXIT_AB, ray.handedness, front, t, leave, turned);
        }

        // The part of it within the levels that the prism's surface and steps can have.
        float entry_t = clamp(t, range.x, range.y), leave_t = clamp(leave, range.x, range.y);
        bool passes = entry_t != leave_t || (in_level && entry_t == t);
        if (passes) {
            entry.t = entry_t;
            entry.wall = entry_t == t ? came : EXIT_NONE;
            bool at_origin = in_level && came == EXIT_NONE && entry_t == t;
            entry.lambda = at_origin ? ray.lambda : walk_lambda(at, entry.wall, entry_t);
            entry.uv = entry.lambda.x * at.uv_a + entry.lambda.y * at.uv_b + entry.lambda.z * at.uv_c;
            end.t = leave_t;
            end.wall = leave_t == leave ? turned : EXIT_NONE;
            end.lambda = walk_lambda(at, end.wall, leave_t);
            end.uv = end.lambda.x * at.uv_a + end.lambda.y * at.uv_b + end.lambda.z * at.uv_c;

            uint kind = entry.wall == EXIT_AB ? wall_kind(at.corners.w, at.entry) : WALL_SAME;
            // On a wall where the surface takes a step, or at the start.
            bool steps = entry_t == t && (fresh || kind != WALL_SAME);
            float here = 0.0;
            if (steps || (KEEPS_CLEARANCE && (!clear_known || entry_t != t))) {
                here = surface_level(settings, entry.uv);
                clear = entry_t - here;
            }
            if (entry_t != t) {
                // In through an end of the levels.
                above = travel < 0.0;
            } else if (steps) {
                bool was = above;
                above = t >= here;
                if (fresh && came == EXIT_AB) {
                    was = ray.shadow ? above : walk_outside(at, settings, at.corners.w, t, above);
                }
                if (kind != WALL_SAME && was != above && (was || ray.shadow || wall_behind(at.corners.w, at.entry))) {
                    walks = false;
                    hit = WalkHit(true, at.prism, t, walk_unturned(entry.lambda, at.entry), at.entry, hit.limits);
                }
            }
            if (walks) {
                vec2 ub = at.uv_b - at.uv_a, uc = at.uv_c - at.uv_a;
                path.u = at.ca * ub.x + at.ab * uc.x;
                path.v = at.ca * ub.y + at.ab * uc.y;
                path.w = at.bc + at.ca + at.ab;
                path.origin = at.uv_a;
                chord = in_level || follows_chord(entry_t, leave_t, range.y - range.x);
#ifdef SOFT_SHADOW
                if (ray.shadow && penumbra.open) {
                    float middle_t = 0.5 * (entry_t + leave_t);
                    vec3 middle = chord ? 0.5 * (entry.lambda + end.lambda) : walk_lambda(at, EXIT_NONE, middle_t);
                    penumbra_interval(walk_distance(ray, at, entry.lambda, entry_t),
                                      walk_distance(ray, at, middle, middle_t),
                                      walk_distance(ray, at, end.lambda, leave_t));
                }
#endif
                enter_prism(at.corners.w);
                crossed = crosses(settings, path, entry, end, chord, above, clear, hit.limits, found);
                walks = !crossed;
                clear_known = end.wall != EXIT_NONE;
            }
            if (walks && end.wall != EXIT_NONE) {
                int wall = walk_number(at.entry, end.wall);
                if (steps_out(wall_kind(at.corners.w, wall), above, leave_t, settings.two_sided)) {
                    walks = false;
                    hit = WalkHit(true, at.prism, leave_t, walk_unturned(end.lambda, at.entry), wall, hit.limits);
                }
            }
        } else {
            above = leave == t ? above : t >= range.y;
            clear_known = false;
        }
        if (walks) {
            fresh = fresh && !passes && leave == t;
            bool leaves = turned == EXIT_NONE;
            if (travel > 0.0 ? leave > range.y : leave < range.x) {
                // Past the surface's levels; past the lid or base too where none of this prism's corners has it further
                // out. What the ray meets then it enters anew, through a lid or base.
                above = travel > 0.0;
                if (travel > 0.0 ? leave > range.w : leave < range.z) {
                    float margin = ray.shadow ? 0.0 : walk_margin(at.corners);
                    leaves = leaves || (travel > 0.0 ? leave > range.w + margin : leave < range.z - margin);
                }
            }
            uint neighbour = leaves ? NO_NEIGHBOUR : walk_neighbour(at.prism, walk_number(at.entry, turned));
            walks = neighbour != NO_NEIGHBOUR;
            if (walks) {
                walk_over(ray, neighbour, turned, at);
                t = leave;
                came = EXIT_AB;
                // Around a vertex the two others may disagree by rounding; the larger tells.
                front = quadratic(at.bc, t) + quadratic(at.ca, t) < 0.0 ? -1.0 : 1.0;
            } else {
                walk_leave(at, turned, t, leave, trail);
            }
        }
    } while (walks && --limit > 0);
    hit.limits += walks ? 1 : 0;
    if (crossed) {
        float along = crossing(settings, path, entry, end, chord, above, found);
        hit.hit = true;
        hit.prism = at.prism;
        hit.t = mix(entry.t, end.t, along);
        vec3 lambda = chord ? mix(entry.lambda, end.lambda, along) : walk_lambda(at, EXIT_NONE, hit.t);
        hit.lambda = walk_unturned(lambda, at.entry);
    }
    return hit;
}

#endif
