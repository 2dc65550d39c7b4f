// Counts what a ray costs, for a picture of it: reads of heights, bounds and cones with VIEW_GATHERS, prisms of a pixel's
// walk with VIEW_WALK; and with COUNT_READS all reads of an invocation, for its includer to add up. Without them nothing of
// it is left in the code.
#ifndef SHELL_WORK_GLSL
#define SHELL_WORK_GLSL

#if defined(VIEW_GATHERS) || defined(VIEW_WALK)
uint work = 0u;
#endif
#ifdef COUNT_READS
uint height_reads = 0u;
#endif

void count_read() {
#ifdef VIEW_GATHERS
    ++work;
#endif
#ifdef COUNT_READS
    ++height_reads;
#endif
}

void count_prism() {
#ifdef VIEW_WALK
    ++work;
#endif
}

#endif
