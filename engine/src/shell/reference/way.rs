//! The way of one ray through the prisms, in the order in which it meets them: what a probe draws, and what marches are
//! followed along.

use glam::{DVec2, DVec3};

use super::{
    Hit, Reference,
    bezier::restrict,
    height::HeightField,
    prism::{Accept, Path, Ray, paths, total},
    render::Lens,
    surface::{Facet, Relief, Surface},
};
use crate::scene::{Camera, Wrap};

/// A ray and what it passes.
#[derive(Debug)]
pub struct Way<'a> {
    /// World units.
    pub origin: DVec3,
    /// World; one unit of it is one unit of view depth. Distances are in units of it.
    pub direction: DVec3,
    /// Its stretches within displaced prisms, the nearest first.
    pub stretches: Vec<Stretch<'a>>,
    /// The first hit.
    pub hit: Option<Hit>,
    /// Where it first meets what no march searches: a plain triangle, or a wall that closes a step.
    pub solid: Option<f64>,
}

/// A stretch of a ray within one prism, as long as its levels reach over the whole height map. Its parameter runs from 0
/// at the near end to 1 at the far one, and the level is linear in it.
#[derive(Debug)]
pub struct Stretch<'a> {
    /// Index into the scene's instances.
    pub instance: usize,
    /// Of the mesh.
    pub primitive: usize,
    /// Of the primitive.
    pub triangle: usize,
    /// Levels at both ends, mesh units.
    pub t: [f64; 2],
    ray: Ray,
    facet: &'a Facet,
    relief: &'a Relief,
    field: &'a HeightField,
    path: Path,
}

/// A point of a stretch.
#[derive(Clone, Copy, Debug)]
pub struct Station {
    /// Along the ray, in units of its direction.
    pub distance: f64,
    /// The ray's level, mesh units.
    pub t: f64,
    /// The surface's level over the same point.
    pub surface: f64,
    /// Coordinates of the height map, its transform applied, not wrapped.
    pub uv: DVec2,
}

impl Reference {
    /// The way of the ray through the centre of a pixel, row 0 on top, of a picture of `size`; between the camera's near
    /// and far plane.
    pub fn way(&self, camera: &Camera, size: [u32; 2], pixel: [u32; 2]) -> Way<'_> {
        let lens = Lens { camera: *camera, size: size.map(f64::from) };
        let (origin, direction) = lens.ray(pixel[0] as usize, pixel[1] as usize);
        let range = lens.depths();
        let mut stretches = Vec::new();
        for placed in &self.instances {
            let surface = &self.surfaces[placed.mesh];
            let ray = Ray::new(placed.inverse * (origin - placed.transform.translation), placed.inverse * direction);
            surface.bvh.traverse(ray.origin, ray.direction, range, |item, far| {
                if let Some((facet, relief)) = surface.facets.get(item).and_then(|f| Some((f, f.relief.as_ref()?))) {
                    for path in paths(&ray, facet, relief) {
                        let stretch = Stretch {
                            instance: placed.index,
                            primitive: facet.id[0],
                            triangle: facet.id[1],
                            t: path.t,
                            ray,
                            facet,
                            relief,
                            field: &self.fields[relief.field],
                            path,
                        };
                        if stretch.at(1.0).distance > range[0] && stretch.at(0.0).distance < range[1] {
                            stretches.push(stretch);
                        }
                    }
                }
                far
            });
        }
        stretches.sort_by(|a, b| a.at(0.5).distance.total_cmp(&b.at(0.5).distance));
        let searched = |surface: &Surface, item: usize| surface.facets.get(item).is_some_and(|f| f.relief.is_some());
        let solids = self.instances.iter().filter_map(|placed| {
            let accept = Accept { range, both_sides: false };
            self.nearest(placed, origin, direction, accept, false, |surface, item| !searched(surface, item))
        });
        let solid = solids.map(|found| found.distance).min_by(f64::total_cmp);
        Way { origin, direction, stretches, hit: self.first(origin, direction, range), solid }
    }
}

impl Stretch<'_> {
    /// The point at a parameter.
    pub fn at(&self, x: f64) -> Station {
        let (lambda, t) = self.path.at(x);
        let texel: DVec2 = (0..3).map(|k| lambda[k] * self.relief.texel[k]).sum();
        let base = DVec2::new(self.relief.base[0] as f64, self.relief.base[1] as f64);
        Station {
            distance: self.ray.distance(self.facet.point(lambda, t)),
            t,
            surface: self.relief.surface_t(self.field, lambda).0,
            uv: (texel + base + 0.5) / self.map_size(),
        }
    }

    /// Columns and rows of the height map; 1 and 1 for a function.
    pub fn map_size(&self) -> DVec2 {
        self.field.size().into()
    }

    /// The field's height at coordinates as those of a [`Station`].
    pub fn height(&self, uv: DVec2) -> f64 {
        self.field.sample(uv * self.map_size() - 0.5, [0; 2], self.relief.wrap).0
    }

    /// The level of a height, mesh units: (height - midlevel) · scale. First the scale, then the midlevel.
    pub fn scale(&self) -> [f64; 2] {
        [self.relief.scale, self.relief.midlevel]
    }

    /// How the height map goes on beyond its edges, along u and v.
    pub fn wrap(&self) -> [Wrap; 2] {
        self.relief.wrap
    }

    /// How far the path, in texels, strays at most from its chord between two parameters. Both, over the path's
    /// denominator, are cubics in Bernstein form that agree at the ends; of what is left between, no weight is over 3/4.
    pub fn bend(&self, a: f64, b: f64) -> f64 {
        let s = self.path.s.map(|s| restrict(s, a, b));
        let numerator =
            |i: usize| -> DVec2 { (1..3).map(|k| s[k][i] * (self.relief.texel[k] - self.relief.texel[0])).sum() };
        let w = total(&s);
        let least = if w[1] * w[0] > 0.0 && w[1] * w[2] > 0.0 {
            w.map(f64::abs).into_iter().fold(f64::MAX, f64::min)
        } else {
            0.0
        };
        let from = numerator(0) / w[0];
        let chord = numerator(2) / w[2] - from;
        let middle = numerator(1) - w[1] * from;
        let first = (2.0 * middle - w[0] * chord) / 3.0;
        let second = (2.0 * (middle - w[1] * chord) + w[2] * chord) / 3.0;
        0.75 * first.length().max(second.length()) / least.max(1e-300)
    }

    /// Whether a hit from behind counts.
    pub fn double_sided(&self) -> bool {
        self.facet.double_sided
    }

    /// The prism's corners in the height map, as those of a [`Station`].
    pub fn corners(&self) -> [DVec2; 3] {
        let base = DVec2::new(self.relief.base[0] as f64, self.relief.base[1] as f64);
        self.relief.texel.map(|texel| (texel + base + 0.5) / self.map_size())
    }

    /// The straight line that classic parallax follows in this triangle's tangent plane: coordinates where the ray meets
    /// the base triangle's plane, and what they gain by each level along the ray. None where the ray lies in the plane.
    pub fn tangent_line(&self) -> Option<[DVec2; 2]> {
        let [a, b, c] = self.facet.positions;
        let (e1, e2) = (b - a, c - a);
        let normal = e1.cross(e2).normalize_or_zero();
        let way = self.ray.direction.normalize();
        let climb = way.dot(normal);
        // Barycentric weights of corners 1 and 2 of a point of the plane, and what a movement in it adds.
        let squared = e1.cross(e2).length_squared();
        let weights = |v: DVec3| DVec2::new(v.cross(e2).dot(e1.cross(e2)), e1.cross(v).dot(e1.cross(e2))) / squared;
        let [uv0, uv1, uv2] = self.corners();
        let moved = |v: DVec3| {
            let w = weights(v);
            w.x * (uv1 - uv0) + w.y * (uv2 - uv0)
        };
        let meets = self.ray.origin + way * ((a - self.ray.origin).dot(normal) / climb);
        let line = [uv0 + moved(meets - a), moved(way / climb - normal)];
        line.iter().all(|p| p.is_finite()).then_some(line)
    }
}
