//! The `prism` command: the list of samples, the benchmark and the report.

mod app;
mod bench;
mod cloth;
mod depth_offset;
mod integration;
mod photo;
mod prism_shell;
mod procedural;
#[cfg(feature = "report")]
mod report;
mod self_shadow;
mod shadows;
mod silhouette;
mod stability;
mod techniques;
mod terrain;
mod timing;
mod viewer;

fn main() -> std::process::ExitCode {
    app::main(&[
        &prism_shell::PrismShell,
        &viewer::Viewer,
        &stability::Stability,
        &cloth::Cloth,
        &shadows::Shadows,
        &self_shadow::SelfShadows,
        &techniques::Techniques,
        &silhouette::Outlines,
        &depth_offset::Sand,
        &procedural::Wall::SWINGING,
        &photo::Photographs,
        &terrain::Terrain,
        &integration::Integration,
    ])
}
