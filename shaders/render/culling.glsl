// Which items of a draw, prisms' outlines or lids, no pixel can show, so that no stage need make them.
//
// CULL_HIDDEN: also those behind what is nearer. Then a draw has two rounds: the first takes the prisms that the last frame
// showed; the second, with the depth of all that was drawn so far, finds which of all prisms show, and takes those of them
// that the first has left out.
#ifndef RENDER_CULLING_GLSL
#define RENDER_CULLING_GLSL

#include "render/interface.glsl"
#include "render/lid_growth.glsl"
#ifdef WALK_LIDS
#include "render/lids.glsl"
#else
#include "render/shell_corners.glsl"
#endif
#ifdef CULL_HIDDEN
#include "render/depth_tiles.glsl"

layout(std430, set = 0, binding = 7) readonly buffer DepthTileBlock { float item[]; } depth_tiles;

// The farthest depth of the pixels from `first` to `last`.
float farthest_depth(vec2 first, vec2 last) {
    ivec2 picture = ivec2(frame.viewport.xy);
    ivec2 low = clamp(ivec2(floor(first)), ivec2(0), picture - 1) / TILE;
    ivec2 high = clamp(ivec2(floor(last)), ivec2(0), picture - 1) / TILE;
    // The level at which at most 4 x 4 tiles hold them.
    int level = 0, start = 0;
    while (any(greaterThan((high >> level) - (low >> level), ivec2(3)))) {
        ivec2 count = tile_count(picture, level++);
        start += count.x * count.y;
    }
    int columns = tile_count(picture, level).x;
    float farthest = 1.0;
    for (int y = low.y >> level; y <= high.y >> level; ++y) {
        for (int x = low.x >> level; x <= high.x >> level; ++x) {
            farthest = min(farthest, depth_tiles.item[start + y * columns + x]);
        }
    }
    return farthest;
}

// 1 for each prism that the last frame showed.
layout(std430, set = 1, binding = 19) buffer SeenBlock { uint item[]; } seen;
#endif
#ifdef COUNT_CULLED
layout(std430, set = 0, binding = 6) buffer CulledBlock { uint items[4]; } culled;
#endif

const uint SHOWS = 0u;
const uint OUTSIDE = 1u;  // of the view
const uint AWAY = 2u;     // it faces away, or lies behind the horizon of its shell
const uint HIDDEN = 3u;   // behind what is nearer
const uint NOTHING = 4u;  // no border, and the near plane does not cut it: it has no outline

// What is that near to a limit, in pixels, is kept: outlines and lids are grown, and rasterisers snap corners to a grid.
const float ROOM = 1.0;

#ifdef WALK_LIDS
uint prism_of(uint item) {
    return item;
}

// Clip x, y, w and view depth of six corners around what an item draws, base first.
void hull_corners(Object object, PrismData data, out vec4 corners[6]) {
    for (int k = 0; k < 3; ++k) {
        Vertex vertex = vertices.item[data.corners[k]];
        vec2 levels = lids_of(data.corners[k]);
        float lid = grown_level(object, vertex, levels.y, 1.0);
        // Without a base the lid alone is drawn.
        float base = draw.bases != 0u ? grown_level(object, vertex, levels.x, -1.0) : lid;
        for (int side = 0; side < 2; ++side) {
            vec3 at = vertex.position.xyz + (side == 0 ? base : lid) * vertex.shell.xyz;
            vec3 clip = transform_point(object.clip_x, object.clip_y, object.clip_w, at);
            corners[3 * side + k] = vec4(clip, dot(object.depth.xyz, at) + object.depth.w);
        }
    }
}
#else
uint prism_of(uint item) {
    return outlined_prism(item);
}

void hull_corners(Object object, PrismData data, out vec4 corners[6]) {
    prism_corners(object, data, corners);
}
#endif

// Twice the area of a triangle on screen, in pixels, positive if it faces away, less what snapping may change of it.
float away_by(vec2 a, vec2 b, vec2 c, float facing) {
    vec2 extent = max(a, max(b, c)) - min(a, min(b, c));
    return facing * determinant(mat2(b - a, c - a)) - ROOM / 16.0 * (extent.x + extent.y);
}

// Which test drops the item, or SHOWS.
uint verdict(uint prism) {
    Object object = drawn;
    vec4 corners[6];
    hull_corners(object, prisms.item[prism], corners);

    // All corners beyond one plane of the view: then the hull is.
    vec2 edge = 1.0 + 2.0 * ROOM * frame.viewport.zw;
    bvec2 low = bvec2(true), high = bvec2(true);
    float nearest = corners[0].w, farthest = corners[0].w;
    for (int i = 0; i < 6; ++i) {
        vec2 reach = edge * corners[i].z;
        low = bvec2(low.x && corners[i].x < -reach.x, low.y && corners[i].y < -reach.y);
        high = bvec2(high.x && corners[i].x > reach.x, high.y && corners[i].y > reach.y);
        nearest = min(nearest, corners[i].w);
        farthest = max(farthest, corners[i].w);
    }
#ifdef WALK_BORDERS
    if (!has_flag(prisms.item[prism].corners.w, BORDER) && nearest >= frame.lens.z * NEAR_REACH) {
        return NOTHING;
    }
#endif
    if (any(low) || any(high) || farthest < frame.lens.z || nearest > frame.lens.w) {
        return OUTSIDE;
    }
    // What reaches before the near plane has no place on screen to go by.
    if (nearest <= frame.lens.z * NEAR_REACH) {
        return SHOWS;
    }
    vec2 at[6];
    for (int i = 0; i < 6; ++i) {
        at[i] = (corners[i].xy / corners[i].z * 0.5 + 0.5) * frame.viewport.xy;
    }
    float facing = object.handedness.x;
    bool away = away_by(at[3], at[4], at[5], facing) > 0.0;
#ifdef WALK_LIDS
    // The rasteriser leaves such lids out anyway, after they were made.
    away = away && (draw.bases == 0u || away_by(at[0], at[2], at[1], facing) > 0.0);
    if (away) {
        return AWAY;
    }
#else
    away = away && away_by(at[0], at[1], at[2], facing) > 0.0;
#endif
#ifdef CULL_HIDDEN
    if (draw.round != 0u) {
        vec2 first = min(min(at[0], at[1]), min(min(at[2], at[3]), min(at[4], at[5]))) - ROOM;
        vec2 last = max(max(at[0], at[1]), max(max(at[2], at[3]), max(at[4], at[5]))) + ROOM;
#if defined(WALK_LIDS) || defined(WALK_BORDERS)
        // Nothing that is hit stands before the lid, base or border where its ray comes in, and that is drawn (proved by
        // tests/culling.rs and engine/src/shell/walk.rs). Snapped to its grid, a rasteriser may name a neighbour of it.
        nearest -= 0.5 * (farthest - nearest);
#endif
        nearest = max(nearest * (1.0 - 1e-4), frame.lens.z);
        if (buffer_depth(nearest) < farthest_depth(first, last)) {
            return away ? AWAY : HIDDEN;
        }
    }
#endif
    return SHOWS;
}

// Whether the draw's item is to be drawn, in this round. Counts those that are not, by test.
bool keeps(uint item) {
    uint prism = prism_of(item);
    uint found = verdict(prism);
    bool keep = found == SHOWS;
#ifdef CULL_HIDDEN
    bool was_seen = seen.item[prism] != 0u;
    if (draw.round == 0u) {
        return keep && was_seen;
    }
    seen.item[prism] = uint(keep);
#endif
#ifdef COUNT_CULLED
    if (draw.counted != 0u && found != NOTHING) {
        atomicAdd(culled.items[found], 1u);
    }
#endif
#ifdef CULL_HIDDEN
    keep = keep && !was_seen;
#endif
    return keep;
}

#endif
