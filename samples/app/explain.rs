//! `prism explain`: what a scene needs on this machine, and why.

use prism_engine::{
    error::Result,
    gpu::{self, DeviceReport, Feature},
    render::{
        Output,
        explain::{Explanation, Situation},
        plan,
    },
    settings::{Settings, Stage},
};

use super::{cli::ExplainArgs, console, job::Job, load, offscreen};

/// Texels a side of an image that every device of Vulkan 1.3 holds.
const LEAST_MAX_IMAGE_2D: u32 = 4096;

/// Prints the plan of the job's first scene.
pub fn run(args: &ExplainArgs, job: &Job<'_>) -> Result<()> {
    let loaded = &load::load(job, 1)?[0];
    let (scene, settings) = (&*loaded.scene, &job.settings);
    plan::check(scene, settings)?;
    // A plan can be told without a device, unless one is asked for.
    let device = match &args.gpu {
        Some(selector) => Some(gpu::chosen_device(Some(selector))?),
        None => gpu::chosen_device(None).ok(),
    };
    let stage = stage(settings, device.as_ref());
    let output = Output { color_format: offscreen::FORMAT, aov: job.sample.exhibit().is_some() };
    let plan = plan::plan(scene, settings, stage, output.aov);
    for notice in &plan.notices {
        console::notice(notice);
    }
    let situation = Situation {
        device: device.map(|device| device.name),
        extent: job.sample.exhibit().map_or(Ok(job.size()), |exhibit| exhibit.frame_size(job.size()))?,
        max_image_2d: LEAST_MAX_IMAGE_2D,
        output,
        window: false,
    };
    let explanation = Explanation::new(scene, settings, &plan, &situation);
    console::data(&if args.json { format!("{}\n", explanation.json()) } else { explanation.to_string() })
}

/// What makes shells there.
fn stage(settings: &Settings, device: Option<&DeviceReport>) -> Stage {
    let has_mesh = device.is_none_or(|device| device.features.contains(&(Feature::MeshShader, true)));
    match settings.stage {
        Stage::Auto if has_mesh => Stage::Mesh,
        Stage::Auto => Stage::Geometry,
        asked => asked,
    }
}
