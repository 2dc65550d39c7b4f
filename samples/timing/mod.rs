//! Fair timing of several ways to draw, on one device: what `bench` and `report` share.
// Only the report needs all of it.
#![cfg_attr(not(feature = "report"), allow(dead_code, unused_imports))]

mod device;
mod rounds;

pub use device::{CULLS_BY, Device, Drawn, View, grown, mib};
pub use rounds::{Rounds, Spread, Timing, WARM_UP};
