//! Shader variants: which code a draw needs, as the defines it is compiled with. What no define asks for is not in the
//! machine code.

use crate::gpu::ShaderStage;
use crate::scene::{Procedure, Wrap};
use crate::settings::{March, Stage};

/// Texture slots of a material, in the order of their bindings (4 to 8 of set 1).
pub const TEXTURE_DEFINES: [&str; 5] =
    ["BASE_COLOR_UV", "METALLIC_ROUGHNESS_UV", "NORMAL_UV", "OCCLUSION_UV", "EMISSIVE_UV"];

/// The descriptor names of the same slots.
pub const TEXTURE_NAMES: [&str; 5] =
    ["base_color_map", "metallic_roughness_map", "normal_map", "occlusion_map", "emissive_map"];

/// What generates a draw's fragments.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Geometry {
    /// The base surface's own triangles.
    Surface,
    /// Prism outlines from the stage named ([`Stage::Auto`] never stands here).
    Shell(Stage),
}

/// The height field's part in a variant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Height {
    /// The function that gives the heights; none where a map does.
    pub procedure: Option<Procedure>,
    /// Wrap of u and v.
    pub wrap: [Wrap; 2],
    /// The search.
    pub march: March,
    /// Discard outside the primitive's UV bounds.
    pub uv_bounds: bool,
    /// The hit moves the depth of a base surface.
    pub depth_offset: bool,
    /// Second march toward the first light.
    pub self_shadow: bool,
    /// Counts loops that reach their limit.
    pub count_limits: bool,
}

/// Everything that decides a draw's shader code and pipeline state.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Variant {
    /// Geometry.
    pub geometry: Geometry,
    /// UV set of each texture that the material has.
    pub textures: [Option<u8>; 5],
    /// Height field, if the draw reads one.
    pub height: Option<Height>,
    /// alphaMode MASK.
    pub alpha_mask: bool,
    /// Culls nothing.
    pub double_sided: bool,
    /// The transform turns winding around.
    pub mirrored: bool,
    /// The scene has lights.
    pub lights: bool,
    /// Writes the AOVs beside the colour.
    pub aov: bool,
    /// UV set of the AOV.
    pub aov_uv: u8,
}

impl Variant {
    /// The shader paths below `shaders/`, in stage order.
    pub fn shaders(&self) -> &'static [(&'static str, ShaderStage)] {
        use ShaderStage as S;
        match self.geometry {
            Geometry::Surface => &[("render/surface.vert", S::Vertex), ("render/surface.frag", S::Fragment)],
            Geometry::Shell(Stage::Mesh) => &[("render/shell.mesh", S::Mesh), ("render/shell.frag", S::Fragment)],
            Geometry::Shell(_) => &[
                ("render/shell.vert", S::Vertex),
                ("render/shell.geom", S::Geometry),
                ("render/shell.frag", S::Fragment),
            ],
        }
    }

    /// The pipeline's debug name.
    pub fn name(&self) -> String {
        match (self.geometry, self.height) {
            (Geometry::Surface, None) => "surface".into(),
            (Geometry::Surface, Some(height)) => format!("surface {}", height.march),
            (Geometry::Shell(_), height) => {
                format!("shell {}", height.map_or(March::None, |height| height.march))
            }
        }
    }

    /// The defines of its shaders.
    pub fn defines(&self) -> Vec<(&'static str, String)> {
        let mut defines = vec![("AOV_UV", self.aov_uv.to_string())];
        let mut flag = |name, on: bool| {
            if on {
                defines.push((name, String::new()));
            }
        };
        flag("MESH_STAGE", self.geometry == Geometry::Shell(Stage::Mesh));
        flag("HAS_LIGHTS", self.lights);
        flag("ALPHA_MASK", self.alpha_mask);
        flag("AOV", self.aov);
        if let Some(height) = self.height {
            flag("HAS_HEIGHT", true);
            flag("MARCH_TRACES", height.march.traces());
            flag("MARCH_RELIEF", height.march == March::Relief);
            flag("MARCH_EXACT", height.march == March::Exact);
            flag("UV_BOUNDS", height.uv_bounds);
            flag("DEPTH_OFFSET", height.depth_offset);
            flag("SELF_SHADOW", height.self_shadow);
            flag("COUNT_LIMITS", height.count_limits);
            match height.procedure {
                Some(procedure) => defines.push(procedure_define(procedure)),
                None => defines.extend(wrap_defines(height.wrap)),
            }
        }
        for (name, set) in TEXTURE_DEFINES.iter().zip(self.textures) {
            if let Some(set) = set {
                defines.push((name, set.to_string()));
            }
        }
        defines
    }
}

/// Which function gives the heights, as `shaders/shell/procedures.glsl` wants to know it.
pub fn procedure_define(procedure: Procedure) -> (&'static str, String) {
    ("HEIGHT_PROCEDURE", format!("PROCEDURE_{}", procedure.name().to_uppercase()))
}

/// How the height map wraps, as `shaders/shell/height.glsl` wants to know it.
pub fn wrap_defines(wrap: [Wrap; 2]) -> [(&'static str, String); 2] {
    let mode = |wrap| match wrap {
        Wrap::Repeat => "0",
        Wrap::Mirror => "1",
        Wrap::Clamp => "2",
    };
    [("HEIGHT_WRAP_U", mode(wrap[0]).into()), ("HEIGHT_WRAP_V", mode(wrap[1]).into())]
}
