//! The marches in f64 along one ray: where each takes its samples, and where it stops. What a probe draws.
//!
//! Twins of `shaders/shell/march.glsl`, `refine.glsl` and `cone.glsl`, prism by prism along the reference's exact path;
//! `tests/probe.rs` holds them to what the GPU draws. Plain triangles and the walls of steps are no march's to search: a
//! ray ends there at the latest.

mod cone;
mod linear;
#[cfg(test)]
mod tests;

use std::collections::HashMap;

use self::cone::ConeMap;
use super::{
    certificate,
    cones::ConeKind,
    prisms,
    reference::{Stretch, Way},
};
use crate::{
    scene::{HeightSource, Scene, Wrap},
    settings::{March, Settings},
};

/// A point of a way: a stretch of it, and that stretch's parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Index into [`Way::stretches`].
    pub stretch: usize,
    /// 0 at its near end, 1 at its far one.
    pub x: f64,
}

/// What a march did.
#[derive(Clone, Debug)]
pub struct Followed {
    /// Which one.
    pub march: March,
    /// Where it compared the ray with the surface, in the order in which it did.
    pub samples: Vec<Place>,
    /// Where it hit the height field; none where it ended on a wall or a plain triangle, or hit nothing.
    pub place: Option<Place>,
    /// How far along the ray it ended, in units of its direction; none where it hit nothing.
    pub distance: Option<f64>,
}

/// The marches of one scene, with what they know of it beforehand.
pub struct Marches<'a> {
    scene: &'a Scene,
    /// Levels of each prism, by mesh, primitive and triangle.
    ranges: HashMap<usize, Vec<Vec<[f64; 2]>>>,
    cones: HashMap<(usize, [Wrap; 2], ConeKind), ConeMap>,
}

/// Where a march stopped in a prism.
enum Outcome {
    Hit(f64),
    /// Above the surface at the far end, or below it.
    Passed,
}

/// What a march of one prism sees: the stretch, cut to the levels that the prism's surface can have. Its own parameter
/// runs from 0 to 1 too.
struct Interval<'s, 'w> {
    stretch: &'s Stretch<'w>,
    from: f64,
    to: f64,
}

impl Interval<'_, '_> {
    fn x(&self, at: f64) -> f64 {
        self.from + (self.to - self.from) * at
    }

    /// How high the ray is over the surface, mesh units.
    fn clearance(&self, at: f64) -> f64 {
        let station = self.stretch.at(self.x(at));
        station.t - station.surface
    }
}

impl<'a> Marches<'a> {
    /// Of `scene`, which nothing has moved since it was loaded.
    pub fn new(scene: &'a Scene) -> Self {
        Marches { scene, ranges: HashMap::new(), cones: HashMap::new() }
    }

    /// Follows `settings.march` along a way: any march that steps, or reads cones of a map.
    pub fn follow(&mut self, way: &Way<'_>, settings: &Settings) -> Followed {
        let march = settings.march;
        let mut followed = Followed { march, samples: Vec::new(), place: None, distance: way.solid };
        for (index, stretch) in way.stretches.iter().enumerate() {
            let Some(interval) = self.interval(stretch) else { continue };
            let first = interval.stretch.at(interval.from).distance;
            if followed.distance.is_some_and(|end| first >= end) {
                continue;
            }
            let mut samples = Vec::new();
            let outcome = if march.reads_cones() {
                self.cone_search(&interval, settings, &mut samples)
            } else {
                linear::search(&interval, self.texels(stretch), settings, &mut samples)
            };
            followed.samples.extend(samples.iter().map(|at| Place { stretch: index, x: interval.x(*at) }));
            if let Outcome::Hit(at) = outcome {
                let distance = stretch.at(interval.x(at)).distance;
                if followed.distance.is_none_or(|end| distance < end) {
                    followed.distance = Some(distance);
                    followed.place = Some(Place { stretch: index, x: interval.x(at) });
                }
                // Stretches are in order: the first hit is the nearest.
                break;
            }
        }
        followed
    }

    /// The part of a stretch within its prism's own levels; none where they do not meet.
    fn interval<'s, 'w>(&mut self, stretch: &'s Stretch<'w>) -> Option<Interval<'s, 'w>> {
        let mesh = self.scene.instances[stretch.instance].mesh;
        let scene = self.scene;
        let ranges = self.ranges.entry(mesh).or_insert_with(|| {
            let mesh = &scene.meshes[mesh];
            let factors = certificate::mesh_folds(scene, mesh).factors;
            let shells = prisms::build(scene, mesh, &factors);
            shells.iter().map(|shell| shell.prisms.iter().map(|prism| prism.range).collect()).collect()
        });
        let [low, high] = *ranges[stretch.primitive].get(stretch.triangle)?;
        let [a, b] = stretch.t;
        let x = |t: f64| if a == b { 0.0 } else { (t.clamp(low, high) - a) / (b - a) };
        let interval = Interval { stretch, from: x(a), to: if a == b { 1.0 } else { x(b) } };
        (interval.from < interval.to && (a != b || (low..=high).contains(&a))).then_some(interval)
    }

    /// Texels of the height map along u and v, or of one that would hold the function's features.
    fn texels(&self, stretch: &Stretch<'_>) -> [f64; 2] {
        match self.source(stretch) {
            Some(HeightSource::Procedure(procedure)) => procedure.detail(),
            _ => stretch.map_size().to_array(),
        }
    }

    fn source(&self, stretch: &Stretch<'_>) -> Option<HeightSource> {
        let mesh = &self.scene.meshes[self.scene.instances[stretch.instance].mesh];
        let material = &self.scene.materials[mesh.primitives[stretch.primitive].material];
        material.displacement.map(|displacement| displacement.source)
    }

    fn cone_search(&mut self, interval: &Interval<'_, '_>, settings: &Settings, samples: &mut Vec<f64>) -> Outcome {
        let kind = if settings.march == March::Cone { ConeKind::Plain } else { ConeKind::Relaxed };
        let Some(HeightSource::Map(map)) = self.source(interval.stretch) else { return Outcome::Passed };
        let (scene, wrap) = (self.scene, interval.stretch.wrap());
        let cones =
            self.cones.entry((map, wrap, kind)).or_insert_with(|| ConeMap::new(&scene.height_maps[map], wrap, kind));
        cone::search(interval, cones, settings, samples)
    }
}
