// What the classic marches share: where a linear search takes its samples, and how it gets from the two between which it
// crossed the field to the hit.
//
// The includer gives a struct SearchPath and `float clearance(SearchPath path, float at)`: the height of the ray over
// the field at `at`, which runs from 0 to 1 along the ray. MARCH_STEEP, MARCH_RELIEF, MARCH_SECANT, MARCH_CONTACT or
// none of them (POM) chooses how. Cost: one height a refinement; none for steep and POM.
#ifndef SHELL_REFINE_GLSL
#define SHELL_REFINE_GLSL

// A linear search of `steps` steps takes so many samples after the one at 0; the i-th lies at sample_at, the last at 1.
// With DITHERED_START the includer's search_start, between 0 and 1, says how long the first step is.
#ifdef DITHERED_START
float search_start();

int sample_count(int steps) {
    return steps + 1;
}
#else
float search_start() {
    return 1.0;
}

int sample_count(int steps) {
    return steps;
}
#endif

float sample_at(int i, int steps, float start) {
    return min((float(i - 1) + start) / float(steps), 1.0);
}

struct Bracket {
    float a, fa; // the last sample before the crossing and its clearance
    float b, fb; // the first one beyond it
};

struct Refinement {
    int steps;       // bisections, secant steps, fine linear steps
    float tolerance; // secant: the clearance, in levels, that counts as a hit
};

// Where the line through both samples meets the field.
float chord_root(Bracket x) {
    return mix(x.a, x.b, x.fa == x.fb ? 0.5 : clamp(x.fa / (x.fa - x.fb), 0.0, 1.0));
}

// The part of the bracket that holds the crossing, cut at `at`. above: the side that the ray comes from.
Bracket narrowed(Bracket x, float at, float f, bool above) {
    if ((f >= 0.0) == above) {
        return Bracket(at, f, x.b, x.fb);
    }
    return Bracket(x.a, x.fa, at, f);
}

float refined(SearchPath path, Refinement by, Bracket x, bool above) {
#if defined(MARCH_STEEP)
    // The first sample beyond the field, as it is: layers (McGuire and McGuire 2005).
    return x.b;
#elif defined(MARCH_SECANT)
    // False position (Risser, Shah and Pattanaik 2006, "interval mapping").
    float at = chord_root(x);
    for (int i = 0; i < by.steps; ++i) {
        float f = clearance(path, at);
        if (abs(f) <= by.tolerance) {
            break;
        }
        x = narrowed(x, at, f, above);
        at = chord_root(x);
    }
    return at;
#else
#if defined(MARCH_RELIEF)
    // Bisection (Policarpo, Oliveira and Comba 2005).
    for (int i = 0; i < by.steps; ++i) {
        float m = 0.5 * (x.a + x.b);
        x = narrowed(x, m, clearance(path, m), above);
    }
#elif defined(MARCH_CONTACT)
    // A second linear search, with finer steps, between the two samples (Riccardi, "contact refinement").
    Bracket fine = x;
    for (int i = 1; i <= by.steps; ++i) {
        fine.b = mix(x.a, x.b, float(i) / float(by.steps));
        fine.fb = i == by.steps ? x.fb : clearance(path, fine.b);
        if ((fine.fb >= 0.0) != above) {
            break;
        }
        fine.a = fine.b;
        fine.fa = fine.fb;
    }
    x = fine;
#endif
    // Linear between the two samples: all of POM (Tatarchuk 2006), and what the others leave of the bracket.
    return chord_root(x);
#endif
}

#endif
