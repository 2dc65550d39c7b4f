//! The technique on the CPU: what a mesh's shells need before any ray is traced, and the f64 reference that judges
//! every renderer. Uses `scene` only.

pub mod bounds;
pub mod certificate;
pub mod cones;
pub mod follow;
pub mod heights;
pub mod hierarchy;
pub mod occlusion;
pub mod prisms;
pub mod reference;
pub mod walk;
