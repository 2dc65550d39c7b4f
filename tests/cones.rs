//! Cone maps: what `prism bake` writes, and the marches `cone` and `relaxed-cone` against the f64 reference.

mod common;

use std::{fs, path::Path};

use common::{Frame, Gltf, Map, Wrap, asset, draw, folder, prism};
use glam::DVec2;
use image::DynamicImage;
use prism_engine::{
    measure::Metrics,
    scene::{self, HeightMap},
    shell::{
        cones::{ConeKind, by_all_pairs},
        reference::{Reference, Shadows},
    },
};

const SIZE: [u32; 2] = [160, 120];

/// Bakes `map` and returns the folder with what came out.
fn bake(map: &Map, words: &str) -> tempfile::TempDir {
    let folder = folder();
    fs::write(folder.path().join("in.png"), map.png()).expect("writes");
    let outcome = prism("bake").words(words).within(folder.path()).succeeds();
    assert_eq!(outcome.stdout, "", "{outcome}");
    folder
}

/// Texels of an OpenEXR's part: its size and a channel.
fn channel(path: &Path, part: usize, name: &str) -> ((usize, usize), Vec<f32>) {
    use exr::prelude::*;
    let image = read_all_flat_layers_from_file(path).expect("an OpenEXR");
    let layer = &image.layer_data[part];
    let found = layer.channel_data.list.iter().find(|channel| channel.name == *name).expect("the channel");
    let FlatSamples::F32(samples) = &found.sample_data else { panic!("{name} is not f32") };
    ((layer.size.0, layer.size.1), samples.clone())
}

#[test]
fn baked_cones_are_those_of_the_definition() {
    let map = Map::noise(14, 9);
    for (kind, word) in [(ConeKind::Plain, "cone"), (ConeKind::Relaxed, "relaxed-cone")] {
        for (wrap, mode) in [(scene::Wrap::Repeat, "repeat"), (scene::Wrap::Clamp, "clamp")] {
            let folder = bake(&map, &format!("{word} in.png out.png --wrap {mode} --validation sync"));
            let heights = HeightMap::read(&folder.path().join("in.png")).expect("a height map");
            let defined = by_all_pairs(&heights, [wrap; 2], kind);
            let image = image::open(folder.path().join("out.png")).expect("a PNG");
            let DynamicImage::ImageRgb16(image) = image else { panic!("not 16-bit RGB: {:?}", image.color()) };
            assert_eq!(image.dimensions(), (14, 9));
            for ((x, y, texel), root) in image.enumerate_pixels().zip(&defined) {
                assert_eq!(f64::from(texel[0]) / 65535.0, heights.height(x, y));
                assert!(
                    texel[1] <= *root && f64::from(texel[1]) >= f64::from(*root) * 0.9998 - 2.0,
                    "{texel:?}, {root}"
                );
                assert_eq!(texel[2], 0);
            }
        }
    }
    // The same as floats.
    let folder = bake(&map, "cone in.png out.exr");
    let heights = HeightMap::read(&folder.path().join("in.png")).expect("a height map");
    let (size, ratios) = channel(&folder.path().join("out.exr"), 0, "cone.R");
    assert_eq!(size, (14, 9));
    for (ratio, root) in ratios.iter().zip(by_all_pairs(&heights, [scene::Wrap::Repeat; 2], ConeKind::Plain)) {
        let defined = (f32::from(root) / 65535.0).powi(2);
        assert!(*ratio <= defined * 1.000_001 && *ratio >= defined * 0.999, "{ratio}, {defined}");
    }
}

#[test]
fn a_baked_pyramid_bounds_the_heights_between_its_texels() {
    let map = Map::noise(12, 7);
    let folder = bake(&map, "minmax in.png out.exr --wrap mirror");
    let out = folder.path().join("out.exr");
    for level in 0..4 {
        let (size, least) = channel(&out, level, "min");
        let (_, most) = channel(&out, level, "max");
        for (i, (least, most)) in least.iter().zip(&most).enumerate() {
            let node = [i % size.0, i / size.0].map(|k| (k << level) as f64);
            let span = f64::from(1 << level);
            for (x, y) in (0..=4).flat_map(|y| (0..=4).map(move |x| (x, y))) {
                let texel = DVec2::from(node) + DVec2::new(f64::from(x), f64::from(y)) * 0.25 * span;
                let h = map.at((texel + 0.5) / DVec2::new(12.0, 7.0), [Wrap::Mirror; 2]);
                assert!(
                    f64::from(*least) <= h + 1e-6 && f64::from(*most) >= h - 1e-6,
                    "level {level} node {node:?}: {h}"
                );
            }
        }
    }
}

#[test]
fn what_cannot_be_baked_is_told() {
    let folder = folder();
    fs::write(folder.path().join("in.png"), Map::noise(4, 4).png()).expect("writes");
    fs::write(folder.path().join("text.png"), "no picture").expect("writes");
    for (words, code, told) in [
        ("", 2, "KIND"),
        ("cube in.png out.png", 2, "cube"),
        ("cone in.png", 2, "OUT"),
        ("cone in.png out.jpg", 2, ".png or .exr"),
        ("minmax in.png out.png", 2, ".exr"),
        ("cone in.png out.png --wrap once", 2, "once"),
        ("cone none.png out.png", 1, "none.png"),
        ("cone text.png out.png", 1, "text.png"),
        ("cone in.png no/out.png", 1, "no/out.png"),
    ] {
        let outcome = prism("bake").words(words).within(folder.path()).run().ends(code);
        assert!(outcome.stdout.is_empty() && outcome.stderr.contains(told), "{outcome}");
    }
    // No bar where stderr is no terminal, and nothing half written.
    assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 2);
}

/// Draws `scene` with each set of flags and compares it with the reference; prints and returns the figures.
fn compare(name: &str, scene: &Path, eye: Option<[[f64; 3]; 2]>, flags: &[&str]) -> Vec<Metrics> {
    let folder = folder();
    let loaded = scene::load(scene).expect("a scene");
    let mut camera = loaded.camera.expect("a camera");
    let mut view = String::new();
    if let Some([eye, target]) = eye {
        camera = camera.overridden(Some(eye.into()), Some(target.into()), None).expect("a camera");
        let point = |p: [f64; 3]| p.map(|c| c.to_string()).join(",");
        view = format!("--eye {} --target {}", point(eye), point(target));
    }
    let truth = Reference::new(&loaded).render(&camera, SIZE[0], SIZE[1], Shadows::Skip);
    let figures = |flags: &&str| {
        let words = format!("--size {}x{} {view} {flags} --aov frame.exr", SIZE[0], SIZE[1]);
        draw("render", scene).words(&words).within(folder.path()).succeeds();
        let m = Metrics::between(&Frame::read(&folder.path().join("frame.exr")).aov(), &truth, &camera);
        println!(
            "{name} {flags}: {} pixels; coverage differs {:.1e}; depth p50 {:.1e}, p99 {:.1e} footprints, above 1: {:.1e}",
            m.covered, m.coverage_differs, m.depth_p50, m.depth_p99, m.depth_above_1
        );
        assert!(m.covered > 2000 && m.nan_count == 0, "{m:?}");
        m
    };
    flags.iter().map(figures).collect()
}

/// On a plane the tangent plane is the surface: with steps enough the cones end at the first hit, however rough the map.
#[test]
fn on_a_plane_cones_find_the_first_hit() {
    let folder = folder();
    let mut rough = Gltf::sheet(&Map::noise(24, 24));
    rough.set("/materials/0/extras/displacement/midlevel", 1.0.into());
    let rough = rough.write(folder.path());
    let flags = ["cone", "relaxed-cone --refine-steps 24"].map(|m| format!("--shell off --march {m} --max-steps 1000"));
    let flags = [&*flags[0], &*flags[1], "--shell off --march relief --min-steps 64 --max-steps 64"];
    for (name, scene, eye) in [
        ("rough", &rough, [[0.3, -0.9, 0.55], [0.0, -0.1, 0.0]]),
        ("bricks", &asset("plane.gltf"), [[0.2, 0.35, 0.6], [0.0, 0.0, 0.0]]),
    ] {
        let [plain, relaxed, relief] = compare(name, scene, Some(eye), &flags)[..] else { unreachable!() };
        for m in [plain, relaxed] {
            // The ray's slope is known as well as screen derivatives tell it.
            assert!(m.depth_p99 <= 2e-3 && m.depth_above_1 <= 3e-4, "{name}: {m:?}");
        }
        // The scene is one that steps get wrong.
        assert!(name != "rough" || relief.depth_above_1 > 10.0 * plain.depth_above_1.max(1e-4), "{relief:?}");
    }
}

/// In a shell the path's chords stray by an eighth of a texel at most: 99 % of the pixels are within a tenth of one.
#[test]
fn in_a_shell_cones_are_within_a_tenth_of_a_pixel() {
    let ways = [
        "--shell prism --stage mesh --march cone",
        "--shell prism --stage geometry --march relaxed-cone --refine-steps 16",
        "--shell walk --stage mesh --march relaxed-cone --refine-steps 16",
        "--shell walk --stage geometry --march cone",
    ];
    for m in compare("torus", &asset("torus.gltf"), None, &ways) {
        assert!(m.coverage_differs <= 2e-3 && m.depth_p99 <= 0.1 && m.depth_above_1 <= 2e-3, "{m:?}");
    }
}

/// A function's heights have no texels to stand cones on.
#[test]
fn functions_have_no_cones() {
    for flags in ["--march cone", "--shell off --march relaxed-cone"] {
        let outcome = draw("render", asset("procedural.gltf")).words(flags).within(folder().path()).run().ends(2);
        assert!(outcome.stderr.contains("march") && outcome.stderr.contains("function"), "{outcome}");
    }
}
