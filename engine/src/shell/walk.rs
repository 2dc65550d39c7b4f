//! What the walk needs beside the prisms: who lies across each wall, the lids and bases that bound the shell, and the
//! prisms that a ray may enter otherwise than through these (DESIGN section 5).

use std::collections::{HashMap, HashSet};

use glam::{DVec3, Vec3};

use super::prisms::{ShellGeometry, Wall};
use crate::scene::Primitive;

/// No prism lies across; `NO_NEIGHBOUR` of `shaders/shell/prism_bits.glsl`.
pub const NO_NEIGHBOUR: u32 = u32::MAX;

/// Least cosine between a shell normal and a lid or base around it. Where normals lean further, growth along them does
/// not widen the outline enough for the rasteriser's snapping (see `GROWTH` in `shaders/render/lid_growth.glsl`).
const LEAST_COSINE: f64 = 0.05;

/// The length of a shell normal below which the growth shrinks with it; that of `shaders/shell/lean.glsl`.
const LEAST_NORMAL: f64 = 0.5;

/// The walk's view of one primitive's shell.
#[derive(Clone, Debug, Default)]
pub struct WalkGeometry {
    /// Across each prism's walls: 4 · prism + its number of the wall, or [`NO_NEIGHBOUR`] where the wall is a border, a
    /// plain neighbour's, another primitive's, or an edge without exactly two oppositely wound triangles.
    pub neighbours: Vec<[u32; 3]>,
    /// Base and lid level of each vertex: below and above every surface and step of the prisms around it.
    pub lids: Vec<[f64; 2]>,
    /// Least base and greatest lid of each prism's corners.
    pub reach: Vec<[f64; 2]>,
    /// Prisms whose lids a ray may slip past: one of their normals is zero or leans too far.
    pub irregular: Vec<bool>,
    /// Prisms that are not displaced.
    plain: Vec<bool>,
    /// All prisms, those first that are irregular, plain or have a wall without neighbour.
    pub borders: Vec<u32>,
    /// How many of `borders` come first for that reason.
    pub border_count: u32,
}

impl WalkGeometry {
    /// Gathers it. `shell`: shell normal times r of each vertex.
    pub fn new(primitive: &Primitive, shell: &[Vec3], geometry: &ShellGeometry) -> Self {
        let neighbours = neighbours(primitive, geometry);
        let lids = lids(primitive, geometry);
        let reach = |triangle: &[u32; 3]| {
            let levels = triangle.map(|v| lids[v as usize]);
            levels
                .iter()
                .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], [base, lid]| [low.min(*base), high.max(*lid)])
        };
        let reach: Vec<_> = primitive.triangles.iter().map(reach).collect();
        let leaning = leaning(primitive, shell, &lids);
        let leans = |v: &u32| leaning.contains(&primitive.weld[*v as usize]);
        let irregular = primitive.triangles.iter().map(|triangle| triangle.iter().any(leans)).collect();
        let plain = geometry.prisms.iter().map(|prism| prism.plain).collect();
        let mut walk = WalkGeometry { neighbours, lids, reach, irregular, plain, borders: Vec::new(), border_count: 0 };
        let (mut borders, others): (Vec<u32>, Vec<u32>) =
            (0..geometry.prisms.len() as u32).partition(|prism| walk.is_border(*prism as usize));
        walk.border_count = borders.len() as u32;
        borders.extend(others);
        walk.borders = borders;
        walk
    }

    /// Whether a ray may enter a prism otherwise than through its lid and base.
    pub fn is_border(&self, prism: usize) -> bool {
        self.plain[prism] || self.irregular[prism] || self.neighbours[prism].contains(&NO_NEIGHBOUR)
    }

    /// Whether a ray that starts outside can get under the surface without having crossed it: only then are bases seen.
    pub fn is_open(&self) -> bool {
        self.border_count > 0
    }
}

/// Prism and wall across each wall.
fn neighbours(primitive: &Primitive, geometry: &ShellGeometry) -> Vec<[u32; 3]> {
    let walks = |p: usize, k: usize| {
        let prism = &geometry.prisms[p];
        !prism.plain && matches!(prism.walls[k], Wall::Same | Wall::Seam)
    };
    let mut edges: HashMap<(u32, u32), Vec<u32>> = HashMap::new();
    let edge = |triangle: &[u32; 3], k: usize| {
        let [i, j] = [(k + 1) % 3, (k + 2) % 3].map(|c| primitive.weld[triangle[c] as usize]);
        (i.min(j), i.max(j))
    };
    let sides = || {
        let walls = |(p, triangle)| (0..3).map(move |k| (p, triangle, k));
        primitive.triangles.iter().enumerate().flat_map(walls).filter(|(p, _, k)| walks(*p, *k))
    };
    for (p, triangle, k) in sides() {
        edges.entry(edge(triangle, k)).or_default().push(4 * p as u32 + k as u32);
    }
    let mut neighbours = vec![[NO_NEIGHBOUR; 3]; primitive.triangles.len()];
    for (p, triangle, k) in sides() {
        // Such a wall has one other side; where it is alone here, that is in another primitive.
        let own = 4 * p as u32 + k as u32;
        let other = edges[&edge(triangle, k)].iter().find(|side| **side != own);
        neighbours[p][k] = other.copied().unwrap_or(NO_NEIGHBOUR);
    }
    neighbours
}

/// Base and lid of each vertex; those at one position share them.
fn lids(primitive: &Primitive, geometry: &ShellGeometry) -> Vec<[f64; 2]> {
    let mut welded: HashMap<u32, [f64; 2]> = HashMap::new();
    for (triangle, prism) in primitive.triangles.iter().zip(&geometry.prisms) {
        for v in triangle {
            let [base, lid] = welded.entry(primitive.weld[*v as usize]).or_insert([f64::INFINITY, f64::NEG_INFINITY]);
            *base = base.min(prism.range[0]);
            *lid = lid.max(prism.range[1]);
        }
    }
    // A vertex of no triangle bounds nothing.
    primitive.weld.iter().map(|w| welded.get(w).copied().unwrap_or_default()).collect()
}

/// Welded vertices whose shell normal is zero, or leans too far against a lid or base there.
pub(crate) fn leaning(primitive: &Primitive, shell: &[Vec3], lids: &[[f64; 2]]) -> HashSet<u32> {
    let mut leaning = HashSet::new();
    for triangle in &primitive.triangles {
        for side in [0, 1] {
            let corner = |v: u32| {
                let v = v as usize;
                primitive.positions[v].as_dvec3() + lids[v][side] * shell[v].as_dvec3()
            };
            let [a, b, c] = triangle.map(corner);
            let normal = (b - a).cross(c - a).normalize_or_zero();
            for v in triangle {
                let along: DVec3 = shell[*v as usize].as_dvec3();
                if normal.dot(along) < LEAST_COSINE * along.length().max(LEAST_NORMAL) {
                    leaning.insert(primitive.weld[*v as usize]);
                }
            }
        }
    }
    leaning
}
