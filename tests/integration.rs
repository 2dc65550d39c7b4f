//! The renderer on another engine's device and in its command buffer: sample `integration`.

mod common;

use common::{Picture, STAGES, asset, draw, folder};

/// Rows of the bar that the sample's host draws at the picture's foot.
const BAR: u32 = 8;

/// Above the host's bar the picture is to the bit what the program draws on a device of its own.
#[test]
fn a_host_gets_the_same_picture() {
    let folder = folder();
    for stage in STAGES {
        let path = |name: &str| folder.path().join(format!("{stage} {name}.png"));
        let flags = format!("--size 96x72 --shell prism --march steep --stage {stage}");
        let hosted = draw("run", "integration").words(&flags).arg("--out").arg(path("hosted")).succeeds();
        assert!(!hosted.stderr.to_lowercase().contains("validation"), "{hosted}");
        draw("render", asset("prism_shell.gltf")).words(&flags).arg("--out").arg(path("own")).succeeds();
        let (hosted, own) = (Picture::read(&path("hosted")), Picture::read(&path("own")));
        assert!(own.colours() > 100, "a picture");
        for (i, difference) in (0..).zip(hosted.differences(&own)) {
            let (x, y) = (i % own.width, i / own.width);
            if y < own.height - BAR {
                assert_eq!(difference, 0, "{stage}: pixel {x}, {y}");
            } else {
                assert_eq!(hosted.pixels[i as usize], *hosted.pixels.last().expect("pixels"), "{stage}: {x}, {y}");
            }
        }
    }
}

/// What the application would have to do is not ignored.
#[test]
fn flags_that_the_sample_cannot_honour_are_refused() {
    let folder = folder();
    for flags in ["--stats", "--aov a.exr", "--csv a.csv", "--frames 2", "--gpu 0"] {
        draw("run", "integration").words(flags).within(folder.path()).run().ends(2).complains(&["integration"]);
    }
}
