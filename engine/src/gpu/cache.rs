//! Files that only save time: SPIR-V and pipelines. A cache that cannot be read or written is no error.

use std::{
    fs,
    path::{Path, PathBuf},
    sync::atomic::{AtomicU32, Ordering},
};

/// The user's cache folder for this program: `$XDG_CACHE_HOME/prism-shell`, else `~/.cache/prism-shell`
/// (`%LOCALAPPDATA%\prism-shell` on Windows). `None` where neither is known.
pub fn default_cache_dir() -> Option<PathBuf> {
    let from = |name: &str| std::env::var_os(name).filter(|v| !v.is_empty()).map(PathBuf::from);
    // The XDG specification: a relative path there is to be ignored.
    let base = from("XDG_CACHE_HOME").filter(|p| p.is_absolute());
    let base = base.or_else(|| from("HOME").map(|home| home.join(".cache"))).or_else(|| from("LOCALAPPDATA"));
    base.map(|base| base.join("prism-shell"))
}

/// FNV-1a with 128 bits (Fowler, Noll, Vo). Names files by content; the standard library's hash may change.
pub(super) fn hash(parts: &[&[u8]]) -> u128 {
    const BASIS: u128 = 0x6c62_272e_07bb_0142_62b8_2175_6295_c58d;
    const PRIME: u128 = 0x0000_0000_0100_0000_0000_0000_0000_013b;
    let step = |h: u128, byte: &u8| (h ^ u128::from(*byte)).wrapping_mul(PRIME);
    parts.iter().fold(BASIS, |h, part| {
        // The length keeps ("ab", "c") and ("a", "bc") apart.
        let h = (part.len() as u64).to_le_bytes().iter().fold(h, step);
        part.iter().fold(h, step)
    })
}

/// The file's payload, if the file is whole.
pub(super) fn load(path: &Path) -> Option<Vec<u8>> {
    let bytes = fs::read(path).ok()?;
    let (checksum, payload) = bytes.split_first_chunk::<16>()?;
    (*checksum == hash(&[payload]).to_le_bytes()).then(|| payload.to_vec())
}

/// Writes payload and checksum under a temporary name first: a reader never sees half a file.
pub(super) fn store(path: &Path, payload: &[u8]) {
    static COUNTER: AtomicU32 = AtomicU32::new(0);
    let unique = format!("tmp-{}-{}", std::process::id(), COUNTER.fetch_add(1, Ordering::Relaxed));
    let temporary = path.with_extension(unique);
    let bytes = [&hash(&[payload]).to_le_bytes(), payload].concat();
    let result = path.parent().map_or(Ok(()), fs::create_dir_all);
    let result = result.and_then(|()| fs::write(&temporary, bytes)).and_then(|()| fs::rename(&temporary, path));
    if let Err(e) = result {
        tracing::debug!("not cached: {}: {e}", path.display());
        let _ = fs::remove_file(&temporary);
    }
}
