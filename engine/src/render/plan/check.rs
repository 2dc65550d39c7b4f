//! What a scene can honour of its settings, and what these ask of a device: known before the plan.

use super::ledger::Need;
use super::{needs, tangents};
use crate::error::{Error, Result};
use crate::scene::{Material, Primitive, Procedure, Scene};
use crate::settings::{Baseline, DepthPrepass, Dicer, March, PrismCulling, Settings, Shell, Stage};
use crate::shell::prisms;

/// Whether any draw of the scene would be a shell under these settings, whatever the device.
pub fn wants_shell(scene: &Scene, settings: &Settings) -> bool {
    let settings = &settings.drawn();
    settings.baseline.is_none()
        && settings.resolved_shell() != Shell::Off
        && scene.instances.iter().map(|i| &scene.meshes[i.mesh]).any(|mesh| {
            let shelled = |(p, moved): (&Primitive, Option<f64>)| {
                prisms::displacement(scene, p).is_some() && (settings.keep_all || moved.is_none())
            };
            mesh.primitives.iter().zip(needs::offsets(scene, mesh, settings)).any(shelled)
        })
}

/// What is drawn, as often as it is.
pub(super) fn drawn(scene: &Scene) -> impl Iterator<Item = &Primitive> {
    scene.instances.iter().flat_map(|i| &scene.meshes[i.mesh].primitives)
}

/// What dices the scene's displaced surfaces, where the settings want that.
pub fn dicer(scene: &Scene, settings: &Settings) -> Option<Dicer> {
    match settings.baseline {
        Some(Baseline::Diced { by, .. }) => {
            drawn(scene).any(|p| prisms::displacement(scene, p).is_some()).then_some(by)
        }
        _ => None,
    }
}

/// The first material whose heights are a function that a drawn primitive shows.
fn procedural(scene: &Scene) -> Option<(&Material, Procedure)> {
    let displaced = drawn(scene).filter(|p| prisms::displacement(scene, p).is_some());
    let materials = displaced.map(|p| &scene.materials[p.material]);
    materials.filter_map(|material| Some((material, material.displacement?.source.procedure()?))).next()
}

/// Whether a march can be used in this scene: cones are of height maps.
pub fn allows(scene: &Scene, march: March) -> bool {
    !march.reads_cones() || procedural(scene).is_none()
}

/// Whether fragments may have to be shaded sample by sample: not where all surfaces are plain and opaque.
pub fn may_shade_samples(scene: &Scene, settings: &Settings) -> bool {
    let material = |p: &Primitive| &scene.materials[p.material];
    let decides = |m: &Material| m.displacement.is_some() || m.depth_offset.is_some() || m.alpha_cutoff.is_some();
    settings.msaa > 1 && drawn(scene).any(|p| decides(material(p)))
}

/// Refuses settings that this scene cannot honour.
pub fn check(scene: &Scene, settings: &Settings) -> Result<()> {
    if !matches!(settings.msaa, 1 | 4) {
        return Err(Error::Usage(format!("--msaa {}: a pixel has 1 or 4 samples", settings.msaa)));
    }
    if settings.msaa > 1 && settings.baseline.is_some() {
        return Err(Error::Usage("--msaa: a baseline is drawn with one sample a pixel; use --msaa 1".into()));
    }
    if settings.occlusion_light > 0.0 {
        let occluded = |p: &Primitive| {
            scene.materials[p.material].occlusion.is_some()
                || (settings.ambient_occlusion && prisms::displacement(scene, p).is_some())
        };
        if scene.lights.is_empty() || !drawn(scene).any(occluded) {
            return Err(Error::Usage(
                "--occlusion-light: the scene has no light, or nothing that occludes: no occlusion texture, and no \
                 --ambient-occlusion on"
                    .into(),
            ));
        }
    }
    if settings.pixel_lod
        && let Some((material, procedure)) = procedural(scene)
    {
        return Err(Error::Usage(format!(
            "--height-lod auto: the heights of material '{}' are the function '{}', which has no LOD; drop the flag",
            material.name,
            procedure.name()
        )));
    }
    tangents::check(scene, settings)?;
    check_culling(scene, settings)?;
    super::visibility::check(scene, settings)?;
    if let Some(Baseline::Diced { edge, .. }) = settings.baseline
        && !(edge.is_finite() && edge > 0.0)
    {
        return Err(Error::Usage(format!("edges of {edge} pixels: more than 0 are possible")));
    }
    match procedural(scene).filter(|_| settings.march.reads_cones() && settings.baseline.is_none()) {
        None => Ok(()),
        Some((material, procedure)) => Err(Error::Usage(format!(
            "--march {}: cone maps are made of height maps, and the heights of material '{}' are the function '{}'; use \
             --march exact or relief",
            settings.march,
            material.name,
            procedure.name()
        ))),
    }
}

fn check_culling(scene: &Scene, settings: &Settings) -> Result<()> {
    let asked = settings.prism_culling;
    let why = match asked {
        PrismCulling::Auto | PrismCulling::Off => return Ok(()),
        _ if !wants_shell(scene, settings) => "no shell is drawn",
        _ if settings.keep_all => "--keep-all draws every prism",
        PrismCulling::Hidden if settings.msaa > 1 => "what is hidden is found with one sample a pixel; use --msaa 1",
        PrismCulling::Hidden if settings.depth_prepass == DepthPrepass::On => {
            "--depth-prepass on draws the depth of hidden prisms too"
        }
        PrismCulling::View | PrismCulling::Hidden => return Ok(()),
    };
    Err(Error::Usage(format!("--prism-culling {asked}: {why}")))
}

/// Whether prisms may be dropped unseen, before the plan: what the device is asked for.
pub fn may_cull(scene: &Scene, settings: &Settings) -> bool {
    let decided = |prisms| matches!(needs::culling(settings, Stage::Mesh, prisms), Need::Yes(_));
    wants_shell(scene, settings) && drawn(scene).any(|primitive| decided(primitive.triangles.len()))
}
