//! Expected pixels.

use glam::{DVec2, DVec3, Vec2, Vec3};
use prism_engine::aov::Aov;

use super::{Lens, Ray};

/// How far around a pixel's centre, in pixels, there must be no silhouette for the pixel to be judged: the rasterizer's
/// vertices lie on a grid of 1/256.
const SILHOUETTE: f64 = 0.01;
/// The same for creases of the surface, where only the tracer's own rounding counts.
const CREASE: f64 = 0.001;

/// What one ray must find.
#[derive(Clone, Copy, Debug)]
pub struct Expected {
    /// View depth.
    pub depth: f64,
    /// World.
    pub normal: DVec3,
    pub uv: DVec2,
    pub height: f64,
    /// A plain surface: its point comes out of the rasterizer, whose grid of 1/256 pixel shows at the edges of triangles
    /// (1.3 of its steps were seen, at 3 of 5,000 pixels). Shells find their own points.
    pub plain: bool,
}

/// Insists that every pixel shows what `surface` says about its ray, or nothing where that is `None`.
///
/// Lengths may be off by `tolerance`, and so may UV and height times their own scale, which is near 1 in these scenes.
/// Pixels are not judged that lie on a silhouette or an edge. There are few of them.
#[track_caller]
pub fn check(aov: &Aov, lens: &Lens, tolerance: f64, surface: impl Fn(&Ray) -> Option<Expected>) {
    assert_eq!([aov.width, aov.height], lens.size);
    let (mut hits, mut misses, mut doubtful) = (0, 0, 0);
    let mut wrong = Vec::new();
    for i in 0..aov.depth.len() {
        let (x, y) = ((i as u32 % aov.width), (i as u32 / aov.width));
        let ray_at = |dx: f64, dy: f64| lens.ray(f64::from(x) + 0.5 + dx, f64::from(y) + 0.5 + dy);
        let ray = ray_at(0.0, 0.0);
        let expected = surface(&ray);
        let around = |margin: f64| {
            let corners = [(-margin, -margin), (margin, -margin), (-margin, margin), (margin, margin)];
            corners.map(|(dx, dy)| surface(&ray_at(dx, dy)))
        };
        let smooth = around(CREASE).iter().all(|near| same_face(&expected, near));
        if !smooth || !around(SILHOUETTE).iter().all(|near| same_layer(&expected, near)) {
            doubtful += 1;
            continue;
        }
        let problem = match &expected {
            None => {
                misses += 1;
                missed(aov, i)
            }
            Some(expected) => {
                hits += 1;
                let pixel =
                    2.0 * lens.half / f64::from(aov.height) * if lens.perspective { expected.depth } else { 1.0 };
                let grid = if expected.plain { pixel / 128.0 } else { 0.0 };
                hit(aov, i, &ray, expected, tolerance + grid)
            }
        };
        wrong.extend(problem.map(|problem| format!("pixel {x},{y}: {problem}")));
    }
    println!("{hits} hits, {misses} misses and {doubtful} edges: {} wrong", wrong.len());
    let shown = wrong.iter().take(5).cloned().collect::<Vec<_>>().join("\n");
    assert!(wrong.is_empty(), "{} of {hits} hits and {misses} misses are wrong:\n{shown}", wrong.len());
    assert!(hits >= 400, "only {hits} hits: the test shows nothing");
    assert!(doubtful * 50 <= hits, "{doubtful} pixels are not judged, of {hits}");
}

fn same_layer(a: &Option<Expected>, b: &Option<Expected>) -> bool {
    match (a, b) {
        (None, None) => true,
        (Some(a), Some(b)) => (a.depth - b.depth).abs() < 0.01,
        _ => false,
    }
}

fn same_face(a: &Option<Expected>, b: &Option<Expected>) -> bool {
    match (a, b) {
        (Some(a), Some(b)) => (a.normal - b.normal).length() < 1e-3,
        _ => true,
    }
}

fn missed(aov: &Aov, i: usize) -> Option<String> {
    if aov.depth[i] != f32::INFINITY {
        return Some(format!("hit at depth {}, expected none", aov.depth[i]));
    }
    let zero = [aov.position[i], aov.normal[i], aov.color[i]] == [[0.0; 3]; 3];
    let rest = zero && aov.uv[i] == [0.0; 2] && aov.height_at_hit[i] == 0.0 && aov.shadow[i] == 1.0;
    (!rest).then(|| "missed, but its other channels are not 0 (shadow: 1)".to_owned())
}

fn hit(aov: &Aov, i: usize, ray: &Ray, expected: &Expected, tolerance: f64) -> Option<String> {
    let depth = f64::from(aov.depth[i]);
    if !depth.is_finite() {
        return Some(format!("missed, expected {expected:?}"));
    }
    let position = Vec3::from(aov.position[i]).as_dvec3();
    let normal = Vec3::from(aov.normal[i]).as_dvec3();
    let uv = Vec2::from(aov.uv[i]).as_dvec2();
    let height = f64::from(aov.height_at_hit[i]);
    let off = [
        ("depth", (depth - expected.depth).abs()),
        ("position", (position - ray.at(expected.depth)).length()),
        // Normals are differences of heights, divided by the size of a texel.
        ("normal", (normal - expected.normal).length() / 10.0),
        ("uv", (uv - expected.uv).length()),
        ("height", (height - expected.height).abs()),
    ];
    let worst =
        off.iter().filter(|(_, error)| *error > tolerance).map(|(name, error)| format!("{name} by {error:.2e}"));
    let worst: Vec<String> = worst.collect();
    (!worst.is_empty()).then(|| {
        let found = format!("depth {depth}, position {position}, normal {normal}, uv {uv}, height {height}");
        format!("off in {}\n  found {found}\n  expected {expected:?} at {}", worst.join(", "), ray.at(expected.depth))
    })
}
