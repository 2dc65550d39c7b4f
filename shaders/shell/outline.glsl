// The outline of a prism on screen: the convex hull of its six projected corners, grown by a pixel.
//
// A prism lies in the convex hull of its corners (X is a convex combination of them), so this polygon covers every
// pixel whose centre ray meets it, each once, whichever way the curved walls bulge. The pixel of growth (Minkowski sum
// with a square) covers what the rasteriser's snapping could drop; the fragment clips to the exact prism.
#ifndef SHELL_OUTLINE_GLSL
#define SHELL_OUTLINE_GLSL

const int MAX_OUTLINE = 10; // six hull corners, four more where the growing square turns

struct Outline {
    int count;                // 0: nothing to draw
    vec2 ndc[MAX_OUTLINE];    // counter-clockwise in a y-up plane
    float nearest;            // least view depth of the prism, not below the near plane
};

bool left_turn(vec2 a, vec2 b, vec2 c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x) > 0.0;
}

void compare_swap(inout vec2 a, inout vec2 b) {
    if (b.x < a.x || (b.x == a.x && b.y < a.y)) {
        vec2 c = a;
        a = b;
        b = c;
    }
}

vec2 corner_toward(vec2 direction) {
    return vec2(direction.x < 0.0 ? -1.0 : 1.0, direction.y < 0.0 ? -1.0 : 1.0);
}

void push_outline(inout Outline outline, vec2 at) {
    if (outline.count < MAX_OUTLINE) {
        outline.ndc[outline.count++] = at;
    }
}

// Where a corner is nearer than the near plane: the rectangle around the part beyond it.
Outline near_outline(vec4 corners[6], float near, vec2 grow) {
    Outline outline;
    outline.count = 0;
    outline.nearest = near;
    vec2 low = vec2(1e30), high = vec2(-1e30);
    for (int i = 0; i < 6; ++i) {
        for (int j = i; j < 6; ++j) {
            // Edges of the hull lie among all pairs, so the part beyond the near plane lies within their clipped ends.
            vec4 a = corners[i], b = corners[j];
            if (a.w < near && b.w < near) {
                continue;
            }
            vec4 ends[2] = vec4[2](a, b);
            for (int e = 0; e < 2; ++e) {
                vec4 c = ends[e];
                if (c.w < near) {
                    c = mix(a, b, (near - a.w) / (b.w - a.w));
                }
                vec2 at = c.xy / c.z;
                low = min(low, at);
                high = max(high, at);
            }
        }
    }
    low = max(low - grow, vec2(-1.0));
    high = min(high + grow, vec2(1.0));
    if (all(lessThan(low, high))) {
        outline.count = 4;
        outline.ndc[0] = low;
        outline.ndc[1] = vec2(high.x, low.y);
        outline.ndc[2] = high;
        outline.ndc[3] = vec2(low.x, high.y);
    }
    return outline;
}

// corners: clip x, clip y, clip w and view depth of the six corners. grow: half extents of the growing square in NDC.
Outline prism_outline(vec4 corners[6], float near, vec2 grow) {
    Outline outline;
    outline.count = 0;
    float nearest = corners[0].w, farthest = corners[0].w;
    for (int i = 1; i < 6; ++i) {
        nearest = min(nearest, corners[i].w);
        farthest = max(farthest, corners[i].w);
    }
    if (farthest < near) {
        return outline;
    }
    if (nearest < near) {
        return near_outline(corners, near, grow);
    }
    outline.nearest = nearest;

    vec2 v[6];
    vec2 low = vec2(1e30), high = vec2(-1e30);
    for (int i = 0; i < 6; ++i) {
        v[i] = corners[i].xy / corners[i].z;
        low = min(low, v[i]);
        high = max(high, v[i]);
    }
    if (any(greaterThan(low - grow, vec2(1.0))) || any(lessThan(high + grow, vec2(-1.0)))) {
        return outline;
    }

    if (all(lessThan(high - low, grow))) {
        // Under half a pixel: its corners may coincide, and no hull is tighter than the grown rectangle.
        outline.count = 4;
        outline.ndc[0] = low - grow;
        outline.ndc[1] = vec2(high.x + grow.x, low.y - grow.y);
        outline.ndc[2] = high + grow;
        outline.ndc[3] = vec2(low.x - grow.x, high.y + grow.y);
        return outline;
    }

    // Sorting network of 12 exchanges, then Andrew's monotone chain.
    compare_swap(v[0], v[5]); compare_swap(v[1], v[3]); compare_swap(v[2], v[4]);
    compare_swap(v[1], v[2]); compare_swap(v[3], v[4]);
    compare_swap(v[0], v[3]); compare_swap(v[2], v[5]);
    compare_swap(v[0], v[1]); compare_swap(v[2], v[3]); compare_swap(v[4], v[5]);
    compare_swap(v[1], v[2]); compare_swap(v[3], v[4]);
    vec2 hull[8];
    int n = 0;
    for (int i = 0; i < 6; ++i) {
        while (n >= 2 && !left_turn(hull[n - 2], hull[n - 1], v[i])) {
            --n;
        }
        hull[n++] = v[i];
    }
    int lower = n + 1;
    for (int i = 4; i >= 0; --i) {
        while (n >= lower && !left_turn(hull[n - 2], hull[n - 1], v[i])) {
            --n;
        }
        hull[n++] = v[i];
    }
    --n; // the last equals the first

    for (int i = 0; i < n; ++i) {
        vec2 at = hull[i];
        vec2 incoming = at - hull[(i + n - 1) % n];
        vec2 outgoing = hull[(i + 1) % n] - at;
        // Outward normals of a counter-clockwise hull.
        vec2 first = corner_toward(vec2(incoming.y, -incoming.x));
        vec2 last = corner_toward(vec2(outgoing.y, -outgoing.x));
        push_outline(outline, at + grow * first);
        // Walk the square's corners counter-clockwise from the one to the other.
        for (int turn = 0; turn < 3 && first != last; ++turn) {
            first = vec2(-first.y, first.x);
            push_outline(outline, at + grow * first);
        }
    }
    return outline;
}

#endif
