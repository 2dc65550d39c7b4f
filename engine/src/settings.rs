//! The words that every room uses: what can be asked of a frame. Imports nothing of the engine.

use std::fmt;

/// Which shader stage generates the shell's geometry.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Stage {
    /// Mesh where the device has it, else geometry.
    #[default]
    Auto,
    /// `VK_EXT_mesh_shader`.
    Mesh,
    /// The classic geometry stage.
    Geometry,
}

/// How the displaced detail is bounded by geometry.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Shell {
    /// The best shell this build has: [`Shell::Walk`].
    #[default]
    Auto,
    /// The base surface only: classic parallax in its tangent plane.
    Off,
    /// Every displaced triangle becomes a prism; the fragment clips its ray to it.
    Prism,
    /// The outside of the shell is drawn; the fragment walks from prism to prism.
    Walk,
}

/// How a ray finds the height field.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum March {
    /// Neither displaced nor shaded by the height map.
    None,
    /// The base surface, shaded with the normal of the height map.
    Normal,
    /// The base surface, its textures shifted by its own height: parallax mapping with offset limiting (Kaneko et al.
    /// 2001, Welsh 2004).
    Offset,
    /// Linear search; its first sample below the field is the hit (McGuire and McGuire 2005).
    Steep,
    /// Linear search, then one linear interpolation of the last two samples (Tatarchuk 2006).
    Pom,
    /// Linear search, then bisection (Policarpo, Oliveira and Comba 2005).
    Relief,
    /// Linear search, then false position (Risser, Shah and Pattanaik 2006).
    Secant,
    /// Linear search, then a finer one between its last two samples (Riccardi's contact refinement).
    Contact,
    /// Steps through the cones of a cone map (Dummer 2006); the first hit, with steps enough.
    Cone,
    /// Steps through wider cones that a ray may enter the field in, then bisection (Policarpo and Oliveira 2007).
    RelaxedCone,
    /// The first hit to f32 rounding, through a min-max pyramid (DESIGN section 4).
    Exact,
}

impl March {
    /// Whether the march follows a ray at all; a shell needs one that does.
    pub fn traces(self) -> bool {
        !matches!(self, March::None | March::Normal | March::Offset)
    }

    /// Whether the textures are read elsewhere than at the base surface's own coordinates.
    pub fn moves(self) -> bool {
        self.traces() || self == March::Offset
    }

    /// Whether it begins with a linear search.
    pub fn steps(self) -> bool {
        self.traces() && self != March::Exact && !self.reads_cones()
    }

    /// Whether [`Settings::refine_steps`] means anything to it.
    pub fn refines(self) -> bool {
        matches!(self, March::Relief | March::Secant | March::Contact | March::RelaxedCone)
    }

    /// The refinements that it takes unless told otherwise.
    pub fn usual_refine_steps(self) -> u32 {
        if self == March::Secant { 5 } else { 8 }
    }

    /// Whether it can read its heights at an LOD of each pixel: pyramids and cones are of the map itself.
    pub fn reads_lods(self) -> bool {
        self.steps() || matches!(self, March::Normal | March::Offset)
    }

    /// Whether it needs a cone map, and hence heights that are one.
    pub fn reads_cones(self) -> bool {
        matches!(self, March::Cone | March::RelaxedCone)
    }
}

/// What removes fragments of a base surface whose ray has left it. A shell needs neither.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Silhouette {
    /// Nothing is removed.
    #[default]
    None,
    /// Fragments whose displaced UV lies outside the primitive's UV bounds.
    UvBounds,
    /// On closed curved surfaces: low fragments where the base surface turns edge-on.
    Horizon,
}

/// [`Silhouette::Horizon`]'s parameters. With n·v the cosine between base normal and view, a fragment of height h goes
/// where h - bias < clamp(strength · clamp(1 - |n·v| / safe_threshold)^falloff).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Horizon {
    /// 0 to 4.
    pub strength: f32,
    /// 0 to 1.
    pub bias: f32,
    /// Where |n·v| is more, nothing goes: 0 to 0.95.
    pub safe_threshold: f32,
    /// 0.5 to 8.
    pub falloff: f32,
}

impl Default for Horizon {
    fn default() -> Self {
        Horizon { strength: 1.0, bias: 0.0, safe_threshold: 0.5, falloff: 2.0 }
    }
}

/// How the shading normal of a base surface follows from the heights.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Normals {
    /// One gather: the true slope of the bilinear surface.
    #[default]
    Gather,
    /// Central differences of four heights.
    FourTap,
    /// The 3 × 3 Sobel operator, eight heights.
    Sobel,
}

/// What tells, on a base surface, how a step along it moves the height map's coordinates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Tangents {
    /// The file's tangents, where it has some that follow the height map; else derivatives.
    #[default]
    Auto,
    /// The mesh's: the file's, else MikkTSpace's. Smooth over a smooth mesh.
    Mesh,
    /// Derivatives over the screen, exact within each triangle under any coordinates.
    Derivatives,
}

/// Shadows that the height field casts on itself.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum SelfShadow {
    /// None.
    #[default]
    Off,
    /// A second march toward the light, lit or dark.
    Hard,
    /// The same toward a round light: how much of it the detail leaves.
    Soft,
}

/// Whether a frame's depth is drawn before its colours. Of surfaces that coincide the last one drawn then shows, else the
/// first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum DepthPrepass {
    /// Of plain surfaces, where there are several: their depth costs no fragment shader. A shell's is a trace as long as
    /// its shading's.
    #[default]
    Auto,
    /// Never: a fragment that something nearer covers later is shaded in vain.
    Off,
    /// Of all that is drawn: each pixel is shaded once, by the surface whose depth stayed.
    On,
}

/// Which prisms of shells are dropped before the stage that makes them. The picture is the same.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum PrismCulling {
    /// Where there are so many that it pays: see `render::plan`.
    #[default]
    Auto,
    /// None.
    Off,
    /// What lies outside the view, and lids that face away.
    View,
    /// Also what lies behind what is nearer, its own shell's horizon included: the prisms seen in the last frame are drawn
    /// first, then those of the others that their depth does not hide.
    Hidden,
}

/// Whether the walks of a shell begin at the lids that a visibility buffer names: each pixel's nearest one, drawn before.
/// Then all pixels of a quad trace, whatever the size of the triangles, and none that another lid covers. The picture is
/// the same to the bit. And whether the small triangles of a [`Baseline::MicroMesh`] are shaded so: each pixel's nearest one,
/// the picture the same but for rounding.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum VisibilityBuffer {
    /// Of shells with so many prisms, and meshes of so many triangles, that it pays: see `render::plan`.
    #[default]
    Auto,
    /// Never: each triangle's fragments trace or shade as they are rasterised.
    Off,
    /// Of all walked shells that a pixel sees one sample of, or of all micro-meshes.
    On,
}

/// What a picture shows of a frame. Colours of what is no shading are the picture's own values, 0 to 1: no light, no tone
/// mapping. Counts lie on a scale from black (0) over 1 to 256, whose lightness rises, an eighth of it each doubling.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum View {
    /// The shaded surface.
    #[default]
    Shaded,
    /// The base mesh, not displaced, and the edges of its triangles.
    Base,
    /// The shaded surface and the edges of its prisms, at the lowest and highest level of each, where nothing hides them.
    Wireframe,
    /// A colour for each prism; grey where there is none.
    Prisms,
    /// Prisms that the walk has visited, from where the ray comes in to its hit.
    Walk,
    /// Reads of heights, their bounds and cones, until the pixel's colour is known: shading's and shadow rays' too.
    Gathers,
    /// Red where a loop has given up at its limit.
    Limits,
    /// Red u, green v, each from 0 to 1; blue in every second tile of the plane.
    Uv,
    /// Grey, from black at 0 to white at 1.
    Height,
    /// The surface's own normal in the world, x, y and z each from -1 to 1.
    Normal,
    /// Grey, from white to black within each doubling of the view depth.
    Depth,
    /// White where the first light is seen.
    Shadow,
    /// The depth error against the reference. A renderer knows none, so it shades: whoever has both compares their AOVs.
    Error,
}

/// What is drawn in place of a displaced primitive's shell, for comparison.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Baseline {
    /// A pre-tessellated mesh.
    MicroMesh {
        /// Triangles along an edge of a base triangle.
        density: u32,
        /// What is left out.
        culling: Culling,
    },
    /// Base triangles that the GPU dices anew for each frame, as finely as they show.
    Diced {
        /// The stages that do it.
        by: Dicer,
        /// Length of an edge of the small triangles, pixels.
        edge: f32,
        /// Whether what lies outside the picture or faces away is left out.
        culls: bool,
    },
}

/// Which stages dice base triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Dicer {
    /// Hardware tessellation.
    Tessellation,
    /// Task and mesh stage.
    Mesh,
}

/// What of a micro-mesh is left out because the camera cannot see it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Culling {
    /// Nothing.
    Off,
    /// Clusters outside the picture or seen from behind, on the CPU.
    Clusters,
    /// Triangles outside the picture, seen from behind or between pixel centres, on the GPU.
    Triangles,
}

/// How closely the validation layer looks. Any message of it fails the run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Validation {
    /// The layer is not loaded.
    Off,
    /// Core checks.
    Core,
    /// Core and synchronization checks.
    Sync,
}

impl Default for Validation {
    fn default() -> Self {
        if cfg!(debug_assertions) { Validation::Core } else { Validation::Off }
    }
}

/// Everything that decides how a scene is drawn, after the command line's defaults are resolved.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Shell geometry's stage.
    pub stage: Stage,
    /// Shell or base surface.
    pub shell: Shell,
    /// The search along the ray.
    pub march: March,
    /// Fewest linear steps: of a ray that looks straight down (base surface), of a prism (shell).
    pub min_steps: u32,
    /// Most linear steps: of a ray at grazing angle (base surface), of a prism (shell). Of cone marches, all steps.
    pub max_steps: u32,
    /// Steps after the linear search: bisections of [`March::Relief`], most steps of [`March::Secant`], fine linear steps
    /// of [`March::Contact`]; bisections in the last cone of
    /// [`March::RelaxedCone`].
    pub refine_steps: u32,
    /// Distance of ray and field at which [`March::Secant`] is content, as a share of the height's range.
    pub tolerance: f32,
    /// Steps after which [`March::Exact`] gives up in one prism, per height map cell on its way (and 16 cells more).
    pub step_limit: u32,
    /// The linear search begins at a random part of its first step, blue noise from pixel to pixel.
    pub dither: bool,
    /// The farthest that a base surface's ray runs along the surface for each unit of depth, however flat the view.
    pub slope_limit: f32,
    /// Shading normals of base surfaces.
    pub normals: Normals,
    /// Tangent frames of base surfaces.
    pub tangents: Tangents,
    /// A base surface's heights are read at the LOD of each pixel's footprint, the same all along its ray.
    pub pixel_lod: bool,
    /// Clipping of base surfaces.
    pub silhouette: Silhouette,
    /// Its parameters.
    pub horizon: Horizon,
    /// Least UV of [`Silhouette::UvBounds`], in the height map; none: the primitive's own.
    pub uv_min: Option<[f32; 2]>,
    /// Greatest one.
    pub uv_max: Option<[f32; 2]>,
    /// Whether a base surface's hit moves the fragment's depth. A shell always writes the hit's depth.
    pub depth_offset: bool,
    /// The LOD from which on heights fade: one LOD further the surface is plain. Of a base surface that of its height field
    /// in a pixel; of a shell that of its thickness, 0 where it is as thick as a pixel is wide. Not with shadow maps, which
    /// see it from elsewhere, and never in surface data.
    pub lod_fade: Option<f32>,
    /// Self-shadowing.
    pub self_shadow: SelfShadow,
    /// Tangent of the angular radius of every light of [`SelfShadow::Soft`]; 0 is [`SelfShadow::Hard`].
    pub shadow_softness: f32,
    /// Most linear steps of a ray toward a light: along the whole ray (base surface), in a prism (shell). None: as the
    /// march's own.
    pub shadow_steps: Option<u32>,
    /// What the height field hides of the sky dims the ambient light.
    pub ambient_occlusion: bool,
    /// How much of its occlusion dims direct light too, 0 to 1.
    pub occlusion_light: f32,
    /// Lights cast shadows through depth maps of what they see.
    pub shadow_map: bool,
    /// Texels a side of each shadow map.
    pub shadow_map_size: u32,
    /// Shadow maps of a directional light: the nearer to the camera, the finer.
    pub cascades: u32,
    /// Depth before colours.
    pub depth_prepass: DepthPrepass,
    /// Prisms that are dropped unseen.
    pub prism_culling: PrismCulling,
    /// Walks that begin at the lids of a visibility buffer.
    pub visibility_buffer: VisibilityBuffer,
    /// Samples of a pixel: 1 or 4. Surface data keep one, at the pixel's centre.
    pub msaa: u32,
    /// What the picture shows. Surface data are always those of the surface.
    pub view: View,
    /// Count the loops that reach their limit; costs a storage buffer that fragments write.
    pub count_limits: bool,
    /// Count the reads of height maps, and of bounds and cones over them, that fragments make; costs the same.
    /// Where surface data are written beside several samples a pixel, it is their one sample that counts.
    pub count_reads: bool,
    /// Replaces the shell.
    pub baseline: Option<Baseline>,
    /// Neither instances nor lights move while these are in force: what only their motion could need is left out.
    pub still: bool,
    /// Keep what the plan would leave out though it could be there: for comparison, the picture is the same.
    pub keep_all: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Settings {
            stage: Stage::Auto,
            shell: Shell::Auto,
            march: March::Exact,
            min_steps: 8,
            max_steps: 64,
            refine_steps: 8,
            tolerance: 0.01,
            step_limit: 16,
            dither: false,
            slope_limit: 1000.0,
            normals: Normals::Gather,
            tangents: Tangents::Auto,
            pixel_lod: false,
            silhouette: Silhouette::None,
            horizon: Horizon::default(),
            uv_min: None,
            uv_max: None,
            depth_offset: true,
            lod_fade: None,
            self_shadow: SelfShadow::Off,
            shadow_softness: 0.05,
            shadow_steps: None,
            ambient_occlusion: false,
            occlusion_light: 0.0,
            shadow_map: false,
            shadow_map_size: 1024,
            cascades: 3,
            depth_prepass: DepthPrepass::Auto,
            prism_culling: PrismCulling::Auto,
            visibility_buffer: VisibilityBuffer::Auto,
            msaa: 1,
            view: View::Shaded,
            count_limits: false,
            count_reads: false,
            baseline: None,
            still: false,
            keep_all: false,
        }
    }
}

impl Settings {
    /// The shell that [`Shell::Auto`] stands for in this build.
    pub fn resolved_shell(&self) -> Shell {
        match self.shell {
            Shell::Auto => Shell::Walk,
            other => other,
        }
    }

    /// Whether fragments count something.
    pub fn counts(&self) -> bool {
        self.count_limits || self.count_reads
    }

    /// What is drawn under them: a base mesh is its triangles, without their heights.
    pub fn drawn(&self) -> Settings {
        match self.view {
            View::Base => Settings {
                shell: Shell::Off,
                march: March::None,
                silhouette: Silhouette::None,
                self_shadow: SelfShadow::Off,
                lod_fade: None,
                ambient_occlusion: false,
                pixel_lod: false,
                dither: false,
                tangents: Tangents::Auto,
                ..self.clone()
            },
            _ => self.clone(),
        }
    }

    /// Whether its view has something to show under the other settings.
    pub fn shows_view(&self) -> bool {
        let rays = matches!(self.view, View::Walk | View::Gathers | View::Limits);
        match self.view {
            View::Base | View::Wireframe | View::Prisms if self.baseline.is_some() => false,
            _ if rays && self.baseline.is_some() => false,
            View::Wireframe | View::Prisms => self.resolved_shell() != Shell::Off,
            View::Walk => self.resolved_shell() == Shell::Walk,
            View::Gathers => self.march != March::None,
            View::Limits => self.march.traces(),
            _ => true,
        }
    }

    /// The cosine between ray and base normal at which the ray runs as far as [`Settings::slope_limit`] lets it.
    pub fn least_cosine(&self) -> f32 {
        (1.0 + self.slope_limit * self.slope_limit).sqrt().recip()
    }
}

/// Names as the command line spells them.
macro_rules! names {
    ($type:ty { $($variant:ident = $name:literal),* $(,)? }) => {
        impl $type {
            /// Every value, in the command line's order.
            pub const ALL: &'static [$type] = &[$(<$type>::$variant),*];

            /// The name on the command line.
            pub fn name(self) -> &'static str {
                match self { $(<$type>::$variant => $name),* }
            }
        }

        impl fmt::Display for $type {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(self.name())
            }
        }
    };
}

names!(Stage { Auto = "auto", Mesh = "mesh", Geometry = "geometry" });
names!(Shell { Auto = "auto", Off = "off", Prism = "prism", Walk = "walk" });
names!(March {
    None = "none",
    Normal = "normal",
    Offset = "offset",
    Steep = "steep",
    Pom = "pom",
    Relief = "relief",
    Secant = "secant",
    Contact = "contact",
    Cone = "cone",
    RelaxedCone = "relaxed-cone",
    Exact = "exact",
});
names!(Silhouette { None = "none", UvBounds = "uv-bounds", Horizon = "horizon" });
names!(Normals { Gather = "gather", FourTap = "4-tap", Sobel = "sobel" });
names!(Tangents { Auto = "auto", Mesh = "mesh", Derivatives = "derivatives" });
names!(SelfShadow { Off = "off", Hard = "hard", Soft = "soft" });
names!(View {
    Shaded = "shaded",
    Base = "base",
    Wireframe = "wireframe",
    Prisms = "prisms",
    Walk = "walk",
    Gathers = "gathers",
    Limits = "limits",
    Uv = "uv",
    Height = "height",
    Normal = "normal",
    Depth = "depth",
    Shadow = "shadow",
    Error = "error",
});
names!(Dicer { Tessellation = "tessellation", Mesh = "mesh-tessellation" });
names!(DepthPrepass { Auto = "auto", Off = "off", On = "on" });
names!(PrismCulling { Auto = "auto", Off = "off", View = "view", Hidden = "hidden" });
names!(VisibilityBuffer { Auto = "auto", Off = "off", On = "on" });
names!(Validation { Off = "off", Core = "core", Sync = "sync" });
