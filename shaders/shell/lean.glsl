// How far a shell normal may lean against a lid or base before that is not enough to find a ray by.
#ifndef SHELL_LEAN_GLSL
#define SHELL_LEAN_GLSL

// As in engine/src/shell/walk.rs.
const float LEAST_COSINE = 0.05;

// Shell normals are 1 long, less where prisms would fold (DESIGN section 1). Below this the growth of a lid shrinks with
// them: as levels it stays alike over a lid, or these would be far from what the lid's planes are.
const float LEAST_NORMAL = 0.5;

// Whether growth along `shell` does not widen the outline enough. lid_normal: unit or zero.
bool leans(vec3 lid_normal, vec3 shell) {
    return dot(lid_normal, shell) < LEAST_COSINE * max(length(shell), LEAST_NORMAL);
}

#endif
