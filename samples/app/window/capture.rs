//! A frame for RenderDoc, where the program runs under it.

use renderdoc::{RenderDoc, V100};

/// Lets RenderDoc take the next frame that is presented. What came of it, for the user.
pub fn next_frame() -> &'static str {
    // Only one that is loaded already counts: it has to see the device made.
    match RenderDoc::<V100>::new() {
        Ok(mut renderdoc) => {
            renderdoc.trigger_capture();
            "RenderDoc takes the next frame"
        }
        Err(_) => "RenderDoc is not there: start prism from it, or with its library preloaded",
    }
}
