//! What of a primitive's vertices follows from the rest of them, so that no shader reads it and nobody uploads it.

use glam::Vec3;

use super::ledger::{Ledger, Need};
use crate::scene::{Primitive, Scene};
use crate::shell::prisms::{self, ShellGeometry};

/// Normals that differ by no more are one direction: a few times the rounding of f32.
const SAME_NORMAL: f32 = 1e-6;

/// See above.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Derived {
    /// Each vertex's normal is its shell direction.
    pub normals: bool,
    /// The UV set that is, to the bit, the coordinates in the height map.
    pub uvs: Option<u8>,
}

impl Derived {
    /// Of a displaced primitive called `of`; of any other nothing. `shell_normals`: of its vertices, as long as its folds
    /// let them be. `deforms`: a pose moves its normals.
    pub fn new(
        scene: &Scene,
        primitive: &Primitive,
        shell: &ShellGeometry,
        shell_normals: &[Vec3],
        deforms: bool,
        of: &str,
        ledger: &mut Ledger,
    ) -> Derived {
        let Some(displacement) = prisms::displacement(scene, primitive) else { return Derived::default() };
        let along = |(normal, direction): (&Vec3, &Vec3)| normal.abs_diff_eq(*direction, SAME_NORMAL);
        let same = !deforms && primitive.normals.iter().zip(shell_normals).all(along);
        let why = if deforms { "a pose may shorten shell directions" } else { "some are not its shell's directions" };
        let normals = Need::when(!(shell.is_displaced() && same), why, "they are its shell's directions");
        let set = displacement.tex_coord;
        let shared = !ledger.keeps_all() && primitive.uvs[set] == *shell.height_uvs(primitive, &displacement);
        Derived { normals: !ledger.decide(of, "normals", normals), uvs: shared.then_some(set as u8) }
    }
}
