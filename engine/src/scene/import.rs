//! From a file to a scene.

use std::{fs, path::Path};

use gltf::json::{mesh::Mode, validation::Checked};

use super::{
    Instance, Material, Mesh, Scene,
    accessor::Buffers,
    ambient, camera,
    document::Document,
    image::Images,
    light, material,
    mesh::{self, Importer},
    node::{self, Extent, Reached},
};
use crate::error::{Error, Result};

/// Loads a glTF 2.0 file, `.gltf` or `.glb`, as DESIGN section 2 says.
///
/// The nodes of the default scene are drawn; of a file without one, those of its first scene; without any scene, all
/// nodes. Instances come in depth-first order. The camera is that of the lowest node index among the nodes that the
/// scene reaches, and the lights stand in the order of their nodes' indices. What no such node uses is not read: such
/// a mesh stays in [`Scene::meshes`] without primitives, such a material in [`Scene::materials`] with glTF's defaults.
///
/// Neither camera nor light is added: that is [`Scene::with_defaults`].
///
/// # Errors
///
/// [`Error::Input`], with the file, the object at fault and the mend. What glTF lets a reader pass over is passed over,
/// and told in [`Scene::notices`].
pub fn load(path: &Path) -> Result<Scene> {
    let bytes = fs::read(path)
        .map_err(|error| Error::input(path, "scene file", format!("cannot be read ({error})"), "check the path"))?;
    from_bytes(path, &bytes)
}

/// [`load`] with the file's bytes in hand; `file` is for messages and relative URIs.
pub(super) fn from_bytes(file: &Path, bytes: &[u8]) -> Result<Scene> {
    let mut notices = Vec::new();
    let doc = Document::parse(file, bytes, &mut notices)?;
    let reached = node::walk(&doc)?;
    let instances = instances(&doc, &reached, &mut notices)?;
    let ambient = ambient::import(&doc, &mut notices)?;
    let use_of = Use::of(&doc, &instances)?;

    let buffers = Buffers::new(&doc);
    let mut images = Images::new(&doc, &buffers);
    let mut materials = Vec::with_capacity(doc.materials.len() + 1);
    for (index, &used) in use_of.materials.iter().enumerate() {
        materials.push(material::import(&doc, index, used, &mut images, &mut notices)?);
    }
    if use_of.default_material {
        materials.push(Material::default());
    }

    let mut importer = Importer { doc: &doc, buffers: &buffers, materials: &materials, notices: &mut notices };
    let mut meshes = Vec::with_capacity(doc.meshes.len());
    for (index, &used) in use_of.meshes.iter().enumerate() {
        let name = doc.meshes[index].name.clone().unwrap_or_else(|| format!("mesh {index}"));
        let (primitives, shell_normals) = if used { importer.mesh(index)? } else { Default::default() };
        meshes.push(Mesh { name, primitives, shell_normals, deforms: false });
    }
    let camera = camera::import(&doc, &reached)?;
    let lights = light::import(&doc, &reached)?;
    Ok(Scene {
        file: file.to_owned(),
        meshes,
        images: images.colors,
        height_maps: images.heights,
        materials,
        instances,
        camera,
        lights,
        ambient,
        notices,
    })
}

fn instances(doc: &Document, reached: &[Reached], notices: &mut Vec<String>) -> Result<Vec<Instance>> {
    let mut instances = Vec::new();
    for reached in reached {
        let node = &doc.nodes[reached.node];
        let Some(mesh) = node.mesh else { continue };
        let label = doc.node_label(reached.node);
        doc.lookup(&doc.meshes, mesh, "mesh", &label)?;
        match Extent::of(&reached.world.matrix3) {
            Extent::Full => instances.push(Instance {
                name: node.name.clone().unwrap_or_else(|| format!("node {}", reached.node)),
                mesh: mesh.value(),
                transform: reached.world,
            }),
            Extent::Hidden => notices.push(format!("{label}: its scale is 0, it is not drawn")),
            Extent::Flat => {
                return Err(doc.error(
                    label,
                    "its transform to the world is singular: it flattens the mesh",
                    "give every axis a scale other than 0, and no two axes the same direction",
                ));
            }
        }
    }
    Ok(instances)
}

/// Which objects the scene's instances use.
struct Use {
    meshes: Vec<bool>,
    materials: Vec<bool>,
    /// Some primitive names no material.
    default_material: bool,
}

impl Use {
    fn of(doc: &Document, instances: &[Instance]) -> Result<Self> {
        let mut use_of = Use {
            meshes: vec![false; doc.meshes.len()],
            materials: vec![false; doc.materials.len()],
            default_material: false,
        };
        for instance in instances {
            // Each mesh is looked at once, however often it is instanced.
            if std::mem::replace(&mut use_of.meshes[instance.mesh], true) {
                continue;
            }
            for (index, primitive) in doc.meshes[instance.mesh].primitives.iter().enumerate() {
                match primitive.material {
                    _ if !makes_triangles(&primitive.mode) => {}
                    Some(material) => {
                        let by = mesh::primitive_label(doc, instance.mesh, index);
                        doc.lookup(&doc.materials, material, "material", &by)?;
                        use_of.materials[material.value()] = true;
                    }
                    None => use_of.default_material = true,
                }
            }
        }
        Ok(use_of)
    }
}

fn makes_triangles(mode: &Checked<Mode>) -> bool {
    matches!(mode, Checked::Valid(Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan))
}
