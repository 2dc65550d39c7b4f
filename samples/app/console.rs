//! The two streams: data to stdout, notices to stderr. Unlike `println!`, neither panics when nobody listens.

use std::{
    fmt::Display,
    io::{self, Write},
};

use prism_engine::error::{Error, Result};

/// Writes data to stdout. A reader that has seen enough, such as `head`, is no failure.
pub fn data(text: &str) -> Result<()> {
    let mut stdout = io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(e) if e.kind() != io::ErrorKind::BrokenPipe => {
            Err(Error::input("stdout", "output", format!("cannot be written: {e}"), "check where it is sent"))
        }
        _ => Ok(()),
    }
}

/// Tells the user something that is no error.
pub fn notice(text: impl Display) {
    line(format_args!("notice: {text}"));
}

/// Tells the user why the command failed.
pub fn error(text: impl Display) {
    line(format_args!("error: {text}"));
}

/// Writes a line to stderr. With a closed stderr there is nobody left to tell.
pub fn line(text: impl Display) {
    let _ = writeln!(io::stderr().lock(), "{text}");
}
