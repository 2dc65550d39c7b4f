//! The linear search and what refines its bracket: `shaders/shell/refine.glsl`.

use super::{Interval, Outcome};
use crate::settings::{March, Settings};

/// Two samples between which the ray crosses the surface, and their clearances.
#[derive(Clone, Copy)]
struct Bracket {
    a: f64,
    fa: f64,
    b: f64,
    fb: f64,
}

impl Bracket {
    /// Where the line through both samples meets the surface.
    fn chord_root(self) -> f64 {
        let part = if self.fa == self.fb { 0.5 } else { (self.fa / (self.fa - self.fb)).clamp(0.0, 1.0) };
        self.a + (self.b - self.a) * part
    }

    /// The part that holds the crossing, cut at `at`. `above`: the side that the ray comes from.
    fn narrowed(self, at: f64, f: f64, above: bool) -> Bracket {
        if (f >= 0.0) == above { Bracket { a: at, fa: f, ..self } } else { Bracket { b: at, fb: f, ..self } }
    }
}

/// Follows the march through one prism. `texels`: of the height map.
pub(super) fn search(
    interval: &Interval<'_, '_>,
    texels: [f64; 2],
    settings: &Settings,
    samples: &mut Vec<f64>,
) -> Outcome {
    let mut sample = |at: f64| {
        samples.push(at);
        interval.clearance(at)
    };
    let ends = [interval.from, interval.to].map(|x| interval.stretch.at(x).uv);
    let length = ((ends[1] - ends[0]) * glam::DVec2::from(texels)).length();
    let steps = (length.min(1e6).ceil() as u32).clamp(settings.min_steps, settings.max_steps);
    let mut x = Bracket { a: 0.0, fa: sample(0.0), b: 0.0, fb: 0.0 };
    let mut above = x.fa >= 0.0;
    for i in 1..=steps {
        x.b = f64::from(i) / f64::from(steps);
        x.fb = sample(x.b);
        if (x.fb >= 0.0) != above {
            if above || interval.stretch.double_sided() {
                return Outcome::Hit(refined(x, above, settings, interval.stretch.scale()[0], sample));
            }
            above = true;
        }
        (x.a, x.fa) = (x.b, x.fb);
    }
    Outcome::Passed
}

fn refined(mut x: Bracket, above: bool, settings: &Settings, scale: f64, mut sample: impl FnMut(f64) -> f64) -> f64 {
    let steps = settings.refine_steps;
    match settings.march {
        March::Steep => return x.b,
        March::Secant => {
            let mut at = x.chord_root();
            for _ in 0..steps {
                let f = sample(at);
                if f.abs() <= f64::from(settings.tolerance) * scale {
                    break;
                }
                x = x.narrowed(at, f, above);
                at = x.chord_root();
            }
            return at;
        }
        March::Relief => {
            for _ in 0..steps {
                let middle = 0.5 * (x.a + x.b);
                x = x.narrowed(middle, sample(middle), above);
            }
        }
        March::Contact => {
            let mut fine = x;
            for i in 1..=steps {
                fine.b = x.a + (x.b - x.a) * f64::from(i) / f64::from(steps);
                fine.fb = if i == steps { x.fb } else { sample(fine.b) };
                if (fine.fb >= 0.0) != above {
                    break;
                }
                (fine.a, fine.fa) = (fine.b, fine.fb);
            }
            x = fine;
        }
        _ => {}
    }
    x.chord_root()
}
