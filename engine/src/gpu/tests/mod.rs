//! Against lavapipe, with synchronization validation. Where it is missing the tests fail: they never skip.

mod compute;
mod context;
mod draw;
mod shaders;

use std::path::PathBuf;

use super::*;
use crate::{error::Result, settings::Validation};

/// A context on the software renderer with these features and full validation.
fn context(required: &[Feature]) -> Context {
    try_context(required, &[]).unwrap()
}

fn try_context(required: &[Feature], masked: &[Feature]) -> Result<Context> {
    Context::new(&ContextDesc {
        app: "prism-engine tests",
        validation: Validation::Sync,
        selector: Some("llvmpipe"),
        required,
        masked,
        ..ContextDesc::default()
    })
}

/// Nothing was wrong, not even while the context was torn down.
fn assert_clean(ctx: Context) {
    let log = ctx.validation_log();
    drop(ctx);
    assert_eq!(log.messages(), Vec::<String>::new());
}

/// A folder that is removed at the end of the test.
struct TempDir(PathBuf);

impl TempDir {
    fn new(test: &str) -> Self {
        let dir = std::env::temp_dir().join(format!("prism-{test}-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&dir);
        std::fs::create_dir_all(&dir).unwrap();
        TempDir(dir)
    }
}

impl Drop for TempDir {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// A compiler that knows these files, with a cache of its own.
fn compiler(dir: &TempDir, files: &[(&str, &str)]) -> ShaderCompiler {
    let mut compiler = ShaderCompiler::new(None, Some(&dir.0)).unwrap();
    for (name, text) in files {
        compiler.provide(name, (*text).to_owned());
    }
    compiler
}
