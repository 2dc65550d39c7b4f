//! A sample in a window under Wayland: in sway, without a screen, each test in one of its own.

mod common;

use std::{
    ffi::OsStr,
    fs,
    os::unix::{self, fs::MetadataExt as _, process::CommandExt as _},
    path::PathBuf,
    process::{Child, Command, Stdio},
    thread,
    time::{Duration, Instant},
};

use common::{
    Picture, draw, folder,
    program::Running,
    window::{PATIENCE, clean, comes_to_rest, comes_to_show, headless, ticks, wait},
};
use serde_json::Value;

/// The user and the group `nobody` of every Linux.
const NOBODY: u32 = 65534;

/// Windows float and have no borders: what a client asks for is what it gets. The second output has two pixels a point.
const CONFIG: &str = "\
xwayland disable
floating_minimum_size 16 x 16
for_window [title=\".*\"] floating enable, border none
output HEADLESS-1 mode 800x600 position 0 0
output HEADLESS-2 mode 1600x1200 position 800 0 scale 2
";

/// A compositor; it ends when it goes out of scope.
struct Desk {
    folder: tempfile::TempDir,
    sway: Child,
}

impl Desk {
    fn open() -> Desk {
        let folder = folder();
        let at = folder.path();
        fs::write(at.join("config"), CONFIG).expect("a file");
        let mut command = Command::new("sway");
        command.args(["--config", "config"]).current_dir(at).stdout(Stdio::null());
        command.stderr(fs::File::create(at.join("log")).expect("a file"));
        // No socket of another one's, no screen, no GPU, no device to be moved or typed on.
        command.env_remove("WAYLAND_DISPLAY").env_remove("DISPLAY");
        command.env("XDG_RUNTIME_DIR", at).env("HOME", at).env("SWAYSOCK", at.join("control"));
        command.envs([("WLR_BACKENDS", "headless"), ("WLR_RENDERER", "pixman"), ("WLR_HEADLESS_OUTPUTS", "2")]);
        command.env("WLR_LIBINPUT_NO_DEVICES", "1");
        // It refuses to run as root.
        if fs::metadata("/proc/self").expect("this process").uid() == 0 {
            unix::fs::chown(at, Some(NOBODY), Some(NOBODY)).expect("a folder of its own");
            command.uid(NOBODY).gid(NOBODY);
        }
        let sway = command.spawn().expect("sway, which .ci/setup installs");
        let mut desk = Desk { folder, sway };
        let begun = Instant::now();
        while !desk.socket().exists() || desk.ask(&["-t", "get_outputs"]).is_none() {
            let log = || fs::read_to_string(desk.folder.path().join("log")).unwrap_or_default();
            assert!(desk.sway.try_wait().expect("its state").is_none(), "sway ended:\n{}", log());
            assert!(begun.elapsed() < PATIENCE, "sway does not answer:\n{}", log());
            thread::sleep(Duration::from_millis(30));
        }
        desk
    }

    fn socket(&self) -> PathBuf {
        self.folder.path().join("wayland-1")
    }

    fn client(&self, program: &str) -> Command {
        let mut command = Command::new(program);
        command.env("XDG_RUNTIME_DIR", self.folder.path()).env("WAYLAND_DISPLAY", self.socket());
        command.env("SWAYSOCK", self.folder.path().join("control"));
        command
    }

    /// What swaymsg answers.
    fn ask(&self, words: &[&str]) -> Option<Value> {
        let output = self.client("swaymsg").arg("--raw").args(words).output().expect("swaymsg, a part of sway");
        output.status.success().then(|| serde_json::from_slice(&output.stdout).expect("JSON"))
    }

    /// Does something to the only window.
    fn tell(&self, what: &str) {
        assert!(self.ask(&[&format!("[title=\".*\"] {what}")]).is_some(), "{what}");
    }

    /// `prism run SAMPLE` in a window of 320 × 240.
    fn start(&self, sample: &str, flags: &str) -> Running {
        let call = draw("run", sample).words("--size 320x240").words(flags);
        call.env("XDG_RUNTIME_DIR", self.folder.path()).env("WAYLAND_DISPLAY", self.socket()).start()
    }

    /// The only window, as the compositor has it, once it is there.
    fn window(&self) -> Option<Value> {
        fn found(node: &Value) -> Option<&Value> {
            let inner = ["nodes", "floating_nodes"].into_iter().filter_map(|kind| node[kind].as_array()).flatten();
            if node["pid"].is_u64() { Some(node) } else { inner.into_iter().find_map(found) }
        }
        found(&self.ask(&["-t", "get_tree"])?).cloned()
    }

    fn title(&self) -> String {
        self.window().and_then(|window| Some(window["name"].as_str()?.to_owned())).unwrap_or_default()
    }

    /// What the window shows, in the pixels of its output; nothing of a window that is not there.
    fn picture(&self) -> Picture {
        let window = self.window().map_or(Value::Null, |window| window["rect"].clone());
        let [x, y, width, height] = ["x", "y", "width", "height"].map(|name| window[name].as_i64().unwrap_or(0));
        if width * height == 0 {
            return Picture { width: 0, height: 0, pixels: Vec::new() };
        }
        let path = self.folder.path().join("seen.png");
        let status = self.client("grim").args(["-g", &format!("{x},{y} {width}x{height}")]).arg(&path).status();
        assert!(status.expect("grim, which .ci/setup installs").success());
        Picture::read(&path)
    }

    fn shows(&self, process: &mut Running, expected: &Picture) {
        comes_to_show(process, expected, || self.picture());
    }

    /// Presses a key on a keyboard that is there only for it; the program has a moment to see that keyboard come.
    fn press(&self, key: impl AsRef<OsStr>) {
        let status = self.client("wtype").args(["-s", "300", "-k"]).arg(key).args(["-s", "100"]).status();
        assert!(status.expect("wtype, which .ci/setup installs").success());
    }
}

impl Drop for Desk {
    fn drop(&mut self) {
        // Of a child that has ended there is nothing to kill, and nothing to say.
        let _ = self.sway.kill();
        let _ = self.sway.wait();
    }
}

const PLAIN: &str = "--shell off --march none";

#[test]
fn a_sample_is_shown_resized_switched_moved_to_a_finer_screen_and_left_with_a_key() {
    let desk = Desk::open();
    let mut process = desk.start("viewer", PLAIN);
    desk.shows(&mut process, &headless("viewer", [320, 240], PLAIN));
    assert_eq!(desk.window().expect("a window")["app_id"], "prism");
    comes_to_rest(&mut process);

    for [width, height] in [[400, 200], [250, 310], [64, 48], [320, 240]] {
        desk.tell(&format!("resize set {width} px {height} px"));
        desk.shows(&mut process, &headless("viewer", [width, height], PLAIN));
    }

    // A key may come before the program knows of its keyboard.
    wait("the view of UV", &mut process, || {
        desk.press("8");
        desk.title().contains("view uv").then_some(())
    });
    let uv = format!("{PLAIN} --view uv");
    desk.shows(&mut process, &headless("viewer", [320, 240], &uv));

    // As many points are four times as many pixels there, and back.
    desk.tell("move container to output HEADLESS-2");
    desk.shows(&mut process, &headless("viewer", [640, 480], &uv));
    desk.tell("move container to output HEADLESS-1");
    desk.shows(&mut process, &headless("viewer", [320, 240], &uv));
    comes_to_rest(&mut process);

    // sway takes the keyboard away from what leaves a screen.
    desk.tell("focus");
    desk.press("Escape");
    clean(process.wait());
}

#[test]
fn a_sample_that_moves_rests_while_it_is_hidden_and_goes_on_after() {
    let desk = Desk::open();
    let mut process = desk.start("prism_shell", PLAIN);
    let moves = |process: &mut Running| {
        let begun = ticks(process);
        wait("a moving picture", process, || {
            let before = desk.picture();
            thread::sleep(Duration::from_millis(200));
            let after = desk.picture();
            (before.width > 0 && before.pixels != after.pixels).then_some(())
        });
        assert!(ticks(process) > begun);
    };
    moves(&mut process);
    desk.tell("move container to workspace elsewhere");
    comes_to_rest(&mut process);
    // Another size meanwhile.
    desk.tell("resize set 200 px 100 px");
    comes_to_rest(&mut process);
    assert!(desk.ask(&["workspace elsewhere"]).is_some());
    moves(&mut process);
    assert_eq!([desk.picture().width, desk.picture().height], [200, 100]);
    // It closes out of sight, too.
    assert!(desk.ask(&["workspace another"]).is_some());
    comes_to_rest(&mut process);
    desk.tell("kill");
    clean(process.wait());
}
