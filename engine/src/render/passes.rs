//! The passes of a frame that draw into its targets, in order.

use super::plan::Draw;
use super::variant::Geometry;
use super::visibility;

/// The pass of lines over the picture.
pub const EDGES: &str = "edges";

/// Draws into one set of targets.
pub struct DrawPass {
    /// Its name, as in `--stats`.
    pub name: &'static str,
    /// Indices of the draws.
    pub draws: Vec<usize>,
    /// Of [`super::plan::Plan::aov_draws`].
    pub of_aov: bool,
    /// Colours too, not depth alone.
    pub shades: bool,
    /// Whether it is the first to draw depth, and to shade.
    pub clear: [bool; 2],
    /// 1 where it draws what the depth so far does not hide of shells, and the pass before it did not draw.
    pub round: u32,
    /// What it has to do with the visibility buffer.
    pub part: Part,
}

/// A pass's part in drawing by the visibility buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// None.
    None,
    /// Writes it.
    Write,
    /// Walks from the lids that it names, or shades the triangles, with one over the picture for each draw.
    Resolve,
    /// Draws what these walks have not.
    Rest,
}

impl DrawPass {
    /// Whether the prisms of some of its draws are listed before it.
    pub fn lists(&self, draws: &[Draw]) -> bool {
        self.part != Part::Resolve && self.draws.iter().any(|index| draws[*index].cull.is_some())
    }

    /// Name of the pass before it that lists its prisms.
    pub fn culling(&self) -> &'static str {
        match (self.round, self.part) {
            (0, Part::Rest) => "culling of the rest",
            (0, _) => "culling",
            _ => "culling again",
        }
    }
}

/// Whether a draw is of lines over the picture.
fn is_edges(draw: &Draw) -> bool {
    matches!(draw.variant.geometry, Geometry::BaseEdges | Geometry::PrismEdges)
}

/// Depth first, where it comes first. Then surfaces: they are cheap, and their depth spares the shells' fragments behind
/// them. Lines over all of it last. The picture has a pass even without any draw, to be cleared.
pub fn passes(draws: &[Draw], of_aov: bool) -> Vec<DrawPass> {
    let (edges, filled): (Vec<_>, Vec<_>) = (0..draws.len()).partition(|i| is_edges(&draws[*i]));
    let (shells, others): (Vec<_>, Vec<_>) = filled.into_iter().partition(|i| draws[*i].is_shell());
    let (meshes, surfaces): (Vec<_>, Vec<_>) = others.into_iter().partition(|i| draws[*i].visibility.is_some());
    let depths: Vec<_> = surfaces.iter().chain(&shells).copied().filter(|i| draws[*i].depth.is_some()).collect();
    let [surface, shell] = if of_aov { ["surface aov", "shell aov"] } else { ["surface", "shell"] };
    let again: Vec<_> = shells.iter().copied().filter(|i| draws[*i].hides()).collect();
    let named: Vec<_> = shells.iter().copied().filter(|i| draws[*i].visibility.is_some()).collect();
    let (rest, part) = if named.is_empty() { (shell, Part::None) } else { (visibility::REST, Part::Rest) };
    let mut passes = Vec::new();
    let mut clear = [true; 2];
    for (name, indices, shades, round, part) in [
        ("depth", depths, false, 0, Part::None),
        (surface, surfaces, true, 0, Part::None),
        (visibility::PASS, meshes.clone(), false, 0, Part::Write),
        (visibility::MESH, meshes, true, 0, Part::Resolve),
        (visibility::PASS, named.clone(), false, 0, Part::Write),
        (shell, named, true, 0, Part::Resolve),
        (rest, shells, true, 0, part),
        ("shell again", again, true, 1, Part::None),
        (EDGES, edges, true, 0, Part::None),
    ] {
        let needed = name == "surface" && draws.is_empty();
        if indices.is_empty() && !needed {
            continue;
        }
        let writes_lids = part == Part::Write && indices.iter().any(|i| draws[*i].is_shell());
        passes.push(DrawPass { name, draws: indices, of_aov, shades, clear, round, part });
        // Lids are named with a depth of their own.
        if !writes_lids {
            clear = [false, clear[1] && !shades];
        }
    }
    passes
}
