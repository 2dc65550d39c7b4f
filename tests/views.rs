//! What a view shows, on scenes whose every pixel can be written down.

mod common;

use common::{
    Gltf, Lens, Map, Outcome, Picture, Ray, asset, draw, folder,
    forms::{oblique, ramp_scene, sheet_scene},
    frame::Frame,
};
use glam::{DAffine3, DVec2, DVec3};
use serde_json::json;

const MESH: &str = "--shell walk --stage mesh";
const GEOMETRY: &str = "--shell prism --stage geometry";

/// Behind everything: no view has it.
const BACKGROUND: [u8; 3] = [63, 69, 77];

/// Draws a view, and insists on the stage that the flags name.
#[track_caller]
fn view(gltf: &Gltf, lens: &Lens, flags: &str) -> (Picture, Outcome) {
    let mut gltf = gltf.clone();
    gltf.camera(lens);
    let folder = folder();
    let file = folder.path().join("view.png");
    let [width, height] = lens.size;
    let words = format!("--size {width}x{height} {flags} --stats --out");
    let outcome = draw("render", gltf.write(folder.path())).words(&words).arg(&file).within(folder.path()).succeeds();
    for (stage, model) in [("mesh", "MeshEXT"), ("geometry", "Geometry")] {
        assert!(!flags.contains(&format!("--stage {stage}")) || outcome.stdout.contains(model), "{outcome}");
    }
    (Picture::read(&file), outcome)
}

/// Compares the pixels that lie on the surface, by more than half a pixel, with what they must be to a unit of 255.
#[track_caller]
fn compare(picture: &Picture, lens: &Lens, what: &str, expected: impl Fn(&Ray) -> Option<[f64; 3]>) {
    let (mut seen, mut wrong) = (0, Vec::new());
    for (i, pixel) in picture.pixels.iter().enumerate() {
        let (x, y) = (f64::from(i as u32 % picture.width), f64::from(i as u32 / picture.width));
        let at = |dx: f64, dy: f64| expected(&lens.ray(x + 0.5 + dx, y + 0.5 + dy));
        let inside = [(-0.6, -0.6), (0.6, -0.6), (-0.6, 0.6), (0.6, 0.6)].iter().all(|(dx, dy)| at(*dx, *dy).is_some());
        let Some(color) = at(0.0, 0.0).filter(|_| inside) else { continue };
        seen += 1;
        if (0..3).any(|k| (f64::from(pixel[k]) - 255.0 * color[k]).abs() > 1.0) {
            wrong.push(format!("pixel {x},{y}: {pixel:?}, not {:?}", color.map(|c| 255.0 * c)));
        }
    }
    assert!(seen > 400, "{what}: only {seen} pixels");
    assert!(
        wrong.is_empty(),
        "{what}: {} of {seen} pixels are wrong:\n{}",
        wrong.len(),
        wrong[..wrong.len().min(5)].join("\n")
    );
}

#[test]
fn uv_height_normal_and_depth_are_those_of_the_surface() {
    let (gltf, sheet) = ramp_scene(0.5, 0.4, DAffine3::IDENTITY);
    let lens = oblique();
    type Color = fn(&common::Expected) -> [f64; 3];
    let views: [(&str, &str, Color); 4] = [
        ("uv", MESH, |at| [at.uv.x, at.uv.y, 0.0]),
        ("height", GEOMETRY, |at| [at.height; 3]),
        ("normal", MESH, |at| (0.5 + 0.5 * at.normal).to_array()),
        ("depth", GEOMETRY, |at| [1.0 - at.depth.log2().fract(); 3]),
    ];
    for (name, way, color) in views {
        let (picture, _) = view(&gltf, &lens, &format!("{way} --view {name}"));
        compare(&picture, &lens, name, |ray| sheet.at(&lens, ray).map(|at| color(&at)));
    }
}

/// Which of the sheet's two triangles a point is over, if it is not near their common edge.
fn triangle_of(p: DVec3) -> Option<usize> {
    let across = p.x + p.y;
    (across.abs() > 0.05).then_some(usize::from(across > 0.0))
}

#[test]
fn each_prism_has_a_colour_of_its_own() {
    let (gltf, sheet) = ramp_scene(0.5, 0.4, DAffine3::IDENTITY);
    let lens = oblique();
    for way in [MESH, GEOMETRY] {
        let (picture, _) = view(&gltf, &lens, &format!("{way} --view prisms"));
        let mut colours: [Vec<[u8; 3]>; 2] = Default::default();
        for (i, pixel) in picture.pixels.iter().enumerate().filter(|(_, pixel)| **pixel != BACKGROUND) {
            let (x, y) = (i as u32 % picture.width, i as u32 / picture.width);
            let ray = lens.ray(f64::from(x) + 0.5, f64::from(y) + 0.5);
            let Some(triangle) = sheet.at(&lens, &ray).and_then(|at| triangle_of(ray.at(at.depth))) else { continue };
            colours[triangle].push(*pixel);
        }
        let [a, b] = colours;
        assert!(a.len() > 300 && b.len() > 300, "{way}: {} and {}", a.len(), b.len());
        assert!(a.iter().all(|c| *c == a[0]) && b.iter().all(|c| *c == b[0]), "{way}: a prism of several colours");
        let apart = (0..3).map(|k| a[0][k].abs_diff(b[0][k])).max().unwrap();
        assert!(apart > 16, "{way}: {:?} and {:?}", a[0], b[0]);
    }
}

/// The colours of counts 0, 1, 2, 4 and 8, by the formula that `--help` tells.
fn count_color(count: u32) -> [f64; 3] {
    const SCALE: [[f64; 3]; 8] = [
        [0.0, 0.0, 4.0],
        [40.0, 11.0, 84.0],
        [101.0, 21.0, 110.0],
        [159.0, 42.0, 99.0],
        [212.0, 72.0, 66.0],
        [245.0, 125.0, 21.0],
        [250.0, 193.0, 39.0],
        [252.0, 255.0, 164.0],
    ];
    let at = 7.0 * f64::from(count).log2() / 8.0;
    let below = at as usize;
    std::array::from_fn(|k| (SCALE[below][k] + (SCALE[below + 1][k] - SCALE[below][k]) * at.fract()) / 255.0)
}

#[test]
fn a_base_surface_counts_the_gathers_of_its_normal() {
    let (gltf, sheet) = ramp_scene(0.5, 0.0001, DAffine3::IDENTITY);
    let lens = oblique();
    for (normals, reads) in [("gather", 1), ("4-tap", 4), ("sobel", 8)] {
        let flags = format!("--shell off --march normal --normals {normals} --view gathers");
        let (picture, _) = view(&gltf, &lens, &flags);
        compare(&picture, &lens, normals, |ray| sheet.at(&lens, ray).map(|_| count_color(reads)));
    }
}

#[test]
fn a_walk_that_stays_in_a_prism_counts_one() {
    let (gltf, sheet) = ramp_scene(0.5, 0.4, DAffine3::IDENTITY);
    let lens = oblique();
    let (picture, _) = view(&gltf, &lens, "--shell walk --stage geometry --view walk");
    let [one, two] = [1, 2].map(|count| count_color(count).map(|c| (255.0 * c).round() as u8));
    let (mut alone, mut crossed) = (0, 0);
    for (i, pixel) in picture.pixels.iter().enumerate().filter(|(_, pixel)| **pixel != BACKGROUND) {
        let ray = lens.ray(f64::from(i as u32 % picture.width) + 0.5, f64::from(i as u32 / picture.width) + 0.5);
        let Some(hit) = sheet.at(&lens, &ray).and_then(|at| triangle_of(ray.at(at.depth))) else { continue };
        // The highest level of all: the ray comes in there at the earliest, and between the two there is no other prism.
        let top = ray.at(ray.plane(DVec3::new(0.0, 0.0, 0.2), DVec3::Z));
        if top.x.abs() < 1.0 && top.y.abs() < 1.0 && triangle_of(top) == Some(hit) {
            assert_eq!(*pixel, one, "pixel {i}");
            alone += 1;
        }
        crossed += usize::from(*pixel == two);
    }
    assert!(alone > 500 && crossed > 20, "{alone} walks in one prism, {crossed} through two");
}

/// Where points of a segment show in the picture.
fn projected(lens: &Lens, from: DVec3, to: DVec3) -> impl Iterator<Item = DVec2> {
    let lens = *lens;
    (0..=400).map(move |i| {
        let local = lens.axes.transpose() * (from.lerp(to, f64::from(i) / 400.0) - lens.eye);
        let [width, height] = lens.size.map(f64::from);
        let scale = 0.5 * height / lens.half / -local.z;
        DVec2::new(0.5 * width + local.x * scale, 0.5 * height - local.y * scale)
    })
}

/// Insists that two pictures differ on lines and nowhere else. seen: segments that nothing hides.
#[track_caller]
fn differs_on_lines(a: &Picture, b: &Picture, lens: &Lens, seen: &[[DVec3; 2]], all: &[[DVec3; 2]]) {
    let differences = a.differences(b);
    let points: Vec<DVec2> = all.iter().flat_map(|[from, to]| projected(lens, *from, *to)).collect();
    for i in (0..differences.len()).filter(|i| differences[*i] > 0) {
        let at = DVec2::new(f64::from(i as u32 % a.width) + 0.5, f64::from(i as u32 / a.width) + 0.5);
        let nearest = points.iter().map(|p| p.distance(at)).fold(f64::MAX, f64::min);
        assert!(nearest < 1.6, "pixel {at} is {nearest:.1} pixels from any edge");
    }
    for [from, to] in seen {
        let drawn = projected(lens, *from, *to).filter(|p| {
            let near = |dx: f64, dy: f64| {
                let (x, y) = ((p.x + dx) as usize, (p.y + dy) as usize);
                differences[y * a.width as usize + x] > 0
            };
            near(0.0, 0.0) || near(-0.6, 0.0) || near(0.6, 0.0) || near(0.0, -0.6) || near(0.0, 0.6)
        });
        let drawn = drawn.count();
        assert!(drawn > 380, "of the edge from {from} to {to} only {drawn} of 401 points are drawn");
    }
}

/// The square at a level, and its diagonal.
fn square(z: f64) -> [[DVec3; 2]; 5] {
    let corner = |x: f64, y: f64| DVec3::new(x, y, z);
    let [a, b, c, d] = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    [[a, b], [b, c], [c, d], [d, a], [d, b]]
}

#[test]
fn edges_lie_over_the_base_mesh_and_around_the_prisms() {
    let (gltf, _) = ramp_scene(0.5, 0.4, DAffine3::IDENTITY);
    // All of it in the picture.
    let lens = Lens::at([2.0, 1.3, 3.1], [0.0; 3]);
    let (base, _) = view(&gltf, &lens, "--view base");
    let (plain, _) = view(&gltf, &lens, "--shell off --march none");
    differs_on_lines(&base, &plain, &lens, &square(0.0), &square(0.0));

    for way in [MESH, GEOMETRY] {
        let (wires, _) = view(&gltf, &lens, &format!("{way} --view wireframe"));
        let (shaded, _) = view(&gltf, &lens, way);
        let (top, bottom) = (square(0.2), square(-0.2));
        let uprights = [0, 1, 2, 3].map(|i| [top[i][0], bottom[i][0]]);
        let all: Vec<_> = top.iter().chain(&bottom).chain(&uprights).copied().collect();
        // Above the surface nothing hides them, up to where it reaches them at x = 1.
        differs_on_lines(&wires, &shaded, &lens, &[top[0], top[2], top[3], top[4]], &all);
    }
}

#[test]
fn shadow_is_that_of_the_surface_data() {
    let lens = oblique();
    let wavy = json!({ "scale": 0.3, "midlevel": 0.5 });
    let mut gltf = sheet_scene(&Map::noise(16, 16), wavy, DAffine3::IDENTITY);
    gltf.camera(&lens);
    let folder = folder();
    let flags = "--shell off --march relief --self-shadow hard --size 96x72";
    let scene = gltf.write(folder.path());
    let file = folder.path().join("frame.exr");
    draw("render", &scene).words(flags).words("--aov").arg(&file).within(folder.path()).succeeds();
    let aov = Frame::read(&file).aov();
    let file = folder.path().join("frame.png");
    draw("render", &scene).words(flags).words("--view shadow --out").arg(&file).within(folder.path()).succeeds();
    let picture = Picture::read(&file);
    let mut counts = [0; 2];
    for (i, pixel) in picture.pixels.iter().enumerate().filter(|(i, _)| aov.depth[*i].is_finite()) {
        assert_eq!(*pixel, [(255.0 * aov.shadow[i]).round() as u8; 3], "pixel {i}");
        counts[usize::from(aov.shadow[i] > 0.5)] += 1;
    }
    assert!(counts.iter().all(|n| *n > 100), "{counts:?} dark and lit");
}

#[test]
fn the_error_of_the_exact_march_is_next_to_nothing_and_that_of_none_is_not() {
    let lens = oblique();
    let (gltf, sheet) = ramp_scene(0.5, 0.4, DAffine3::IDENTITY);
    let dark = |pixel: &[u8; 3]| u32::from(pixel[0]) + u32::from(pixel[1]) + u32::from(pixel[2]) < 159 + 42 + 99;
    for (way, exact) in [(MESH, true), ("--shell off --march normal", false)] {
        let (picture, outcome) = view(&gltf, &lens, &format!("{way} --view error"));
        let mut counts = [0; 2];
        for (i, pixel) in picture.pixels.iter().enumerate() {
            let ray = lens.ray(f64::from(i as u32 % picture.width) + 0.5, f64::from(i as u32 / picture.width) + 0.5);
            let Some(at) = sheet.at(&lens, &ray) else { continue };
            let p = ray.at(at.depth);
            // Where the flat surface crosses the ramp it is right, and at its sides it is not seen.
            if p.x.abs() > 0.2 && p.x.abs() < 0.7 && p.y.abs() < 0.7 {
                counts[usize::from(dark(pixel))] += 1;
            }
        }
        let [wrong, right] = counts;
        assert!(
            if exact { wrong == 0 && right > 400 } else { right == 0 && wrong > 400 },
            "{way}: {counts:?}\n{outcome}"
        );
        assert!(outcome.stdout.contains("depth error p50"), "{outcome}");
    }
}

#[test]
fn a_view_of_nothing_is_wrong_usage() {
    let wrong = |command: &str, subject: &str, words: &str, told: &str| {
        let subject = if command == "render" { asset(subject) } else { subject.into() };
        let folder = folder();
        let outcome = draw(command, subject).words(words).within(folder.path()).run().ends(2);
        assert!(outcome.stderr.contains(told), "{outcome}");
    };
    wrong("render", "plane.gltf", "--shell prism --view walk", "--shell walk");
    wrong("render", "plane.gltf", "--view uv --aov plane.exr", "--aov");
    wrong("run", "stability", "--headless --view uv", "stability composes its picture itself");
    wrong("run", "cloth", "--headless --size 64x36 --view error", "changes shape");
}
