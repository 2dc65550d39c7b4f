// What the task stage hands to the mesh stage that makes prisms' outlines.
#ifndef RENDER_KEPT_PRISMS_GLSL
#define RENDER_KEPT_PRISMS_GLSL

// Prisms of a mesh workgroup.
const uint PRISMS_PER_GROUP = 24u;

#ifdef CULLED
// Of a task workgroup: four of these at most. engine/src/render/mod.rs has it too.
const uint PRISMS_PER_TASK = 96u;

struct KeptPrisms {
    uint count;
    uint items[PRISMS_PER_TASK];
};
taskPayloadSharedEXT KeptPrisms kept;
#endif

#endif
