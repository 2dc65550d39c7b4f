// Dicing without cracks: a base triangle is cut into splits² patches, a patch's edges into steps. How an edge of the base
// triangle is divided follows from the edge alone: into parts, each of which has a number of steps of its own. A patch
// that is smaller than such a part takes the part's nearest points for its own. Within a triangle the same holds for
// the edges of patches. All shares are of whole numbers, so both sides come to the same point to the bit.
//
// The including shader defines MOST_STEPS, into how many steps an edge of a patch is cut at most.
#ifndef BASELINE_DICING_GLSL
#define BASELINE_DICING_GLSL

#include "render/interface.glsl"
#include "render/vertex_streams.glsl"
#include "render/height_field.glsl"

layout(std430, set = 1, binding = 17) readonly buffer DicedTriangleBlock { DicedTriangle item[]; } diced_triangles;

// The steepest that dicing may make heights seem; as in engine/src/render/baseline/dice.rs.
const float STEEPEST = 8.0;

// Steps along an edge of a patch. Of an edge that lies on one of the triangle's: the share of that edge at which they
// begin and end is first / whole and last / whole; else `whole` is 0.
struct PatchEdge {
    int steps, first, last, whole;
};

// A patch. Corners count in parts of 1 / splits toward the triangle's corners; edge k joins corners k + 1 and k + 2.
struct Patch {
    uint triangle;
    ivec3 corners[3];
    ivec2 shares[3]; // of a corner on an edge of the triangle: its place there, as numerator and denominator
    PatchEdge edges[3];
};

// A point of the surface: three vertices that stand for it, and their weights.
struct Place {
    uvec3 vertices;
    vec3 weights;
    vec3 lambda; // its weights in the triangle
};

// The vertices that stand for an edge's ends.
uvec2 edge_ends(DicedTriangle triangle, int k) {
    return k == 0 ? triangle.edges.xy : k == 1 ? triangle.edges.zw : triangle.last_edge.xy;
}

bool is_turned(DicedTriangle triangle, int k) {
    return ((triangle.corners.w >> k) & 1u) != 0u;
}

// The base surface at a share of an edge.
vec3 on_edge(uvec2 ends, float share) {
    precise vec3 p = (1.0 - share) * vertices.item[ends.x].position.xyz + share * vertices.item[ends.y].position.xyz;
    return p;
}

float depth_of(Object object, vec3 p) {
    precise float depth = dot(object.depth.xyz, p) + object.depth.w;
    return depth;
}

// Steps from a to b, were all of it as far off as `depth`: of the sphere around both, so that displacement shows even
// where they are in line with the eye.
float steps_at(Object object, vec3 a, vec3 b, float depth) {
    precise vec3 across = transform_point(object.world_x, object.world_y, object.world_z, a) -
                          transform_point(object.world_x, object.world_y, object.world_z, b);
    precise float squared = dot(across, across);
    precise float steps = sqrt(squared) * draw.fineness / (frame.projection.x != 0u ? max(depth, frame.lens.z) : 1.0);
    return steps;
}

int steps_between(Object object, vec3 a, vec3 b) {
    precise float middle = 0.5 * (depth_of(object, a) + depth_of(object, b));
    return int(clamp(ceil(steps_at(object, a, b, middle)), 1.0, float(MOST_STEPS)));
}

// Parts of an edge of the triangle, a power of two.
int parts_of(Object object, uvec2 ends) {
    vec3 a = vertices.item[ends.x].position.xyz, b = vertices.item[ends.y].position.xyz;
    float steps = steps_at(object, a, b, min(depth_of(object, a), depth_of(object, b)));
    int parts = 1;
    while (parts < int(draw.splits) && float(parts * MOST_STEPS) < steps) {
        parts *= 2;
    }
    return parts;
}

int steps_of_part(Object object, uvec2 ends, int parts, int part) {
    return steps_between(object, on_edge(ends, float(part) / float(parts)), on_edge(ends, float(part + 1) / float(parts)));
}

// The step nearest to `place` of `size` places along a part.
int nearest_step(int place, int size, int steps) {
    return (2 * place * steps + size) / (2 * size);
}

// Where a patch's corner goes that is `place` splits along an edge.
ivec2 share_of(Object object, uvec2 ends, int place) {
    int parts = parts_of(object, ends), size = int(draw.splits) / parts;
    int part = min(place / size, parts - 1), rest = place - part * size;
    int steps = rest == 0 || rest == size ? 1 : steps_of_part(object, ends, parts, part);
    int at = nearest_step(rest, size, steps);
    // One way to write what is a part's end.
    return at == 0 ? ivec2(part, parts) : at == steps ? ivec2(part + 1, parts) : ivec2(part * steps + at, parts * steps);
}

int zeros(ivec3 corner) {
    return int(corner.x == 0) + int(corner.y == 0) + int(corner.z == 0);
}

// The edge that a corner with one zero lies on.
int edge_of(ivec3 corner) {
    return corner.x == 0 ? 0 : corner.y == 0 ? 1 : 2;
}

// How many splits a corner lies along an edge, from the first of its ends.
int place_along(DicedTriangle triangle, ivec3 corner, int k) {
    return corner[(is_turned(triangle, k) ? k + 1 : k + 2) % 3];
}

vec3 base_at(DicedTriangle triangle, ivec3 corner) {
    vec3 lambda = vec3(corner) / float(draw.splits);
    precise vec3 p = lambda.x * vertices.item[triangle.corners.x].position.xyz +
                     lambda.y * vertices.item[triangle.corners.y].position.xyz +
                     lambda.z * vertices.item[triangle.corners.z].position.xyz;
    return p;
}

// The patch of a number in the draw.
Patch patch_of(uint item) {
    Object object = drawn;
    int splits = int(draw.splits);
    Patch patch_;
    patch_.triangle = draw.first + item / (draw.splits * draw.splits);
    DicedTriangle triangle = diced_triangles.item[patch_.triangle];
    // Row by row away from corner 0; in a row the ones that stand like the triangle take turns with the others.
    int within = int(item % (draw.splits * draw.splits));
    int row = int(sqrt(float(within)));
    row -= int(row * row > within);
    row += int((row + 1) * (row + 1) <= within);
    int column = within - row * row;
    bool upright = column % 2 == 0;
    int across = (column + 1) / 2;
    ivec3 low = upright ? ivec3(splits - 1 - row, row - across, across) : ivec3(splits - row, row - across + 1, across);
    int step_ = upright ? 1 : -1;
    for (int k = 0; k < 3; ++k) {
        ivec3 corner = low;
        corner[k] += step_;
        patch_.corners[k] = corner;
        int edge = edge_of(corner);
        patch_.shares[k] = zeros(corner) == 1
            ? share_of(object, edge_ends(triangle, edge), place_along(triangle, corner, edge))
            : ivec2(0, 1);
    }
    for (int k = 0; k < 3; ++k) {
        ivec3 a = patch_.corners[(k + 1) % 3], b = patch_.corners[(k + 2) % 3];
        if (a[k] == 0 && b[k] == 0) {
            uvec2 ends = edge_ends(triangle, k);
            int parts = parts_of(object, ends), size = splits / parts;
            int first = place_along(triangle, a, k), last = place_along(triangle, b, k);
            int part = min(first, last) / size, steps = steps_of_part(object, ends, parts, part);
            first = nearest_step(first - part * size, size, steps);
            last = nearest_step(last - part * size, size, steps);
            patch_.edges[k] = PatchEdge(abs(last - first), part * steps + first, part * steps + last, parts * steps);
        } else {
            patch_.edges[k] = PatchEdge(steps_between(object, base_at(triangle, a), base_at(triangle, b)), 0, 0, 0);
        }
    }
    return patch_;
}

Place corner_place(DicedTriangle triangle, int k) {
    uint anchor = triangle.anchors[k];
    vec3 lambda = vec3(k == 0, k == 1, k == 2);
    return Place(uvec3(anchor), vec3(1.0, 0.0, 0.0), lambda);
}

Place edge_place(DicedTriangle triangle, int k, int part, int whole) {
    bool turned = is_turned(triangle, k);
    int from = (turned ? k + 2 : k + 1) % 3, to = (turned ? k + 1 : k + 2) % 3;
    if (part == 0) {
        return corner_place(triangle, from);
    }
    if (part == whole) {
        return corner_place(triangle, to);
    }
    float share = float(part) / float(whole);
    vec3 lambda = vec3(0.0);
    lambda[from] = 1.0 - share;
    lambda[to] = share;
    return Place(edge_ends(triangle, k).xyy, vec3(1.0 - share, share, 0.0), lambda);
}

Place inner_place(DicedTriangle triangle, vec3 lambda) {
    return Place(triangle.corners.xyz, lambda, lambda);
}

// Corner k of a patch.
Place patch_corner(Patch patch_, DicedTriangle triangle, int k) {
    ivec3 corner = patch_.corners[k];
    int edges = zeros(corner);
    if (edges == 2) {
        return corner_place(triangle, corner.x != 0 ? 0 : corner.y != 0 ? 1 : 2);
    }
    if (edges == 1) {
        return edge_place(triangle, edge_of(corner), patch_.shares[k].x, patch_.shares[k].y);
    }
    return inner_place(triangle, vec3(corner) / float(draw.splits));
}

// `along` steps on edge k of a patch, from corner k + 1 toward corner k + 2.
Place patch_edge(Patch patch_, DicedTriangle triangle, int k, int along) {
    PatchEdge edge = patch_.edges[k];
    if (along == 0) {
        return patch_corner(patch_, triangle, (k + 1) % 3);
    }
    if (along == edge.steps) {
        return patch_corner(patch_, triangle, (k + 2) % 3);
    }
    if (edge.whole != 0) {
        int part = edge.first + (edge.last >= edge.first ? along : -along);
        return edge_place(triangle, k, part, edge.whole);
    }
    ivec3 a = patch_.corners[(k + 1) % 3], b = patch_.corners[(k + 2) % 3];
    return inner_place(triangle, vec3(a * (edge.steps - along) + b * along) / float(int(draw.splits) * edge.steps));
}

// Inside a patch.
Place patch_inside(Patch patch_, DicedTriangle triangle, vec3 weights) {
    vec3 lambda = weights.x * vec3(patch_.corners[0]) + weights.y * vec3(patch_.corners[1]) +
                  weights.z * vec3(patch_.corners[2]);
    return inner_place(triangle, lambda / float(draw.splits));
}

vec2 height_uv_of(uint vertex) {
    return height_uv_of(vertices.item[vertex]);
}

// Height map coordinates at a place.
vec2 place_uv(Place place) {
    precise vec2 uv = place.weights.x * height_uv_of(place.vertices.x) + place.weights.y * height_uv_of(place.vertices.y) +
                      place.weights.z * height_uv_of(place.vertices.z);
    return uv;
}

vec3 lifted(uint vertex, float level) {
    precise vec3 p = vertices.item[vertex].position.xyz + level * vertices.item[vertex].shell.xyz;
    return p;
}

// The surface there, mesh space.
vec3 place_position(Place place, float level) {
    precise vec3 p = place.weights.x * lifted(place.vertices.x, level) + place.weights.y * lifted(place.vertices.y, level) +
                     place.weights.z * lifted(place.vertices.z, level);
    return p;
}

float level_of(float height) {
    precise float level = (height - material.displacement.y) * material.displacement.x;
    return level;
}

vec4 clip_position(Object object, vec3 p) {
    vec3 clip = transform_point(object.clip_x, object.clip_y, object.clip_w, p);
    return vec4(clip.xy, frame.lens.x * depth_of(object, p) + frame.lens.y, clip.z);
}

// A vertex for the material shader of any plain surface.
struct DicedVertex {
    vec3 position, normal; // mesh space
    vec4 uvs;
#ifdef VERTEX_TANGENTS
    vec4 tangent;
#endif
};

// The surface at a place, with the authored normals turned by the heights' slope (DESIGN section 4).
DicedVertex diced_vertex(DicedTriangle triangle, Place place) {
    vec2 uv = place_uv(place);
    float level = level_of(height_at(uv, 0.0));
    vec2 slope = height_gradient(uv, 0.0);
    vec3 lambda = place.lambda, at[3], authored = vec3(0.0), lifts = vec3(0.0);
    vec2 uvs[3];
    DicedVertex result;
    result.uvs = vec4(0.0);
#ifdef VERTEX_TANGENTS
    result.tangent = vec4(0.0);
#endif
    for (int k = 0; k < 3; ++k) {
        Vertex vertex = vertices.item[triangle.corners[k]];
        at[k] = vertex.position.xyz + level * vertex.shell.xyz;
        uvs[k] = height_uv_of(vertex);
        lifts += abs(vertex.shell.xyz);
        authored += lambda[k] * vertex.normal.xyz;
        result.uvs += lambda[k] * vertex_uvs(triangle.corners[k], uvs[k]);
#ifdef VERTEX_TANGENTS
        result.tangent += lambda[k] * tangents.item[triangle.corners[k]];
#endif
    }
    vec2 own = lambda.x * uvs[0] + lambda.y * uvs[1] + lambda.z * uvs[2];
    // The coordinates of another triangle may run another way.
    if (place.weights.z == 0.0 && any(greaterThan(abs(own - uv), vec2(1e-3) / height_size()))) {
        slope = height_gradient(own, 0.0);
    }
    slope *= lifts == vec3(0.0) ? 0.0 : material.displacement.x;
    vec3 e = at[1] - at[0], f = at[2] - at[0];
    authored = normalize(authored);
    vec3 normal = length(cross(e, f)) * authored + dot(slope, uvs[1] - uvs[0]) * cross(authored, f) +
                  dot(slope, uvs[2] - uvs[0]) * cross(e, authored);
    result.position = place_position(place, level);
    result.normal = dot(normal, normal) > 0.0 ? normalize(normal) : authored;
    return result;
}

#ifdef CULLS
// What rounding may move a point against the limits of the picture, as a share of its place.
const float ROUNDING = 1e-5;

// How much steeper than the field along the triangle's edges the shapes of a patch's small triangles may make it seem;
// `even`: for a patch whose edges have as many steps as its inside.
float steepness(Patch patch_, float even, float uneven) {
    ivec3 steps = ivec3(patch_.edges[0].steps, patch_.edges[1].steps, patch_.edges[2].steps);
    int most = max(steps.x, max(steps.y, steps.z)), least = min(steps.x, min(steps.y, steps.z));
    for (int k = 0; k < 3; ++k) {
        // Drawn to another's point: no shape is promised.
        if (zeros(patch_.corners[k]) == 1 && draw.splits > 1u) {
            int edge = edge_of(patch_.corners[k]);
            int place = place_along(diced_triangles.item[patch_.triangle], patch_.corners[k], edge);
            least = place * patch_.shares[k].y == patch_.shares[k].x * int(draw.splits) ? least : 0;
        }
    }
    return least == 0 ? STEEPEST + 1.0 : least == most ? even : uneven + even * float(most) / float(least);
}

// Whether nothing of a patch can be seen: it is outside the picture, or all of it faces away. By the hull of its corners at
// the lowest and the highest level, in which all of its surface lies, and a cone around all normals.
bool is_hidden(Patch patch_, float steep) {
    Object object = drawn;
    DicedTriangle triangle = diced_triangles.item[patch_.triangle];
    vec3 points[12];
    for (int k = 0; k < 3; ++k) {
        vec3 lambdas[2] = vec3[2](vec3(patch_.corners[k]) / float(draw.splits), patch_corner(patch_, triangle, k).lambda);
        for (int i = 0; i < 4; ++i) {
            vec3 lambda = lambdas[i / 2];
            float level = (i & 1) == 0 ? triangle.range.x : triangle.range.y;
            points[4 * k + i] = lambda.x * lifted(triangle.corners.x, level) + lambda.y * lifted(triangle.corners.y, level) +
                                lambda.z * lifted(triangle.corners.z, level);
        }
    }
    vec3 below = vec3(0.0), above = vec3(0.0), middle = vec3(0.0); // points beyond each limit
    for (int i = 0; i < 12; ++i) {
        vec3 clip = transform_point(object.clip_x, object.clip_y, object.clip_w, points[i]);
        float depth = depth_of(object, points[i]);
        vec3 at = vec3(clip.xy, depth);
        vec3 low = vec3(-clip.zz, frame.lens.z), high = vec3(clip.zz, frame.lens.w);
        vec3 room = ROUNDING * (abs(at) + abs(clip.z));
        below += vec3(lessThan(at + room, low));
        above += vec3(greaterThan(at - room, high));
        middle += points[i] / 12.0;
    }
    if (any(equal(below, vec3(12.0))) || any(equal(above, vec3(12.0)))) {
        return true;
    }
    if (hits_from_behind() || steep > STEEPEST) {
        return false;
    }
    float radius = 0.0;
    for (int i = 0; i < 12; ++i) {
        radius = max(radius, distance(points[i], middle));
    }
    vec3 a = vertices.item[triangle.corners.x].position.xyz;
    vec3 axis = normalize(cross(vertices.item[triangle.corners.y].position.xyz - a,
                                vertices.item[triangle.corners.z].position.xyz - a));
    float tangent = steep * triangle.range.z + triangle.range.w;
    vec3 away = object.eye.w != 0.0 ? middle - object.eye.xyz : -object.eye.xyz;
    radius = object.eye.w != 0.0 ? radius : 0.0;
    // The cosine between `away` and the normal that is turned most toward the eye, times its length.
    float far = length(away), along = dot(away, axis), aside = sqrt(max(far * far - along * along, 0.0));
    return (along - aside * tangent) * inversesqrt(1.0 + tangent * tangent) > radius + ROUNDING * far;
}
#endif

#endif
