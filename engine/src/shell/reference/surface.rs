//! The surface of one mesh as the tracer sees it: prisms, plain triangles, and the walls that close its steps.

use std::collections::HashMap;

use glam::{DVec2, DVec3};

use super::{
    bvh::{Aabb, Bvh},
    fold::{Candidate, Weld, factors, headroom},
    height::HeightField,
};
use crate::scene::{Displacement, HeightSource, Mesh, Primitive, Procedure, Scene, Wrap};

/// The height field on one triangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Relief {
    /// Index into the reference's height fields.
    pub(super) field: usize,
    pub(super) wrap: [Wrap; 2],
    /// Texel coordinates at the corners, less `base`.
    pub(super) texel: [DVec2; 3],
    /// Whole texels that were taken off the corners' coordinates, so that f64 keeps its digits.
    pub(super) base: [i64; 2],
    /// Mesh units.
    pub(super) scale: f64,
    pub(super) midlevel: f64,
    /// The map-wide range of t with 0 included, a hair wider.
    pub(super) t_range: [f64; 2],
}

/// A triangle: a prism where it has a relief, else plain.
#[derive(Clone, Copy, Debug)]
pub(super) struct Facet {
    /// Primitive and triangle in the mesh.
    pub(super) id: [usize; 2],
    pub(super) positions: [DVec3; 3],
    /// r N at the corners, zero on a plain triangle.
    pub(super) lifts: [DVec3; 3],
    /// Texture coordinates at the corners, as stored.
    pub(super) uv: [DVec2; 3],
    pub(super) relief: Option<Relief>,
    /// Height reported where t is 0.
    pub(super) midlevel: f64,
    pub(super) double_sided: bool,
}

/// One of the two surfaces that end at a wall.
#[derive(Clone, Copy, Debug)]
pub(super) struct Side {
    pub(super) facet: usize,
    /// The facet's corners at the wall's two ends.
    pub(super) corners: [usize; 2],
}

/// What a wall stands against.
#[derive(Clone, Copy, Debug)]
pub(super) enum Outer {
    /// The neighbour's surface.
    Neighbour(Side),
    /// The floor of an open border, at this t.
    Floor(f64),
}

/// The ruled surface over an edge between two heights. The edge runs counter-clockwise around `inner`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wall {
    pub(super) positions: [DVec3; 2],
    pub(super) lifts: [DVec3; 2],
    pub(super) inner: Side,
    pub(super) outer: Outer,
    pub(super) t_range: [f64; 2],
}

/// Everything of one mesh, in mesh space.
#[derive(Clone, Debug)]
pub(super) struct Surface {
    pub(super) facets: Vec<Facet>,
    pub(super) walls: Vec<Wall>,
    /// How far every prism stays free of folds above its highest level, as a share of the range of its levels.
    pub(super) headroom: f64,
    /// Over the facets, then the walls.
    pub(super) bvh: Bvh,
}

impl Outer {
    /// The neighbour, where there is one.
    pub(super) fn neighbour(self) -> Option<Side> {
        match self {
            Outer::Neighbour(side) => Some(side),
            Outer::Floor(_) => None,
        }
    }
}

impl Relief {
    /// The surface's t at λ, and its derivatives by texel coordinates; `field` is the relief's.
    pub(super) fn surface_t(&self, field: &HeightField, lambda: [f64; 3]) -> (f64, [f64; 2]) {
        let at: DVec2 = (0..3).map(|k| lambda[k] * self.texel[k]).sum();
        let (h, slope) = field.sample(at, self.base, self.wrap);
        ((h - self.midlevel) * self.scale, slope.map(|d| d * self.scale))
    }
}

impl Facet {
    /// A point on the level t.
    pub(super) fn point(&self, lambda: [f64; 3], t: f64) -> DVec3 {
        (0..3).map(|k| lambda[k] * (self.positions[k] + t * self.lifts[k])).sum()
    }

    /// Length of the longest edge.
    pub(super) fn size(&self) -> f64 {
        let p = self.positions;
        p[0].distance(p[1]).max(p[1].distance(p[2])).max(p[2].distance(p[0]))
    }

    /// The displaced surface's t at λ, and its derivatives by texel coordinates.
    pub(super) fn surface_t(&self, fields: &[HeightField], lambda: [f64; 3]) -> (f64, [f64; 2]) {
        let Some(relief) = &self.relief else { return (0.0, [0.0; 2]) };
        relief.surface_t(&fields[relief.field], lambda)
    }

    /// The surface's normal on its front, not unit: DESIGN section 4, with `slope` = ∂t/∂(texel coordinates).
    pub(super) fn normal(&self, lambda: [f64; 3], t: f64, slope: [f64; 2]) -> DVec3 {
        let level: [DVec3; 3] = std::array::from_fn(|k| self.positions[k] + t * self.lifts[k]);
        let (e1, e2) = (level[1] - level[0], level[2] - level[0]);
        let Some(relief) = &self.relief else { return e1.cross(e2) };
        let lift: DVec3 = (0..3).map(|k| lambda[k] * self.lifts[k]).sum();
        let along = |k: usize| (relief.texel[k] - relief.texel[0]).dot(slope.into());
        e1.cross(e2) + along(1) * lift.cross(e2) + along(2) * e1.cross(lift)
    }
}

impl Surface {
    /// Whether any triangle of a primitive is displaced.
    pub(super) fn displaces(&self, primitive: usize) -> bool {
        self.facets.iter().any(|facet| facet.id[0] == primitive && facet.relief.is_some())
    }

    /// Welds, folds and closes `mesh`.
    pub(super) fn new(scene: &Scene, mesh: &Mesh, fields: &[HeightField]) -> Self {
        let weld = Weld::new(mesh);
        let (mut facets, mut welds) = (Vec::new(), Vec::new());
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            for i in 0..primitive.triangles.len() {
                let ids = primitive.triangles[i].map(|v| weld.ids[p][v as usize]);
                // Two corners in one point: no level of it has an area.
                if ids[0] != ids[1] && ids[1] != ids[2] && ids[2] != ids[0] {
                    facets.push(facet(scene, primitive, [p, i], fields));
                    welds.push(ids);
                }
            }
        }
        let candidates: Vec<Candidate> = (facets.iter().zip(&welds))
            .filter_map(|(f, &weld)| {
                let [lo, hi] = exact_range(f.relief.as_ref()?, fields);
                Some(Candidate { weld, positions: f.positions, t_range: [lo, hi] })
            })
            .collect();
        let r = factors(&candidates, &weld.normals);
        let headroom = headroom(&candidates, &r, &weld.normals);
        for (facet, ids) in facets.iter_mut().zip(&welds) {
            facet.lifts = ids.map(|v| r[v] * weld.normals[v]);
            if ids.iter().all(|v| r[*v] == 0.0) {
                facet.relief = None;
            }
        }
        let walls = walls(scene, mesh, &facets, &welds, fields);
        let boxes: Vec<Aabb> =
            facets.iter().map(facet_box).chain(walls.iter().map(|w| hull(&w.positions, &w.lifts, w.t_range))).collect();
        Surface { facets, walls, headroom, bvh: Bvh::new(&boxes) }
    }
}

fn facet_box(facet: &Facet) -> Aabb {
    hull(&facet.positions, &facet.lifts, facet.relief.map_or([0.0; 2], |relief| relief.t_range))
}

/// The box around the convex hull of all corners on the first and the last level, which holds every level between.
pub(super) fn hull(positions: &[DVec3], lifts: &[DVec3], t_range: [f64; 2]) -> Aabb {
    let corners = || t_range.into_iter().flat_map(|t| positions.iter().zip(lifts).map(move |(p, n)| *p + t * *n));
    let tight = Aabb::around(corners(), 0.0);
    Aabb::around(corners(), 1e-8 * (tight.max - tight.min).length())
}

fn exact_range(relief: &Relief, fields: &[HeightField]) -> [f64; 2] {
    let [lo, hi] = fields[relief.field].extent().map(|h| (h - relief.midlevel) * relief.scale);
    [lo.min(0.0), hi.max(0.0)]
}

fn facet(scene: &Scene, primitive: &Primitive, id: [usize; 2], fields: &[HeightField]) -> Facet {
    let triangle = primitive.triangles[id[1]].map(|v| v as usize);
    let material = &scene.materials[primitive.material];
    let displacement = material.displacement.as_ref();
    let set = &primitive.uvs[displacement.map_or(0, |d| d.tex_coord)];
    let mut facet = Facet {
        id,
        positions: triangle.map(|v| primitive.positions[v].as_dvec3()),
        lifts: [DVec3::ZERO; 3],
        uv: triangle.map(|v| set.get(v).map_or(DVec2::ZERO, |uv| uv.as_dvec2())),
        relief: None,
        midlevel: displacement.map_or(0.5, |d| d.midlevel),
        double_sided: material.double_sided,
    };
    let scale = displacement.map_or(0.0, |d| mesh_units(d, primitive));
    if let Some(d) = displacement.filter(|_| scale > 0.0) {
        let field = field_of(scene, d.source);
        let [width, height] = fields[field].size();
        let texel = facet.uv.map(|uv| d.transform.transform_point2(uv) * DVec2::new(width, height) - 0.5);
        let base = texel[0].min(texel[1]).min(texel[2]).floor();
        let mut relief = Relief {
            field,
            wrap: d.wrap,
            texel: texel.map(|x| x - base),
            base: [base.x as i64, base.y as i64],
            scale,
            midlevel: d.midlevel,
            t_range: [0.0; 2],
        };
        // Wider than rounding, so that a surface on the first or the last level lies inside.
        let [lo, hi] = exact_range(&relief, fields);
        let pad = 1e-7 * (facet.size() + hi - lo);
        relief.t_range = [lo - pad, hi + pad];
        facet.relief = Some(relief);
    }
    facet
}

/// All height fields of a scene: its maps, then every procedure.
pub(super) fn height_fields(scene: &Scene) -> Vec<HeightField> {
    scene.height_maps.iter().map(HeightField::new).chain(Procedure::ALL.map(HeightField::Procedure)).collect()
}

/// Index among [`height_fields`].
fn field_of(scene: &Scene, source: HeightSource) -> usize {
    match source {
        HeightSource::Map(map) => map,
        HeightSource::Procedure(procedure) => scene.height_maps.len() + procedure as usize,
    }
}

/// The scale in mesh units: `relative` ones follow the primitive's ratio of mesh to UV area.
fn mesh_units(displacement: &Displacement, primitive: &Primitive) -> f64 {
    if !displacement.relative {
        return displacement.scale;
    }
    let (mut mesh_area, mut uv_area) = (0.0, 0.0);
    let set = &primitive.uvs[displacement.tex_coord];
    for triangle in &primitive.triangles {
        let [a, b, c] = triangle.map(|v| primitive.positions[v as usize].as_dvec3());
        mesh_area += (b - a).cross(c - a).length();
        let [a, b, c] = triangle.map(|v| set[v as usize].as_dvec2());
        uv_area += (b - a).perp_dot(c - a).abs();
    }
    let ratio = (mesh_area / uv_area).sqrt();
    if ratio.is_finite() { displacement.scale * ratio } else { 0.0 }
}

/// The walls of a mesh: on edges of exactly two oppositely wound triangles whose heights may disagree, and on all other
/// edges of displaced triangles whose material closes its borders.
fn walls(scene: &Scene, mesh: &Mesh, facets: &[Facet], welds: &[[usize; 3]], fields: &[HeightField]) -> Vec<Wall> {
    // Edge → (runs from the smaller to the greater vertex, facet, its corners along its own winding).
    let mut edges: HashMap<[usize; 2], Vec<(bool, Side)>> = HashMap::new();
    for (f, weld) in welds.iter().enumerate() {
        for corners in [[0, 1], [1, 2], [2, 0]] {
            let [a, b] = corners.map(|k| weld[k]);
            edges.entry([a.min(b), a.max(b)]).or_default().push((a < b, Side { facet: f, corners }));
        }
    }
    let wall = |inner: Side, outer: Outer| {
        let facet = &facets[inner.facet];
        let ranges =
            [Some(inner), outer.neighbour()].map(|s| s.and_then(|s| facets[s.facet].relief).map(|r| r.t_range));
        let t_range = ranges.into_iter().flatten().fold([0.0f64; 2], |[a, b], [lo, hi]| [a.min(lo), b.max(hi)]);
        let wall = Wall {
            positions: inner.corners.map(|k| facet.positions[k]),
            lifts: inner.corners.map(|k| facet.lifts[k]),
            inner,
            outer,
            t_range,
        };
        (wall.lifts != [DVec3::ZERO; 2]).then_some(wall)
    };
    let mut walls: Vec<Wall> = Vec::new();
    for sides in edges.values() {
        if let [(a, first), (b, second)] = sides[..]
            && a != b
        {
            let turned = Side { facet: second.facet, corners: [second.corners[1], second.corners[0]] };
            if may_step(facets, first, turned) {
                walls.extend(wall(first, Outer::Neighbour(turned)));
            }
            continue;
        }
        for &(_, side) in sides {
            let facet = &facets[side.facet];
            let material = &scene.materials[mesh.primitives[facet.id[0]].material];
            if let (Some(relief), Some(displacement)) = (&facet.relief, &material.displacement)
                && displacement.border_wall
            {
                let floor = (fields[relief.field].extent()[0] - relief.midlevel) * relief.scale;
                walls.extend(wall(side, Outer::Floor(floor)));
            }
        }
    }
    // Hash maps iterate in any order; the same scene gives the same walls.
    walls.sort_unstable_by_key(|w| (w.inner.facet, w.inner.corners));
    walls
}

/// Whether the two sides of an edge can disagree on the height: unless both are plain, or both read the same texels.
fn may_step(facets: &[Facet], a: Side, b: Side) -> bool {
    let whole = |s: Side, relief: &Relief, k: usize| {
        relief.texel[s.corners[k]] + DVec2::new(relief.base[0] as f64, relief.base[1] as f64)
    };
    match (&facets[a.facet].relief, &facets[b.facet].relief) {
        (None, None) => false,
        (Some(x), Some(y)) => {
            let same = (x.field, x.wrap, x.scale, x.midlevel) == (y.field, y.wrap, y.scale, y.midlevel);
            !same || (0..2).any(|k| (whole(a, x, k) - whole(b, y, k)).abs().max_element() > 1e-9)
        }
        _ => true,
    }
}
