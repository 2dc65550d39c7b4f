//! Prism Shell's engine: displaced detail on coarse meshes by rays traced inside prism shells.

pub mod aov;
pub mod error;
pub mod gpu;
pub mod measure;
pub mod render;
pub mod scene;
pub mod settings;
pub mod shell;
