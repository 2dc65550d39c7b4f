//! What the walk needs beside the prisms: who lies across each wall, the lids and bases that bound the shell, and the
//! prisms that a ray may enter otherwise than through these (DESIGN section 5).

use std::collections::{HashMap, HashSet};

use glam::{DVec3, Vec3};

use super::prisms::{Prism, ShellGeometry, Wall};
use crate::scene::{Mesh, Primitive};

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
    /// Which corners of each prism lie at a border: a ray along the wall between two prisms comes in through that corner
    /// alone, though neither wall of its prism there is a border.
    pub brinks: Vec<[bool; 3]>,
    /// Prisms whose lids a ray may slip past: one of their normals is zero or leans too far.
    pub irregular: Vec<bool>,
    /// Prisms that are not displaced.
    plain: Vec<bool>,
    /// All prisms, those first that are irregular, plain or at a border by a wall or a corner.
    pub borders: Vec<u32>,
    /// How many of `borders` come first for that reason.
    pub border_count: u32,
}

impl WalkGeometry {
    /// Gathers it for primitive `index` of a mesh. `shell`: shell normal times r of each vertex.
    pub fn new(mesh: &Mesh, index: usize, shell: &[Vec3], geometry: &ShellGeometry) -> Self {
        let primitive = &mesh.primitives[index];
        let neighbours = neighbours(index, geometry);
        let brinks = brinks(primitive, geometry, &neighbours);
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
        let mut walk =
            WalkGeometry { neighbours, lids, reach, brinks, irregular, plain, borders: Vec::new(), border_count: 0 };
        let (mut borders, others): (Vec<u32>, Vec<u32>) =
            (0..geometry.prisms.len() as u32).partition(|prism| walk.is_border(*prism as usize));
        walk.border_count = borders.len() as u32;
        borders.extend(others);
        walk.borders = borders;
        walk
    }

    /// Whether a ray may enter a prism otherwise than through its lid and base.
    pub fn is_border(&self, prism: usize) -> bool {
        // The ends of a wall without neighbour are at the border.
        self.plain[prism] || self.irregular[prism] || self.brinks[prism].contains(&true)
    }

    /// Whether a ray that starts outside can get under the surface without having crossed it: only then are bases seen.
    pub fn is_open(&self) -> bool {
        self.border_count > 0
    }
}

/// Prism and wall across each wall of the prisms of a mesh's primitive `index`.
fn neighbours(index: usize, geometry: &ShellGeometry) -> Vec<[u32; 3]> {
    let of = |prism: &Prism| {
        std::array::from_fn(|k| match prism.across[k] {
            Some(at) if at.primitive == index && matches!(prism.walls[k], Wall::Same | Wall::Seam) => {
                4 * at.triangle as u32 + at.wall as u32
            }
            _ => NO_NEIGHBOUR,
        })
    };
    geometry.prisms.iter().map(of).collect()
}

/// Which corners of each prism are ends of walls without neighbour, of whatever prism.
fn brinks(primitive: &Primitive, geometry: &ShellGeometry, neighbours: &[[u32; 3]]) -> Vec<[bool; 3]> {
    let weld = |v: &u32| primitive.weld[*v as usize];
    let mut ends = HashSet::new();
    for (prism, walls) in geometry.prisms.iter().zip(neighbours) {
        for k in (0..3).filter(|k| walls[*k] == NO_NEIGHBOUR) {
            ends.extend([prism.corners[(k + 1) % 3], prism.corners[(k + 2) % 3]].iter().map(weld));
        }
    }
    geometry.prisms.iter().map(|prism| prism.corners.map(|v| ends.contains(&weld(&v)))).collect()
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

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::scene;
    use crate::shell::{certificate, prisms};

    /// Each primitive of an asset that is displaced, with its prisms, what the walk has of it, and its shell normals.
    fn walked(name: &str) -> Vec<(Primitive, ShellGeometry, WalkGeometry, Vec<Vec3>)> {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets").join(name);
        let scene = scene::load(&path).unwrap();
        let mut all = Vec::new();
        for mesh in &scene.meshes {
            let factors = certificate::mesh_folds(&scene, mesh).factors;
            for (index, geometry) in prisms::build(&scene, mesh, &factors).into_iter().enumerate() {
                let primitive = &mesh.primitives[index];
                let lift = |w: &u32| (mesh.shell_normals[*w as usize] * factors[*w as usize]).as_vec3();
                let shell: Vec<Vec3> = primitive.weld.iter().map(lift).collect();
                if geometry.is_displaced() {
                    let walk = WalkGeometry::new(mesh, index, &shell, &geometry);
                    all.push((primitive.clone(), geometry, walk, shell));
                }
            }
        }
        assert!(!all.is_empty(), "{name}");
        all
    }

    const ASSETS: [&str; 6] =
        ["torus.gltf", "cube.gltf", "suzanne.gltf", "cloth.gltf", "stability_seams.gltf", "stability_slivers.gltf"];

    #[test]
    fn neighbours_share_the_edge_and_name_each_other() {
        for name in ASSETS {
            for (primitive, geometry, walk, _) in walked(name) {
                let edge = |p: usize, k: usize| {
                    let corners = geometry.prisms[p].corners;
                    [corners[(k + 1) % 3], corners[(k + 2) % 3]].map(|v| primitive.weld[v as usize])
                };
                for (p, walls) in walk.neighbours.iter().enumerate() {
                    for (k, &across) in walls.iter().enumerate().filter(|(_, across)| **across != NO_NEIGHBOUR) {
                        let (other, wall) = ((across / 4) as usize, (across % 4) as usize);
                        assert_eq!(walk.neighbours[other][wall], 4 * p as u32 + k as u32, "{name}");
                        let [i, j] = edge(p, k);
                        assert_eq!(edge(other, wall), [j, i], "{name}");
                    }
                }
            }
        }
    }

    #[test]
    fn lids_clear_every_surface_around_a_vertex_and_are_one_at_a_place() {
        for name in ASSETS {
            for (primitive, geometry, walk, _) in walked(name) {
                for (prism, [base, lid]) in geometry.prisms.iter().zip(&walk.reach) {
                    for v in prism.corners {
                        let [low, high] = walk.lids[v as usize];
                        assert!(low <= prism.range[0] && prism.range[1] <= high, "{name}");
                        assert!(*base <= low && high <= *lid, "{name}");
                    }
                }
                let mut welded = HashMap::new();
                for (weld, levels) in primitive.weld.iter().zip(&walk.lids) {
                    assert_eq!(welded.entry(weld).or_insert(levels), &levels, "{name}");
                }
            }
        }
    }

    /// What the surface of a prism lies under, the triangle at its highest level, sticks out of neither lid at a wall, though
    /// lids are planar between corners at different levels and walls are not: so no ray hits before it meets a lid. Where
    /// normals lean, prisms are drawn by hulls of their own.
    #[test]
    fn no_surface_stands_out_of_the_lids() {
        for name in ASSETS {
            for (primitive, geometry, walk, shell) in walked(name) {
                let at = |v: u32, t: f64| primitive.positions[v as usize].as_dvec3() + t * shell[v as usize].as_dvec3();
                let regular = |index: &usize| !geometry.prisms[*index].plain && !walk.irregular[*index];
                for index in (0..geometry.prisms.len()).filter(regular) {
                    let prism = &geometry.prisms[index];
                    for k in 0..3 {
                        let side = [1, 2].map(|i| at(prism.corners[(k + i) % 3], prism.range[1]));
                        let across = Some(walk.neighbours[index][k]).filter(|across| *across != NO_NEIGHBOUR);
                        for t in across.map(|across| (across / 4) as usize).into_iter().chain([index]) {
                            let lid = primitive.triangles[t].map(|v| at(v, walk.lids[v as usize][1]));
                            assert!(walk.irregular[t] || !pierces(side, lid), "{name}: {side:?} {lid:?}");
                        }
                    }
                }
            }
        }
    }

    /// Whether a segment passes through a triangle, by more than rounding.
    fn pierces([from, to]: [DVec3; 2], [a, b, c]: [DVec3; 3]) -> bool {
        let normal = (b - a).cross(c - a);
        let size = (b - a).length().max((c - a).length());
        let [before, beyond] = [from, to].map(|p| (p - a).dot(normal));
        let room = 1e-7 * size * normal.length();
        if before.min(beyond) > -room || before.max(beyond) < room {
            return false;
        }
        let at = from.lerp(to, before / (before - beyond));
        let weight = |p: DVec3, q: DVec3| (q - p).cross(at - p).dot(normal);
        [weight(a, b), weight(b, c), weight(c, a)].iter().all(|weight| *weight > 1e-7 * normal.length_squared())
    }

    #[test]
    fn borders_come_first_and_closed_meshes_have_none() {
        for name in ASSETS {
            for (_, geometry, walk, _) in walked(name) {
                let mut listed = walk.borders.clone();
                let border = |i: usize| walk.is_border(listed[i] as usize);
                assert!((0..listed.len()).all(|i| border(i) == (i < walk.border_count as usize)), "{name}");
                listed.sort_unstable();
                assert!(listed.iter().copied().eq(0..geometry.prisms.len() as u32), "{name}");
                assert_eq!(walk.is_open(), !["torus.gltf", "cube.gltf"].contains(&name), "{name}");
            }
        }
    }
}
