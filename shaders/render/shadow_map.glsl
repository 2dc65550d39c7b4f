// Shadow maps: what each light sees, traced into depth maps as the camera's picture is (engine/src/render/shadow).
//
// A map holds the surface's exact depth along the light's ray through each texel's centre. The four texels around a point
// are compared with the receiver itself where those rays meet it, and the outcomes are mixed bilinearly
// (percentage-closer filtering: Reeves, Salesin and Cook 1987). No bias is tuned; it is what the receiver does there:
//
// - its tangent plane, on which the map's depth is an affine function of the texel (Isidoro, "Shadow Mapping: GPU-based
//   Tips and Techniques", 2006); in perspective too, as the depth buffer's value is affine in 1 / depth;
// - its detail: by how much the height field leaves that plane at the texel, one height looked up where the plane alone
//   would be in shadow. Along the light's ray that is e (L · n) / (n · l) for e levels of lift L. The ray meets the bent
//   surface a little aside of the place looked up, so that amount is allowed once more; and where that does not do, the
//   height at the place of what the map holds is asked whether it is this surface's. Across an edge of the receiver's
//   triangle the field goes on as the neighbour there stands, which may lean toward the light; farther on nothing is
//   put down to the receiver;
// - rounding: 2^-20 of the terms of each sum that f32 takes, and of plain triangles 1/128 texel of slope, as the
//   rasteriser moves their corners to its grid (1/256 texel). A traced surface is met on the texel's ray itself.
//
// What plane and allowances let pass may be the same height field standing in the light: a crest beside a joint, within
// the depth that the joint itself runs through over a texel, which grows without bound as the light grazes it. So the
// receiver's own way to the light is then followed through the field up to the depths that the map holds: a blocked way is
// dark whatever the texels say.
#ifndef RENDER_SHADOW_MAP_GLSL
#define RENDER_SHADOW_MAP_GLSL

#include "render/interface.glsl"
#include "render/brdf.glsl"
#ifdef HAS_HEIGHT
#include "render/height_field.glsl"
#endif

layout(std430, set = 0, binding = 4) readonly buffer ShadowViewBlock { ShadowView item[]; } shadow_views;
layout(set = 0, binding = 5) uniform sampler2D shadow_atlas;

const float ROUNDING = 1.0 / 1048576.0;
#ifdef RASTERISED
const float SNAPPING = 1.0 / 128.0;
#else
const float SNAPPING = 0.0;
#endif

// Most cells of the height map that are looked at one by one on the way to the light.
const int FIELD_CELLS = 32;
// Cells by which a border that was met may be missed.
const float CROSSED = 1e-3;
const float FIELD_ROUNDING = 1.0 / 65536.0;

// At the place of what a texel holds the receiver's own surface would stand just so high; how much is put down to the
// frame in which that place is found, the receiver's level's, where other levels are wider or narrower.
const float FRAME_SLACK = 1.25;

// How the height field continues beside the receiver. Of a surface without one, all zero.
struct Relief {
    vec2 uv;         // height map coordinates at the receiver
    float level;
    vec3 lambda;     // weights of its triangle's corners; of a surface that has no end, anything above 0
    mat3 to_lambda;  // change of the weights per world displacement within the tangent plane
    mat3x2 to_uv;    // change of uv per the same
    vec3 rise;       // levels per the same, on that plane
    vec3 climb;      // levels over that plane per world displacement
    vec3 lift;       // world displacement per level
    mat3 lifts;      // the same at each corner
    // Of the neighbour across wall k, per weight k of a place there, which is negative:
    mat3 beyond;     // weights of its corner beyond the wall; zero where it is not known
    vec3 fold;       // levels by which it stands over the triangle's own
    mat3x2 fold_uv;  // what its uv differ by from the triangle's own
};

const Relief NO_RELIEF = Relief(vec2(0.0), 0.0, vec3(1.0), mat3(0.0), mat3x2(0.0), vec3(0.0), vec3(0.0), vec3(0.0),
                                mat3(0.0), mat3(0.0), vec3(0.0), mat3x2(0.0));

// The wall across which a place with these weights lies, if it lies outside of the triangle.
int wall_before(vec3 lambda) {
    return lambda.x <= min(lambda.y, lambda.z) ? 0 : lambda.y <= lambda.z ? 1 : 2;
}

// Levels by which the surface stands over the place at `moved` from the receiver, in its tangent plane, and `gained` levels
// over that. known: the place lies in the receiver's triangle or in a neighbour.
float stands_over(Relief relief, vec3 moved, float gained, out bool known) {
    known = true;
#ifdef HAS_HEIGHT
    vec3 lambda = relief.lambda + relief.to_lambda * moved;
    if (all(greaterThanEqual(lambda, vec3(0.0)))) {
        // The shell map has one term of second order, a lift that differs with the weights: so much the frame moves too
        // far.
        vec3 bent = (dot(relief.rise, moved) + gained) * (relief.lifts * (relief.to_lambda * moved));
        float sunk = dot(relief.climb, bent);
        moved -= bent - sunk * relief.lift;
        gained -= sunk;
        lambda = relief.lambda + relief.to_lambda * moved;
    }
    vec2 uv = relief.uv + relief.to_uv * moved;
    float over = 0.0;
    int wall = wall_before(lambda);
    if (lambda[wall] < 0.0) {
        vec3 beyond = relief.beyond[wall];
        vec3 inside = lambda - lambda[wall] * beyond;
        inside[wall] = 0.0;
        known = beyond != vec3(0.0) && all(greaterThanEqual(inside, vec3(0.0)));
        over = lambda[wall] * relief.fold[wall];
        uv += lambda[wall] * relief.fold_uv[wall];
    }
    over += (height_at(uv, 0.0) - material.displacement.y) * material.displacement.x;
    return over - relief.level - dot(relief.rise, moved) - gained;
#else
    return 0.0;
#endif
}

// How the light's way runs through the height field, per world unit from the receiver.
struct FieldWay {
    float gain; // levels over the tangent plane
    vec3 along; // displacement within that plane
};

FieldWay field_way(Relief relief, vec3 toward) {
    float gain = dot(relief.climb, toward);
    return FieldWay(gain, toward - gain * relief.lift);
}

// Whether the height field itself stands in the receiver's light, up to `reach` from it, as its triangle and the neighbour
// across the wall continue it: cell by cell of the height map. On a straight way through a cell the height is a quadratic,
// which three of its values give, its highest point too; of a function, and of more than FIELD_CELLS cells, as many pieces
// of one length. What counts is more than UVs' and the hit's rounding make of a height.
bool field_blocks(Relief relief, FieldWay way, float reach) {
#ifdef HAS_HEIGHT
    vec3 weights = relief.to_lambda * way.along;
    vec3 until = mix(vec3(reach), -relief.lambda / min(weights, -1e-30), lessThan(weights, vec3(0.0)));
    int wall = wall_before(until);
    float leaves = min(until[wall], reach);
    vec2 rate = height_size() * (relief.to_uv * way.along), cell = height_size() * relief.uv - 0.5;
    float crossings = reach * (abs(rate.x) + abs(rate.y));
    float least = crossings > float(FIELD_CELLS) ? reach / float(FIELD_CELLS) : 0.0;
    float from = 0.0, before = 0.0;
    // A crossing in each direction, the wall and the end come on top.
    for (int i = 0; i < FIELD_CELLS + 4 && from < reach; ++i) {
        vec2 border = mix(ceil(cell - CROSSED) - 1.0, floor(cell + CROSSED) + 1.0, greaterThan(rate, vec2(0.0)));
        vec2 away = abs(border - cell) / max(abs(rate), vec2(1e-30));
        float to = min(from + max(min(away.x, away.y), least), from < leaves ? leaves : reach);
        bool known;
        float middle = 0.5 * (from + to);
        middle = sign(way.gain) * stands_over(relief, middle * way.along, middle * way.gain, known);
        float after = sign(way.gain) * stands_over(relief, to * way.along, to * way.gain, known);
        float first = 4.0 * middle - 3.0 * before - after, second = 2.0 * (before + after) - 4.0 * middle;
        bool inside = first > 0.0 && first < -2.0 * second;
        float highest = inside ? before - 0.25 * first * first / second : after;
        if (highest > FIELD_ROUNDING * material.displacement.x) {
            return true;
        }
        cell += (to - from) * rate;
        if (from < leaves && to >= leaves) {
            rate += height_size() * weights[wall] * relief.fold_uv[wall];
        }
        from = to;
        before = after;
    }
#endif
    return false;
}

float weighed(vec4 at, vec3 position) {
    return dot(abs(at.xyz), abs(position)) + abs(at.w);
}

// How much of the light arrives by one map. at: the receiver in texels. w: its clip w.
float map_lit(ShadowView view, vec2 at, float w, Surface surface, vec3 toward, Relief relief) {
    vec3 position = surface.position, normal = surface.geometric, axis = view.depth.xyz;
    float depth = dot(axis, position) + view.depth.w;
    bool perspective = view.lens.w != 0.0;
    if (perspective && depth <= 0.0) {
        return 1.0;
    }
    float receiver = view.lens.x * depth + view.lens.y, change = view.lens.x;
    if (perspective) {
        receiver /= depth;
        change = -view.lens.y / (depth * depth);
    }
    // One texel right and one down on the tangent plane: (row - texel w) . moved = w * (change of texel).
    vec3 row_x = view.x.xyz - at.x * view.w.xyz, row_y = view.y.xyz - at.y * view.w.xyz;
    vec3 across = cross(row_y, normal), down = cross(normal, row_x);
    float volume = dot(row_x, across), least = 1e-6 * length(row_x) * length(row_y);
    float scale = w / (volume < 0.0 ? min(volume, -least) : max(volume, least));
    across *= scale;
    down *= scale;
    vec2 slope = change * vec2(dot(axis, across), dot(axis, down));
    vec2 spread = vec2(weighed(view.x, position), weighed(view.y, position)) / w;
    float rounding = ROUNDING * (abs(change) * weighed(view.depth, position) + abs(receiver)
                                 + dot(abs(slope), spread)) + SNAPPING * (abs(slope.x) + abs(slope.y));
    // Of the buffer's value, per level of lift.
    float lifted = change * dot(axis, toward) * dot(relief.lift, normal) / max(dot(normal, toward), 1e-6);

    vec2 first = clamp(floor(at - 0.5), vec2(0.0), vec2(view.lens.z - 2.0));
    vec2 part = clamp(at - 0.5 - first, 0.0, 1.0);
    vec4 stored = textureGather(shadow_atlas, (view.tile.xy + first + 1.0) * view.tile.zw);
    vec4 share = vec4((1.0 - part.x) * part.y, part.x * part.y, part.x * (1.0 - part.y),
                      (1.0 - part.x) * (1.0 - part.y));
    FieldWay way = field_way(relief, toward);
    float nearing = change * dot(axis, toward), lit = 0.0, farthest = 0.0;
    for (int i = 0; i < 4; ++i) {
        // A gather's order: lower left, lower right, upper right, upper left.
        vec2 away = first + 0.5 + vec2(i == 1 || i == 2 ? 1.0 : 0.0, i < 2 ? 1.0 : 0.0) - at;
        float over = stored[i] - receiver - dot(slope, away);
        bool blocked = over > rounding;
#ifdef HAS_HEIGHT
        if (blocked && relief.lift != vec3(0.0)) {
            vec3 moved = away.x * across + away.y * down;
            bool known;
            float bend = lifted * stands_over(relief, moved, 0.0, known);
            blocked = over - rounding > 2.0 * max(bend, 0.0);
            if (blocked) {
                float ahead = over / nearing;
                bend = over + lifted * stands_over(relief, moved + ahead * way.along, ahead * way.gain, known);
                blocked = !known || over - rounding > FRAME_SLACK * max(bend, 0.0)
                          || bend - rounding > FRAME_SLACK * over;
            }
        }
#endif
        if (!blocked) {
            lit += share[i];
            farthest = max(farthest, stored[i] - receiver);
        }
    }
#ifdef HAS_HEIGHT
    if (farthest > rounding && relief.lift != vec3(0.0) && field_blocks(relief, way, farthest / nearing)) {
        return 0.0;
    }
#endif
    return lit;
}

// What the maps say of each light at a receiver, in `visibility`.
Visibility mapped_visibility(Visibility visibility, Surface surface, Relief relief) {
    for (int i = 0; i < SHADOWED_LIGHTS; ++i) {
        Light light = lights.item[i];
        vec3 toward;
        light_arriving(light, surface.position, toward);
        if (dot(surface.geometric, toward) <= 0.0) {
            visibility.light[i] = 0.0;
            continue;
        }
        // The finest map that holds the point: cascades come in that order, and the faces of a cube do not overlap.
        int begin = int(light.spot.z), end = begin + int(light.spot.w);
        for (int v = begin; v < end && visibility.light[i] > 0.0; ++v) {
            ShadowView view = shadow_views.item[v];
            float w = dot(view.w.xyz, surface.position) + view.w.w;
            vec2 at = vec2(dot(view.x.xyz, surface.position), dot(view.y.xyz, surface.position));
            at = (at + vec2(view.x.w, view.y.w)) / w;
            if (w > 0.0 && all(greaterThanEqual(at, vec2(1.0))) && all(lessThanEqual(at, vec2(view.lens.z - 1.0)))) {
                visibility.light[i] *= map_lit(view, at, w, surface, toward, relief);
                break;
            }
        }
    }
    return visibility;
}

#endif
