// Which prism lies across each wall of each prism.
#ifndef RENDER_ADJACENCY_GLSL
#define RENDER_ADJACENCY_GLSL

// Three a prism: 4 times the neighbour and the number of its wall, or NO_NEIGHBOUR.
layout(std430, set = 1, binding = 10) readonly buffer AdjacencyBlock { uint item[]; } adjacency;

#endif
