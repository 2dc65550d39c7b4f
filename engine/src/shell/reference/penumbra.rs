//! How much of a round light a point of a displaced primitive sees past its own detail, by the definition of
//! `shaders/shell/soft.glsl`, the clearance measured densely.

use std::f64::consts::PI;

use glam::DVec3;

use super::{
    Hit, Placed, Reference,
    bvh::{Aabb, Bvh},
    height::HeightField,
    prism::{Path, Ray, cell_borders, paths, total},
    render::{LIFT_OFF, way_to},
    surface::{Facet, Relief, hull},
};
use crate::scene::Light;

/// Samples of a path within a height map's cell, and of one in a prism under a function, before the least is refined.
const CELL_SAMPLES: u32 = 8;
const FUNCTION_SAMPLES: u32 = 2000;

/// Narrowings of the stretch around the least sample: golden sections.
const SECTIONS: u32 = 40;

/// What the penumbrae of every mesh need besides: hierarchies over prisms that reach above their lids.
pub(super) struct Roofs {
    softness: f64,
    /// Of each surface.
    bvhs: Vec<Bvh>,
}

/// Of a disc, the part above a level edge that `q` of its diameter rises above.
pub(super) fn disc_above(q: f64) -> f64 {
    let above = (2.0 * q - 1.0).clamp(-1.0, 1.0);
    0.5 + (above * (1.0 - above * above).sqrt() + above.asin()) / PI
}

/// A relief with room above it.
fn roofed(relief: &Relief, headroom: f64) -> Relief {
    let [lo, hi] = relief.t_range;
    Relief { t_range: [lo, hi + headroom * (hi - lo)], ..*relief }
}

impl Roofs {
    pub(super) fn new(reference: &Reference, softness: f64) -> Self {
        let bvhs = reference.surfaces.iter().map(|surface| {
            let bounds = |facet: &Facet| {
                let range = facet.relief.map_or([0.0; 2], |relief| roofed(&relief, surface.headroom).t_range);
                hull(&facet.positions, &facet.lifts, range)
            };
            Bvh::new(&surface.facets.iter().map(bounds).collect::<Vec<Aabb>>())
        });
        Roofs { softness, bvhs: bvhs.collect() }
    }
}

/// A ray toward the upper limb of a light, and the least share of its disc's diameter that it stays clear of so far.
struct Limb<'a> {
    ray: &'a Ray,
    range: [f64; 2],
    /// Width of the disc along the levels for each unit of distance.
    spread: f64,
    headroom: f64,
    least: f64,
}

impl Limb<'_> {
    fn width(&self, distance: f64) -> f64 {
        (self.spread * distance).min(self.headroom)
    }

    /// Measures a path of the ray through the prism of `facet`.
    fn measure(&mut self, facet: &Facet, relief: &Relief, path: &Path, fields: &[HeightField]) {
        let share = |x: f64, limb: &Limb| {
            let (lambda, t) = path.at(x);
            let distance = limb.ray.distance(facet.point(lambda, t));
            let clear = (t - facet.surface_t(fields, lambda).0).max(0.0);
            let seen = distance > limb.range[0] && distance < limb.range[1];
            if seen { clear / limb.width(distance) } else { f64::INFINITY }
        };
        let mut cuts = vec![0.0, 1.0];
        let samples = match &fields[relief.field] {
            HeightField::Map(_) => {
                for axis in 0..2 {
                    let texels = relief.texel.map(|x| x[axis]);
                    let along = std::array::from_fn(|i| (0..3).map(|k| path.s[k][i] * texels[k]).sum());
                    cell_borders(along, total(&path.s), texels, &mut cuts);
                }
                CELL_SAMPLES
            }
            HeightField::Procedure(_) => FUNCTION_SAMPLES,
        };
        cuts.sort_unstable_by(f64::total_cmp);
        for piece in cuts.windows(2) {
            let at = |i: f64| piece[0] + (piece[1] - piece[0]) * i / f64::from(samples);
            let (i, first) = (0..=samples)
                .map(|i| (i, share(at(f64::from(i)), self)))
                .min_by(|a, b| a.1.total_cmp(&b.1))
                .expect("there are samples");
            self.least = self.least.min(first);
            // Only what may still count.
            if first < self.least + 0.1 {
                let [mut a, mut b] =
                    [f64::from(i) - 1.0, f64::from(i) + 1.0].map(|i| at(i.clamp(0.0, f64::from(samples))));
                for _ in 0..SECTIONS {
                    let [c, d] = [a + 0.382 * (b - a), b - 0.382 * (b - a)];
                    let [f, g] = [c, d].map(|x| share(x, self));
                    self.least = self.least.min(f).min(g);
                    if f < g { b = d } else { a = c }
                }
            }
        }
    }
}

impl Reference {
    /// How much of a light of that angular radius is seen from a hit, past its own primitive's surface.
    pub(super) fn seen_past_own(&self, hit: &Hit, light: &Light, roofs: &Roofs) -> f64 {
        let (direction, reach) = way_to(light, hit.position);
        if hit.normal.dot(direction) <= 0.0 {
            return 0.0;
        }
        let own = |placed: &&Placed| placed.index == hit.instance;
        let placed = self.instances.iter().find(own).expect("a hit lies on one");
        let surface = &self.surfaces[placed.mesh];
        let facet = surface.facets.iter().find(|f| f.id == [hit.primitive, hit.triangle]).expect("a hit lies on one");
        let front = facet.normal(hit.lambda, hit.t, facet.surface_t(&self.fields, hit.lambda).1);
        let behind = !hit.on_wall && hit.normal.dot(placed.inverse.transpose() * front) < 0.0;
        let softness = if behind || surface.headroom == 0.0 { 0.0 } else { roofs.softness };
        let lift: DVec3 = (0..3).map(|k| hit.lambda[k] * facet.lifts[k]).sum();
        let lift = lift.try_normalize().unwrap_or_else(|| facet.normal(hit.lambda, 0.0, [0.0; 2]).normalize());
        let toward = placed.inverse * direction;
        // Mesh units of one unit of the way.
        let unit = toward.length();
        let sine = toward.dot(lift) / unit;
        let tilt = (softness / (1.0 - sine * sine).max(1e-12).sqrt()).min(softness.max(0.5 * sine));
        let limb = toward / unit + tilt * lift;
        let world = placed.transform.matrix3 * limb;
        let range = [LIFT_OFF * hit.size / world.length(), reach * unit];
        if self.blocked_by_own(hit, world, range) {
            return 0.0;
        }
        if softness == 0.0 || !surface.displaces(hit.primitive) {
            return 1.0;
        }
        let ray = Ray::new(placed.inverse * (hit.position - placed.transform.translation), limb);
        let Some(relief) = surface.facets.iter().filter(|f| f.id[0] == hit.primitive).find_map(|f| f.relief) else {
            return 1.0;
        };
        let headroom = surface.headroom * (relief.t_range[1] - relief.t_range[0]);
        let mut limb = Limb { ray: &ray, range, spread: 2.0 * tilt, headroom, least: 1.0 };
        roofs.bvhs[placed.mesh].traverse(ray.origin, ray.direction, range, |item, far| {
            let facet = &surface.facets[item];
            if let Some(relief) = facet.relief.filter(|_| facet.id[0] == hit.primitive) {
                for path in paths(&ray, facet, &roofed(&relief, surface.headroom)) {
                    limb.measure(facet, &relief, &path, &self.fields);
                }
            }
            far
        });
        if limb.least < 1.0 { disc_above(limb.least) } else { 1.0 }
    }
}
