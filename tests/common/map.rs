//! Height maps: written as PNG, and read by the contract's rule in f64.

use std::io::Cursor;

use glam::DVec2;
use image::{DynamicImage, ImageBuffer, ImageFormat};

/// glTF's wrap modes, by their numbers in the file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Wrap {
    Repeat = 10497,
    Mirror = 33648,
    Clamp = 33071,
}

impl Wrap {
    /// The texel that index `i` of a row of `n` texels means.
    fn texel(self, i: i64, n: i64) -> i64 {
        match self {
            Wrap::Repeat => i.rem_euclid(n),
            Wrap::Clamp => i.clamp(0, n - 1),
            Wrap::Mirror => {
                let i = i.rem_euclid(2 * n);
                if i < n { i } else { 2 * n - 1 - i }
            }
        }
    }
}

/// A grey image.
#[derive(Clone, Debug)]
pub struct Map {
    width: u32,
    height: u32,
    texels: Texels,
}

#[derive(Clone, Debug)]
enum Texels {
    Eight(Vec<u8>),
    Sixteen(Vec<u16>),
}

impl Map {
    /// 8 bits a texel, row 0 on top.
    pub fn eight(width: u32, texels: &[u8]) -> Map {
        let height = texels.len() as u32 / width;
        assert_eq!(texels.len() as u32, width * height);
        Map { width, height, texels: Texels::Eight(texels.to_vec()) }
    }

    /// 16 bits a texel, row 0 on top.
    pub fn sixteen(width: u32, texels: &[u16]) -> Map {
        let height = texels.len() as u32 / width;
        assert_eq!(texels.len() as u32, width * height);
        Map { width, height, texels: Texels::Sixteen(texels.to_vec()) }
    }

    /// Texels without order, the same each time.
    pub fn noise(width: u32, height: u32) -> Map {
        let mut state = 1u32;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 16) as u16
        };
        Map::sixteen(width, &(0..width * height).map(|_| next()).collect::<Vec<_>>())
    }

    /// The file.
    pub fn png(&self) -> Vec<u8> {
        let image = match &self.texels {
            Texels::Eight(t) => ImageBuffer::from_raw(self.width, self.height, t.clone()).map(DynamicImage::ImageLuma8),
            Texels::Sixteen(t) => {
                ImageBuffer::from_raw(self.width, self.height, t.clone()).map(DynamicImage::ImageLuma16)
            }
        };
        let mut bytes = Cursor::new(Vec::new());
        image.expect("the sizes fit").write_to(&mut bytes, ImageFormat::Png).expect("writes to memory");
        bytes.into_inner()
    }

    fn texel(&self, x: i64, y: i64) -> f64 {
        let i = (y * i64::from(self.width) + x) as usize;
        match &self.texels {
            Texels::Eight(t) => f64::from(t[i]) / 255.0,
            Texels::Sixteen(t) => f64::from(t[i]) / 65535.0,
        }
    }

    /// The height at `uv`: bilinear, texel centres at (i + ½) / n.
    pub fn at(&self, uv: DVec2, wrap: [Wrap; 2]) -> f64 {
        let at = uv * DVec2::new(f64::from(self.width), f64::from(self.height)) - 0.5;
        let (low, part) = (at.floor(), at - at.floor());
        let texel = |dx: i64, dy: i64| {
            let x = wrap[0].texel(low.x as i64 + dx, i64::from(self.width));
            let y = wrap[1].texel(low.y as i64 + dy, i64::from(self.height));
            self.texel(x, y)
        };
        let row = |dy| texel(0, dy) * (1.0 - part.x) + texel(1, dy) * part.x;
        row(0) * (1.0 - part.y) + row(1) * part.y
    }
}
