//! What is made of a height map before any frame, for a file: cone maps and min-max pyramids.

use std::path::Path;

use super::resources::{height_sampler, upload_height};
use super::{cones, pyramid};
use crate::error::Result;
use crate::gpu::{Context, Image, Sampler, ShaderCompiler, Uploader};
use crate::scene::{HeightMap, Wrap};
use crate::shell::cones::ConeKind;

pub use super::pyramid::Level;

/// The cone map of a map from `file`: √ratio of each texel as 16 bits. `progress` is told the share that is done.
pub fn cone_map(
    ctx: &Context,
    compiler: &ShaderCompiler,
    file: &Path,
    map: &HeightMap,
    wrap: [Wrap; 2],
    kind: ConeKind,
    progress: impl FnMut(f64),
) -> Result<Vec<u16>> {
    let (image, sampler) = upload(ctx, file, map, wrap)?;
    cones::build(ctx, compiler, map, (&image, &sampler), wrap, kind, progress)
}

/// The min-max pyramid of a map from `file`, finest level first; `shaders/shell/pyramid.glsl` says what a node covers.
pub fn min_max(
    ctx: &Context,
    compiler: &ShaderCompiler,
    file: &Path,
    map: &HeightMap,
    wrap: [Wrap; 2],
) -> Result<Vec<Level>> {
    let (image, sampler) = upload(ctx, file, map, wrap)?;
    pyramid::levels(ctx, compiler, &image, &sampler, wrap)
}

fn upload(ctx: &Context, file: &Path, map: &HeightMap, wrap: [Wrap; 2]) -> Result<(Image, Sampler)> {
    let mut uploader = Uploader::new(ctx)?;
    let image = upload_height(ctx, &mut uploader, file, map, false)?;
    uploader.finish()?;
    Ok((image, height_sampler(ctx, wrap)?))
}
