// The farthest depth in tiles of the picture, and in tiles of these: what lies behind it is hidden. Depth is reversed, so
// the farthest is the least.
#ifndef RENDER_DEPTH_TILES_GLSL
#define RENDER_DEPTH_TILES_GLSL

// Pixels along an edge of the smallest tile; that of `engine/src/render/depth_tiles.rs`.
const int TILE = 4;

// Tiles along both axes at a level.
ivec2 tile_count(ivec2 picture, int level) {
    int side = TILE << level;
    return (picture + side - 1) / side;
}

#endif
