#version 460
#extension GL_GOOGLE_include_directive : require
#ifdef MESH_STAGE
#extension GL_EXT_mesh_shader : require
#endif
// The pixel's ray in one prism: exact interval, march, depth of the hit. Without a height (no HAS_HEIGHT) all prisms
// are plain triangles.
#include "render/interface.glsl"

#include "shell/prism.glsl"
#include "shell/prism_bits.glsl"
#ifdef HAS_HEIGHT
#include "render/height_field.glsl"
#include "render/other_fields.glsl"
#include "shell/march.glsl"
#include "render/dither.glsl"
#include "render/march_settings.glsl"
#endif
#include "render/shell_shade.glsl"

#ifdef MESH_STAGE
layout(location = 0) perprimitiveEXT flat in uint in_prism;
#else
layout(location = 0) flat in uint in_prism;
#endif

void main() {
    Object object = drawn;
    PrismData data = prisms.item[in_prism];
    Vertex v[3] = Vertex[3](vertices.item[data.corners[0]], vertices.item[data.corners[1]],
                            vertices.item[data.corners[2]]);
    vec2 ndc = pixel_ndc(ray_point());
#ifdef LOD_FADE
    fade_heights(object, ndc);
#endif

    ProjectedPrism projected;
    vec3 depth, slope;
    for (int k = 0; k < 3; ++k) {
        vec3 p = transform_point(object.clip_x, object.clip_y, object.clip_w, v[k].position.xyz);
        vec3 q = transform_direction(object.clip_x, object.clip_y, object.clip_w, v[k].shell.xyz);
        projected.p[k] = across_ray(p, ndc);
        projected.q[k] = across_ray(q, ndc);
        projected.descending[k] = wall_descends(data.corners.w, k);
        depth[k] = dot(object.depth.xyz, v[k].position.xyz) + object.depth.w;
        slope[k] = dot(object.depth.xyz, v[k].shell.xyz);
    }
    bool two_sided = hits_from_behind();
#ifdef HAS_HEIGHT
    Prism prism;
    for (int k = 0; k < 3; ++k) {
        prism.uv[k] = height_uv_of(v[k]);
        prism.neighbour_uv[k] = data.neighbour_uv[k];
        prism.wall[k] = wall_kind(data.corners.w, k);
        prism.field[k] = wall_field(data.corners.w, k);
        prism.behind[k] = wall_behind(data.corners.w, k);
    }
    prism.t0 = height_share * data.range.x;
    prism.t1 = height_share * data.range.y;
    prism.plain = is_plain(data.corners.w);
    enter_prism(data.corners.w);
    MarchSettings settings = march_settings();

    ShellHit hit = prism_trace(projected, prism, settings, depth, slope, frame.lens.z, object.handedness.x);
    count_limits(hit.limits);
#else
    ShellHit hit = plain_trace(projected, two_sided, depth, frame.lens.z, object.handedness.x);
#endif
    if (!hit.hit || hit.depth > frame.lens.w) {
        count_reads();
        if (write_missed()) {
            return;
        }
        discard;
    }
#ifdef VIEW_PRISMS
    seen_prism = in_prism;
#endif

#ifdef HAS_HEIGHT
    shade_hit(object, in_prism, data.corners.xyz, v, ndc, prism, settings, hit);
    count_reads();
#else
    Shaded shaded = shaded_at(object, in_prism, data.corners.xyz, v, ndc, hit, vec2(0.0), false);
    write_shaded(shaded, hit, material.displacement.y);
#endif
}
