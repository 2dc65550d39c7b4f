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
//   surface a little aside of the place looked up, so that amount is allowed once more. Where that does not do, the place
//   of what the map holds is found in the shell, from prism to prism: if the surface there is at it, or as a step passes
//   between a little before it and a little behind it, the map holds the receiver's own surface;
// - rounding: 2^-20 of the terms of each sum that f32 takes, and of plain triangles 1/128 texel of slope, as the
//   rasteriser moves their corners to its grid (1/256 texel). A traced surface is met on the texel's ray itself.
//
// What plane and allowances let pass may be the same height field standing in the light: a crest beside a joint, within
// the depth that the joint itself runs through over a texel, which grows without bound as the light grazes it. So the
// receiver's own way to the light is then followed through the field (render/shadow_receiver.glsl) as far as that surface
// reaches: a blocked way is dark whatever the texels say, and what lies beyond the end of what is known of it blocks. Where
// a texel sees something nearer, an edge may run between the texels: the way is followed until it leaves the field. Where it
// has left that by its own range, what a texel holds farther on is another surface, and blocks.
#ifndef RENDER_SHADOW_MAP_GLSL
#define RENDER_SHADOW_MAP_GLSL

#include "render/brdf.glsl"
#include "render/shadow_receiver.glsl"

layout(std430, set = 0, binding = 4) readonly buffer ShadowViewBlock { ShadowView item[]; } shadow_views;
layout(set = 0, binding = 5) uniform sampler2D shadow_atlas;

const float ROUNDING = 1.0 / 1048576.0;
#ifdef RASTERISED
const float SNAPPING = 1.0 / 128.0;
#else
const float SNAPPING = 0.0;
#endif

// What the map holds lies on the receiver's own surface: within this part of the height's scale, or, on a step, of the way
// there.
const float PLACE_ROUNDING = 1.0 / 4096.0;
const float PLACE_SLACK = 1.0 / 16.0;

float weighed(vec4 at, vec3 position) {
    return dot(abs(at.xyz), abs(position)) + abs(at.w);
}

// How much of the light arrives by one map. at: the receiver in texels. w: its clip w.
float map_lit(ShadowView view, vec2 at, float w, Surface surface, vec3 toward, Receiver receiver) {
    vec3 position = surface.position, normal = surface.geometric, axis = view.depth.xyz;
    float depth = dot(axis, position) + view.depth.w;
    bool perspective = view.lens.w != 0.0;
    if (perspective && depth <= 0.0) {
        return 1.0;
    }
    float own = view.lens.x * depth + view.lens.y, change = view.lens.x;
    if (perspective) {
        own /= depth;
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
    float rounding = ROUNDING * (abs(change) * weighed(view.depth, position) + abs(own)
                                 + dot(abs(slope), spread)) + SNAPPING * (abs(slope.x) + abs(slope.y));
#ifdef HAS_HEIGHT
    // Of the buffer's value, per level of lift.
    vec3 lift = receiver.axes[2];
    float lifted = change * dot(axis, toward) * dot(lift, normal) / max(dot(normal, toward), 1e-6);
    float side = receiver.on_wall || dot(lift, normal) >= 0.0 ? 1.0 : -1.0;
#endif
    vec2 first = clamp(floor(at - 0.5), vec2(0.0), vec2(view.lens.z - 2.0));
    vec2 part = clamp(at - 0.5 - first, 0.0, 1.0);
    vec4 stored = textureGather(shadow_atlas, (view.tile.xy + first + 1.0) * view.tile.zw);
    vec4 share = vec4((1.0 - part.x) * part.y, part.x * part.y, part.x * (1.0 - part.y),
                      (1.0 - part.x) * (1.0 - part.y));
    // Of the buffer's value, per unit of the way to the light.
    float nearing = change * dot(axis, toward);
    // How far ahead a texel's surface lies, how far the way to the light has to be known so that it counts, and how far it is
    // followed.
    vec4 aheads, needed = vec4(0.0);
    float farthest = 0.0;
    bool nearer = false;
    for (int i = 0; i < 4; ++i) {
        // A gather's order: lower left, lower right, upper right, upper left.
        vec2 away = first + 0.5 + vec2(i == 1 || i == 2 ? 1.0 : 0.0, i < 2 ? 1.0 : 0.0) - at;
        float over = stored[i] - own - dot(slope, away);
        // In perspective the value is no affine function of the way.
        float bent = perspective ? (own - view.lens.x) / (stored[i] - view.lens.x) : 1.0;
        float ahead = bent * (stored[i] - own) / nearing;
        aheads[i] = ahead;
        if (over > rounding) {
            nearer = true;
            needed[i] = NEVER;
#ifdef HAS_HEIGHT
            if (receiver.followed) {
                vec3 moved = away.x * across + away.y * down;
                bool known = false, ignored;
                Receiver there = receiver;
                float bend = receiver.on_wall ? 0.0 : lifted * stands_over(there, moved, known);
                bool passes = known && over - rounding <= 2.0 * max(bend, 0.0);
                if (!passes) {
                    vec3 place = moved + bent * over / nearing * toward;
                    vec3 slack = (PLACE_SLACK * bent * over + rounding) / nearing * toward;
                    there = receiver;
                    float stands = stands_over(there, place, known);
                    passes = known && (abs(stands) <= PLACE_ROUNDING * material.displacement.x
                                       || side * stands_over(there, place + slack, ignored) <= 0.0
                                          && side * stands_over(there, place - slack, ignored) >= 0.0);
                }
                needed[i] = passes ? ahead : NEVER;
            }
#endif
        }
        farthest = needed[i] < NEVER ? max(farthest, ahead) : farthest;
    }
    float clear = farthest, left = NEVER;
#ifdef HAS_HEIGHT
    if (receiver.followed && any(lessThan(needed, vec4(NEVER))) && (nearer || farthest > rounding / nearing)) {
        // Seen from the light, the surface within a texel or two is no farther than that beyond the levels of the way.
        float texel = w / min(length(view.x.xyz), length(view.y.xyz));
        clear = field_clear(receiver, toward, side, farthest, nearer, 2.0 * texel / length(lift), left);
    }
#endif
    return dot(share, vec4(lessThanEqual(needed, vec4(clear))) * vec4(lessThanEqual(aheads, vec4(left))));
}

// What the maps say of each light at a receiver, in `visibility`.
Visibility mapped_visibility(Visibility visibility, Surface surface, Receiver receiver) {
    for (int i = 0; i < SHADOWED_LIGHTS; ++i) {
        Light light = lights[i];
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
                visibility.light[i] *= map_lit(view, at, w, surface, toward, receiver);
                break;
            }
        }
    }
    return visibility;
}

#endif
