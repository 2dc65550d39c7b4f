//! Files that load, and what comes out of them.

use std::path::Path;

use glam::{DVec2, DVec3, Vec2, Vec3};
use image::{DynamicImage, ImageBuffer, ImageFormat, Luma, Rgb};
use serde_json::json;

use super::{Folder, Gltf, data_uri, encode, from_bytes, grey_png};
use crate::scene::{HeightSource, HeightTexels, LightKind, Procedure, Projection, Wrap, load};

#[test]
fn the_quad_in_both_containers() {
    let gltf = Gltf::quad();
    for scene in [gltf.loads(), from_bytes(Path::new("a.glb"), &gltf.glb()).expect("the same as GLB")] {
        assert_eq!(scene.notices, [""; 0]);
        let mesh = &scene.meshes[0];
        assert_eq!((mesh.name.as_str(), mesh.primitives.len()), ("Quad", 1));
        let quad = &mesh.primitives[0];
        assert_eq!(quad.triangles, [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(quad.positions[2], Vec3::new(1.0, 1.0, 0.0));
        assert_eq!(quad.normals, [Vec3::Z; 4]);
        assert_eq!(quad.uvs[0][0], Vec2::Y);
        assert!(quad.uvs[1].is_empty());
        assert_eq!(quad.tangents, [glam::Vec4::new(1.0, 0.0, 0.0, 1.0); 4]);
        assert_eq!(mesh.shell_normals, [DVec3::Z; 4]);
        assert_eq!(quad.displacement_scale, 0.5);
        let displacement = scene.materials[0].displacement.expect("displaced");
        assert_eq!((displacement.midlevel, displacement.border_wall, displacement.relative), (0.5, false, false));
        assert_eq!(displacement.source, HeightSource::Map(0));
        let map = &scene.height_maps[0];
        assert_eq!((map.name.as_str(), map.width, map.height), ("steps", 2, 2));
        assert_eq!((map.height(1, 0), map.height(0, 1), map.min_max()), (0.2, 0.4, (0.0, 1.0)));
        assert_eq!(scene.instances.len(), 1);
        assert_eq!(scene.instances[0].name, "tile");
        assert!(scene.camera.is_none() && scene.lights.is_empty() && scene.images.is_empty());
        let (low, high) = scene.bounds().expect("something is drawn");
        assert_eq!((low, high), (DVec3::new(0.0, 0.0, -0.25), DVec3::new(1.0, 1.0, 0.25)));
    }
}

#[test]
fn files_beside_the_scene() {
    let folder = Folder::new();
    let mut gltf = Gltf::quad();
    folder.write("scene/maps/the steps.png", &grey_png(&[1, 2]));
    folder.write("scene/maps/mesh.bin", &gltf.bytes);
    let buffer = json!({ "byteLength": gltf.bytes.len(), "uri": "./maps/mesh.bin" });
    gltf.set("/images/0/uri", json!("maps/../maps/the%20steps.png")).set("/buffers/0", buffer);
    let scene = load(&folder.write("scene/scene.gltf", &gltf.text())).expect("its files are there");
    assert_eq!(scene.height_maps[0].name, "the steps.png");
}

#[test]
fn defaults_are_added_and_told() {
    let scene = Gltf::quad().loads().with_defaults(1.0);
    assert!(scene.camera.is_some());
    assert_eq!(scene.lights.len(), 1);
    assert_eq!(scene.lights[0].kind, LightKind::Directional);
    assert_eq!(scene.notices.len(), 2);
    assert!(scene.notices[1].contains("no light in the file: one directional light was added"));
}

#[test]
fn a_scene_without_anything() {
    let scene = from_bytes(Path::new("a.gltf"), br#"{"asset": {"version": "2.0"}}"#).expect("valid");
    assert!(scene.meshes.is_empty() && scene.bounds().is_none());
    assert!(scene.with_defaults(1.0).camera.is_some_and(|camera| camera.transform.is_finite()));
}

#[test]
fn one_texel_maps_and_deep_maps() {
    let mut gltf = Gltf::quad();
    let one = DynamicImage::from(ImageBuffer::from_pixel(1, 1, Luma([51_u8])));
    gltf.set("/images/0/uri", json!(data_uri(&encode(&one, ImageFormat::Png))));
    assert_eq!(gltf.loads().height_maps[0].min_max(), (0.2, 0.2));
    let deep = DynamicImage::from(ImageBuffer::from_pixel(3, 1, Rgb([0x1234_u16, 1, 2])));
    gltf.set("/images/0/uri", json!(data_uri(&encode(&deep, ImageFormat::Png))));
    assert!(matches!(&gltf.loads().height_maps[0].texels, HeightTexels::U16(texels) if *texels == [0x1234; 3]));
}

#[test]
fn wrap_modes_and_filters() {
    for (number, wrap) in [(10497, Wrap::Repeat), (33648, Wrap::Mirror), (33071, Wrap::Clamp)] {
        let mut gltf = Gltf::quad();
        gltf.set("/samplers", json!([{ "wrapT": number, "magFilter": 9728, "minFilter": 9729 }]))
            .set("/textures/0/sampler", json!(0))
            .set("/materials/0/emissiveTexture", json!({ "index": 0 }));
        let scene = gltf.loads();
        let material = &scene.materials[0];
        assert_eq!(material.displacement.expect("displaced").wrap, [Wrap::Repeat, wrap]);
        let sampler = material.emissive.expect("emissive").sampler;
        assert_eq!((sampler.wrap, sampler.nearest, sampler.no_mips), ([Wrap::Repeat, wrap], true, true));
    }
}

#[test]
fn a_procedure_reads_its_uv_set_and_no_image() {
    for procedure in Procedure::ALL {
        let mut gltf = Gltf::quad();
        let displacement = json!({ "procedural": procedure.name(), "texCoord": 1, "scale": 0.5, "relative": true });
        gltf.set("/materials/0/extras/displacement", displacement);
        // UV set 1 has a quarter of set 0's area.
        let uvs = gltf.floats("VEC2", &[[0.0, 0.5], [0.5, 0.5], [0.5, 0.0], [0.0, 0.0]]);
        gltf.set("/meshes/0/primitives/0/attributes/TEXCOORD_1", json!(uvs)).set("/images/0/uri", json!("missing.png"));
        let scene = gltf.loads();
        let displacement = scene.materials[0].displacement.expect("displaced");
        assert_eq!(displacement.source, HeightSource::Procedure(procedure));
        assert_eq!((displacement.tex_coord, displacement.wrap), (1, [Wrap::Repeat; 2]));
        assert!(scene.height_maps.is_empty() && scene.notices.is_empty(), "{:?}", scene.notices);
        assert_eq!(scene.meshes[0].primitives[0].displacement_scale, 1.0);
        assert_eq!(scene.displacement_range(&scene.meshes[0].primitives[0]), (-0.5, 0.5));
    }
}

#[test]
fn relative_scale_follows_the_areas() {
    let mut gltf = Gltf::quad();
    gltf.set("/materials/0/extras/displacement/relative", json!(true));
    // Area 1 over UV area 1.
    assert_eq!(gltf.loads().meshes[0].primitives[0].displacement_scale, 0.5);
    // UV area 1/4, one triangle mirrored: areas are absolute.
    let uvs = gltf.floats("VEC2", &[[0.0, 0.0], [0.5, 0.0], [0.5, 0.5], [1.0, 0.5]]);
    gltf.set("/meshes/0/primitives/0/attributes/TEXCOORD_0", json!(uvs));
    assert_eq!(gltf.loads().meshes[0].primitives[0].displacement_scale, 1.0);
    // A texture transform does not count.
    let transform = json!({ "KHR_texture_transform": { "scale": [9, 9] } });
    gltf.set("/materials/0/extras/displacement/texture/extensions", transform);
    assert_eq!(gltf.loads().meshes[0].primitives[0].displacement_scale, 1.0);
}

#[test]
fn the_extension_of_specular_is_read() {
    let mut gltf = Gltf::quad();
    let plain = gltf.loads().materials[0].clone();
    assert_eq!((plain.specular, plain.specular_color_factor), (1.0, Vec3::ONE));
    assert!(plain.specular_map.is_none() && plain.specular_color.is_none());
    let extension = json!({ "specularFactor": 0.25, "specularTexture": { "index": 0 }, "specularColorFactor": [2, 0.5, 0],
        "specularColorTexture": { "index": 0, "texCoord": 1 } });
    gltf.set("/materials/0/extensions", json!({ "KHR_materials_specular": extension }))
        .set("/extensionsUsed", json!(["KHR_materials_specular"]))
        .set("/extensionsRequired", json!(["KHR_materials_specular"]));
    let scene = gltf.loads();
    let material = &scene.materials[0];
    assert_eq!((material.specular, material.specular_color_factor), (0.25, Vec3::new(2.0, 0.5, 0.0)));
    let images = [material.specular_map, material.specular_color].map(|texture| texture.expect("a texture").image);
    assert_eq!(images[0], images[1], "alpha is linear in an sRGB image too");
    assert!(scene.images[images[0]].srgb);
    assert!(scene.notices.iter().all(|notice| !notice.contains("specular")), "{:?}", scene.notices);
}

#[test]
fn colour_and_data_are_stored_apart_and_once() {
    let mut gltf = Gltf::quad();
    let extension = json!({ "KHR_texture_transform": { "offset": [0.5, 0.25], "texCoord": 1 } });
    gltf.set("/materials/0/emissiveTexture", json!({ "index": 0 }))
        .set("/materials/0/pbrMetallicRoughness", json!({ "baseColorTexture": { "index": 0 } }))
        .set("/materials/0/normalTexture", json!({ "index": 0, "scale": 2, "extensions": extension }))
        .set("/materials/0/occlusionTexture", json!({ "index": 0, "strength": 0.5, "extensions": extension }));
    let scene = gltf.loads();
    let material = &scene.materials[0];
    let (normal, scale) = material.normal.expect("set");
    let (occlusion, strength) = material.occlusion.expect("set");
    assert_eq!((scale, strength), (2.0, 0.5));
    assert_eq!(scene.images.len(), 2);
    assert!(scene.images[material.base_color.expect("set").image].srgb);
    assert_eq!(material.base_color.expect("set").image, material.emissive.expect("set").image);
    assert!(!scene.images[normal.image].srgb);
    for texture in [normal, occlusion] {
        assert_eq!(texture.tex_coord, 1, "the extension replaces the set");
        assert_eq!(texture.transform.transform_point2(DVec2::ZERO), DVec2::new(0.5, 0.25));
    }
    assert_eq!(scene.images[0].rgba.len(), 16);
}

#[test]
fn what_the_scene_does_not_use_is_not_read() {
    let mut gltf = Gltf::plain();
    gltf.push("/meshes", json!({ "primitives": [{ "attributes": { "POSITION": 99 }, "material": 1 }] }));
    gltf.push("/materials", json!({ "name": "unused", "emissiveTexture": { "index": 5 } }));
    gltf.push("/nodes", json!({ "mesh": 1 }));
    let scene = gltf.loads();
    assert_eq!((scene.meshes.len(), scene.materials.len(), scene.instances.len()), (2, 2, 1));
    assert!(scene.meshes[1].primitives.is_empty());
    // Without any scene every node counts.
    gltf.remove("/scene").remove("/scenes").fails("material 1 'unused'", "refers to texture 5");
}

#[test]
fn primitives_without_normals_are_flat_and_without_material_get_one() {
    let mut gltf = Gltf::quad();
    gltf.remove("/meshes/0/primitives/0/attributes/NORMAL").remove("/meshes/0/primitives/0/material");
    let scene = gltf.loads();
    let quad = &scene.meshes[0].primitives[0];
    assert_eq!(quad.normals, [Vec3::Z; 6]);
    assert_eq!(quad.triangles, [[0, 1, 2], [3, 4, 5]]);
    assert_eq!(quad.uvs[0].len(), 6);
    assert_eq!(scene.meshes[0].shell_normals.len(), 4, "flat corners are welded again");
    assert_eq!(quad.material, 1);
    assert_eq!(scene.materials[1].name, "default material");
}

#[test]
fn strips_and_fans_without_indices() {
    for (mode, triangles) in [(5, [[0, 1, 2], [1, 3, 2]]), (6, [[1, 2, 0], [2, 3, 0]])] {
        let mut gltf = Gltf::plain();
        gltf.remove("/meshes/0/primitives/0/indices").set("/meshes/0/primitives/0/mode", json!(mode));
        assert_eq!(gltf.loads().meshes[0].primitives[0].triangles, triangles);
    }
}

#[test]
fn coordinates_in_integers_and_strides() {
    let mut gltf = Gltf::plain();
    // Four texture coordinates of two normalized bytes, each followed by two bytes of something else.
    let bytes = [0, 255, 7, 7, 255, 255, 7, 7, 255, 0, 7, 7, 51, 0];
    let uvs = gltf.accessor("VEC2", 5121, 4, &bytes);
    gltf.set("/bufferViews/4/byteStride", json!(4)).set(&format!("/accessors/{uvs}/normalized"), json!(true));
    gltf.set("/meshes/0/primitives/0/attributes/TEXCOORD_1", json!(uvs));
    let scene = gltf.loads();
    assert_eq!(scene.meshes[0].primitives[0].uvs[1][3], Vec2::new(0.2, 0.0));
}

#[test]
fn transforms_are_composed_depth_first() {
    let mut gltf = Gltf::plain();
    gltf.set("/scenes/0/nodes", json!([2, 0])).set(
        "/nodes",
        json!([
            { "name": "last", "mesh": 0, "matrix": [1, 0, 0, 0, 0.5, 1, 0, 0, 0, 0, 1, 0, 7, 8, 9, 1] },
            { "name": "child", "mesh": 0, "scale": [-1, 2, 1] },
            { "name": "parent", "translation": [1, 2, 3], "children": [3, 1], "rotation": [0, 0, 2, 2] },
            { "name": "first child", "mesh": 0 },
        ]),
    );
    let scene = gltf.loads();
    let names: Vec<_> = scene.instances.iter().map(|instance| instance.name.as_str()).collect();
    assert_eq!(names, ["first child", "child", "last"]);
    let at = |i: usize| scene.instances[i].transform.transform_point3(DVec3::new(1.0, 1.0, 0.0));
    // A quarter turn about z, from a quaternion that is not normalised.
    assert!(at(0).abs_diff_eq(DVec3::new(0.0, 3.0, 3.0), 1e-12));
    assert!(at(1).abs_diff_eq(DVec3::new(-1.0, 1.0, 3.0), 1e-12));
    assert_eq!(at(2), DVec3::new(8.5, 9.0, 9.0));
}

#[test]
fn cameras_and_lights_in_the_order_of_nodes() {
    let mut gltf = Gltf::plain();
    let light = |i: u32| json!({ "KHR_lights_punctual": { "light": i } });
    gltf.set("/scenes/0/nodes", json!([2, 1, 0]))
        .set(
            "/nodes",
            json!([
                { "mesh": 0 },
                { "camera": 1, "extensions": light(1), "scale": [2, 3, -4], "translation": [1, 2, 3] },
                { "camera": 0, "extensions": light(0), "rotation": [1, 0, 0, 0] },
                { "camera": 0, "extensions": light(0) },
            ]),
        )
        .set(
            "/cameras",
            json!([
                { "type": "perspective", "perspective": { "yfov": 1, "znear": 0.1 } },
                { "type": "orthographic", "orthographic": { "xmag": 1, "ymag": 2, "znear": 0, "zfar": 9 } },
            ]),
        )
        .set(
            "/extensions",
            json!({ "KHR_lights_punctual": { "lights": [
                { "type": "directional", "intensity": 4, "color": [1, 0.5, 0], "extras": { "any": [1] } },
                { "type": "spot", "spot": { "outerConeAngle": 1.5707964 }, "range": 5 },
            ] } }),
        );
    let scene = gltf.loads();
    let camera = scene.camera.expect("two cameras");
    assert!(matches!(camera.projection, Projection::Orthographic { y_mag: 2.0, near: 0.0, far: 9.0 }));
    let basis = camera.transform.matrix3;
    assert!((basis.determinant() - 1.0).abs() < 1e-12, "scale and mirroring are gone");
    assert_eq!(basis.z_axis, DVec3::NEG_Z);
    assert_eq!(camera.transform.translation, DVec3::new(1.0, 2.0, 3.0));
    assert_eq!(scene.lights.len(), 2);
    let [spot, sun] = [scene.lights[0], scene.lights[1]];
    assert!(matches!(spot.kind, LightKind::Spot { inner: 0.0, outer } if outer == std::f64::consts::FRAC_PI_2));
    assert_eq!((spot.position, spot.direction, spot.range), (DVec3::new(1.0, 2.0, 3.0), DVec3::Z, Some(5.0)));
    assert_eq!(sun.intensity, DVec3::new(4.0, 2.0, 0.0));
    assert!(sun.direction.abs_diff_eq(DVec3::Z, 1e-12), "turned about x by half a turn");
}

/// The repository's own models, where they have been made.
#[test]
fn the_assets_load() {
    let assets = Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets");
    let Ok(entries) = std::fs::read_dir(assets) else {
        return;
    };
    for path in entries.map(|entry| entry.expect("a readable folder").path()) {
        if path.extension().is_some_and(|ending| ending == "gltf") {
            let scene = load(&path).unwrap_or_else(|error| panic!("{error}"));
            assert!(scene.bounds().is_some(), "{}", path.display());
            assert_eq!(scene.notices, [""; 0], "{}", path.display());
        }
    }
}

#[test]
fn an_image_based_light_lights_from_everywhere() {
    let mut gltf = Gltf::quad();
    // Irradiance of one everywhere: only the first harmonic, whose value is 1 / (2 sqrt(pi)).
    let constant = 2.0 * std::f64::consts::PI.sqrt();
    let mut coefficients = vec![json!([0, 0, 0]); 9];
    coefficients[0] = json!([constant, constant, constant]);
    let light = json!({ "intensity": 3.0, "irradianceCoefficients": coefficients });
    gltf.set("/extensions", json!({ "EXT_lights_image_based": { "lights": [light] } }));
    gltf.set("/extensionsUsed", json!(["EXT_lights_image_based"]));
    gltf.set("/scenes/0/extensions", json!({ "EXT_lights_image_based": { "light": 0 } }));
    let scene = gltf.loads();
    let expected = DVec3::splat(3.0 / std::f64::consts::PI);
    assert!(scene.ambient.irradiance(DVec3::Y).abs_diff_eq(expected, 1e-12));
    assert!(scene.notices.iter().any(|notice| notice.contains("specular images are not read")), "{:?}", scene.notices);
}
