//! Materials, textures and images that must be refused by name, or passed over with a notice.

use image::{DynamicImage, ImageFormat};
use serde_json::{Value, json};

use super::{Folder, Gltf, assert_fails, data_uri, encode, grey_png};
use crate::scene::load;

/// The displaced quad with one field of its request changed.
fn displaced(field: &str, value: Value) -> Gltf {
    let mut gltf = Gltf::quad();
    gltf.set(&format!("/materials/0/extras/displacement/{field}"), value);
    gltf
}

#[test]
fn requests_of_the_wrong_type() {
    let wall = "material 0 'wall'";
    for (field, value) in [
        ("scale", json!("0.1")),
        ("scale", json!(null)),
        ("midlevel", json!([0.5])),
        ("relative", json!(1)),
        ("border", json!(true)),
        ("texture", json!(0)),
        ("texture", json!({ "index": "0" })),
        ("texture", json!({ "index": -1 })),
        ("texture", json!({ "index": 0, "texCoord": 0.5 })),
        ("texture", json!({ "index": 0, "extensions": [] })),
        ("procedural", json!(7)),
    ] {
        displaced(field, value.clone()).fails(wall, &format!("its extras.displacement.{field}"));
    }
    Gltf::quad().set("/materials/0/extras/displacement", json!("much")).fails(wall, "displacement is \"much\"");
}

#[test]
fn requests_that_make_no_sense() {
    let wall = "material 0 'wall'";
    displaced("scale", json!(-0.1)).fails(wall, "scale is -0.1, below zero");
    displaced("border", json!("fence")).fails(wall, "border is 'fence'");
    displaced("procedural", json!("bricks")).fails(wall, "both 'texture' and 'procedural'");
    Gltf::quad().remove("/materials/0/extras/displacement/scale").fails(wall, "has no 'scale'");
    Gltf::quad().remove("/materials/0/extras/displacement/texture").fails(wall, "neither 'texture' nor");
    Gltf::quad().remove("/materials/0/extras/displacement/texture/index").fails(wall, "has no 'index'");
    let mut procedural = displaced("procedural", json!("brick"));
    procedural.remove("/materials/0/extras/displacement/texture");
    let problem = "procedural is 'brick', but the height functions are \"bricks\", \"cobbles\", \"waves\"";
    procedural.fails(wall, problem);
    procedural.set("/materials/0/extras/displacement/procedural", json!("bricks"));
    procedural.set("/materials/0/extras/displacement/texCoord", json!(2)).fails(wall, "reads TEXCOORD_2");
    procedural.set("/materials/0/extras/displacement/texCoord", json!("1")).fails(wall, "displacement.texCoord");
    procedural.set("/materials/0/extras/displacement/texCoord", json!(1)).fails("mesh 0 'Quad'", "has no TEXCOORD_1");
    displaced("texture", json!({ "index": 0, "texCoord": 2 })).fails(wall, "reads TEXCOORD_2");
    let transformed =
        |transform| displaced("texture", json!({ "index": 0, "extensions": { "KHR_texture_transform": transform } }));
    transformed(json!({ "texCoord": 3 })).fails(wall, "reads TEXCOORD_3");
    transformed(json!({ "scale": [1] })).fails(wall, "a broken KHR_texture_transform");
    transformed(json!({ "scale": [1e39, 1] })).fails(wall, "not finite");
}

#[test]
fn a_specular_extension_that_is_broken() {
    let specular = |name: &str, value| {
        let mut gltf = Gltf::quad();
        gltf.set("/materials/0/extensions", json!({ "KHR_materials_specular": { name: value } }));
        gltf
    };
    let wall = "material 0 'wall'";
    specular("specularTexture", json!({ "index": 9 })).fails(wall, "refers to texture 9");
    specular("specularColorTexture", json!({ "index": 0, "texCoord": 2 })).fails(wall, "reads TEXCOORD_2");
    specular("specularFactor", json!(1e39)).fails(wall, "specularFactor is not finite");
    specular("specularFactor", json!("high")).fails(wall, "high");
}

#[test]
fn numbers_beyond_all_bounds() {
    // serde_json's own values cannot hold these, so the text is edited.
    let text = String::from_utf8(displaced("midlevel", json!(0.125)).text()).expect("JSON is UTF-8");
    let text = text.replace("0.125", "1e999");
    let loaded = super::from_bytes(std::path::Path::new("test.gltf"), text.as_bytes());
    assert_fails(loaded, "JSON", "number out of range");
}

#[test]
fn unknown_keys_are_told() {
    displaced("texCoord", json!(1)).notes("material 0 'wall': extras.displacement.texCoord is not known");
    displaced("tiles", json!(3)).notes("material 0 'wall': extras.displacement.tiles is not known");
    displaced("texture", json!({ "index": 0, "scale": 2 })).notes("extras.displacement.texture.scale is not known");
    displaced("texture", json!({ "index": 0, "extensions": { "X": {} } })).notes("texture.extensions.X is not known");
    Gltf::quad().set("/materials/0/alphaMode", json!("BLEND")).notes("BLEND is not supported, it is drawn opaque");
}

#[test]
fn material_factors_and_modes() {
    let wall = "material 0 'wall'";
    Gltf::plain().set("/materials/0/alphaMode", json!("GLASS")).fails(wall, "alphaMode is none");
    Gltf::plain().set("/materials/0/emissiveFactor", json!([1e39, 0, 0])).fails(wall, "emissiveFactor is not finite");
    Gltf::plain()
        .set("/materials/0/pbrMetallicRoughness", json!({ "roughnessFactor": 1e39 }))
        .fails(wall, "roughnessFactor is not finite");
    Gltf::plain()
        .set("/materials/0/normalTexture", json!({ "index": 0, "texCoord": 5 }))
        .fails(wall, "its normal texture reads TEXCOORD_5");
    Gltf::plain()
        .set("/materials/0/occlusionTexture", json!({ "index": 4 }))
        .fails("material 0 'wall', occlusion texture", "refers to texture 4");
}

#[test]
fn textures_and_samplers() {
    displaced("texture/index", json!(3)).fails("material 0 'wall', displacement texture", "refers to texture 3");
    Gltf::quad().set("/textures/0", json!({ "name": "t" })).fails("texture 0 't'", "has no 'source'");
    Gltf::quad().set("/textures/0/source", json!(8)).fails("texture 0", "refers to image 8");
    Gltf::quad().set("/textures/0/sampler", json!(0)).fails("texture 0", "refers to sampler 0");
    let sampled = |sampler| {
        let mut gltf = Gltf::quad();
        gltf.set("/samplers", json!([sampler])).set("/textures/0/sampler", json!(0));
        gltf
    };
    sampled(json!({ "wrapS": 3 })).fails("sampler 0", "wrapS is none");
    sampled(json!({ "wrapT": 3 })).fails("sampler 0", "wrapT is none");
    sampled(json!({ "magFilter": 9987 })).fails("sampler 0", "magFilter is none");
    sampled(json!({ "minFilter": 1 })).fails("sampler 0", "minFilter is none");
}

#[test]
fn images_that_are_none() {
    let with = |bytes: &[u8]| {
        let mut gltf = Gltf::quad();
        gltf.set("/images/0/uri", json!(data_uri(bytes)));
        gltf
    };
    let png = grey_png(&(0..200).collect::<Vec<u8>>());
    for length in 9..png.len() - 12 {
        with(&png[..length]).fails("image 0 'steps'", "cannot be decoded");
    }
    with(b"no image").fails("image 0 'steps'", "is no image that is known");
    with(&[]).fails("image 0 'steps'", "is no image that is known");
    for offset in [20, 45] {
        let mut damaged = png.clone();
        damaged[offset] ^= 0x55;
        with(&damaged).fails("image 0 'steps'", "cannot be decoded");
    }
    let jpeg = encode(&DynamicImage::new_rgb8(4, 4), ImageFormat::Jpeg);
    with(&jpeg).fails("image 0 'steps'", "is Jpeg, which cannot be read as a height map");
    Gltf::quad().set("/images/0", json!({})).fails("image 0", "has neither 'uri' nor 'bufferView'");
    Gltf::quad().set("/images/0", json!({ "bufferView": 44 })).fails("image 0", "refers to buffer view 44");
}

#[test]
fn a_decompression_bomb() {
    let mut png = grey_png(&[0, 0]);
    // The header's width; its check sum follows 13 bytes of content and is computed over type and content.
    png[16..20].copy_from_slice(&60_000_u32.to_be_bytes());
    let crc = crc(&png[12..29]);
    png[29..33].copy_from_slice(&crc.to_be_bytes());
    let mut gltf = Gltf::quad();
    gltf.set("/images/0/uri", json!(data_uri(&png)));
    gltf.fails("image 0 'steps'", "cannot be decoded");
    let Err(crate::error::Error::Input { mend, .. }) = gltf.load() else { panic!("refused above") };
    assert!(mend.contains("at most 32768 texels"), "{mend}");
}

fn crc(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| crc >> 1 ^ if crc & 1 == 1 { 0xEDB8_8320 } else { 0 })
    })
}

#[test]
fn image_files_outside_or_missing() {
    let folder = Folder::new();
    folder.write("secret.png", &grey_png(&[0, 0]));
    let mut gltf = Gltf::quad();
    for (uri, object, problem) in [
        ("../secret.png", "image 0 'secret.png'", "leaves the scene's folder"),
        ("maps/gone.png", "image 0 'gone.png'", "cannot be read"),
    ] {
        gltf.set("/images/0/uri", json!(uri));
        assert_fails(load(&folder.write("scene/scene.gltf", &gltf.text())), object, problem);
    }
}
