//! The program, run as a user runs it.

use std::{
    ffi::OsStr,
    io::Read,
    path::Path,
    process::{Child, Command, Stdio},
    thread::{self, JoinHandle},
    time::{Duration, Instant},
};

/// What is slower hangs. The longest run, the bench's, compiles every baseline's pipelines and takes over a minute of CPU.
const PATIENCE: Duration = Duration::from_secs(400);

/// A run of `prism` in the making.
pub struct Call {
    command: Command,
}

/// How a run ended.
#[derive(Debug)]
pub struct Outcome {
    /// The command line, for messages.
    pub line: String,
    /// The exit code; -1 if a signal ended it.
    pub code: i32,
    /// What it printed.
    pub stdout: String,
    /// What it told.
    pub stderr: String,
}

/// `prism WORDS`, without a display and with no settings from this environment.
pub fn prism(words: &str) -> Call {
    let mut command = Command::new(env!("CARGO_BIN_EXE_prism"));
    for name in ["DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET"] {
        command.env_remove(name);
    }
    for (name, _) in std::env::vars_os().filter(|(name, _)| name.to_string_lossy().starts_with("PRISM_")) {
        command.env_remove(name);
    }
    // Not the user's: what is cached here was made by these tests, and goes with `cargo clean`.
    command.env("XDG_CACHE_HOME", Path::new(env!("CARGO_TARGET_TMPDIR")).join("cache"));
    Call { command }.words(words)
}

/// `prism COMMAND SUBJECT` with every check of the validation layer: any message of it fails the run.
pub fn draw(command: &str, subject: impl AsRef<OsStr>) -> Call {
    prism(command).arg(subject).words("--validation sync")
}

impl Call {
    /// Words that hold no spaces themselves.
    pub fn words(mut self, words: &str) -> Self {
        self.command.args(words.split_whitespace());
        self
    }

    /// One word.
    pub fn arg(mut self, word: impl AsRef<OsStr>) -> Self {
        self.command.arg(word);
        self
    }

    /// A variable of its environment.
    pub fn env(mut self, name: &str, value: impl AsRef<OsStr>) -> Self {
        self.command.env(name, value);
        self
    }

    /// The folder it runs in.
    pub fn within(mut self, folder: &Path) -> Self {
        self.command.current_dir(folder);
        self
    }

    /// Starts it and does not wait.
    pub fn start(mut self) -> Running {
        let line = format!("{:?}", self.command);
        self.command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = self.command.spawn().unwrap_or_else(|error| panic!("{line}: {error}"));
        // Both pipes are drained at once, or a talkative run would wait for its reader for ever.
        let stdout = drain(child.stdout.take().expect("piped"));
        let stderr = drain(child.stderr.take().expect("piped"));
        Running { line, child, stdout: Some(stdout), stderr: Some(stderr) }
    }

    /// Runs it to its end.
    pub fn run(self) -> Outcome {
        self.start().wait()
    }

    /// Runs it and insists on success.
    #[track_caller]
    pub fn succeeds(self) -> Outcome {
        self.run().ends(0)
    }
}

fn drain(mut pipe: impl Read + Send + 'static) -> JoinHandle<String> {
    thread::spawn(move || {
        let mut bytes = Vec::new();
        pipe.read_to_end(&mut bytes).expect("its output");
        String::from_utf8_lossy(&bytes).into_owned()
    })
}

/// A run under way; killed when it goes out of scope.
pub struct Running {
    line: String,
    child: Child,
    stdout: Option<JoinHandle<String>>,
    stderr: Option<JoinHandle<String>>,
}

impl Running {
    /// The number of its process.
    pub fn id(&self) -> u32 {
        self.child.id()
    }

    /// Whether it has ended.
    pub fn ended(&mut self) -> bool {
        self.child.try_wait().expect("its state").is_some()
    }

    /// What it told on stderr, once it has ended.
    pub fn said(&mut self) -> String {
        self.stderr.take().map(|reader| reader.join().expect("its reader")).unwrap_or_default()
    }

    /// Waits for its end; kills it and fails when it hangs.
    #[track_caller]
    pub fn wait(mut self) -> Outcome {
        let begun = Instant::now();
        let mut hangs = false;
        while !self.ended() {
            hangs = begun.elapsed() > PATIENCE;
            if hangs {
                let _ = self.child.kill();
                break;
            }
            thread::sleep(Duration::from_millis(5));
        }
        let status = self.child.wait().expect("its exit status");
        let text =
            |reader: Option<JoinHandle<String>>| reader.map(|r| r.join().expect("its reader")).unwrap_or_default();
        let (stdout, stderr) = (text(self.stdout.take()), text(self.stderr.take()));
        let outcome = Outcome { line: self.line.clone(), code: status.code().unwrap_or(-1), stdout, stderr };
        assert!(!hangs, "killed after {PATIENCE:?}\n{outcome}");
        outcome
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        // It has usually ended, and then there is nothing to kill.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Outcome {
    /// Insists on the exit code. No run may panic or have the validation layer speak, however it ends.
    #[track_caller]
    pub fn ends(self, code: i32) -> Self {
        assert_eq!(self.code, code, "exit code\n{self}");
        for word in ["panicked", "VUID-", "SYNC-HAZARD", "Validation Error", "Validation Warning"] {
            assert!(!self.stderr.contains(word), "'{word}'\n{self}");
        }
        self
    }

    /// Insists on exactly one line `error: …`, the last one, with all these words in it, and on no data.
    #[track_caller]
    pub fn complains(&self, words: &[&str]) {
        let errors: Vec<&str> = self.stderr.lines().filter(|line| line.starts_with("error: ")).collect();
        assert_eq!(errors.len(), 1, "one message\n{self}");
        assert_eq!(self.stderr.lines().last(), Some(errors[0]), "the message ends the notices\n{self}");
        for word in words {
            assert!(errors[0].contains(word), "'{word}' is not in the message\n{self}");
        }
        assert_eq!(self.stdout, "", "data of a failed run\n{self}");
    }

    /// Insists on a line of stderr that starts with `notice: ` and has all these words.
    #[track_caller]
    pub fn notices(&self, words: &[&str]) {
        let told = |line: &str| line.starts_with("notice: ") && words.iter().all(|word| line.contains(word));
        assert!(self.stderr.lines().any(told), "no notice with {words:?}\n{self}");
    }
}

impl std::fmt::Display for Outcome {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Outcome { line, code, stdout, stderr } = self;
        write!(f, "$ {line}\n--- exit code {code}, stdout:\n{stdout}--- stderr:\n{stderr}---")
    }
}
