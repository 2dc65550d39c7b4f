//! Damaged files: whatever the bytes, loading returns. The generator is seeded, so a failure repeats.

use std::path::Path;

use serde_json::json;

use super::{Gltf, from_bytes};

/// Marsaglia's xorshift, enough to spread damage.
struct Random(u64);

impl Random {
    fn below(&mut self, bound: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % bound as u64) as usize
    }
}

/// A scene that touches every part of the importer, as GLB.
fn victim() -> Vec<u8> {
    let mut gltf = Gltf::quad();
    let png = super::grey_png(&[9, 80, 200, 31, 7, 8]);
    let image = gltf.view(&png);
    let indices = gltf.view(&[1, 0]);
    let values = gltf.view(&[1.5_f32, 0.25, 0.125].map(f32::to_le_bytes).concat());
    gltf.set("/images/0", json!({ "bufferView": image, "mimeType": "image/png" }))
        .set("/textures/0/sampler", json!(0))
        .set("/samplers", json!([{ "wrapS": 33071, "magFilter": 9728, "minFilter": 9984 }]))
        .set(
            "/accessors/0/sparse",
            json!({
                "count": 1,
                "indices": { "bufferView": indices, "componentType": 5123 },
                "values": { "bufferView": values },
            }),
        )
        .set(
            "/materials/0/normalTexture",
            json!({
                "index": 0, "scale": 0.5, "extensions": { "KHR_texture_transform": { "rotation": 1, "scale": [2, 3] } },
            }),
        )
        .set("/materials/0/extras/displacement/relative", json!(true))
        .set(
            "/nodes",
            json!([
                { "mesh": 0, "children": [1, 2], "rotation": [0, 0.6, 0, 0.8] },
                { "camera": 0, "translation": [0, 1, 2] },
                { "extensions": { "KHR_lights_punctual": { "light": 0 } }, "scale": [1, 2, 3], "mesh": 0 },
            ]),
        )
        .set("/cameras", json!([{ "type": "perspective", "perspective": { "yfov": 0.7, "znear": 0.1 } }]))
        .set("/extensions", json!({ "KHR_lights_punctual": { "lights": [{ "type": "spot", "spot": {} }] } }));
    gltf.glb()
}

/// Loads, and uses what came out of it; panics are the failure.
fn survive(bytes: &[u8]) -> bool {
    match from_bytes(Path::new("fuzz.glb"), bytes) {
        Ok(scene) => {
            let scene = scene.with_defaults(1.5);
            assert!(scene.meshes.iter().flat_map(|mesh| &mesh.shell_normals).all(|normal| normal.is_finite()));
            true
        }
        Err(error) => {
            assert!(!error.to_string().is_empty());
            false
        }
    }
}

#[test]
fn damaged_bytes_never_panic() {
    let victim = victim();
    assert!(survive(&victim), "the undamaged file loads");
    let mut random = Random(0x9E37_79B9_7F4A_7C15);
    let mut loaded = 0;
    for _ in 0..6000 {
        let mut bytes = victim.clone();
        for _ in 0..=random.below(4) {
            let at = random.below(bytes.len());
            bytes[at] = match random.below(4) {
                0 => bytes[at] ^ 1 << random.below(8),
                1 => random.below(256) as u8,
                2 => b"0123456789-e[]{},\":"[random.below(19)],
                _ => 0xFF,
            };
        }
        loaded += usize::from(survive(&bytes));
    }
    // Both outcomes must be common, or the damage misses the point.
    assert!((100..5900).contains(&loaded), "{loaded} of 6000 loaded");
}

#[test]
fn truncated_files_never_panic() {
    let victim = victim();
    for length in 0..victim.len() {
        let mut bytes = victim[..length].to_vec();
        assert!(!survive(&bytes), "{length} bytes of {} load", victim.len());
        // Once more with a header that admits the length, to reach the parsers behind it.
        if length >= 12 {
            bytes[8..12].copy_from_slice(&(length as u32).to_le_bytes());
            survive(&bytes);
        }
    }
}
