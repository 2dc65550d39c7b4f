//! Depth offset: sand by parallax, and rocks whose depth is moved by noise, so that both blend. README.md says what to
//! look at.

use prism_engine::{
    error::Result,
    settings::{March, Settings, Shell},
};

use crate::app::{
    grid::Grid,
    picture::Picture,
    sample::{Exhibit, Sample, Shot, Source},
};

const GRID: Grid = Grid { columns: 2, rows: 1 };

/// `prism run depth_offset`.
pub struct Sand;

impl Sample for Sand {
    fn id(&self) -> &'static str {
        "depth_offset"
    }

    fn summary(&self) -> &'static str {
        "Sand that blends into rocks by a dithered depth offset, beside the same without"
    }

    fn scene(&self) -> Source {
        Source::Asset("depth_offset.gltf")
    }

    /// A base surface, where the offset is a choice.
    fn settings(&self) -> Settings {
        Settings { shell: Shell::Off, march: March::Relief, ..Settings::default() }
    }

    fn moves(&self) -> bool {
        false
    }

    fn exhibit(&self) -> Option<&'static dyn Exhibit> {
        Some(&WithAndWithout)
    }
}

/// Without on the left, with it on the right.
struct WithAndWithout;

impl Exhibit for WithAndWithout {
    fn frame_size(&self, size: [u32; 2]) -> Result<[u32; 2]> {
        GRID.cell(size)
    }

    fn variants(&self, settings: &Settings) -> Vec<Settings> {
        let base = Settings { shell: Shell::Off, ..settings.clone() };
        [false, true].map(|depth_offset| Settings { depth_offset, ..base.clone() }).to_vec()
    }

    fn compose(&self, shot: &Shot<'_>, size: [u32; 2]) -> (Picture, String) {
        let frames = || shot.variants.iter().map(|drawn| &drawn.frame);
        let pixels = shot.variants.iter().map(|drawn| &drawn.frame.pixels).collect::<Vec<_>>();
        let differ = match pixels[..] {
            [without, with] => without.iter().zip(with).filter(|(a, b)| a != b).count(),
            _ => 0,
        };
        let figures = format!("{}: the depth offset changes {differ} pixels", shot.name);
        (GRID.compose(size, frames()), figures)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_two_differ_in_the_offset_alone() {
        let [without, with] = &WithAndWithout.variants(&Sand.settings())[..] else { panic!("two") };
        assert!(!without.depth_offset && with.depth_offset);
        assert_eq!(Settings { depth_offset: true, ..without.clone() }, *with);
    }
}
