//! Flags that give displaced materials other values draw what a file with these values draws.

mod common;

use std::path::Path;

use common::{Frame, Gltf, Lens, Map, Shape, Wrap, draw, folder};
use prism_engine::{
    measure::Metrics,
    scene::{self, Adjustment, HeightFormat},
    shell::reference::{Reference, Shadows},
};
use serde_json::json;

const SIZE: &str = "--size 96x72";

/// A sheet over a noisy map, turned around or not.
fn sheet(flipped: bool, wrap: Wrap, displacement: serde_json::Value) -> Gltf {
    let texels = (0..48u16).map(|i| i.wrapping_mul(40503) ^ 0x5a5a);
    let texels: Vec<u16> = texels.map(|texel| if flipped { u16::MAX - texel } else { texel }).collect();
    sheet_of(&Map::sixteen(8, &texels), wrap, displacement)
}

fn sheet_of(map: &Map, wrap: Wrap, displacement: serde_json::Value) -> Gltf {
    let mut gltf = Gltf::new();
    let material = gltf.displaced("sheet", map, [wrap; 2], displacement);
    let mesh = gltf.mesh("Sheet", &Shape::sheet(1.0, [-0.2, 0.1], [1.4, 1.2]), material);
    gltf.node(json!({ "mesh": mesh }));
    gltf.camera(&Lens::at([0.9, -1.6, 1.4], [0.0, 0.0, 0.0]));
    gltf
}

fn frame(scene: &Path, flags: &str) -> Frame {
    let folder = folder();
    draw("render", scene).words(&format!("{SIZE} {flags} --aov frame.exr")).within(folder.path()).succeeds();
    Frame::read(&folder.path().join("frame.exr"))
}

#[test]
fn flags_draw_what_a_file_of_these_values_draws() {
    let folder = folder();
    let (from, to) = (folder.path().join("from"), folder.path().join("to"));
    for path in [&from, &to] {
        std::fs::create_dir(path).expect("a folder");
    }
    let plain = sheet(false, Wrap::Repeat, json!({ "scale": 0.2, "midlevel": 0.5 })).write(&from);
    let mut wanted = sheet(true, Wrap::Mirror, json!({ "scale": 0.4, "midlevel": 0.75, "relative": true }));
    wanted.set(
        "/materials/0/extras/displacement/texture/extensions",
        json!({ "KHR_texture_transform": { "scale": [2.0, 0.5], "offset": [0.25, -0.125] } }),
    );
    wanted.set("/extensionsUsed", json!(["KHR_texture_transform"]));
    let wanted = wanted.write(&to);
    let flags = "--height-flip on --wrap mirror --height-scale 0.4 --relative on --midlevel 0.75 --uv-scale 2,0.5 \
                 --uv-offset 0.25,-0.125";
    for way in ["--shell walk", "--shell prism --march relief", "--shell off"] {
        let (asked, there) = (frame(&plain, &format!("{way} {flags}")), frame(&wanted, way));
        let (asked, there) = (asked.aov(), there.aov());
        let covered = there.depth.iter().filter(|depth| depth.is_finite()).count();
        assert!(covered > 1000, "{way}: {covered} pixels");
        // A flipped 16-bit texel is one in f32 too but for its last bits.
        let off = |i: usize| there.depth[i] != asked.depth[i] && (there.depth[i] - asked.depth[i]).abs() >= 1e-4;
        let wrong = (0..there.depth.len()).filter(|&i| off(i)).count();
        println!("{way}: {covered} pixels, {wrong} differ");
        assert!(wrong <= 2, "{way}: {wrong} pixels differ");
        if way != "--shell walk" {
            continue;
        }
        let unasked = frame(&plain, way).aov();
        let changed = (0..there.depth.len()).filter(|&i| unasked.depth[i] != there.depth[i]).count();
        assert!(changed > 1000, "the flags are to change something");
    }
}

/// A border of zeros and the second mip, against maps that have them texel by texel.
#[test]
fn borders_and_mips_are_those_of_a_map_that_has_them() {
    let texel = |x: u16, y: u16| (y * 8 + x).wrapping_mul(40503) ^ 0x5a5a;
    let all = |width: u16, height: u16| (0..height).flat_map(move |y| (0..width).map(move |x| (x, y)));
    let map = Map::sixteen(8, &all(8, 6).map(|(x, y)| texel(x, y)).collect::<Vec<_>>());
    // Eight texels of margin: more than the sheet shows.
    let within = |x: u16, y: u16| if (8..16).contains(&x) && (8..14).contains(&y) { texel(x - 8, y - 8) } else { 0 };
    let margin = Map::sixteen(24, &all(24, 22).map(|(x, y)| within(x, y)).collect::<Vec<_>>());
    let mean = |x: u16, y: u16| {
        let four = all(2, 2).map(|(i, j)| u32::from(texel(2 * x + i, 2 * y + j))).sum::<u32>();
        ((f64::from(four) / 4.0).round()) as u16
    };
    let mip = Map::sixteen(4, &all(4, 3).map(|(x, y)| mean(x, y)).collect::<Vec<_>>());
    let displacement = || json!({ "scale": 0.3, "midlevel": 0.25 });
    for (flags, map_with, wrap, scale, offset) in [
        ("--wrap border", &margin, Wrap::Clamp, [8.0 / 24.0, 6.0 / 22.0], [8.0 / 24.0, 8.0 / 22.0]),
        ("--height-lod 1", &mip, Wrap::Repeat, [1.0; 2], [0.0; 2]),
    ] {
        let folder = folder();
        let (from, to) = (folder.path().join("from"), folder.path().join("to"));
        for path in [&from, &to] {
            std::fs::create_dir(path).expect("a folder");
        }
        let plain = sheet_of(&map, Wrap::Repeat, displacement()).write(&from);
        let mut wanted = sheet_of(map_with, wrap, displacement());
        wanted.set(
            "/materials/0/extras/displacement/texture/extensions",
            json!({ "KHR_texture_transform": { "scale": scale, "offset": offset } }),
        );
        wanted.set("/extensionsUsed", json!(["KHR_texture_transform"]));
        let wanted = wanted.write(&to);
        for way in ["--shell prism --march pom", "--shell off --march secant"] {
            let [asked, there, unasked] = [(&plain, flags), (&wanted, ""), (&plain, "")]
                .map(|(scene, flags)| frame(scene, &format!("{way} {flags}")).aov());
            let differs = |a: f32, b: f32| a != b && (a - b).abs() >= 1e-4;
            let count = |other: &[f32]| (0..other.len()).filter(|&i| differs(other[i], asked.depth[i])).count();
            let (wrong, changed) = (count(&there.depth), count(&unasked.depth));
            println!("{way} {flags}: {wrong} pixels differ, {changed} by the flag");
            assert!(wrong <= 4 && changed > 1000, "{way} {flags}: {wrong} differ, {changed} by the flag");
        }
    }
}

/// A texture of one colour.
fn texture(gltf: &mut Gltf, colour: [u8; 4]) -> usize {
    let mut png = std::io::Cursor::new(Vec::new());
    let image = image::RgbaImage::from_pixel(1, 1, image::Rgba(colour));
    image.write_to(&mut png, image::ImageFormat::Png).expect("a PNG");
    let view = gltf.view(&png.into_inner());
    let image = gltf.push("images", json!({ "bufferView": view, "mimeType": "image/png" }));
    gltf.push("textures", json!({ "source": image }))
}

/// Roughness and metallic from any channel, against a file that has them where glTF wants them.
#[test]
fn channels_are_those_asked_for() {
    let folder = folder();
    let coloured = |name: &str, colour: [u8; 4]| {
        let path = folder.path().join(name);
        std::fs::create_dir(&path).expect("a folder");
        let mut gltf = sheet(false, Wrap::Repeat, json!({ "scale": 0.2 }));
        let texture = texture(&mut gltf, colour);
        gltf.set("/materials/0/pbrMetallicRoughness", json!({ "metallicRoughnessTexture": { "index": texture } }));
        gltf.write(&path)
    };
    let (ours, theirs) = (coloured("ours", [90, 20, 250, 200]), coloured("theirs", [0, 200, 90, 0]));
    for way in ["--shell prism", "--shell off --march pom"] {
        let asked = frame(&ours, &format!("{way} --roughness-channel a --metallic-channel r")).aov();
        let (there, unasked) = (frame(&theirs, way).aov(), frame(&ours, way).aov());
        let differ = |a: &[[f32; 3]], b: &[[f32; 3]]| a.iter().zip(b).filter(|(a, b)| a != b).count();
        let (wrong, changed) = (differ(&asked.color, &there.color), differ(&asked.color, &unasked.color));
        println!("{way}: {wrong} pixels differ, {changed} by the flags");
        assert!(wrong == 0 && changed > 1000, "{way}: {wrong} differ, {changed} by the flags");
    }
}

/// KHR_materials_specular: what reflects nothing is lit diffusely alone, each texture stands for its factor, metal has no
/// use for either.
#[test]
fn specular_is_what_the_file_or_the_flag_says() {
    let folder = folder();
    let mut files = 0;
    let mut scene = |colour: [f32; 3], metallic: f32, specular: Option<[u8; 4]>, extension: serde_json::Value| {
        let path = folder.path().join(files.to_string());
        files += 1;
        std::fs::create_dir(&path).expect("a folder");
        let mut gltf = sheet(false, Wrap::Repeat, json!({ "scale": 0.2 }));
        let [r, g, b] = colour;
        let pbr = json!({ "baseColorFactor": [r, g, b, 1], "metallicFactor": metallic, "roughnessFactor": 0.6 });
        gltf.set("/materials/0/pbrMetallicRoughness", pbr);
        gltf.set("/materials/0/extensions", json!({ "KHR_materials_specular": extension }));
        if let Some(colour) = specular {
            let texture = texture(&mut gltf, colour);
            gltf.set("/materials/0/extensions/KHR_materials_specular/specularTexture", json!({ "index": texture }));
            gltf.set(
                "/materials/0/extensions/KHR_materials_specular/specularColorTexture",
                json!({ "index": texture }),
            );
        }
        gltf.write(&path)
    };
    const GREY: [f32; 3] = [0.5; 3];
    let plain = scene(GREY, 0.0, None, json!({}));
    let matt = scene(GREY, 0.0, None, json!({ "specularFactor": 0 }));
    // 51 / 255 is 0.2; of colours 255 is 1 and 0 is 0.
    let mapped = scene(GREY, 0.0, Some([255, 0, 255, 51]), json!({ "specularColorFactor": [8, 1, 2] }));
    let factors = scene(GREY, 0.0, None, json!({ "specularFactor": 0.2, "specularColorFactor": [8, 0, 2] }));
    let black = scene([0.0; 3], 0.0, None, json!({ "specularFactor": 0 }));
    let metals = [json!({}), json!({ "specularFactor": 0.2, "specularColorFactor": [8, 0, 2] })]
        .map(|extension| scene(GREY, 1.0, None, extension));
    for way in ["--shell prism", "--shell off --march pom"] {
        let colors = |scene, flags: &str| frame(scene, &format!("{way} {flags}")).aov().color;
        let differing = |a: &[[f32; 3]], b: &[[f32; 3]]| {
            a.iter().flatten().zip(b.iter().flatten()).filter(|(a, b)| (*a - *b).abs() > 1e-6).count()
        };
        let (shown, dull) = (colors(&plain, ""), colors(&plain, "--specular 0"));
        let changed = differing(&shown, &dull);
        assert!(changed > 1000, "{way}: {changed} values changed");
        assert_eq!(differing(&dull, &colors(&matt, "")), 0, "{way}: the flag and the factor");
        let dark = colors(&black, "");
        assert!(dark.iter().flatten().all(|value| *value == 0.0), "{way}: black that reflects nothing is lit");
        let (mapped, factors) = (colors(&mapped, ""), colors(&factors, ""));
        assert_eq!(differing(&mapped, &factors), 0, "{way}: the textures and the factors");
        // Of the colour (8, 0, 2) nothing is reflected in green at normal incidence, and more in red than in blue; the
        // few pixels that only the sky lights have its colour.
        let right = factors.iter().filter(|[r, g, b]| r > b && b > g).count();
        let lit = factors.iter().filter(|color| color.iter().any(|value| *value > 0.0)).count();
        assert!(right > 1000 && right * 100 > lit * 99, "{way}: {right} pixels of {lit} have its colour");
        let [metal, changed] = metals.each_ref().map(|scene| colors(scene, ""));
        assert_eq!(metal, changed, "{way}: metal");
    }
}

/// Where nothing of the sky is seen, direct light goes by the share that is asked for.
#[test]
fn occlusion_dims_direct_light_by_its_share() {
    let folder = folder();
    let mut gltf = sheet(false, Wrap::Repeat, json!({ "scale": 0.2 }));
    let texture = texture(&mut gltf, [0, 255, 255, 255]);
    gltf.set("/materials/0/occlusionTexture", json!({ "index": texture }));
    let scene = gltf.write(folder.path());
    for way in ["--shell prism", "--shell off --march pom"] {
        let [none, half, all] =
            ["0", "0.5", "1"].map(|share| frame(&scene, &format!("{way} --occlusion-light {share}")).aov());
        let lit: Vec<usize> = (0..none.color.len()).filter(|&i| none.color[i][0] > 0.01).collect();
        let halved = |i: &&usize| (half.color[**i][0] - 0.5 * none.color[**i][0]).abs() < 1e-3 * none.color[**i][0];
        let halves = lit.iter().filter(halved).count();
        assert!(lit.len() > 1000 && halves == lit.len(), "{way}: {halves} of {}", lit.len());
        assert!(lit.iter().all(|&i| all.color[i] == [0.0; 3]), "{way}: light where none is left");
    }
    gltf.remove("/materials/0/occlusionTexture");
    let scene = gltf.write(folder.path());
    let refused = draw("render", &scene).words("--occlusion-light 1").within(folder.path()).run().ends(2);
    refused.complains(&["--occlusion-light", "occlusion"]);
}

/// The surface of half floats is that of the rounded texels, in the reference too, and as far from the file's as they say.
#[test]
fn half_floats_are_rounded_once() {
    let folder = folder();
    let scene = sheet(false, Wrap::Repeat, json!({ "scale": 0.2, "midlevel": 0.5 })).write(folder.path());
    let mut loaded = scene::load(&scene).expect("a scene");
    let camera = loaded.camera.expect("a camera");
    loaded.adjust(&Adjustment { height_format: HeightFormat::R16F, ..Adjustment::default() }).expect("adjusted");
    let truth = Reference::new(&loaded).render(&camera, 96, 72, Shadows::Skip);
    for way in ["--shell prism", "--shell prism --march cone"] {
        let [half, kept] =
            ["r16f", "auto"].map(|format| frame(&scene, &format!("{way} --height-format {format}")).aov());
        let m = Metrics::between(&half, &truth, &camera);
        let both = (0..half.depth.len()).filter(|&i| half.depth[i].is_finite() && kept.depth[i].is_finite());
        let moved: Vec<f32> = both.map(|i| (half.depth[i] - kept.depth[i]).abs()).collect();
        let most = moved.iter().copied().fold(0.0, f32::max);
        println!("{way}: depth p99 {:.1e} footprints; moved by {most:.1e} at most", m.depth_p99);
        assert!(m.depth_p99 < 2e-3 && m.coverage_differs <= 1.0 / m.covered as f64, "{way}: {m:?}");
        // 0.2 / 4096 along the normal; more along rays that graze.
        assert!(most > 1e-5 && most < 20.0 * 0.2 / 4096.0, "{way}: {most}");
    }
}

#[test]
fn what_cannot_be_adjusted_is_refused() {
    let folder = folder();
    let mut gltf = sheet(false, Wrap::Repeat, json!({ "scale": 0.2 }));
    gltf.remove("/materials/0/extras/displacement/texture");
    gltf.set("/materials/0/extras/displacement/procedural", json!("bricks"));
    let scene = gltf.write(folder.path());
    for flags in ["--height-flip on", "--wrap border", "--height-lod 2", "--height-format r16f"] {
        let refused = draw("render", &scene).words(flags).within(folder.path()).run().ends(1);
        refused.complains(&["sheet", "function"]);
    }
    draw("render", &scene).words("--size 16x16 --midlevel 1").within(folder.path()).succeeds();
    gltf.remove("/materials/0/extras");
    let scene = gltf.write(folder.path());
    draw("render", &scene).words("--midlevel 1").within(folder.path()).run().ends(1).complains(&["displacement"]);
}

#[test]
fn the_sun_and_its_strength_follow_their_flags() {
    let folder = folder();
    let scene = sheet(false, Wrap::Repeat, json!({ "scale": 0.2 })).write(folder.path());
    let colours = |flags: &str| frame(&scene, &format!("--shell off --march normal {flags}")).aov().color;
    let near = |a: &[[f32; 3]], b: &[[f32; 3]]| {
        a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
    };
    let plain = colours("");
    assert!(plain.iter().flatten().any(|value| *value > 0.1));
    // A scene without a light gets one that comes from (-0.4, 1, 0.6).
    let around = f64::atan2(-0.4, 0.6).to_degrees();
    let above = (1.0 / (0.4f64 * 0.4 + 1.0 + 0.6 * 0.6).sqrt()).asin().to_degrees();
    let told = colours(&format!("--sun {around},{above}"));
    assert!(near(&plain, &told) < 1e-5, "{}", near(&plain, &told));
    let behind = colours("--sun 180,0");
    assert!(near(&plain, &behind) > 0.05, "{}", near(&plain, &behind));
    // What the sky gives stays, what the light gives is as strong as it is.
    let dark = colours("--light-intensity 0");
    assert!(near(&dark, &behind) < 0.02, "{}", near(&dark, &behind));
    let triple = colours("--light-intensity 3");
    let expected: Vec<[f32; 3]> =
        plain.iter().zip(&dark).map(|(p, d)| std::array::from_fn(|k| d[k] + 3.0 * (p[k] - d[k]))).collect();
    assert!(near(&triple, &expected) < 1e-4, "{}", near(&triple, &expected));
}
