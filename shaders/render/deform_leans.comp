#version 460
#extension GL_GOOGLE_include_directive : require
// Marks welded vertices whose shell normal is zero or leans too far against a lid or base around it: a ray may slip
// past the lids there.
#include "render/deform.glsl"
#include "shell/lean.glsl"

void main() {
    uint index = gl_GlobalInvocationID.x;
    if (index >= deform.count) {
        return;
    }
    uvec3 at = triangles.item[index].corners.xyz, weld;
    vec3 shell[3];
    for (int k = 0; k < 3; ++k) {
        weld[k] = mesh_vertices.item[at[k]].ids.x;
        // Others may set their mark meanwhile.
        shell[k] = fold_factor(weld[k], atomicOr(folds.item[weld[k]], 0u)) * shell_normals.item[weld[k]].xyz;
    }
    for (int side = 0; side < 2; ++side) {
        vec3 p[3];
        for (int k = 0; k < 3; ++k) {
            p[k] = posed.item[at[k]].position.xyz + mesh_vertices.item[at[k]].levels[side] * shell[k];
        }
        vec3 normal = unit_or_zero(cross(p[1] - p[0], p[2] - p[0]));
        for (int k = 0; k < 3; ++k) {
            if (leans(normal, shell[k])) {
                atomicOr(folds.item[weld[k]], LEANS);
            }
        }
    }
}
