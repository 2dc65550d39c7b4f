//! Camera and object transforms in f64, handed to the shaders as camera-relative f32 rows.
//!
//! A product of large numbers that nearly cancel (a camera 20 km from the origin, looking at something beside it) is
//! taken here, in f64; f32 sees only its small result.

use glam::{DAffine3, DMat4, DVec2, DVec3, DVec4, Vec4};

use super::layout::{Frame, Light as GpuLight, Object, ShadowView};
use super::plan::fade::Fade;
use crate::scene::{Ambient, Camera, Light, LightKind, Projection};

/// A camera's transforms for one picture.
#[derive(Clone, Copy, Debug)]
pub struct View {
    /// World position of the camera.
    pub position: DVec3,
    /// World direction of view, unit.
    pub forward: DVec3,
    /// Camera-relative world to clip, y down, depth reversed; the z row is unused (see [`Frame::lens`]).
    projection: DMat4,
    perspective: bool,
    /// (scale, offset, near, far) of [`Frame::lens`].
    lens: [f64; 4],
    extent: [u32; 2],
    /// Corners of the near plane's window, world.
    near_corners: [DVec3; 4],
}

impl View {
    /// The view of `camera` on a picture of `extent` pixels.
    pub fn new(camera: &Camera, extent: [u32; 2]) -> Self {
        let aspect = f64::from(extent[0]) / f64::from(extent[1]);
        let axes = camera.transform.matrix3;
        let (right, up, forward) = (axes.x_axis, axes.y_axis, -axes.z_axis);
        let row = |direction: DVec3, scale: f64| (direction * scale).extend(0.0);
        let (x, y, w, lens, perspective) = match camera.projection {
            Projection::Perspective { fov_y, near, far } => {
                let focal = 1.0 / (0.5 * fov_y).tan();
                let lens = match far {
                    Some(far) => [-near / (far - near), near * far / (far - near), near, far],
                    None => [0.0, near, near, f64::from(f32::MAX)],
                };
                (row(right, focal / aspect), row(up, -focal), row(forward, 1.0), lens, true)
            }
            Projection::Orthographic { y_mag, near, far } => {
                let lens = [-1.0 / (far - near), far / (far - near), near, far];
                (row(right, 1.0 / (y_mag * aspect)), row(up, -1.0 / y_mag), DVec4::W, lens, false)
            }
        };
        // Rows x, y, clip w, view depth.
        let projection = DMat4::from_cols(x, y, w, row(forward, 1.0)).transpose();
        let half_height = match camera.projection {
            Projection::Perspective { fov_y, near, .. } => near * (0.5 * fov_y).tan(),
            Projection::Orthographic { y_mag, .. } => y_mag,
        };
        let position = camera.transform.translation;
        let near_corners = [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]]
            .map(|[x, y]| position + lens[2] * forward + half_height * (x * aspect * right + y * up));
        View { position, forward, projection, perspective, lens, extent, near_corners }
    }

    /// The frame's uniform block.
    pub fn frame(&self, ambient: &Ambient) -> Frame {
        let [width, height] = self.extent.map(|n| n as f32);
        Frame {
            viewport: Vec4::new(width, height, 1.0 / width, 1.0 / height),
            lens: Vec4::from_array(self.lens.map(|v| v as f32)),
            forward: self.forward.as_vec3().extend(0.0),
            ambient: std::array::from_fn(|i| ambient.forms[i / 4].col(i % 4).as_vec4()),
            projection: glam::UVec4::new(u32::from(self.perspective), 0, 0, 0),
            origin: Vec4::ZERO,
        }
    }

    /// The rows of an object whose vertices are stored relative to `center` (mesh space) and stand in the world by
    /// `transform`.
    pub fn object(&self, transform: &DAffine3, center: DVec3) -> Object {
        let relative = DAffine3::from_translation(-self.position) * *transform * DAffine3::from_translation(center);
        let clip = self.projection * DMat4::from(relative);
        let world = DMat4::from(relative);
        let linear = relative.matrix3;
        let normal = linear.inverse().transpose();
        let row = |m: &DMat4, i: usize| m.row(i).as_vec4();
        let normal_row = |i: usize| normal.row(i).as_vec3().extend(0.0);
        let inverse = relative.inverse();
        let eye = if self.perspective {
            inverse.translation.as_vec3().extend(1.0)
        } else {
            inverse.transform_vector3(-self.forward).as_vec3().extend(0.0)
        };
        let third = if self.perspective { 2 } else { 3 };
        let det = clip.row(0).truncate().cross(clip.row(1).truncate()).dot(clip.row(third).truncate());
        Object {
            clip_x: row(&clip, 0),
            clip_y: row(&clip, 1),
            clip_w: row(&clip, 2),
            depth: row(&clip, 3),
            world_x: row(&world, 0),
            world_y: row(&world, 1),
            world_z: row(&world, 2),
            normal_x: normal_row(0),
            normal_y: normal_row(1),
            normal_z: normal_row(2),
            eye,
            handedness: Vec4::new(det.signum() as f32, 0.0, 0.0, 0.0),
            fade: Vec4::ZERO,
            spare: [Vec4::ZERO; 3],
        }
    }

    /// How a shell of this world thickness within a box fades from the LOD `start` on: that of its thickness in a pixel.
    pub fn fade(&self, extent: DVec3, thickness: f64, start: f64) -> Fade {
        // Rows of the picture span 2 / |row y| at depth 1, or at any.
        let pixel = 2.0 / (self.projection.row(1).truncate().length() * f64::from(self.extent[1]));
        Fade { extent, scale: pixel / (thickness * start.exp2()) }
    }

    /// Least and greatest view depth of a box of half extents `extent` around `center`, in the mesh space of `transform`,
    /// as far as it lies beyond the near plane; 1 and 1 where pixels are as large everywhere.
    pub fn depths(&self, transform: &DAffine3, center: DVec3, extent: DVec3) -> [f64; 2] {
        if !self.perspective {
            return [1.0; 2];
        }
        let middle = self.forward.dot(transform.transform_point3(center) - self.position);
        let reach = (transform.matrix3.transpose() * self.forward).abs().dot(extent);
        [middle - reach, middle + reach].map(|depth| depth.max(self.lens[2]))
    }

    /// This view's picture as a shadow map, for points relative to `eye`. It begins at texel `origin` of an atlas.
    pub fn shadow_view(&self, eye: DVec3, origin: [u32; 2], atlas: [u32; 2]) -> ShadowView {
        let relative = self.projection * DMat4::from_translation(eye - self.position);
        let [x, y, w, depth] = [0, 1, 2, 3].map(|i| relative.row(i));
        let half = self.extent.map(|n| 0.5 * f64::from(n));
        let [scale, offset, ..] = self.lens.map(|v| v as f32);
        ShadowView {
            x: (half[0] * (x + w)).as_vec4(),
            y: (half[1] * (y + w)).as_vec4(),
            w: w.as_vec4(),
            depth: depth.as_vec4(),
            lens: Vec4::new(scale, offset, self.extent[0] as f32, f32::from(u8::from(self.perspective))),
            tile: Vec4::new(origin[0] as f32, origin[1] as f32, 1.0 / atlas[0] as f32, 1.0 / atlas[1] as f32),
        }
    }

    /// Whether the near plane's window may meet a box of half extents `extent` around `center`, in the mesh space of
    /// `transform`.
    pub fn near_plane_meets(&self, transform: &DAffine3, center: DVec3, extent: DVec3) -> bool {
        let inverse = transform.inverse();
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for corner in self.near_corners {
            let corner = inverse.transform_point3(corner) - center;
            (low, high) = (low.min(corner), high.max(corner));
        }
        low.cmple(extent).all() && high.cmpge(-extent).all()
    }

    /// First pixel and size of the part of the picture in which a box may be drawn, of half extents around a centre in the
    /// mesh space of `transform`; all of it where the box is not known. None where it is outside.
    pub fn pixels(&self, transform: &DAffine3, bounds: Option<(DVec3, DVec3)>) -> Option<[[u32; 2]; 2]> {
        // The rasteriser's snapping, and what is drawn grown.
        const MARGIN: f64 = 2.0;
        let whole = Some([[0, 0], self.extent]);
        let Some((center, extent)) = bounds else { return whole };
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for corner in 0..8u32 {
            let side = DVec3::from_array([0, 1, 2].map(|axis| if corner >> axis & 1 == 0 { -1.0 } else { 1.0 }));
            let at = transform.transform_point3(center + side * extent) - self.position;
            let clip = self.projection * at.extend(1.0);
            // Rows x, y, clip w, view depth.
            if clip.w <= self.lens[2] {
                return whole;
            }
            let place = clip.truncate().truncate() / clip.z;
            (low, high) = (low.min(place), high.max(place));
        }
        let size = DVec2::from_array(self.extent.map(f64::from));
        let pixel = |ndc: DVec2, margin: f64| (0.5 * (ndc + 1.0) * size + margin).clamp(DVec2::ZERO, size);
        let (first, end) = (pixel(low, -MARGIN).floor().as_uvec2(), pixel(high, MARGIN).ceil().as_uvec2());
        first.cmplt(end).all().then(|| [first.to_array(), (end - first).to_array()])
    }

    /// A light, camera-relative.
    pub fn light(&self, light: &Light) -> GpuLight {
        let (local, spot) = match light.kind {
            LightKind::Directional => (0.0, [0.0, 1.0]),
            LightKind::Point => (1.0, [0.0, 1.0]),
            LightKind::Spot { inner, outer } => {
                // KHR_lights_punctual, "inner and outer cone angles".
                let scale = 1.0 / (inner.cos() - outer.cos()).max(1e-3);
                (1.0, [scale, -outer.cos() * scale])
            }
        };
        GpuLight {
            intensity: light.intensity.as_vec3().extend(local),
            position: (light.position - self.position).as_vec3().extend(light.range.map_or(0.0, |r| r.powi(-4)) as f32),
            direction: light.direction.as_vec3().extend(0.0),
            spot: Vec4::new(spot[0] as f32, spot[1] as f32, 0.0, 0.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera(projection: Projection) -> Camera {
        Camera { transform: DAffine3::from_translation(DVec3::new(20_000.0, 0.0, 5.0)), projection }
    }

    #[test]
    fn a_far_away_object_keeps_its_place_on_screen() {
        let view =
            View::new(&camera(Projection::Perspective { fov_y: 90f64.to_radians(), near: 0.1, far: None }), [200, 100]);
        let object = view.object(&DAffine3::from_translation(DVec3::new(20_001.0, 2.0, 0.0)), DVec3::ZERO);
        // 1 right, 2 up, 5 ahead; focal length 1, aspect 2.
        assert_eq!([object.clip_x.w, object.clip_y.w, object.clip_w.w, object.depth.w], [0.5, -2.0, 5.0, 5.0]);
        assert_eq!(object.eye, Vec4::new(-1.0, -2.0, 5.0, 1.0));
    }

    #[test]
    fn handedness_follows_mirrors_and_is_the_same_for_both_lenses() {
        for projection in [
            Projection::Perspective { fov_y: 1.0, near: 0.1, far: Some(10.0) },
            Projection::Orthographic { y_mag: 1.0, near: 0.1, far: 10.0 },
        ] {
            let view = View::new(&camera(projection), [64, 64]);
            let plain = view.object(&DAffine3::IDENTITY, DVec3::ZERO).handedness.x;
            let mirrored = view.object(&DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0)), DVec3::ZERO).handedness.x;
            assert_eq!([plain, mirrored], [1.0, -1.0]);
        }
    }

    #[test]
    fn a_box_is_drawn_within_its_pixels() {
        let camera = Camera {
            transform: DAffine3::IDENTITY,
            projection: Projection::Perspective { fov_y: 90f64.to_radians(), near: 0.1, far: None },
        };
        let view = View::new(&camera, [200, 100]);
        let at = |x, y, z| DAffine3::from_translation(DVec3::new(x, y, z));
        let pixels = |transform, half| view.pixels(&transform, Some((DVec3::ZERO, DVec3::splat(half))));
        // Focal length 1, aspect 2: its front, 4 away, spans a quarter of the height up and down.
        assert_eq!(pixels(at(0.0, 0.0, -5.0), 1.0), Some([[85, 35], [30, 30]]));
        // Cut off by the left edge of the picture, and beyond it.
        assert_eq!(pixels(at(-10.0, 0.0, -5.0), 1.0), Some([[0, 35], [27, 30]]));
        assert_eq!(pixels(at(-20.0, 0.0, -5.0), 1.0), None);
        // Around the eye, or not known.
        assert_eq!(pixels(at(0.0, 0.0, 0.0), 1.0), Some([[0, 0], [200, 100]]));
        assert_eq!(view.pixels(&DAffine3::IDENTITY, None), Some([[0, 0], [200, 100]]));
    }

    #[test]
    fn depth_is_reversed() {
        for projection in [
            Projection::Perspective { fov_y: 1.0, near: 0.5, far: Some(8.0) },
            Projection::Orthographic { y_mag: 1.0, near: 0.5, far: 8.0 },
        ] {
            let view = View::new(&camera(projection), [64, 64]);
            let frame = view.frame(&Ambient::default());
            let buffer = |d: f32| (frame.lens.x * d + frame.lens.y) / if frame.projection.x == 1 { d } else { 1.0 };
            assert!((buffer(0.5) - 1.0).abs() < 1e-6 && buffer(8.0).abs() < 1e-6 && buffer(2.0) > buffer(3.0));
        }
    }
}
