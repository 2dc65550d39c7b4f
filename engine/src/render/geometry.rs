//! A primitive as the shaders read it: vertices, prisms, indices, material.

use std::borrow::Cow;

use glam::{DAffine2, DVec2, DVec3, UVec3, UVec4, Vec2, Vec4};

use super::layout::{BoxNode, Material as GpuMaterial, PrismData, SurfaceVertex, Vertex};
use super::meshlets::{self, Meshlets};
use super::plan::{self, PlannedPrimitive, source};
use super::tangent_frames;
use super::variant::Vertices;
use crate::scene::{HeightSource, Material, Mesh, Primitive, Scene, TextureRef};
use crate::settings::{Horizon, Settings, Shell, Stage};
use crate::shell::{
    hierarchy,
    prisms::{self, MAX_OTHERS},
    walk::WalkGeometry,
};

/// Height of a surface that no map displaces (DESIGN section 3, `height.H`).
const DEFAULT_MIDLEVEL: f64 = 0.5;

/// What one primitive uploads.
pub struct PrimitiveData {
    /// Mesh-space point that the positions are relative to; of all primitives of a mesh the same, so that where they meet
    /// they do so to the bit.
    pub center: DVec3,
    /// Per vertex; empty where nothing reads shell normals.
    pub vertices: Vec<Vertex>,
    /// The same without these; empty where `vertices` are there, or nothing reads either.
    pub surface_vertices: Vec<SurfaceVertex>,
    /// UV sets 0 and 1, as in the file; each empty where nothing reads it.
    pub uvs: [Vec<Vec2>; 2],
    /// Shading tangents and handedness, with lengths where they frame the parallax; empty where nothing reads them.
    pub tangents: Vec<Vec4>,
    /// Triangles of the base surface that are drawn as such.
    pub indices: Vec<[u32; 3]>,
    /// Prisms.
    pub prisms: Vec<PrismData>,
    /// What the walk needs besides.
    pub walk: Option<WalkData>,
    /// Boxes over the prisms, for shadow rays; empty where there are none.
    pub hierarchy: Vec<BoxNode>,
    /// Their indices in the order in which a pose fits them anew; see [`hierarchy::ranks`].
    pub refit: Vec<Vec<u32>>,
    /// Half extents of a box around `center` that holds the primitive with all levels of its shell.
    pub extent: DVec3,
    /// Of its shell, along a unit normal, the base surface included: a faded one is within it.
    pub thickness: f64,
    /// Material.
    pub material: GpuMaterial,
}

/// The walk's buffers.
pub struct WalkData {
    /// Neighbour across each wall of each prism.
    pub adjacency: Vec<u32>,
    /// Base and lid level of each vertex.
    pub lids: Vec<Vec2>,
    /// Prisms in the order of [`WalkGeometry::borders`].
    pub borders: Vec<u32>,
    /// How many of them are borders.
    pub border_count: u32,
    /// Whether bases may be seen from outside.
    pub open: bool,
    /// The lids' meshlets.
    pub meshlets: Meshlets,
}

impl WalkData {
    fn new(primitive: &Primitive, planned: &PlannedPrimitive, walk: &WalkGeometry) -> Self {
        let displaced = (0..primitive.triangles.len()).filter(|t| !planned.shell.prisms[*t].plain);
        WalkData {
            adjacency: walk.neighbours.as_flattened().to_vec(),
            lids: walk.lids.iter().map(|levels| DVec2::from_array(*levels).as_vec2()).collect(),
            borders: if planned.lids.is_some() { walk.borders.clone() } else { Vec::new() },
            border_count: walk.border_count,
            // What a pose folds opens a border.
            open: planned.deforms || walk.is_open(),
            meshlets: match planned.lids {
                Some(Stage::Mesh) => meshlets::build(&primitive.positions, &primitive.triangles, displaced),
                _ => Meshlets::default(),
            },
        }
    }
}

impl PrimitiveData {
    /// Gathers it. `settings` give the march's steps.
    pub fn new(scene: &Scene, planned: &PlannedPrimitive, settings: &Settings) -> Self {
        let primitive = source(scene, planned);
        let material = &scene.materials[primitive.material];
        let displacement = prisms::displacement(scene, primitive);
        let center = center(&scene.meshes[planned.mesh]);
        // f32 keeps a deforming mesh's centre, so that the GPU rebases with one rounding, as is done here.
        let center = if planned.deforms { center.as_vec3().as_dvec3() } else { center };
        let height_uv = displacement.as_ref().map_or_else(Cow::default, |d| planned.shell.height_uvs(primitive, d));
        let framed = settings.resolved_shell() == Shell::Off
            && !planned.deforms
            && plan::tangents::from_mesh(material, primitive, settings);
        let frames = if framed { tangent_frames::of_vertices(primitive, &height_uv) } else { Vec::new() };
        let count = primitive.positions.len();
        let uvs = [0, 1].map(|set: usize| {
            let read = if planned.streams.uvs[set] { count } else { 0 };
            (0..read).map(|v| primitive.uvs[set].get(v).copied().unwrap_or_default()).collect()
        });
        let tangent = |v: usize| match frames.get(v) {
            Some(frame) => frame.tangent,
            None => primitive.tangents.get(v).copied().unwrap_or_default(),
        };
        let tangents = (0..if planned.streams.tangents { count } else { 0 }).map(tangent).collect();
        let vertices = (0..count)
            .map(|v| {
                let height_uv = height_uv.get(v).copied().unwrap_or_default();
                let shear = frames.get(v).map_or(0.0, |frame| frame.shear);
                // Where all heights are the same, the triangles themselves are moved to them.
                let lift = planned.offset.unwrap_or(0.0) * planned.shell_normals[v].as_dvec3();
                Vertex {
                    position: (primitive.positions[v].as_dvec3() + lift - center).as_vec3().extend(shear),
                    shell: planned.shell_normals[v].extend(height_uv.x),
                    normal: primitive.normals[v].extend(height_uv.y),
                }
            })
            .collect::<Vec<_>>();
        let surface =
            |v: &Vertex| SurfaceVertex { position: v.position.truncate().extend(v.shell.w), normal: v.normal };
        let (vertices, surface_vertices) = match planned.streams.vertices {
            Vertices::None => (Vec::new(), Vec::new()),
            Vertices::Surface => (Vec::new(), vertices.iter().map(surface).collect()),
            Vertices::Shell => (vertices, Vec::new()),
        };
        let traced = !planned.shell.prisms.is_empty();
        // The geometry stage makes lids of them.
        // What fades has the triangles themselves at its end.
        let indexed = !traced || planned.lids == Some(Stage::Geometry) || settings.lod_fade.is_some();
        let indices = if indexed { primitive.triangles.clone() } else { Vec::new() };
        let mut data = gpu_material(material, settings);
        let (low, high) = scene.displacement_range(primitive);
        if let Some(d) = &displacement {
            let scale = primitive.displacement_scale;
            let [width, height] = map_size(scene, d.source);
            data.height_size = Vec4::new(width, height, 0.0, 0.0);
            // A surface without a field has the height that is said to be its midlevel.
            let midlevel = d.midlevel + planned.offset.map_or(0.0, |level| level / scale);
            data.displacement = Vec4::new(scale as f32, midlevel as f32, low as f32, high as f32);
            let [least, greatest] = uv_bounds(primitive, &height_uv);
            let least = settings.uv_min.map_or(least, Vec2::from);
            let greatest = settings.uv_max.map_or(greatest, Vec2::from);
            data.shadow.y = planned.headroom as f32;
            data.shadow.w =
                planned.shell.prisms.iter().fold(high, |top, prism| top.max(prism.range[1])).max(0.0) as f32;
            data.uv_bounds = Vec4::new(least.x, least.y, greatest.x, greatest.y);
        }
        for (slot, other) in data.others.iter_mut().zip(&planned.shell.others) {
            let [width, height] = map_size(scene, other.source);
            *slot = Vec4::new(other.scale as f32, other.midlevel as f32, width, height);
        }
        // A baseline is made of them, and has none itself.
        let prisms = if settings.baseline.is_some() { 0 } else { planned.shell.prisms.len() };
        let nodes =
            if planned.hierarchy { boxes(primitive, planned, center, settings.lod_fade.is_some()) } else { Vec::new() };
        PrimitiveData {
            center,
            vertices,
            surface_vertices,
            uvs,
            tangents,
            indices,
            prisms: (0..prisms).map(|p| gpu_prism(planned, p)).collect(),
            walk: planned.walk.as_ref().map(|walk| WalkData::new(primitive, planned, walk)),
            refit: if planned.deforms { hierarchy::ranks(&nodes) } else { Vec::new() },
            hierarchy: nodes.into_iter().map(gpu_box).collect(),
            extent: extent(primitive, planned, center, (low, high)),
            thickness: high.max(0.0) - low.min(0.0),
            material: data,
        }
    }
}

impl PrimitiveData {
    /// What of it is uploaded, by its name after the primitive's, and in bytes. `deforms`: its mesh does.
    pub fn buffers(&self, deforms: bool) -> Vec<(&'static str, usize)> {
        let mut buffers = vec![
            ("indices", size_of_val(&self.indices[..])),
            ("vertices", size_of_val(&self.vertices[..])),
            ("surface_vertices", size_of_val(&self.surface_vertices[..])),
            ("uvs_0", size_of_val(&self.uvs[0][..])),
            ("uvs_1", size_of_val(&self.uvs[1][..])),
            ("tangents", size_of_val(&self.tangents[..])),
            ("prisms", size_of_val(&self.prisms[..])),
            ("hierarchy", size_of_val(&self.hierarchy[..])),
            ("material", size_of_val(&self.material)),
        ];
        if let Some(walk) = &self.walk {
            buffers.extend([
                ("adjacency", size_of_val(&walk.adjacency[..])),
                ("lids", size_of_val(&walk.lids[..])),
                ("borders", size_of_val(&walk.borders[..])),
                ("meshlets", size_of_val(&walk.meshlets.meshlets[..])),
                ("meshlet_vertices", size_of_val(&walk.meshlets.vertices[..])),
                ("meshlet_triangles", size_of_val(&walk.meshlets.triangles[..])),
            ]);
        }
        if deforms {
            buffers.extend([
                ("vertices at rest", size_of_val(&self.vertices[..])),
                ("prisms at rest", size_of_val(&self.prisms[..])),
                ("adjacency at rest", self.walk.as_ref().map_or(0, |walk| size_of_val(&walk.adjacency[..]))),
                ("boxes' order", self.refit.iter().map(|part| size_of_val(&part[..])).sum()),
            ]);
        }
        buffers.retain(|(_, bytes)| *bytes > 0);
        buffers
    }
}

/// Texels of a height map; a procedure's shader knows its own.
fn map_size(scene: &Scene, source: HeightSource) -> [f32; 2] {
    source.map().map_or([0.0; 2], |map| [scene.height_maps[map].width, scene.height_maps[map].height].map(|n| n as f32))
}

/// Middle of a mesh's bounding box.
fn center(mesh: &Mesh) -> DVec3 {
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for p in mesh.primitives.iter().flat_map(|p| &p.positions) {
        low = low.min(p.as_dvec3());
        high = high.max(p.as_dvec3());
    }
    if low.is_finite() { 0.5 * (low + high) } else { DVec3::ZERO }
}

/// Bounds of the coordinates that some triangle uses.
fn uv_bounds(primitive: &Primitive, uv: &[Vec2]) -> [Vec2; 2] {
    let used = primitive.triangles.iter().flatten().map(|v| uv[*v as usize]);
    used.fold([Vec2::INFINITY, Vec2::NEG_INFINITY], |[low, high], uv| [low.min(uv), high.max(uv)])
}

/// See [`PrimitiveData::extent`].
fn extent(primitive: &Primitive, planned: &PlannedPrimitive, center: DVec3, (low, high): (f64, f64)) -> DVec3 {
    let reach = low.abs().max(high.abs());
    let corners = primitive.positions.iter().zip(&planned.shell_normals);
    corners.fold(DVec3::ZERO, |extent, (position, normal)| {
        extent.max((position.as_dvec3() - center).abs() + reach * normal.as_dvec3().abs())
    })
}

/// Rounding of positions in f32 that the boxes allow for, relative to their size; that of `deform_fit_boxes.comp`.
const BOX_ROOM: f64 = 1e-6;

/// Boxes over the prisms, relative to `center`. A prism lies in the hull of its corners, however its walls bulge. `fades`:
/// its heights may, toward the base surface.
fn boxes(primitive: &Primitive, planned: &PlannedPrimitive, center: DVec3, fades: bool) -> Vec<hierarchy::Node> {
    let bounds = |prism: &prisms::Prism| {
        let corners = prism.corners.map(|v| {
            let (at, lift) = (primitive.positions[v as usize].as_dvec3(), planned.shell_normals[v as usize].as_dvec3());
            let [low, high] = prism.range;
            let range = if fades { [low.min(0.0), high.max(0.0)] } else { [low, high] };
            [range[0], range[1] + planned.headroom].map(|t| at - center + t * lift)
        });
        let empty = [DVec3::INFINITY, DVec3::NEG_INFINITY];
        let [low, high] = corners.as_flattened().iter().fold(empty, |[low, high], p| [low.min(*p), high.max(*p)]);
        let room = BOX_ROOM * low.abs().max(high.abs()).max_element();
        [low - room, high + room]
    };
    hierarchy::build(&planned.shell.prisms.iter().map(bounds).collect::<Vec<_>>())
}

fn gpu_box(node: hierarchy::Node) -> BoxNode {
    let bits = |at: DVec3| UVec3::from(at.as_vec3().to_array().map(f32::to_bits));
    BoxNode { low: bits(node.bounds[0]).extend(node.next), high: bits(node.bounds[1]).extend(node.prism) }
}

/// The bits are those of `shaders/shell/prism_bits.glsl`.
fn gpu_prism(planned: &PlannedPrimitive, index: usize) -> PrismData {
    let prism = &planned.shell.prisms[index];
    let mut packed = 0;
    for k in 0..3 {
        packed |= (prism.walls[k] as u32) << (3 * k);
        packed |= u32::from(prism.descending[k]) << (9 + k);
        packed |= prism.field[k] << (14 + 3 * k);
        packed |= u32::from(prism.behind[k]) << (23 + k);
    }
    packed |= u32::from(prism.plain) << 12;
    packed |= u32::from(prism.one_height) << 30;
    let mut reach = [0.0; 2];
    if let Some(walk) = &planned.walk {
        packed |= u32::from(walk.irregular[index]) << 13;
        packed |= u32::from(walk.is_border(index)) << 26;
        for k in 0..3 {
            packed |= u32::from(walk.brinks[index][k]) << (27 + k);
        }
        reach = walk.reach[index];
    }
    let [a, b, c] = prism.corners;
    let [low, high] = prism.range;
    PrismData {
        corners: UVec4::new(a, b, c, packed),
        range: Vec4::new(low as f32, high as f32, reach[0] as f32, reach[1] as f32),
        neighbour_uv: prism.neighbour_uv.map(|[first, second]| Vec4::new(first.x, first.y, second.x, second.y)),
    }
}

fn gpu_material(material: &Material, settings: &Settings) -> GpuMaterial {
    let rows = |texture: Option<TextureRef>| {
        let t = texture.map_or(DAffine2::IDENTITY, |t| t.transform);
        let m = t.matrix2;
        [
            Vec4::new(m.x_axis.x as f32, m.y_axis.x as f32, t.translation.x as f32, 0.0),
            Vec4::new(m.x_axis.y as f32, m.y_axis.y as f32, t.translation.y as f32, 0.0),
        ]
    };
    let normal_scale = material.normal.map_or(1.0, |(_, scale)| scale);
    let midlevel = material.displacement.map_or(DEFAULT_MIDLEVEL, |d| d.midlevel);
    let occlusion_strength = material.occlusion.map_or(1.0, |(_, strength)| strength);
    GpuMaterial {
        base_color: material.base_color_factor,
        factors: Vec4::new(material.roughness, material.metallic, normal_scale, occlusion_strength),
        emissive: material.emissive_factor.extend(material.alpha_cutoff.unwrap_or(0.0)),
        displacement: Vec4::new(0.0, midlevel as f32, 0.0, 0.0),
        uv_bounds: Vec4::ZERO,
        height_size: Vec4::ZERO,
        others: [Vec4::ZERO; MAX_OTHERS],
        march: UVec4::new(
            settings.min_steps,
            settings.max_steps,
            settings.refine_steps,
            u32::from(material.double_sided) + 2 * settings.step_limit,
        ),
        classic: {
            let shift = material.depth_offset.map_or(0.0, |offset| offset.distance);
            Vec4::new(settings.tolerance, settings.least_cosine(), shift as f32, settings.lod_fade.unwrap_or(0.0))
        },
        horizon: {
            let Horizon { strength, bias, safe_threshold, falloff } = settings.horizon;
            Vec4::new(strength, bias, safe_threshold, falloff)
        },
        shadow: Vec4::new(settings.shadow_softness, 0.0, settings.shadow_steps.unwrap_or(0) as f32, 0.0),
        base_color_uv: rows(material.base_color),
        metallic_roughness_uv: rows(material.metallic_roughness),
        normal_uv: rows(material.normal.map(|(t, _)| t)),
        occlusion_uv: rows(material.occlusion.map(|(t, _)| t)),
        emissive_uv: rows(material.emissive),
        specular: material.specular_color_factor.extend(material.specular),
        specular_uv: rows(material.specular_map),
        specular_color_uv: rows(material.specular_color),
    }
}
