//! Accessors and meshes that must be refused by name, or passed over with a notice.

use serde_json::json;

use super::Gltf;

#[test]
fn accessors_out_of_their_range() {
    let out = "reads out of its range";
    Gltf::plain().set("/accessors/0/count", json!(5)).fails("accessor 0 (positions of mesh 0 'Quad' primitive 0)", out);
    Gltf::plain().set("/accessors/0/byteOffset", json!(1)).fails("accessor 0", out);
    Gltf::plain().set("/accessors/0/byteOffset", json!(u64::MAX)).fails("accessor 0", out);
    Gltf::plain().set("/accessors/3/count", json!(u64::MAX)).fails("accessor 3 (indices of", out);
    Gltf::plain().set("/bufferViews/0/byteStride", json!(16)).fails("accessor 0", out);
    Gltf::plain().set("/bufferViews/0/byteStride", json!(4)).fails("accessor 0", "stride is 4");
    Gltf::plain().set("/bufferViews/0/byteStride", json!(u32::MAX)).fails("accessor 0", "stride is");
    Gltf::plain().set("/accessors/0/bufferView", json!(9)).fails("accessor 0", "refers to buffer view 9");
    let attributes = "/meshes/0/primitives/0/attributes";
    Gltf::plain()
        .set(&format!("{attributes}/NORMAL"), json!(77))
        .fails("normals of mesh 0 'Quad' primitive 0", "refers to accessor 77");
    Gltf::plain().set("/accessors/0/count", json!(0)).fails("accessor 0", "count of 0");
    Gltf::plain()
        .remove("/accessors/0/bufferView")
        .set("/accessors/0/count", json!(1_u64 << 50))
        .fails("accessor 0", "no buffer view");
}

#[test]
fn accessors_of_the_wrong_type() {
    Gltf::plain().set("/accessors/0/type", json!("VEC2")).fails("accessor 0", "holds Vec2");
    Gltf::plain().set("/accessors/0/type", json!("VEC5")).fails("accessor 0", "type that glTF does not know");
    Gltf::plain().set("/accessors/0/componentType", json!(5123)).fails("accessor 0", "components of type U16");
    Gltf::plain().set("/accessors/0/componentType", json!(1)).fails("accessor 0", "componentType that glTF");
    Gltf::plain().set("/accessors/3/componentType", json!(5126)).fails("accessor 3", "components of type F32");
    Gltf::plain()
        .set("/accessors/2/componentType", json!(5123))
        .fails("accessor 2 (TEXCOORD_0 of mesh 0 'Quad' primitive 0)", "not normalized");
}

/// The quad with one sparse position.
fn sparse(indices: &[u16], count: usize) -> Gltf {
    let mut gltf = Gltf::plain();
    let bytes: Vec<u8> = indices.iter().flat_map(|i| i.to_le_bytes()).collect();
    let indices = gltf.view(&bytes);
    let values = gltf.view(&[2.0_f32, 3.0, 4.0].map(f32::to_le_bytes).concat());
    gltf.set(
        "/accessors/0/sparse",
        json!({
            "count": count,
            "indices": { "bufferView": indices, "componentType": 5123 },
            "values": { "bufferView": values },
        }),
    );
    gltf
}

#[test]
fn sparse_accessors_are_read_and_checked() {
    let scene = sparse(&[2], 1).loads();
    assert_eq!(scene.meshes[0].primitives[0].positions[2].to_array(), [2.0, 3.0, 4.0]);
    sparse(&[4], 1).fails("accessor 0", "its sparse indices name element 4, it has 4");
    sparse(&[2], 2).fails("accessor 0", "its sparse indices reach past the end");
    sparse(&[2, 3], 2).fails("accessor 0", "its sparse values reach past the end");
    sparse(&[2], usize::MAX).fails("accessor 0", "reach past the end");
    let mut gltf = sparse(&[2], 1);
    gltf.set("/accessors/0/sparse/indices/componentType", json!(5126)).fails("accessor 0", "no unsigned integer");
    let mut gltf = sparse(&[2], 1);
    gltf.set("/accessors/0/sparse/values/bufferView", json!(99)).fails("accessor 0", "refers to buffer view 99");
    // Without a buffer view the other elements are zero: both triangles lose their area.
    let mut gltf = sparse(&[2], 1);
    gltf.remove("/accessors/0/bufferView").notes("has no triangles");
}

#[test]
fn numbers_that_are_none() {
    for value in [f32::NAN, f32::INFINITY] {
        Gltf::plain().poke(0, 4, value).fails("accessor 0 (positions of", "element 1 is not finite");
        Gltf::plain().poke(1, 3, value).fails("accessor 1 (normals of", "element 1 is not finite");
        Gltf::plain().poke(2, 2, value).fails("accessor 2 (TEXCOORD_0 of", "element 1 is not finite");
    }
}

#[test]
fn vectors_without_length() {
    Gltf::plain()
        .poke(1, 5, 0.0)
        .fails("accessor 1 (normals of mesh 0 'Quad' primitive 0)", "element 1 has length zero");
    let mut gltf = Gltf::plain();
    let tangents = gltf.floats("VEC4", &[[1.0, 0.0, 0.0, 1.0]; 4]);
    gltf.set("/meshes/0/primitives/0/attributes/TANGENT", json!(tangents)).loads();
    gltf.clone().poke(tangents, 0, 0.0).fails("accessor 4 (tangents of", "element 0 has length zero");
    gltf.clone().poke(tangents, 3, 0.5).fails("accessor 4 (tangents of", "a w other than");
}

#[test]
fn indices_and_counts() {
    let mut gltf = Gltf::plain();
    let past = gltf.indices(&[0, 1, 4]);
    gltf.set("/meshes/0/primitives/0/indices", json!(past));
    gltf.fails("accessor 4 (indices of mesh 0 'Quad' primitive 0)", "element 2 is 4, past the end of 4 vertices");
    let mut gltf = Gltf::plain();
    let odd = gltf.indices(&[0, 1, 2, 3]);
    gltf.set("/meshes/0/primitives/0/indices", json!(odd)).fails("mesh 0 'Quad' primitive 0", "no multiple of three");
    let mut gltf = Gltf::plain();
    let few = gltf.floats("VEC3", &[[0.0, 0.0, 1.0]; 3]);
    gltf.set("/meshes/0/primitives/0/attributes/NORMAL", json!(few));
    gltf.fails("accessor 4 (normals of", "has 3 elements for 4 positions");
    Gltf::plain().set("/meshes/0/primitives/0/mode", json!(9)).fails("mesh 0 'Quad' primitive 0", "mode is none");
    Gltf::plain().set("/meshes/0/primitives/0/material", json!(9)).fails("primitive 0", "refers to material 9");
}

#[test]
fn displaced_without_coordinates() {
    Gltf::quad()
        .remove("/meshes/0/primitives/0/attributes/TEXCOORD_0")
        .fails("mesh 0 'Quad' primitive 0", "has no TEXCOORD_0, which the displacement of material 'wall' reads");
    let mut gltf = Gltf::quad();
    let point = gltf.floats("VEC2", &[[0.5, 0.5]; 4]);
    gltf.set("/meshes/0/primitives/0/attributes/TEXCOORD_0", json!(point)).loads();
    gltf.set("/materials/0/extras/displacement/relative", json!(true));
    gltf.fails("mesh 0 'Quad' primitive 0", "covers no area");
}

#[test]
fn what_is_passed_over_is_told() {
    Gltf::plain().set("/meshes/0/primitives/0/mode", json!(1)).notes("points and lines are not drawn");
    Gltf::plain().remove("/meshes/0/primitives/0/attributes/POSITION").notes("has no positions");
    let mut gltf = Gltf::plain();
    let degenerate = gltf.indices(&[0, 1, 2, 0, 1, 1]);
    gltf.set("/meshes/0/primitives/0/indices", json!(degenerate));
    let scene = gltf.notes("1 triangle(s) without area were left out");
    assert_eq!(scene.meshes[0].primitives[0].triangles, [[0, 1, 2]]);
    let scene = Gltf::plain().set("/nodes/0/scale", json!([0, 0, 0])).notes("its scale is 0");
    assert!(scene.instances.is_empty() && scene.bounds().is_none());
    Gltf::plain().set("/meshes/0/primitives/0/targets", json!([{ "POSITION": 0 }])).notes("morph targets are ignored");
    Gltf::plain().set("/skins", json!([{ "joints": [0] }])).notes("skins are ignored");
    Gltf::plain().set("/animations", json!([{ "channels": [], "samplers": [] }])).notes("animations are ignored");
    Gltf::plain().set("/extensionsUsed", json!(["KHR_materials_clearcoat"])).notes("'KHR_materials_clearcoat'");
    let mut gltf = Gltf::plain();
    let colours = gltf.floats("VEC3", &[[1.0, 1.0, 1.0]; 4]);
    gltf.set("/meshes/0/primitives/0/attributes/COLOR_0", json!(colours)).notes("vertex colours are ignored");
    let mut gltf = Gltf::plain();
    gltf.remove("/meshes/0/primitives/0/attributes/TEXCOORD_0")
        .set("/materials/0/normalTexture", json!({ "index": 0 }))
        .notes("its textures are read at (0, 0)");
}
