//! Finds the samples' models and maps from any working folder.

use std::{
    env,
    path::{Path, PathBuf},
};

use prism_engine::error::{Error, Result};

/// The path of an asset, such as `prism_shell.gltf`. Looked for in the folder that `PRISM_ASSETS` names and nowhere
/// else if it is set; then beside the program as it is installed; then in the checkout it was built from.
pub fn find(name: &str) -> Result<PathBuf> {
    let set = env::var_os("PRISM_ASSETS").filter(|value| !value.is_empty());
    let folders = match &set {
        Some(folder) => vec![PathBuf::from(folder)],
        None => default_folders(env::current_exe().ok().as_deref()),
    };
    let found = folders.iter().map(|folder| folder.join(name)).find(|path| path.is_file());
    found.ok_or_else(|| {
        let places: Vec<String> = folders.iter().map(|folder| folder.display().to_string()).collect();
        Error::input(
            name,
            "asset",
            format!("not found in {}", places.join(", ")),
            "set PRISM_ASSETS to the project's assets folder",
        )
    })
}

fn default_folders(program: Option<&Path>) -> Vec<PathBuf> {
    let mut folders = Vec::new();
    if let Some(folder) = program.and_then(Path::parent) {
        folders.push(folder.join("assets"));
        folders.push(folder.join("../share/prism/assets"));
    }
    folders.push(Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets"));
    folders
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn beside_the_program_comes_before_the_checkout() {
        let folders = default_folders(Some(Path::new("/opt/prism/bin/prism")));
        assert_eq!(folders[0], Path::new("/opt/prism/bin/assets"));
        assert_eq!(folders[1], Path::new("/opt/prism/bin/../share/prism/assets"));
        assert_eq!(folders.len(), 3);
    }

    #[test]
    fn a_missing_asset_names_the_places_and_the_mend() {
        let error = find("no such asset.gltf").unwrap_err().to_string();
        assert!(error.contains("no such asset.gltf") && error.contains("PRISM_ASSETS"), "{error}");
    }
}
