//! What `--stats` prints: the device, the pipelines, the passes, the memory.

use std::fmt::Write as _;

use prism_engine::{
    gpu::{Context, ShaderCompiler, ShaderStage},
    render::{Renderer, culling::Counts},
};

use super::timings::{self, FrameRow};

/// The report, one fact a line, each line with its key in front.
///
/// `limits`: loops that reached their limit, over all frames; `None` where the march has none. `culled`: prisms
/// of the last frame, where unseen ones are dropped.
pub fn report(
    ctx: &Context,
    compiler: &ShaderCompiler,
    renderer: &Renderer,
    frames: &[FrameRow],
    limits: Option<u64>,
    culled: Option<Counts>,
) -> String {
    let mut text = String::new();
    let mut line = |key: &str, value: String| {
        // Writing to a String cannot fail.
        let _ = writeln!(text, "{key}: {value}");
    };

    line("device", format!("{}, {}", ctx.device_name(), ctx.driver().trim()));
    line("features", or_none(ctx.enabled_features().iter().map(|feature| feature.name())));
    line("extensions", or_none(ctx.enabled_extensions().iter().map(String::as_str)));
    let compiled = compiler.stats();
    line(
        "shaders",
        format!("{} compiled in {:.1} ms, {} from the cache", compiled.misses, compiled.compile_ms, compiled.hits),
    );
    let pipelines = renderer.pipelines();
    let mut variants: Vec<String> = Vec::new();
    for shader in pipelines.iter().flat_map(|(_, pipeline)| pipeline.shaders()) {
        let label = shader.label();
        if !variants.contains(&label) {
            variants.push(label);
        }
    }
    let created: Vec<_> = pipelines.iter().filter_map(|(_, pipeline)| pipeline.creation()).collect();
    line(
        "pipelines",
        format!(
            "{} of {} shader variants, created in {:.1} ms, {} from the cache",
            pipelines.len(),
            variants.len(),
            created.iter().map(|creation| creation.ms).sum::<f64>(),
            created.iter().filter(|creation| creation.cached).count()
        ),
    );
    for (name, pipeline) in pipelines {
        // From the SPIR-V itself, so that one stage cannot pose as another.
        let models: Vec<&str> = pipeline.execution_models().into_iter().map(execution_model).collect();
        line(&format!("pipeline {name}"), models.join("+"));
    }
    line("loop limits reached", limits.map_or_else(|| "no loop has one".to_owned(), |n| n.to_string()));
    let culled = culled.map(|Counts { shown, outside, away, hidden }| {
        format!("{shown} drawn; {outside} outside the view, {away} facing away or behind a horizon, {hidden} hidden")
    });
    line("prisms culled", culled.unwrap_or_else(|| "none, all are drawn".to_owned()));
    let memory = ctx.memory_report();
    let total: u64 = memory.iter().map(|(_, bytes)| bytes).sum();
    let passes = timings::summary(frames);

    text.push_str(&passes);
    let _ = writeln!(text, "memory: {} in {} allocations", mebibytes(total), memory.len());
    for (name, bytes) in &memory {
        let _ = writeln!(text, "memory {name}: {}", mebibytes(*bytes));
    }
    text
}

/// SPIR-V's name of the stage.
fn execution_model(stage: ShaderStage) -> &'static str {
    match stage {
        ShaderStage::Vertex => "Vertex",
        ShaderStage::TessControl => "TessellationControl",
        ShaderStage::TessEvaluation => "TessellationEvaluation",
        ShaderStage::Geometry => "Geometry",
        ShaderStage::Task => "TaskEXT",
        ShaderStage::Mesh => "MeshEXT",
        ShaderStage::Fragment => "Fragment",
        ShaderStage::Compute => "GLCompute",
    }
}

fn or_none<'a>(names: impl Iterator<Item = &'a str>) -> String {
    let names: Vec<&str> = names.collect();
    if names.is_empty() { "none".to_owned() } else { names.join(", ") }
}

fn mebibytes(bytes: u64) -> String {
    format!("{:.3} MiB", bytes as f64 / f64::from(1 << 20))
}
