//! Several samples a pixel: `--msaa`.

mod common;

use common::{Frame, Gltf, Lens, Map, Picture, Shape, Wrap, draw, folder};
use serde_json::json;

/// Pixels of the pictures.
const SIZE: [u32; 2] = [64, 48];
/// How much finer the reference is, each way: 16 samples a pixel.
const FINE: u32 = 4;

/// A white cube of noise that shines by itself, so that a pixel's colour tells how much of it is covered.
fn cube() -> Gltf {
    let mut gltf = Gltf::new();
    let displacement = json!({ "scale": 0.15, "midlevel": 0.5 });
    let white = gltf.displaced("white", &Map::noise(8, 8), [Wrap::Repeat; 2], displacement);
    gltf.set(&format!("/materials/{white}/emissiveFactor"), json!([1.0, 1.0, 1.0]));
    gltf.set(
        &format!("/materials/{white}/pbrMetallicRoughness"),
        json!({ "baseColorFactor": [0.0, 0.0, 0.0, 1.0], "metallicFactor": 1.0 }),
    );
    let mesh = gltf.mesh("Cube", &Shape::cube(0.5), white);
    gltf.node(json!({ "mesh": mesh }));
    gltf.camera(&Lens::at([1.4, 1.1, 1.9], [0.0; 3]));
    gltf
}

/// How much of each pixel is covered, from the picture: white over the background, both constant.
fn alpha(picture: &Picture) -> Vec<f64> {
    let linear = |byte: u8| {
        let v = f64::from(byte) / 255.0;
        if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
    };
    let red: Vec<f64> = picture.pixels.iter().map(|p| linear(p[0])).collect();
    let (behind, white) = (red[0], red[(SIZE[1] / 2 * SIZE[0] + SIZE[0] / 2) as usize]);
    assert!(white > behind + 0.5, "the cube is in the middle: {white}, background {behind}");
    red.iter().map(|v| ((v - behind) / (white - behind)).clamp(0.0, 1.0)).collect()
}

#[test]
fn a_shells_outline_is_smooth_and_surface_data_keep_one_sample() {
    let folder = folder();
    let scene = cube().write(folder.path());
    let run = |flags: &str, name: &str, size: [u32; 2]| {
        let path = |kind: &str| folder.path().join(format!("{name}.{kind}"));
        let call = draw("render", &scene).words(flags).words(&format!("--march steep --size {}x{}", size[0], size[1]));
        call.arg("--out").arg(path("png")).arg("--aov").arg(path("exr")).succeeds();
        (Picture::read(&path("png")), Frame::read(&path("exr")))
    };
    let (_, fine) = run("--shell prism", "fine", SIZE.map(|n| n * FINE));
    let depth = fine.aov().depth;
    let covered = |i: u32| {
        let (x, y) = (i % SIZE[0] * FINE, i / SIZE[0] * FINE);
        let hits =
            (0..FINE * FINE).filter(|k| depth[((y + k / FINE) * fine.width + x + k % FINE) as usize].is_finite());
        hits.count() as f64 / f64::from(FINE * FINE)
    };
    let reference: Vec<f64> = (0..SIZE[0] * SIZE[1]).map(covered).collect();
    let outline: Vec<usize> = (0..reference.len()).filter(|&i| reference[i] > 0.0 && reference[i] < 1.0).collect();
    assert!(outline.len() > 100, "{} pixels of outline", outline.len());
    let error = |picture: &Picture| {
        let alpha = alpha(picture);
        let sum: f64 = outline.iter().map(|&i| (alpha[i] - reference[i]).powi(2)).sum();
        (sum / outline.len() as f64).sqrt()
    };
    let (rough, one) = run("--shell prism --stage geometry", "one", SIZE);
    let rough = error(&rough);
    for flags in ["--shell prism --stage geometry", "--shell walk --stage mesh"] {
        let (smooth, four) = run(&format!("{flags} --msaa 4"), "four", SIZE);
        let smooth = error(&smooth);
        println!("{flags}: error of coverage on the outline {rough:.3} with 1 sample, {smooth:.3} with 4");
        assert!(smooth < 0.5 * rough, "{flags}: {smooth} of {rough}");
        if flags.contains("prism") {
            assert_eq!(one.channels, four.channels, "{flags}: surface data");
        }
    }
}
