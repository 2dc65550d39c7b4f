// The hit on a plain triangle: level 0 of a prism without height, decided by the same walls as its neighbours', so that
// it meets them without a crack. The rasteriser, which moves vertices to a grid of its own, would leave one.
//
// Needs shell/prism.glsl. Cost: three cross products.
#ifndef SHELL_PLAIN_GLSL
#define SHELL_PLAIN_GLSL

struct ShellHit {
    bool hit;
    float depth;      // view depth
    float t;          // level
    vec3 lambda;      // barycentric weights
    int wall;         // the wall hit (a step or a closed border), or -1 for the height field itself
    int limits;       // loops that gave up
};

const ShellHit NOTHING = ShellHit(false, 1e30, 0.0, vec3(0.0), -1, 0);

// depth: view depths of the corners. handedness: see prism_trace of shell/march.glsl.
ShellHit plain_trace(ProjectedPrism projected, bool two_sided, vec3 depth, float near, float handedness) {
    vec3 sides, weights;
    for (int k = 0; k < 3; ++k) {
        float canonical = wall_quadratic(projected, k).x;
        float side = canonical != 0.0 ? canonical : side_on_wall(projected, k);
        sides[k] = projected.descending[k] ? -side : side;
        weights[k] = canonical * wall_sign(projected, k);
    }
    bool front = all(greaterThan(sides, vec3(0.0))), back = all(lessThan(sides, vec3(0.0)));
    bool climbs = front == (handedness > 0.0);
    if ((!front && !back) || (climbs && !two_sided)) {
        return NOTHING;
    }
    float sum = weights.x + weights.y + weights.z;
    vec3 lambda = weights / sum;
    float hit_depth = dot(lambda, depth);
    return sum == 0.0 || hit_depth < near ? NOTHING : ShellHit(true, hit_depth, 0.0, lambda, -1, 0);
}

#endif
