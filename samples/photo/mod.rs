//! Photographs of bricks and grass in grey: colours and heights are invented from their tone. README.md says how, and what
//! to look at.

use prism_engine::{
    error::Result,
    settings::{March, Settings, Shell},
};

use crate::app::{
    grid::Grid,
    picture::Picture,
    sample::{Drawn, Exhibit, Sample, Shot, Source},
};

const GRID: Grid = Grid { columns: 2, rows: 1 };

/// `prism run photo`.
pub struct Photographs;

impl Sample for Photographs {
    fn id(&self) -> &'static str {
        "photo"
    }

    fn summary(&self) -> &'static str {
        "Photographs of bricks and grass, flat and with heights invented from their tone"
    }

    fn scene(&self) -> Source {
        Source::Asset("photo.gltf")
    }

    fn moves(&self) -> bool {
        false
    }

    fn exhibit(&self) -> Option<&'static dyn Exhibit> {
        Some(&FlatAndDeep)
    }
}

/// The photographs alone on the left, with their heights on the right.
struct FlatAndDeep;

impl Exhibit for FlatAndDeep {
    fn frame_size(&self, size: [u32; 2]) -> Result<[u32; 2]> {
        GRID.cell(size)
    }

    fn variants(&self, settings: &Settings) -> Vec<Settings> {
        let flat = Settings { shell: Shell::Off, march: March::None, ..settings.clone() };
        vec![flat, settings.clone()]
    }

    fn compose(&self, shot: &Shot<'_>, size: [u32; 2]) -> (Picture, String) {
        let covered = |drawn: &Drawn| drawn.aov.depth.iter().filter(|depth| depth.is_finite()).count().to_string();
        let covered = shot.variants.iter().map(covered).collect::<Vec<_>>().join(", with heights ");
        let figures = format!("{}: pixels covered by the flat photographs {covered}", shot.name);
        (GRID.compose(size, shot.variants.iter().map(|drawn| &drawn.frame)), figures)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_right_one_has_heights() {
        let [flat, deep] = &FlatAndDeep.variants(&Photographs.settings())[..] else { panic!("two") };
        assert!(!flat.march.traces() && flat.resolved_shell() == Shell::Off);
        assert!(deep.march.traces() && deep.resolved_shell() != Shell::Off);
    }
}
