//! Links shaderc and embeds the shader tree.

use std::{env, fmt::Write as _, fs, path::Path};

/// The archives that Debian's `libshaderc_combined.a` leaves out, in link order (each needs those after it).
const DEBIAN_ARCHIVES: [&str; 9] = [
    "SPIRV",
    "glslang",
    "MachineIndependent",
    "GenericCodeGen",
    "OGLCompiler",
    "OSDependent",
    "HLSL",
    "SPIRV-Tools-opt",
    "SPIRV-Tools",
];

fn main() {
    link_shaderc();
    embed_shaders();
}

/// Debian ships shaderc as loose static archives, and its shared library has undefined symbols. An SDK's combined
/// archive is complete, so nothing is added where one is named.
fn link_shaderc() {
    println!("cargo::rerun-if-env-changed=VULKAN_SDK");
    println!("cargo::rerun-if-env-changed=SHADERC_LIB_DIR");
    let has_sdk = env::var_os("VULKAN_SDK").is_some() || env::var_os("SHADERC_LIB_DIR").is_some();
    if has_sdk || env::var("CARGO_CFG_TARGET_OS").as_deref() != Ok("linux") {
        return;
    }
    let arch = env::var("CARGO_CFG_TARGET_ARCH").unwrap_or_default();
    let folders = [format!("/usr/lib/{arch}-linux-gnu"), "/usr/lib".to_owned()];
    for folder in &folders {
        println!("cargo::rustc-link-search=native={folder}");
    }
    // Newer glslangs have merged some of them into others.
    let exists = |name: &str| folders.iter().any(|f| Path::new(f).join(format!("lib{name}.a")).exists());
    for name in DEBIAN_ARCHIVES.into_iter().filter(|name| exists(name)) {
        // Not bundled into our rlib: the final link takes what shaderc still needs, in this order.
        println!("cargo::rustc-link-lib=static:-bundle={name}");
    }
    println!("cargo::rustc-link-lib=dylib=stdc++");
}

/// Writes `EMBEDDED: &[(path, text)]` with every file below `shaders/`, paths relative to it, sorted.
fn embed_shaders() {
    let root = Path::new(&env::var("CARGO_MANIFEST_DIR").expect("cargo sets it")).join("../shaders");
    let root = root.canonicalize().unwrap_or_else(|e| panic!("{}: {e}", root.display()));
    println!("cargo::rerun-if-changed={}", root.display());
    let mut files = Vec::new();
    collect(&root, &mut files);
    files.sort();
    let mut table = String::from("pub(super) const EMBEDDED: &[(&str, &str)] = &[\n");
    for file in &files {
        let name = file.strip_prefix(&root).expect("below root").to_string_lossy().replace('\\', "/");
        writeln!(table, "    ({name:?}, include_str!({:?})),", file.display()).expect("writes to a String");
    }
    table.push_str("];\n");
    let out = Path::new(&env::var("OUT_DIR").expect("cargo sets it")).join("embedded_shaders.rs");
    fs::write(&out, table).unwrap_or_else(|e| panic!("{}: {e}", out.display()));
}

fn collect(dir: &Path, files: &mut Vec<std::path::PathBuf>) {
    for entry in fs::read_dir(dir).unwrap_or_else(|e| panic!("{}: {e}", dir.display())) {
        let path = entry.expect("readable folder entry").path();
        if path.is_dir() {
            collect(&path, files);
        } else if path.file_name().is_some_and(|name| name != "README.md") {
            files.push(path);
        }
    }
}
