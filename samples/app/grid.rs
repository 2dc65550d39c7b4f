//! Pictures of one size in rows and columns.

use prism_engine::error::{Error, Result};

use super::picture::Picture;

/// Pixels between two cells.
const GAP: u32 = 2;
/// The gaps' colour, sRGB.
const BETWEEN: [u8; 3] = [24, 26, 30];

/// Columns and rows.
#[derive(Clone, Copy)]
pub struct Grid {
    /// Cells in a row.
    pub columns: u32,
    /// Rows.
    pub rows: u32,
}

impl Grid {
    /// Size of a cell in a picture of `size`.
    ///
    /// # Errors
    /// `Usage` where there is no room for a pixel each.
    pub fn cell(self, size: [u32; 2]) -> Result<[u32; 2]> {
        let [width, height] = size;
        let side = |whole: u32, count: u32| whole.saturating_sub((count - 1) * GAP) / count;
        let cell = [side(width, self.columns), side(height, self.rows)];
        if cell.contains(&0) {
            let Grid { columns, rows } = self;
            return Err(Error::Usage(format!(
                "--size {width}x{height} has no room for {columns}x{rows} cells; enlarge it"
            )));
        }
        Ok(cell)
    }

    /// The cells, row by row, in a picture of `size`.
    pub fn compose<'a>(self, size: [u32; 2], cells: impl Iterator<Item = &'a Picture>) -> Picture {
        let mut picture = Picture::filled(size, BETWEEN);
        for (i, cell) in (0..).zip(cells) {
            let [x, y] = [i % self.columns, i / self.columns];
            picture.paste(cell, [x * (cell.size[0] + GAP), y * (cell.size[1] + GAP)]);
        }
        picture
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_stand_in_their_places() {
        let grid = Grid { columns: 2, rows: 2 };
        let cell = grid.cell([8, 7]).unwrap();
        assert_eq!(cell, [3, 2]);
        let cells = [1, 2, 3, 4].map(|grey| Picture::filled(cell, [grey; 3]));
        let picture = grid.compose([8, 7], cells.iter());
        let at = |x: usize, y: usize| picture.pixels[y * 8 + x][0];
        assert_eq!([at(0, 0), at(5, 0), at(0, 4), at(7, 5)], [1, 2, 3, 4]);
        assert_eq!([at(3, 0), at(0, 3)], [BETWEEN[0]; 2]);
        assert!(grid.cell([3, 2]).is_err());
    }
}
