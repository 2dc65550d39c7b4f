// One ray in one prism: the projected corners, the three side walls, the intervals inside.
//
// The prism of a triangle is { sum l_k (P_k + t N_k) : l a barycentric triple, t0 <= t <= t1 }. Seen along a ray its
// corners become 2D points p_k + t q_k, with the ray at the origin, and everything about the ray is a polynomial in the
// level t (DESIGN section 4; the same rational path as Ogaki 2023, in the plane across the ray):
//
//     s_k(t) = (p_i + t q_i) x (p_j + t q_j),  (i, j) = (k+1, k+2) mod 3      quadratic, one per side wall
//     l_k(t) = s_k(t) / (s_0 + s_1 + s_2)(t)
//
// Needs nothing but core GLSL. No bindings.
#ifndef SHELL_PRISM_GLSL
#define SHELL_PRISM_GLSL

// The corners of a prism across the ray, and the order in which each wall is evaluated.
struct ProjectedPrism {
    vec2 p[3];
    vec2 q[3];
    // Wall k joins corners (k+1, k+2) mod 3; true where their welded ids are in descending order.
    bvec3 descending;
};

// A quadratic a + b t + c t^2 as (a, b, c).
float quadratic(vec3 coefficients, float t) {
    precise float value = coefficients.x + t * (coefficients.y + t * coefficients.z);
    return value;
}

float cross2(vec2 a, vec2 b) {
    precise float value = a.x * b.y - a.y * b.x;
    return value;
}

// Corner of a point given by its clip coordinates (x, y, w), for the pixel at `ndc`. A direction has w = its own w row.
vec2 across_ray(vec3 clip, vec2 ndc) {
    precise vec2 value = clip.xy - ndc * clip.z;
    return value;
}

// The two corners of wall k in canonical order: lower welded id first. Both prisms at a wall evaluate it in this order
// with the same operations, so they agree on it to the bit and no ray slips between them.
ivec2 wall_corners(ProjectedPrism prism, int k) {
    ivec2 ij = ivec2((k + 1) % 3, (k + 2) % 3);
    return prism.descending[k] ? ij.yx : ij;
}

// (p_i + t q_i) x (p_j + t q_j). Without contraction it is antisymmetric to the bit: the other order of corners gives the
// negated quadratic.
vec3 wall_between(vec2 pi, vec2 qi, vec2 pj, vec2 qj) {
    precise vec3 value = vec3(cross2(pi, pj), cross2(pi, qj) + cross2(qi, pj), cross2(qi, qj));
    return value;
}

// s_k of the wall in canonical order; the prism's own s_k is `wall_sign` times it.
vec3 wall_quadratic(ProjectedPrism prism, int k) {
    ivec2 c = wall_corners(prism, k);
    return wall_between(prism.p[c.x], prism.q[c.x], prism.p[c.y], prism.q[c.y]);
}

// The top-left rule: the side of a ray that lies in wall k, as if it stood a little aside, the same for all walls. Of the
// two prisms at a wall, and of those around a corner, exactly one has the ray; so the level must be the same for all: 0.
float side_on_wall(ProjectedPrism prism, int k) {
    ivec2 c = wall_corners(prism, k);
    vec2 edge = prism.p[c.y] - prism.p[c.x];
    return edge.y > 0.0 || (edge.y == 0.0 && edge.x < 0.0) ? 1.0 : -1.0;
}

float wall_sign(ProjectedPrism prism, int k) {
    return prism.descending[k] ? -1.0 : 1.0;
}

// Where the ray crosses the wall from corner i to corner j at level t: the weight of corner j, in [0, 1]. Well conditioned
// even where s_0 + s_1 + s_2 vanishes (a ray within the level).
float weight_between(vec2 pi, vec2 qi, vec2 pj, vec2 qj, float t) {
    precise vec2 a = pi + t * qi;
    precise vec2 b = pj + t * qj;
    precise vec2 e = b - a;
    precise float weight = -dot(a, e) / max(dot(e, e), 1e-37);
    return clamp(weight, 0.0, 1.0);
}

// The same for wall k: the weight of the second corner of `wall_corners`.
float wall_weight(ProjectedPrism prism, int k, float t) {
    ivec2 c = wall_corners(prism, k);
    return weight_between(prism.p[c.x], prism.q[c.x], prism.p[c.y], prism.q[c.y], t);
}

// Barycentric weights of the point of wall k with weight `w` of its second canonical corner.
vec3 wall_barycentrics(ProjectedPrism prism, int k, float w) {
    ivec2 c = wall_corners(prism, k);
    vec3 lambda = vec3(0.0);
    lambda[c.x] = 1.0 - w;
    lambda[c.y] = w;
    return lambda;
}

// Level ends of the inside intervals: at most six wall roots between the two ends of the prism's range.
const int MAX_CROSSINGS = 8;
const int AT_LEVEL = 3; // not a wall: an end of the range of t

struct Crossings {
    int count;
    float t[MAX_CROSSINGS];  // ascending
    int wall[MAX_CROSSINGS]; // 0..2, or AT_LEVEL
};

void add_crossing(inout Crossings crossings, float t, int wall) {
    int at = crossings.count++;
    for (; at > 0 && crossings.t[at - 1] > t; --at) {
        crossings.t[at] = crossings.t[at - 1];
        crossings.wall[at] = crossings.wall[at - 1];
    }
    crossings.t[at] = t;
    crossings.wall[at] = wall;
}

// p + t q to the last bit, also where the two nearly cancel (TwoProduct and TwoSum: Dekker 1971, Knuth 1969).
vec2 corner_at(vec2 p, vec2 q, float t) {
    precise float split_t = 4097.0 * t;
    precise float t_high = split_t - (split_t - t);
    precise float t_low = t - t_high;
    precise vec2 split_q = 4097.0 * q;
    precise vec2 q_high = split_q - (split_q - q);
    precise vec2 q_low = q - q_high;
    precise vec2 product = t * q;
    precise vec2 product_rest = ((t_high * q_high - product) + t_high * q_low + t_low * q_high) + t_low * q_low;
    precise vec2 sum = p + product;
    precise vec2 part = sum - p;
    precise vec2 sum_rest = (p - (sum - part)) + (product - part);
    precise vec2 value = sum + (sum_rest + product_rest);
    return value;
}

// One Newton step from a root of wall k's quadratic, with a residual from exact corners. Around a vertex a ray crosses
// several walls within a few ulp; with the rounding of their coefficients alone the order of the crossings is random.
float refined_crossing(ProjectedPrism prism, int k, vec3 s, float t) {
    ivec2 c = wall_corners(prism, k);
    precise float slope = s.y + 2.0 * t * s.z;
    precise float residual = cross2(corner_at(prism.p[c.x], prism.q[c.x], t), corner_at(prism.p[c.y], prism.q[c.y], t));
    precise float change = -residual / slope;
    precise float refined = t + change;
    // Elsewhere (a double root, or none of a wall in sight) the residual says nothing.
    return abs(change) <= 1e-3 * abs(t) ? refined : t;
}

// All levels within [t0, t1] at which the line meets the border of the prism, ascending, both ends included. `top`: the
// side of each wall just below t1, as the prism's own sign, never 0; it turns at each crossing of that wall on the way
// down, so the sides cannot contradict the crossings. The line is inside where all three are alike.
Crossings prism_crossings(ProjectedPrism prism, vec3 s[3], float t0, float t1, out vec3 top) {
    Crossings crossings;
    crossings.count = 0;
    add_crossing(crossings, t0, AT_LEVEL);
    add_crossing(crossings, t1, AT_LEVEL);
    for (int k = 0; k < 3; ++k) {
        float a = s[k].x, b = s[k].y, c = s[k].z;
        // The side above all roots.
        float side = c != 0.0 ? sign(c) : b != 0.0 ? sign(b) : a != 0.0 ? sign(a) : side_on_wall(prism, k);
        precise float discriminant = b * b - 4.0 * a * c;
        // The larger root first: no cancellation, and a vanishing c only sends it to infinity. h is 0 only where the
        // two roots are one, which turns nothing.
        precise float h = discriminant < 0.0 ? 0.0 : -0.5 * (b + (b < 0.0 ? -1.0 : 1.0) * sqrt(discriminant));
        for (int root = c == 0.0 ? 1 : 0; root < 2 && h != 0.0; ++root) {
            precise float t = root == 0 ? h / c : a / h;
            t = refined_crossing(prism, k, s[k], t);
            if (t >= t1) {
                side = -side;
            } else if (t > t0) {
                add_crossing(crossings, t, k);
            }
        }
        top[k] = prism.descending[k] ? -side : side;
    }
    return crossings;
}

// A stretch of the line between two neighbouring crossings, in the order in which the ray runs.
struct Stretch {
    bool inside;
    bool front;   // it sees the level planes from the front
    int from, to; // indices of the crossings
};

// The stretch between crossings i and i + 1. From the top down: `sides` are those above it, from `prism_crossings` or the
// stretch before, and become its own. handedness: see prism_trace of shell/march.glsl.
Stretch stretch_below(Crossings crossings, int i, float handedness, inout vec3 sides) {
    int above = crossings.wall[i + 1];
    if (above != AT_LEVEL) {
        sides[above] = -sides[above];
    }
    bool front = all(greaterThan(sides, vec3(0.0))), back = all(lessThan(sides, vec3(0.0)));
    bool climbs = front == (handedness > 0.0);
    return Stretch(front || back, front, climbs ? i : i + 1, climbs ? i + 1 : i);
}

#endif
