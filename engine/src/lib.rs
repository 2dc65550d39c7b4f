//! Prism Shell's engine: displaced detail on coarse meshes by rays traced inside prism shells.
//!
//! # One frame
//!
//! What happens between a file and a pixel, in order, with the place that does it.
//!
//! ## Once, when a scene is loaded
//!
//! 1. [`scene::load`] reads a glTF file into a [`scene::Scene`]: meshes whose vertices at one place share a shell normal,
//!    materials with their [`scene::Displacement`], height maps of 8 or 16 bits, a camera, lights. Nothing of it knows
//!    Vulkan.
//! 2. [`gpu::Context`] opens a device with the features that [`render::features`] names for this scene and these
//!    [`settings::Settings`], and no others.
//!
//! ## Once for each choice of settings
//!
//! [`render::Renderer::new`], and [`render::Renderer::set_settings`] later:
//!
//! 3. [`render::plan::plan`] decides, without any device, what there will be: for each mesh the certificate that no prism
//!    folds ([`shell::certificate`]), its prisms ([`shell::prisms`]), and for a walk their adjacency and lids
//!    ([`shell::walk`]); for each primitive of each instance one or two draws. A draw's [`render::variant::Variant`] holds
//!    all that its shaders depend on.
//! 4. Images and buffers that some draw reads are made and uploaded; the min-max pyramid of a height map, or its cones, by
//!    compute.
//! 5. Each variant becomes a pipeline: its defines cut the GLSL below `shaders/`, so that what a draw does not need is not
//!    in its SPIR-V. The structs of [`render::layout`] stand once, in Rust, and are included into the GLSL.
//!
//! ## Each frame
//!
//! The caller begins a command buffer ([`gpu::Frames`], or its own) and hands it to [`render::Renderer::record`]:
//!
//! 6. Meshes that change shape: compute passes find normals, shell normals, folds and boxes anew ([`render::deform`]).
//! 7. [`render::view::View`] makes the transforms in f64, relative to the camera and to the middle of each mesh; f32 sees
//!    only these products, as the rows of [`render::layout::Object`].
//! 8. Shadow maps, where the plan has some: the same draws through the same tracer, with the lights' rays, depth only.
//! 9. Depth first, where the plan says so; then `surface`, the triangles that are no shell's, whose depth spares the
//!    shells' fragments behind them; then `shell`; and the lines of a view, if it has any. Of several samples a pixel the
//!    picture is resolved last. Where triangles are small, `visibility` before `shell` names each pixel's nearest lid
//!    (`render/nearest_lid.glsl`), `shell` is one triangle over the picture that walks from those, and `shell rest` draws
//!    what is left by its lids. A micro-mesh in a shell's place has its triangles named by `visibility`, and shaded in the
//!    pass `micro-mesh` (`baseline/nearest_triangle.glsl`).
//!
//! ## Each shell, on the GPU
//!
//! 10. `lids.mesh`, or `lids.vert` and `lids.geom`, emit the outside of the shell: lids, and bases where they can be seen.
//!     `shell.mesh`, or `shell.vert` and `shell.geom`, emit the screen outline of single prisms: with `--shell prism` of
//!     all of them, in a walk of those that a ray may enter otherwise than through a lid.
//!
//! ## Each fragment of it
//!
//! 11. `walk.frag` takes the pixel's ray as two dimensions: a prism's corners become points p + t q of the plane across
//!     it, its walls quadratics in the level t (`shell/prism.glsl`).
//! 12. It starts where the ray was last outside (`walk_start`), and goes from prism to prism through the wall that each
//!     leaves by (`walk`, `shell/walk.glsl`). In `shell.frag` there is one prism (`prism_trace`, `shell/march.glsl`).
//! 13. In each prism the march looks for the height field along the curved path uv(t): `crosses` whether and between which
//!     points, `crossing` where. The exact march clears boxes of the path by the pyramid, then cells by Bernstein
//!     coefficients (`shell/exact.glsl`); the others step (`shell/refine.glsl`) or follow cones (`shell/cone.glsl`).
//! 14. The hit's barycentric weights and level give position, depth, UV and both normals (`shaded_at`,
//!     `render/shell_shade.glsl`); rays toward the lights go through the same shell (`shell/shadow.glsl`).
//! 15. `write_outputs` (`render/output.glsl`) leaves the tone-mapped colour, the depth of the hit, and with
//!     [`render::Output::aov`] the surface itself, which [`render::Renderer::read_aov`] reads back as an [`aov::Aov`].
//!
//! ## And whether it is right
//!
//! [`shell::reference::Reference`] traces the same surface on the CPU in f64 and shares no code with any of this;
//! [`measure`] compares the two.

pub mod aov;
pub mod error;
pub mod gpu;
pub mod measure;
pub mod render;
pub mod scene;
pub mod settings;
pub mod shell;
