//! Tests of the whole import, on glTF files written here by hand.

mod bad_files;
mod bad_geometry;
mod bad_materials;
mod fuzz;
mod good;

use std::{
    fs,
    io::Cursor,
    path::{Path, PathBuf},
    sync::atomic::{AtomicUsize, Ordering},
};

use image::{DynamicImage, ImageBuffer, ImageFormat, Luma};
use serde_json::{Value, json};

use super::{Scene, import::from_bytes};
use crate::error::{Error, Result};

/// A glTF file in the making: JSON, and the bytes of buffer 0, each accessor with a view of its own.
#[derive(Clone)]
struct Gltf {
    json: Value,
    bytes: Vec<u8>,
}

impl Gltf {
    /// Accessors 0 to 3: positions, normals, TEXCOORD_0 and indices of a unit square in z = 0, v down. Node 'tile',
    /// mesh 'Quad', material 'wall' displaced by a 2×2 map.
    fn quad() -> Self {
        let mut gltf = Gltf {
            json: json!({
                "asset": { "version": "2.0" },
                "scene": 0,
                "scenes": [{ "nodes": [0] }],
                "nodes": [{ "name": "tile", "mesh": 0 }],
                "meshes": [{ "name": "Quad", "primitives": [{
                    "attributes": { "POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2 }, "indices": 3, "material": 0,
                }] }],
                "materials": [{
                    "name": "wall",
                    "extras": { "displacement": { "texture": { "index": 0 }, "scale": 0.5 } },
                }],
                "textures": [{ "source": 0 }],
                "images": [{ "name": "steps", "uri": data_uri(&grey_png(&[0, 51, 102, 255])) }],
                "accessors": [],
                "bufferViews": [],
                "buffers": [{}],
            }),
            bytes: Vec::new(),
        };
        gltf.floats("VEC3", &[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]);
        gltf.floats("VEC3", &[[0.0, 0.0, 1.0]; 4]);
        gltf.floats("VEC2", &[[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]]);
        gltf.indices(&[0, 1, 2, 0, 2, 3]);
        gltf
    }

    /// A plain quad, whose material asks for nothing.
    fn plain() -> Self {
        let mut gltf = Gltf::quad();
        gltf.set("/materials/0", json!({ "name": "wall" }));
        gltf
    }

    /// Adds an accessor of floats and returns its index.
    fn floats<const N: usize>(&mut self, kind: &str, values: &[[f32; N]]) -> usize {
        let bytes: Vec<u8> = values.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect();
        self.accessor(kind, 5126, values.len(), &bytes)
    }

    /// Adds an accessor of 16-bit indices and returns its index.
    fn indices(&mut self, values: &[u16]) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|x| x.to_le_bytes()).collect();
        self.accessor("SCALAR", 5123, values.len(), &bytes)
    }

    fn accessor(&mut self, kind: &str, component: u32, count: usize, bytes: &[u8]) -> usize {
        let view = self.view(bytes);
        let accessor = json!({ "bufferView": view, "componentType": component, "count": count, "type": kind });
        self.push("/accessors", accessor)
    }

    /// Adds a buffer view and returns its index.
    fn view(&mut self, bytes: &[u8]) -> usize {
        let offset = self.bytes.len();
        self.bytes.extend_from_slice(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.push("/bufferViews", json!({ "buffer": 0, "byteOffset": offset, "byteLength": bytes.len() }))
    }

    fn push(&mut self, list: &str, value: Value) -> usize {
        let list = self.json.pointer_mut(list).and_then(Value::as_array_mut).expect("a list of the quad");
        list.push(value);
        list.len() - 1
    }

    /// Sets the value at a JSON pointer; its last key may be new.
    fn set(&mut self, pointer: &str, value: Value) -> &mut Self {
        let (parent, key) = pointer.rsplit_once('/').expect("a pointer");
        let parent = self.json.pointer_mut(parent).unwrap_or_else(|| panic!("nothing at {parent}"));
        match key.parse::<usize>() {
            Ok(index) if parent.is_array() => parent[index] = value,
            _ => parent[key] = value,
        }
        self
    }

    /// Removes the key at a JSON pointer.
    fn remove(&mut self, pointer: &str) -> &mut Self {
        let (parent, key) = pointer.rsplit_once('/').expect("a pointer");
        let parent = self.json.pointer_mut(parent).and_then(Value::as_object_mut).expect("an object");
        parent.remove(key).unwrap_or_else(|| panic!("nothing at {pointer}"));
        self
    }

    /// Overwrites a float of an accessor's view.
    fn poke(&mut self, accessor: usize, float: usize, value: f32) -> &mut Self {
        let view =
            &self.json["bufferViews"][self.json["accessors"][accessor]["bufferView"].as_u64().unwrap_or(0) as usize];
        let offset = view["byteOffset"].as_u64().expect("the quad's views have offsets") as usize + 4 * float;
        self.bytes[offset..offset + 4].copy_from_slice(&value.to_le_bytes());
        self
    }

    /// A `.gltf` with its buffer embedded.
    fn text(&self) -> Vec<u8> {
        let mut gltf = self.clone();
        if let Some(Value::Object(buffer)) = gltf.json.pointer_mut("/buffers/0") {
            buffer.entry("byteLength").or_insert(json!(self.bytes.len()));
            buffer.entry("uri").or_insert(json!(data_uri(&self.bytes)));
        }
        gltf.json.to_string().into_bytes()
    }

    /// A `.glb` with its buffer in the binary chunk.
    fn glb(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        json["buffers"][0]["byteLength"] = json!(self.bytes.len());
        let mut json = json.to_string().into_bytes();
        json.resize(json.len().next_multiple_of(4), b' ');
        let mut chunks = Vec::new();
        for (kind, bytes) in [(b"JSON", &json), (b"BIN\0", &self.bytes)] {
            chunks.extend((bytes.len() as u32).to_le_bytes());
            chunks.extend(kind);
            chunks.extend(bytes);
        }
        let mut glb = b"glTF\x02\0\0\0".to_vec();
        glb.extend((12 + chunks.len() as u32).to_le_bytes());
        glb.extend(chunks);
        glb
    }

    fn load(&self) -> Result<Scene> {
        from_bytes(Path::new("test.gltf"), &self.text())
    }

    #[track_caller]
    fn loads(&self) -> Scene {
        self.load().unwrap_or_else(|error| panic!("{error}"))
    }

    #[track_caller]
    fn notes(&self, notice: &str) -> Scene {
        let scene = self.loads();
        let told = scene.notices.iter().any(|told| told.contains(notice));
        assert!(told, "no notice has '{notice}': {:#?}", scene.notices);
        scene
    }

    #[track_caller]
    fn fails(&self, object: &str, problem: &str) {
        assert_fails(self.load(), object, problem);
    }
}

/// Asserts an input error by its object and a part of its problem.
#[track_caller]
fn assert_fails(result: Result<Scene>, wanted_object: &str, wanted_problem: &str) {
    match result {
        Err(Error::Input { object, problem, mend, .. }) => {
            assert!(object.contains(wanted_object), "object '{object}' lacks '{wanted_object}' ({problem})");
            assert!(problem.contains(wanted_problem), "problem '{problem}' lacks '{wanted_problem}'");
            assert!(!mend.is_empty());
        }
        Err(error) => panic!("another kind of error: {error}"),
        Ok(_) => panic!("loaded, instead of '{wanted_object}: {wanted_problem}'"),
    }
}

fn data_uri(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut uri = "data:application/octet-stream;base64,".to_owned();
    for group in bytes.chunks(3) {
        let bits = (0..3).fold(0, |bits, i| bits << 8 | u32::from(*group.get(i).unwrap_or(&0)));
        for i in 0..4 {
            let digit = DIGITS[(bits >> (18 - 6 * i) & 63) as usize];
            uri.push(if i <= group.len() { digit.into() } else { '=' });
        }
    }
    uri
}

/// An 8-bit grey PNG two texels wide.
fn grey_png(texels: &[u8]) -> Vec<u8> {
    let image = ImageBuffer::<Luma<u8>, _>::from_raw(2, texels.len() as u32 / 2, texels.to_vec());
    encode(&image.expect("rows of two").into(), ImageFormat::Png)
}

fn encode(image: &DynamicImage, format: ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    image.write_to(&mut bytes, format).expect("encodes");
    bytes.into_inner()
}

/// A folder that is removed at the end of the test.
struct Folder(PathBuf);

impl Folder {
    fn new() -> Self {
        static COUNT: AtomicUsize = AtomicUsize::new(0);
        let name = format!("prism-scene-{}-{}", std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed));
        let path = std::env::temp_dir().join(name);
        fs::create_dir_all(path.join("scene/maps")).expect("a temporary folder");
        Folder(path)
    }

    /// Writes a file below the folder and returns its path.
    fn write(&self, name: &str, bytes: &[u8]) -> PathBuf {
        let path = self.0.join(name);
        fs::write(&path, bytes).expect("a temporary file");
        path
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // What is left behind in the temporary folder does no harm.
        let _ = fs::remove_dir_all(&self.0);
    }
}
