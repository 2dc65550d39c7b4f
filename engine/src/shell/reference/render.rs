//! The reference's camera: one ray through each pixel centre, and light visibility.

use std::sync::atomic::{AtomicUsize, Ordering};

use glam::DVec3;
use rayon::prelude::*;

use super::{Hit, Reference, penumbra::Roofs};
use crate::{
    aov::Aov,
    scene::{Camera, Light, LightKind, Projection},
};

/// Shadow rays leave a surface this far from it, in sizes of its triangle: past the rounding of their own root.
pub(super) const LIFT_OFF: f64 = 1e-7;

/// Whether [`Reference::render`] follows rays to the light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shadows {
    /// Fill the shadow channel.
    Trace,
    /// The same, with the shaded primitive alone to cast them, and only where it is displaced: self-shadow.
    TraceOwn,
    /// The same past a round light, of that tangent of its angular radius: how much of it is seen.
    TraceOwnSoft {
        /// See `Settings::shadow_softness`.
        softness: f64,
    },
    /// Leave it lit.
    Skip,
}

/// Rays of a camera.
pub(super) struct Lens {
    pub(super) camera: Camera,
    pub(super) size: [f64; 2],
}

impl Lens {
    /// The ray through pixel (x, y)'s centre: origin, and a direction of which one unit is one unit of view depth.
    pub(super) fn ray(&self, x: usize, y: usize) -> (DVec3, DVec3) {
        let [width, height] = self.size;
        // In units of the half height, so that square pixels come from the picture's own aspect ratio.
        let across = (2.0 * (x as f64 + 0.5) - width) / height;
        let up = 1.0 - 2.0 * (y as f64 + 0.5) / height;
        let place = &self.camera.transform;
        match self.camera.projection {
            Projection::Perspective { fov_y, .. } => {
                let half = (0.5 * fov_y).tan();
                (place.translation, place.transform_vector3(DVec3::new(across * half, up * half, -1.0)))
            }
            Projection::Orthographic { y_mag, .. } => {
                let offset = DVec3::new(across * y_mag, up * y_mag, 0.0);
                (place.transform_point3(offset), place.transform_vector3(-DVec3::Z))
            }
        }
    }

    /// Near and far plane.
    pub(super) fn depths(&self) -> [f64; 2] {
        match self.camera.projection {
            Projection::Perspective { near, far, .. } => [near, far.unwrap_or(f64::INFINITY)],
            Projection::Orthographic { near, far, .. } => [near, far],
        }
    }
}

impl Reference {
    /// Traces a frame: every channel of [`Aov`] but the colour, which stays 0. One ray per pixel centre, row 0 on top;
    /// hits nearer than the near plane or farther than a finite far plane do not count.
    pub fn render(&self, camera: &Camera, width: u32, height: u32, shadows: Shadows) -> Aov {
        self.render_counting(camera, width, height, shadows, &AtomicUsize::new(0))
    }

    /// [`Reference::render`], which counts the pixels that are done in `done`, for whoever waits.
    pub fn render_counting(
        &self,
        camera: &Camera,
        width: u32,
        height: u32,
        shadows: Shadows,
        done: &AtomicUsize,
    ) -> Aov {
        let lens = Lens { camera: *camera, size: [f64::from(width), f64::from(height)] };
        let light = self.lights.first().filter(|_| shadows != Shadows::Skip);
        let roofs = match shadows {
            Shadows::TraceOwnSoft { softness } => Some(Roofs::new(self, softness)),
            _ => None,
        };
        let pixel = |i: usize| {
            done.fetch_add(1, Ordering::Relaxed);
            let (origin, direction) = lens.ray(i % width as usize, i / width as usize);
            let hit = self.first(origin, direction, lens.depths())?;
            let lit = |lit: bool| if lit { 1.0 } else { 0.0 };
            let seen = light.map_or(1.0, |light| match (&roofs, shadows) {
                (Some(roofs), _) => self.seen_past_own(&hit, light, roofs),
                (None, Shadows::TraceOwn) => {
                    lit(self.lit_by(&hit, light, |way, range| self.blocked_by_own(&hit, way, range)))
                }
                _ => lit(self.lit(&hit, light)),
            });
            Some((hit, seen))
        };
        let mut aov = Aov::missed(width, height);
        let pixels: Vec<Option<(Hit, f64)>> = (0..aov.depth.len()).into_par_iter().map(pixel).collect();
        for (i, (hit, seen)) in pixels.into_iter().enumerate().filter_map(|(i, p)| Some((i, p?))) {
            aov.depth[i] = hit.distance as f32;
            aov.position[i] = hit.position.as_vec3().to_array();
            aov.normal[i] = hit.normal.as_vec3().to_array();
            aov.uv[i] = hit.uv.as_vec2().to_array();
            aov.height_at_hit[i] = hit.height as f32;
            aov.shadow[i] = seen as f32;
        }
        aov
    }

    /// Whether the light is seen from a hit: it lies on the hit's visible side, and nothing blocks the way. A light's
    /// cone and range dim it but cast no shadow.
    pub fn lit(&self, hit: &Hit, light: &Light) -> bool {
        self.lit_by(hit, light, |way, range| self.blocked(hit.position, way, range))
    }

    /// [`Reference::lit`] with what is in the way as `blocked` says.
    fn lit_by(&self, hit: &Hit, light: &Light, blocked: impl Fn(DVec3, [f64; 2]) -> bool) -> bool {
        let (direction, distance) = way_to(light, hit.position);
        hit.normal.dot(direction) > 0.0 && !blocked(direction, [LIFT_OFF * hit.size, distance])
    }
}

/// Unit direction toward a light, and how far it is.
pub(super) fn way_to(light: &Light, position: DVec3) -> (DVec3, f64) {
    match light.kind {
        LightKind::Directional => (-light.direction, f64::INFINITY),
        LightKind::Point | LightKind::Spot { .. } => {
            let way = light.position - position;
            (way.normalize_or_zero(), way.length())
        }
    }
}
