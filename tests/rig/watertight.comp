#version 460
#extension GL_GOOGLE_include_directive : require
// Rays aimed at the shared walls and vertices of a closed mesh, each through every prism it could meet; see
// tests/watertight.rs. The surface is convex, or nearly flat along the ray, so that each ray has exactly one hit.
layout(local_size_x = 64) in;

struct CornerData {
    vec4 position; // w: u
    vec4 normal;   // w: v
};

struct PrismData {
    uvec4 corners; // w: bit k where the welded ids of wall k descend
    vec4 range;    // t0, t1; least base and greatest lid of its corners
    vec4 bounds;   // a sphere around it and its lid
};

layout(std430, set = 0, binding = 0) readonly buffer Corners { CornerData item[]; } corners;
layout(std430, set = 0, binding = 1) readonly buffer Prisms { PrismData item[]; } prisms;
layout(std430, set = 0, binding = 2) readonly buffer Edges { uvec2 item[]; } edges;

#ifdef WALK
layout(std430, set = 0, binding = 4) readonly buffer Adjacency { uint item[]; } adjacency;
layout(std430, set = 0, binding = 5) readonly buffer Lids { vec2 item[]; } lids;
#endif

const uint TARGETS = 3u, VIEWS = 4u;
const uint LOGGED = 32u;
layout(std430, set = 0, binding = 3) buffer Results {
    uint rays[TARGETS * VIEWS], misses[TARGETS * VIEWS], doubles[TARGETS * VIEWS];
    uint astray;   // hits that are not on the surface, NaN among them
    uint limits;   // loops that gave up
    uint overflow; // rays that could meet more prisms than MAX_CANDIDATES
    uint twice;    // rays with a hit that two prisms report, on a rugged surface
    uint bad;      // misses and doubles
    uint log[2u * LOGGED]; // of the first: ray and hits
} results;

layout(push_constant) uniform Block {
    uint first, end; // rays
    uint seed;
    uint corner_count, prism_count, edge_count;
    float size;   // of the mesh: its radius
    float inner;  // every ray comes this near to the middle
    float scale;  // of the height
    float t0, t1; // levels that rays are aimed at, apart from the surface's
    float map_size;
};

const float MIDLEVEL = 0.5;

#ifdef RUGGED
float texel(ivec2 at) {
    uint n = uint(at.x) * 1597334677u ^ uint(at.y) * 3812015801u;
    n = (n ^ n >> 15) * 2654435769u;
    return 0.7 + 0.1 * float(n >> 8) / 16777216.0;
}
vec4 height_cell(ivec2 cell) {
    return vec4(texel(cell), texel(cell + ivec2(1, 0)), texel(cell + ivec2(0, 1)), texel(cell + ivec2(1, 1)));
}
vec2 height_bounds(ivec2 first, ivec2 last) {
    return vec2(0.7, 0.8);
}
#else
vec4 height_cell(ivec2 cell) {
    return vec4(0.75);
}
vec2 height_bounds(ivec2 first, ivec2 last) {
    return vec2(0.75);
}
#endif

float height_at(vec2 uv, float lod) {
    vec2 at = uv * map_size - 0.5, low = floor(at), f = at - low;
    vec4 h = height_cell(ivec2(low));
    return mix(mix(h.x, h.y, f.x), mix(h.z, h.w, f.x), f.y);
}

vec2 height_gradient(vec2 uv, float lod) {
    return vec2(0.0); // nothing is shaded
}

#include "shell/prism.glsl"
#ifdef MARCH_EXACT
#include "shell/exact.glsl"
#endif
#include "shell/march.glsl"
#ifdef WALK
#include "tests/watertight_walk.glsl"
#endif

// PCG (O'Neill 2014; the 32-bit permutation as in Jarzynski and Olano 2020).
uint random_state;

uint random_word() {
    random_state = random_state * 747796405u + 2891336453u;
    uint word = ((random_state >> ((random_state >> 28) + 4u)) ^ random_state) * 277803737u;
    return word >> 22 ^ word;
}

float random() {
    return float(random_word() >> 8) / 16777216.0;
}

uint random_below(uint n) {
    return min(uint(random() * float(n)), n - 1u);
}

vec3 random_direction() {
    float z = 2.0 * random() - 1.0, angle = 6.2831853 * random();
    return vec3(sqrt(max(1.0 - z * z, 0.0)) * vec2(cos(angle), sin(angle)), z);
}

// What a ray is aimed at: a point of the wall over the edge (a, b), or of the line over a vertex (a = b).
const uint TARGET_WALL = 0u;
const uint TARGET_MIDDLE = 1u; // of an edge of the surface
const uint TARGET_VERTEX = 2u;

struct Target {
    uint a, b;
    float weight; // of b
    float level;
};

vec3 wall_point(uint a, uint b, float weight, float level) {
    vec3 from = corners.item[a].position.xyz + level * corners.item[a].normal.xyz;
    vec3 to = corners.item[b].position.xyz + level * corners.item[b].normal.xyz;
    return from + weight * (to - from);
}

Target random_target(uint kind, MarchSettings settings) {
    Target aim;
    uvec2 edge = edges.item[random_below(edge_count)];
    aim.a = edge.x;
    aim.b = edge.y;
    aim.weight = kind == TARGET_MIDDLE ? 0.5 : random();
    if (kind == TARGET_VERTEX) {
        aim.a = aim.b = random_below(corner_count);
        aim.weight = 0.0;
    }
    vec2 uv_a = vec2(corners.item[aim.a].position.w, corners.item[aim.a].normal.w);
    vec2 uv_b = vec2(corners.item[aim.b].position.w, corners.item[aim.b].normal.w);
    float surface = surface_level(settings, mix(uv_a, uv_b, aim.weight));
    bool elsewhere = kind != TARGET_MIDDLE && random() < 0.5;
    aim.level = elsewhere ? mix(t0, t1, random()) : surface;
    return aim;
}

// A ray as rows over mesh space: clip = rows * (point - origin), and the ray is where clip.xy = ndc * clip.z.
struct View {
    vec4 x, y, w;
    vec3 origin;
    vec2 ndc;
};

const uint VIEW_PIXEL = 0u; // a pixel of a camera, by its clip coordinates
const uint VIEW_RAY = 1u;   // origin and direction, by two unit vectors across
const uint VIEW_ALONG = 2u; // the same, within the wall or along the vertex line
const uint VIEW_AXIS = 3u;  // parallel to an axis or a diagonal, without any rounding on a mesh of few bits

// To the ray through `at` with direction `d`.
View ray_view(vec3 at, vec3 d, float distance) {
    View view;
    vec3 e0 = normalize(cross(d, random_direction())), e1 = cross(d, e0);
    view.x = vec4(random() < 0.5 ? e0 : -e0, 0.0); // either handedness
    view.y = vec4(e1, 0.0);
    view.w = vec4(d, 0.0);
    view.origin = at - distance * d;
    view.ndc = vec2(0.0);
    return view;
}

// A camera at `eye` that does not quite look at the middle; the ray of the point `at`, wherever between pixel centres.
View pixel_view(vec3 at, vec3 eye) {
    View view;
    vec3 forward = normalize(0.3 * size * random_direction() - eye);
    vec3 right = normalize(cross(forward, random_direction())), up = cross(right, forward);
    float zoom = length(eye) / size;
    right *= random() < 0.5 ? zoom : -zoom;
    up *= zoom;
    view.x = vec4(right, -dot(right, eye));
    view.y = vec4(up, -dot(up, eye));
    view.w = vec4(forward, -dot(forward, eye));
    view.origin = vec3(0.0);
    vec3 clip = vec3(dot(right, at) + view.x.w, dot(up, at) + view.y.w, dot(forward, at) + view.w.w);
    view.ndc = clip.xy / clip.z;
    return view;
}

// Components -1, 0 and 1, not all 0.
ivec3 random_axis() {
    int n = int(random_below(26u));
    n += n >= 13 ? 1 : 0;
    return ivec3(n % 3, n / 3 % 3, n / 9) - 1;
}

// Two integer vectors across the axis, not of unit length.
View axis_view(vec3 at, ivec3 axis) {
    ivec3 e0 = axis.x != 0 && axis.y != 0 ? ivec3(axis.y, -axis.x, 0)
             : axis.x == 0                ? ivec3(1, 0, 0)
                                          : ivec3(0, 1, 0);
    vec3 d = vec3(axis), across = vec3(e0), up = cross(d, across);
    View view;
    view.x = vec4(across, -dot(across, at));
    view.y = vec4(up, -dot(up, at));
    view.w = vec4(d, 8.0 * size);
    view.origin = vec3(0.0);
    view.ndc = vec2(0.0);
    return view;
}

// Toward the side of the target that it can be seen from, and so near to the middle that nothing is grazed.
bool serves(vec3 at, vec3 d) {
    float along = dot(at, d);
    vec3 nearest = at - along * d;
    return along < 0.0 && dot(nearest, nearest) < inner * inner;
}

View random_view(uint kind, Target aim) {
    vec3 at = wall_point(aim.a, aim.b, aim.weight, aim.level);
    float distance = size * 2.0 * exp2(random() * 8.97); // 2 to 1000
    if (kind == VIEW_ALONG) {
        // Half of them run along a straight line of the wall, the others cross its curve at a small angle.
        float weight = random() < 0.5 ? aim.weight : clamp(aim.weight + 0.2 * (random() - 0.5), 0.0, 1.0);
        vec3 d = normalize(wall_point(aim.a, aim.b, weight, aim.level - 0.25 * size) - at);
        return ray_view(at, serves(at, d) ? d : normalize(-at), distance);
    }
    if (kind == VIEW_AXIS) {
        for (int i = 0; i < 16; ++i) {
            ivec3 axis = random_axis();
            if (serves(at, normalize(vec3(axis)))) {
                return axis_view(at, axis);
            }
        }
    }
    vec3 eye = distance * normalize(at);
    for (int i = 0; i < 16; ++i) {
        vec3 other = distance * random_direction();
        if (serves(at, normalize(at - other))) {
            eye = other;
            break;
        }
    }
    return kind == VIEW_PIXEL ? pixel_view(at, eye) : ray_view(at, normalize(at - eye), length(at - eye));
}

vec3 clip_point(View view, vec3 point) {
    vec3 from = point - view.origin;
    precise vec3 clip =
        vec3(dot(view.x.xyz, from) + view.x.w, dot(view.y.xyz, from) + view.y.w, dot(view.w.xyz, from) + view.w.w);
    return clip;
}

vec3 clip_direction(View view, vec3 d) {
    precise vec3 clip = vec3(dot(view.x.xyz, d), dot(view.y.xyz, d), dot(view.w.xyz, d));
    return clip;
}

const int MAX_CANDIDATES = 64;

// Prisms whose sphere the line meets.
int candidates(View view, out uint found[MAX_CANDIDATES]) {
    vec3 x = view.x.xyz - view.ndc.x * view.w.xyz, y = view.y.xyz - view.ndc.y * view.w.xyz;
    vec2 stretch = 1.01 * vec2(length(x), length(y));
    int count = 0;
    for (uint i = 0u; i < prism_count; ++i) {
        vec4 bounds = prisms.item[i].bounds;
        vec2 middle = abs(across_ray(clip_point(view, bounds.xyz), view.ndc));
        if (all(lessThanEqual(middle, stretch * bounds.w))) {
            if (count == MAX_CANDIDATES) {
                atomicAdd(results.overflow, 1u);
                break;
            }
            found[count++] = i;
        }
    }
    return count;
}

ShellHit trace(View view, uint index, MarchSettings settings) {
    PrismData data = prisms.item[index];
    ProjectedPrism projected;
    Prism prism;
    vec3 depth, slope;
    for (int k = 0; k < 3; ++k) {
        CornerData corner = corners.item[data.corners[k]];
        vec3 p = clip_point(view, corner.position.xyz), q = clip_direction(view, corner.normal.xyz);
        projected.p[k] = across_ray(p, view.ndc);
        projected.q[k] = across_ray(q, view.ndc);
        projected.descending[k] = bitfieldExtract(data.corners.w, k, 1) != 0u;
        prism.uv[k] = vec2(corner.position.w, corner.normal.w);
        prism.neighbour_uv[k] = vec4(0.0);
        prism.wall[k] = WALL_SAME;
        prism.field[k] = 0u;
        prism.behind[k] = false;
        depth[k] = p.z;
        slope[k] = q.z;
    }
    prism.t0 = data.range.x;
    prism.t1 = data.range.y;
    prism.plain = false;
    float handedness = dot(cross(view.x.xyz, view.y.xyz), view.w.xyz) < 0.0 ? -1.0 : 1.0;
    return prism_trace(projected, prism, settings, depth, slope, 1e-3 * size, handedness);
}

bool on_surface(ShellHit hit) {
    const vec2 levels =
#ifdef RUGGED
        vec2(0.7, 0.8);
#else
        vec2(0.75);
#endif
    vec2 between = (levels - MIDLEVEL) * scale + 1e-4 * size * vec2(-1.0, 1.0);
    bool level = hit.t > between.x && hit.t < between.y && hit.wall < 0;
    bool inside = all(greaterThan(hit.lambda, vec3(-0.01))) && all(lessThan(hit.lambda, vec3(1.01)));
    return level && inside && hit.depth > 0.0 && hit.depth < 1e4 * size;
}

void main() {
    uint ray = first + gl_GlobalInvocationID.x;
    if (ray >= end) {
        return;
    }
    MarchSettings settings;
    settings.scale = scale;
    settings.midlevel = MIDLEVEL;
    settings.min_steps = 4;
    settings.max_steps = 64;
    settings.refine_steps = 4;
    settings.tolerance = 0.01;
    settings.map_size = vec2(map_size);
    settings.two_sided = false;
    settings.step_limit = 16;

    random_state = ray;
    random_state = random_word() ^ seed;
    uint kind = ray % (TARGETS * VIEWS);
    Target aim = random_target(kind / VIEWS, settings);
    View view = random_view(kind % VIEWS, aim);

    uint found[MAX_CANDIDATES];
    int count = candidates(view, found);
    uint hits = 0u;
#ifdef WALK
    walk_origin = view.origin;
    walk_pixel = 1e-3 * size;
    float handedness = dot(cross(view.x.xyz, view.y.xyz), view.w.xyz) < 0.0 ? -1.0 : 1.0;
    WalkRay walked = pixel_ray(view.x, view.y, view.w, view.ndc, handedness);
    for (int i = 0; i < count; ++i) {
        // A lid that the raster might show here, to within its grid: near a wall, now and then, the neighbour's.
        Standing at = walk_stand(walked, found[i], 2);
        uvec3 named = walk_corners(found[i]).xyz;
        vec3 levels = vec3(walk_lids(named.x).y, walk_lids(named.y).y, walk_lids(named.z).y) + walk_pixel;
        vec2 a = at.pa + levels.x * at.qa, b = at.pb + levels.y * at.qb, c = at.pc + levels.z * at.qc;
        vec3 weights = -walked.handedness * vec3(cross2(b, c), cross2(c, a), cross2(a, b));
        float sum = weights.x + weights.y + weights.z, least = min(weights.x, min(weights.y, weights.z));
        if (sum <= 0.0 || least < -1e-3 * sum) {
            continue;
        }
        float level = dot(weights, levels) / sum;
        if (least < 1e-2 * sum && random() < 0.5) {
            int wall = weights.x == least ? 0 : weights.y == least ? 1 : 2;
            at = walk_stand(walked, walk_neighbour(found[i], wall) >> 2, 2);
        }
        WalkStart start = walk_start(walked, level, at);
        if (!start.found) {
            continue;
        }
        WalkTrail trail = NO_TRAIL;
        WalkHit hit = walk(walked, settings, at, start, 64 + 2 * int(prism_count), trail);
        if (hit.limits > 0) {
            atomicAdd(results.limits, 1u);
        }
        if (hit.hit) {
            hits = 1u;
            if (!walk_true(walked, settings, hit, view.w)) {
                atomicAdd(results.astray, 1u);
            }
        }
    }
#else
    float near = 1e30, far = 0.0;
    for (int i = 0; i < count; ++i) {
        ShellHit hit = trace(view, found[i], settings);
        if (hit.hit) {
            ++hits;
            near = min(near, hit.depth);
            far = max(far, hit.depth);
            if (!on_surface(hit)) {
                atomicAdd(results.astray, 1u);
            }
        }
        if (hit.limits > 0) {
            atomicAdd(results.limits, 1u);
        }
    }
#ifdef RUGGED
    // What its own polynomial finds at a prism's very end, the next may find at its start: one point, seen twice.
    if (hits > 1u && far - near < 1e-3 * size) {
        atomicAdd(results.twice, 1u);
        hits = 1u;
    }
#endif
#endif
    atomicAdd(results.rays[kind], 1u);
    if (hits == 0u) {
        atomicAdd(results.misses[kind], 1u);
    } else if (hits > 1u) {
        atomicAdd(results.doubles[kind], 1u);
    }
    if (hits != 1u) {
        uint at = atomicAdd(results.bad, 1u);
        if (at < LOGGED) {
            results.log[2u * at] = ray;
            results.log[2u * at + 1u] = hits;
        }
    }
}
