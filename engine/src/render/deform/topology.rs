//! What no pose of a mesh changes: who belongs together, and which corners lie around it.

use std::collections::HashMap;

use glam::{UVec4, Vec4};

use crate::render::layout::{DeformTriangle, DeformVertex};
use crate::render::plan::PlannedPrimitive;
use crate::scene::{Mesh, Primitive, Scene, tangent_space};
use crate::shell::{certificate, prisms::Across, walk::NO_NEIGHBOUR};

/// A mesh's vertices and triangles, numbered one primitive after the other.
pub struct Topology {
    pub vertices: Vec<DeformVertex>,
    pub triangles: Vec<DeformTriangle>,
    /// Lists of corners (4 · triangle + corner) around welded vertices, smoothing groups and vertices; before the lists
    /// of each kind where each of them begins and, once more, where the last one ends.
    pub fans: Vec<u32>,
    /// Where the lists around smoothing groups and around vertices begin.
    pub smooth_fans: u32,
    pub vertex_fans: u32,
    /// Welded vertices.
    pub welds: u32,
    /// First vertex and first triangle of each primitive.
    pub firsts: Vec<[u32; 2]>,
}

impl Topology {
    /// Gathers it. `planned`: the mesh's primitives in the plan.
    pub fn new(scene: &Scene, mesh: &Mesh, planned: &[PlannedPrimitive]) -> Self {
        let mut topology = Topology {
            vertices: Vec::new(),
            triangles: Vec::new(),
            fans: Vec::new(),
            smooth_fans: 0,
            vertex_fans: 0,
            welds: mesh.shell_normals.len() as u32,
            firsts: Vec::new(),
        };
        let mut smooth = HashMap::new();
        for (primitive, planned) in mesh.primitives.iter().zip(planned) {
            topology.firsts.push([topology.vertices.len() as u32, topology.triangles.len() as u32]);
            topology.add_vertices(scene, primitive, planned, &mut smooth);
            topology.add_triangles(scene, primitive);
        }
        for (planned, [_, first]) in planned.iter().zip(topology.firsts.clone()) {
            for (triangle, prism) in topology.triangles[first as usize..].iter_mut().zip(&planned.shell.prisms) {
                let number = |at: Across| topology.firsts[at.primitive][1] + at.triangle as u32;
                let [a, b, c] = prism.across.map(|at| at.map_or(NO_NEIGHBOUR, number));
                triangle.across = UVec4::new(a, b, c, 0);
            }
        }
        let (welds, groups, vertices) = (topology.welds, smooth.len() as u32, topology.vertices.len() as u32);
        topology.add_fans(welds, |vertices, v| vertices[v as usize].ids.x);
        topology.smooth_fans = topology.fans.len() as u32;
        topology.add_fans(groups, |vertices, v| vertices[v as usize].ids.y);
        topology.vertex_fans = topology.fans.len() as u32;
        topology.add_fans(vertices, |_, v| v);
        topology
    }

    /// `smooth`: the smoothing groups so far, by welded vertex and normal. What shares both in the file stays smooth;
    /// where normals differ there is a hard edge, and stays one.
    fn add_vertices(
        &mut self,
        scene: &Scene,
        primitive: &Primitive,
        planned: &PlannedPrimitive,
        smooth: &mut HashMap<(u32, [u32; 3]), u32>,
    ) {
        let space = tangent_space(&scene.materials[primitive.material], primitive);
        for v in 0..primitive.positions.len() {
            let weld = primitive.weld[v];
            let next = smooth.len() as u32;
            let normal = primitive.normals[v].to_array().map(|x| (x + 0.0).to_bits());
            let group = *smooth.entry((weld, normal)).or_insert(next);
            let tangent = space.filter(|_| planned.streams.tangents).map_or(Vec4::ZERO, |(set, transform)| {
                let uv = transform.transform_point2(primitive.uvs[set][v].as_dvec2()).as_vec2();
                Vec4::new(uv.x, uv.y, primitive.tangents.get(v).map_or(0.0, |tangent| tangent.w), 0.0)
            });
            let [base, lid] = planned.walk.as_ref().map_or([0.0; 2], |walk| walk.lids[v]);
            self.vertices.push(DeformVertex {
                ids: UVec4::new(weld, group, 0, 0),
                tangent,
                levels: Vec4::new(base as f32, lid as f32, 0.0, 0.0),
            });
        }
    }

    fn add_triangles(&mut self, scene: &Scene, primitive: &Primitive) {
        let first = self.vertices.len() as u32 - primitive.positions.len() as u32;
        let range = certificate::t_range(scene, primitive);
        let [low, high] = range.unwrap_or_default();
        for triangle in &primitive.triangles {
            let [a, b, c] = triangle.map(|v| first + v);
            self.triangles.push(DeformTriangle {
                corners: UVec4::new(a, b, c, u32::from(range.is_some())),
                across: UVec4::splat(NO_NEIGHBOUR),
                range: Vec4::new(low as f32, high as f32, 0.0, 0.0),
            });
        }
    }

    /// Appends the lists of `count` groups, to which `group` assigns each vertex.
    fn add_fans(&mut self, count: u32, group: impl Fn(&[DeformVertex], u32) -> u32) {
        let corners = || {
            let corner = |(t, triangle): (usize, &DeformTriangle)| {
                let corners = triangle.corners.to_array();
                (0..3).map(move |k| (4 * t as u32 + k as u32, corners[k]))
            };
            self.triangles.iter().enumerate().flat_map(corner).map(|(entry, v)| (entry, group(&self.vertices, v)))
        };
        // How many corners each has, then where each begins.
        let mut begins = vec![0u32; count as usize + 1];
        for (_, group) in corners() {
            begins[group as usize + 1] += 1;
        }
        let start = self.fans.len() as u32 + count + 1;
        begins[0] = start;
        for group in 0..count as usize {
            begins[group + 1] += begins[group];
        }
        let mut entries = vec![0; 3 * self.triangles.len()];
        let mut next = begins.clone();
        for (entry, group) in corners() {
            let at = &mut next[group as usize];
            entries[(*at - start) as usize] = entry;
            *at += 1;
        }
        self.fans.extend(begins);
        self.fans.extend(entries);
    }
}
