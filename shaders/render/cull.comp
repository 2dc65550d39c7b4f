#version 460
#extension GL_GOOGLE_include_directive : require
// Lists the items of a draw that may show, in the order in which they were: those of each workgroup for an indirect draw.
#include "render/culling.glsl"

layout(local_size_x = 64) in;

// Items of a workgroup; engine/src/render/culling.rs has it too.
const uint CHUNK = 512u;

#ifdef WALK_LIDS
const uint VERTICES = 3u;
#else
const uint VERTICES = 1u;
#endif

layout(std430, set = 1, binding = 18) writeonly buffer KeptBlock { uint item[]; } kept;
// VkDrawIndirectCommand: vertices, instances, first vertex, first instance.
layout(std430, set = 1, binding = 21) writeonly buffer CommandBlock { uvec4 item[]; } commands;

shared uint lanes[gl_WorkGroupSize.x];

void main() {
    uint lane = gl_LocalInvocationIndex;
    uint first = gl_WorkGroupID.x * CHUNK, count = 0u;
    for (uint start = first; start < min(first + CHUNK, draw.count); start += gl_WorkGroupSize.x) {
        uint item = start + lane;
        bool keep = item < draw.count && keeps(item);
        lanes[lane] = uint(keep);
        barrier();
        uint before = count;
        for (uint i = 0u; i < gl_WorkGroupSize.x; ++i) {
            before += i < lane ? lanes[i] : 0u;
            count += lanes[i];
        }
        if (keep) {
            kept.item[first + before] = item;
        }
        barrier();
    }
    if (lane == 0u) {
        commands.item[gl_WorkGroupID.x] = uvec4(VERTICES * count, 1u, VERTICES * first, 0u);
    }
}
