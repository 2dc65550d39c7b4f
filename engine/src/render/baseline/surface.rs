//! The displaced surface of one primitive, sampled in f64 (DESIGN section 1).

use std::collections::HashMap;

use glam::{DVec2, DVec3, Vec2};

use crate::render::plan::{PlannedPrimitive, source};
use crate::scene::Scene;
use crate::shell::{heights::Heights, prisms::displacement};

/// Two sides of an edge whose heights differ by less than this, of the height range, are one surface.
const SAME_HEIGHT: f64 = 1e-9;

/// Texels across an edge, as it were, of a function that gives the heights.
const FUNCTION_TEXELS: f64 = 64.0;

/// One corner of a triangle.
#[derive(Clone, Copy)]
struct Corner {
    position: DVec3,
    /// Shell normal times r.
    lift: DVec3,
    /// Shading normal.
    normal: DVec3,
    height_uv: DVec2,
}

/// A primitive's displaced surface.
pub struct Surface {
    heights: Heights,
    scale: f64,
    midlevel: f64,
    corners: Vec<Corner>,
    triangles: Vec<[u32; 3]>,
    weld: Vec<u32>,
    uvs: Vec<Vec2>,
    /// Welded vertex → the vertex whose height map coordinates all of them take, where that makes no difference.
    canonical_vertex: HashMap<u32, u32>,
    /// Welded edge, lower id first → its two vertices, to the same end.
    canonical_edge: HashMap<[u32; 2], [u32; 2]>,
    /// Edge of two vertices, the lower first → triangles there: their normals there are one.
    edge_triangles: HashMap<[u32; 2], Vec<u32>>,
    /// Vertex → triangles there.
    vertex_triangles: Vec<Vec<u32>>,
}

/// The two vertices in the order of their welded ids.
pub fn edge_of(weld: &[u32], [a, b]: [u32; 2]) -> [u32; 2] {
    if weld[a as usize] <= weld[b as usize] { [a, b] } else { [b, a] }
}

impl Surface {
    /// The surface of a planned primitive, which is displaced.
    pub fn new(scene: &Scene, planned: &PlannedPrimitive) -> Option<Self> {
        let primitive = source(scene, planned);
        let d = displacement(scene, primitive)?;
        let corners = (0..primitive.positions.len())
            .map(|v| Corner {
                position: primitive.positions[v].as_dvec3(),
                lift: planned.shell_normals[v].as_dvec3(),
                normal: primitive.normals[v].as_dvec3(),
                height_uv: planned.shell.height_uv[v].as_dvec2(),
            })
            .collect::<Vec<_>>();
        let mut surface = Surface {
            heights: Heights::new(scene, &d),
            scale: primitive.displacement_scale,
            midlevel: d.midlevel,
            vertex_triangles: vec![Vec::new(); corners.len()],
            corners,
            triangles: primitive.triangles.clone(),
            weld: primitive.weld.clone(),
            uvs: primitive.uvs[d.tex_coord].clone(),
            canonical_vertex: HashMap::new(),
            canonical_edge: HashMap::new(),
            edge_triangles: HashMap::new(),
        };
        for (t, triangle) in primitive.triangles.iter().enumerate() {
            for k in 0..3 {
                let v = triangle[k];
                surface.canonical_vertex.entry(primitive.weld[v as usize]).or_insert(v);
                surface.vertex_triangles[v as usize].push(t as u32);
                let edge = surface.edge([triangle[(k + 1) % 3], triangle[(k + 2) % 3]]);
                let welded = edge.map(|v| primitive.weld[v as usize]);
                surface.canonical_edge.entry(welded).or_insert(edge);
                let mut unordered = edge;
                unordered.sort_unstable();
                surface.edge_triangles.entry(unordered).or_default().push(t as u32);
            }
        }
        Some(surface)
    }

    /// Base triangles, by vertices.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// Stored texture coordinates of a vertex.
    pub fn uv(&self, vertex: u32) -> Vec2 {
        self.uvs[vertex as usize]
    }

    /// See [`edge_of`].
    pub fn edge(&self, ends: [u32; 2]) -> [u32; 2] {
        edge_of(&self.weld, ends)
    }

    fn corner(&self, vertex: u32) -> &Corner {
        &self.corners[vertex as usize]
    }

    /// The level at a point of the height map.
    fn level(&self, uv: DVec2) -> f64 {
        (self.heights.at(uv).0 - self.midlevel) * self.scale
    }

    /// The level there, or at `canonical` where that is the same but for rounding: then all sides have it to the bit.
    fn shared_level(&self, uv: DVec2, canonical: DVec2) -> f64 {
        let (own, shared) = (self.level(uv), self.level(canonical));
        if (own - shared).abs() <= SAME_HEIGHT * self.scale { shared } else { own }
    }

    /// The surface above a vertex; the same to the bit for all vertices welded to it, where there is no step.
    pub fn vertex(&self, vertex: u32) -> DVec3 {
        let corner = self.corner(vertex);
        let canonical = self.canonical_vertex[&self.weld[vertex as usize]];
        corner.position + self.shared_level(corner.height_uv, self.corner(canonical).height_uv) * corner.lift
    }

    /// The vertex whose height map coordinates the surface above `vertex` takes.
    pub fn anchor(&self, vertex: u32) -> u32 {
        let canonical = self.canonical_vertex[&self.weld[vertex as usize]];
        let [own, shared] = [vertex, canonical].map(|v| self.level(self.corner(v).height_uv));
        if (own - shared).abs() <= SAME_HEIGHT * self.scale { canonical } else { vertex }
    }

    /// The vertices whose height map coordinates the surface above an edge takes, in the order of [`Self::edge`]: its own
    /// where there is a step anywhere along it.
    pub fn ends(&self, edge: [u32; 2]) -> [u32; 2] {
        let canonical = self.canonical_edge[&edge.map(|v| self.weld[v as usize])];
        let [a, b, from, to] = [edge[0], edge[1], canonical[0], canonical[1]].map(|v| self.corner(v).height_uv);
        // Between the texels that it crosses, a level along an edge is a quadratic.
        let crossed = self.heights.texels().map_or(FUNCTION_TEXELS, |size| ((b - a) * size).abs().element_sum());
        let samples = 4 * crossed.ceil() as u32 + 4;
        let same = |i: u32| {
            let s = f64::from(i) / f64::from(samples);
            let [own, shared] = [a.lerp(b, s), from.lerp(to, s)].map(|uv| self.level(uv));
            (own - shared).abs() <= SAME_HEIGHT * self.scale
        };
        if canonical == edge || (0..=samples).all(same) { canonical } else { edge }
    }

    /// Position, and shell normal times r, of a vertex.
    pub fn base(&self, vertex: u32) -> [DVec3; 2] {
        [self.corner(vertex).position, self.corner(vertex).lift]
    }

    /// How fast the level can change along the edges of a triangle, per edge: the greatest; none where nobody knows.
    pub fn steepness(&self, triangle: u32) -> Option<f64> {
        let uv = self.triangles[triangle as usize].map(|v| self.corner(v).height_uv);
        let [low, high] = [uv[0].min(uv[1]).min(uv[2]), uv[0].max(uv[1]).max(uv[2])];
        let slope = self.heights.steepest(low, high)?;
        let edge = |k: usize| (uv[(k + 1) % 3] - uv[k]).abs().dot(slope);
        Some(self.scale * edge(0).max(edge(1)).max(edge(2)))
    }

    /// The surface above an edge as [`Self::edge`] orders it, at share `s` of the way; the same to the bit from both
    /// sides, where there is no step.
    pub fn along_edge(&self, edge: [u32; 2], s: f64) -> DVec3 {
        let [a, b] = edge.map(|v| self.corner(v));
        let canonical = self.canonical_edge[&edge.map(|v| self.weld[v as usize])];
        let [from, to] = canonical.map(|v| self.corner(v).height_uv);
        let level = self.shared_level(a.height_uv.lerp(b.height_uv, s), from.lerp(to, s));
        (a.position + level * a.lift).lerp(b.position + level * b.lift, s)
    }

    /// The surface inside a triangle.
    pub fn inside(&self, triangle: u32, lambda: DVec3) -> DVec3 {
        let corners = self.triangles[triangle as usize].map(|v| self.corner(v));
        let uv = (0..3).map(|k| corners[k].height_uv * lambda[k]).sum();
        let level = self.level(uv);
        (0..3).map(|k| lambda[k] * (corners[k].position + level * corners[k].lift)).sum()
    }

    /// The shading normal in a triangle, unit: the height's gradient on the authored normal (DESIGN section 4).
    pub fn normal(&self, triangle: u32, lambda: DVec3) -> DVec3 {
        let c = self.triangles[triangle as usize].map(|v| self.corner(v));
        let uv = (0..3).map(|k| c[k].height_uv * lambda[k]).sum();
        let (height, slope) = self.heights.at(uv);
        let level = (height - self.midlevel) * self.scale;
        let at = |k: usize| c[k].position + level * c[k].lift;
        let (e1, e2) = (at(1) - at(0), at(2) - at(0));
        let plain = c.iter().all(|c| c.lift == DVec3::ZERO);
        let slope = if plain { DVec2::ZERO } else { slope * self.scale };
        let [f1, f2] = [1, 2].map(|k| slope.dot(c[k].height_uv - c[0].height_uv));
        let authored: DVec3 = (0..3).map(|k| lambda[k] * c[k].normal).sum();
        let authored = authored.normalize_or_zero();
        (e1.cross(e2).length() * authored + f1 * authored.cross(e2) + f2 * e1.cross(authored)).normalize_or_zero()
    }

    /// The mean of the normals of the triangles that share an edge's two vertices, at share `s` from the first.
    pub fn edge_normal(&self, edge: [u32; 2], s: f64) -> DVec3 {
        let mut unordered = edge;
        unordered.sort_unstable();
        let weight = |v: u32| {
            if v == edge[0] {
                1.0 - s
            } else if v == edge[1] {
                s
            } else {
                0.0
            }
        };
        self.mean_normal(&self.edge_triangles[&unordered], weight)
    }

    /// The mean of the normals of the triangles around a vertex.
    pub fn vertex_normal(&self, vertex: u32) -> DVec3 {
        self.mean_normal(&self.vertex_triangles[vertex as usize], |v| f64::from(u8::from(v == vertex)))
    }

    fn mean_normal(&self, triangles: &[u32], weight: impl Fn(u32) -> f64) -> DVec3 {
        let normal = |t: &u32| self.normal(*t, DVec3::from_array(self.triangles[*t as usize].map(&weight)));
        triangles.iter().map(normal).sum::<DVec3>().normalize_or_zero()
    }
}
