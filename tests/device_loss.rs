//! A GPU that hangs or is taken away: the program says so, with the pass that it was last given, and ends.

mod common;

use common::{
    folder,
    losing::{Losing, tells_of_the_loss},
    prism,
};

#[test]
fn a_device_lost_in_the_middle_of_a_run_is_told_with_its_last_pass() {
    let folder = folder();
    let losing = Losing::new(folder.path());
    for function in ["vkQueueSubmit2", "vkWaitForFences"] {
        let run = prism(
            "run viewer --headless --frames 60 --size 64x48 --shell off --march none --validation off --out lost.png",
        );
        let outcome = losing.loses(run.within(folder.path()), function, 30).run();
        tells_of_the_loss(outcome, "surface");
        assert!(!folder.path().join("lost.png").exists(), "a picture of a frame that was not drawn");
    }
}
