#version 460
#extension GL_GOOGLE_include_directive : require
#ifdef MESH_STAGE
#extension GL_EXT_mesh_shader : require
#endif
// The pixel's ray in one prism: exact interval, march, depth of the hit.
#include "render/interface.glsl"

#include "render/height_field.glsl"
#include "shell/prism.glsl"
#include "shell/march.glsl"
#include "render/shell_shade.glsl"

#ifdef MESH_STAGE
layout(location = 0) perprimitiveEXT flat in uint in_prism;
#else
layout(location = 0) flat in uint in_prism;
#endif

void main() {
    Object object = objects.item[draw.object];
    PrismData data = prisms.item[in_prism];
    Vertex v[3] = Vertex[3](vertices.item[data.corners[0]], vertices.item[data.corners[1]],
                            vertices.item[data.corners[2]]);
    vec2 ndc = gl_FragCoord.xy * frame.viewport.zw * 2.0 - 1.0;

    ProjectedPrism projected;
    Prism prism;
    vec3 depth, slope;
    for (int k = 0; k < 3; ++k) {
        vec3 p = transform_point(object.clip_x, object.clip_y, object.clip_w, v[k].position.xyz);
        vec3 q = transform_direction(object.clip_x, object.clip_y, object.clip_w, v[k].shell.xyz);
        projected.p[k] = across_ray(p, ndc);
        projected.q[k] = across_ray(q, ndc);
        projected.descending[k] = bitfieldExtract(data.corners.w, 9 + k, 1) != 0u;
        prism.uv[k] = vec2(v[k].shell.w, v[k].normal.w);
        prism.neighbour_uv[k] = data.neighbour_uv[k];
        prism.wall[k] = bitfieldExtract(data.corners.w, 3 * k, 3);
        depth[k] = dot(object.depth.xyz, v[k].position.xyz) + object.depth.w;
        slope[k] = dot(object.depth.xyz, v[k].shell.xyz);
    }
    prism.t0 = data.range.x;
    prism.t1 = data.range.y;
    prism.plain = bitfieldExtract(data.corners.w, 12, 1) != 0u;
    MarchSettings settings;
    settings.scale = material.displacement.x;
    settings.midlevel = material.displacement.y;
    settings.min_steps = int(material.march.x);
    settings.max_steps = int(material.march.y);
    settings.refine_steps = int(material.march.z);
    settings.map_size = height_size();
    settings.two_sided = (material.march.w & 1u) != 0u;
    settings.step_limit = int(material.march.w >> 1);

    ShellHit hit = prism_trace(projected, prism, settings, depth, slope, frame.lens.z, object.handedness.x);
#ifdef COUNT_LIMITS
    if (hit.limits > 0) {
        atomicAdd(counters.limits, uint(hit.limits));
    }
#endif
    if (!hit.hit || hit.depth > frame.lens.w) {
        discard;
    }

    shade_hit(object, v, ndc, prism, settings, hit);
}
