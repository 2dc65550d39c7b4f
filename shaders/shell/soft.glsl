// Soft shadows: how much of a round light a point sees, by the least clearance along one ray (Quilez, "Soft shadows in
// raymarched SDFs", 2010; there a distance field's, here that of a height field).
//
// The light is a disc, whose angular radius has the tangent `softness`. The ray runs toward its upper limb,
//
//     x + s (toward + tilt * lift),        toward unit, lift the unit shell normal at the start
//
// and stays c(s) levels clear of the surface. Along lift the disc is 2 tilt s wide there, of which the surface covers
// what is below: so the least q = c / min(2 tilt s, headroom) over the way says what is seen. A hit is q = 0, all dark;
// where q = 1 all of the disc is seen; between, the share of a disc that a level edge leaves, with q of its diameter above
// it. tilt is softness over the cosine of the light's height, as a level's clearance is longer than the one across the
// ray by that; but no more than takes the lower limb of a high light halfway down to the horizon.
//
// Above a shell's lid nothing is known but that nothing is there, and prisms are followed for `headroom` levels above it
// alone: no wider is the disc taken to be, so that the penumbra does not end where the walk does.
//
// The state of the ray under way is global, so that the searches are called alike with it and without.
#ifndef SHELL_SOFT_GLSL
#define SHELL_SOFT_GLSL

struct Penumbra {
    bool open;      // the ray under way is measured
    float spread;   // width of the disc for each unit of distance
    float headroom; // levels
    float highest;  // level that no surface rises above
    float reach;    // distance of the light
    float rounding; // of levels: next to the start there is nothing else
    float least;    // q, of what was met so far
    vec3 distance;  // polynomial: along the way, over an interval that is searched from 0 to 1
};

// sine: of the light's height over the level.
float penumbra_tilt(float softness, float sine) {
    return min(softness * inversesqrt(max(1.0 - sine * sine, 1e-12)), max(softness, 0.5 * sine));
}

Penumbra penumbra = Penumbra(false, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, vec3(0.0));

// Distances at the ends and in the middle of an interval that is searched next.
void penumbra_interval(float entry, float middle, float leave) {
    penumbra.distance = vec3(entry, 4.0 * middle - 3.0 * entry - leave, 2.0 * (entry + leave) - 4.0 * middle);
}

float penumbra_distance(float p) {
    return penumbra.distance.x + p * (penumbra.distance.y + p * penumbra.distance.z);
}

// Levels that the disc is wide at a distance.
float penumbra_width(float distance) {
    return min(penumbra.spread * max(distance, 1e-30), penumbra.headroom);
}

// The clearance up to which a piece of the interval that ends at p may still hide some of the light; 0 for a hit alone.
float penumbra_spare(float p) {
    return penumbra.open ? penumbra.least * penumbra_width(penumbra_distance(p)) : 0.0;
}

// Takes down a clearance at a distance.
void penumbra_see(float clearance, float distance) {
    if (penumbra.open && distance < penumbra.reach) {
        penumbra.least = min(penumbra.least, max(clearance + penumbra.rounding, 0.0) / penumbra_width(distance));
    }
}

// Takes down clearances over a piece [a, b] of the interval: `c` at its ends and in its middle, a quadratic between.
// c / s is least where its derivative vanishes, a square root; c / headroom at the vertex.
void penumbra_see_piece(vec3 c, float a, float b) {
    float from = penumbra_distance(a), span = penumbra_distance(b) - from;
    float second = 2.0 * (c.x + c.z) - 4.0 * c.y, first = 4.0 * c.y - 3.0 * c.x - c.z;
    float back = span > 1e-6 * from ? from / span : 0.0;
    float divisor = abs(second) > 0.0 ? second : 1e-30;
    float apart = sqrt(max((c.x - back * (first - back * second)) / divisor, 0.0)) - back;
    float vertex = -0.5 * first / divisor;
    float at[4] = float[4](0.0, 1.0, clamp(apart, 0.0, 1.0), clamp(vertex, 0.0, 1.0));
    for (int i = 0; i < 4; ++i) {
        penumbra_see(c.x + at[i] * (first + at[i] * second), from + at[i] * span);
    }
}

// Share of the disc that is seen by what was taken down.
float penumbra_seen() {
    float above = clamp(2.0 * penumbra.least - 1.0, -1.0, 1.0);
    return penumbra.least < 1.0
        ? clamp(0.5 + (above * sqrt(1.0 - above * above) + asin(above)) / 3.14159265358979, 0.0, 1.0)
        : 1.0;
}

#endif
