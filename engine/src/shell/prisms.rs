//! The prisms of a primitive: which triangles become one, how their walls continue, and their ranges of levels.

use std::{
    borrow::Cow,
    collections::{HashMap, HashSet},
};

use glam::{DVec2, Vec2};

use super::bounds::{self, FieldBounds};
use crate::scene::{Displacement, HeightSource, Mesh, Primitive, Scene, Wrap};

/// How the surface goes on across a wall. The numbers are those of `shaders/shell/prism_bits.glsl`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Wall {
    /// At the same height: no step.
    Same = 0,
    /// Displaced, with other texture coordinates or by another height field.
    Seam = 1,
    /// A plain surface at t = 0.
    Plain = 2,
    /// Border of the sheet, left open.
    Open = 3,
    /// Border closed by a wall.
    Closed = 4,
}

/// A wall of a triangle of the mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Across {
    /// Primitive of the mesh.
    pub primitive: usize,
    /// Triangle of the primitive.
    pub triangle: usize,
    /// Its own number of the wall.
    pub wall: usize,
}

/// One prism.
#[derive(Clone, Copy, Debug)]
pub struct Prism {
    /// Vertices of the primitive.
    pub corners: [u32; 3],
    /// Wall k joins corners (k+1, k+2) mod 3.
    pub walls: [Wall; 3],
    /// What lies across wall k; none at a border, which is any edge without exactly two oppositely wound triangles.
    pub across: [Option<Across>; 3],
    /// Wall k's welded ids descend from corner k+1 to corner k+2: its canonical order is the reverse.
    pub descending: [bool; 3],
    /// The neighbour's height map coordinates at wall k's canonical first and second corner.
    pub neighbour_uv: [[Vec2; 2]; 3],
    /// The neighbour's height field at wall k: 0 for the prism's own, else 1 + index into [`ShellGeometry::others`].
    pub field: [u32; 3],
    /// Whether the neighbour's surface at wall k is hit from behind too.
    pub behind: [bool; 3],
    /// Lowest and highest level that the surface or a wall can have in it, mesh units.
    pub range: [f64; 2],
    /// Its heights are all the same, and none of its walls has a step.
    pub one_height: bool,
    /// Not displaced, by its material or because all its r are 0. It is traced all the same, so that it meets its
    /// neighbours without a crack; the rasteriser, which moves vertices to its own grid, would leave one.
    pub plain: bool,
}

/// Most height fields of its neighbours, besides its own, that a primitive reads: one sampler each, or a function.
pub const MAX_OTHERS: usize = 7;

/// What gives a primitive's levels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Field {
    /// Where the heights come from.
    pub source: HeightSource,
    /// Wrap of u and v.
    pub wrap: [Wrap; 2],
    /// Mesh units.
    pub scale: f64,
    /// The height that stays on the base surface.
    pub midlevel: f64,
}

/// A primitive's triangles as prisms; empty where they are drawn as they are.
#[derive(Clone, Debug, Default)]
pub struct ShellGeometry {
    /// One per triangle, in the primitive's order.
    pub prisms: Vec<Prism>,
    /// Height map coordinates per vertex: the texture transform applied, moved by an even integer where the wrap mode
    /// does not notice, so that f32 keeps their fraction.
    pub height_uv: Vec<Vec2>,
    /// Least and greatest `height_uv`.
    pub uv_bounds: [Vec2; 2],
    /// Fields of neighbours that differ from the primitive's own, in the order in which its walls meet them.
    pub others: Vec<Field>,
    /// Walls whose neighbour has a field beyond [`MAX_OTHERS`]: steps there stay open.
    pub left_open: usize,
}

impl ShellGeometry {
    /// Its [`Self::height_uv`], made for a displaced primitive that is drawn without a shell.
    pub fn height_uvs(&self, primitive: &Primitive, displacement: &Displacement) -> Cow<'_, [Vec2]> {
        if self.height_uv.is_empty() {
            return height_uvs(primitive, displacement).into();
        }
        Cow::Borrowed(&self.height_uv)
    }

    /// Whether any of its triangles is displaced; else all of its prisms, if it has any, are plain.
    pub fn is_displaced(&self) -> bool {
        self.prisms.iter().any(|prism| !prism.plain)
    }

    /// A neighbour's field as [`Prism::field`] numbers it; none where there is no room for it.
    fn number(&mut self, field: Field) -> Option<u32> {
        let index = self.others.iter().position(|other| *other == field).or_else(|| {
            (self.others.len() < MAX_OTHERS).then(|| {
                self.others.push(field);
                self.others.len() - 1
            })
        })?;
        Some(index as u32 + 1)
    }
}

/// Whether a primitive's material displaces it at all.
pub fn displacement(scene: &Scene, primitive: &Primitive) -> Option<Displacement> {
    scene.materials[primitive.material].displacement.filter(|_| primitive.displacement_scale > 0.0)
}

/// A displaced primitive's field.
fn field(scene: &Scene, primitive: &Primitive) -> Option<Field> {
    let d = displacement(scene, primitive)?;
    Some(Field { source: d.source, wrap: d.wrap, scale: primitive.displacement_scale, midlevel: d.midlevel })
}

/// Height map coordinates of every vertex; see [`ShellGeometry::height_uv`].
pub fn height_uvs(primitive: &Primitive, displacement: &Displacement) -> Vec<Vec2> {
    let exact: Vec<DVec2> = primitive.uvs[displacement.tex_coord]
        .iter()
        .map(|uv| displacement.transform.transform_point2(uv.as_dvec2()))
        .collect();
    let mut low = DVec2::INFINITY;
    for uv in &exact {
        low = low.min(*uv);
    }
    let offset = |axis: usize| match displacement.wrap[axis] {
        Wrap::Clamp => 0.0,
        _ if exact.is_empty() => 0.0,
        // Even, so that a mirrored map is not turned around.
        Wrap::Repeat | Wrap::Mirror => 2.0 * (low[axis] / 2.0).floor(),
    };
    let offset = DVec2::new(offset(0), offset(1));
    exact.iter().map(|uv| (*uv - offset).as_vec2()).collect()
}

/// A triangle of the mesh seen from one of its edges.
struct Side {
    at: Across,
    /// Runs from the lower to the higher welded id.
    ascending: bool,
    /// Vertices at the lower and the higher id.
    ends: [u32; 2],
}

/// Builds the shell geometry of every primitive of a mesh. `factors`: r per welded vertex, from the certificate.
/// Primitives that no displaced triangle touches, directly or over others of the mesh, come back empty.
pub fn build(scene: &Scene, mesh: &Mesh, factors: &[f64]) -> Vec<ShellGeometry> {
    let displaced = |primitive: &Primitive, triangle: [u32; 3]| {
        displacement(scene, primitive).is_some()
            && triangle.iter().any(|v| factors[primitive.weld[*v as usize] as usize] > 0.0)
    };
    let uvs: Vec<Vec<Vec2>> =
        mesh.primitives.iter().map(|p| displacement(scene, p).map(|d| height_uvs(p, &d)).unwrap_or_default()).collect();
    let traced = connected(mesh, |p| p.triangles.iter().any(|t| displaced(p, *t)));
    let edges = edges(mesh);
    let mut bounds: HashMap<(HeightSource, [Wrap; 2]), FieldBounds<'_>> = HashMap::new();
    // Levels of each displaced triangle's own surface; seams need their neighbour's too.
    let ranges: Vec<Vec<[f64; 2]>> = mesh
        .primitives
        .iter()
        .zip(&uvs)
        .map(|(primitive, uvs)| {
            let Some(d) = displacement(scene, primitive) else {
                return Vec::new();
            };
            let bounds = bounds.entry((d.source, d.wrap)).or_insert_with(|| FieldBounds::new(scene, &d));
            let level = |h: f32| (f64::from(h) - d.midlevel) * primitive.displacement_scale;
            let range = |triangle: &[u32; 3]| {
                let [a, b, c] = triangle.map(|v| uvs[v as usize].as_dvec2());
                let (low, high) = bounds.over(a.min(b).min(c), a.max(b).max(c));
                let [low, high] = [low, high].map(level);
                // Any of its neighbours may be plain in some pose.
                if mesh.deforms { [low.min(0.0), high.max(0.0)] } else { [low, high] }
            };
            primitive.triangles.iter().map(range).collect()
        })
        .collect();

    mesh.primitives
        .iter()
        .enumerate()
        .map(|(p, primitive)| {
            if !traced[p] {
                return ShellGeometry::default();
            }
            let border_wall = displacement(scene, primitive).is_some_and(|d| d.border_wall);
            let mut geometry = ShellGeometry { height_uv: uvs[p].clone(), ..ShellGeometry::default() };
            geometry.uv_bounds = [Vec2::INFINITY, Vec2::NEG_INFINITY];
            for uv in &uvs[p] {
                geometry.uv_bounds = [geometry.uv_bounds[0].min(*uv), geometry.uv_bounds[1].max(*uv)];
            }
            let (lowest, _) = scene.displacement_range(primitive);
            for (t, &triangle) in primitive.triangles.iter().enumerate() {
                let plain = !displaced(primitive, triangle);
                let mut prism = Prism {
                    corners: triangle,
                    walls: [Wall::Open; 3],
                    across: [None; 3],
                    descending: [false; 3],
                    neighbour_uv: [[Vec2::ZERO; 2]; 3],
                    field: [0; 3],
                    behind: [false; 3],
                    range: if plain { [0.0, 0.0] } else { ranges[p][t] },
                    one_height: false,
                    plain,
                };
                let mut scale = primitive.displacement_scale;
                for k in 0..3 {
                    let (i, j) = (triangle[(k + 1) % 3], triangle[(k + 2) % 3]);
                    let (wi, wj) = (primitive.weld[i as usize], primitive.weld[j as usize]);
                    prism.descending[k] = wi > wj;
                    let other = neighbour(&edges, (wi.min(wj), wi.max(wj)), p, t);
                    prism.across[k] = other.map(|other| other.at);
                    if plain {
                        continue;
                    }
                    let Some(other) = other else {
                        if border_wall {
                            prism.walls[k] = Wall::Closed;
                            prism.range[0] = prism.range[0].min(lowest);
                        }
                        continue;
                    };
                    let at = other.at;
                    let there = &mesh.primitives[at.primitive];
                    prism.behind[k] = scene.materials[there.material].double_sided;
                    if !displaced(there, there.triangles[at.triangle]) {
                        prism.walls[k] = Wall::Plain;
                        prism.range = [prism.range[0].min(0.0), prism.range[1].max(0.0)];
                        continue;
                    }
                    let across = other.ends.map(|v| uvs[at.primitive][v as usize]);
                    let here = if wi > wj { [j, i] } else { [i, j] }.map(|v| uvs[p][v as usize]);
                    prism.neighbour_uv[k] = across;
                    let (own, theirs) = (field(scene, primitive), field(scene, there));
                    let number = if theirs == own { Some(0) } else { theirs.and_then(|f| geometry.number(f)) };
                    prism.walls[k] = match number {
                        Some(0) if across == here => Wall::Same,
                        Some(_) => Wall::Seam,
                        None => {
                            geometry.left_open += 1;
                            Wall::Same
                        }
                    };
                    if prism.walls[k] == Wall::Seam {
                        prism.field[k] = number.unwrap_or(0);
                        let range = ranges[at.primitive][at.triangle];
                        prism.range = [prism.range[0].min(range[0]), prism.range[1].max(range[1])];
                        scale = scale.max(there.displacement_scale);
                    }
                }
                prism.range = padded(prism.range, scale);
                let steps = prism.walls.iter().any(|wall| !matches!(wall, Wall::Same | Wall::Open));
                prism.one_height =
                    !plain && !steps && !mesh.deforms && has_one_height(scene, primitive, &uvs[p], triangle);
                geometry.prisms.push(prism);
            }
            geometry
        })
        .collect()
}

/// Whether a triangle's height map has one height wherever it reads it.
fn has_one_height(scene: &Scene, primitive: &Primitive, uvs: &[Vec2], triangle: [u32; 3]) -> bool {
    let Some(displacement) = displacement(scene, primitive) else { return false };
    let Some(map) = displacement.source.map() else { return false };
    let [a, b, c] = triangle.map(|v| uvs[v as usize].as_dvec2());
    let (low, high) = (a.min(b).min(c), a.max(b).max(c));
    bounds::constant_over(&scene.height_maps[map], displacement.wrap, low, high).is_some()
}

/// Room for the rounding of levels in f32, and a thickness for surfaces of constant height.
fn padded([low, high]: [f64; 2], scale: f64) -> [f64; 2] {
    let room = 1e-4 * scale + 1e-5 * low.abs().max(high.abs());
    [low - room, high + room]
}

/// Which primitives share a welded vertex with one that `is_displaced`, or with one that does, and so on: a rasterised
/// triangle beside a traced one would leave a crack.
fn connected(mesh: &Mesh, is_displaced: impl Fn(&Primitive) -> bool) -> Vec<bool> {
    let groups = groups(mesh);
    let displaced: HashSet<usize> = groups
        .iter()
        .zip(&mesh.primitives)
        .filter(|(_, primitive)| is_displaced(primitive))
        .map(|(group, _)| *group)
        .collect();
    groups.iter().map(|group| displaced.contains(group)).collect()
}

/// The first primitive of each one's group: of those that share a welded vertex with it, or with one that does, and so on.
pub fn groups(mesh: &Mesh) -> Vec<usize> {
    // Each points to an earlier one of its group, the first to itself.
    let mut group: Vec<usize> = (0..mesh.primitives.len()).collect();
    let first = |group: &[usize], mut p: usize| {
        while group[p] != p {
            p = group[p];
        }
        p
    };
    let mut owners: HashMap<u32, usize> = HashMap::new();
    for (p, primitive) in mesh.primitives.iter().enumerate() {
        for vertex in primitive.triangles.iter().flatten() {
            let owner = *owners.entry(primitive.weld[*vertex as usize]).or_insert(p);
            let (a, b) = (first(&group, owner), first(&group, p));
            group[a.max(b)] = a.min(b);
        }
    }
    (0..mesh.primitives.len()).map(|p| first(&group, p)).collect()
}

/// Welded edge (lower id, higher id) → every triangle there, across the mesh's primitives.
fn edges(mesh: &Mesh) -> HashMap<(u32, u32), Vec<Side>> {
    let mut edges: HashMap<(u32, u32), Vec<Side>> = HashMap::new();
    for (p, primitive) in mesh.primitives.iter().enumerate() {
        for (t, triangle) in primitive.triangles.iter().enumerate() {
            for k in 0..3 {
                let (i, j) = (triangle[(k + 1) % 3], triangle[(k + 2) % 3]);
                let (wi, wj) = (primitive.weld[i as usize], primitive.weld[j as usize]);
                let ascending = wi < wj;
                let ends = if ascending { [i, j] } else { [j, i] };
                let at = Across { primitive: p, triangle: t, wall: k };
                edges.entry((wi.min(wj), wi.max(wj))).or_default().push(Side { at, ascending, ends });
            }
        }
    }
    edges
}

/// The triangle across an edge; none where the edge is a border, which is any without exactly two oppositely wound
/// triangles.
fn neighbour(
    edges: &HashMap<(u32, u32), Vec<Side>>,
    edge: (u32, u32),
    primitive: usize,
    triangle: usize,
) -> Option<&Side> {
    match edges.get(&edge).map(Vec::as_slice) {
        Some([a, b]) if a.ascending != b.ascending => {
            Some(if (a.at.primitive, a.at.triangle) == (primitive, triangle) { b } else { a })
        }
        _ => None,
    }
}
