//! What a user would take instead of a shell, built to be as fast as it can be: the speed contest's other side.

mod clusters;
mod cull;
mod dice;
mod draw;
mod micro_mesh;
mod surface;

pub use cull::Sides;
pub use dice::{Diced, Dicing};
pub use draw::{Drawable, VERTEX_LAYOUT};
pub use micro_mesh::{MAX_DENSITY, MicroMesh};
