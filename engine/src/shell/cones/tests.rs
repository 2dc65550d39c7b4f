//! Every texel's cone is marched against the bilinear surface, by nothing but heights.

use std::f64::consts::TAU;

use super::*;
use crate::scene::HeightTexels;

/// Texels of a path from p per sample.
const STEP: f64 = 1.0 / 16.0;

struct Random(u32);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(self.0 >> 8) / f64::from(1 << 24)
    }
}

fn map(size: [u32; 2], height: impl FnMut([u32; 2]) -> f64) -> HeightMap {
    let texels = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| [x, y])).map(height);
    let texels = texels.map(|h| (h.clamp(0.0, 1.0) * 65535.0).round() as u16).collect();
    HeightMap { name: "test".into(), width: size[0], height: size[1], texels: HeightTexels::U16(texels) }
}

/// Maps that are hard in different ways, with all three wrap modes and texels that are not square in UV.
fn maps() -> Vec<(&'static str, HeightMap, [Wrap; 2])> {
    use Wrap::{Clamp, Mirror, Repeat};
    let mut random = Random(7);
    let wave = |[x, y]: [u32; 2]| 0.5 + 0.25 * (f64::from(x) * TAU / 16.0).sin() + 0.25 * (f64::from(y) * 0.7).cos();
    vec![
        ("noise", map([12, 12], |_| random.next()), [Repeat, Repeat]),
        ("low noise", map([13, 6], |_| 0.05 * random.next()), [Mirror, Clamp]),
        ("needles", map([16, 8], |at| f64::from(u8::from(at == [3, 5] || at == [12, 2]))), [Repeat, Mirror]),
        ("cliffs", map([10, 16], |[x, y]| f64::from(u8::from(x > 4)) * 0.9 - 0.01 * f64::from(y % 3)), [Clamp, Repeat]),
        ("waves", map([16, 16], wave), [Repeat, Clamp]),
        ("steps", map([14, 9], |[x, y]| f64::from((x + y) / 5) * 0.2), [Mirror, Mirror]),
        ("flat", map([5, 7], |_| 0.4), [Repeat, Repeat]),
    ]
}

/// The bilinear height at texel coordinates.
fn height(heights: &Heights, at: [f64; 2]) -> f64 {
    let low = at.map(f64::floor);
    let [a, b, c, d] = heights.cell(low.map(|v| v as i64)).corners;
    let [x, y] = [at[0] - low[0], at[1] - low[1]];
    (a + (b - a) * x) * (1.0 - y) + (c + (d - c) * x) * y
}

/// How many of the paths outward from points in the texels' footprints find their cone's promise broken.
fn violations(heights: &Heights, kind: ConeKind, roots: &[u16]) -> usize {
    let mut random = Random(3);
    let size = heights.size();
    let texel = size.map(|n| 1.0 / n as f64);
    let mut broken = 0;
    for (texel_y, texel_x) in (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (y, x))) {
        let ratio = (f64::from(roots[(texel_y * size[0] + texel_x) as usize]) / 65535.0).powi(2);
        for sample in 0..6 {
            // The centre, a corner of the footprint, then anywhere in it.
            let offset = match sample {
                0 => [0.0, 0.0],
                1 => [1.0 - 1e-9, -1.0],
                _ => [random.next(), random.next()].map(|r| 2.0 * r - 1.0),
            };
            let p = [texel_x as f64 + offset[0], texel_y as f64 + offset[1]];
            let foot = height(heights, p);
            for turn in 0..40 {
                let angle = TAU * (f64::from(turn) + random.next()) / 40.0;
                let (sin, cos) = angle.sin_cos();
                let speed = (cos * texel[0]).hypot(sin * texel[1]) / ratio.max(1e-12);
                let mut highest = foot;
                let mut s = STEP;
                // Until the cone is above all heights.
                while foot + s * speed < 1.0 {
                    let here = height(heights, [p[0] + s * cos, p[1] + s * sin]);
                    let cone = foot + s * speed;
                    highest = highest.max(here);
                    // A level ray between these two is in the cone: it has gone into the surface and come out again.
                    let free =
                        if kind == ConeKind::Plain { here <= cone + 1e-9 } else { highest <= here.max(cone) + 1e-9 };
                    if !free {
                        broken += 1;
                        break;
                    }
                    s += STEP;
                }
            }
        }
    }
    broken
}

#[test]
fn no_cone_breaks_its_promise_anywhere_in_its_texels_footprint() {
    for (name, map, wrap) in maps() {
        let heights = Heights::new(&map, wrap);
        let mut mean = [0.0; 2];
        for (kind, mean) in [ConeKind::Plain, ConeKind::Relaxed].into_iter().zip(&mut mean) {
            let roots = by_all_pairs(&map, wrap, kind);
            assert_eq!(violations(&heights, kind, &roots), 0, "{name} {kind:?}");
            *mean = roots.iter().map(|r| f64::from(*r)).sum::<f64>() / roots.len() as f64 / 65535.0;
        }
        println!("{name}: mean √ratio {:.3} plain, {:.3} relaxed", mean[0], mean[1]);
        assert!(mean[1] >= mean[0], "{name}: relaxed cones are narrower");
        assert!(name != "flat" || mean == [1.0; 2], "{name}: {mean:?}");
    }
}

/// Cones are not only safe but useful: within half of the steepness that samples of p and q show to be needed.
#[test]
fn plain_cones_are_near_the_widest() {
    for (name, map, wrap) in maps() {
        let heights = Heights::new(&map, wrap);
        let [width, height_] = heights.size();
        let (mut ours, mut least) = (0.0, 0.0);
        for at in (0..height_).flat_map(|y| (0..width).map(move |x| [x, y])) {
            let fractions = [0.0, 0.5, 1.0];
            let mut sampled = 1.0;
            for (a, b) in fractions.into_iter().flat_map(|b| fractions.map(|a| (a, b))) {
                let p = [at[0] as f64 + a, at[1] as f64 + b];
                let foot = height(&heights, p);
                for (x, y) in (-32..=32).flat_map(|y| (-32..=32).map(move |x| (x, y))) {
                    let way = [f64::from(x) / 2.0, f64::from(y) / 2.0];
                    let distance = (way[0] / width as f64).hypot(way[1] / height_ as f64);
                    if distance > 0.0 {
                        sampled =
                            f64::max(sampled, (height(&heights, [p[0] + way[0], p[1] + way[1]]) - foot) / distance);
                    }
                }
            }
            ours += heights.steepness(ConeKind::Plain, at).ln();
            least += sampled.ln();
        }
        let loss = ((ours - least) / (width * height_) as f64).exp();
        println!("{name}: {loss:.3} times as steep as sampled, geometric mean");
        assert!((0.999..1.5).contains(&loss), "{name}: {loss}");
    }
}

/// The cone map as published: between texel centres only (Policarpo and Oliveira 2007, listing 18-1).
fn published(heights: &Heights, kind: ConeKind) -> Vec<u16> {
    let [width, height_] = heights.size();
    let texel = heights.size().map(|n| 1.0 / n as f64);
    let texels = (0..height_).flat_map(|y| (0..width).map(move |x| [x, y]));
    texels
        .map(|p| {
            let foot = heights.cell(p).corners[0];
            let mut ratio = 1.0;
            for (x, y) in (-height_..=height_).flat_map(|y| (-width..=width).map(move |x| (x, y))) {
                let length = (x as f64 * texel[0]).hypot(y as f64 * texel[1]);
                let mut top = heights.cell([p[0] + x, p[1] + y]).corners[0];
                if length == 0.0 || top <= foot {
                    continue;
                }
                let mut along = 1.0;
                if kind == ConeKind::Relaxed {
                    // From the top over p down to q, and on to where it comes out again.
                    let fall = 1.0 - top;
                    let texels = (x as f64).hypot(y as f64);
                    loop {
                        along += 0.25 / texels;
                        top = 1.0 - along * fall;
                        let at = [p[0] as f64 + along * x as f64, p[1] as f64 + along * y as f64];
                        if height(heights, at) < top || top <= foot || along * length > 1.0 {
                            break;
                        }
                    }
                }
                if top > foot && along * length <= 1.0 {
                    ratio = f64::min(ratio, along * length / (top - foot));
                }
            }
            (65535.0 * ratio.sqrt()).floor() as u16
        })
        .collect()
}

#[test]
fn published_cones_do_break_theirs() {
    for kind in [ConeKind::Plain, ConeKind::Relaxed] {
        for (name, map, wrap) in maps().into_iter().filter(|(name, ..)| ["noise", "needles", "waves"].contains(name)) {
            let heights = Heights::new(&map, wrap);
            let found = violations(&heights, kind, &published(&heights, kind));
            println!("{name} {kind:?}: {found} paths");
            assert!(found > 0, "{name} {kind:?}: this check finds nothing");
        }
    }
}
