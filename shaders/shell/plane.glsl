// The classic parallax techniques: the height field over the tangent plane of a base surface point.
//
// Near the point the surface is taken as flat, so the ray is straight in texture space: at level t above the plane its
// coordinates are uv + t * slope. Needs the height hook `height_at` (exact: `height_size` too; cones: shell/cone.glsl).
// Cost: one height a step.
#ifndef SHELL_PLANE_GLSL
#define SHELL_PLANE_GLSL

struct PlaneRay {
    vec2 uv;      // of the base surface point, level 0
    vec2 slope;   // change of uv per level, along the ray
    float cosine; // |cos| between ray and normal
};

struct PlaneMarch {
    float scale, midlevel; // level = (height - midlevel) * scale; negative scale: seen from behind
    float t0, t1;          // range of levels
    int min_steps, max_steps, refine_steps;
    int step_limit;  // exact: see MarchSettings
    float tolerance; // secant: of the height's range
    float lod;       // at which every height on the way is read
};

struct PlaneHit {
    float t; // level
    vec2 uv;
    int limits; // loops that gave up
};

// How a vector of mesh space moves uv within the plane of `normal`: from the derivatives of position and uv over the
// screen, hence in true proportion under any parametrisation (surface-gradient form, Mikkelsen 2010, eq. 3 to 5).
mat3x2 uv_jacobian(vec3 position_x, vec3 position_y, vec2 uv_x, vec2 uv_y, vec3 normal) {
    vec3 r1 = cross(position_y, normal), r2 = cross(normal, position_x);
    float det = dot(position_x, r1);
    float inverse = abs(det) > 0.0 ? 1.0 / det : 0.0;
    return mat3x2(inverse * (r1.x * uv_x + r2.x * uv_y), inverse * (r1.y * uv_x + r2.y * uv_y),
                  inverse * (r1.z * uv_x + r2.z * uv_y));
}

// The same from the mesh's tangents (surface-gradient form too): with c = normal x unit tangent, u gains `tangent.xyz` and
// `shear` times c, v gains -tangent.w times c. So the tangent has the length of grad u along it, and its w, whose sign is
// the handedness, that of grad v. normal: unit, of the mesh, whichever side is seen.
mat3x2 frame_jacobian(vec3 normal, vec4 tangent, float shear) {
    vec3 along = tangent.xyz - normal * dot(normal, tangent.xyz);
    vec3 across = cross(normal, along) * inversesqrt(max(dot(along, along), 1e-37));
    vec3 u = along + shear * across, v = -tangent.w * across;
    return mat3x2(u.x, v.x, u.y, v.y, u.z, v.z);
}

// The ray along `direction` (mesh space, any length) through a point with unit `normal`. The cosine is kept off zero, at
// `least`: there the plane is seen edge-on and the approximation has no answer.
PlaneRay plane_ray(vec2 uv, mat3x2 jacobian, vec3 direction, vec3 normal, float least) {
    direction = normalize(direction);
    float along = dot(direction, normal);
    float cosine = max(abs(along), least);
    vec3 tangential = direction - along * normal;
    return PlaneRay(uv, jacobian * tangential / (along < 0.0 ? -cosine : cosine), cosine);
}

float plane_level(PlaneMarch march, vec2 uv) {
    return (height_at(uv, march.lod) - march.midlevel) * march.scale;
}

// More steps the flatter the ray (Tatarchuk 2006).
int plane_steps(PlaneMarch march, float cosine) {
    return int(mix(float(march.max_steps), float(march.min_steps), cosine) + 0.5);
}

#ifdef MARCH_EXACT
// From the top of the range down to the field, exactly. Always ends in a hit: at the bottom at the latest.
PlaneHit plane_trace(PlaneMarch march, PlaneRay ray) {
    vec2 size = height_size();
    vec2 a = (ray.uv + march.t1 * ray.slope) * size - 0.5, b = (ray.uv + march.t0 * ray.slope) * size - 0.5;
    Curve curve;
    curve.origin = ivec2(floor(a));
    a -= vec2(curve.origin);
    b -= vec2(curve.origin);
    curve.x = vec3(a.x, 0.5 * (a.x + b.x), b.x);
    curve.y = vec3(a.y, 0.5 * (a.y + b.y), b.y);
    curve.w = vec3(1.0);
    curve.t = vec2(march.t1, march.t0);
    Field field = Field(march.scale, march.midlevel, 1.0, false);
    vec2 cells = abs(b - a);
    int limit = march.step_limit * (16 + int(min(cells.x + cells.y, 1e5)));
    float t = mix(march.t1, march.t0, min(exact_hit(curve, field, limit), 1.0));
    return PlaneHit(t, ray.uv + t * ray.slope, limit == 0 ? 1 : 0);
}
#elif defined(MARCH_OFFSET)
// No ray: the view direction's tangential part times the height of the point itself. Without the division by the cosine
// the shift never exceeds the height: offset limiting (Kaneko et al. 2001; Welsh 2004).
PlaneHit plane_trace(PlaneMarch march, PlaneRay ray) {
    float t = plane_level(march, ray.uv);
    return PlaneHit(t, ray.uv + t * ray.cosine * ray.slope, 0);
}
#elif defined(MARCH_CONE)
// From the top of the range down to the field, through cones. Always ends in a hit: at the bottom at the latest. Seen
// from behind, the ray comes up to the heights from below them.
PlaneHit plane_trace(PlaneMarch march, PlaneRay ray) {
    vec2 heights = vec2(march.t1, march.t0) / march.scale + march.midlevel;
    ConeRay cone = cone_ray(ray.uv + march.t1 * ray.slope, ray.uv + march.t0 * ray.slope, heights.x, heights.y);
    bool above = march.scale > 0.0;
    int steps = march.max_steps, limits = 0;
    float along = cone_search(cone, ConeSettings(march.refine_steps, true), above, steps, limits);
    float t = mix(march.t1, march.t0, min(along, 1.0));
    return PlaneHit(t, ray.uv + t * ray.slope, limits);
}
#else
struct SearchPath {
    PlaneMarch march;
    PlaneRay ray;
};

float clearance(SearchPath path, float at) {
    float t = mix(path.march.t1, path.march.t0, at);
    return t - plane_level(path.march, path.ray.uv + t * path.ray.slope);
}

#include "shell/refine.glsl"

// From the top of the range down to the field. Always ends in a hit: at the bottom at the latest.
PlaneHit plane_trace(PlaneMarch march, PlaneRay ray) {
    SearchPath path = SearchPath(march, ray);
    int steps = plane_steps(march, ray.cosine);
    float start = search_start();
    float top = clearance(path, 0.0);
    Bracket x = Bracket(0.0, top, 0.0, top);
    for (int i = 1; i <= sample_count(steps) && x.fb > 0.0; ++i) {
        x = Bracket(x.b, x.fb, sample_at(i, steps, start), 0.0);
        x.fb = clearance(path, x.b);
    }
    Refinement by = Refinement(march.refine_steps, march.tolerance * abs(march.scale));
    float t = mix(march.t1, march.t0, x.fb > 0.0 ? 1.0 : refined(path, by, x, true));
    return PlaneHit(t, ray.uv + t * ray.slope, 0);
}
#endif

// How much of the light along `ray` (from the base point toward the light) is seen from the field at the hit's
// coordinates: 1 or 0, or, while a penumbra is open, what that says (shell/soft.glsl). Not from the hit: that lies beside
// the field by what its march leaves, up to a step below it, where no light comes.
float plane_lit(PlaneMarch march, PlaneHit hit, PlaneRay ray, int steps) {
    float from = plane_level(march, hit.uv), top = march.t1;
#ifdef SOFT_SHADOW
    // As high as what is below may hide something of the disc.
    float gain = ray.cosine - penumbra.spread;
    top += min(penumbra.headroom, gain > 0.0 ? penumbra.spread * (march.t1 - from) / gain : penumbra.headroom);
#endif
    float rounding = 1e-4 * (march.t1 - march.t0);
    for (int i = 1; i <= steps; ++i) {
        float t = mix(from, top, float(i) / float(steps));
        float level = plane_level(march, hit.uv + (t - from) * ray.slope);
        if (level > t + rounding) {
            return 0.0;
        }
#ifdef SOFT_SHADOW
        penumbra_see(t + rounding - level, (t - from) / ray.cosine);
#endif
    }
#ifdef SOFT_SHADOW
    return penumbra_seen();
#else
    return 1.0;
#endif
}

#endif
