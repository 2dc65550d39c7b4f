//! What becomes of outlines: nothing, UV bounds and the horizon on the base surface, and a shell. README.md says where each
//! breaks.

use prism_engine::{
    error::Result,
    measure::Metrics,
    settings::{Horizon, March, Settings, Shell, Silhouette},
    shell::reference::{Reference, Shadows},
};

use crate::app::{
    grid::Grid,
    picture::Picture,
    sample::{Exhibit, Sample, Shot, Source},
};

const GRID: Grid = Grid { columns: 2, rows: 2 };

/// `prism run silhouette`.
pub struct Outlines;

impl Sample for Outlines {
    fn id(&self) -> &'static str {
        "silhouette"
    }

    fn summary(&self) -> &'static str {
        "Outlines of a plane, a cylinder and a sphere: none, UV bounds, horizon, and a shell, with each one's error"
    }

    fn scene(&self) -> Source {
        Source::Asset("silhouette.gltf")
    }

    /// A horizon strong enough to be seen.
    fn settings(&self) -> Settings {
        let horizon = Horizon { strength: 1.5, safe_threshold: 0.6, falloff: 1.0, ..Horizon::default() };
        Settings { horizon, ..Settings::default() }
    }

    fn moves(&self) -> bool {
        false
    }

    fn exhibit(&self) -> Option<&'static dyn Exhibit> {
        Some(&Four)
    }
}

/// Three cells of the base surface, clipped each in its way, and the shell.
struct Four;

impl Exhibit for Four {
    fn frame_size(&self, size: [u32; 2]) -> Result<[u32; 2]> {
        GRID.cell(size)
    }

    fn variants(&self, settings: &Settings) -> Vec<Settings> {
        let base = Settings { shell: Shell::Off, march: March::Exact, ..settings.clone() };
        let clipped = Silhouette::ALL.iter().map(|&silhouette| Settings { silhouette, ..base.clone() });
        let shell = if settings.resolved_shell() == Shell::Off { Shell::Auto } else { settings.shell };
        clipped.chain([Settings { shell, march: March::Exact, ..settings.clone() }]).collect()
    }

    fn compose(&self, shot: &Shot<'_>, size: [u32; 2]) -> (Picture, String) {
        let truth = Reference::new(shot.scene).render(shot.camera, shot.aov.width, shot.aov.height, Shadows::Skip);
        let names = Silhouette::ALL.iter().map(|silhouette| silhouette.name()).chain(["shell"]);
        let lines = names.zip(shot.variants).map(|(name, drawn)| {
            let m = Metrics::between(&drawn.aov, &truth, shot.camera);
            format!("{name:>10}: {:.4} of the covered pixels differ in coverage", m.coverage_differs)
        });
        let figures = lines.collect::<Vec<_>>().join("\n");
        (GRID.compose(size, shot.variants.iter().map(|drawn| &drawn.frame)), figures)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_is_a_cell_for_every_way() {
        let variants = Four.variants(&Outlines.settings());
        assert_eq!(variants.len() as u32, GRID.columns * GRID.rows);
        for &silhouette in Silhouette::ALL {
            assert!(variants.iter().any(|s| s.silhouette == silhouette && s.resolved_shell() == Shell::Off));
        }
        assert_ne!(variants.last().map(Settings::resolved_shell), Some(Shell::Off));
    }
}
