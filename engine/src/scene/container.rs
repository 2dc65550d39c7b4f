//! The two containers of glTF: plain JSON, and GLB with its chunks.

use std::path::Path;

use crate::error::{Error, Result};

const MAGIC: &[u8; 4] = b"glTF";
const CHUNK_JSON: u32 = 0x4E4F_534A;
const CHUNK_BIN: u32 = 0x004E_4942;
const HEADER: usize = 12;
const CHUNK_HEADER: usize = 8;

/// The parts of a scene file.
#[derive(Debug)]
pub(super) struct Container<'a> {
    /// The JSON text.
    pub json: &'a [u8],
    /// What to call the JSON in messages.
    pub json_object: &'static str,
    /// GLB's binary chunk.
    pub bin: Option<&'a [u8]>,
}

/// Splits a file into its parts. The content decides, not the file's ending; but a `.glb` without GLB's magic is
/// reported as such, since a JSON parser's complaint about binary data would help nobody.
pub(super) fn split<'a>(file: &Path, bytes: &'a [u8]) -> Result<Container<'a>> {
    if bytes.starts_with(MAGIC) {
        return split_glb(file, bytes);
    }
    if file.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("glb")) {
        return Err(glb_error(file, "does not start with 'glTF'"));
    }
    // glTF forbids a byte order mark but lets readers pass over it.
    let json = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    Ok(Container { json, json_object: "JSON", bin: None })
}

fn split_glb<'a>(file: &Path, bytes: &'a [u8]) -> Result<Container<'a>> {
    let (Some(version), Some(length)) = (u32_at(bytes, 4), u32_at(bytes, 8)) else {
        return Err(glb_error(file, "ends within its header"));
    };
    if version != 2 {
        return Err(glb_error(file, &format!("has container version {version}, not 2")));
    }
    let length = length as usize;
    let Some(mut rest) = bytes.get(HEADER..length) else {
        return Err(glb_error(file, &format!("is {} bytes long, its header says {length}", bytes.len())));
    };

    let mut chunks = Vec::new();
    while !rest.is_empty() {
        let (Some(size), Some(kind)) = (u32_at(rest, 0), u32_at(rest, 4)) else {
            return Err(glb_error(file, &format!("ends within the header of chunk {}", chunks.len())));
        };
        let Some(data) = rest[CHUNK_HEADER..].get(..size as usize) else {
            return Err(glb_error(file, &format!("ends within chunk {}, of {size} bytes", chunks.len())));
        };
        chunks.push((kind, data));
        rest = &rest[CHUNK_HEADER + data.len()..];
    }

    // JSON comes first, binary data second; further chunks belong to extensions and are passed over.
    match chunks.first() {
        Some(&(CHUNK_JSON, json)) => Ok(Container {
            json,
            json_object: "JSON chunk",
            bin: chunks.get(1).filter(|(kind, _)| *kind == CHUNK_BIN).map(|(_, data)| *data),
        }),
        _ => Err(glb_error(file, "has no JSON as its first chunk")),
    }
}

fn glb_error(file: &Path, problem: &str) -> Error {
    Error::input(file, "GLB container", problem, "export or copy the file again")
}

fn u32_at(bytes: &[u8], offset: usize) -> Option<u32> {
    let word = bytes.get(offset..)?.first_chunk::<4>()?;
    Some(u32::from_le_bytes(*word))
}
