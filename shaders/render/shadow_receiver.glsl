// A shadow map's receiver and the height field around it.
//
// A place near the receiver is found in the prism that holds it: by Newton's method for that prism's shell map, from a
// point of it that is known. That is the receiver itself at first; where the place lies beyond a wall, the point of the
// wall where the way there crosses it, in the neighbour, and so on. So folds, seams, steps and plain triangles are met as
// they are. A base surface is one plane without end.
#ifndef RENDER_SHADOW_RECEIVER_GLSL
#define RENDER_SHADOW_RECEIVER_GLSL

#include "render/interface.glsl"
#ifdef HAS_HEIGHT
#include "render/height_field.glsl"
#ifndef RASTERISED
#include "render/adjacency.glsl"
#include "shell/prism_bits.glsl"
#endif
#endif

// Prisms that a place may lie away from the receiver's.
const int RECEIVER_HOPS = 32;
// How far beyond the surface's levels a place is still told, as a part of their range.
const float LEVEL_SLACK = 0.25;
// And how far the way to the light is followed.
const float WAY_SLACK = 1.0;
// Most cells of the height map that are looked at one by one on the way to the light.
const int FIELD_CELLS = 256;
// Cells by which a border that was met may be missed.
const float CROSSED = 1e-3;
// Of Newton's method, after the tangent's.
const int RECEIVER_STEPS = 2;
// Farther than any light.
const float NEVER = 1e30;
// What counts as blocked, of the height's scale: more than UVs' and the hit's rounding make of a height.
const float FIELD_ROUNDING = 1.0 / 65536.0;

// All in world units and less the receiver's place, where nothing else is said.
struct Receiver {
    bool followed;     // has a height field around it; without one there is nothing else
    bool on_wall;
    vec3 origin;       // its own place, mesh space
    uint prism;
    vec3 anchor;       // a point of the prism
    vec3 lambda;       // its weights, level and coordinates
    float level;
    vec2 uv;
    float scale;       // levels of a height; 0 where the triangle is plain
    mat3 axes;         // displacement per weight of corner 1, of corner 2, and per level
    vec3 lift1, lift2; // what that per level gains per those weights
    mat2 uvs;          // change of the coordinates per those weights
};

const Receiver NO_RECEIVER = Receiver(false, false, vec3(0.0), 0u, vec3(0.0), vec3(0.0), 0.0, vec2(0.0), 0.0, mat3(0.0),
                                      vec3(0.0), vec3(0.0), mat2(0.0));

#ifdef HAS_HEIGHT
// A place near the receiver, as the prism has it.
struct ReceiverPlace {
    vec3 lambda;
    float level;
    vec2 uv;
};

// Change of a place per weight of corner 1, of corner 2, and per level, where they have changed by `moved`.
mat3 receiver_axes(Receiver receiver, vec3 moved) {
    return mat3(receiver.axes[0] + moved.z * receiver.lift1, receiver.axes[1] + moved.z * receiver.lift2,
                receiver.axes[2] + moved.x * receiver.lift1 + moved.y * receiver.lift2);
}

// The place for a change of these.
ReceiverPlace receiver_after(Receiver receiver, vec3 moved) {
    return ReceiverPlace(receiver.lambda + vec3(-moved.x - moved.y, moved.xy), receiver.level + moved.z,
                         receiver.uv + receiver.uvs * moved.xy);
}

// What they change by on the way to `at`: Newton's method for the shell map, which is bilinear.
vec3 receiver_moved(Receiver receiver, vec3 at) {
    vec3 away = at - receiver.anchor, moved = inverse(receiver.axes) * away;
    for (int i = 0; i < RECEIVER_STEPS; ++i) {
        mat3 axes = receiver_axes(receiver, moved);
        moved -= inverse(axes) * (mat3(receiver.axes[0], receiver.axes[1], axes[2]) * moved - away);
    }
    return moved;
}

ReceiverPlace receiver_place(Receiver receiver, vec3 at) {
    return receiver_after(receiver, receiver_moved(receiver, at));
}

// Levels by which the field stands over a place.
float field_over(Receiver receiver, ReceiverPlace place) {
    return (height_at(place.uv, 0.0) - material.displacement.y) * receiver.scale - place.level;
}

// The surface's levels, and on either side this part of their range.
vec2 levels_around(float part) {
    vec2 range = material.displacement.zw;
    return range + part * (range.y - range.x) * vec2(-1.0, 1.0);
}

// Whether the field is told at a place of this level.
bool tells(float level) {
    vec2 range = levels_around(LEVEL_SLACK);
    return level >= range.x && level <= range.y;
}

// The wall across which a place with these weights lies, if it lies outside of the triangle.
int wall_before(vec3 lambda) {
    return lambda.x <= min(lambda.y, lambda.z) ? 0 : lambda.y <= lambda.z ? 1 : 2;
}

#ifndef RASTERISED
// Sees places from prism `id`, from its point with these weights at level `t`. first: that is the receiver. False where
// all levels meet there.
bool receiver_stands(inout Receiver receiver, uint id, vec3 lambda, float t, bool first) {
    Object object = drawn;
    uvec4 corners = prisms.item[id].corners;
    Vertex v[3] = Vertex[3](vertices.item[corners[0]], vertices.item[corners[1]], vertices.item[corners[2]]);
    vec3 s0 = v[0].position.xyz + t * v[0].shell.xyz;
    vec3 e1 = v[1].position.xyz + t * v[1].shell.xyz - s0, e2 = v[2].position.xyz + t * v[2].shell.xyz - s0;
    vec3 position = s0 + lambda.y * e1 + lambda.z * e2, normal = cross(e1, e2);
    vec3 along = lambda.x * v[0].shell.xyz + lambda.y * v[1].shell.xyz + lambda.z * v[2].shell.xyz;
    bool plain = is_plain(corners.w), meet = dot(along, along) < 1e-12;
    if (plain) {
        // Any direction will do.
        along = normalize(normal);
        t = 0.0;
    }
    receiver.origin = first ? position : receiver.origin;
    receiver.prism = id;
    receiver.anchor = transform_direction(object.world_x, object.world_y, object.world_z, position - receiver.origin);
    receiver.lambda = lambda;
    receiver.level = t;
    vec2 uv = height_uv_of(v[0]), uv1 = height_uv_of(v[1]) - uv, uv2 = height_uv_of(v[2]) - uv;
    receiver.uv = uv + lambda.y * uv1 + lambda.z * uv2;
    receiver.scale = plain ? 0.0 : material.displacement.x;
    receiver.uvs = mat2(uv1, uv2);
    float bends = plain ? 0.0 : 1.0;
    vec3 columns[5] = vec3[5](e1, e2, along, bends * (v[1].shell.xyz - v[0].shell.xyz),
                              bends * (v[2].shell.xyz - v[0].shell.xyz));
    for (int i = 0; i < 5; ++i) {
        columns[i] = transform_direction(object.world_x, object.world_y, object.world_z, columns[i]);
    }
    receiver.axes = mat3(columns[0], columns[1], columns[2]);
    receiver.lift1 = columns[3];
    receiver.lift2 = columns[4];
    return plain || !meet;
}

// Weights of a point of the wall between two prisms as the one across it has them.
vec3 weights_across(vec3 lambda, int wall, int entry) {
    vec3 other = vec3(0.0);
    other[(entry + 1) % 3] = lambda[(wall + 2) % 3];
    other[(entry + 2) % 3] = lambda[(wall + 1) % 3];
    return other;
}
#endif

// Sees places from across a wall, from the point there with these weights. False where nothing is known beyond it.
bool receiver_crosses(inout Receiver receiver, int wall, vec3 lambda, float level) {
#ifdef RASTERISED
    return false;
#else
    uint across = adjacency.item[3u * receiver.prism + uint(wall)];
    if (across == NO_NEIGHBOUR || wall_field(prisms.item[receiver.prism].corners.w, wall) != 0u) {
        return false;
    }
    vec3 other = max(weights_across(lambda, wall, int(across & 3u)), 0.0);
    return receiver_stands(receiver, across >> 2u, other / max(other.x + other.y + other.z, 1e-30), level, false);
#endif
}

// Levels by which the surface stands over a place, which is seen from its own prism from then on. known: the surface goes
// on to there, and may be as high. Beyond its levels prisms may fold, so no way there leads through them.
float stands_over(inout Receiver receiver, vec3 at, out bool known) {
    known = false;
    ReceiverPlace place;
    for (int hop = 0; hop <= RECEIVER_HOPS; ++hop) {
        place = receiver_place(receiver, at);
#ifdef RASTERISED
        known = true;
        break;
#else
        int wall = wall_before(place.lambda);
        known = place.lambda[wall] >= 0.0;
        if (known) {
            break;
        }
        float part = receiver.lambda[wall] / (receiver.lambda[wall] - place.lambda[wall]);
        float level = mix(receiver.level, place.level, part);
        if (!tells(level) || !receiver_crosses(receiver, wall, mix(receiver.lambda, place.lambda, part), level)) {
            break;
        }
#endif
    }
    known = known && tells(place.level);
    return field_over(receiver, place);
}

// How far the receiver's way to the light, up to `reach`, is known to be clear of the height field; negative where that
// stands in it. From prism to prism, cell by cell of the height map, until something is not known. On a straight way
// through a cell the height is a quadratic, which three of its values give; levels bend too, so where its highest point
// would stand in the way, the field is asked there. Of more than FIELD_CELLS cells, as many pieces of one length. side: +1
// where light arrives from above the surface. leaves: at least to where the way leaves the surface's levels. left: where
// it has left them so far, and by `aside` besides, that what lies beyond is another surface.
float field_clear(Receiver receiver, vec3 toward, float side, float reach, bool leaves, float aside, out float left) {
    left = NEVER;
    vec3 moved = vec3(0.0), rates = inverse(receiver.axes) * toward;
    ReceiverPlace place = receiver_after(receiver, moved);
    vec2 rate = height_size() * (receiver.uvs * rates.xy);
    float crossings = abs(rate.x) + abs(rate.y);
    if (leaves) {
        float rises = side * rates.z, most = float(FIELD_CELLS) / max(crossings, 1e-30);
        float room = side * ((side > 0.0 ? material.displacement.w : material.displacement.z) - place.level);
        reach = max(reach, rises * most > room ? room / rises : most);
    }
    float shortest = crossings * reach > float(FIELD_CELLS) ? reach / float(FIELD_CELLS) : 0.0;
    // What rounding lets the receiver itself lie under the field is no blocker.
    float from = 0.0, before = side * field_over(receiver, place);
    float least = FIELD_ROUNDING * material.displacement.x + (receiver.on_wall ? 0.0 : max(before, 0.0));
    vec2 range = levels_around(WAY_SLACK) + aside * vec2(-1.0, 1.0);
    // A crossing in each direction, the walls and the end come on top.
    for (int i = 0; i < FIELD_CELLS + 64 && from < reach; ++i) {
        float level = place.level;
        rates = inverse(receiver_axes(receiver, moved)) * toward;
        rate = height_size() * (receiver.uvs * rates.xy);
#ifdef RASTERISED
        int wall = 0;
        float exit = reach;
#else
        vec3 weights = vec3(-rates.x - rates.y, rates.xy);
        vec3 until = mix(vec3(reach), from - place.lambda / min(weights, -1e-30), lessThan(weights, vec3(0.0)));
        int wall = wall_before(until);
        float exit = clamp(until[wall], from, reach);
#endif
        vec2 cell = height_size() * place.uv - 0.5;
        vec2 border = mix(ceil(cell - CROSSED) - 1.0, floor(cell + CROSSED) + 1.0, greaterThan(rate, vec2(0.0)));
        vec2 away = abs(border - cell) / max(abs(rate), vec2(1e-30));
        float to = min(from + max(min(away.x, away.y), shortest), exit);
        float middle = side * field_over(receiver, receiver_place(receiver, 0.5 * (from + to) * toward));
        moved = receiver_moved(receiver, to * toward);
        place = receiver_after(receiver, moved);
        float after = side * field_over(receiver, place), highest = after;
        float first = 4.0 * middle - 3.0 * before - after, second = 2.0 * (before + after) - 4.0 * middle;
        if (first > 0.0 && first < -2.0 * second && before - 0.25 * first * first / second > least) {
            float at = mix(from, to, -0.5 * first / second);
            highest = max(after, side * field_over(receiver, receiver_place(receiver, at * toward)));
        }
        if (highest > least) {
            return tells(place.level) ? -1.0 : from;
        }
        if (place.level < range.x || place.level > range.y) {
            float top = place.level > level ? range.y : range.x;
            left = mix(from, to, clamp((top - level) / (place.level - level), 0.0, 1.0));
            return left;
        }
        from = to;
        before = after;
        if (to == exit && to < reach) {
            if (!receiver_crosses(receiver, wall, place.lambda, place.level)) {
                return from;
            }
            moved = receiver_moved(receiver, to * toward);
            place = receiver_after(receiver, moved);
            before = side * field_over(receiver, place);
            if (before > least) {
                return -1.0;
            }
        }
    }
    return from;
}
#endif

#endif
