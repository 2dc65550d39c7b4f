//! Output files that are whole or not there.

use std::{
    fs::{self, File},
    io::{BufWriter, Write},
    path::{Path, PathBuf},
    process,
};

use prism_engine::error::{Error, Result};

/// What an encoder may fail with.
pub type WriteResult = std::result::Result<(), Box<dyn std::error::Error>>;

/// Finds out before the work begins that `path` cannot be written, as far as its folder tells.
pub fn check_target(path: &Path, object: &str) -> Result<()> {
    let folder = folder_of(path);
    if !folder.is_dir() {
        return Err(Error::input(path, object, "its folder does not exist", format!("create {}", folder.display())));
    }
    if path.is_dir() {
        return Err(Error::input(path, object, "it is a folder", "name a file in it"));
    }
    Ok(())
}

/// Replaces `path` by what `write` writes. A failure leaves the old file, or none: never half a new one.
pub fn replace(path: &Path, object: &str, write: impl FnOnce(&mut BufWriter<File>) -> WriteResult) -> Result<()> {
    check_target(path, object)?;
    let failed = |cause: &dyn std::fmt::Display| {
        Error::input(path, object, format!("cannot be written: {cause}"), "name a file that you may write")
    };
    // Through a link, not in its place; and a device such as /dev/null cannot be replaced, only written to.
    let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    if target.exists() && !target.is_file() {
        let file = File::options().write(true).open(&target).map_err(|e| failed(&e))?;
        return fill(file, write).map_err(|e| failed(&e));
    }
    let temporary = temporary_beside(&target);
    let written = File::create(&temporary)
        .map_err(Into::into)
        .and_then(|file| fill(file, write))
        .and_then(|()| fs::rename(&temporary, &target).map_err(Into::into));
    written.map_err(|cause| {
        // It may never have been created; the first failure is the one to tell.
        let _ = fs::remove_file(&temporary);
        failed(&cause)
    })
}

fn fill(file: File, write: impl FnOnce(&mut BufWriter<File>) -> WriteResult) -> WriteResult {
    let mut buffered = BufWriter::new(file);
    write(&mut buffered)?;
    // A drop would swallow a full disk.
    buffered.flush()?;
    Ok(())
}

fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// In the same folder, so that the rename stays on one file system; with the process's id, so that two do not meet.
fn temporary_beside(target: &Path) -> PathBuf {
    let name = target.file_name().unwrap_or_default().to_string_lossy();
    folder_of(target).join(format!(".{name}.{}.tmp", process::id()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
    }

    #[test]
    fn a_failure_keeps_the_old_file_and_leaves_no_other() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("frame.png");
        replace(&path, "picture", |file| Ok(file.write_all(b"old")?)).unwrap();
        let error = replace(&path, "picture", |file| {
            file.write_all(b"half")?;
            Err("no more".into())
        })
        .unwrap_err();
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(names(folder.path()), ["frame.png"]);
        assert_eq!(error.exit_code(), 1);
        assert!(error.to_string().contains("frame.png") && error.to_string().contains("no more"), "{error}");
    }

    #[test]
    fn a_missing_folder_is_named() {
        let error = check_target(Path::new("/no/such/folder/frame.png"), "picture").unwrap_err().to_string();
        assert!(error.contains("/no/such/folder"), "{error}");
    }

    #[cfg(unix)]
    #[test]
    fn a_link_is_followed_and_a_device_is_written() {
        let folder = tempfile::tempdir().unwrap();
        let (real, link) = (folder.path().join("real"), folder.path().join("link"));
        fs::write(&real, "old").unwrap();
        std::os::unix::fs::symlink(&real, &link).unwrap();
        replace(&link, "picture", |file| Ok(file.write_all(b"new")?)).unwrap();
        assert_eq!(fs::read(&real).unwrap(), b"new");
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        replace(Path::new("/dev/null"), "picture", |file| Ok(file.write_all(b"gone")?)).unwrap();
    }
}
