//! A primitive as the shaders read it: vertices, prisms, indices, material.

use glam::{DAffine2, DVec3, UVec4, Vec2, Vec4};

use super::layout::{Material as GpuMaterial, PrismData, Vertex};
use super::plan::{PlannedPrimitive, source};
use super::variant::wrap_mode;
use crate::scene::{Material, Mesh, Primitive, Scene, TextureRef};
use crate::settings::Settings;
use crate::shell::prisms::{self, MAX_OTHERS, Prism};

/// Height of a surface that no map displaces (DESIGN section 3, `height.H`).
const DEFAULT_MIDLEVEL: f64 = 0.5;

/// What one primitive uploads.
pub struct PrimitiveData {
    /// Mesh-space point that the positions are relative to; of all primitives of a mesh the same, so that where they meet
    /// they do so to the bit.
    pub center: DVec3,
    /// Per vertex.
    pub vertices: Vec<Vertex>,
    /// Triangles of the base surface that are drawn as such.
    pub indices: Vec<[u32; 3]>,
    /// Prisms.
    pub prisms: Vec<PrismData>,
    /// Material.
    pub material: GpuMaterial,
}

impl PrimitiveData {
    /// Gathers it. `settings` give the march's steps.
    pub fn new(scene: &Scene, planned: &PlannedPrimitive, settings: &Settings) -> Self {
        let primitive = source(scene, planned);
        let material = &scene.materials[primitive.material];
        let mesh = &scene.meshes[planned.mesh];
        let displacement = prisms::displacement(scene, primitive);
        let center = center(mesh);
        let height_uv = match &displacement {
            Some(d) if planned.shell.height_uv.is_empty() => prisms::height_uvs(primitive, d),
            _ => planned.shell.height_uv.clone(),
        };
        let uv = |set: usize, v: usize| primitive.uvs[set].get(v).copied().unwrap_or_default();
        let vertices = (0..primitive.positions.len())
            .map(|v| {
                let shell = mesh.shell_normals[primitive.weld[v] as usize] * planned.factors[v];
                let height_uv = height_uv.get(v).copied().unwrap_or_default();
                let (uv0, uv1) = (uv(0, v), uv(1, v));
                Vertex {
                    position: (primitive.positions[v].as_dvec3() - center).as_vec3().extend(0.0),
                    shell: shell.as_vec3().extend(height_uv.x),
                    normal: primitive.normals[v].extend(height_uv.y),
                    tangent: primitive.tangents.get(v).copied().unwrap_or_default(),
                    uvs: Vec4::new(uv0.x, uv0.y, uv1.x, uv1.y),
                }
            })
            .collect();
        let traced = !planned.shell.prisms.is_empty();
        let indices = if traced { Vec::new() } else { primitive.triangles.clone() };
        let mut data = gpu_material(material, settings);
        if let Some(d) = &displacement {
            let (low, high) = scene.displacement_range(primitive);
            let scale = primitive.displacement_scale;
            data.displacement = Vec4::new(scale as f32, d.midlevel as f32, low as f32, high as f32);
            let [least, greatest] = uv_bounds(primitive, &height_uv);
            data.uv_bounds = Vec4::new(least.x, least.y, greatest.x, greatest.y);
        }
        for (slot, other) in data.others.iter_mut().zip(&planned.shell.others) {
            let [u, v] = other.wrap.map(wrap_mode);
            *slot = Vec4::new(other.scale as f32, other.midlevel as f32, u as f32, v as f32);
        }
        PrimitiveData {
            center,
            vertices,
            indices,
            prisms: planned.shell.prisms.iter().map(gpu_prism).collect(),
            material: data,
        }
    }
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

fn gpu_prism(prism: &Prism) -> PrismData {
    let mut packed = 0;
    for k in 0..3 {
        packed |= (prism.walls[k] as u32) << (3 * k);
        packed |= u32::from(prism.descending[k]) << (9 + k);
        packed |= prism.field[k] << (14 + 3 * k);
        packed |= u32::from(prism.behind[k]) << (23 + k);
    }
    packed |= u32::from(prism.plain) << 12;
    let [a, b, c] = prism.corners;
    let [low, high] = prism.range;
    PrismData {
        corners: UVec4::new(a, b, c, packed),
        range: Vec4::new(low as f32, high as f32, 0.0, 0.0),
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
        others: [Vec4::ZERO; MAX_OTHERS],
        march: UVec4::new(
            settings.min_steps,
            settings.max_steps,
            settings.refine_steps,
            u32::from(material.double_sided) + 2 * settings.step_limit,
        ),
        base_color_uv: rows(material.base_color),
        metallic_roughness_uv: rows(material.metallic_roughness),
        normal_uv: rows(material.normal.map(|(t, _)| t)),
        occlusion_uv: rows(material.occlusion.map(|(t, _)| t)),
        emissive_uv: rows(material.emissive),
    }
}
