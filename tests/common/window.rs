//! What the tests of windows share, whichever system opens them.

use std::{
    thread,
    time::{Duration, Instant},
};

use super::{Outcome, Picture, draw, folder, leftovers, program::Running};

/// For the window to come, to change, to go: a slow machine compiles shaders meanwhile.
pub const PATIENCE: Duration = Duration::from_secs(60);

/// Asks again and again until there is an answer.
#[track_caller]
pub fn wait<T>(what: &str, process: &mut Running, mut ask: impl FnMut() -> Option<T>) -> T {
    let begun = Instant::now();
    loop {
        if let Some(answer) = ask() {
            return answer;
        }
        assert!(!process.ended(), "the program ended while the test waited for {what}; it said:\n{}", process.said());
        assert!(begun.elapsed() < PATIENCE, "{what} did not come within {PATIENCE:?}");
        thread::sleep(Duration::from_millis(30));
    }
}

/// The picture that the same sample gives without a window.
pub fn headless(sample: &str, size: [u16; 2], flags: &str) -> Picture {
    let folder = folder();
    let flags = format!("--headless --size {}x{} {flags} --out frame.png", size[0], size[1]);
    draw("run", sample).words(&flags).within(folder.path()).succeeds();
    Picture::read(&folder.path().join("frame.png"))
}

/// The share of pixels that differ by more than a little.
pub fn difference(a: &Picture, b: &Picture) -> f64 {
    let differences = a.differences(b);
    differences.iter().filter(|d| **d > 8).count() as f64 / differences.len() as f64
}

/// Waits until the window's picture is this one.
#[track_caller]
pub fn comes_to_show(process: &mut Running, expected: &Picture, picture: impl Fn() -> Picture) {
    let mut last = f64::NAN;
    let begun = Instant::now();
    while begun.elapsed() < PATIENCE {
        assert!(!process.ended(), "the program ended; it said:\n{}", process.said());
        let seen = picture();
        if (seen.width, seen.height) == (expected.width, expected.height) {
            last = difference(&seen, expected);
            if last < 0.01 {
                return;
            }
        }
        thread::sleep(Duration::from_millis(50));
    }
    let kept = leftovers();
    picture().write(&kept.join("window-seen.png"));
    expected.write(&kept.join("window-expected.png"));
    panic!("the window is not the headless picture: {last:.3} of the pixels differ; see {}", kept.display());
}

/// Insists on success, and on no error on the way.
#[track_caller]
pub fn clean(outcome: Outcome) {
    let outcome = outcome.ends(0);
    // The window system has warnings of its own.
    let told = |line: &str| line.starts_with("error: ") || line.to_lowercase().contains("validation");
    assert!(!outcome.stderr.lines().any(told), "{outcome}");
}

/// Time that a process has had of a CPU so far, in the kernel's ticks of 10 ms.
pub fn ticks(process: &Running) -> u64 {
    let text = std::fs::read_to_string(format!("/proc/{}/stat", process.id())).expect("its state");
    // After the name, which may hold anything: utime and stime are the 14th and 15th field of all.
    let fields: Vec<&str> = text.rsplit(") ").next().expect("fields").split(' ').collect();
    fields[11..13].iter().map(|field| field.parse::<u64>().expect("a number")).sum()
}

/// Waits until a process takes no time: a whole second nearly without.
#[track_caller]
pub fn comes_to_rest(process: &mut Running) {
    let begun = Instant::now();
    while begun.elapsed() < PATIENCE {
        assert!(!process.ended(), "the program ended; it said:\n{}", process.said());
        let before = ticks(process);
        thread::sleep(Duration::from_secs(1));
        if ticks(process) - before <= 1 {
            return;
        }
    }
    panic!("the program does not come to rest");
}
