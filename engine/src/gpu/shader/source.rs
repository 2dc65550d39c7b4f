//! Where GLSL text comes from.

use std::{
    borrow::Cow,
    collections::{BTreeMap, HashMap},
    fs,
    path::{Path, PathBuf},
};

include!(concat!(env!("OUT_DIR"), "/embedded_shaders.rs"));

/// Files by their path below the shader root.
pub(super) struct Sources {
    dir: Option<PathBuf>,
    provided: HashMap<String, String>,
}

impl Sources {
    pub fn new(dir: Option<&Path>) -> Self {
        Sources { dir: dir.map(Path::to_owned), provided: HashMap::new() }
    }

    pub fn provide(&mut self, name: &str, text: String) {
        self.provided.insert(name.to_owned(), text);
    }

    /// The file's text, or what to tell the user.
    pub fn read(&self, path: &str) -> Result<Cow<'_, str>, String> {
        if let Some(text) = self.provided.get(path) {
            return Ok(text.into());
        }
        if let Some(dir) = &self.dir {
            let file = dir.join(path);
            return fs::read_to_string(&file).map(Cow::from).map_err(|e| format!("{}: {e}", file.display()));
        }
        let embedded = EMBEDDED.iter().find(|(name, _)| *name == path);
        embedded.map(|(_, text)| (*text).into()).ok_or_else(|| "no such shader in this program".to_owned())
    }

    /// Path and text of `#include "name"` in the file `from`: beside it, else from the root.
    pub fn resolve(&self, name: &str, from: &str) -> Option<(String, String)> {
        let folder = from.rsplit_once('/').map_or("", |(folder, _)| folder);
        [normalise(&format!("{folder}/{name}")), normalise(name)].into_iter().flatten().find_map(|path| {
            let text = self.read(&path).ok()?.into_owned();
            Some((path, text))
        })
    }

    /// All files that `text` may include, directly or not, by path. Conditionals are not looked at: a file too many
    /// in a cache key costs nothing.
    pub fn includes(&self, path: &str, text: &str) -> BTreeMap<String, String> {
        let mut found = BTreeMap::new();
        let mut open = vec![(path.to_owned(), text.to_owned())];
        while let Some((from, text)) = open.pop() {
            for name in text.lines().filter_map(included) {
                if let Some((path, text)) = self.resolve(name, &from)
                    && found.insert(path.clone(), text.clone()).is_none()
                {
                    open.push((path, text));
                }
            }
        }
        found
    }
}

fn included(line: &str) -> Option<&str> {
    let rest = line.trim_start().strip_prefix('#')?.trim_start().strip_prefix("include")?.trim_start();
    let (close, rest) = match rest.split_at_checked(1)? {
        ("\"", rest) => ('"', rest),
        ("<", rest) => ('>', rest),
        _ => return None,
    };
    rest.split_once(close).map(|(name, _)| name)
}

/// Resolves "." and ".."; `None` for a path that leaves the root.
fn normalise(path: &str) -> Option<String> {
    let mut parts = Vec::new();
    for part in path.split('/') {
        match part {
            "" | "." => {}
            ".." => drop(parts.pop()?),
            part => parts.push(part),
        }
    }
    Some(parts.join("/"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn includes_are_found_beside_and_from_the_root_never_outside() {
        let mut sources = Sources::new(None);
        sources.provide("a/x.glsl", "  # include <b/y.glsl>\n".into());
        sources.provide("b/y.glsl", "#include \"z.glsl\"\n#include \"../a/x.glsl\"".into());
        sources.provide("b/z.glsl", "1".into());
        assert_eq!(sources.resolve("x.glsl", "a/main.frag").unwrap().0, "a/x.glsl");
        assert!(sources.resolve("../../a/x.glsl", "a/main.frag").is_none());
        let all = sources.includes("a/main.frag", "#include \"x.glsl\"");
        assert_eq!(all.keys().collect::<Vec<_>>(), ["a/x.glsl", "b/y.glsl", "b/z.glsl"]);
    }
}
