//! The application around the samples: command line, headless and window loop, output files.

pub mod assets;
pub mod camera;
pub mod choices;
pub mod cli;
pub mod console;
pub mod files;
pub mod job;
pub mod exr;
pub mod png;
pub mod sample;
pub mod still;
#[cfg(test)]
pub mod testing;
pub mod timings;
pub mod window;
