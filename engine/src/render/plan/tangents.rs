//! Whose tangents frame the parallax of a base surface: the mesh's where they serve, so that no derivative has to.

use crate::error::{Error, Result};
use crate::scene::{self, Material, Primitive, Scene};
use crate::settings::{Settings, Shell, Tangents};
use crate::shell::prisms;

/// Whether the mesh's tangents follow the height map's coordinates: those that they were made for.
fn follow_heights(material: &Material, primitive: &Primitive) -> bool {
    let Some(displacement) = material.displacement else { return false };
    let followed = scene::tangent_space(material, primitive);
    !primitive.tangents.is_empty()
        && followed.is_some_and(|(set, transform)| {
            set == displacement.tex_coord && transform.matrix2 == displacement.transform.matrix2
        })
}

/// Whether the frame of a base surface is the mesh's, as long as it keeps its shape.
pub fn from_mesh(material: &Material, primitive: &Primitive, settings: &Settings) -> bool {
    match settings.tangents {
        Tangents::Derivatives => false,
        Tangents::Auto => primitive.own_tangents && follow_heights(material, primitive),
        Tangents::Mesh => follow_heights(material, primitive),
    }
}

/// Refuses to take frames from a mesh that has none for its height map.
pub fn check(scene: &Scene, settings: &Settings) -> Result<()> {
    if settings.tangents != Tangents::Mesh || settings.resolved_shell() != Shell::Off {
        return Ok(());
    }
    for mesh in scene.instances.iter().map(|instance| &scene.meshes[instance.mesh]) {
        for primitive in mesh.primitives.iter().filter(|p| prisms::displacement(scene, p).is_some()) {
            let material = &scene.materials[primitive.material];
            let why = match () {
                () if mesh.deforms => "changes shape, and its tangents tell no lengths".to_owned(),
                () if follow_heights(material, primitive) => continue,
                () => format!("has tangents along other coordinates than the height map of '{}'", material.name),
            };
            return Err(Error::Usage(format!(
                "--tangents mesh: mesh '{}' {why}; use --tangents derivatives, or auto",
                mesh.name
            )));
        }
    }
    Ok(())
}
