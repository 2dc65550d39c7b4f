#version 460
#extension GL_GOOGLE_include_directive : require
// A vertex's place, shading normal and tangent in the pose.
#include "render/deform.glsl"

// Three floats a vertex.
layout(std430, set = 0, binding = 7) readonly buffer PositionBlock { float item[]; } positions;
#ifdef NORMALS_GIVEN
layout(std430, set = 0, binding = 8) readonly buffer NormalBlock { float item[]; } normals;
#endif

vec3 position(uint vertex) {
    return vec3(positions.item[3u * vertex], positions.item[3u * vertex + 1u], positions.item[3u * vertex + 2u]);
}

// The mean of the triangles' normals around the smoothing group, weighted by corner angle.
vec3 normal_of(uint vertex) {
#ifdef NORMALS_GIVEN
    return vec3(normals.item[3u * vertex], normals.item[3u * vertex + 1u], normals.item[3u * vertex + 2u]);
#else
    vec3 sum = vec3(0.0);
    uvec2 fan = fan_of(deform.smooth_fans, mesh_vertices.item[vertex].ids.y);
    for (uint i = fan.x; i < fan.y; ++i) {
        uint corner = fans.item[i] & 3u;
        uvec4 at = triangles.item[fans.item[i] >> 2].corners;
        vec3 p = position(at[corner]);
        vec3 e1 = position(at[(corner + 1u) % 3u]) - p, e2 = position(at[(corner + 2u) % 3u]) - p;
        sum += angle_between(e1, e2) * unit_or_zero(cross(e1, e2));
    }
    float size = length(sum);
    // Triangles that cancel out, or have no area, leave any direction as good as another.
    return size > 0.0 ? sum / size : vec3(0.0, 0.0, 1.0);
#endif
}

// The mean of the triangles' tangents around the vertex within the plane across its normal, as MikkTSpace takes it.
vec3 tangent_of(uint vertex, vec3 normal) {
    vec3 sum = vec3(0.0);
    uvec2 fan = fan_of(deform.vertex_fans, vertex);
    for (uint i = fan.x; i < fan.y; ++i) {
        uint corner = fans.item[i] & 3u;
        uvec4 at = triangles.item[fans.item[i] >> 2].corners;
        uint b = at[(corner + 1u) % 3u], c = at[(corner + 2u) % 3u];
        vec3 p = position(vertex), e1 = position(b) - p, e2 = position(c) - p;
        vec2 uv = mesh_vertices.item[vertex].tangent.xy;
        vec2 d1 = mesh_vertices.item[b].tangent.xy - uv, d2 = mesh_vertices.item[c].tangent.xy - uv;
        vec3 along = d2.y * e1 - d1.y * e2;
        along *= d1.x * d2.y - d2.x * d1.y < 0.0 ? -1.0 : 1.0;
        along = unit_or_zero(along - dot(along, normal) * normal);
        e1 -= dot(e1, normal) * normal;
        e2 -= dot(e2, normal) * normal;
        sum += angle_between(e1, e2) * along;
    }
    sum = unit_or_zero(sum);
    vec3 across = abs(normal.x) < 0.5 ? vec3(1.0, 0.0, 0.0) : vec3(0.0, 1.0, 0.0);
    return sum != vec3(0.0) ? sum : normalize(cross(normal, across));
}

void main() {
    uint vertex = gl_GlobalInvocationID.x;
    if (vertex >= deform.count) {
        return;
    }
    vec3 normal = normal_of(vertex);
    float hand = mesh_vertices.item[vertex].tangent.z;
    posed.item[vertex].position = vec4(position(vertex) - deform.center.xyz, 0.0);
    posed.item[vertex].normal = vec4(normal, 0.0);
    posed.item[vertex].tangent = hand != 0.0 ? vec4(tangent_of(vertex, normal), hand) : vec4(0.0);
}
