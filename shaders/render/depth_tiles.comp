#version 460
#extension GL_GOOGLE_include_directive : require
// One level of the depth tiles: the smallest of them from the picture's depth, the others from the level before.
#include "render/depth_tiles.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 0) uniform sampler2D picture_depth;
layout(std430, set = 0, binding = 1) buffer DepthTileBlock { float item[]; } depth_tiles;

layout(push_constant) uniform LevelBlock {
    int level;
    int first, first_before; // in the buffer: of the level, and of the one before
} at;

void main() {
    ivec2 picture = textureSize(picture_depth, 0);
    ivec2 tile = ivec2(gl_GlobalInvocationID.xy), count = tile_count(picture, at.level);
    if (any(greaterThanEqual(tile, count))) {
        return;
    }
    float farthest = 1.0;
    if (at.level == 0) {
        ivec2 end = min((tile + 1) * TILE, picture);
        for (int y = tile.y * TILE; y < end.y; ++y) {
            for (int x = tile.x * TILE; x < end.x; ++x) {
                farthest = min(farthest, texelFetch(picture_depth, ivec2(x, y), 0).x);
            }
        }
    } else {
        ivec2 before = tile_count(picture, at.level - 1), end = min((tile + 1) * 2, before);
        for (int y = tile.y * 2; y < end.y; ++y) {
            for (int x = tile.x * 2; x < end.x; ++x) {
                farthest = min(farthest, depth_tiles.item[at.first_before + y * before.x + x]);
            }
        }
    }
    depth_tiles.item[at.first + tile.y * count.x + tile.x] = farthest;
}
