//! A sample in a window, driven as a user drives it: through the X server that DISPLAY names.

mod common;

use std::{
    env, fs,
    path::{Path, PathBuf},
    sync::{Mutex, MutexGuard, PoisonError},
    thread,
    time::{Duration, Instant},
};

use common::{
    Picture, asset, draw, folder,
    losing::{Losing, tells_of_the_loss},
    prism,
    program::Running,
    window::{clean, comes_to_rest, comes_to_show, difference, headless, wait},
};
use x11rb::{
    connection::Connection,
    protocol::{
        randr::{ConnectionExt as _, MonitorInfo},
        xproto::{
            Atom, AtomEnum, BUTTON_PRESS_EVENT, BUTTON_RELEASE_EVENT, ClientMessageEvent, ConfigureWindowAux,
            ConnectionExt as _, CreateWindowAux, EventMask, ImageFormat, InputFocus, KEY_PRESS_EVENT,
            KEY_RELEASE_EVENT, MOTION_NOTIFY_EVENT, MapState, PropMode, StackMode, Window, WindowClass,
        },
        xtest::ConnectionExt as _,
    },
    rust_connection::RustConnection,
    wrapper::ConnectionExt as _,
};

/// What the keys send: the letters' own code points, and Escape's number in the X protocol.
const ESCAPE: u32 = 0xff1b;

/// The client that watches the program and presses its keys.
struct User {
    x: RustConnection,
    root: Window,
}

impl User {
    fn connect() -> User {
        assert!(env::var_os("DISPLAY").is_some(), "these tests need an X server: tests/run starts one");
        let (x, screen) = x11rb::connect(None).expect("the X server");
        let root = x.setup().roots[screen].root;
        User { x, root }
    }

    fn atom(&self, name: &str) -> Atom {
        self.x.intern_atom(false, name.as_bytes()).expect("sent").reply().expect("an atom").atom
    }

    fn property(&self, window: Window, name: &str, kind: impl Into<Atom>) -> Vec<u8> {
        let cookie = self.x.get_property(false, window, self.atom(name), kind, 0, 1024).expect("sent");
        cookie.reply().map(|reply| reply.value).unwrap_or_default()
    }

    fn title(&self, window: Window) -> String {
        String::from_utf8_lossy(&self.property(window, "_NET_WM_NAME", self.atom("UTF8_STRING"))).into_owned()
    }

    /// The window of this process, once it is shown.
    fn window_of(&self, process: &mut Running) -> Window {
        let pid = process.id();
        wait("its window", process, || {
            let tree = self.x.query_tree(self.root).expect("sent").reply().expect("the windows");
            tree.children.into_iter().find(|&window| {
                let owner = self.property(window, "_NET_WM_PID", AtomEnum::CARDINAL);
                let attributes = self.x.get_window_attributes(window).expect("sent").reply();
                owner == pid.to_ne_bytes() && attributes.is_ok_and(|a| a.map_state == MapState::VIEWABLE)
            })
        })
    }

    fn size(&self, window: Window) -> [u16; 2] {
        let geometry = self.x.get_geometry(window).expect("sent").reply().expect("its size");
        [geometry.width, geometry.height]
    }

    /// What the window shows.
    fn picture(&self, window: Window) -> Picture {
        let [width, height] = self.size(window);
        let cookie = self.x.get_image(ImageFormat::Z_PIXMAP, window, 0, 0, width, height, !0).expect("sent");
        let image = cookie.reply().expect("its content");
        assert_eq!(image.data.len(), 4 * usize::from(width) * usize::from(height), "32 bits a pixel");
        // Little-endian X servers store blue first.
        let pixels = image.data.chunks_exact(4).map(|p| [p[2], p[1], p[0]]).collect();
        Picture { width: width.into(), height: height.into(), pixels }
    }

    fn focus(&self, window: Window) {
        self.x.set_input_focus(InputFocus::PARENT, window, x11rb::CURRENT_TIME).expect("sent");
        self.x.flush().expect("sent");
    }

    fn press(&self, symbol: u32) {
        let setup = self.x.setup();
        let (first, count) = (setup.min_keycode, setup.max_keycode - setup.min_keycode + 1);
        let map = self.x.get_keyboard_mapping(first, count).expect("sent").reply().expect("the keyboard");
        let row = map.keysyms.chunks(map.keysyms_per_keycode.into()).position(|symbols| symbols.contains(&symbol));
        let code = first + row.unwrap_or_else(|| panic!("no key gives {symbol:#x}")) as u8;
        for kind in [KEY_PRESS_EVENT, KEY_RELEASE_EVENT] {
            self.x.xtest_fake_input(kind, code, 0, self.root, 0, 0, 0).expect("sent").check().expect("a key");
        }
    }

    /// Moves the pointer off every window: to the screen's last pixel.
    fn point_away(&self) {
        let [width, height] = self.size(self.root).map(|side| side as i16 - 1);
        let sent = self.x.xtest_fake_input(MOTION_NOTIFY_EVENT, 0, 0, self.root, width, height, 0);
        sent.expect("sent").check().expect("the mouse");
    }

    /// Who has the clipboard.
    fn clipboard(&self) -> Window {
        self.x.get_selection_owner(self.atom("CLIPBOARD")).expect("sent").reply().expect("its owner").owner
    }

    /// A window as large as the screen, not shown yet.
    fn unseen_window(&self) -> Window {
        let window = self.x.generate_id().expect("a number");
        let [width, height] = self.size(self.root);
        let (class, aux) = (WindowClass::INPUT_OUTPUT, CreateWindowAux::new().override_redirect(1));
        let sent = self.x.create_window(0, window, self.root, 0, 0, width, height, 0, class, 0, &aux);
        sent.expect("sent").check().expect("a window");
        window
    }

    /// Puts it over whatever another test has put there.
    fn raise(&self, window: Window) {
        let above = ConfigureWindowAux::new().stack_mode(StackMode::ABOVE);
        self.x.configure_window(window, &above).expect("sent").check().expect("its place");
    }

    /// A click with the left button at a pixel of the window, over whatever another test has put there.
    fn click(&self, window: Window, at: [i16; 2]) {
        self.drag(window, at, at);
    }

    /// The left button pressed at one pixel and let go of at another, over whatever another test has put there.
    fn drag(&self, window: Window, from: [i16; 2], to: [i16; 2]) {
        self.raise(window);
        let send = |kind: u8, detail: u8, [x, y]: [i16; 2]| {
            let at = self.x.translate_coordinates(window, self.root, x, y).expect("sent").reply().expect("its place");
            let sent = self.x.xtest_fake_input(kind, detail, 0, self.root, at.dst_x, at.dst_y, 0);
            sent.expect("sent").check().expect("the mouse");
            thread::sleep(Duration::from_millis(60));
        };
        send(MOTION_NOTIFY_EVENT, 0, from);
        send(BUTTON_PRESS_EVENT, 1, from);
        let half = [(from[0] + to[0]) / 2, (from[1] + to[1]) / 2];
        for at in [half, to].into_iter().filter(|at| *at != from) {
            send(MOTION_NOTIFY_EVENT, 0, at);
        }
        send(BUTTON_RELEASE_EVENT, 1, to);
    }

    fn resize(&self, window: Window, width: u32, height: u32) {
        let aux = ConfigureWindowAux::new().width(width).height(height);
        self.x.configure_window(window, &aux).expect("sent").check().expect("a new size");
    }

    /// As a window manager does when the cross in the corner is clicked.
    fn close(&self, window: Window) {
        let data = [self.atom("WM_DELETE_WINDOW"), x11rb::CURRENT_TIME, 0, 0, 0];
        let event = ClientMessageEvent::new(32, window, self.atom("WM_PROTOCOLS"), data);
        self.x.send_event(false, window, EventMask::NO_EVENT, event).expect("sent").check().expect("a message");
    }
}

/// Waits until a window's title has a part.
#[track_caller]
fn titled(user: &User, window: Window, process: &mut Running, part: &str) {
    wait(&format!("'{part}' in the title"), process, || user.title(window).contains(part).then_some(()));
}

/// Keys go to whichever window has the focus, so one test at a time has the keyboard.
fn keyboard() -> MutexGuard<'static, ()> {
    static KEYBOARD: Mutex<()> = Mutex::new(());
    // A test that failed with the keyboard in its hands has let go of it.
    KEYBOARD.lock().unwrap_or_else(PoisonError::into_inner)
}

/// `prism run SAMPLE` in a window of 320 × 240.
fn open(sample: &str, flags: &str) -> Running {
    open_sized(sample, [320, 240], flags)
}

fn open_sized(sample: &str, [width, height]: [u16; 2], flags: &str) -> Running {
    let display = env::var_os("DISPLAY").expect("an X server");
    let call = draw("run", sample).words(&format!("--size {width}x{height}")).words(flags).env("DISPLAY", display);
    call.start()
}

/// Waits until the window shows this picture.
#[track_caller]
fn shows(user: &User, window: Window, process: &mut Running, expected: &Picture) {
    comes_to_show(process, expected, || user.picture(window));
}

#[test]
fn a_sample_is_shown_resized_switched_and_closed() {
    let _keyboard = keyboard();
    let user = User::connect();
    let mut process = open("prism_shell", "--time-step 0");
    let window = user.window_of(&mut process);
    assert_eq!(user.size(window), [320, 240]);
    assert_eq!(user.property(window, "WM_CLASS", AtomEnum::STRING), b"prism\0prism\0");
    let first = headless("prism_shell", [320, 240], "");
    assert!(first.colours() > 1000, "{} colours", first.colours());
    shows(&user, window, &mut process, &first);

    for [width, height] in [[400, 200], [250, 310], [64, 48], [320, 240]] {
        user.resize(window, width.into(), height.into());
        shows(&user, window, &mut process, &headless("prism_shell", [width, height], ""));
    }

    user.focus(window);
    titled(&user, window, &mut process, "shell walk");
    user.press('h'.into());
    titled(&user, window, &mut process, "shell off");
    shows(&user, window, &mut process, &headless("prism_shell", [320, 240], "--shell off --march exact"));
    user.press('h'.into());
    titled(&user, window, &mut process, "shell walk");
    titled(&user, window, &mut process, "march exact");
    user.press('m'.into());
    titled(&user, window, &mut process, "march steep");
    titled(&user, window, &mut process, "stage auto");
    user.press('s'.into());
    titled(&user, window, &mut process, "stage mesh");
    user.press('s'.into());
    titled(&user, window, &mut process, "stage geometry");
    shows(&user, window, &mut process, &headless("prism_shell", [320, 240], "--march steep --stage geometry"));

    user.press('h'.into());
    titled(&user, window, &mut process, "shell off");
    for (key, part) in [
        ('d', "dither"),
        ('l', "self-shadow hard"),
        ('w', "shadow map"),
        ('a', "ambient occlusion"),
        ('c', "silhouette uv-bounds"),
        ('g', "normals 4-tap"),
    ] {
        user.press(key.into());
        titled(&user, window, &mut process, part);
    }
    let flags = "--shell off --march steep --dither on --self-shadow hard --shadow-map on --ambient-occlusion on \
                 --silhouette uv-bounds --normals 4-tap";
    shows(&user, window, &mut process, &headless("prism_shell", [320, 240], flags));

    user.close(window);
    clean(process.wait());
}

#[test]
fn a_walk_shows_each_scene_beside_its_reference() {
    let _keyboard = keyboard();
    let user = User::connect();
    let mut process = open("stability", "--scene stability_inside");
    let window = user.window_of(&mut process);
    let expected = |scene: &str, flags: &str| headless("stability", [320, 240], &format!("--scene {scene} {flags}"));
    shows(&user, window, &mut process, &expected("stability_inside", ""));
    titled(&user, window, &mut process, "stability_inside: ");

    // After the last scene comes the first.
    user.focus(window);
    for (key, scene) in [('n', "torus"), ('n', "suzanne"), ('b', "torus")] {
        user.press(key.into());
        titled(&user, window, &mut process, &format!("stability · {scene} · "));
        shows(&user, window, &mut process, &expected(scene, ""));
    }
    user.press('h'.into());
    titled(&user, window, &mut process, "shell off");
    shows(&user, window, &mut process, &expected("torus", "--shell off --march exact"));

    user.press(ESCAPE);
    let outcome = process.wait();
    let told: Vec<&str> = outcome.stdout.lines().filter_map(|line| Some(line.split_once(": ")?.0)).collect();
    assert_eq!(told, ["stability_inside", "torus", "suzanne", "torus", "torus"], "{outcome}");
    clean(outcome);
}

#[test]
fn escape_quits() {
    let _keyboard = keyboard();
    let user = User::connect();
    let mut process = open("viewer", "");
    let window = user.window_of(&mut process);
    shows(&user, window, &mut process, &headless("viewer", [320, 240], ""));
    user.focus(window);
    user.press(ESCAPE);
    clean(process.wait());
}

/// A copy of the shaders that a test may edit.
fn shaders(folder: &Path) -> PathBuf {
    let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shaders");
    let to = folder.join("shaders");
    copy(&from, &to);
    to
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).expect("a folder");
    for entry in fs::read_dir(from).expect("a folder") {
        let entry = entry.expect("an entry");
        let target = to.join(entry.file_name());
        if entry.path().is_dir() {
            copy(&entry.path(), &target);
        } else {
            fs::copy(entry.path(), target).expect("a copy");
        }
    }
}

#[test]
fn a_shader_edited_meanwhile_is_drawn_with_as_soon_as_it_compiles() {
    let _keyboard = keyboard();
    let user = User::connect();
    let folder = folder();
    let dir = shaders(folder.path());
    let flags = format!("--shell off --march none --shader-dir {}", dir.display());
    // Room for a message of many lines in the lower half.
    let size = [640, 480];
    let mut process = open_sized("viewer", size, &flags);
    let window = user.window_of(&mut process);
    let original = headless("viewer", size, &flags);
    shows(&user, window, &mut process, &original);

    // A good edit: what it draws is what the folder now gives.
    let file = dir.join("render/surface.frag");
    let text = fs::read_to_string(&file).expect("the shader");
    let end = text.rfind('}').expect("the end of main");
    let red = format!("{}    out_color.rgb = out_color.rrr;\n{}", &text[..end], &text[end..]);
    fs::write(&file, &red).expect("an edit");
    let edited = headless("viewer", size, &flags);
    assert!(difference(&original, &edited) > 0.02, "the edit shows: {}", difference(&original, &edited));
    shows(&user, window, &mut process, &edited);

    // A broken one: the picture stays, and over its lower edge the message says where.
    fs::write(&file, red.replace("out_color.rrr", "no_such_name")).expect("an edit");
    let upper = |picture: &Picture| Picture {
        width: picture.width,
        height: picture.height / 2,
        pixels: picture.pixels[..picture.pixels.len() / 2].to_vec(),
    };
    // Both at once: a message just come may still be taking its size.
    wait("the message under the picture", &mut process, || {
        let seen = user.picture(window);
        (difference(&seen, &edited) > 0.02 && difference(&upper(&seen), &upper(&edited)) < 0.01).then_some(())
    });

    // The mend.
    fs::write(&file, &text).expect("an edit");
    shows(&user, window, &mut process, &original);
    user.close(window);
    let outcome = process.wait();
    let line = red[..red.find("out_color.rrr").expect("the edit")].lines().count();
    let told = format!("surface.frag:{line}: error: 'no_such_name'");
    assert!(outcome.stderr.contains(&told), "{told}\n{outcome}");
    clean(outcome);
}

/// The middles of the panel's first `count` buttons, if as many are seen: row by row, of the uppermost pixels in a
/// button's grey.
fn buttons(picture: &Picture, count: usize) -> Option<Vec<[i16; 2]>> {
    let grey = |pixel: &[u8; 3]| pixel.iter().all(|value| value.abs_diff(60) <= 2);
    let mut found: Vec<[i16; 2]> = Vec::new();
    let mut next = 0;
    for (y, row) in picture.pixels.chunks_exact(picture.width as usize).enumerate() {
        let mut from = 0;
        for run in row[..300].chunk_by(|a, b| grey(a) == grey(b)) {
            if y >= next && grey(&run[0]) && run.len() > 40 {
                found.push([(from + run.len() / 2) as i16, y as i16 + 4]);
            }
            from += run.len();
        }
        // Below its first row a button is interrupted by its own words.
        if found.last().is_some_and(|at| at[1] == y as i16 + 4) {
            next = y + 20;
        }
        if found.len() >= count {
            return Some(found);
        }
    }
    None
}

/// Clicks until that has its effect. A click may be lost while another test's window comes in between; one that is only
/// late must not be followed by a second, which would meet what the first has changed.
fn click_until(user: &User, window: Window, process: &mut Running, at: [i16; 2], done: impl Fn() -> bool) {
    wait("what a click does", process, || {
        user.click(window, at);
        let clicked = Instant::now();
        while !done() {
            if clicked.elapsed() > Duration::from_secs(5) {
                return None;
            }
            thread::sleep(Duration::from_millis(30));
        }
        Some(())
    });
}

#[test]
fn the_panel_is_drawn_and_clicked() {
    let _keyboard = keyboard();
    let user = User::connect();
    let folder = folder();
    // What the pointer is over looks otherwise.
    user.point_away();
    let display = env::var_os("DISPLAY").expect("an X server");
    let call = draw("run", "viewer").words("--size 960x720 --shell off --march none").within(folder.path());
    let mut process = call.env("DISPLAY", display).start();
    let window = user.window_of(&mut process);
    let bare = headless("viewer", [960, 720], "--shell off --march none");
    // Left of the picture, over it; the right half is the sample's own.
    let half = |picture: &Picture, right: bool| {
        let [from, to] = if right { [480, 960] } else { [0, 200] };
        let rows = picture.pixels.chunks_exact(960).flat_map(|row| row[from..to].to_vec());
        Picture { width: (to - from) as u32, height: picture.height, pixels: rows.collect() }
    };
    wait("the panel", &mut process, || {
        let seen = user.picture(window);
        let over = difference(&half(&seen, false), &half(&bare, false));
        (over > 0.3 && difference(&half(&seen, true), &half(&bare, true)) < 0.01).then_some(())
    });
    user.focus(window);
    // Where they are is read once: the one under the pointer has another grey.
    let places = wait("the buttons", &mut process, || buttons(&user.picture(window), 4));
    let [copy, _, save, load] = places[..4] else { unreachable!("four were asked for") };
    // 'copy as command line'. The panel is not to be put away before the click is seen.
    let before = user.clipboard();
    click_until(&user, window, &mut process, copy, || user.clipboard() != before);
    // 'save view', another march, 'load view'.
    let saved = folder.path().join("viewer-view-1.json");
    click_until(&user, window, &mut process, save, || saved.exists());
    user.focus(window);
    user.press('m'.into());
    titled(&user, window, &mut process, "march normal");
    click_until(&user, window, &mut process, load, || user.title(window).contains("march none"));
    user.focus(window);
    user.press('u'.into());
    shows(&user, window, &mut process, &bare);
    user.press(ESCAPE);
    let outcome = process.wait();
    assert!(outcome.stderr.contains("copied: prism run viewer --scene"), "{outcome}");
    assert!(outcome.stderr.contains("--shell off --march none --size 960x720"), "{outcome}");
    clean(outcome);
}

/// Opens the panel and clicks on its first button, 'copy as command line'; then puts it away again.
fn copies_by_the_panel(user: &User, window: Window, process: &mut Running) {
    user.point_away();
    user.focus(window);
    user.press('u'.into());
    // Right of it is another; where the pointer was last is told one frame late.
    let first = || buttons(&user.picture(window), 1)?.into_iter().next().filter(|at| at[0] < 170);
    let copy = wait("the first button", process, first);
    // Nobody's: who has it already is still its owner after the next copy.
    let clipboard = user.atom("CLIPBOARD");
    user.x.set_selection_owner(x11rb::NONE, clipboard, x11rb::CURRENT_TIME).expect("sent").check().expect("no owner");
    click_until(user, window, process, copy, || user.clipboard() != x11rb::NONE);
    user.focus(window);
    user.press('u'.into());
}

#[test]
fn a_screen_with_more_pixels_a_point_shows_the_same_picture_and_is_clicked_on() {
    let _keyboard = keyboard();
    let user = User::connect();
    user.point_away();
    let display = env::var_os("DISPLAY").expect("an X server");
    let (size, flags) = ([600, 400], "--shell off --march none");
    // The size is in pixels, whatever a point is.
    let bare = headless("viewer", size, flags);
    let uv = headless("viewer", size, &format!("{flags} --view uv"));
    for scale in [1.5, 2.0] {
        let call = draw("run", "viewer").words("--size 600x400").words(flags);
        let call = call.env("DISPLAY", &display).env("WINIT_X11_SCALE_FACTOR", scale.to_string());
        let mut process = call.start();
        let window = user.window_of(&mut process);
        shows(&user, window, &mut process, &bare);
        copies_by_the_panel(&user, window, &mut process);
        shows(&user, window, &mut process, &bare);
        shows_uv(&user, window, &mut process);
        user.press('k'.into());
        user.press('1'.into());
        // A line may be held as far away as a finger is wide, 6 points: so many more pixels.
        let near = 300 + (5.0 * scale) as i16;
        wait("two pictures", &mut process, || {
            let seen = columns(&user.picture(window), 310, 500);
            (difference(&seen, &columns(&uv, 310, 500)) < 0.01).then_some(())
        });
        user.drag(window, [near, 200], [500, 200]);
        wait("the line further right", &mut process, || {
            let seen = columns(&user.picture(window), 100, 490);
            (difference(&seen, &columns(&bare, 100, 490)) < 0.01).then_some(())
        });
        user.focus(window);
        user.press(ESCAPE);
        clean(process.wait());
    }
}

#[test]
fn another_sample_and_another_file_are_chosen_in_the_panel() {
    let _keyboard = keyboard();
    let user = User::connect();
    user.point_away();
    let (size, flags) = ([640, 480], "--shell off --march none");
    let mut process = open_sized("viewer", size, flags);
    let window = user.window_of(&mut process);
    shows(&user, window, &mut process, &headless("viewer", size, flags));
    user.focus(window);
    user.press('u'.into());
    // After five buttons come two lists; what they let choose is below, in rows of 21 points.
    let right = |picture: &Picture| columns(picture, 300, 640);
    let choose = |process: &mut Running, list: usize, row: i16, done: &dyn Fn() -> bool| {
        let at = wait("the lists", process, || buttons(&user.picture(window), 7))[list];
        wait("what was chosen", process, || {
            let below = || {
                let seen = user.picture(window);
                let rows = seen.pixels.chunks_exact(640).skip(at[1] as usize + 15).take(60);
                rows.flat_map(|row| row[10..120].to_vec()).collect::<Vec<_>>()
            };
            let closed = below();
            user.click(window, at);
            let within = |what: &dyn Fn() -> bool| {
                let begun = Instant::now();
                while !what() && begun.elapsed() < Duration::from_secs(15) {
                    thread::sleep(Duration::from_millis(30));
                }
                what()
            };
            let open = || closed.iter().zip(below()).filter(|(a, b)| **a != *b).count() > 2000;
            if within(&open) {
                user.click(window, [at[0], at[1] + 25 + 21 * row]);
            }
            within(done).then_some(())
        });
        user.point_away();
    };
    // The second file, and the settings that were in force.
    let cube = headless("viewer", size, &format!("--scene {} {flags}", asset("cube.gltf").display()));
    choose(&mut process, 6, 1, &|| difference(&right(&user.picture(window)), &right(&cube)) < 0.01);
    // The first sample, which moves, as its own settings have it; then back.
    choose(&mut process, 5, 0, &|| {
        user.title(window).starts_with("prism_shell · ") && user.title(window).contains("walk")
    });
    choose(&mut process, 5, 1, &|| user.title(window).starts_with("viewer · "));
    let suzanne = headless("viewer", size, "");
    wait("the other sample", &mut process, || {
        (difference(&right(&user.picture(window)), &right(&suzanne)) < 0.01).then_some(())
    });
    user.focus(window);
    user.press(ESCAPE);
    clean(process.wait());
}

/// Two monitors side by side, and a desktop's settings; gone once it goes out of scope.
struct Desk<'a> {
    user: &'a User,
    monitors: [Atom; 2],
    /// Whose property the settings are: those of XSETTINGS, which all desktops have.
    settings: Window,
}

impl<'a> Desk<'a> {
    fn new(user: &'a User) -> Desk<'a> {
        let outputs = user.x.randr_get_screen_resources_current(user.root).expect("sent").reply();
        let outputs = outputs.expect("the plugs").outputs;
        let [width, height] = user.size(user.root);
        let monitors = ["left", "right"].map(|name| user.atom(name));
        for (k, name) in monitors.into_iter().enumerate() {
            let monitor = MonitorInfo {
                name,
                x: (k * usize::from(width) / 2) as i16,
                width: width / 2,
                height,
                // The second has no plug of its own.
                outputs: outputs.iter().copied().filter(|_| k == 0).collect(),
                ..MonitorInfo::default()
            };
            user.x.randr_set_monitor(user.root, monitor).expect("sent").check().expect("a monitor");
        }
        let settings = user.unseen_window();
        let desk = Desk { user, monitors, settings };
        desk.set_dots_an_inch(96);
        let owned = user.x.set_selection_owner(settings, user.atom("_XSETTINGS_S0"), x11rb::CURRENT_TIME);
        owned.expect("sent").check().expect("the settings are nobody else's");
        desk
    }

    /// 96 is a pixel a point.
    fn set_dots_an_inch(&self, dots: u32) {
        // Byte order, serial, count; of the only setting its type, its name, its serial and its value in 1024ths.
        let numbers = [0u32, 0, 1, 7 << 16].map(u32::to_le_bytes).concat();
        let setting = [numbers, b"Xft/DPI\0".to_vec(), [0, dots * 1024].map(u32::to_le_bytes).concat()].concat();
        let name = self.user.atom("_XSETTINGS_SETTINGS");
        let sent = self.user.x.change_property8(PropMode::REPLACE, self.settings, name, name, &setting);
        sent.expect("sent").check().expect("a property");
    }
}

impl Drop for Desk<'_> {
    fn drop(&mut self) {
        let x = &self.user.x;
        // An X server that is gone has nothing to be put back.
        for monitor in self.monitors {
            let _ = x.randr_delete_monitor(self.user.root, monitor).map(|sent| sent.check());
        }
        let _ = x.destroy_window(self.settings).map(|sent| sent.check());
    }
}

#[test]
fn it_goes_from_one_monitor_to_another_and_follows_a_change_of_scale() {
    let _keyboard = keyboard();
    let user = User::connect();
    user.point_away();
    let desk = Desk::new(&user);
    let flags = "--shell off --march none";
    let mut process = open_sized("viewer", [480, 320], flags);
    let window = user.window_of(&mut process);
    let bare = |[width, height]: [u16; 2]| headless("viewer", [width, height], flags);
    let small = bare([480, 320]);
    shows(&user, window, &mut process, &small);

    // On the second, then on both at once.
    for x in [900, 600] {
        let there = ConfigureWindowAux::new().x(x).y(100);
        user.x.configure_window(window, &there).expect("sent").check().expect("a place");
        shows(&user, window, &mut process, &small);
        copies_by_the_panel(&user, window, &mut process);
    }

    // As many points are more pixels, and fewer again.
    for (dots, size) in [(144, [720, 480]), (192, [960, 640]), (96, [480, 320])] {
        desk.set_dots_an_inch(dots);
        shows(&user, window, &mut process, &bare(size));
        copies_by_the_panel(&user, window, &mut process);
        shows(&user, window, &mut process, &bare(size));
    }
    comes_to_rest(&mut process);
    user.focus(window);
    user.press(ESCAPE);
    clean(process.wait());
}

#[test]
fn a_sample_that_moves_rests_while_it_is_out_of_sight_and_goes_on_after() {
    let _keyboard = keyboard();
    let user = User::connect();
    let mut process = open("prism_shell", "--shell off --march none");
    let window = user.window_of(&mut process);
    let moves = |process: &mut Running| {
        user.raise(window);
        wait("a moving picture", process, || {
            let before = user.picture(window);
            thread::sleep(Duration::from_millis(200));
            (before.pixels != user.picture(window).pixels).then_some(())
        });
    };
    moves(&mut process);

    // Minimised, by a window manager that takes it off the screen, or leaves its desktop.
    user.x.unmap_window(window).expect("sent").check().expect("no window");
    comes_to_rest(&mut process);
    user.x.map_window(window).expect("sent").check().expect("a window");
    moves(&mut process);

    // By one that keeps it there, for small pictures of all windows.
    let (states, hidden) = (user.atom("_NET_WM_STATE"), user.atom("_NET_WM_STATE_HIDDEN"));
    let sent = user.x.change_property32(PropMode::REPLACE, window, states, AtomEnum::ATOM, &[hidden]);
    sent.expect("sent").check().expect("a property");
    comes_to_rest(&mut process);
    user.x.delete_property(window, states).expect("sent").check().expect("no property");
    moves(&mut process);

    // Behind another one.
    let cover = user.unseen_window();
    user.x.map_window(cover).expect("sent").check().expect("a window");
    comes_to_rest(&mut process);
    user.x.destroy_window(cover).expect("sent").check().expect("no window");
    moves(&mut process);

    // It closes out of sight, too.
    user.x.unmap_window(window).expect("sent").check().expect("no window");
    comes_to_rest(&mut process);
    user.close(window);
    clean(process.wait());
}

/// A library of RenderDoc's name and with its one entry, whose table says on stderr when it is to take a frame.
fn renderdoc(folder: &Path) -> PathBuf {
    let source = folder.join("renderdoc.c");
    let text = "#include <stdio.h>\n\
                static int nothing(void) { return 0; }\n\
                static void trigger(void) { fputs(\"takes a frame\\n\", stderr); }\n\
                int RENDERDOC_GetAPI(int version, void **out) {\n\
                    static void *table[40];\n\
                    for (int i = 0; i < 40; ++i) table[i] = i == 15 ? (void *)trigger : (void *)nothing;\n\
                    *out = table;\n\
                    return 1;\n\
                }\n";
    fs::write(&source, text).expect("a file");
    let library = folder.join("librenderdoc.so");
    let mut compiler = std::process::Command::new("cc");
    compiler.args(["-shared", "-fPIC", "-Wl,-soname,librenderdoc.so", "-o"]).arg(&library).arg(&source);
    assert!(compiler.status().expect("a C compiler, which linking needs too").success());
    library
}

#[test]
fn renderdoc_takes_a_frame_where_it_is_loaded() {
    let _keyboard = keyboard();
    let user = User::connect();
    let folder = folder();
    let library = renderdoc(folder.path());
    for loaded in [true, false] {
        let display = env::var_os("DISPLAY").expect("an X server");
        let mut call = draw("run", "viewer").words("--size 160x120 --shell off --march none").env("DISPLAY", display);
        if loaded {
            call = call.env("LD_PRELOAD", &library);
        }
        let mut process = call.start();
        let window = user.window_of(&mut process);
        shows_uv(&user, window, &mut process);
        // Keys come in their order: once the view has changed, the first one has been seen to.
        user.press('f'.into());
        user.press('9'.into());
        titled(&user, window, &mut process, "view height");
        user.press(ESCAPE);
        let outcome = process.wait();
        let told = if loaded { "RenderDoc takes the next frame" } else { "RenderDoc is not there" };
        assert!(outcome.stderr.contains(told), "{outcome}");
        assert_eq!(outcome.stderr.contains("takes a frame\n"), loaded, "{outcome}");
        clean(outcome);
    }
}

#[test]
fn it_ends_after_the_frames_that_were_asked_for() {
    let mut process = open("prism_shell", "--frames 5 --stats");
    let user = User::connect();
    let _ = user.window_of(&mut process);
    let outcome = process.wait().ends(0);
    assert!(outcome.stdout.contains("n=5"), "the statistics are of five frames\n{outcome}");
}

#[test]
fn a_device_that_is_lost_ends_the_window_with_its_last_pass() {
    let folder = folder();
    let losing = Losing::new(folder.path());
    let display = env::var_os("DISPLAY").expect("an X server");
    for function in ["vkQueueSubmit2", "vkWaitForFences", "vkAcquireNextImageKHR", "vkQueuePresentKHR"] {
        let run = prism("run prism_shell --size 160x120 --shell off --march none --frames 200 --validation off")
            .env("DISPLAY", &display);
        tells_of_the_loss(losing.loses(run, function, 30).run(), "surface");
    }
}

#[test]
fn every_frame_is_kept_from_one_key_to_the_next() {
    let _keyboard = keyboard();
    let user = User::connect();
    let folder = folder();
    let display = env::var_os("DISPLAY").expect("an X server");
    let call = draw("run", "prism_shell").words("--size 160x120 --shell off --march none").within(folder.path());
    let mut process = call.env("DISPLAY", display).start();
    let window = user.window_of(&mut process);
    shows_uv(&user, window, &mut process);
    user.press('i'.into());
    titled(&user, window, &mut process, "keeps frames");
    let frame = |number: usize| folder.path().join(format!("prism_shell-frames-1-{number:03}.png"));
    wait("the fourth frame", &mut process, || frame(3).exists().then_some(()));
    user.press('i'.into());
    wait("the end", &mut process, || (!user.title(window).contains("keeps frames")).then_some(()));
    // Then the first name that is free.
    user.press('i'.into());
    let second = folder.path().join("prism_shell-frames-2-000.png");
    wait("another first frame", &mut process, || second.exists().then_some(()));
    user.press(ESCAPE);
    let outcome = process.wait();
    let told = "wrote prism_shell-frames-1-000.png to prism_shell-frames-1-";
    assert!(
        outcome.stderr.contains(told) && outcome.stderr.contains("wrote prism_shell-frames-2-000.png"),
        "{outcome}"
    );
    clean(outcome);
    // A twenty-fifth of a second apart, however long each took.
    let turned = |number: usize| Picture::read(&frame(number));
    assert_eq!([turned(0).width, turned(0).height], [160, 120]);
    let first = difference(&turned(0), &turned(1));
    assert!(first > 0.0 && first < difference(&turned(0), &turned(3)), "{first}");
}

#[test]
fn a_display_that_is_not_there() {
    let call = draw("run", "prism_shell").words("--size 64x48").env("DISPLAY", ":65500");
    call.run().ends(77).complains(&["window"]);
}

#[test]
fn a_view_is_chosen_by_its_key_and_the_error_comes_when_it_is_known() {
    let _keyboard = keyboard();
    let user = User::connect();
    let flags = "--shell off --march relief";
    let mut process = open("viewer", flags);
    let window = user.window_of(&mut process);
    shows(&user, window, &mut process, &headless("viewer", [320, 240], flags));
    user.focus(window);
    // Prisms, the fourth view, are none of a base surface's: the key does nothing.
    user.press('4'.into());
    for (key, view) in [('8', "uv"), ('v', "height"), ('e', "error"), ('2', "base")] {
        user.press(key.into());
        titled(&user, window, &mut process, &format!("view {view}"));
        shows(&user, window, &mut process, &headless("viewer", [320, 240], &format!("{flags} --view {view}")));
    }
    user.press('1'.into());
    shows(&user, window, &mut process, &headless("viewer", [320, 240], flags));
    user.press(ESCAPE);
    clean(process.wait());
}

/// Gives a window the keyboard and asks for its view of UV until that is seen: a key that comes before the program knows
/// of its focus is lost.
fn shows_uv(user: &User, window: Window, process: &mut Running) {
    user.focus(window);
    wait("the view of UV", process, || {
        user.press('8'.into());
        thread::sleep(Duration::from_millis(100));
        user.title(window).contains("view uv").then_some(())
    });
}

/// Columns of a picture, below what stands along its upper edge.
fn columns(picture: &Picture, from: usize, to: usize) -> Picture {
    let rows = picture.pixels.chunks_exact(picture.width as usize).skip(60);
    let pixels: Vec<[u8; 3]> = rows.flat_map(|row| row[from..to].to_vec()).collect();
    Picture { width: (to - from) as u32, height: picture.height - 60, pixels }
}

#[test]
fn two_settings_are_compared_at_a_line_that_is_dragged() {
    let _keyboard = keyboard();
    let user = User::connect();
    user.point_away();
    let flags = "--shell off --march none";
    let size = [480, 320];
    let mut process = open_sized("viewer", size, flags);
    let window = user.window_of(&mut process);
    let (shaded, uv) = (headless("viewer", size, flags), headless("viewer", size, &format!("{flags} --view uv")));
    shows(&user, window, &mut process, &shaded);
    shows_uv(&user, window, &mut process);
    user.press('k'.into());
    user.press('1'.into());
    let parted = |at: usize, process: &mut Running| {
        wait(&format!("two pictures, parted at {at}"), process, || {
            let seen = user.picture(window);
            let same = |expected: &Picture, from: usize, to: usize| {
                difference(&columns(&seen, from, to), &columns(expected, from, to)) < 0.01
            };
            (same(&shaded, 0, at - 4) && same(&uv, at + 4, 480)).then_some(seen)
        })
    };
    let seen = parted(240, &mut process);
    assert!(seen.pixels[200 * 480 + 238..200 * 480 + 243].contains(&[255; 3]), "no line");
    // Along the upper edge both GPU times are written, right and left of it.
    wait("both times", &mut process, || {
        let seen = user.picture(window);
        let written = |from: usize, to: usize| {
            let rows = seen.pixels.chunks_exact(480).take(30);
            rows.flat_map(|row| &row[from..to]).filter(|pixel| pixel.iter().all(|value| *value > 200)).count()
        };
        // Beyond the letters' place.
        (written(150, 215) > 40 && written(265, 330) > 40).then_some(())
    });
    user.drag(window, [240, 200], [120, 180]);
    parted(120, &mut process);
    user.focus(window);
    user.press('k'.into());
    shows(&user, window, &mut process, &shaded);
    user.press(ESCAPE);
    clean(process.wait());
}

#[test]
fn a_click_probes_the_pixel_and_turns_nothing() {
    let _keyboard = keyboard();
    let user = User::connect();
    let size = [720, 480];
    let mut process = open_sized("viewer", size, "--shell off --march none");
    let window = user.window_of(&mut process);
    let bare = headless("viewer", size, "--shell off --march none");
    shows(&user, window, &mut process, &bare);
    user.click(window, [5, 5]);
    user.click(window, [360, 240]);
    wait("the drawing", &mut process, || {
        let seen = user.picture(window);
        let right = difference(&columns(&seen, 300, 720), &columns(&bare, 300, 720));
        (right > 0.3 && difference(&columns(&seen, 0, 150), &columns(&bare, 0, 150)) < 0.01).then_some(())
    });
    user.focus(window);
    user.press(ESCAPE);
    clean(process.wait());
}
