//! Shader variants: which code a draw needs, as the defines it is compiled with. What no define asks for is not in the
//! machine code.

use super::baseline::Sides;
use super::layout::Light;
use crate::gpu::ShaderStage;
use crate::scene::{Channel, Procedure, Wrap};
use crate::settings::{Dicer, March, Normals, Stage, View};
use crate::shell::prisms::MAX_OTHERS;

/// What one draw is drawn by at most: its shading, its depth before it, its nearest lids, the list of its prisms.
pub const MOST_VARIANTS: usize = 4;

/// Lights that are one uniform buffer of the size that every device has room for, 16 KiB; more are a storage buffer.
pub const UNIFORM_LIGHTS: usize = 16384 / size_of::<Light>();

/// Texture slots of a material, in the order of [`crate::scene::Material::textures`].
pub const TEXTURE_DEFINES: [&str; 7] = [
    "BASE_COLOR_UV",
    "METALLIC_ROUGHNESS_UV",
    "NORMAL_UV",
    "OCCLUSION_UV",
    "EMISSIVE_UV",
    "SPECULAR_UV",
    "SPECULAR_COLOR_UV",
];

/// Slots that a material may fill with one texture, other channels of it: the second is then read with the first, and says
/// so to the shader.
pub const READ_TOGETHER: [(usize, usize, &str); 2] =
    [(1, 3, "OCCLUSION_WITH_METALLIC_ROUGHNESS"), (5, 6, "SPECULAR_COLOR_WITH_SPECULAR")];

/// The descriptor names of the same slots.
pub const TEXTURE_NAMES: [&str; 7] = [
    "base_color_map",
    "metallic_roughness_map",
    "normal_map",
    "occlusion_map",
    "emissive_map",
    "specular_map",
    "specular_color_map",
];

/// What the UV sets of a mesh are called.
pub const UV_SETS: [&str; 2] = ["first UV set", "second UV set"];

/// The descriptor names of the maps of other fields, in their order.
pub const OTHER_NAMES: [&str; MAX_OTHERS] =
    ["other_map_0", "other_map_1", "other_map_2", "other_map_3", "other_map_4", "other_map_5", "other_map_6"];

/// The defines that name the functions among them.
const OTHER_PROCEDURE_DEFINES: [&str; MAX_OTHERS] = [
    "OTHER_0_PROCEDURE",
    "OTHER_1_PROCEDURE",
    "OTHER_2_PROCEDURE",
    "OTHER_3_PROCEDURE",
    "OTHER_4_PROCEDURE",
    "OTHER_5_PROCEDURE",
    "OTHER_6_PROCEDURE",
];

/// What generates a draw's fragments.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Geometry {
    /// The base surface's own triangles.
    Surface,
    /// Prism outlines from the stage named ([`Stage::Auto`] never stands here).
    Shell(Stage),
    /// The walk's lids and bases.
    Lids(Stage),
    /// Outlines of the prisms that a walk may begin in otherwise than through a lid or base.
    Borders(Stage),
    /// The triangles of a [`crate::render::baseline::MicroMesh`].
    MicroMesh,
    /// Edges of base triangles, over them.
    BaseEdges,
    /// Edges of prisms.
    PrismEdges,
    /// Base triangles, diced on the GPU.
    Diced {
        /// The stages that do it.
        by: Dicer,
        /// They leave out what cannot be seen.
        culls: bool,
    },
}

impl Geometry {
    /// The stage that makes a shell; none for the base surface.
    pub fn stage(self) -> Option<Stage> {
        match self {
            Geometry::Surface | Geometry::MicroMesh | Geometry::Diced { .. } => None,
            Geometry::BaseEdges | Geometry::PrismEdges => None,
            Geometry::Shell(stage) | Geometry::Lids(stage) | Geometry::Borders(stage) => Some(stage),
        }
    }
}

/// What there is, or is read, of a primitive's vertices, besides UV sets and tangents.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Vertices {
    /// Nothing.
    #[default]
    None,
    /// All but the shell normals.
    Surface,
    /// All.
    Shell,
}

/// What a draw is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Pass {
    /// The picture.
    Shade,
    /// The picture's depth, before it is shaded.
    Depth,
    /// A light's depth map: what blocks it, from either side.
    Light,
    /// What lists the prisms that may show, before the others.
    Cull,
    /// The nearest lid, or small triangle, of each pixel: the visibility buffer.
    Visibility,
}

/// How unseen prisms are dropped before a draw, by a task stage or, for the geometry stage, by a pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Cull {
    /// Also what lies behind what is nearer.
    pub hidden: bool,
    /// Counts what is dropped.
    pub counted: bool,
}

/// The height field's part in a variant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Height {
    /// The function that gives the heights; none where a map does.
    pub procedure: Option<Procedure>,
    /// Wrap of u and v.
    pub wrap: [Wrap; 2],
    /// Height fields of neighbours that the walls of its prisms meet, besides its own.
    pub others: u8,
    /// Functions that give the heights of these, in their order; none where a map does.
    pub other_procedures: [Option<Procedure>; MAX_OTHERS],
    /// Steps at walls: the heights across some differ.
    pub steps: bool,
    /// Triangles of it may be plain.
    pub plain: bool,
    /// Triangles of it have one height, which one step finds.
    pub one_heights: bool,
    /// The search.
    pub march: March,
    /// Discard outside the primitive's UV bounds.
    pub uv_bounds: bool,
    /// Discard low fragments where the base surface turns edge-on.
    pub horizon: bool,
    /// Dithered start of the linear search.
    pub dither: bool,
    /// Shading normals of a base surface.
    pub normals: Normals,
    /// A base surface's tangent frame is the mesh's, not that of derivatives.
    pub mesh_tangents: bool,
    /// A base surface's heights are read at the LOD of the pixel.
    pub pixel_lod: bool,
    /// The hit moves the depth of a base surface.
    pub depth_offset: bool,
    /// A base surface's heights fade with the LOD.
    pub lod_fade: bool,
    /// Rays toward the lights.
    pub self_shadow: bool,
    /// They tell how much of a round light is seen.
    pub soft_shadow: bool,
    /// They have steps of their own.
    pub shadow_steps: bool,
    /// They go on in a hierarchy of boxes once they leave the shell.
    pub reenters: bool,
    /// Ambient light dimmed by what the field hides of the sky.
    pub ambient_occlusion: bool,
    /// Counts loops that reach their limit.
    pub count_limits: bool,
    /// Counts reads of height maps.
    pub count_reads: bool,
}

/// Everything that decides a draw's shader code and pipeline state.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Variant {
    /// Pass.
    pub pass: Pass,
    /// Geometry.
    pub geometry: Geometry,
    /// Its depth stands already: shades where that is its own.
    pub depth_stands: bool,
    /// UV set of each texture that the material has.
    pub textures: [Option<u8>; 7],
    /// Which pairs of [`READ_TOGETHER`] are; the second has no place in `textures` then.
    pub read_together: [bool; 2],
    /// What is no metal reflects otherwise than by 4 %.
    pub specular: bool,
    /// Channels of roughness and metallic in their texture.
    pub channels: [Channel; 2],
    /// Its occlusion dims direct light too.
    pub occludes_light: bool,
    /// Height field, if the draw reads one.
    pub height: Option<Height>,
    /// Moves the depth of a plain surface, dithered or not.
    pub depth_shift: Option<bool>,
    /// Where it writes depth, that is never nearer than the raster's: the rasteriser is promised so.
    pub depth_behind: bool,
    /// alphaMode MASK.
    pub alpha_mask: bool,
    /// Culls nothing.
    pub double_sided: bool,
    /// The transform turns winding around.
    pub mirrored: bool,
    /// Lights of the scene.
    pub lights: u32,
    /// Lights whose shadows it computes, the scene's first ones.
    pub shadowed_lights: u8,
    /// Reads their shadow maps.
    pub shadow_maps: bool,
    /// Writes the AOVs beside the colour.
    pub aov: bool,
    /// UV set of the AOV.
    pub aov_uv: u8,
    /// The UV set that is the height map's coordinates, which each vertex has anyway.
    pub height_uvs: Option<u8>,
    /// Its vertices' normals are their shell directions.
    pub normals_along_shell: bool,
    /// Samples of a pixel.
    pub samples: u8,
    /// Its fragments are traced and shaded sample by sample.
    pub per_sample: bool,
    /// Its stage skips the prisms that are plain in the mesh's pose.
    pub deforms: bool,
    /// Its primitive's vertices are without shell normals ([`super::layout::SurfaceVertex`]).
    pub surface_vertices: bool,
    /// Unseen prisms are dropped.
    pub cull: Option<Cull>,
    /// Its walks begin at the lids that the visibility buffer names, or it shades the small triangles named there.
    pub visibility: bool,
    /// What it writes in place of the shaded colour, if anything.
    pub view: View,
}

impl Variant {
    /// The shader paths below `shaders/`, in stage order.
    pub fn shaders(&self) -> &'static [(&'static str, ShaderStage)] {
        use ShaderStage as S;
        match self.geometry {
            _ if self.pass == Pass::Cull => &[("render/cull.comp", S::Compute)],
            Geometry::Lids(Stage::Mesh) if self.pass == Pass::Visibility && self.cull.is_some() => {
                &[("render/lids.task", S::Task), ("render/lids.mesh", S::Mesh), ("render/visibility.frag", S::Fragment)]
            }
            Geometry::Lids(Stage::Mesh) if self.pass == Pass::Visibility => {
                &[("render/lids.mesh", S::Mesh), ("render/visibility.frag", S::Fragment)]
            }
            Geometry::Lids(_) if self.pass == Pass::Visibility => &[
                ("render/lids.vert", S::Vertex),
                ("render/lids.geom", S::Geometry),
                ("render/visibility.frag", S::Fragment),
            ],
            // The rasteriser's own depth is enough.
            Geometry::Surface
                if self.pass != Pass::Shade
                    && !self.alpha_mask
                    && self.height.is_none()
                    && self.depth_shift.is_none() =>
            {
                &[("render/surface.vert", S::Vertex)]
            }
            Geometry::Surface => &[("render/surface.vert", S::Vertex), ("render/surface.frag", S::Fragment)],
            Geometry::BaseEdges | Geometry::PrismEdges => {
                &[("render/edges.vert", S::Vertex), ("render/edges.frag", S::Fragment)]
            }
            Geometry::MicroMesh if self.pass == Pass::Visibility => {
                &[("baseline/nearest_triangle.vert", S::Vertex), ("baseline/nearest_triangle.frag", S::Fragment)]
            }
            Geometry::MicroMesh if self.names_triangles() => {
                &[("render/resolve.vert", S::Vertex), ("render/surface.frag", S::Fragment)]
            }
            Geometry::MicroMesh => &[("baseline/micro_mesh.vert", S::Vertex), ("render/surface.frag", S::Fragment)],
            Geometry::Diced { by: Dicer::Tessellation, .. } => &[
                ("render/shell.vert", S::Vertex),
                ("baseline/dice.tesc", S::TessControl),
                ("baseline/dice.tese", S::TessEvaluation),
                ("render/surface.frag", S::Fragment),
            ],
            Geometry::Diced { by: Dicer::Mesh, .. } => &[
                ("baseline/dice.task", S::Task),
                ("baseline/dice.mesh", S::Mesh),
                ("render/surface.frag", S::Fragment),
            ],
            Geometry::Shell(Stage::Mesh) if self.cull.is_some() => {
                &[("render/shell.task", S::Task), ("render/shell.mesh", S::Mesh), ("render/shell.frag", S::Fragment)]
            }
            Geometry::Borders(Stage::Mesh) if self.cull.is_some() => {
                &[("render/shell.task", S::Task), ("render/shell.mesh", S::Mesh), ("render/walk.frag", S::Fragment)]
            }
            Geometry::Lids(Stage::Mesh) if self.cull.is_some() => {
                &[("render/lids.task", S::Task), ("render/lids.mesh", S::Mesh), ("render/walk.frag", S::Fragment)]
            }
            Geometry::Shell(Stage::Mesh) => &[("render/shell.mesh", S::Mesh), ("render/shell.frag", S::Fragment)],
            Geometry::Borders(Stage::Mesh) => &[("render/shell.mesh", S::Mesh), ("render/walk.frag", S::Fragment)],
            Geometry::Lids(Stage::Mesh) => &[("render/lids.mesh", S::Mesh), ("render/walk.frag", S::Fragment)],
            Geometry::Lids(_) => {
                &[("render/lids.vert", S::Vertex), ("render/lids.geom", S::Geometry), ("render/walk.frag", S::Fragment)]
            }
            Geometry::Borders(_) => &[
                ("render/shell.vert", S::Vertex),
                ("render/shell.geom", S::Geometry),
                ("render/walk.frag", S::Fragment),
            ],
            Geometry::Shell(_) => &[
                ("render/shell.vert", S::Vertex),
                ("render/shell.geom", S::Geometry),
                ("render/shell.frag", S::Fragment),
            ],
        }
    }

    /// The same draw as a light sees it.
    pub fn for_light(self) -> Variant {
        let depth = self.for_depth();
        Variant {
            pass: Pass::Light,
            samples: 1,
            per_sample: false,
            depth_shift: None,
            // Light also sees the backs of base surfaces, whose heights then stand before them.
            depth_behind: self.depth_behind && self.geometry != Geometry::Surface,
            // A lid seen from behind is where rays leave.
            double_sided: self.geometry == Geometry::Surface,
            // Each light would have a view of its own to drop them by, and to name them in.
            cull: None,
            // A base surface stands where its depth says.
            height: depth.height.filter(|h| self.geometry != Geometry::Surface || h.depth_offset),
            ..depth
        }
    }

    /// What draws its depth alone, before it is shaded.
    pub fn for_depth(self) -> Variant {
        let [base_color, ..] = self.textures;
        // A base surface that no ray moves is its triangles, wherever nothing is cut out of it.
        let flat = self.geometry == Geometry::Surface && !self.alpha_mask;
        let idle = |h: &Height| flat && !(h.depth_offset || h.uv_bounds || h.horizon);
        Variant {
            pass: Pass::Depth,
            depth_stands: false,
            visibility: false,
            textures: [base_color.filter(|_| self.alpha_mask), None, None, None, None, None, None],
            read_together: [false; 2],
            specular: false,
            channels: [Channel::G, Channel::B],
            occludes_light: false,
            height: self.height.filter(|h| !idle(h)).map(|h| Height {
                self_shadow: false,
                soft_shadow: false,
                shadow_steps: false,
                reenters: false,
                ambient_occlusion: false,
                ..h
            }),
            lights: 0,
            shadowed_lights: 0,
            shadow_maps: false,
            aov: false,
            aov_uv: 0,
            height_uvs: self.height_uvs.filter(|_| self.alpha_mask),
            normals_along_shell: false,
            view: View::Shaded,
            ..self
        }
    }

    /// What names the nearest lid of each pixel before it.
    pub fn for_visibility(self) -> Variant {
        let depth = self.for_depth();
        let height = depth.height.map(|height| Height { march: March::None, dither: false, others: 0, ..height });
        Variant { pass: Pass::Visibility, height, depth_behind: false, ..depth }
    }

    /// What lists the prisms that it is to draw, where it does not do so itself.
    pub fn for_culling(self) -> Option<Variant> {
        let listed = self.cull.is_some() && self.geometry.stage() == Some(Stage::Geometry);
        listed.then(|| Variant { pass: Pass::Cull, ..self.for_depth() })
    }

    /// Lines of its primitive, over the picture.
    pub fn for_edges(self, geometry: Geometry) -> Variant {
        Variant {
            pass: Pass::Shade,
            geometry,
            height: None,
            depth_shift: None,
            depth_behind: false,
            double_sided: true,
            mirrored: false,
            per_sample: false,
            deforms: false,
            cull: None,
            visibility: false,
            ..Variant { alpha_mask: false, ..self }.for_depth()
        }
    }

    /// Whether it shades the small triangles that the visibility buffer names, with one over the picture.
    pub fn names_triangles(&self) -> bool {
        self.geometry == Geometry::MicroMesh && self.visibility
    }

    /// Which sides of its triangles show.
    pub fn sides(&self) -> Sides {
        Sides { double: self.double_sided, mirrored: self.mirrored }
    }

    /// Whether the fragment itself says what it covers, or how deep: the raster's coverage of the samples says neither.
    pub fn decides_coverage(&self) -> bool {
        self.writes_depth() || self.discards()
    }

    /// Whether its fragments write their depth.
    pub fn writes_depth(&self) -> bool {
        self.pass != Pass::Visibility
            && (self.geometry.stage().is_some()
                || self.depth_shift.is_some()
                || self.height.is_some_and(|h| h.depth_offset))
    }

    /// Whether some of its fragments end without a trace.
    pub fn discards(&self) -> bool {
        let by_height = |h: Height| h.depth_offset || h.uv_bounds || h.horizon;
        self.pass != Pass::Visibility
            && (self.geometry.stage().is_some()
                || self.alpha_mask
                || self.names_triangles()
                || self.height.is_some_and(by_height))
    }

    /// Whether it shows coordinates, those of [`Variant::aov_uv`].
    pub fn shows_uvs(&self) -> bool {
        self.aov || self.view == View::Uv
    }

    /// Whether its textures, or what it shows of them, are on a UV set.
    pub fn reads_uvs(&self, set: u8) -> bool {
        self.textures.contains(&Some(set)) || (self.shows_uvs() && self.aov_uv == set)
    }

    /// What it reads of its primitive's vertices themselves.
    pub fn reads_vertices(&self) -> Vertices {
        match self.geometry {
            // It has vertices of its own.
            Geometry::MicroMesh => Vertices::None,
            // A tangent frame's shear lies where the others have none.
            Geometry::Surface if !self.height.is_some_and(|height| height.mesh_tangents) => Vertices::Surface,
            Geometry::BaseEdges => Vertices::Surface,
            _ => Vertices::Shell,
        }
    }

    /// Whether it reads them as the vertices' own.
    pub fn reads_uv_stream(&self, set: u8) -> bool {
        self.reads_uvs(set) && self.height_uvs != Some(set)
    }

    /// Whether it reads tangents.
    pub fn reads_tangents(&self) -> bool {
        let [_, _, normal, ..] = self.textures;
        normal.is_some() || self.height.is_some_and(|height| height.mesh_tangents)
    }

    /// Whether it reads blue noise.
    pub fn dithers(&self) -> bool {
        self.depth_shift == Some(true) || self.height.is_some_and(|height| height.dither)
    }

    /// The pipeline's debug name.
    pub fn name(&self) -> String {
        let name = match (self.geometry, self.height) {
            (Geometry::Surface, None) => "surface".into(),
            (Geometry::Surface, Some(height)) => format!("surface {}", height.march),
            (Geometry::BaseEdges, _) => "edges of base triangles".into(),
            (Geometry::PrismEdges, _) => "edges of prisms".into(),
            (Geometry::MicroMesh, _) => "micro-mesh".into(),
            (Geometry::Diced { by, .. }, _) => by.to_string(),
            (geometry, height) => {
                let part = match geometry {
                    Geometry::Lids(_) => "walk lids ",
                    Geometry::Borders(_) => "walk borders ",
                    _ => "",
                };
                format!("shell {part}{}", height.map_or_else(|| "plain".into(), |height| height.march.to_string()))
            }
        };
        let name = match self.view {
            View::Shaded => name,
            view => format!("{name}, view {view}"),
        };
        match self.pass {
            Pass::Shade if self.samples > 1 => format!("{name}, {} samples", self.samples),
            Pass::Shade => name,
            Pass::Depth => format!("depth: {name}"),
            Pass::Light => format!("shadow map: {name}"),
            Pass::Cull => format!("culling: {name}"),
            Pass::Visibility => format!("visibility: {name}"),
        }
    }

    /// The defines of its shaders.
    pub fn defines(&self) -> Vec<(&'static str, String)> {
        let mut defines = vec![("AOV_UV", self.aov_uv.to_string())];
        if self.lights > 0 {
            defines.push(("LIGHTS", self.lights.to_string()));
        }
        if self.shadowed_lights > 0 {
            defines.push(("SHADOWED_LIGHTS", self.shadowed_lights.to_string()));
        }
        let mut flag = |name, on: bool| {
            if on {
                defines.push((name, String::new()));
            }
        };
        flag("MESH_STAGE", self.geometry.stage() == Some(Stage::Mesh));
        flag("WALK_LIDS", matches!(self.geometry, Geometry::Lids(_)));
        flag("WALK_BORDERS", matches!(self.geometry, Geometry::Borders(_)));
        let diced = matches!(self.geometry, Geometry::Diced { .. });
        flag("CULLS", matches!(self.geometry, Geometry::Diced { culls: true, .. }));
        flag("CULLED", self.cull.is_some());
        flag("CULL_HIDDEN", self.cull.is_some_and(|cull| cull.hidden));
        flag("COUNT_CULLED", self.cull.is_some_and(|cull| cull.counted));
        flag("DEFORMS", self.deforms);
        flag("STORED_LIGHTS", self.lights as usize > UNIFORM_LIGHTS);
        flag("SURFACE_VERTICES", self.surface_vertices);
        flag("DEPTH_ONLY", self.pass != Pass::Shade);
        flag("VISIBILITY", self.visibility);
        flag("BLOCKS_LIGHT", self.pass == Pass::Light);
        flag("SHADOW_MAPS", self.shadow_maps);
        flag("ALPHA_MASK", self.alpha_mask);
        flag("SPECULAR", self.specular);
        flag("AOV", self.aov);
        flag("OCCLUSION_LIGHT", self.occludes_light);
        flag("PRISM_EDGES", self.geometry == Geometry::PrismEdges);
        flag("VIEW", self.view != View::Shaded);
        flag("VIEW_PRISMS", self.view == View::Prisms);
        flag("VIEW_WALK", self.view == View::Walk);
        flag("VIEW_GATHERS", self.view == View::Gathers);
        flag("VIEW_LIMITS", self.view == View::Limits);
        flag("VIEW_UV", self.view == View::Uv);
        flag("VIEW_HEIGHT", self.view == View::Height);
        flag("VIEW_NORMAL", self.view == View::Normal);
        flag("VIEW_DEPTH", self.view == View::Depth);
        flag("VIEW_SHADOW", self.view == View::Shadow);
        flag("SAMPLE_SHADING", self.per_sample);
        let uvs = [0, 1].map(|set| self.reads_uvs(set));
        flag("VERTEX_UVS", uvs.contains(&true));
        flag("VERTEX_UVS_0", self.reads_uv_stream(0));
        flag("VERTEX_UVS_1", self.reads_uv_stream(1));
        flag("HEIGHT_UVS_0", uvs[0] && self.height_uvs == Some(0));
        flag("HEIGHT_UVS_1", uvs[1] && self.height_uvs == Some(1));
        flag("NORMALS_ALONG_SHELL", self.normals_along_shell);
        flag("VERTEX_TANGENTS", self.reads_tangents());
        flag("DITHER", self.dithers());
        flag("DEPTH_SHIFT", self.depth_shift.is_some());
        flag("DEPTH_BEHIND", self.depth_behind && self.writes_depth());
        if let Some(height) = self.height.filter(|_| !diced) {
            flag("HAS_HEIGHT", true);
            flag("NO_STEPS", self.geometry.stage().is_some() && !height.steps);
            flag("NO_PLAIN", self.geometry.stage().is_some() && !height.plain);
            flag("ONE_HEIGHTS", height.one_heights);
            flag("MARCH_TRACES", height.march.traces());
            flag("MARCH_MOVES", height.march.moves());
            flag("MARCH_OFFSET", height.march == March::Offset);
            flag("MARCH_STEEP", height.march == March::Steep);
            flag("MARCH_RELIEF", height.march == March::Relief);
            flag("MARCH_SECANT", height.march == March::Secant);
            flag("MARCH_CONTACT", height.march == March::Contact);
            flag("MARCH_CONE", height.march.reads_cones());
            flag("CONE_RELAXED", height.march == March::RelaxedCone);
            flag("MARCH_EXACT", height.march == March::Exact);
            flag("MARCH_NONE", height.march == March::None);
            flag("UV_BOUNDS", height.uv_bounds);
            flag("HORIZON", height.horizon);
            flag("DITHERED_START", height.dither);
            flag("NORMALS_4_TAP", height.normals == Normals::FourTap);
            flag("NORMALS_SOBEL", height.normals == Normals::Sobel);
            flag("MESH_TANGENTS", height.mesh_tangents);
            flag("HEIGHT_MIPS", height.pixel_lod);
            flag("DEPTH_OFFSET", height.depth_offset);
            flag("LOD_FADE", height.lod_fade);
            flag("SELF_SHADOW", height.self_shadow);
            flag("SOFT_SHADOW", height.soft_shadow);
            flag("SHADOW_STEPS", height.shadow_steps);
            flag("AMBIENT_OCCLUSION", height.ambient_occlusion);
            flag("SHADOW_REENTRY", height.reenters);
            flag("COUNT_LIMITS", height.count_limits);
            flag("COUNT_READS", height.count_reads);
            if height.others > 0 {
                defines.push(("OTHER_FIELDS", height.others.to_string()));
            }
            for (name, procedure) in OTHER_PROCEDURE_DEFINES.into_iter().zip(height.other_procedures) {
                defines.extend(procedure.map(|procedure| (name, procedure_constant(procedure))));
            }
        }
        if let Some(height) = self.height {
            match height.procedure {
                Some(procedure) => defines.push(procedure_define(procedure)),
                None => defines.extend(wrap_defines(height.wrap)),
            }
        }
        if self.textures[1].is_some() {
            let [roughness, metallic] = self.channels.map(|channel| channel.name().to_owned());
            defines.extend([("ROUGHNESS_CHANNEL", roughness), ("METALLIC_CHANNEL", metallic)]);
        }
        for (name, set) in TEXTURE_DEFINES.iter().zip(self.textures) {
            if let Some(set) = set {
                defines.push((name, set.to_string()));
            }
        }
        for ((_, _, name), together) in READ_TOGETHER.iter().zip(self.read_together) {
            if together {
                defines.push((name, String::new()));
            }
        }
        defines
    }
}

/// Which function gives the heights, as `shaders/shell/procedures.glsl` wants to know it.
pub fn procedure_define(procedure: Procedure) -> (&'static str, String) {
    ("HEIGHT_PROCEDURE", procedure_constant(procedure))
}

/// A procedure's name in `shaders/shell/procedures.glsl`.
fn procedure_constant(procedure: Procedure) -> String {
    format!("PROCEDURE_{}", procedure.name().to_uppercase())
}

/// How the height map wraps, as the shaders' `HEIGHT_WRAP_U` and `HEIGHT_WRAP_V` say it.
pub fn wrap_defines(wrap: [Wrap; 2]) -> [(&'static str, String); 2] {
    let mode = |wrap| match wrap {
        Wrap::Repeat => "0",
        Wrap::Mirror => "1",
        Wrap::Clamp => "2",
    };
    [("HEIGHT_WRAP_U", mode(wrap[0]).into()), ("HEIGHT_WRAP_V", mode(wrap[1]).into())]
}
