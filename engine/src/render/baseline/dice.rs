//! Base triangles that the GPU dices for each frame: what it reads, and the draws of a frame.
//!
//! The shaders are `shaders/baseline/dice.*`. A draw takes neighbouring triangles, each cut into splits² patches, because
//! a patch has a limit of its own: the tessellator divides an edge into 64 at most, and a mesh workgroup has room for 16.
//! How finely an edge is divided follows from the edge alone, whatever the splits of the triangles there.

use glam::{DVec3, UVec4, Vec3, Vec4};
use rayon::prelude::*;

use super::clusters::Sight;
use super::surface::Surface;
use crate::error::Result;
use crate::gpu::{Buffer, CommandEncoder, Pipeline, Uploader, vk};
use crate::render::layout::{DicedTriangle, Draw, Frame, Object};
use crate::render::plan::PlannedPrimitive;
use crate::scene::Scene;
use crate::settings::Dicer;

/// How a primitive is diced: see [`crate::settings::Baseline::Diced`].
#[derive(Clone, Copy, Debug)]
pub struct Dicing {
    /// Stages.
    pub by: Dicer,
    /// Pixels.
    pub edge: f32,
    /// What cannot be seen is left out.
    pub culls: bool,
}

/// Small triangles of one draw at most: lavapipe's tessellator takes a time that grows with the square of the draw's size,
/// and draws large ones wrong.
const MOST_TRIANGLES: f64 = 50_000.0;
/// Patches of one draw of task shaders at most: 2¹⁵ workgroups of [`PATCHES_PER_TASK`].
const MOST_PATCHES: f64 = (PATCHES_PER_TASK << 15) as f64;
/// Patches that a task workgroup looks at; the constant of the same name in `baseline/dice.task`.
const PATCHES_PER_TASK: u32 = 32;
/// Patches along an edge of a triangle at most.
const MOST_SPLITS: u32 = 128;
/// So much more finely the CPU splits than it would have to, for the shaders' rounding.
const ROOM: f32 = 1.01;
/// The steepest that dicing makes heights seem, for [`DicedTriangle::range`]; the constant in `baseline/dicing.glsl`.
const STEEPEST: f64 = 8.0;

/// Into how many parts an edge of a patch is cut at most, as in the shaders.
fn most_steps(by: Dicer) -> u32 {
    match by {
        Dicer::Tessellation => 64,
        Dicer::Mesh => 16,
    }
}

/// Where a triangle's surface can be.
struct Hull {
    corners: [Vec3; 3],
    /// Corners at its lowest and at its highest level.
    points: [Vec3; 6],
}

/// A primitive to be diced.
pub struct Diced {
    triangles: Buffer,
    /// Of each triangle.
    hulls: Vec<Hull>,
    dicing: Dicing,
}

/// Some triangles in one draw.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Run {
    first: u32,
    triangles: u32,
    splits: u32,
    /// Steps of the longest edge of each, and their squares, summed.
    steps: f64,
    squares: f64,
}

impl Run {
    /// The run with one more triangle.
    fn with(self, need: Need) -> Run {
        Run {
            triangles: self.triangles + 1,
            splits: need.splits,
            steps: self.steps + need.steps,
            squares: self.squares + need.steps * need.steps,
            ..self
        }
    }

    /// What it draws: small triangles, of which the tessellator makes 1.5 times the square of its level, or patches.
    fn size(&self, by: Dicer) -> f64 {
        let (splits, triangles) = (f64::from(self.splits), f64::from(self.triangles));
        match by {
            Dicer::Tessellation => 1.5 * (self.squares + 2.0 * splits * self.steps + splits * splits * triangles),
            Dicer::Mesh => splits * splits * triangles,
        }
    }
}

/// What a triangle asks of a draw.
#[derive(Clone, Copy, Debug)]
struct Need {
    splits: u32,
    /// Parts of its longest edge.
    steps: f64,
}

impl Diced {
    /// Uploads what the shaders read. `center`: the mesh-space point that positions are relative to.
    ///
    /// # Panics
    /// Where the primitive is not displaced.
    pub fn new(
        uploader: &mut Uploader,
        name: &str,
        scene: &Scene,
        planned: &PlannedPrimitive,
        center: DVec3,
        dicing: Dicing,
    ) -> Result<Self> {
        let surface = Surface::new(scene, planned).expect("only displaced primitives are diced");
        let indices = 0..surface.triangles().len() as u32;
        let levels = |t: u32| planned.shell.prisms[t as usize].range;
        let triangles: Vec<_> =
            indices.clone().into_par_iter().map(|t| diced_triangle(&surface, t, levels(t))).collect();
        let hull = |t: u32| {
            let corners = surface.triangles()[t as usize].map(|v| surface.base(v));
            let at = |k: usize, level: f64| (corners[k][0] - center + level * corners[k][1]).as_vec3();
            let [low, high] = levels(t);
            let points = [at(0, low), at(1, low), at(2, low), at(0, high), at(1, high), at(2, high)];
            Hull { corners: [0, 1, 2].map(|k| at(k, 0.0)), points }
        };
        let name = format!("{name} diced triangles");
        let triangles = uploader.buffer(&name, vk::BufferUsageFlags::STORAGE_BUFFER, &triangles)?;
        Ok(Diced { triangles, hulls: indices.map(hull).collect(), dicing })
    }

    /// What the shaders read.
    pub fn triangles(&self) -> &Buffer {
        &self.triangles
    }

    /// Bytes that stay on the CPU.
    pub fn host_bytes(&self) -> u64 {
        size_of_val(self.hulls.as_slice()) as u64
    }

    /// Records its draws; the pipeline and its sets are bound. `index`: the object's. What is split, and which triangles
    /// lie outside the picture, is found here, on the CPU, so no GPU time is charged for it.
    pub fn record(&self, cmd: &mut CommandEncoder, pipeline: &Pipeline, index: u32, frame: &Frame, object: &Object) {
        let fineness = pixels_per_unit(frame, object) / self.dicing.edge;
        for run in self.runs(frame, object, fineness) {
            let patches = run.triangles * run.splits * run.splits;
            cmd.push(
                pipeline,
                &Draw {
                    object: index,
                    count: patches,
                    first: run.first,
                    splits: run.splits,
                    fineness,
                    ..Draw::default()
                },
            );
            match self.dicing.by {
                Dicer::Mesh => cmd.draw_mesh_tasks(patches.div_ceil(PATCHES_PER_TASK), 1, 1),
                Dicer::Tessellation => {
                    // One triangle alone may be too much.
                    let draws = (run.size(self.dicing.by) / MOST_TRIANGLES).ceil().max(1.0);
                    let most = (f64::from(patches) / draws).ceil() as u32;
                    for first in (0..patches).step_by(most as usize) {
                        cmd.draw(most.min(patches - first), 1, first, 0);
                    }
                }
            }
        }
    }

    /// The draws: triangles in their order, those left out that lie outside the picture.
    fn runs(&self, frame: &Frame, object: &Object, fineness: f32) -> Vec<Run> {
        let sight = Sight::new(frame, object, true);
        let need = |hull: &Hull| self.need(hull, &sight, frame, object, fineness);
        let needs: Vec<_> = self.hulls.par_iter().map(need).collect();
        merged(&needs, self.dicing.by)
    }

    /// As `parts_of` in `baseline/dicing.glsl` has it for the edge that needs most; none where all lies outside the
    /// picture.
    fn need(&self, hull: &Hull, sight: &Sight, frame: &Frame, object: &Object, fineness: f32) -> Option<Need> {
        let shows = sight.may_show(&hull.points);
        if !shows && self.dicing.culls {
            return None;
        }
        let near = frame.lens.z;
        let depth = |p: Vec3| object.depth.dot(p.extend(1.0)).max(near);
        let rows = [object.world_x, object.world_y, object.world_z].map(|row| row.truncate());
        let most = (0..3).map(|k| {
            let [a, b] = [hull.corners[(k + 1) % 3], hull.corners[(k + 2) % 3]];
            let across = Vec3::from_array(rows.map(|row| row.dot(a - b)));
            let depth = if frame.projection.x == 0 { 1.0 } else { depth(a).min(depth(b)) };
            across.length() * fineness / depth
        });
        let steps = most.fold(1.0, f32::max) * ROOM;
        let limit = most_steps(self.dicing.by);
        // Where nothing is culled it is drawn all the same, but nobody sees how finely.
        let most = if shows { MOST_SPLITS } else { 1 };
        let patches = (steps / limit as f32).ceil().min(most as f32) as u32;
        let splits = patches.max(1).next_power_of_two();
        Some(Need { splits, steps: f64::from(steps.min((splits * limit) as f32)) })
    }
}

/// Neighbouring triangles in one draw each, as long as it does not grow too large.
fn merged(needs: &[Option<Need>], by: Dicer) -> Vec<Run> {
    let most = match by {
        Dicer::Tessellation => MOST_TRIANGLES,
        Dicer::Mesh => MOST_PATCHES,
    };
    let mut runs: Vec<Run> = Vec::new();
    let mut open = false;
    for (first, need) in (0..).zip(needs) {
        if let Some(need) = need {
            // Of the same splits only: how a triangle is diced is not to depend on what else is drawn.
            let last = runs.last().filter(|run| open && run.splits == need.splits);
            match last.map(|run| run.with(*need)).filter(|run| run.size(by) <= most) {
                Some(grown) => *runs.last_mut().expect("one is open") = grown,
                None => runs.push(Run { first, ..Run::default() }.with(*need)),
            }
        }
        open = need.is_some();
    }
    runs
}

/// Pixels that a world unit spans, one unit before the eye, or anywhere in an orthographic view.
fn pixels_per_unit(frame: &Frame, object: &Object) -> f32 {
    // Clip y of a world direction: the mesh's row times the inverse of mesh to world.
    let row = object.clip_y.truncate();
    let world = [object.normal_x, object.normal_y, object.normal_z].map(|n| n.truncate().dot(row));
    0.5 * frame.viewport.y * Vec3::from_array(world).length()
}

fn diced_triangle(surface: &Surface, index: u32, [low, high]: [f64; 2]) -> DicedTriangle {
    let corners = surface.triangles()[index as usize];
    let edges = [0, 1, 2].map(|k| [corners[(k + 1) % 3], corners[(k + 2) % 3]]);
    let turned = |k: usize| u32::from(surface.edge(edges[k]) != edges[k]) << k;
    let [a, b, c] = corners;
    let anchors = corners.map(|v| surface.anchor(v));
    let [e, f, g] = edges.map(|edge| surface.ends(surface.edge(edge)));
    let [lean, start] = lean(surface, index, [low, high]);
    DicedTriangle {
        corners: UVec4::new(a, b, c, turned(0) | turned(1) | turned(2)),
        anchors: UVec4::new(anchors[0], anchors[1], anchors[2], 0),
        edges: UVec4::new(e[0], e[1], f[0], f[1]),
        last_edge: UVec4::new(g[0], g[1], 0, 0),
        range: Vec4::new(low as f32, high as f32, lean as f32, start as f32),
    }
}

/// How far the normals of small triangles turn from that of the base triangle: their tangent is at most
/// steepness · \[0\] + \[1\], where the steepness, of [`STEEPEST`] at most, tells how much steeper than the field along the
/// triangle's edges a small triangle's shape may make it.
///
/// With the edges e, f of a level, shell normals N, M and slopes s, t along e and f, a small triangle's normal is
/// (e + s N) × (f + t M) = e × f + s N × f + t e × M + s t N × M.
fn lean(surface: &Surface, index: u32, levels: [f64; 2]) -> [f64; 2] {
    let unbounded = [f64::INFINITY, 0.0];
    let Some(slope) = surface.steepness(index) else { return unbounded };
    let corners = surface.triangles()[index as usize].map(|v| surface.base(v));
    let edges = |level: f64| {
        let at = |k: usize| corners[k][0] + level * corners[k][1];
        [at(1) - at(0), at(2) - at(0)]
    };
    let [e, f] = edges(0.0);
    let normal = e.cross(f);
    let area = normal.length();
    if area == 0.0 {
        return unbounded;
    }
    let normal = normal / area;
    // A level's normal is a quadratic in the level: by its Bernstein coefficients.
    let [[e0, f0], [e1, f1]] = levels.map(edges);
    let leveled = [e0.cross(f0), 0.5 * (e0.cross(f1) + e1.cross(f0)), e1.cross(f1)];
    let turned = leveled.map(|n| (n / area - normal).length()).into_iter().fold(0.0, f64::max);
    let longest = [e0, f0, e1, f1].map(DVec3::length).into_iter().fold(0.0, f64::max) / area;
    let lifts = corners.map(|[_, lift]| lift);
    let lift = lifts.map(DVec3::length).into_iter().fold(0.0, f64::max);
    let sideways = lifts.map(|n| (n - n.dot(normal) * normal).length()).into_iter().fold(0.0, f64::max);
    let twisted = [0, 1, 2].map(|k| lifts[k].cross(lifts[(k + 1) % 3]).length()).into_iter().fold(0.0, f64::max) / area;
    // What may shorten the normal's part along the base triangle's, at worst.
    let steep = STEEPEST * slope;
    let second = steep * steep * twisted;
    let along = 1.0 - turned - 2.0 * steep * longest * sideways - second;
    if along <= 0.0 {
        return unbounded;
    }
    [2.0 * slope * longest * lift / along, (turned + second) / along]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_draw_is_larger_than_the_tessellator_bears_and_none_is_left_out() {
        // Every third triangle needs two patches an edge, every seventh is not seen.
        let need = |t: u32| {
            let splits = if t.is_multiple_of(3) { 2 } else { 1 };
            (!t.is_multiple_of(7)).then_some(Need { splits, steps: f64::from(30 * splits) })
        };
        let needs: Vec<_> = (0..10_000).map(need).chain((0..500).map(|_| need(1))).collect();
        for by in Dicer::ALL.iter().copied() {
            let runs = merged(&needs, by);
            assert!(runs.iter().all(|run| run.size(by) <= MOST_TRIANGLES), "{by}");
            let drawn: Vec<_> =
                runs.iter().flat_map(|run| (0..run.triangles).map(|i| (run.first + i, run.splits))).collect();
            let wanted: Vec<_> = (0..).zip(&needs).filter_map(|(t, need)| Some((t, (*need)?.splits))).collect();
            assert_eq!(drawn, wanted, "{by}");
        }
        let alike: Vec<_> = (0..1000).map(|_| need(1)).collect();
        let most = merged(&alike, Dicer::Tessellation).iter().map(|run| run.triangles).max();
        assert!(most > Some(30), "draws are merged: {most:?}");
    }
}
