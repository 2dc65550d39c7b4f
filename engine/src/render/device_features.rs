//! The device features that a scene needs.

use super::plan;
use crate::gpu::{Context, Feature};
use crate::scene::Scene;
use crate::settings::{Dicer, Settings, Stage, View};

/// Device features that a scene needs under given settings.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Features {
    /// Without these nothing can be drawn.
    pub required: Vec<Feature>,
    /// Used where the device has them.
    pub optional: Vec<Feature>,
    /// One of them is enough, the first that the device has.
    pub alternatives: Vec<Feature>,
}

/// The features of `scene` under `settings`. `interactive`: the settings may change while it runs, so both stages are
/// asked for, neither insisted on.
pub fn features(scene: &Scene, settings: &Settings, interactive: bool) -> Features {
    let mut features = Features::default();
    if interactive {
        features.optional.extend([
            Feature::TaskShader,
            Feature::MeshShader,
            Feature::GeometryShader,
            Feature::SampleRateShading,
        ]);
        features.optional.push(Feature::FillModeNonSolid);
    }
    if settings.view == View::Base {
        features.required.push(Feature::FillModeNonSolid);
    }
    if plan::may_shade_samples(scene, settings) {
        features.required.push(Feature::SampleRateShading);
    }
    if settings.counts() {
        features.required.push(Feature::FragmentStoresAndAtomics);
    }
    if plan::wants_shell(scene, settings) {
        match settings.stage {
            Stage::Mesh => features.required.push(Feature::MeshShader),
            Stage::Geometry => features.required.push(Feature::GeometryShader),
            Stage::Auto => features.alternatives.extend([Feature::MeshShader, Feature::GeometryShader]),
        }
    }
    if settings.stage != Stage::Geometry && plan::may_cull(scene, settings) {
        features.optional.push(Feature::TaskShader);
    }
    if let Some(by) = plan::dicer(scene, settings) {
        features.required.extend_from_slice(dicer_features(by));
    }
    features
}

/// The stages that can make a shell on a device, of the features that it was made with.
pub fn shell_stages(ctx: &Context) -> Vec<Stage> {
    let stages = [(Stage::Mesh, Feature::MeshShader), (Stage::Geometry, Feature::GeometryShader)];
    stages.into_iter().filter(|(_, feature)| ctx.has(*feature)).map(|(stage, _)| stage).collect()
}

/// What a baseline that dices needs of the device.
pub fn dicer_features(by: Dicer) -> &'static [Feature] {
    match by {
        Dicer::Tessellation => &[Feature::TessellationShader],
        Dicer::Mesh => &[Feature::TaskShader, Feature::MeshShader],
    }
}
