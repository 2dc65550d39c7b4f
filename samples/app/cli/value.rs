//! How the values of flags are read.

use clap::builder::{PossibleValuesParser, TypedValueParser};
use prism_engine::settings::March;

/// Width and height in pixels, both at least 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

impl Default for Size {
    fn default() -> Self {
        Size { width: 1280, height: 720 }
    }
}

/// A parser of the words that the engine gives its settings, so that they stand once.
pub fn words<T: Copy + Send + Sync + 'static>(
    all: &'static [T],
    name: fn(T) -> &'static str,
) -> impl TypedValueParser<Value = T> {
    PossibleValuesParser::new(all.iter().map(|&value| name(value)))
        .try_map(move |word| all.iter().copied().find(|&value| name(value) == word).ok_or("unknown word"))
}

/// `on` or `off`.
pub fn on_off() -> impl TypedValueParser<Value = bool> {
    PossibleValuesParser::new(["on", "off"]).map(|word| word == "on")
}

/// Width and height.
pub fn size(text: &str) -> Result<Size, String> {
    let side = |s: &str| s.parse::<u32>().ok().filter(|&n| n > 0);
    match text.split_once('x').map(|(w, h)| (side(w), side(h))) {
        Some((Some(width), Some(height))) => Ok(Size { width, height }),
        _ => Err("two whole numbers above 0, as in 1280x720".into()),
    }
}

/// Column and row.
pub fn pixel(text: &str) -> Result<[u32; 2], String> {
    let numbers: Option<Vec<u32>> = text.split(',').map(|part| part.trim().parse().ok()).collect();
    numbers.and_then(|n| n.try_into().ok()).ok_or_else(|| "column and row, whole numbers from 0, as in 640,360".into())
}

/// The marches that follow a ray.
pub fn tracing_march() -> impl TypedValueParser<Value = March> {
    let names = March::ALL.iter().filter(|march| march.traces()).map(|march| march.name());
    PossibleValuesParser::new(names)
        .try_map(|word| March::ALL.iter().copied().find(|march| march.name() == word).ok_or("unknown word"))
}

fn number(text: &str) -> Option<f64> {
    text.trim().parse().ok().filter(|n: &f64| n.is_finite())
}

/// Any number above 0.
pub fn positive(text: &str) -> Result<f64, String> {
    number(text).filter(|&n| n > 0.0).ok_or_else(|| "a finite number above 0".into())
}

/// A number between two, both allowed.
pub fn ranged(text: &str, least: f64, most: f64) -> Result<f32, String> {
    let inside = number(text).filter(|n| (least..=most).contains(n));
    inside.map(|n| n as f32).ok_or_else(|| format!("a number from {least} to {most}"))
}

/// Any number.
pub fn unbounded(text: &str) -> Result<f64, String> {
    number(text).ok_or_else(|| "a finite number".into())
}

/// A scale of heights.
pub fn height_scale(text: &str) -> Result<f64, String> {
    number(text).filter(|&n| n >= 0.0).ok_or_else(|| "a finite number, not below 0".into())
}

/// Factors of u and v.
pub fn scale_factors(text: &str) -> Result<[f32; 2], String> {
    two_numbers(text).ok().filter(|n| n.iter().all(|&n| n > 0.0)).ok_or_else(|| "two numbers above 0, as in 2,3".into())
}

/// A part of a whole.
pub fn share(text: &str) -> Result<f32, String> {
    ranged(text, 0.0, 1.0)
}

/// Two numbers, parted by a comma.
pub fn two_numbers(text: &str) -> Result<[f32; 2], String> {
    let numbers: Option<Vec<f32>> = text.split(',').map(|part| number(part).map(|n| n as f32)).collect();
    numbers.and_then(|n| n.try_into().ok()).ok_or_else(|| "two finite numbers, as in 0,1".into())
}

/// A point in the world.
pub fn point(text: &str) -> Result<[f64; 3], String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(number).collect();
    numbers.and_then(|n| n.try_into().ok()).ok_or_else(|| "three finite numbers, as in -1,2.5,3".into())
}

/// An angle of view, in degrees.
pub fn field_of_view(text: &str) -> Result<f64, String> {
    number(text).filter(|&deg| deg > 0.0 && deg < 180.0).ok_or_else(|| "degrees, above 0 and below 180".into())
}

/// A time, in seconds.
pub fn seconds(text: &str) -> Result<f64, String> {
    number(text).filter(|&s| s >= 0.0).ok_or_else(|| "seconds, finite and not negative".into())
}
