//! A probe as points and lines, for a window to draw; and its SVG beside them.

use super::{
    Probe,
    figure::{self, View, colour},
    profile,
};

/// Points of a curve within a prism.
const POINTS: usize = 48;

/// What one pixel's ray does, without the scene that it was found in.
pub struct Sketch {
    /// Scene and pixel.
    pub title: String,
    /// World units along the ray and mesh units of level at the drawing's corners: left bottom, right top.
    pub profile: [[f64; 2]; 2],
    /// Prisms that the ray passes, in order.
    pub prisms: Vec<Passed>,
    /// The true hit in the profile.
    pub hit: [f64; 2],
    /// Its coordinates in the texture.
    pub hit_uv: [f64; 2],
    /// The marches.
    pub marches: Vec<Marched>,
    /// All of it as `prism probe` draws it.
    pub svg: String,
}

/// A ray's part in one prism.
pub struct Passed {
    /// Its level over the way.
    pub ray: Vec<[f64; 2]>,
    /// That of the surface.
    pub surface: Vec<[f64; 2]>,
    /// Its path over the texture.
    pub path: Vec<[f64; 2]>,
    /// The base triangle there.
    pub corners: [[f64; 2]; 3],
}

/// What a march does on the way.
pub struct Marched {
    /// Which.
    pub name: &'static str,
    /// Its colour, `#rrggbb`.
    pub colour: &'static str,
    /// Its samples in the profile.
    pub samples: Vec<[f64; 2]>,
    /// Its hit there.
    pub hit: Option<[f64; 2]>,
    /// How many samples, and how far off.
    pub verdict: String,
}

impl Sketch {
    /// Of a probe.
    pub fn new(probe: &Probe<'_>) -> Sketch {
        let view = View::new(probe);
        let way = probe.way;
        let [x, y] = probe.pixel.at;
        let prisms = view.stretches().map(|(_, stretch, [from, to])| {
            let stations = || (0..=POINTS).map(|i| stretch.at(from + (to - from) * i as f64 / POINTS as f64));
            Passed {
                ray: stations().map(|at| [view.along(at.distance), at.t]).collect(),
                surface: stations().map(|at| [view.along(at.distance), at.surface]).collect(),
                path: stations().map(|at| at.uv.to_array()).collect(),
                corners: stretch.corners().map(|corner| corner.to_array()),
            }
        });
        let point = |place: &prism_engine::shell::follow::Place| {
            let at = way.stretches[place.stretch].at(place.x);
            [view.along(at.distance), at.t]
        };
        let marches = probe.followed.iter().map(|followed| Marched {
            name: followed.march.name(),
            colour: colour(followed.march),
            samples: followed.samples.iter().map(point).collect(),
            hit: followed.place.as_ref().map(point),
            verdict: figure::verdict(&view, followed),
        });
        let at_hit = &way.stretches[view.at_hit];
        let end = figure::part_within(at_hit, [f64::MIN, probe.hit.distance]).map_or(0.0, |[_, end]| end);
        let levels = profile::levels(&view, view.window, [0.0, 1.0]).numbers;
        Sketch {
            title: format!("{}: pixel {x},{y}", probe.name),
            profile: [[0.0, levels[0]], [view.along(view.window[1]), levels[1]]],
            prisms: prisms.collect(),
            hit: [view.along(probe.hit.distance), at_hit.at(end).t],
            hit_uv: at_hit.at(end).uv.to_array(),
            marches: marches.collect(),
            svg: figure::draw(probe).to_string(),
        }
    }
}
