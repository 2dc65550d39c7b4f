// Our bindings. Set 0: the frame; set 1: one primitive and its material. The structs come from render/layout.rs.
#ifndef RENDER_INTERFACE_GLSL
#define RENDER_INTERFACE_GLSL

#include "layout.glsl"
#include "shell/work.glsl"

// Of a fragment's inputs: taken at the sample that it is alone for.
#ifdef SAMPLE_SHADING
#define PER_SAMPLE sample
#else
#define PER_SAMPLE
#endif

layout(std140, set = 0, binding = 0) uniform FrameBlock { Frame frame; };
// What all lanes read alike lies in uniform buffers: lavapipe reads storage lane by lane.
layout(std140, set = 0, binding = 1) uniform ObjectBlock { Object drawn; };
#if defined(STORED_LIGHTS)
layout(std430, set = 0, binding = 2) readonly buffer LightBlock { Light lights[]; };
#elif defined(LIGHTS)
layout(std140, set = 0, binding = 2) uniform LightBlock { Light lights[LIGHTS]; };
#endif
#if defined(COUNT_LIMITS) || defined(COUNT_READS)
layout(std430, set = 0, binding = 3) buffer CounterBlock { Counters item; } counters;
#endif

#ifdef VIEW_LIMITS
// Of this fragment.
uint limits_reached = 0u;
#endif

// Counts loops that gave up, where they are counted.
void count_limits(int limits) {
#ifdef VIEW_LIMITS
    limits_reached += uint(limits);
#endif
#ifdef COUNT_LIMITS
    if (limits > 0) {
        atomicAdd(counters.item.limits, uint(limits));
    }
#endif
}

// Counts what the fragment has read of height maps, where that is counted.
void count_reads() {
#ifdef COUNT_READS
    atomicAdd(counters.item.reads, height_reads);
    height_reads = 0u;
#endif
}

layout(std430, set = 1, binding = 0) readonly buffer VertexBlock { Vertex item[]; } vertices;
layout(std430, set = 1, binding = 1) readonly buffer PrismBlock { PrismData item[]; } prisms;
layout(std140, set = 1, binding = 2) uniform MaterialBlock { Material material; };

// A vertex's coordinates in the height map.
vec2 height_uv_of(Vertex vertex) {
    return vec2(vertex.shell.w, vertex.normal.w);
}

// Whether hits from behind count. To light both sides are alike: whatever stands in its way blocks it.
bool hits_from_behind() {
#ifdef BLOCKS_LIGHT
    return true;
#else
    return (material.march.w & 1u) != 0u;
#endif
}

layout(push_constant) uniform DrawBlock { Draw draw; };

vec3 transform_point(vec4 x, vec4 y, vec4 z, vec3 p) {
    precise vec3 value = vec3(dot(x.xyz, p) + x.w, dot(y.xyz, p) + y.w, dot(z.xyz, p) + z.w);
    return value;
}

vec3 transform_direction(vec4 x, vec4 y, vec4 z, vec3 d) {
    precise vec3 value = vec3(dot(x.xyz, d), dot(y.xyz, d), dot(z.xyz, d));
    return value;
}

// The pixel at `frag`, a fragment's coordinates in the target, of which the picture may be a part.
vec2 pixel_ndc(vec2 frag) {
    return (frag - frame.origin.xy) * frame.viewport.zw * 2.0 - 1.0;
}

// What the depth buffer holds at a view depth: reversed, 1 at the near plane.
float buffer_depth(float view_depth) {
    float z = frame.lens.x * view_depth + frame.lens.y;
    return frame.projection.x != 0u ? z / view_depth : z;
}

#endif
