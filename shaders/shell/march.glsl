// The search for the height field along the exact curved path of a ray inside one prism.
//
// Needs shell/prism.glsl and the height hook: float height_at(vec2 uv, float lod), vec2 height_gradient(vec2, float).
// MARCH_EXACT (with shell/exact.glsl or shell/exact_procedural.glsl), MARCH_CONE (with shell/cone.glsl), MARCH_NONE or one
// of those of shell/refine.glsl chooses the search. Cost: prism_trace solves three quadratics; each linear step is three
// quadratics, one reciprocal and one height; a cone's step is two gathers.
#ifndef SHELL_MARCH_GLSL
#define SHELL_MARCH_GLSL

#include "shell/plain.glsl"
#include "shell/prism_bits.glsl"
#ifdef SOFT_SHADOW
#include "shell/soft.glsl"
#endif

// Whether the prism at hand has one height all over. Then one step finds all there is.
#ifdef ONE_HEIGHTS
bool one_height = false;
#else
const bool one_height = false;
#endif

void enter_prism(uint bits) {
#ifdef ONE_HEIGHTS
    one_height = has_one_height(bits);
#endif
}

// Everything about one prism that does not depend on the ray.
struct Prism {
    vec2 uv[3];             // height map coordinates of the corners
    vec4 neighbour_uv[3];   // of wall k's canonical corners (first, second), on the other side of the wall
    uint wall[3];           // WALL_*
    uint field[3];          // of the neighbour across wall k: 0 this prism's own, else 1 + its number among the others
    bool behind[3];         // the neighbour's surface is hit from behind too
    float t0, t1;           // range of levels
    bool plain;             // not displaced: the triangle itself, traced so that it meets its neighbours without a crack
};

// How a height in [0, 1] becomes a level, and how hard to look.
struct MarchSettings {
    float scale, midlevel;
    int min_steps, max_steps; // linear steps in one prism: about one a texel of path, between these
    int refine_steps;         // see Refinement
    float tolerance;          // secant: of the height's range
    vec2 map_size;            // texels: height_size()
    bool two_sided;           // hits from behind count
    int step_limit;           // exact: steps in one prism before it gives up, as a multiple of the cells on the way
};

// The path's numerators over their shared denominator, coordinates relative to corner 0.
struct UvPath {
    vec3 u, v, w;
    vec2 origin;
};

UvPath uv_path(Prism prism, vec3 s[3]) {
    vec2 e1 = prism.uv[1] - prism.uv[0], e2 = prism.uv[2] - prism.uv[0];
    return UvPath(s[1] * e1.x + s[2] * e2.x, s[1] * e1.y + s[2] * e2.y, s[0] + s[1] + s[2], prism.uv[0]);
}

vec2 path_uv(UvPath path, float t) {
    return path.origin + vec2(quadratic(path.u, t), quadratic(path.v, t)) / quadratic(path.w, t);
}

float surface_level(MarchSettings settings, vec2 uv) {
#ifdef MARCH_NONE
    return 0.0;
#endif
    return (height_at(uv, 0.0) - settings.midlevel) * settings.scale;
}

#ifdef OTHER_FIELDS
// The includer's: the level of another field's surface.
float other_level(uint other, vec2 uv);
#endif

// The level of the surface beyond a seam; `field` as in Prism.
float seam_level(MarchSettings settings, uint field, vec2 uv) {
#ifdef OTHER_FIELDS
    if (field > 0u) {
        return other_level(field - 1u, uv);
    }
#endif
    return surface_level(settings, uv);
}

// The prism's own coordinates at a point of wall k; canonical order, so that the neighbour without a seam gets the same.
vec2 wall_uv(ProjectedPrism projected, Prism prism, int k, float weight) {
    ivec2 c = wall_corners(projected, k);
    return mix(prism.uv[c.x], prism.uv[c.y], weight);
}

// View depth at (lambda, t): `depth` and `slope` hold the corners' view depths and what the normals add per level.
float depth_at(vec3 lambda, float t, vec3 depth, vec3 slope) {
    return dot(lambda, depth + t * slope);
}

// Barycentric weights at level t, inside.
vec3 path_lambda(vec3 s[3], float t) {
    vec3 weights = vec3(quadratic(s[0], t), quadratic(s[1], t), quadratic(s[2], t));
    return weights / (weights.x + weights.y + weights.z);
}

// Level on the path at which the view depth passes `near`, between an end before it and an end beyond it.
float near_level(vec3 s[3], float before, float beyond, vec3 depth, vec3 slope, float near) {
    for (int i = 0; i < 24; ++i) {
        float t = 0.5 * (before + beyond);
        if (depth_at(path_lambda(s, t), t, depth, slope) < near) {
            before = t;
        } else {
            beyond = t;
        }
    }
    return beyond;
}

// One end of an interval.
struct PathEnd {
    float t;
    int wall;    // 0..2, or AT_LEVEL: the range's end, or the near plane
    vec3 lambda;
    vec2 uv;
};

PathEnd path_end(ProjectedPrism projected, Prism prism, vec3 s[3], float t, int wall) {
    PathEnd end;
    end.t = t;
    end.wall = wall;
    if (wall < 3) {
        float weight = wall_weight(projected, wall, t);
        end.lambda = wall_barycentrics(projected, wall, weight);
        end.uv = wall_uv(projected, prism, wall, weight);
    } else {
        end.lambda = path_lambda(s, t);
        end.uv = end.lambda.x * prism.uv[0] + end.lambda.y * prism.uv[1] + end.lambda.z * prism.uv[2];
    }
    return end;
}

// The level that the neighbour's surface has where the ray crosses wall `end.wall`; `otherwise` where there is none.
float neighbour_level(ProjectedPrism projected, Prism prism, MarchSettings settings, PathEnd end, float otherwise) {
    uint kind = prism.wall[end.wall];
    if (kind == WALL_SEAM) {
        vec4 uv = prism.neighbour_uv[end.wall];
        vec2 at = mix(uv.xy, uv.zw, wall_weight(projected, end.wall, end.t));
        return seam_level(settings, prism.field[end.wall], at);
    }
    return kind == WALL_PLAIN ? 0.0 : otherwise;
}

// A ray nearly within its level: t has too few bits left to tell its points apart, so the path becomes the chord. In a
// level the path is straight, so the chord's error is of the order of the span.
bool follows_chord(float entry, float leave, float thickness) {
    return abs(leave - entry) < 2e-5 * max(max(abs(entry), abs(leave)), thickness);
}

const float NO_HIT = 2.0;

// Control points of a quadratic over [a, b].
vec3 over(vec3 q, float a, float b) {
    return vec3(quadratic(q, a), q.x + 0.5 * q.y * (a + b) + q.z * a * b, quadratic(q, b));
}

#ifdef MARCH_NONE
// No height is looked up: the base surface at level 0, which is what a walk costs at least.
float search_whole(MarchSettings settings, UvPath path, PathEnd entry, PathEnd leave, bool chord, inout bool above,
                   inout int limits) {
    bool falls = above && leave.t < 0.0;
    above = leave.t >= 0.0;
    return falls ? clamp(entry.t / (entry.t - leave.t), 0.0, 1.0) : NO_HIT;
}
#elif defined(MARCH_EXACT)
// The path between two ends as a curve through the map's cells.
Curve path_curve(MarchSettings settings, UvPath path, PathEnd entry, PathEnd leave, bool chord) {
    Curve curve;
    curve.t = vec2(entry.t, leave.t);
    vec2 from = entry.uv * settings.map_size - 0.5;
    curve.origin = ivec2(floor(from));
    vec2 a = from - vec2(curve.origin), b = leave.uv * settings.map_size - 0.5 - vec2(curve.origin);
    if (chord) {
        curve.x = vec3(a.x, 0.5 * (a.x + b.x), b.x);
        curve.y = vec3(a.y, 0.5 * (a.y + b.y), b.y);
        curve.w = vec3(1.0);
        return curve;
    }
    vec3 w = over(path.w, entry.t, leave.t);
    float unit = 1.0 / max(max(abs(w.x), abs(w.y)), max(abs(w.z), 1e-37));
    curve.w = unit * w;
    vec2 corner = path.origin * settings.map_size - 0.5 - vec2(curve.origin);
    curve.x = unit * settings.map_size.x * over(path.u, entry.t, leave.t) + corner.x * curve.w;
    curve.y = unit * settings.map_size.y * over(path.v, entry.t, leave.t) + corner.y * curve.w;
    // The ends are known better from the walls, also where the denominator nearly vanishes.
    curve.x.xz = vec2(a.x, b.x) * curve.w.xz;
    curve.y.xz = vec2(a.y, b.y) * curve.w.xz;
    return curve;
}

// Where along the interval (0 to 1) the field is hit, or NO_HIT; `above` is where the ray starts and, on return, ends.
float search_whole(MarchSettings settings, UvPath path, PathEnd entry, PathEnd leave, bool chord, inout bool above,
                   inout int limits) {
    Curve curve = path_curve(settings, path, entry, leave, chord);
    Field field = Field(settings.scale, settings.midlevel, above ? 1.0 : -1.0, settings.two_sided);
    vec2 cells = abs(leave.uv - entry.uv) * settings.map_size;
    int limit = settings.step_limit * (16 + int(min(cells.x + cells.y, 1e5)));
    float hit = exact_hit(curve, field, limit);
    limits += limit == 0 ? 1 : 0;
    above = field.side > 0.0;
    return hit;
}
#elif defined(MARCH_CONE)
// Cones take the ray as straight in (uv, t). The path is cut until no piece strays farther than this from its chord, in
// texels, or is 1/64 of the interval.
const float MOST_BEND = 0.125;
const float LEAST_PIECE = 1.0 / 64.0;

// How far uv(t), in texels, strays from its chord between levels a and b. Both, over the path's denominator, are cubics
// in Bernstein form that agree at the ends; of what is left between, no weight is over 3/4.
float path_bend(MarchSettings settings, UvPath path, float a, float b) {
    vec3 w = over(path.w, a, b), u = over(path.u, a, b), v = over(path.v, a, b);
    float least = w.y * w.x > 0.0 && w.y * w.z > 0.0 ? min(abs(w.x), min(abs(w.y), abs(w.z))) : 0.0;
    vec2 from = vec2(u.x, v.x) / w.x, chord = vec2(u.z, v.z) / w.z - from;
    vec2 middle = vec2(u.y, v.y) - w.y * from;
    vec2 first = (2.0 * middle - w.x * chord) / 3.0, second = (2.0 * (middle - w.y * chord) + w.z * chord) / 3.0;
    return 0.75 * max(length(first * settings.map_size), length(second * settings.map_size)) / max(least, 1e-37);
}

// Where along the interval (0 to 1) the field is hit, or NO_HIT; `above` is where the ray starts and, on return, ends.
float search_whole(MarchSettings settings, UvPath path, PathEnd entry, PathEnd leave, bool chord, inout bool above,
                   inout int limits) {
    ConeSettings cones = ConeSettings(settings.refine_steps, settings.two_sided);
    int steps = settings.max_steps;
    float from = 0.0, piece = 1.0, inverse = 1.0 / settings.scale;
    vec2 uv = entry.uv;
    while (from < 1.0) {
        float to = min(from + piece, 1.0);
        float a = mix(entry.t, leave.t, from), b = mix(entry.t, leave.t, to);
        if (!chord && piece > LEAST_PIECE && path_bend(settings, path, a, b) > MOST_BEND) {
            piece *= 0.5;
            continue;
        }
        vec2 end = to < 1.0 ? path_uv(path, b) : leave.uv;
        ConeRay ray = cone_ray(uv, end, a * inverse + settings.midlevel, b * inverse + settings.midlevel);
        float hit = cone_search(ray, cones, above, steps, limits);
        if (hit <= 1.0) {
            return mix(from, to, hit);
        }
        from = to;
        uv = end;
    }
    return NO_HIT;
}
#else
#define MARCH_SAMPLES
struct SearchPath {
    MarchSettings settings;
    UvPath path;
    PathEnd entry, leave;
    bool chord;
};

float clearance(SearchPath on, float along) {
    float t = mix(on.entry.t, on.leave.t, along);
    return t - surface_level(on.settings, on.chord ? mix(on.entry.uv, on.leave.uv, along) : path_uv(on.path, t));
}

#include "shell/refine.glsl"
#endif

// A search comes in two parts, so that rays that cross the field in different prisms, or after different numbers of
// steps, are refined at once where they run side by side.
#ifdef MARCH_SAMPLES
#define Found Bracket
const bool KEEPS_CLEARANCE = true;

// Whether the interval crosses the field, and between which samples. `above` is where the ray starts and, on return,
// ends: for a crossing, before it. `clear`: the ray's height over the field at the entry; on return, at the end. Only
// where KEEPS_CLEARANCE.
bool crosses(MarchSettings settings, UvPath path, PathEnd entry, PathEnd leave, bool chord, inout bool above,
             inout float clear, inout int limits, out Found x) {
    float texels = length((leave.uv - entry.uv) * settings.map_size);
    int steps = one_height ? 1 : clamp(int(ceil(min(texels, 1e6))), settings.min_steps, settings.max_steps);
    int count = sample_count(steps);
    float start = search_start();
    bool found = false;
    x.a = 0.0;
    x.fa = clear;
    int i = 0;
    do {
        x.b = sample_at(++i, steps, start);
        // The end is known better from its wall, and the same for the neighbour.
        bool last = i == count;
        float t = last ? leave.t : mix(entry.t, leave.t, x.b);
        vec2 uv = last ? leave.uv : chord ? mix(entry.uv, leave.uv, x.b) : path_uv(path, t);
        x.fb = t - surface_level(settings, uv);
#ifdef SOFT_SHADOW
        penumbra_see(above ? x.fb : -x.fb, penumbra_distance(x.b));
#endif
        bool through = (x.fb >= 0.0) != above;
        found = through && (above || settings.two_sided);
        above = above || (through && !found);
        x.a = found ? x.a : x.b;
        x.fa = found ? x.fa : x.fb;
    } while (!found && i < count);
    clear = x.fb;
    return found;
}

// Where along the interval (0 to 1) that crossing lies.
float crossing(MarchSettings settings, UvPath path, PathEnd entry, PathEnd leave, bool chord, bool above, Found x) {
    if (one_height) {
        return chord_root(x);
    }
    Refinement by = Refinement(settings.refine_steps, settings.tolerance * settings.scale);
    return refined(SearchPath(settings, path, entry, leave, chord), by, x, above);
}
#else
#define Found float
const bool KEEPS_CLEARANCE = false;

bool crosses(MarchSettings settings, UvPath path, PathEnd entry, PathEnd leave, bool chord, inout bool above,
             inout float clear, inout int limits, out Found along) {
    if (one_height) {
        float here = surface_level(settings, entry.uv), span = entry.t - leave.t;
        bool was = above;
        above = leave.t >= here;
        along = span != 0.0 ? clamp((entry.t - here) / span, 0.0, 1.0) : 0.0;
        return was != above && (was || settings.two_sided);
    }
    along = search_whole(settings, path, entry, leave, chord, above, limits);
    return along <= 1.0;
}

float crossing(MarchSettings settings, UvPath path, PathEnd entry, PathEnd leave, bool chord, bool above, Found along) {
    return along;
}
#endif

// Both in one: where along the interval (0 to 1) the field is hit, or NO_HIT.
float search(MarchSettings settings, UvPath path, PathEnd entry, PathEnd leave, bool chord, inout bool above,
             inout int limits) {
    float clear = KEEPS_CLEARANCE ? entry.t - surface_level(settings, entry.uv) : 0.0;
    Found found;
    if (crosses(settings, path, entry, leave, chord, above, clear, limits, found)) {
        return crossing(settings, path, entry, leave, chord, above, found);
    }
    return NO_HIT;
}

// Whether a ray that leaves through a wall at level t hits the step there, of those whose far side is no prism: the plain
// neighbour's, and from behind the closed border too.
bool steps_out(uint kind, bool above, float t, bool two_sided) {
    return above ? kind == WALL_PLAIN && t < 0.0
                 : two_sided && (kind == WALL_CLOSED || (kind == WALL_PLAIN && t >= 0.0));
}

// The first hit in one interval, from `entry` to `leave`: where along it (0 to 1), or NO_HIT. `wall` is the wall hit, or
// -1 for the field.
float march_interval(ProjectedPrism projected, Prism prism, MarchSettings settings, UvPath path, PathEnd entry,
                     PathEnd leave, bool chord, out int wall, inout int limits) {
    wall = -1;
    bool above = entry.t >= surface_level(settings, entry.uv);
#ifndef NO_STEPS
    if (entry.wall < 3 && prism.wall[entry.wall] != WALL_SAME) {
        // A step between the neighbour's surface and ours: hit from above theirs to below ours, or, where theirs is hit
        // from behind too, from below theirs to above ours. Beyond an open border there is nothing; a closed one is a
        // step down to the lowest level.
        uint kind = prism.wall[entry.wall];
        float outside = kind == WALL_CLOSED ? prism.t0 : 1e30;
        float there = neighbour_level(projected, prism, settings, entry, outside);
        bool from_behind = prism.behind[entry.wall] && (kind == WALL_SEAM || kind == WALL_PLAIN);
        if (above ? from_behind && entry.t < there : entry.t >= there) {
            wall = entry.wall;
            return 0.0;
        }
    }
#endif
    float along = search(settings, path, entry, leave, chord, above, limits);
    if (along > 1.0 && leave.wall < 3) {
        if (above && leave.t < surface_level(settings, leave.uv)) {
            // The neighbour will find the ray below, by these same operations: the hit is ours, however late.
            return 1.0;
        }
#ifndef NO_STEPS
        if (steps_out(prism.wall[leave.wall], above, leave.t, settings.two_sided)) {
            wall = leave.wall;
            return 1.0;
        }
#endif
    }
    return along;
}

// The first hit of the pixel's ray in a prism, beyond the near plane.
// handedness: sign of det of the linear x, y, w rows (x, y, view depth when orthographic) of mesh to clip: t climbs
// away from the eye where handedness * (s_0 + s_1 + s_2) > 0.
ShellHit prism_trace(ProjectedPrism projected, Prism prism, MarchSettings settings, vec3 depth, vec3 slope, float near,
                     float handedness) {
    if (prism.plain) {
        return plain_trace(projected, settings.two_sided, depth, near, handedness);
    }
    vec3 canonical[3], s[3];
    for (int k = 0; k < 3; ++k) {
        canonical[k] = wall_quadratic(projected, k);
        s[k] = canonical[k] * wall_sign(projected, k);
    }
    vec3 sides;
    Crossings crossings = prism_crossings(projected, canonical, prism.t0, prism.t1, sides);
    UvPath path = uv_path(prism, s);
    ShellHit best = NOTHING;
    int limits = 0;
    for (int i = crossings.count - 2; i >= 0; --i) {
        Stretch stretch = stretch_below(crossings, i, handedness, sides);
        if (!stretch.inside) {
            continue;
        }
        PathEnd entry = path_end(projected, prism, s, crossings.t[stretch.from], crossings.wall[stretch.from]);
        PathEnd leave = path_end(projected, prism, s, crossings.t[stretch.to], crossings.wall[stretch.to]);
        float entry_depth = depth_at(entry.lambda, entry.t, depth, slope);
        float leave_depth = depth_at(leave.lambda, leave.t, depth, slope);
        if (leave_depth < near || entry_depth >= best.depth) {
            continue;
        }
        if (entry_depth < near) {
            entry = path_end(projected, prism, s, near_level(s, entry.t, leave.t, depth, slope, near), AT_LEVEL);
        }
        bool chord = follows_chord(entry.t, leave.t, prism.t1 - prism.t0);
#ifdef SOFT_SHADOW
        if (penumbra.open) {
            float middle_t = 0.5 * (entry.t + leave.t);
            vec3 middle = chord ? 0.5 * (entry.lambda + leave.lambda) : path_lambda(s, middle_t);
            penumbra_interval(depth_at(entry.lambda, entry.t, depth, slope), depth_at(middle, middle_t, depth, slope),
                              leave_depth);
        }
#endif
        int wall;
        float along = march_interval(projected, prism, settings, path, entry, leave, chord, wall, limits);
        if (along > 1.0) {
            continue;
        }
        float t = mix(entry.t, leave.t, along);
        vec3 lambda;
        if (wall >= 0) {
            lambda = along == 0.0 ? entry.lambda : leave.lambda;
        } else if (chord) {
            lambda = mix(entry.lambda, leave.lambda, along);
        } else {
            lambda = path_lambda(s, t);
        }
        float hit_depth = depth_at(lambda, t, depth, slope);
        if (hit_depth < best.depth) {
            best = ShellHit(true, hit_depth, t, lambda, wall, 0);
        }
    }
    best.limits = limits;
    return best;
}

#endif
