//! The flags that light a scene otherwise than its file does.

use clap::Args;
use glam::DVec3;
use prism_engine::{
    error::{Error, Result},
    scene::{LightKind, Scene},
};

use super::cli::two_numbers;

/// An absent flag leaves what the file says.
#[derive(Clone, Debug, Default, PartialEq, Args)]
#[command(next_help_heading = "Lights")]
pub struct LightArgs {
    /// Where the first directional light comes from: degrees around Y from +Z toward +X, and above the horizon, -90 to 90
    /// [default: the file's]
    #[arg(long, value_name = "AROUND,ABOVE", value_parser = sun, allow_hyphen_values = true)]
    pub sun: Option<[f32; 2]>,

    /// Factor of every light's intensity, 0 to 1000 [default: 1]
    #[arg(long, value_name = "FACTOR", value_parser = |s: &str| super::cli::ranged(s, 0.0, 1000.0))]
    pub light_intensity: Option<f32>,
}

fn sun(text: &str) -> std::result::Result<[f32; 2], String> {
    two_numbers(text)
        .ok()
        .filter(|[_, above]| above.abs() <= 90.0)
        .ok_or_else(|| "two numbers of degrees, as in 30,45, the second from -90 to 90".into())
}

impl LightArgs {
    /// Whether any is given.
    pub fn given(&self) -> bool {
        *self != LightArgs::default()
    }

    /// Lights the scene so.
    pub fn apply(&self, scene: &mut Scene) -> Result<()> {
        if let Some([around, above]) = self.sun {
            let sun = scene.lights.iter_mut().find(|light| matches!(light.kind, LightKind::Directional));
            let sun = sun.ok_or_else(|| {
                Error::Usage("--sun: the scene has lights, but no directional one; drop the flag".to_owned())
            })?;
            sun.direction = -toward(around, above);
        }
        for light in &mut scene.lights {
            light.intensity *= f64::from(self.light_intensity.unwrap_or(1.0));
        }
        Ok(())
    }
}

/// Unit vector at so many degrees around Y from +Z toward +X, and above the horizon.
fn toward(around: f32, above: f32) -> DVec3 {
    let [around, above] = [around, above].map(|degrees| f64::from(degrees).to_radians());
    DVec3::new(above.cos() * around.sin(), above.sin(), above.cos() * around.cos())
}

/// The degrees of a light's direction, as [`LightArgs::sun`] has them.
#[cfg(any(test, feature = "window"))]
pub fn degrees(direction: DVec3) -> [f32; 2] {
    let toward = -direction;
    let above = toward.y.clamp(-1.0, 1.0).asin();
    [toward.x.atan2(toward.z).to_degrees() as f32, above.to_degrees() as f32]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sun_stands_where_it_is_told() {
        assert!(toward(90.0, 0.0).abs_diff_eq(DVec3::X, 1e-12));
        assert!(toward(0.0, 90.0).abs_diff_eq(DVec3::Y, 1e-12));
        let [around, above] = degrees(-toward(-30.0, 50.0));
        assert!((around + 30.0).abs() < 1e-4 && (above - 50.0).abs() < 1e-4, "{around}, {above}");
    }

    #[test]
    fn no_sun_is_wrong_usage() {
        let mut scene = crate::app::testing::empty_scene();
        assert!(scene.lights.is_empty());
        let args = LightArgs { sun: Some([0.0, 0.0]), ..LightArgs::default() };
        assert_eq!(args.apply(&mut scene).unwrap_err().exit_code(), 2);
    }
}
