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

use self::micro_mesh::MicroVertex;
use super::layout::DicedTriangle;
use super::plan::{PlannedPrimitive, source};
use crate::error::Result;
use crate::scene::Scene;
use crate::settings::{Baseline, Culling};

/// The buffers of a baseline's primitive that are its own, by name, and their bytes. `name`: the primitive's. `named`: a
/// visibility buffer names its triangles.
///
/// # Errors
/// Those of [`MicroMesh::new`].
pub fn buffers(
    scene: &Scene,
    planned: &PlannedPrimitive,
    name: &str,
    baseline: Baseline,
    named: bool,
) -> Result<Vec<(String, usize)>> {
    let (density, culling) = match baseline {
        Baseline::MicroMesh { density, culling } => (density, culling),
        Baseline::Diced { .. } => {
            let triangles = source(scene, planned).triangles.len();
            return Ok(vec![(format!("{name} diced triangles"), size_of::<DicedTriangle>() * triangles)]);
        }
    };
    let [vertices, indices] = micro_mesh::size(scene, planned, density)?;
    let mut buffers = vec![
        (format!("{name} micro-vertices"), size_of::<MicroVertex>() * vertices),
        (format!("{name} micro-indices"), draw::bytes_of_index(culling, named) * indices),
    ];
    if culling == Culling::Triangles {
        let own = cull::buffers(indices / 3);
        buffers.extend(own.map(|(name, bytes)| (name.to_owned(), bytes)));
    }
    Ok(buffers)
}
