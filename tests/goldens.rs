//! The samples' pictures against those in `goldens/`, which someone has looked at.
//!
//! `PRISM_UPDATE_GOLDENS=1 tests/run -- --test goldens` makes them anew; look at them before they are committed.

mod common;

use std::{env, ffi::OsStr, fs, path::Path};

use common::{Picture, asset, draw, folder, leftovers};

/// lavapipe compiles for the CPU it finds: across CPU types a few pixels at edges and creases fall on the other side, and
/// no others change by more than rounding.
const MEAN: f64 = 0.15;
const STEADY: f64 = 0.99;
const ROUNDING: u8 = 4;
/// Of all pixels, those that may be anything.
const STRAY: f64 = 0.002;

fn compare(name: &str, command: &str, subject: &str, flags: &str) {
    compare_at("192x144", name, command, subject, flags);
}

fn compare_at(size: &str, name: &str, command: &str, subject: impl AsRef<OsStr>, flags: &str) {
    let folder = folder();
    let file = format!("{name}.png");
    let call = draw(command, subject).words(&format!("--headless --size {size} {flags} --out {file}"));
    call.within(folder.path()).succeeds();
    let actual = Picture::read(&folder.path().join(&file));
    let golden = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/goldens").join(&file);
    if env::var_os("PRISM_UPDATE_GOLDENS").is_some() {
        fs::create_dir_all(golden.parent().expect("a folder")).expect("the folder");
        fs::copy(folder.path().join(&file), &golden).expect("the golden");
        println!("wrote {}", golden.display());
        return;
    }
    let expected = Picture::read(&golden);
    let differences = actual.differences(&expected);
    let share = |above: u8| differences.iter().filter(|d| **d > above).count() as f64 / differences.len() as f64;
    let mean = differences.iter().map(|d| f64::from(*d)).sum::<f64>() / differences.len() as f64;
    let (uneven, stray) = (share(ROUNDING), share(24));
    println!("{name}: mean {mean:.4}, above {ROUNDING}: {uneven:.5}, above 24: {stray:.5}");
    if mean <= MEAN && uneven <= 1.0 - STEADY && stray <= STRAY {
        return;
    }
    let kept = leftovers();
    let amplified = differences.iter().map(|d| [d.saturating_mul(8); 3]).collect();
    actual.write(&kept.join(&file));
    Picture { pixels: amplified, ..actual }.write(&kept.join(format!("{name}-difference.png")));
    panic!(
        "{name}: not the picture in {}: mean difference {mean:.3} (at most {MEAN}), {uneven:.4} of the pixels off by more \
         than {ROUNDING} (at most {:.4}), {stray:.4} by more than 24 (at most {STRAY}). Picture and difference × 8 are in {}",
        golden.display(),
        1.0 - STEADY,
        kept.display()
    );
}

#[test]
fn prism_shell() {
    compare("prism_shell", "run", "prism_shell", "");
}

#[test]
fn prism_shell_a_quarter_turn_later() {
    compare("prism_shell_later", "run", "prism_shell", "--frames 2 --time-step 10");
}

#[test]
fn techniques() {
    // Its fifteen cells lie down.
    compare_at("260x108", "techniques", "run", "techniques", "");
}

/// Near enough, and by so few steps, where it takes any, that the searches differ to the eye.
fn technique(shell: &str, march: &str) {
    let name = format!("technique_{shell}_{march}");
    let steps = if STEPPED.contains(&march) { "--min-steps 3 --max-steps 6" } else { "" };
    let flags = format!("--fov-y 12 --shell {shell} --march {march} {steps}");
    compare_at("128x72", &name, "render", asset("techniques.gltf"), &flags);
}

const STEPPED: [&str; 5] = ["steep", "pom", "relief", "secant", "contact"];
const OTHER_RAYS: [&str; 3] = ["cone", "relaxed-cone", "exact"];

#[test]
fn each_technique_on_the_base_surface() {
    let techniques = ["none", "normal", "offset"].into_iter().chain(STEPPED).chain(OTHER_RAYS);
    techniques.for_each(|march| technique("off", march));
}

#[test]
fn each_technique_in_a_shell() {
    STEPPED.into_iter().chain(OTHER_RAYS).for_each(|march| technique("walk", march));
}

#[test]
fn silhouette() {
    compare("silhouette", "run", "silhouette", "");
}

#[test]
fn depth_offset() {
    compare("depth_offset", "run", "depth_offset", "");
}

#[test]
fn terrain() {
    compare("terrain", "run", "terrain", "");
}

#[test]
fn self_shadow() {
    compare("self_shadow", "run", "self_shadow", "");
}

#[test]
fn viewer() {
    compare("viewer", "run", "viewer", "");
}

#[test]
fn viewer_without_a_shell() {
    compare("viewer_base", "run", "viewer", "--shell off");
}
