//! The crates of each build of the engine are those that its README lists: nothing for windows, plots or user interfaces
//! unless it is asked for.

use std::{collections::BTreeSet, fs, path::Path, process::Command};

/// The engine's crates with some features, itself left out.
fn crates(features: &str) -> BTreeSet<String> {
    let arguments = "tree --offline --edges normal --prefix none --no-dedupe --target x86_64-unknown-linux-gnu \
                     --package prism-engine --no-default-features";
    let mut command = Command::new(env!("CARGO"));
    command.args(arguments.split_whitespace()).args(["--features", features]).current_dir(env!("CARGO_MANIFEST_DIR"));
    let output = command.output().expect("cargo runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let names = String::from_utf8_lossy(&output.stdout);
    names
        .lines()
        .filter_map(|line| line.split(' ').next())
        .filter(|name| *name != "prism-engine")
        .map(Into::into)
        .collect()
}

/// The names in the indented lines that follow `heading` in the engine's README.
fn listed(heading: &str) -> BTreeSet<String> {
    let readme =
        fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../engine/README.md")).expect("a README");
    let (_, after) = readme.split_once(heading).unwrap_or_else(|| panic!("no '{heading}'"));
    let lines = after.lines().skip_while(|line| !line.starts_with("    ")).take_while(|line| line.starts_with("    "));
    lines.flat_map(str::split_whitespace).map(Into::into).collect()
}

#[test]
fn the_readme_lists_the_crates_of_each_build() {
    let plain = crates("");
    assert_eq!(plain, listed("Without features:"), "engine/README.md, without features");
    let more: BTreeSet<_> = crates("window").difference(&plain).cloned().collect();
    assert_eq!(more, listed("Feature `window` adds:"), "engine/README.md, window");
    // Whatever the README says.
    for word in ["window", "winit", "wayland", "x11", "egui", "plot", "gltf-writer", "clap"] {
        let found: Vec<_> = plain.iter().filter(|name| name.contains(word)).collect();
        assert!(found.is_empty(), "a build without features has {found:?}");
    }
}
