//! What a pipeline's code has and has not, read off its variant.

use serde::Serialize;

use crate::render::variant::{Height, Pass, UV_SETS, Variant};
use crate::settings::March;

/// One thing that shader code or pipeline state may have.
#[derive(Clone, Debug, Serialize)]
pub struct Part {
    /// The thing.
    pub what: &'static str,
    /// Whether it is there.
    pub kept: bool,
    /// Why, or why not.
    pub why: &'static str,
}

/// Every part, had or not.
pub fn of(variant: &Variant) -> Vec<Part> {
    let mut parts = Vec::new();
    let mut part = |what, kept: bool, why: &'static str, why_not: &'static str| {
        parts.push(Part { what, kept, why: if kept { why } else { why_not } });
    };
    let shell = variant.geometry.stage().is_some();
    let fragment = variant.shaders().len() > 1;
    let height = |of: fn(Height) -> bool| variant.height.is_some_and(of);
    let march = |of: fn(March) -> bool| variant.height.is_some_and(|h| of(h.march));
    part("fragment shader", fragment, "colours or the hit's depth are computed", "the raster's depth is all it is for");
    part("culling", variant.cull.is_some(), "unseen prisms are dropped before it", "all its prisms are made");
    let hides = variant.cull.is_some_and(|cull| cull.hidden);
    part("culling of the hidden", hides, "depth before it drops them", "depth drops their pixels");
    if variant.pass == Pass::Cull {
        return parts;
    }
    part("height field", variant.height.is_some(), "it traces or shades by it", "none moves or shades it");
    part("gl_FragDepth", variant.writes_depth(), "its surface is not the raster's", "its surface is the raster's own");
    let not_behind =
        if variant.writes_depth() { "it may lie before the raster's depth" } else { "no depth is written" };
    let behind = variant.depth_behind && variant.writes_depth();
    part("conservative depth", behind, "it never lies before the raster's depth", not_behind);
    part("discard", variant.discards(), "a ray may miss, or a texel be cut out", "nothing cuts anything out of it");
    part("linear march", march(March::steps), "its march takes steps", "its march takes none");
    part("exact march", march(|m| m == March::Exact), "--march exact", "its march is another, or none");
    let mapped = |h: Height| h.march == March::Exact && h.procedure.is_none();
    part("min-max pyramid", height(mapped), "the exact march skips by it", "only the exact march of a map reads it");
    part("cone map", march(March::reads_cones), "its march steps through cones", "its march reads no cones");
    part(
        "steps at walls",
        shell && height(|h| h.steps),
        "heights differ across some walls",
        "the heights agree, or end",
    );
    part("plain prisms", shell && height(|h| h.plain), "some triangles are plain", "all are displaced, or all plain");
    part("one step", height(|h| h.one_heights), "some triangles have one height", "none has, or all are marched");
    part("self-shadow", height(|h| h.self_shadow), "rays go toward the lights", "not asked for, or no light can graze");
    part(
        "re-entry of shadow rays",
        height(|h| h.reenters),
        "what leaves the shell may meet it again",
        "no shadow rays",
    );
    part("shadow map look-ups", variant.shadow_maps, "lights have maps", "no light has one");
    part("lights", variant.lights > 0, "the scene has some", "none in the scene, or depth alone");
    let of = "a normal map, or parallax, is in their frame";
    part("tangents", variant.reads_tangents(), of, "no normal map is read");
    for (set, what) in (0..).zip(UV_SETS) {
        part(what, variant.reads_uvs(set), "a texture or the surface data read it", "nothing reads it");
    }
    part("ambient occlusion", height(|h| h.ambient_occlusion), "--ambient-occlusion on", "not asked for");
    part("alphaMode MASK", variant.alpha_mask, "its alpha may fall below the cut-off", "nothing is cut out by alpha");
    part("UV bounds", height(|h| h.uv_bounds), "--silhouette uv-bounds", "not asked for");
    part("horizon", height(|h| h.horizon), "--silhouette horizon", "not asked for");
    part("LOD of each pixel", height(|h| h.pixel_lod), "--height-lod auto", "heights are read at full size");
    part("LOD fade", height(|h| h.lod_fade), "--lod-fade", "not asked for");
    part("dither", variant.dithers(), "blue noise is read", "nothing is dithered");
    part("samples", variant.samples > 1, "--msaa 4", "one a pixel");
    let raster = "the raster's coverage of the samples is right";
    part("shading by sample", variant.per_sample, "the fragment decides what it covers", raster);
    part("surface data", variant.aov, "they are asked for", "not asked for");
    part("loop counters", height(|h| h.count_limits), "--stats counts loops that give up", "not asked for");
    part("read counters", height(|h| h.count_reads), "the report counts reads of height maps", "not asked for");
    part(
        "visibility buffer",
        variant.visibility,
        if shell { "its walks begin at each pixel's nearest lid" } else { "each pixel's nearest triangle is shaded" },
        "it begins where it is drawn",
    );
    part("depth stands already", variant.depth_stands, "a pass before it drew its depth", "it draws its own depth");
    let light = variant.pass == Pass::Light;
    part(
        "both sides",
        variant.double_sided || light,
        "its material, or light, is stopped by both",
        "backs do not show",
    );
    parts
}
