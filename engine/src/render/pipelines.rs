//! The pipeline of a shader variant.

use std::sync::Arc;

use super::aov::AovTargets;
use super::variant::{Geometry, Pass, Variant};
use super::{DEPTH_FORMAT, Output, baseline, visibility};
use crate::error::Result;
use crate::gpu::{Context, DepthState, GraphicsDesc, Pipeline, Shader, ShaderCompiler, vk};

/// Lids and bases come nearer by a pixel of their slope and some ulp: the rasteriser's own depth may then promise that
/// no hit lies before it, though it moves corners to its grid.
const LID_DEPTH_BIAS: [f32; 2] = [64.0, 1.0];

/// A variant's shaders, one a stage.
pub fn variant_shaders(compiler: &ShaderCompiler, variant: &Variant) -> Result<Vec<Arc<Shader>>> {
    let defines = variant.defines();
    variant.shaders().iter().map(|(path, stage)| compiler.compile(path, *stage, &defines)).collect()
}

/// Makes it of them.
pub fn variant_pipeline(ctx: &Context, output: Output, variant: &Variant, shaders: &[Arc<Shader>]) -> Result<Pipeline> {
    if let (Pass::Cull, [shader]) = (variant.pass, shaders) {
        return Pipeline::compute(ctx, &variant.name(), shader);
    }
    let mut color_formats = Vec::new();
    if variant.pass == Pass::Visibility {
        color_formats.push(visibility::FORMAT);
    }
    if variant.pass == Pass::Shade {
        color_formats.push(output.color_format);
        if variant.aov {
            color_formats.extend(AovTargets::FORMATS);
        }
    }
    let outlines = matches!(variant.geometry, Geometry::Shell(_) | Geometry::Borders(_));
    let over_picture = variant.names_triangles();
    let cull = if outlines || over_picture || variant.double_sided {
        vk::CullModeFlags::NONE
    } else {
        vk::CullModeFlags::BACK
    };
    let front_face = if variant.mirrored { vk::FrontFace::CLOCKWISE } else { vk::FrontFace::COUNTER_CLOCKWISE };
    Pipeline::graphics(
        ctx,
        &GraphicsDesc {
            name: &variant.name(),
            shaders: &shaders.iter().collect::<Vec<_>>(),
            vertices: match variant.geometry {
                // Fragments that know their triangle's number take corners that are looked up by it.
                Geometry::MicroMesh if variant.pass == Pass::Shade && !over_picture => Some(baseline::VERTEX_LAYOUT),
                _ => None,
            },
            color_formats: &color_formats,
            depth_format: Some(DEPTH_FORMAT),
            depth: match variant.geometry {
                // The triangles named have written theirs.
                _ if over_picture => DepthState::OFF,
                _ if variant.depth_stands => {
                    DepthState { write: false, compare: vk::CompareOp::EQUAL, ..DepthState::REVERSED }
                }
                Geometry::BaseEdges | Geometry::PrismEdges => DepthState { write: false, ..DepthState::REVERSED },
                _ => DepthState::REVERSED,
            },
            cull,
            front_face,
            topology: match variant.geometry {
                _ if outlines => vk::PrimitiveTopology::POINT_LIST,
                Geometry::Diced { .. } => vk::PrimitiveTopology::PATCH_LIST,
                Geometry::PrismEdges => vk::PrimitiveTopology::LINE_LIST,
                _ => vk::PrimitiveTopology::TRIANGLE_LIST,
            },
            samples: vk::SampleCountFlags::from_raw(variant.samples.into()),
            polygon_mode: match variant.geometry {
                Geometry::BaseEdges => vk::PolygonMode::LINE,
                _ => vk::PolygonMode::FILL,
            },
            blend: false,
            depth_bias: matches!(variant.geometry, Geometry::Lids(_) | Geometry::BaseEdges).then_some(LID_DEPTH_BIAS),
        },
    )
}
