//! Closed convex meshes that rays are aimed at.

use std::collections::{HashMap, HashSet};

use glam::DVec3;

use super::{LEVEL, THICK, rig::random::Random};

/// A closed mesh of radius about 1 around the origin, by its surface at [`LEVEL`].
pub struct Mesh {
    pub name: &'static str,
    pub surface: Vec<DVec3>,
    pub normals: Vec<DVec3>,
    pub triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// An icosahedron's faces in four, with normals tilted at random: the walls are curved, and no number is round.
    pub fn tilted() -> Mesh {
        let g = 0.5 * (1.0 + 5f64.sqrt());
        let corners = (0..12).map(|i| {
            let (a, b) = (if i & 1 == 0 { 1.0 } else { -1.0 }, if i & 2 == 0 { g } else { -g });
            match i / 4 {
                0 => DVec3::new(a, b, 0.0),
                1 => DVec3::new(0.0, a, b),
                _ => DVec3::new(b, 0.0, a),
            }
        });
        let (surface, triangles) = sphere(&corners.collect::<Vec<_>>(), 2);
        let mut random = Random(7);
        let mut tilt = || DVec3::from_array(std::array::from_fn(|_| 0.24 * (2.0 * random.next() - 1.0)));
        let normals = surface.iter().map(|p| (*p + tilt()).normalize()).collect();
        Mesh { name: "tilted", surface, normals, triangles }
    }

    /// An octahedron's faces in sixteen, each coordinate a multiple of 1/128: along axes and diagonals all of the walls'
    /// arithmetic is exact, and rays lie in walls, and on vertex lines, to the last bit.
    pub fn exact() -> Mesh {
        let axes = [DVec3::X, DVec3::Y, DVec3::Z].into_iter().flat_map(|axis| [axis, -axis]);
        let (surface, triangles) = sphere(&axes.collect::<Vec<_>>(), 4);
        let rounded = |p: &DVec3, step: f64| (*p / step).round() * step;
        let normals = surface.iter().map(|p| rounded(p, 1.0 / 64.0)).collect();
        let surface = surface.iter().map(|p| rounded(p, 1.0 / 128.0)).collect();
        Mesh { name: "exact", surface, normals, triangles }
    }

    /// Corner k of a triangle at a level.
    pub fn at(&self, vertex: u32, level: f64) -> DVec3 {
        self.surface[vertex as usize] + (level - LEVEL) * self.normals[vertex as usize]
    }

    /// The least distance of a face of the surface from the middle. Insists that the surface is convex and that no prism
    /// folds within [`THICK`].
    pub fn inradius(&self) -> f64 {
        let mut inradius = f64::INFINITY;
        for triangle in &self.triangles {
            let normal = |level: f64| {
                let [a, b, c] = triangle.map(|v| self.at(v, level));
                (b - a).cross(c - a).normalize()
            };
            let (normal_at_level, on) = (normal(LEVEL), self.surface[triangle[0] as usize]);
            for (vertex, point) in (0..).zip(&self.surface) {
                let above = normal_at_level.dot(*point - on);
                assert!(triangle.contains(&vertex) || above < -1e-3, "{} is not convex: {above}", self.name);
            }
            for step in 0..=8 {
                let normal = normal(THICK[0] + (THICK[1] - THICK[0]) * f64::from(step) / 8.0);
                for vertex in triangle {
                    assert!(normal.dot(self.normals[*vertex as usize]) > 0.2, "{} folds", self.name);
                }
            }
            inradius = inradius.min(normal_at_level.dot(on));
        }
        inradius
    }

    /// Every edge once. Insists that the mesh is closed.
    pub fn edges(&self) -> Vec<[u32; 2]> {
        let sides = || self.triangles.iter().flat_map(|t| (0..3).map(move |k| [t[k], t[(k + 1) % 3]]));
        let all: HashSet<[u32; 2]> = sides().collect();
        assert_eq!(all.len(), 3 * self.triangles.len(), "two triangles at one side of an edge");
        assert!(all.iter().all(|[a, b]| all.contains(&[*b, *a])), "{} has a border", self.name);
        sides().filter(|[a, b]| a < b).collect()
    }
}

/// The convex hull of corners that has equilateral faces, each face in `n` by `n`, out to the unit sphere.
fn sphere(corners: &[DVec3], n: i32) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let edge = corners[1..].iter().map(|c| c.distance(corners[0])).fold(f64::INFINITY, f64::min);
    let near = |a: DVec3, b: DVec3| a.distance(b) < 1.01 * edge;
    let mut points: Vec<DVec3> = Vec::new();
    let mut known: HashMap<[i64; 3], u32> = HashMap::new();
    let mut triangles = Vec::new();
    let count = corners.len();
    for (i, j, k) in (0..count).flat_map(|i| (i..count).flat_map(move |j| (j..count).map(move |k| (i, j, k)))) {
        let [a, mut b, mut c] = [corners[i], corners[j], corners[k]];
        if i == j || j == k || !near(a, b) || !near(b, c) || !near(c, a) {
            continue;
        }
        if (b - a).cross(c - a).dot(a) < 0.0 {
            (b, c) = (c, b);
        }
        let mut point = |u: i32, v: i32| {
            let p = (a + (b - a) * f64::from(u) / f64::from(n) + (c - a) * f64::from(v) / f64::from(n)).normalize();
            let key = (p * 1e6).round().to_array().map(|x| x as i64);
            *known.entry(key).or_insert_with(|| {
                points.push(p);
                points.len() as u32 - 1
            })
        };
        for (u, v) in (0..n).flat_map(|u| (0..n - u).map(move |v| (u, v))) {
            triangles.push([point(u, v), point(u + 1, v), point(u, v + 1)]);
            if u + v + 1 < n {
                triangles.push([point(u + 1, v), point(u + 1, v + 1), point(u, v + 1)]);
            }
        }
    }
    (points, triangles)
}
