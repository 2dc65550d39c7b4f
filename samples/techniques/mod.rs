//! Every technique in one picture, from none to the exact shell, the f64 reference last. README.md says what to look at.

use prism_engine::{
    error::Result,
    measure::Metrics,
    settings::{March, Settings, Shell, Silhouette},
    shell::reference::{Reference, Shadows},
};

use crate::app::{
    clay,
    grid::Grid,
    picture::Picture,
    sample::{Exhibit, Sample, Shot, Source},
};

/// Room for all cells and the reference.
const GRID: Grid = Grid { columns: 5, rows: 3 };

/// From the plainest to the finest, row by row.
const CELLS: [(Shell, March); 14] = [
    (Shell::Off, March::None),
    (Shell::Off, March::Normal),
    (Shell::Off, March::Offset),
    (Shell::Off, March::Steep),
    (Shell::Off, March::Pom),
    (Shell::Off, March::Relief),
    (Shell::Off, March::Secant),
    (Shell::Off, March::Contact),
    (Shell::Off, March::Cone),
    (Shell::Off, March::RelaxedCone),
    (Shell::Off, March::Exact),
    (Shell::Auto, March::Pom),
    (Shell::Auto, March::Relief),
    (Shell::Auto, March::Exact),
];

/// `prism run techniques`.
pub struct Techniques;

impl Sample for Techniques {
    fn id(&self) -> &'static str {
        "techniques"
    }

    fn summary(&self) -> &'static str {
        "Every technique on a cube and a torus, from none to the exact shell, with each one's error; the reference last"
    }

    fn scene(&self) -> Source {
        Source::Asset("techniques.gltf")
    }

    /// So few steps that the searches differ to the eye.
    fn settings(&self) -> Settings {
        Settings { min_steps: 6, max_steps: 12, ..Settings::default() }
    }

    fn moves(&self) -> bool {
        false
    }

    fn exhibit(&self) -> Option<&'static dyn Exhibit> {
        Some(&Ladder)
    }
}

struct Ladder;

impl Exhibit for Ladder {
    fn frame_size(&self, size: [u32; 2]) -> Result<[u32; 2]> {
        GRID.cell(size)
    }

    fn variants(&self, settings: &Settings) -> Vec<Settings> {
        let cell = |&(shell, march): &(Shell, March)| {
            let shell =
                if shell == Shell::Auto && settings.resolved_shell() != Shell::Off { settings.shell } else { shell };
            // Clipping would take from some cells what the others show.
            let refine_steps = march.usual_refine_steps();
            Settings { shell, march, refine_steps, silhouette: Silhouette::None, ..settings.clone() }
        };
        CELLS.iter().map(cell).collect()
    }

    fn compose(&self, shot: &Shot<'_>, size: [u32; 2]) -> (Picture, String) {
        let truth = Reference::new(shot.scene).render(shot.camera, shot.aov.width, shot.aov.height, Shadows::Skip);
        let reference = clay::of(&truth, shot.camera);
        let cells = shot.variants.iter().map(|drawn| &drawn.frame).chain([&reference]);
        let lines = CELLS.iter().zip(shot.variants).map(|((shell, march), drawn)| {
            let m = Metrics::between(&drawn.aov, &truth, shot.camera);
            let place = if *shell == Shell::Off { "base surface" } else { "shell" };
            format!(
                "{:>12}, {place:<12} depth error p50 {:.1e}, p99 {:.1e} footprints; coverage differs {:.1e}",
                march.name(),
                m.depth_p50,
                m.depth_p99,
                m.coverage_differs
            )
        });
        let figures = lines.collect::<Vec<_>>().join("\n");
        (GRID.compose(size, cells), figures)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_grid_has_a_cell_for_every_technique_and_the_reference() {
        assert_eq!((GRID.columns * GRID.rows) as usize, CELLS.len() + 1);
        for &march in March::ALL {
            assert!(CELLS.iter().any(|&(shell, shown)| shown == march && shell == Shell::Off), "{march}");
        }
        for settings in Ladder.variants(&Techniques.settings()) {
            assert!(settings.resolved_shell() == Shell::Off || settings.march.traces(), "{settings:?}");
        }
    }
}
