// What a vertex of a pre-tessellated mesh holds besides its position.
#ifndef BASELINE_MICRO_VERTEX_GLSL
#define BASELINE_MICRO_VERTEX_GLSL

// The normal, of any length, that was folded into an octahedron (Meyer et al. 2010).
vec3 unfolded(vec2 octahedral) {
    vec3 normal = vec3(octahedral, 1.0 - abs(octahedral.x) - abs(octahedral.y));
    float fold = max(-normal.z, 0.0);
    normal.x += normal.x < 0.0 ? fold : -fold;
    normal.y += normal.y < 0.0 ? fold : -fold;
    return normal;
}

#endif
