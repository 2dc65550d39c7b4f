//! Where the heights of far shells fade, until the plain surface stands in their place.

use glam::{DAffine3, DMat3, DVec3};

use crate::settings::Settings;

/// When a draw is part of a frame, where heights fade with the distance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Span {
    /// As long as every ray sees all of the heights: the shell as it is.
    Near,
    /// Between the two: the shell, each ray with its own part of the heights.
    Fading,
    /// Once no ray sees any: the plain surface.
    Far,
}

/// Whether shells fade. Not in surface data, which are of the whole field, nor beside shadow maps, which see it from
/// elsewhere.
pub(super) fn fades(settings: &Settings, aov: bool) -> bool {
    settings.lod_fade.is_some() && !aov && !settings.shadow_map
}

/// The most that a transform stretches a vector, or up to 4 % more.
pub fn stretch(transform: &DAffine3) -> f64 {
    let gram = transform.matrix3.transpose() * transform.matrix3;
    let trace = |m: &DMat3| m.x_axis.x + m.y_axis.y + m.z_axis.z;
    // The greatest eigenvalue outgrows the others: its 16th power is the trace's but for a factor of 3 at most.
    let size = trace(&gram).max(f64::MIN_POSITIVE);
    let mut power = gram * size.recip();
    for _ in 0..4 {
        power = power * power;
    }
    (size * trace(&power).powf(1.0 / 16.0)).sqrt()
}

/// What of a mesh's instance fades, in one view.
#[derive(Clone, Copy, Debug)]
pub struct Fade {
    /// Half extents of a box around the mesh's centre.
    pub extent: DVec3,
    /// At view depth d the LOD is log2(d · scale) past the one at which heights begin to fade.
    pub scale: f64,
}

impl Fade {
    /// The span of an instance whose box is seen between these view depths.
    pub fn span(&self, nearest: f64, farthest: f64) -> Span {
        if farthest * self.scale <= 1.0 {
            Span::Near
        } else if nearest * self.scale >= 2.0 {
            Span::Far
        } else {
            Span::Fading
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stretch_is_that_of_the_longest_image() {
        let rotated = DAffine3::from_axis_angle(DVec3::new(1.0, 2.0, -1.0).normalize(), 0.7);
        let scaled = DAffine3::from_scale(DVec3::new(0.2, 3.0, -1.0)) * rotated;
        let shear = DAffine3::from_mat3(DMat3::from_cols(DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Z));
        for (transform, most) in [(DAffine3::IDENTITY, 1.0), (scaled, 3.0), (shear, 0.5 * (1.0 + 5f64.sqrt()))] {
            let ratio = stretch(&transform) / most;
            assert!((1.0 - 1e-9..1.04).contains(&ratio), "{transform:?}: {ratio}");
        }
    }

    #[test]
    fn spans_follow_one_another() {
        let fade = Fade { extent: DVec3::ONE, scale: 0.1 };
        assert_eq!(fade.span(5.0, 10.0), Span::Near);
        assert_eq!(fade.span(5.0, 10.1), Span::Fading);
        assert_eq!(fade.span(19.9, 30.0), Span::Fading);
        assert_eq!(fade.span(20.0, 22.0), Span::Far);
    }
}
