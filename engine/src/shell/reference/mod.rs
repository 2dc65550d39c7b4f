//! The reference: a CPU tracer in f64 of exactly the surface of DESIGN section 1. It judges every renderer, so it
//! shares no code with them: it reads only the raw scene (positions, normals, UVs, triangles, transforms, texels,
//! materials, cameras, lights) and welds, folds, bounds, projects and samples by itself.
//!
//! What it finds is exact to f64 rounding: within each prism the ray's curved path through texture space is cut at
//! every texel cell, and the first root of the degree-5 polynomial `W²(t - S(h))` is isolated in Bernstein form; under
//! a procedural height the path is halved until the procedure's bounds clear it. Not modelled: `alphaMode` MASK (every
//! surface is opaque).

mod bezier;
mod bvh;
mod fold;
mod height;
mod penumbra;
mod prism;
mod procedural;
mod render;
mod surface;
mod wall;
mod way;

#[cfg(test)]
mod tests;

use glam::{DAffine3, DMat3, DVec2, DVec3};

use self::{
    height::HeightField,
    prism::{Accept, Found, Ray},
    surface::{Surface, height_fields},
};
pub use self::{
    render::Shadows,
    way::{Station, Stretch, Way},
};
use crate::scene::{Light, Scene};

/// The traced scene.
#[derive(Clone, Debug)]
pub struct Reference {
    fields: Vec<HeightField>,
    surfaces: Vec<Surface>,
    instances: Vec<Placed>,
    lights: Vec<Light>,
}

/// An instance whose transform can be undone.
#[derive(Clone, Copy, Debug)]
struct Placed {
    /// Index into the scene's instances.
    index: usize,
    mesh: usize,
    transform: DAffine3,
    /// Inverse of the transform's linear part.
    inverse: DMat3,
}

/// Where a ray meets the surface.
#[derive(Clone, Copy, Debug)]
pub struct Hit {
    /// World units.
    pub position: DVec3,
    /// Along the ray, in units of its direction's length.
    pub distance: f64,
    /// World, unit, the geometric normal of the displaced surface (or of the wall), turned toward the ray's origin.
    pub normal: DVec3,
    /// The set that the displacement reads, else set 0: as stored, before `KHR_texture_transform`, not wrapped. At a
    /// wall that of the prism being entered, or, where that is plain, left.
    pub uv: DVec2,
    /// t / scale + midlevel; the midlevel on a plain surface (0.5 where the material has no displacement).
    pub height: f64,
    /// On a wall that closes a step, rather than on the height field.
    pub on_wall: bool,
    /// Index into [`Scene::instances`].
    pub instance: usize,
    /// Index into the mesh's primitives.
    pub primitive: usize,
    /// Index into the primitive's triangles.
    pub triangle: usize,
    /// Barycentric weights in that triangle.
    pub lambda: [f64; 3],
    /// Height above the base triangle, mesh units along the (folded) shell normals.
    pub t: f64,
    /// World size of the triangle, roughly: the unit of tolerances around the hit.
    size: f64,
}

impl Reference {
    /// Welds and folds every mesh of `scene` and builds a hierarchy over its prisms, in mesh space. Instances whose
    /// transform flattens space are left out: their surfaces have no inside.
    pub fn new(scene: &Scene) -> Self {
        let fields = height_fields(scene);
        let surfaces = scene.meshes.iter().map(|mesh| Surface::new(scene, mesh, &fields)).collect();
        let placed = |(index, instance): (usize, &crate::scene::Instance)| {
            let linear = instance.transform.matrix3;
            let inverse = linear.inverse();
            let solid = linear.determinant() != 0.0 && inverse.is_finite();
            solid.then_some(Placed { index, mesh: instance.mesh, transform: instance.transform, inverse })
        };
        let instances = scene.instances.iter().enumerate().filter_map(placed).collect();
        Reference { fields, surfaces, instances, lights: scene.lights.clone() }
    }

    /// The first hit of the ray `origin + s · direction` with `s > t_min`, world space; `direction` has any length but
    /// 0. Hits from behind count only on double-sided materials. glTF fronts stay fronts under a mirrored transform.
    pub fn trace(&self, origin: DVec3, direction: DVec3, t_min: f64) -> Option<Hit> {
        self.first(origin, direction, [t_min, f64::INFINITY])
    }

    /// Whether anything lies between two distances along a ray; both sides of every surface block.
    pub fn blocked(&self, origin: DVec3, direction: DVec3, range: [f64; 2]) -> bool {
        let accept = Accept { range, both_sides: true };
        let by_all = |_: &Surface, _| true;
        self.instances.iter().any(|placed| self.nearest(placed, origin, direction, accept, true, by_all).is_some())
    }

    /// Whether the displaced surface of a hit's own primitive and instance, its walls included, lies on the way from it.
    fn blocked_by_own(&self, hit: &Hit, direction: DVec3, range: [f64; 2]) -> bool {
        let accept = Accept { range, both_sides: true };
        let of_own = |surface: &Surface, item: usize| {
            let own = |facet: usize| surface.facets[facet].id[0] == hit.primitive;
            match item.checked_sub(surface.facets.len()) {
                None => own(item),
                Some(wall) => {
                    let wall = &surface.walls[wall];
                    own(wall.inner.facet) || wall.outer.neighbour().is_some_and(|side| own(side.facet))
                }
            }
        };
        let own = self.instances.iter().filter(|placed| placed.index == hit.instance);
        own.filter(|placed| self.surfaces[placed.mesh].displaces(hit.primitive))
            .any(|placed| self.nearest(placed, hit.position, direction, accept, true, of_own).is_some())
    }

    fn first(&self, origin: DVec3, direction: DVec3, range: [f64; 2]) -> Option<Hit> {
        let mut accept = Accept { range, both_sides: false };
        let mut best = None;
        for placed in &self.instances {
            if let Some(found) = self.nearest(placed, origin, direction, accept, false, |_, _| true) {
                accept.range[1] = found.distance;
                best = Some((placed, found));
            }
        }
        best.map(|(placed, found)| self.hit(placed, &found, direction))
    }

    /// The nearest crossing in one instance with the items that `counts` takes, or, if `any`, some crossing.
    fn nearest(
        &self,
        placed: &Placed,
        origin: DVec3,
        direction: DVec3,
        accept: Accept,
        any: bool,
        counts: impl Fn(&Surface, usize) -> bool,
    ) -> Option<Found> {
        // The translation goes first, so that nothing is lost far away from the world's origin.
        let ray = Ray::new(placed.inverse * (origin - placed.transform.translation), placed.inverse * direction);
        let surface = &self.surfaces[placed.mesh];
        let mut best: Option<Found> = None;
        surface.bvh.traverse(ray.origin, ray.direction, accept.range, |item, far| {
            if !counts(surface, item) {
                return far;
            }
            let accept = Accept { range: [accept.range[0], far], ..accept };
            let found = match item.checked_sub(surface.facets.len()) {
                None => prism::hit(&ray, &surface.facets, item, &self.fields, accept),
                Some(wall) => wall::hit(&ray, &surface.facets, &surface.walls[wall], &self.fields, accept),
            };
            let Some(found) = found else { return far };
            best = Some(found);
            if any { f64::NEG_INFINITY } else { found.distance }
        });
        best
    }

    fn hit(&self, placed: &Placed, found: &Found, direction: DVec3) -> Hit {
        let facet = &self.surfaces[placed.mesh].facets[found.facet];
        let normal = (placed.inverse.transpose() * found.normal).normalize_or_zero();
        let scale = placed.transform.matrix3.to_cols_array_2d().map(|c| DVec3::from(c).length());
        Hit {
            position: placed.transform.transform_point3(facet.point(found.lambda, found.t)),
            distance: found.distance,
            normal: if normal.dot(direction) > 0.0 { -normal } else { normal },
            uv: (0..3).map(|k| found.lambda[k] * facet.uv[k]).sum(),
            height: facet.relief.map_or(facet.midlevel, |r| found.t / r.scale + r.midlevel),
            on_wall: found.on_wall,
            instance: placed.index,
            primitive: facet.id[0],
            triangle: facet.id[1],
            lambda: found.lambda,
            t: found.t,
            size: facet.size() * scale.into_iter().fold(0.0, f64::max),
        }
    }
}
