//! The JSON of a scene file: its version, its extensions, and its lists as typed objects.
//!
//! The types are those of the `gltf` crate, but its own importer and validator are not used: they index without
//! checking and do not say which object is at fault. Every list entry is parsed by itself, so that its error can name
//! it, and every index is looked up through [`Document::lookup`].

use std::path::{Path, PathBuf};

use gltf::json::{self, Index, extensions::scene::khr_lights_punctual};
use serde::de::DeserializeOwned;
use serde_json::{Map, Value, error::Category};

use super::{ambient, container};
use crate::error::{Error, Result};

/// What this engine implements.
const KNOWN_EXTENSIONS: [&str; 3] = ["KHR_lights_punctual", "KHR_materials_specular", "KHR_texture_transform"];

/// Top-level lists that are not read, and what that means for the picture.
const IGNORED_LISTS: [(&str, &str); 2] = [
    ("skins", "skins are ignored: the meshes are drawn unskinned"),
    ("animations", "animations are ignored: the scene stands still"),
];

/// A parsed file. Indices between its objects are not checked yet.
pub(super) struct Document {
    /// The file, for messages and to resolve URIs.
    pub file: PathBuf,
    /// GLB's binary chunk.
    pub bin: Option<Vec<u8>>,
    /// The default scene's index.
    pub scene: Option<Index<json::Scene>>,
    pub accessors: Vec<json::Accessor>,
    pub buffers: Vec<json::Buffer>,
    pub views: Vec<json::buffer::View>,
    pub cameras: Vec<json::Camera>,
    pub images: Vec<json::Image>,
    pub lights: Vec<khr_lights_punctual::Light>,
    /// Image-based lights, of which the scene may name one.
    pub ambients: Vec<Map<String, Value>>,
    /// What the scene says of them.
    pub ambient_reference: Option<Value>,
    pub materials: Vec<json::Material>,
    pub meshes: Vec<json::Mesh>,
    pub nodes: Vec<json::Node>,
    pub samplers: Vec<json::texture::Sampler>,
    pub scenes: Vec<json::Scene>,
    pub textures: Vec<json::Texture>,
}

impl Document {
    /// Parses a file's bytes.
    pub fn parse(file: &Path, bytes: &[u8], notices: &mut Vec<String>) -> Result<Self> {
        let container = container::split(file, bytes)?;
        let mut root = parse_root(file, &container)?;
        check_version(file, &root)?;
        check_extensions(file, &root, notices)?;
        for (list, notice) in IGNORED_LISTS {
            if root.get(list).is_some_and(|list| list.as_array().is_none_or(|list| !list.is_empty())) {
                notices.push(notice.to_owned());
            }
        }

        let mut extensions = root.remove("extensions").unwrap_or_default();
        let mut lists_of = |name: &str| match extensions.get_mut(name).map(Value::take) {
            Some(Value::Object(lists)) => lists,
            _ => Map::new(),
        };
        let mut lights = lists_of("KHR_lights_punctual");
        let mut ambients = lists_of(ambient::EXTENSION);
        let scene = match root.remove("scene") {
            Some(scene) => Some(
                serde_json::from_value(scene)
                    .map_err(|error| broken(file, "scene", &format!("is no index of a scene ({error})")))?,
            ),
            None => None,
        };
        let chosen = scene.map_or(0, |scene: Index<json::Scene>| scene.value());
        let pointer = format!("/{chosen}/extensions/{}", ambient::EXTENSION);
        let ambient_reference = root.get("scenes").and_then(|scenes| scenes.pointer(&pointer)).cloned();
        Ok(Document {
            file: file.to_owned(),
            bin: container.bin.map(<[u8]>::to_vec),
            scene,
            accessors: list(file, &mut root, "accessors", "accessor")?,
            buffers: list(file, &mut root, "buffers", "buffer")?,
            views: list(file, &mut root, "bufferViews", "buffer view")?,
            cameras: list(file, &mut root, "cameras", "camera")?,
            images: list(file, &mut root, "images", "image")?,
            lights: list(file, &mut lights, "lights", "light")?,
            ambients: list(file, &mut ambients, "lights", "image-based light")?,
            ambient_reference,
            materials: list(file, &mut root, "materials", "material")?,
            meshes: list(file, &mut root, "meshes", "mesh")?,
            nodes: list(file, &mut root, "nodes", "node")?,
            samplers: list(file, &mut root, "samplers", "sampler")?,
            scenes: list(file, &mut root, "scenes", "scene")?,
            textures: list(file, &mut root, "textures", "texture")?,
        })
    }

    /// An input error of this file.
    pub fn error(&self, object: impl Into<String>, problem: impl Into<String>, mend: impl Into<String>) -> Error {
        Error::input(&self.file, object, problem, mend)
    }

    /// The object behind an index that `by` holds; `kind` is what the list holds.
    pub fn lookup<'a, T>(&self, list: &'a [T], index: Index<T>, kind: &str, by: &str) -> Result<&'a T> {
        list.get(index.value()).ok_or_else(|| {
            let count = list.len();
            self.error(
                by,
                format!("refers to {kind} {}, but the file has {count} of them", index.value()),
                format!("correct the index, or export the file again with that {kind}"),
            )
        })
    }

    /// "material 2 'wall'".
    pub fn material_label(&self, index: usize) -> String {
        label("material", index, self.materials.get(index).and_then(|material| material.name.as_deref()))
    }

    /// "mesh 0 'Torus'".
    pub fn mesh_label(&self, index: usize) -> String {
        label("mesh", index, self.meshes.get(index).and_then(|mesh| mesh.name.as_deref()))
    }

    /// "node 3 'tower'".
    pub fn node_label(&self, index: usize) -> String {
        label("node", index, self.nodes.get(index).and_then(|node| node.name.as_deref()))
    }
}

/// How messages name an object: kind, index, and its name if it has one.
pub(super) fn label(kind: &str, index: usize, name: Option<&str>) -> String {
    match name {
        Some(name) if !name.is_empty() => format!("{kind} {index} '{name}'"),
        _ => format!("{kind} {index}"),
    }
}

fn broken(file: &Path, object: &str, problem: &str) -> Error {
    Error::input(file, object, problem, "correct it, or export the file again")
}

fn parse_root(file: &Path, container: &container::Container) -> Result<Map<String, Value>> {
    let object = container.json_object;
    match serde_json::from_slice(container.json) {
        Ok(Value::Object(root)) => Ok(root),
        Ok(_) => Err(broken(file, object, "is no glTF: its top level is no object")),
        Err(error) if error.classify() == Category::Eof => {
            Err(broken(file, object, &format!("ends too early ({error})")))
        }
        Err(error) => Err(broken(file, object, &format!("is not valid JSON ({error})"))),
    }
}

fn check_version(file: &Path, root: &Map<String, Value>) -> Result<()> {
    let Some(asset) = root.get("asset") else {
        return Err(broken(file, "JSON", "is no glTF: it has no 'asset'"));
    };
    let Some(version) = asset.get("version").and_then(Value::as_str) else {
        return Err(broken(file, "asset", "has no 'version'"));
    };
    // `minVersion` is what a reader must know; without it any reader of the same major version will do.
    let needed = asset.get("minVersion").and_then(Value::as_str);
    let readable = match needed {
        Some(needed) => needed == "2.0",
        None => version == "2" || version.starts_with("2."),
    };
    if readable {
        return Ok(());
    }
    Err(Error::input(
        file,
        "asset",
        format!("asks for glTF {}, but 2.0 is read", needed.unwrap_or(version)),
        "export the file as glTF 2.0",
    ))
}

fn check_extensions(file: &Path, root: &Map<String, Value>, notices: &mut Vec<String>) -> Result<()> {
    for name in strings(file, root, "extensionsRequired")? {
        if !KNOWN_EXTENSIONS.contains(&name) {
            return Err(Error::input(
                file,
                "extensionsRequired",
                format!("asks for '{name}', which is not supported"),
                format!("export the file without {name}; supported: {}", KNOWN_EXTENSIONS.join(", ")),
            ));
        }
    }
    for name in strings(file, root, "extensionsUsed")? {
        // What is read of image-based lights is told where it is read.
        if !KNOWN_EXTENSIONS.contains(&name) && name != ambient::EXTENSION {
            notices.push(format!("extension '{name}' is not supported and was ignored"));
        }
    }
    Ok(())
}

fn strings<'a>(file: &Path, root: &'a Map<String, Value>, key: &str) -> Result<Vec<&'a str>> {
    match root.get(key) {
        None => Ok(Vec::new()),
        Some(value) => value
            .as_array()
            .and_then(|list| list.iter().map(Value::as_str).collect())
            .ok_or_else(|| broken(file, key, "is no list of names")),
    }
}

fn list<T: DeserializeOwned>(file: &Path, root: &mut Map<String, Value>, key: &str, kind: &str) -> Result<Vec<T>> {
    let entries = match root.remove(key) {
        None => return Ok(Vec::new()),
        Some(Value::Array(entries)) => entries,
        Some(_) => return Err(broken(file, key, "is no list")),
    };
    let parse = |(index, entry): (usize, Value)| {
        let name = entry.get("name").and_then(Value::as_str).map(str::to_owned);
        serde_json::from_value(entry).map_err(|error| {
            broken(file, &label(kind, index, name.as_deref()), &format!("cannot be understood ({error})"))
        })
    };
    entries.into_iter().enumerate().map(parse).collect()
}
