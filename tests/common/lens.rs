//! Cameras, and the rays through their pixels.

use glam::{DMat3, DQuat, DVec3};
use serde_json::{Value, json};

/// A camera of a scene written by hand.
#[derive(Clone, Copy, Debug)]
pub struct Lens {
    /// Where it stands.
    pub eye: DVec3,
    /// Its axes in the world: right, up, back.
    pub axes: DMat3,
    /// Half the picture's height: at distance 1 where it is a perspective, else in world units.
    pub half: f64,
    /// Rays start at one point, rather than being parallel.
    pub perspective: bool,
    /// Nearest view depth that counts.
    pub near: f64,
    /// Pixels.
    pub size: [u32; 2],
}

/// A ray through a pixel. One unit of `direction` is one unit of view depth.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    pub origin: DVec3,
    pub direction: DVec3,
}

impl Ray {
    /// The point at this view depth.
    pub fn at(&self, depth: f64) -> DVec3 {
        self.origin + depth * self.direction
    }

    /// The view depth at which it crosses the plane through `point`.
    pub fn plane(&self, point: DVec3, normal: DVec3) -> f64 {
        normal.dot(point - self.origin) / normal.dot(self.direction)
    }
}

impl Lens {
    /// A perspective camera that looks from `eye` at `target`, Y up; 96 × 72 pixels, 40 degrees high.
    pub fn at(eye: [f64; 3], target: [f64; 3]) -> Lens {
        let eye = DVec3::from(eye);
        let back = (eye - DVec3::from(target)).normalize();
        let right = DVec3::Y.cross(back).normalize();
        Lens {
            eye,
            axes: DMat3::from_cols(right, back.cross(right), back),
            half: 20f64.to_radians().tan(),
            perspective: true,
            near: 0.05,
            size: [96, 72],
        }
    }

    /// The same place and direction with parallel rays.
    pub fn orthographic(self, half: f64) -> Lens {
        Lens { half, perspective: false, ..self }
    }

    /// The ray through the picture's point (x, y), in pixels from its top left corner.
    pub fn ray(&self, x: f64, y: f64) -> Ray {
        let [width, height] = self.size.map(f64::from);
        let across = (2.0 * x - width) / height * self.half;
        let up = (1.0 - 2.0 * y / height) * self.half;
        let (right, upward, back) = (self.axes.x_axis, self.axes.y_axis, self.axes.z_axis);
        let aside = across * right + up * upward;
        if self.perspective {
            Ray { origin: self.eye, direction: aside - back }
        } else {
            Ray { origin: self.eye + aside, direction: -back }
        }
    }

    /// The glTF camera.
    pub fn camera(&self) -> Value {
        if self.perspective {
            json!({ "type": "perspective", "perspective": { "yfov": 2.0 * self.half.atan(), "znear": self.near } })
        } else {
            let aspect = f64::from(self.size[0]) / f64::from(self.size[1]);
            json!({ "type": "orthographic", "orthographic": {
                "xmag": self.half * aspect, "ymag": self.half, "znear": self.near, "zfar": 100.0,
            } })
        }
    }

    /// The glTF node that holds the camera with this index.
    pub fn node(&self, camera: usize) -> Value {
        let turn = DQuat::from_mat3(&self.axes).normalize();
        json!({ "name": "camera", "camera": camera, "translation": self.eye.to_array(), "rotation": turn.to_array() })
    }
}
