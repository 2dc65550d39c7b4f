// The search for the height field along a straight ray through a cone map's cones (engine/src/shell/cones.rs says what
// they promise; CONE_RELAXED: relaxed ones).
//
// The includer defines CONE_MAP (√ratio, a sampler2D with the height map's wrap modes) and the height hook over a map.
// Cost: two gathers a step. Where a cone does not reach beyond the ray's bilinear cell, the field along the ray is a
// quadratic up to the cell's border, and its root is the hit: no least step can jump over a crest (Bán et al. 2024). So
// with steps enough a ray through plain cones ends at its first hit, in whatever direction it runs.
#ifndef SHELL_CONE_GLSL
#define SHELL_CONE_GLSL

struct ConeRay {
    ivec2 origin;    // a cell near its start, so that f32 sees small numbers
    vec2 from, way;  // in texels from that cell's first corner, and to the ray's end
    float z, climb;  // height at its start, and to its end
};

struct ConeSettings {
    int refine_steps; // bisections in a relaxed cone, or of what the steps left
    bool two_sided;   // hits from behind count
};

const float CONE_MISS = 2.0;

// From uv `a` to `b`, heights `za` to `zb`.
ConeRay cone_ray(vec2 a, vec2 b, float za, float zb) {
    vec2 size = height_size(), from = a * size - 0.5, low = floor(from);
    return ConeRay(ivec2(low), from - low, (b - a) * size, za, zb - za);
}

float cone_clearance(ConeRay ray, float at) {
    vec2 p = ray.from + at * ray.way, low = floor(p), f = p - low;
    vec4 h = height_cell(ray.origin + ivec2(low));
    return ray.z + at * ray.climb - mix(mix(h.x, h.y, f.x), mix(h.z, h.w, f.x), f.y);
}

// The crossing between two places on its two sides.
float cone_bisected(ConeRay ray, float a, float b, bool above, int steps) {
    float fa = cone_clearance(ray, a), fb = cone_clearance(ray, b);
    for (int i = 0; i < steps; ++i) {
        float m = 0.5 * (a + b), fm = cone_clearance(ray, m);
        if ((fm >= 0.0) == above) {
            a = m;
            fa = fm;
        } else {
            b = m;
            fb = fm;
        }
    }
    return mix(a, b, fa == fb ? 0.5 : clamp(fa / (fa - fb), 0.0, 1.0));
}

// The least s >= 0 at which c.x + c.y s + c.z s², not negative at 0, becomes so; a large number if none.
float cone_root(vec3 c) {
    float discriminant = c.y * c.y - 4.0 * c.x * c.z;
    if (discriminant < 0.0) {
        return 1e30;
    }
    float root = sqrt(discriminant);
    if (c.y < 0.0) {
        return 2.0 * c.x / (root - c.y);
    }
    return c.z < 0.0 ? -(c.y + root) / (2.0 * c.z) : 1e30;
}

// Where along the ray (0 to 1) the field is hit, or CONE_MISS. `above` is where the ray starts and, on return, ends;
// `steps` what is left of them. What the steps do not reach is searched as one piece, and counted in `limits`.
float cone_search(ConeRay ray, ConeSettings settings, inout bool above, inout int steps, inout int limits) {
    vec2 size = height_size();
    float reach = length(ray.way / size); // UV
    // So small a part of a texel that it decides which cell a point on a border is in, and nothing else.
    float nudge = max(1e-4 / max(max(abs(ray.way.x), abs(ray.way.y)), 1e-4), 2e-7);
    float at = 0.0;
    while (at < 1.0) {
        if (steps == 0) {
            ++limits;
            bool ends_above = cone_clearance(ray, 1.0) >= 0.0;
            bool hit = ends_above != above && (above || settings.two_sided);
            float found = hit ? cone_bisected(ray, at, 1.0, above, settings.refine_steps) : CONE_MISS;
            above = ends_above;
            return found;
        }
        --steps;
        vec2 cell = floor(ray.from + (at + nudge) * ray.way), f = ray.from + at * ray.way - cell;
        vec4 h = height_cell(ray.origin + ivec2(cell));
        float twist = h.x - h.y - h.z + h.w;
        vec2 slope = vec2(h.y - h.x + twist * f.y, h.z - h.x + twist * f.x);
        float clearance = ray.z + at * ray.climb - (h.x + (h.y - h.x) * f.x + (h.z - h.x) * f.y + twist * f.x * f.y);
        vec2 walls = (cell + vec2(greaterThan(ray.way, vec2(0.0))) - ray.from) / ray.way;
        float wall = min(abs(ray.way.x) > 0.0 ? walls.x : 1.0, abs(ray.way.y) > 0.0 ? walls.y : 1.0);
        wall = clamp(wall, at + nudge, 1.0);
#ifdef CONE_RELAXED
        bool in_cone = above && ray.climb <= 0.0;
#else
        bool in_cone = above;
#endif
        if (in_cone && clearance > 0.0) {
            vec4 roots = map_cell(CONE_MAP, size, ray.origin + ivec2(cell));
            // Each of the four serves the whole cell.
            float root = max(max(roots.x, roots.y), max(roots.z, roots.w)), ratio = 0.9999 * root * root;
            // Up to the cone's side; a climb steeper than that never meets it.
            float closing = reach - ratio * ray.climb;
            float next = closing * (1.0 - at) > ratio * clearance ? at + ratio * clearance / closing : 1.0;
            if (next > wall) {
#ifdef CONE_RELAXED
                if (cone_clearance(ray, next) < 0.0) {
                    above = false;
                    return cone_bisected(ray, at, next, true, settings.refine_steps);
                }
#endif
                at = next;
                continue;
            }
        }
        float side = above ? 1.0 : -1.0;
        vec3 c = side * vec3(clearance, ray.climb - dot(slope, ray.way), -twist * ray.way.x * ray.way.y);
        float s = c.x < 0.0 ? 0.0 : cone_root(c);
        if (at + s > wall) {
            at = wall;
            continue;
        }
        at += s;
        above = !above;
        if (!above || settings.two_sided) {
            return at;
        }
        // Out of the field, from behind: on from here.
        at += nudge;
    }
    return CONE_MISS;
}

#endif
