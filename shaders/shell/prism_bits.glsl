// The word of bits that each prism carries: how the surface goes on across its walls, and what the prism itself is.
// engine/src/render/geometry.rs writes it; where the mesh deforms, render/deform_write_prisms.comp writes it anew.
#ifndef SHELL_PRISM_BITS_GLSL
#define SHELL_PRISM_BITS_GLSL

// How the neighbour across a wall continues the surface.
const uint WALL_SAME = 0u;   // the same height there: no step
const uint WALL_SEAM = 1u;   // displaced, with other coordinates or another field: read through `neighbour_uv`
const uint WALL_PLAIN = 2u;  // a plain surface at t = 0
const uint WALL_OPEN = 3u;   // border of the sheet, open
const uint WALL_CLOSED = 4u; // border closed by a wall down to the lowest level

// What adjacency says of a wall across which no prism lies.
const uint NO_NEIGHBOUR = 0xffffffffu;

// What a box of the hierarchy over the prisms says in place of a prism, where the boxes that follow divide it.
const uint NO_PRISM = 0xffffffffu;

// Flags, by bit.
const int PLAIN = 12;     // not displaced: the triangle itself, traced so that it meets its neighbours without a crack
const int IRREGULAR = 13; // a ray may slip past its lid
const int BORDER = 26;    // a ray may enter it otherwise than through its lid and base

const int ONE_HEIGHT = 30; // its heights are all the same, and none of its walls has a step

// Corner k lies at a border: a ray may enter by it alone.
const int BRINK = 27; // to 29

bool has_flag(uint bits, int flag) {
    return bitfieldExtract(bits, flag, 1) != 0u;
}

uint with_flag(uint bits, int flag, bool on) {
    return bitfieldInsert(bits, on ? 1u : 0u, flag, 1);
}

bool at_brink(uint bits, int corner) {
    return has_flag(bits, BRINK + corner);
}

// WALL_*. NO_STEPS: at all of the includer's walls the surface goes on at the same height, or ends.
uint wall_kind(uint bits, int wall) {
#ifdef NO_STEPS
    return WALL_SAME;
#else
    return bitfieldExtract(bits, 3 * wall, 3);
#endif
}

// NO_PLAIN: none of the includer's prisms is.
bool is_plain(uint bits) {
#ifdef NO_PLAIN
    return false;
#else
    return has_flag(bits, PLAIN);
#endif
}

// ONE_HEIGHTS: some of the includer's prisms have one.
bool has_one_height(uint bits) {
#ifdef ONE_HEIGHTS
    return has_flag(bits, ONE_HEIGHT);
#else
    return false;
#endif
}

uint with_wall_kind(uint bits, int wall, uint kind) {
    return bitfieldInsert(bits, kind, 3 * wall, 3);
}

// The wall's welded ids descend from corner wall + 1 to corner wall + 2.
bool wall_descends(uint bits, int wall) {
    return bitfieldExtract(bits, 9 + wall, 1) != 0u;
}

// The neighbour's height field: 0 the prism's own, else 1 + its number among the others.
uint wall_field(uint bits, int wall) {
    return bitfieldExtract(bits, 14 + 3 * wall, 3);
}

// The neighbour's surface is hit from behind too; under BLOCKS_LIGHT every surface is.
bool wall_behind(uint bits, int wall) {
#ifdef BLOCKS_LIGHT
    return true;
#else
    return bitfieldExtract(bits, 23 + wall, 1) != 0u;
#endif
}

#endif
