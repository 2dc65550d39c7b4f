// One triangle over the whole target.
#ifndef RENDER_PICTURE_TRIANGLE_GLSL
#define RENDER_PICTURE_TRIANGLE_GLSL

// Its corner i, at the near plane: where depth is written, none lies before it.
vec4 picture_corner(uint i) {
    return vec4(vec2(i & 1u, i >> 1u) * 4.0 - 1.0, 1.0, 1.0);
}

#endif
