//! What is drawn: meshes, materials, height maps, instances, cameras, lights. Knows no Vulkan.
//!
//! [`load`] reads a glTF file into a [`Scene`]; [`Scene::with_defaults`] adds the camera and the light that it lacks.

mod accessor;
mod adjust;
mod ambient;
mod bounds;
mod camera;
mod container;
mod displacement;
mod document;
mod height;
mod image;
mod import;
mod light;
mod material;
mod mesh;
mod node;
mod procedure;
mod tangents;
#[cfg(test)]
mod tests;
mod texture;
mod triangles;
mod uri;
mod weld;

pub use adjust::{Adjustment, Beyond, HeightFormat};
pub use ambient::Ambient;
pub use camera::frame;
pub use import::load;
pub(crate) use mesh::tangent_space;
pub use procedure::Procedure;

use std::path::PathBuf;

use glam::{DAffine2, DAffine3, DVec3, Vec2, Vec3, Vec4};
use half::f16;

/// A scene file after import: everything resolved, checked and in memory.
#[derive(Clone, Debug)]
pub struct Scene {
    /// The file it came from.
    pub file: PathBuf,
    /// glTF meshes in file order.
    pub meshes: Vec<Mesh>,
    /// glTF materials in file order; a primitive without one uses an appended default material.
    pub materials: Vec<Material>,
    /// Decoded colour images that some material reads.
    pub images: Vec<ColorImage>,
    /// Height maps that some displacement reads.
    pub height_maps: Vec<HeightMap>,
    /// Nodes of the default scene that carry a mesh, in node order.
    pub instances: Vec<Instance>,
    /// The file's first camera (in node order of the default scene), if any.
    pub camera: Option<Camera>,
    /// `KHR_lights_punctual` lights in node order.
    pub lights: Vec<Light>,
    /// Light from everywhere: the file's `EXT_lights_image_based`, else a two-colour sky.
    pub ambient: Ambient,
    /// What was ignored or replaced, one sentence each, for the user.
    pub notices: Vec<String>,
}

/// A glTF mesh.
#[derive(Clone, Debug)]
pub struct Mesh {
    /// Its name in the file, or "mesh N".
    pub name: String,
    /// Its triangle primitives.
    pub primitives: Vec<Primitive>,
    /// Shell normal of each welded vertex: unit, or zero where the weighted sum vanishes (DESIGN section 1).
    pub shell_normals: Vec<DVec3>,
    /// Its positions will change from frame to frame. Set by whoever changes them; no file says so.
    pub deforms: bool,
}

/// A triangle list with one material. All per-vertex arrays have the same length, but those that the file lacks are empty.
#[derive(Clone, Debug)]
pub struct Primitive {
    /// Index into [`Scene::materials`].
    pub material: usize,
    /// Mesh space, finite.
    pub positions: Vec<Vec3>,
    /// Shading normals, unit: authored, or flat where the file has none.
    pub normals: Vec<Vec3>,
    /// Shading tangents (w = handedness): authored, or MikkTSpace where a material needs them; else empty.
    pub tangents: Vec<Vec4>,
    /// Whether they are the file's.
    pub own_tangents: bool,
    /// UV sets 0 and 1.
    pub uvs: [Vec<Vec2>; 2],
    /// Vertex indices, counter-clockwise fronts. No index is out of range.
    pub triangles: Vec<[u32; 3]>,
    /// Vertex → welded vertex of the mesh (bit-equal positions), index into [`Mesh::shell_normals`].
    pub weld: Vec<u32>,
    /// Displacement scale in mesh units after `relative` is resolved; 0 without displacement.
    pub displacement_scale: f64,
}

/// A node that draws a mesh.
#[derive(Clone, Debug)]
pub struct Instance {
    /// The node's name, or "node N".
    pub name: String,
    /// Index into [`Scene::meshes`].
    pub mesh: usize,
    /// Mesh to world, in f64.
    pub transform: DAffine3,
}

/// How a texture coordinate becomes a texel: wrap mode of one axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Wrap {
    /// glTF's default.
    #[default]
    Repeat,
    /// Mirrored repeat.
    Mirror,
    /// Clamp to edge.
    Clamp,
}

impl Wrap {
    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Wrap::Repeat => "repeat",
            Wrap::Mirror => "mirror",
            Wrap::Clamp => "clamp",
        }
    }

    /// The texel, of `count`, that stands for texel `index` of the endless row.
    pub fn index(self, index: i64, count: i64) -> i64 {
        match self {
            Wrap::Repeat => index.rem_euclid(count),
            Wrap::Clamp => index.clamp(0, count - 1),
            Wrap::Mirror => {
                let folded = index.rem_euclid(2 * count);
                folded.min(2 * count - 1 - folded)
            }
        }
    }
}

/// glTF sampler of a colour texture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Sampler {
    /// Wrap of u and v.
    pub wrap: [Wrap; 2],
    /// Nearest magnification asked for.
    pub nearest: bool,
    /// False where the file asks for a minification filter without mips.
    pub no_mips: bool,
}

/// One use of an image by a material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureRef {
    /// Index into [`Scene::images`].
    pub image: usize,
    /// Wrap and filter.
    pub sampler: Sampler,
    /// UV set, 0 or 1 (after `KHR_texture_transform`'s override).
    pub tex_coord: usize,
    /// `KHR_texture_transform`, identity without it: uv' = transform · uv.
    pub transform: DAffine2,
}

/// An 8-bit RGBA image.
#[derive(Clone, Debug)]
pub struct ColorImage {
    /// File name, for messages and debug names.
    pub name: String,
    /// Width in texels.
    pub width: u32,
    /// Height in texels.
    pub height: u32,
    /// RGBA, row 0 on top.
    pub rgba: Vec<u8>,
    /// Whether the texels are sRGB-encoded colour (base colour, emissive) or linear data.
    pub srgb: bool,
}

/// A material: glTF's metallic-roughness model and the displacement of its `extras`.
#[derive(Clone, Debug)]
pub struct Material {
    /// Its name in the file, or "material N".
    pub name: String,
    /// Linear RGBA factor.
    pub base_color_factor: Vec4,
    /// Base colour texture (sRGB).
    pub base_color: Option<TextureRef>,
    /// Metallic factor.
    pub metallic: f32,
    /// Roughness factor.
    pub roughness: f32,
    /// Roughness and metallic, each in a channel of its own.
    pub metallic_roughness: Option<TextureRef>,
    /// Channel of its roughness: glTF's is G.
    pub roughness_channel: Channel,
    /// Channel of its metallic: glTF's is B.
    pub metallic_channel: Channel,
    /// `KHR_materials_specular`: strength of what its dielectric part reflects, 1 without the extension.
    pub specular: f32,
    /// Strength in A.
    pub specular_map: Option<TextureRef>,
    /// Linear factor of the 4 % that its dielectric part reflects at normal incidence, white without the extension.
    pub specular_color_factor: Vec3,
    /// Texture of the same (sRGB).
    pub specular_color: Option<TextureRef>,
    /// Tangent-space normal map and its scale.
    pub normal: Option<(TextureRef, f32)>,
    /// Occlusion in R and its strength.
    pub occlusion: Option<(TextureRef, f32)>,
    /// Linear emissive factor, `KHR_materials_emissive_strength` not included.
    pub emissive_factor: Vec3,
    /// Emissive texture (sRGB).
    pub emissive: Option<TextureRef>,
    /// Cut-off of alphaMode MASK.
    pub alpha_cutoff: Option<f32>,
    /// Drawn and hit from both sides.
    pub double_sided: bool,
    /// Displacement, if the material asks for it.
    pub displacement: Option<Displacement>,
    /// Depth offset of a plain surface, if the material asks for it.
    pub depth_offset: Option<DepthOffset>,
}

impl Material {
    /// Its textures in the order of the renderer's slots.
    pub fn textures(&self) -> [Option<TextureRef>; 7] {
        [
            self.base_color,
            self.metallic_roughness,
            self.normal.map(|(texture, _)| texture),
            self.occlusion.map(|(texture, _)| texture),
            self.emissive,
            self.specular_map,
            self.specular_color,
        ]
    }
}

/// A channel of a colour image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Channel {
    /// Red.
    R,
    /// Green.
    G,
    /// Blue.
    B,
    /// Alpha.
    A,
}

impl Channel {
    /// Every channel.
    pub const ALL: &'static [Channel] = &[Channel::R, Channel::G, Channel::B, Channel::A];

    /// The name on the command line, which is GLSL's.
    pub fn name(self) -> &'static str {
        match self {
            Channel::R => "r",
            Channel::G => "g",
            Channel::B => "b",
            Channel::A => "a",
        }
    }
}

/// The `depthOffset` extras of a material that is not displaced: its depth moves away from the eye, its shading does not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DepthOffset {
    /// World units along the view ray, ≥ 0.
    pub distance: f64,
    /// Each pixel goes a random part of it, so that surfaces blend where they meet.
    pub dither: bool,
}

/// The `displacement` extras of a material (DESIGN section 2).
#[derive(Clone, Copy, Debug)]
pub struct Displacement {
    /// Where the heights come from.
    pub source: HeightSource,
    /// Wrap of u and v; repeats for a procedure, whose period is 1.
    pub wrap: [Wrap; 2],
    /// UV set, 0 or 1.
    pub tex_coord: usize,
    /// `KHR_texture_transform` of the height texture: uv' = transform · uv; the identity for a procedure.
    pub transform: DAffine2,
    /// As in the file, ≥ 0: mesh units, or a factor where `relative`.
    pub scale: f64,
    /// Scale is relative to sqrt(Σ mesh area / Σ UV area) of the primitive.
    pub relative: bool,
    /// The height that stays on the base surface.
    pub midlevel: f64,
    /// Open borders are closed by a wall.
    pub border_wall: bool,
}

/// What gives the height at a UV.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum HeightSource {
    /// A height map: index into [`Scene::height_maps`].
    Map(usize),
    /// A built-in function.
    Procedure(Procedure),
}

impl HeightSource {
    /// The map's index, if it is one.
    pub fn map(self) -> Option<usize> {
        match self {
            HeightSource::Map(map) => Some(map),
            HeightSource::Procedure(_) => None,
        }
    }

    /// The function, if it is one.
    pub fn procedure(self) -> Option<Procedure> {
        match self {
            HeightSource::Map(_) => None,
            HeightSource::Procedure(procedure) => Some(procedure),
        }
    }
}

/// A height map: red channel, linear, 8 or 16 bits as in its file.
#[derive(Clone, Debug)]
pub struct HeightMap {
    /// File name, for messages and debug names.
    pub name: String,
    /// Width in texels.
    pub width: u32,
    /// Height in texels.
    pub height: u32,
    /// Row 0 on top.
    pub texels: HeightTexels,
}

/// Texels at the depth of their file, unless told otherwise.
#[derive(Clone, Debug)]
pub enum HeightTexels {
    /// h = value / 255.
    U8(Vec<u8>),
    /// h = value / 65535.
    U16(Vec<u16>),
    /// h = value, in [0, 1]. No file has it: see [`HeightFormat`].
    F16(Vec<f16>),
}

/// A camera: looks along -Z of its transform, +Y up, as in glTF.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Camera to world, orthonormal basis (scale of the node removed).
    pub transform: DAffine3,
    /// Lens.
    pub projection: Projection,
}

/// A camera's lens. The picture's own aspect ratio is used, as glTF allows; the vertical extent stays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Perspective.
    Perspective {
        /// Vertical field of view, radians.
        fov_y: f64,
        /// Near plane distance.
        near: f64,
        /// Far plane distance; infinite if absent.
        far: Option<f64>,
    },
    /// Orthographic.
    Orthographic {
        /// Half the vertical extent, world units.
        y_mag: f64,
        /// Near plane distance.
        near: f64,
        /// Far plane distance.
        far: f64,
    },
}

/// A punctual light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Linear colour times intensity (lux for directional, candela else).
    pub intensity: DVec3,
    /// World position (point and spot).
    pub position: DVec3,
    /// World direction the light travels (directional and spot), unit.
    pub direction: DVec3,
    /// Distance at which it ends, if given (point and spot).
    pub range: Option<f64>,
    /// Kind.
    pub kind: LightKind,
}

/// The kinds of `KHR_lights_punctual`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightKind {
    /// Parallel light.
    Directional,
    /// Equal in all directions.
    Point,
    /// A cone.
    Spot {
        /// Full light within, radians from the axis.
        inner: f64,
        /// Dark beyond, radians from the axis.
        outer: f64,
    },
}
