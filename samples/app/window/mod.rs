//! w
pub mod clock;
pub mod input;
pub mod orbit;
