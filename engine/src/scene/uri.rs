//! URIs of buffers and images: embedded data, and files that may not leave the scene's folder.

use std::path::{Component, Path, PathBuf};

/// Why a URI gave no bytes; the caller adds the file and the object.
#[derive(Debug)]
pub(super) struct Refusal {
    /// What is wrong.
    pub problem: String,
    /// What the user can do.
    pub mend: String,
}

impl Refusal {
    fn new(problem: impl Into<String>, mend: impl Into<String>) -> Self {
        Refusal { problem: problem.into(), mend: mend.into() }
    }
}

/// The bytes behind a URI of a scene whose file lies in `folder`.
pub(super) fn read(folder: &Path, uri: &str) -> Result<Vec<u8>, Refusal> {
    match uri.strip_prefix("data:") {
        Some(data) => decode_data(data),
        None => read_file(folder, uri),
    }
}

/// What to call the object behind a URI: the file's name, or nothing for embedded data.
pub(super) fn file_name(uri: &str) -> Option<String> {
    if uri.starts_with("data:") {
        return None;
    }
    let path = percent_decode(uri)?;
    let name = path.rsplit(['/', '\\']).next().filter(|name| !name.is_empty())?;
    Some(name.to_owned())
}

fn read_file(folder: &Path, uri: &str) -> Result<Vec<u8>, Refusal> {
    let relative = relative_path(uri)?;
    let cannot = |error: std::io::Error| {
        Refusal::new(format!("its file '{uri}' cannot be read ({error})"), "put the file there, or correct the uri")
    };
    // The path was checked by its text; a link in it can still lead elsewhere, so compare what the links resolve to.
    let root = folder.canonicalize().map_err(cannot)?;
    let path = root.join(relative).canonicalize().map_err(cannot)?;
    if !path.starts_with(&root) {
        return Err(leaves(uri));
    }
    // Reading a pipe or a device could block or never end.
    if !path.metadata().map_err(cannot)?.is_file() {
        return Err(Refusal::new(format!("'{uri}' is no regular file"), "correct the uri"));
    }
    std::fs::read(path).map_err(cannot)
}

/// The path of a relative URI, refused if it is anything but a path to below the folder it starts from.
fn relative_path(uri: &str) -> Result<PathBuf, Refusal> {
    if has_scheme(uri) {
        return Err(Refusal::new(
            format!("its uri '{}' is no relative path", shorten(uri)),
            "keep the data in a file beside the scene, or embed it with data:",
        ));
    }
    let Some(decoded) = percent_decode(uri) else {
        return Err(Refusal::new(format!("its uri '{uri}' has a broken % escape"), "write %25 for a percent sign"));
    };
    // Backslashes separate folders on Windows only: refused everywhere, so that a scene means the same everywhere.
    if decoded.starts_with('/') || decoded.contains('\\') || has_scheme(&decoded) {
        return Err(leaves(uri));
    }
    let mut depth = 0_usize;
    let path = PathBuf::from(&decoded);
    for component in path.components() {
        match component {
            Component::Normal(_) => depth += 1,
            Component::CurDir => {}
            Component::ParentDir if depth > 0 => depth -= 1,
            Component::ParentDir | Component::RootDir | Component::Prefix(_) => {
                return Err(leaves(uri));
            }
        }
    }
    if depth == 0 {
        return Err(Refusal::new("its uri names no file", "name a file beside the scene"));
    }
    Ok(path)
}

fn leaves(uri: &str) -> Refusal {
    Refusal::new(
        format!("its uri '{}' leaves the scene's folder", shorten(uri)),
        "move the file beside the scene and use a relative uri",
    )
}

/// RFC 3986: a letter, then letters, digits, `+`, `-`, `.`, up to a colon. A Windows drive letter is one, too.
fn has_scheme(uri: &str) -> bool {
    uri.split_once(':').is_some_and(|(scheme, _)| {
        scheme.starts_with(|c: char| c.is_ascii_alphabetic())
            && scheme.chars().all(|c| c.is_ascii_alphanumeric() || "+-.".contains(c))
    })
}

/// A URI for a message: nobody wants a megabyte of it.
fn shorten(uri: &str) -> String {
    const MOST: usize = 80;
    match uri.char_indices().nth(MOST) {
        Some((end, _)) => format!("{}…", &uri[..end]),
        None => uri.to_owned(),
    }
}

fn percent_decode(text: &str) -> Option<String> {
    let mut bytes = Vec::with_capacity(text.len());
    let mut rest = text.as_bytes();
    while let Some((&first, tail)) = rest.split_first() {
        rest = tail;
        if first == b'%' {
            let (digits, tail) = rest.split_at_checked(2)?;
            let digit = |byte: u8| char::from(byte).to_digit(16);
            // Two hexadecimal digits make at most 255.
            bytes.push((digit(digits[0])? * 16 + digit(digits[1])?) as u8);
            rest = tail;
        } else {
            bytes.push(first);
        }
    }
    String::from_utf8(bytes).ok()
}

/// What follows `data:`, which glTF always writes in base64.
fn decode_data(data: &str) -> Result<Vec<u8>, Refusal> {
    let broken = |problem: &str| Refusal::new(format!("its data uri {problem}"), "embed the bytes as data:…;base64,…");
    let (header, text) = data.split_once(',').ok_or_else(|| broken("has no comma"))?;
    if !header.ends_with(";base64") {
        return Err(broken("is not base64"));
    }
    decode_base64(text).ok_or_else(|| broken("has characters that are no base64, or ends too early"))
}

/// RFC 4648 with or without padding.
fn decode_base64(text: &str) -> Option<Vec<u8>> {
    let digits = text.trim_end_matches('=').as_bytes();
    // One digit left over holds less than a byte.
    if digits.len() % 4 == 1 {
        return None;
    }
    let mut bytes = Vec::with_capacity(digits.len() / 4 * 3 + 2);
    for group in digits.chunks(4) {
        let mut bits = 0_u32;
        for &digit in group {
            bits = bits << 6 | base64_digit(digit)?;
        }
        bits <<= 6 * (4 - group.len());
        bytes.extend_from_slice(&bits.to_be_bytes()[1..group.len()]);
    }
    Some(bytes)
}

fn base64_digit(digit: u8) -> Option<u32> {
    let value = match digit {
        b'A'..=b'Z' => digit - b'A',
        b'a'..=b'z' => digit - b'a' + 26,
        b'0'..=b'9' => digit - b'0' + 52,
        b'+' => 62,
        b'/' => 63,
        _ => return None,
    };
    Some(value.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_of_every_length() {
        for (text, bytes) in [
            ("", &b""[..]),
            ("Zg==", b"f"),
            ("Zm8=", b"fo"),
            ("Zm9v", b"foo"),
            ("Zm9vYg", b"foob"),
            ("Zm9vYmE=", b"fooba"),
            ("Zm9vYmFy", b"foobar"),
            ("+/+/", b"\xFB\xFF\xBF"),
        ] {
            assert_eq!(decode_base64(text).as_deref(), Some(bytes), "{text}");
        }
        for text in ["Z", "Zm9vY", "Zm 9", "Zg==Zg==", "Zm9\u{e9}"] {
            assert_eq!(decode_base64(text), None, "{text}");
        }
    }

    #[test]
    fn paths_stay_below_the_folder() {
        for uri in ["a.png", "./a.png", "b/../a.png", "a%20b.png", "b/c/..%2Fa.png", "..a", "é.png"] {
            assert!(relative_path(uri).is_ok(), "{uri}");
        }
        for uri in
            ["../a.png", "b/../../a.png", "%2e%2e/a.png", "/etc/passwd", "%2Fetc/passwd", "..\\a.png", "%41:b.png"]
        {
            let refusal = relative_path(uri).expect_err(uri);
            assert!(refusal.problem.contains("leaves the scene's folder"), "{uri}: {}", refusal.problem);
        }
        for uri in ["file:///a.png", "http://example.org/a.png", "C:/a.png", "C:a.png"] {
            let refusal = relative_path(uri).expect_err(uri);
            assert!(refusal.problem.contains("is no relative path"), "{uri}: {}", refusal.problem);
        }
        for uri in ["", ".", "a/.."] {
            assert!(relative_path(uri).expect_err(uri).problem.contains("names no file"), "{uri}");
        }
        for uri in ["%", "%4", "%zz", "%FF"] {
            assert!(relative_path(uri).expect_err(uri).problem.contains("broken % escape"), "{uri}");
        }
    }

    #[test]
    fn names_come_from_the_last_part() {
        assert_eq!(file_name("maps/wall%20a.png").as_deref(), Some("wall a.png"));
        assert_eq!(file_name("data:image/png;base64,AAAA"), None);
    }
}
