//! A picture in memory, and pictures put together.

/// sRGB-encoded 8-bit RGBA, row 0 on top.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Row by row.
    pub pixels: Vec<[u8; 4]>,
}

impl Picture {
    /// Of one colour.
    pub fn filled(size: [u32; 2], [r, g, b]: [u8; 3]) -> Picture {
        Picture { size, pixels: vec![[r, g, b, 255]; size[0] as usize * size[1] as usize] }
    }

    /// Each pixel by its index.
    pub fn of(size: [u32; 2], colour: impl Fn(usize) -> [u8; 3]) -> Picture {
        let mut picture = Picture::filled(size, [0; 3]);
        for (i, pixel) in picture.pixels.iter_mut().enumerate() {
            pixel[..3].copy_from_slice(&colour(i));
        }
        picture
    }

    /// From the bytes of an image that was read back.
    pub fn from_bytes(size: [u32; 2], bytes: &[u8]) -> Picture {
        let (pixels, _) = bytes.as_chunks::<4>();
        Picture { size, pixels: pixels.to_vec() }
    }

    /// Puts the part of `other`, of the same size, that begins at a column over this one's.
    #[cfg(feature = "window")]
    pub fn paste_right(&mut self, other: &Picture, column: u32) {
        let width = self.size[0] as usize;
        let rows = self.pixels.chunks_exact_mut(width).zip(other.pixels.chunks_exact(width));
        rows.for_each(|(row, from)| row[column as usize..].copy_from_slice(&from[column as usize..]));
    }

    /// Puts `other` over this one with its left upper corner at `at`. What does not fit is cut off.
    pub fn paste(&mut self, other: &Picture, at: [u32; 2]) {
        let fits = |axis: usize| other.size[axis].min(self.size[axis].saturating_sub(at[axis])) as usize;
        let (width, height) = (fits(0), fits(1));
        for row in 0..height {
            let to = (at[1] as usize + row) * self.size[0] as usize + at[0] as usize;
            let from = row * other.size[0] as usize;
            self.pixels[to..to + width].copy_from_slice(&other.pixels[from..from + width]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_is_pasted_where_it_should_be_and_cut_at_the_edge() {
        let mut picture = Picture::filled([4, 3], [9, 9, 9]);
        picture.paste(&Picture::of([2, 2], |i| [i as u8, 0, 0]), [1, 0]);
        picture.paste(&Picture::filled([9, 9], [7, 7, 7]), [3, 2]);
        let red: Vec<u8> = picture.pixels.iter().map(|pixel| pixel[0]).collect();
        assert_eq!(red, [9, 0, 1, 9, 9, 2, 3, 9, 9, 9, 9, 7]);
    }
}
