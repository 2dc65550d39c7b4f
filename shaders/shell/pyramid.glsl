// The min-max pyramid of a height map: what a box of bilinear cells can hold, without a miss at any border.
//
// Cell c spans texel centres c and c + 1. Node k of level L covers cells k 2^L - s to (k + 1) 2^L - 1 - s along each
// axis, hence texels to (k + 1) 2^L - s inclusive, wrapped one by one; s = 1 where the map is clamped (the cell before
// the first texel is a constant one), else 0. One node more than the map needs holds what lies beyond its end, so a box
// of up to 2^L cells that starts anywhere in the map lies in 2 x 2 nodes. Plain image mips cannot do this.
//
// The includer defines HEIGHT_WRAP_U and HEIGHT_WRAP_V (0 repeat, 1 mirror, 2 clamp).
#ifndef SHELL_PYRAMID_GLSL
#define SHELL_PYRAMID_GLSL

// i modulo n, not negative.
int wrapped(int i, int n) {
    int at = i - n * int(floor(float(i) / float(n)));
    // float division may be one off for large i; one correction is enough
    return at < 0 ? at + n : at >= n ? at - n : at;
}

const int PYRAMID_LEVELS = 16;

// Cells after which an axis of `n` texels repeats, or ends where it is clamped.
int pyramid_period(int n, const int mode) {
    return mode == 1 ? 2 * n : n;
}

int pyramid_shift(const int mode) {
    return mode == 2 ? 1 : 0;
}

ivec2 pyramid_period(ivec2 size) {
    return ivec2(pyramid_period(size.x, HEIGHT_WRAP_U), pyramid_period(size.y, HEIGHT_WRAP_V));
}

ivec2 pyramid_shift() {
    return ivec2(pyramid_shift(HEIGHT_WRAP_U), pyramid_shift(HEIGHT_WRAP_V));
}

// Nodes of a level along both axes.
ivec2 pyramid_nodes(ivec2 size, int level) {
    return ((pyramid_period(size) + pyramid_shift() + (1 << level) - 1) >> level) + 1;
}

// The level at which 2 x 2 nodes hold the whole map.
int pyramid_top(ivec2 size) {
    ivec2 cells = pyramid_period(size) + pyramid_shift();
    return max(findMSB(max(cells.x, cells.y) - 1) + 1, 1);
}

// Bounds are 16 bits each, rounded outward; 8- and 16-bit maps are held exactly.
uint pyramid_pack(vec2 low_high) {
    return uint(floor(low_high.x * 65535.0 + 0.001)) | uint(ceil(low_high.y * 65535.0 - 0.001)) << 16;
}

vec2 pyramid_unpack(uint node) {
    return vec2(node & 0xffffu, node >> 16) / 65535.0;
}

#endif
