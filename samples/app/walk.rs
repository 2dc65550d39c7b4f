//! A sample of several scenes: which files they are, and where the walk through them begins.

use std::path::{Path, PathBuf};

use prism_engine::error::{Error, Result};

/// The scenes of a run, in their order; most samples have one.
#[derive(Clone)]
pub struct Walk {
    files: Vec<PathBuf>,
    first: usize,
}

impl Walk {
    /// A single scene.
    pub fn single(file: PathBuf) -> Walk {
        Walk { files: vec![file], first: 0 }
    }

    /// Several, beginning with the one that `chosen` names or counts.
    pub fn several(files: Vec<PathBuf>, chosen: Option<&Path>) -> Result<Walk> {
        let Some(chosen) = chosen else { return Ok(Walk { files, first: 0 }) };
        let word = chosen.to_string_lossy();
        let number = word.parse::<usize>().ok().and_then(|number| number.checked_sub(1));
        let first = files.iter().position(|file| name(file) == word).or(number).filter(|first| *first < files.len());
        let first = first.ok_or_else(|| {
            let names: Vec<String> = files.iter().map(|file| name(file)).collect();
            Error::Usage(format!(
                "--scene {word}: no such scene here; give a number from 1 to {} or a name: {}",
                names.len(),
                names.join(", ")
            ))
        })?;
        Ok(Walk { files, first })
    }

    /// The first `count` scenes, or all if there are no more, beginning with the chosen one.
    pub fn files(&self, count: u64) -> impl Iterator<Item = &Path> {
        let count = usize::try_from(count).unwrap_or(usize::MAX).min(self.files.len());
        self.files.iter().cycle().skip(self.first).take(count).map(PathBuf::as_path)
    }
}

/// The glTF files of the folder in which `file` lies, in the order of their names: itself at least.
#[cfg(feature = "window")]
pub fn neighbours(file: &Path) -> Vec<PathBuf> {
    let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let entries =
        folder.read_dir().into_iter().flatten().filter_map(|entry| Some(folder.join(entry.ok()?.file_name())));
    let is_scene = |path: &PathBuf| path.extension().is_some_and(|ending| ending == "gltf" || ending == "glb");
    let mut files: Vec<PathBuf> =
        entries.filter(is_scene).filter(|path| path.file_name() != file.file_name()).collect();
    files.push(file.to_owned());
    files.sort();
    files
}

/// What a scene is called: its file's name without the extension.
pub fn name(file: &Path) -> String {
    file.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn order(chosen: Option<&str>, count: u64) -> Result<Vec<String>> {
        let files = ["a/torus.gltf", "a/cube.gltf", "a/cloth.gltf"].map(PathBuf::from).to_vec();
        let walk = Walk::several(files, chosen.map(Path::new))?;
        Ok(walk.files(count).map(name).collect())
    }

    #[test]
    fn a_walk_begins_where_it_is_told_and_goes_around() {
        assert_eq!(order(None, 1).unwrap(), ["torus"]);
        assert_eq!(order(None, 99).unwrap(), ["torus", "cube", "cloth"]);
        assert_eq!(order(Some("cloth"), 2).unwrap(), ["cloth", "torus"]);
        assert_eq!(order(Some("2"), 3).unwrap(), ["cube", "cloth", "torus"]);
    }

    #[test]
    fn a_scene_that_is_not_in_the_walk_is_wrong_usage() {
        for chosen in ["0", "4", "-1", "tor", "cube.gltf", ""] {
            let error = order(Some(chosen), 1).unwrap_err();
            assert_eq!(error.exit_code(), 2);
            assert!(error.to_string().contains("torus, cube, cloth"), "{error}");
        }
    }
}
