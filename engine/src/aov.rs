//! The arbitrary output variables of one frame, as the EXR file holds them. Imports nothing of the engine.

/// Per-pixel surface data, row 0 on top, one sample at each pixel centre.
///
/// A missed pixel has depth +∞, shadow 1 and 0 in everything else; nothing is ever NaN.
#[derive(Clone, Debug, PartialEq)]
pub struct Aov {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Distance along the view axis, world units.
    pub depth: Vec<f32>,
    /// Position, world units.
    pub position: Vec<[f32; 3]>,
    /// Geometric normal of the displaced surface, world, unit, toward the viewer.
    pub normal: Vec<[f32; 3]>,
    /// Texture coordinates at the hit (those of the height map where there is one, else the first set), not wrapped.
    pub uv: Vec<[f32; 2]>,
    /// t / scale + midlevel at the hit; the midlevel on a plain surface.
    pub height_at_hit: Vec<f32>,
    /// First light in node order: 1 lit, 0 in shadow; 1 without a light.
    pub shadow: Vec<f32>,
    /// Scene-linear colour, Rec. 709 primaries, before exposure and tone mapping.
    pub color: Vec<[f32; 3]>,
}

impl Aov {
    /// A frame in which every pixel missed.
    pub fn missed(width: u32, height: u32) -> Self {
        let n = width as usize * height as usize;
        Aov {
            width,
            height,
            depth: vec![f32::INFINITY; n],
            position: vec![[0.0; 3]; n],
            normal: vec![[0.0; 3]; n],
            uv: vec![[0.0; 2]; n],
            height_at_hit: vec![0.0; n],
            shadow: vec![1.0; n],
            color: vec![[0.0; 3]; n],
        }
    }
}
