//! glTF files written by hand.

use std::{
    fs,
    path::{Path, PathBuf},
};

use serde_json::{Value, json};

use super::{Lens, Map, Wrap};

/// Triangles with normals and one UV set.
#[derive(Clone, Debug, Default)]
pub struct Shape {
    pub positions: Vec<[f32; 3]>,
    pub normals: Vec<[f32; 3]>,
    pub uvs: Vec<[f32; 2]>,
    pub triangles: Vec<[u32; 3]>,
}

impl Shape {
    /// A square in z = 0 that faces +Z, from -half to +half; UV from `from` at the top left to `to` at the bottom right.
    pub fn sheet(half: f32, from: [f32; 2], to: [f32; 2]) -> Shape {
        let mut shape = Shape::default();
        shape.face([-half, half, 0.0], [2.0 * half, 0.0, 0.0], [0.0, -2.0 * half, 0.0], [0.0, 0.0, 1.0], from, to);
        shape
    }

    /// A cube with hard edges: 24 vertices, UV 0 to 1 on each face.
    pub fn cube(half: f32) -> Shape {
        let mut shape = Shape::default();
        for axis in 0..3 {
            for sign in [1.0f32, -1.0] {
                let unit = |axis: usize, length: f32| {
                    let mut v = [0.0; 3];
                    v[axis % 3] = length;
                    v
                };
                // right × up is the outward normal on both sides, so that fronts stay counter-clockwise.
                let normal = unit(axis, sign);
                let (right, down) = (unit(axis + 1, sign * 2.0 * half), unit(axis + 2, -2.0 * half));
                let corner = std::array::from_fn(|i| half * normal[i] - (right[i] + down[i]) / 2.0);
                shape.face(corner, right, down, normal, [0.0, 0.0], [1.0, 1.0]);
            }
        }
        shape
    }

    fn face(
        &mut self,
        corner: [f32; 3],
        right: [f32; 3],
        down: [f32; 3],
        normal: [f32; 3],
        from: [f32; 2],
        to: [f32; 2],
    ) {
        let first = self.positions.len() as u32;
        for (a, b) in [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)] {
            self.positions.push(std::array::from_fn(|i| corner[i] + a * right[i] + b * down[i]));
            self.normals.push(normal);
            self.uvs.push([from[0] + a * (to[0] - from[0]), from[1] + b * (to[1] - from[1])]);
        }
        self.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    }
}

/// A glTF file in the making: its JSON, and the bytes of its buffer.
#[derive(Clone, Debug)]
pub struct Gltf {
    pub json: Value,
    pub bytes: Vec<u8>,
}

impl Gltf {
    /// A scene without nodes.
    pub fn new() -> Gltf {
        let json = json!({ "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [] }] });
        Gltf { json, bytes: Vec::new() }
    }

    /// A sheet from -1 to 1 with UV 0 to 1 and a displacement of 0.2, seen straight on from 3 units: nodes 'tile' and
    /// 'camera', mesh 'Sheet', material 'wall', image 'steps'; accessors 0 to 3 are positions, normals, UVs, indices.
    pub fn sheet(map: &Map) -> Gltf {
        let mut gltf = Gltf::new();
        let wall = gltf.displaced("wall", map, [Wrap::Repeat; 2], json!({ "scale": 0.2 }));
        let mesh = gltf.mesh("Sheet", &Shape::sheet(1.0, [0.0, 0.0], [1.0, 1.0]), wall);
        gltf.node(json!({ "name": "tile", "mesh": mesh }));
        gltf.camera(&Lens::at([0.0, 0.0, 3.0], [0.0; 3]));
        gltf
    }

    /// Appends to one of the file's lists; returns the index.
    pub fn push(&mut self, list: &str, value: Value) -> usize {
        let root = self.json.as_object_mut().expect("an object");
        let list = root.entry(list).or_insert_with(|| json!([])).as_array_mut().expect("a list");
        list.push(value);
        list.len() - 1
    }

    /// Sets what a JSON pointer names; its last part may be new.
    pub fn set(&mut self, pointer: &str, value: Value) -> &mut Self {
        let (parent, key) = pointer.rsplit_once('/').expect("a pointer");
        match self.json.pointer_mut(parent).unwrap_or_else(|| panic!("{parent} is not there")) {
            Value::Array(list) => list[key.parse::<usize>().expect("an index")] = value,
            object => object[key] = value,
        }
        self
    }

    /// Removes what a JSON pointer names.
    pub fn remove(&mut self, pointer: &str) -> &mut Self {
        let (parent, key) = pointer.rsplit_once('/').expect("a pointer");
        let object = self.json.pointer_mut(parent).and_then(Value::as_object_mut).expect("an object");
        object.remove(key).unwrap_or_else(|| panic!("{pointer} is not there"));
        self
    }

    /// A buffer view over new bytes.
    pub fn view(&mut self, bytes: &[u8]) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let offset = self.bytes.len();
        self.bytes.extend_from_slice(bytes);
        self.push("bufferViews", json!({ "buffer": 0, "byteOffset": offset, "byteLength": bytes.len() }))
    }

    /// An accessor over new vectors of floats.
    pub fn floats<const N: usize>(&mut self, values: &[[f32; N]]) -> usize {
        let bytes: Vec<u8> = values.iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
        let bound = |fold: fn(f32, f32) -> f32| -> Vec<f32> {
            (0..N).map(|i| values.iter().map(|v| v[i]).reduce(fold).unwrap_or(0.0)).collect()
        };
        let (min, max) = (bound(f32::min), bound(f32::max));
        let view = self.view(&bytes);
        self.push(
            "accessors",
            json!({ "bufferView": view, "componentType": 5126, "count": values.len(), "type": format!("VEC{N}"),
                "min": min, "max": max }),
        )
    }

    /// Overwrites one float of an accessor that has a view of its own.
    pub fn poke(&mut self, accessor: usize, float: usize, value: f32) -> &mut Self {
        let view = self.json["accessors"][accessor]["bufferView"].as_u64().expect("a view") as usize;
        let offset = self.json["bufferViews"][view]["byteOffset"].as_u64().expect("an offset") as usize + 4 * float;
        self.bytes[offset..offset + 4].copy_from_slice(&value.to_le_bytes());
        self
    }

    /// A mesh of one primitive.
    pub fn mesh(&mut self, name: &str, shape: &Shape, material: usize) -> usize {
        let (positions, normals) = (self.floats(&shape.positions), self.floats(&shape.normals));
        let uvs = self.floats(&shape.uvs);
        let bytes: Vec<u8> = shape.triangles.iter().flatten().flat_map(|i| i.to_le_bytes()).collect();
        let view = self.view(&bytes);
        let count = 3 * shape.triangles.len();
        let indices = self
            .push("accessors", json!({ "bufferView": view, "componentType": 5125, "count": count, "type": "SCALAR" }));
        let attributes = json!({ "POSITION": positions, "NORMAL": normals, "TEXCOORD_0": uvs });
        let primitive = json!({ "attributes": attributes, "indices": indices, "material": material });
        self.push("meshes", json!({ "name": name, "primitives": [primitive] }))
    }

    /// A material displaced by `map`; `displacement` is the extras' entry without its texture.
    pub fn displaced(&mut self, name: &str, map: &Map, wrap: [Wrap; 2], mut displacement: Value) -> usize {
        let view = self.view(&map.png());
        let image = self.push("images", json!({ "name": "steps", "bufferView": view, "mimeType": "image/png" }));
        let sampler = self.push("samplers", json!({ "wrapS": wrap[0] as u32, "wrapT": wrap[1] as u32 }));
        let texture = self.push("textures", json!({ "source": image, "sampler": sampler }));
        displacement["texture"] = json!({ "index": texture, "texCoord": 0 });
        self.push("materials", json!({ "name": name, "extras": { "displacement": displacement } }))
    }

    /// A material without displacement.
    pub fn plain(&mut self, name: &str) -> usize {
        self.push("materials", json!({ "name": name }))
    }

    /// A node of the scene.
    pub fn node(&mut self, node: Value) -> usize {
        let index = self.push("nodes", node);
        self.json["scenes"][0]["nodes"].as_array_mut().expect("a list").push(json!(index));
        index
    }

    /// The camera, and its node.
    pub fn camera(&mut self, lens: &Lens) -> usize {
        let camera = self.push("cameras", lens.camera());
        self.node(lens.node(camera))
    }

    /// Writes `scene.glb`.
    pub fn write(&self, folder: &Path) -> PathBuf {
        let mut json = self.json.clone();
        json["buffers"] = json!([{ "byteLength": self.bytes.len() }]);
        let mut text = json.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let mut binary = self.bytes.clone();
        binary.resize(binary.len().next_multiple_of(4), 0);
        let mut file = Vec::new();
        let word = |file: &mut Vec<u8>, value: usize| file.extend((value as u32).to_le_bytes());
        file.extend(b"glTF");
        word(&mut file, 2);
        word(&mut file, 12 + 8 + text.len() + 8 + binary.len());
        for (chunk, kind) in [(text, b"JSON"), (binary, b"BIN\0")] {
            word(&mut file, chunk.len());
            file.extend(kind);
            file.extend(chunk);
        }
        let path = folder.join("scene.glb");
        fs::write(&path, file).expect("the scene");
        path
    }

    /// Writes `scene.gltf` and `scene.bin`; an image may name its file by `uri`.
    pub fn write_text(&self, folder: &Path) -> PathBuf {
        let mut json = self.json.clone();
        if json.get("buffers").is_none() {
            json["buffers"] = json!([{ "byteLength": self.bytes.len(), "uri": "scene.bin" }]);
        }
        fs::write(folder.join("scene.bin"), &self.bytes).expect("the buffer");
        let path = folder.join("scene.gltf");
        fs::write(&path, serde_json::to_vec_pretty(&json).expect("a value")).expect("the scene");
        path
    }
}
