//! The structs that Rust and GLSL share. They stand here once; [`glsl`] writes the shader's side of them, which the
//! compiler gets as the include `layout.glsl`.
//!
//! Only 16-byte members (and `uint`s in groups of four) are used, so std140, std430 and `repr(C)` place them alike;
//! a test compares the offsets with those in the SPIR-V.

use std::fmt::Write as _;

use bytemuck::{Pod, Zeroable};
use glam::{UVec4, Vec4};

use crate::shell::prisms::MAX_OTHERS;

/// A member type with the same layout on both sides.
trait Member {
    /// The GLSL type and the array suffix of its declarator.
    const GLSL: (&'static str, &'static str);
}

impl Member for Vec4 {
    const GLSL: (&'static str, &'static str) = ("vec4", "");
}
impl Member for UVec4 {
    const GLSL: (&'static str, &'static str) = ("uvec4", "");
}
impl Member for [Vec4; 2] {
    const GLSL: (&'static str, &'static str) = ("vec4", "[2]");
}
impl Member for [Vec4; 3] {
    const GLSL: (&'static str, &'static str) = ("vec4", "[3]");
}
impl Member for [Vec4; 12] {
    const GLSL: (&'static str, &'static str) = ("vec4", "[12]");
}
impl Member for [Vec4; MAX_OTHERS] {
    const GLSL: (&'static str, &'static str) = ("vec4", "[7]");
}
impl Member for u32 {
    const GLSL: (&'static str, &'static str) = ("uint", "");
}
impl Member for f32 {
    const GLSL: (&'static str, &'static str) = ("float", "");
}

macro_rules! shared {
    ($($(#[$doc:meta])* $name:ident { $($(#[$member_doc:meta])* $member:ident: $type:ty,)* })*) => {
        $(
            $(#[$doc])*
            #[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
            #[repr(C)]
            pub struct $name { $($(#[$member_doc])* pub $member: $type,)* }

            #[cfg(test)]
            impl $name {
                /// Name and offset of each member.
                const MEMBERS: &'static [(&'static str, usize)] =
                    &[$((stringify!($member), std::mem::offset_of!($name, $member)),)*];
            }
        )*

        /// The GLSL declarations of all shared structs.
        pub fn glsl() -> String {
            let mut text = String::from("// Written by render/layout.rs.\n#ifndef LAYOUT_GLSL\n#define LAYOUT_GLSL\n");
            $(
                writeln!(text, "struct {} {{", stringify!($name)).expect("writes to a String");
                $({
                    let (name, suffix) = <$type as Member>::GLSL;
                    writeln!(text, "    {name} {}{suffix};", stringify!($member)).expect("writes to a String");
                })*
                text.push_str("};\n");
            )*
            text.push_str("#endif\n");
            text
        }
    };
}

shared! {
    /// One frame's view.
    Frame {
        /// Width, height, 1 / width, 1 / height of the picture.
        viewport: Vec4,
        /// Depth buffer value = (x · d + y) [/ d in perspective] of view depth d; near and far view depth in z and w.
        lens: Vec4,
        /// World direction of view (xyz).
        forward: Vec4,
        /// Ambient light: four columns each of the forms of [`crate::scene::Ambient`].
        ambient: [Vec4; 12],
        /// x: 1 in perspective.
        projection: UVec4,
        /// Pixel of the target at which the picture begins (xy); z: how much of the occlusion dims direct light.
        origin: Vec4,
    }
    /// One light, camera-relative.
    Light {
        /// Colour times intensity; w: 0 directional, 1 point or spot.
        intensity: Vec4,
        /// Position; w: 1 / range⁴, 0 without a range.
        position: Vec4,
        /// Direction the light travels, unit.
        direction: Vec4,
        /// Cone: clamp(cos · x + y) is its edge's fade; a point light has (0, 1). First of its shadow maps, and how many.
        spot: Vec4,
    }
    /// One shadow map, a tile of the atlas: rows of camera-relative world to the tile's texels (times clip w) and depth.
    ShadowView {
        /// Row to texel x.
        x: Vec4,
        /// Row to texel y (down).
        y: Vec4,
        /// Row to clip w.
        w: Vec4,
        /// Row to the light's view depth.
        depth: Vec4,
        /// Scale and offset of [`Frame::lens`], texels a side, 1 in perspective.
        lens: Vec4,
        /// First texel of the tile, 1 / width, 1 / height of the atlas.
        tile: Vec4,
    }
    /// One drawn primitive of one instance: its transforms, made in f64 and rebased to the mesh's centre.
    Object {
        /// Row of mesh to clip x.
        clip_x: Vec4,
        /// Row of mesh to clip y (down).
        clip_y: Vec4,
        /// Row of mesh to clip w.
        clip_w: Vec4,
        /// Row of mesh to view depth.
        depth: Vec4,
        /// Rows of mesh to camera-relative world.
        world_x: Vec4,
        /// See `world_x`.
        world_y: Vec4,
        /// See `world_x`.
        world_z: Vec4,
        /// Rows of the inverse transpose of mesh to world.
        normal_x: Vec4,
        /// See `normal_x`.
        normal_y: Vec4,
        /// See `normal_x`.
        normal_z: Vec4,
        /// In mesh space: the eye (w = 1), or the direction toward it (orthographic, w = 0).
        eye: Vec4,
        /// x: sign of the determinant of the linear rows x, y, w (view depth when orthographic).
        handedness: Vec4,
        /// Where heights fade: half extents of a box around the mesh's centre; w: [`super::plan::fade::Fade::scale`].
        fade: Vec4,
        /// Nothing: brings it to 256 bytes, the most that a device may ask of a uniform buffer's offset.
        spare: [Vec4; 3],
    }
    /// One vertex: what every shell reads of it, and lids and walks gather. Tangents and UV sets have buffers of their own.
    /// A primitive has these or [`SurfaceVertex`].
    Vertex {
        /// Position, rebased to the mesh's centre; w: see `tangent_frames`, where the mesh's tangents frame its parallax.
        position: Vec4,
        /// Shell normal times its fold factor r; w: u of the height map.
        shell: Vec4,
        /// Shading normal; w: v of the height map.
        normal: Vec4,
    }
    /// One vertex of a primitive that no draw reads shell normals of.
    SurfaceVertex {
        /// Position, rebased to the mesh's centre; w: u of the height map.
        position: Vec4,
        /// Shading normal; w: v of the height map.
        normal: Vec4,
    }
    /// One prism.
    PrismData {
        /// Three vertices; w: 3 bits a wall for its kind, then 1 bit a wall for descending order, then 1 if plain, then 1
        /// if irregular (walk); from bit 14 on 3 bits a wall for the neighbour's field, then 1 bit a wall if its surface
        /// is hit from behind too; bit 26 if a ray may enter otherwise than through lid and base, then 1 bit a corner if it
        /// lies at a border (walk); bit 30 if its heights are all the same.
        corners: UVec4,
        /// Lowest and highest level of its surface and steps; for the walk, least base and greatest lid of its corners.
        range: Vec4,
        /// Height map coordinates across wall k, at its canonical first and second corner.
        neighbour_uv: [Vec4; 3],
    }
    /// One box of the hierarchy over a primitive's prisms; bits of floats, as small numbers in floats may be flushed.
    BoxNode {
        /// Least corner; w: the box to go on with where a ray misses this one.
        low: UVec4,
        /// Greatest corner; w: the prism in it, or none where the boxes that follow divide it.
        high: UVec4,
    }
    /// One primitive's material.
    Material {
        /// Linear base colour factor.
        base_color: Vec4,
        /// Roughness, metallic, normal map scale, occlusion strength.
        factors: Vec4,
        /// Emissive factor; w: alpha cut-off.
        emissive: Vec4,
        /// Scale, midlevel, lowest and highest level of the whole map.
        displacement: Vec4,
        /// Least and greatest UV of the primitive in the height map.
        uv_bounds: Vec4,
        /// Texels of the height map.
        height_size: Vec4,
        /// Fewest and most linear steps, refinements; 1 if two-sided, plus twice the exact march's step limit.
        march: UVec4,
        /// Of the classic marches: the secant's tolerance, of the height's range; the least cosine of a ray. z: a plain
        /// surface's depth offset, world units. w: the LOD at which heights begin to fade.
        classic: Vec4,
        /// Horizon clipping: strength, bias, safe threshold, falloff.
        horizon: Vec4,
        /// Rays toward lights: softness, levels above the highest one that they are followed for, most linear steps,
        /// the highest level of all.
        shadow: Vec4,
        /// Scale, midlevel and texels of each other field that its walls meet.
        others: [Vec4; MAX_OTHERS],
        /// Rows of the texture transform, as (a, b, offset, unused).
        base_color_uv: [Vec4; 2],
        /// See `base_color_uv`.
        metallic_roughness_uv: [Vec4; 2],
        /// See `base_color_uv`.
        normal_uv: [Vec4; 2],
        /// See `base_color_uv`.
        occlusion_uv: [Vec4; 2],
        /// See `base_color_uv`.
        emissive_uv: [Vec4; 2],
        /// Factor of a dielectric's reflection at normal incidence, by colour; w: of all of it.
        specular: Vec4,
        /// See `base_color_uv`.
        specular_uv: [Vec4; 2],
        /// See `base_color_uv`.
        specular_color_uv: [Vec4; 2],
    }
    /// What a frame's fragments count.
    Counters {
        /// Loops that reached their limit.
        limits: u32,
        /// Reads of height maps, and of bounds and cones over them.
        reads: u32,
    }
    /// Push constants of one draw.
    Draw {
        /// Index of the object.
        object: u32,
        /// Items of the draw: prisms, or those of the list of borders.
        count: u32,
        /// Prisms of the primitive: what a walk can cross.
        prism_count: u32,
        /// 1 where bases are drawn beside lids.
        bases: u32,
        /// Of a draw whose prisms are culled: 1 in the second round, 0 in the first or only one.
        round: u32,
        /// Of the same: 1 where what is dropped is counted.
        counted: u32,
        /// Of a draw that reads the visibility buffer: 1 where it draws one triangle over the picture.
        resolves: u32,
        /// Of a draw that dices: its first triangle.
        first: u32,
        /// Of the same: patches along an edge of each triangle, a power of two.
        splits: u32,
        /// Of the same: edges of small triangles to a world unit, one unit before the eye or, orthographic, anywhere.
        fineness: f32,
    }
    /// One base triangle of a primitive that is diced. Edge k joins corners (k+1, k+2) mod 3; where there is no step, all
    /// triangles at a corner or an edge name the same vertices there.
    DicedTriangle {
        /// Three vertices; w: bit k if edge k runs from corner k+2 to corner k+1.
        corners: UVec4,
        /// The vertex that stands for each corner.
        anchors: UVec4,
        /// The vertices that stand for the ends of edges 0 and 1.
        edges: UVec4,
        /// Those of edge 2.
        last_edge: UVec4,
        /// Lowest and highest level; how far normals of small triangles may turn from the base triangle's: the tangent per
        /// steepness that dicing adds, and that from the start.
        range: Vec4,
    }
    /// One vertex of a deforming mesh: what no pose changes.
    DeformVertex {
        /// Welded vertex and smoothing group.
        ids: UVec4,
        /// Texture coordinates that its tangent follows; z: handedness, 0 without a tangent.
        tangent: Vec4,
        /// Base and lid level.
        levels: Vec4,
    }
    /// One triangle of a deforming mesh.
    DeformTriangle {
        /// Three vertices; w: 1 if its material displaces it.
        corners: UVec4,
        /// Triangle across each wall, or none.
        across: UVec4,
        /// Lowest and highest level of its map, 0 included.
        range: Vec4,
    }
    /// One vertex of a deforming mesh in its pose.
    DeformFrame {
        /// Position, rebased to the mesh's centre.
        position: Vec4,
        /// Shading normal.
        normal: Vec4,
        /// Shading tangent and handedness.
        tangent: Vec4,
    }
    /// Push constants of one pass over a deforming mesh.
    DeformPass {
        /// The mesh's centre.
        center: Vec4,
        /// Items of the pass.
        count: u32,
        /// The mesh's number of the primitive's first vertex or triangle.
        first: u32,
        /// Round of the fold rule.
        round: u32,
        /// Rounds of it.
        rounds: u32,
        /// Welded vertices of the mesh.
        welds: u32,
        /// Where the lists of corners around welded vertices begin.
        weld_fans: u32,
        /// Where those around smoothing groups begin.
        smooth_fans: u32,
        /// Where those around vertices begin.
        vertex_fans: u32,
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::gpu::{BlockMember, ShaderStage};
    use crate::render::shader_compiler;

    /// Compares the members of `prefix` in a block with a struct's; returns how many were there.
    fn compare(members: &[BlockMember], prefix: &str, expected: &[(&str, usize)]) -> usize {
        let mut found = BTreeSet::new();
        for member in members {
            let Some(name) = member.path.strip_prefix(prefix) else { continue };
            if let Some((_, offset)) = expected.iter().find(|(n, _)| *n == name.trim_end_matches("[]")) {
                assert_eq!(member.offset as usize, *offset, "{prefix}{name}");
                found.insert(name.trim_end_matches("[]"));
            }
        }
        found.len()
    }

    #[test]
    fn the_shaders_place_every_member_where_rust_does() {
        let compiler = shader_compiler(None).unwrap();
        let defines = |names: &[&'static str]| -> Vec<(&'static str, String)> {
            names.iter().map(|n| (*n, if n.ends_with("_UV") { "0".into() } else { String::new() })).collect()
        };
        let mut shell = defines(&["HAS_HEIGHT", "MARCH_RELIEF", "AOV_UV", "NORMAL_UV", "VERTEX_TANGENTS"]);
        shell.extend(defines(&["ALPHA_MASK", "BASE_COLOR_UV", "METALLIC_ROUGHNESS_UV", "OCCLUSION_UV", "EMISSIVE_UV"]));
        shell.extend(defines(&["SPECULAR", "SPECULAR_UV", "SPECULAR_COLOR_UV"]));
        shell.extend([("HEIGHT_WRAP_U", "0".into()), ("HEIGHT_WRAP_V", "0".into())]);
        shell.push(("LIGHTS", "2".into()));
        shell.extend([("ROUGHNESS_CHANNEL", "g".into()), ("METALLIC_CHANNEL", "b".into())]);
        let mut shadowed = shell.clone();
        shadowed.extend(defines(&["SELF_SHADOW", "SHADOW_REENTRY"]));
        shadowed.push(("SHADOWED_LIGHTS", "1".into()));
        let mut surface = shell.clone();
        surface.extend(defines(&[
            "MARCH_TRACES",
            "MARCH_MOVES",
            "UV_BOUNDS",
            "HORIZON",
            "COUNT_LIMITS",
            "COUNT_READS",
            "DEPTH_OFFSET",
            "SELF_SHADOW",
            "SHADOW_MAPS",
        ]));
        surface.push(("SHADOWED_LIGHTS", "1".into()));
        let lean = defines(&["HAS_HEIGHT", "SURFACE_VERTICES"]);
        let mut diced = defines(&["CULLS"]);
        diced.extend([("HEIGHT_WRAP_U", "0".into()), ("HEIGHT_WRAP_V", "0".into())]);
        let none = Vec::new();
        let (mut seen, mut unpushed) = (BTreeSet::new(), Vec::new());
        for (path, stage, defines, push) in [
            ("render/shell.frag", ShaderStage::Fragment, &shadowed, Draw::MEMBERS),
            ("render/surface.frag", ShaderStage::Fragment, &surface, Draw::MEMBERS),
            ("render/shell.mesh", ShaderStage::Mesh, &shell, Draw::MEMBERS),
            ("render/surface.vert", ShaderStage::Vertex, &lean, Draw::MEMBERS),
            ("baseline/dice.tesc", ShaderStage::TessControl, &diced, Draw::MEMBERS),
            ("render/deform_write_vertices.comp", ShaderStage::Compute, &none, DeformPass::MEMBERS),
            ("render/deform_folds.comp", ShaderStage::Compute, &none, DeformPass::MEMBERS),
            ("render/deform_leans.comp", ShaderStage::Compute, &none, DeformPass::MEMBERS),
            ("render/deform_write_prisms.comp", ShaderStage::Compute, &none, DeformPass::MEMBERS),
            ("render/deform_fit_boxes.comp", ShaderStage::Compute, &none, DeformPass::MEMBERS),
        ] {
            let shader = compiler.compile(path, stage, defines).unwrap();
            for block in &shader.reflection.bindings {
                let (prefix, expected, size) = match block.name.as_str() {
                    "FrameBlock" => ("frame.", Frame::MEMBERS, None),
                    "MaterialBlock" => ("material.", Material::MEMBERS, None),
                    "counters" => ("item.", Counters::MEMBERS, None),
                    "ObjectBlock" => ("drawn.", Object::MEMBERS, None),
                    "LightBlock" => ("lights[].", Light::MEMBERS, None),
                    "shadow_views" => ("item[].", ShadowView::MEMBERS, Some(size_of::<ShadowView>())),
                    "vertices" => ("item[].", Vertex::MEMBERS, Some(size_of::<Vertex>())),
                    "surface_vertices" => ("item[].", SurfaceVertex::MEMBERS, Some(size_of::<SurfaceVertex>())),
                    "mesh_vertices" => ("item[].", DeformVertex::MEMBERS, Some(size_of::<DeformVertex>())),
                    "triangles" => ("item[].", DeformTriangle::MEMBERS, Some(size_of::<DeformTriangle>())),
                    "posed" => ("item[].", DeformFrame::MEMBERS, Some(size_of::<DeformFrame>())),
                    "diced_triangles" => ("item[].", DicedTriangle::MEMBERS, Some(size_of::<DicedTriangle>())),
                    "shadow_hierarchy" | "boxes" => ("item[].", BoxNode::MEMBERS, Some(size_of::<BoxNode>())),
                    "prisms" => ("item[].", PrismData::MEMBERS, Some(size_of::<PrismData>())),
                    _ => continue,
                };
                assert_eq!(compare(&block.members, prefix, expected), expected.len(), "{path}: {}", block.name);
                if let Some(size) = size {
                    let array = block.members.iter().find(|m| m.path.starts_with("item")).unwrap();
                    assert_eq!(array.stride, Some(size as u32), "{path}: {}", block.name);
                }
                seen.insert(block.name.clone());
            }
            let block = if stage == ShaderStage::Compute { "deform." } else { "draw." };
            let pushed = &shader.reflection.push_constants;
            assert_eq!(compare(pushed, block, push) > 0, !pushed.is_empty(), "{path}: push constants");
            unpushed.extend(pushed.is_empty().then_some(path));
        }
        assert_eq!(unpushed, ["render/surface.frag", "render/surface.vert"]);
        let all = [
            "FrameBlock",
            "LightBlock",
            "MaterialBlock",
            "ObjectBlock",
            "boxes",
            "counters",
            "diced_triangles",
            "mesh_vertices",
            "posed",
            "prisms",
            "shadow_hierarchy",
            "shadow_views",
            "surface_vertices",
            "triangles",
            "vertices",
        ];
        assert_eq!(seen.iter().map(String::as_str).collect::<Vec<_>>(), all);
    }
}
