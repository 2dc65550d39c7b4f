//! GLSL to SPIR-V, with includes, variants by `#define`, and a cache on disk by content.

mod reflect;
mod source;

use std::{
    cell::RefCell,
    collections::HashMap,
    fmt,
    path::{Path, PathBuf},
    sync::{Arc, Mutex},
    time::Instant,
};

use ash::vk;

pub use reflect::{BindingInfo, BlockMember, Reflection};
use source::Sources;

use super::{cache, device::lock};
use crate::error::{Error, Result};

/// A programmable stage.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum ShaderStage {
    /// Vertex.
    Vertex,
    /// Tessellation control: how finely a patch is divided.
    TessControl,
    /// Tessellation evaluation: where the vertices of a divided patch lie.
    TessEvaluation,
    /// Geometry.
    Geometry,
    /// Task, before mesh.
    Task,
    /// Mesh.
    Mesh,
    /// Fragment.
    Fragment,
    /// Compute.
    Compute,
}

impl ShaderStage {
    /// Vulkan's flag.
    pub fn flag(self) -> vk::ShaderStageFlags {
        match self {
            ShaderStage::Vertex => vk::ShaderStageFlags::VERTEX,
            ShaderStage::TessControl => vk::ShaderStageFlags::TESSELLATION_CONTROL,
            ShaderStage::TessEvaluation => vk::ShaderStageFlags::TESSELLATION_EVALUATION,
            ShaderStage::Geometry => vk::ShaderStageFlags::GEOMETRY,
            ShaderStage::Task => vk::ShaderStageFlags::TASK_EXT,
            ShaderStage::Mesh => vk::ShaderStageFlags::MESH_EXT,
            ShaderStage::Fragment => vk::ShaderStageFlags::FRAGMENT,
            ShaderStage::Compute => vk::ShaderStageFlags::COMPUTE,
        }
    }

    /// The name in reports, as in a file's ending: "vert", "tesc", "tese", "geom", "task", "mesh", "frag", "comp".
    pub fn name(self) -> &'static str {
        match self {
            ShaderStage::Vertex => "vert",
            ShaderStage::TessControl => "tesc",
            ShaderStage::TessEvaluation => "tese",
            ShaderStage::Geometry => "geom",
            ShaderStage::Task => "task",
            ShaderStage::Mesh => "mesh",
            ShaderStage::Fragment => "frag",
            ShaderStage::Compute => "comp",
        }
    }

    fn kind(self) -> shaderc::ShaderKind {
        match self {
            ShaderStage::Vertex => shaderc::ShaderKind::Vertex,
            ShaderStage::TessControl => shaderc::ShaderKind::TessControl,
            ShaderStage::TessEvaluation => shaderc::ShaderKind::TessEvaluation,
            ShaderStage::Geometry => shaderc::ShaderKind::Geometry,
            ShaderStage::Task => shaderc::ShaderKind::Task,
            ShaderStage::Mesh => shaderc::ShaderKind::Mesh,
            ShaderStage::Fragment => shaderc::ShaderKind::Fragment,
            ShaderStage::Compute => shaderc::ShaderKind::Compute,
        }
    }
}

impl fmt::Display for ShaderStage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// One compiled variant.
#[derive(Debug)]
pub struct Shader {
    /// SPIR-V 1.6.
    pub spirv: Vec<u32>,
    /// What it reads and writes. `reflection.stage` is what the SPIR-V itself says.
    pub reflection: Reflection,
    /// Path below `shaders/`.
    pub path: String,
    /// The variant's defines, sorted by name.
    pub defines: Vec<(String, String)>,
    /// The stage it was compiled for.
    pub stage: ShaderStage,
}

impl Shader {
    /// Path and defines, for messages and debug names.
    pub fn label(&self) -> String {
        label(&self.path, &self.defines)
    }
}

/// What compiling cost so far.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CompileStats {
    /// Variants found on disk.
    pub hits: u32,
    /// Variants compiled.
    pub misses: u32,
    /// Milliseconds spent in the compiler.
    pub compile_ms: f64,
}

/// Compiles shaders below one root: the embedded tree, or a folder. Each variant once.
pub struct ShaderCompiler {
    compiler: shaderc::Compiler,
    sources: Sources,
    cache_dir: Option<PathBuf>,
    compiled: Mutex<HashMap<u128, Arc<Shader>>>,
    stats: Mutex<CompileStats>,
}

/// Changes with whatever changes the SPIR-V of unchanged sources.
const CACHE_FORMAT: &str = concat!("prism-shell ", env!("CARGO_PKG_VERSION"), " spirv 1.6 performance debug 1");

impl ShaderCompiler {
    /// Reads `shader_dir` in place of the embedded tree if given; keeps SPIR-V in `cache_dir`, by default in
    /// [`super::default_cache_dir`].
    pub fn new(shader_dir: Option<&Path>, cache_dir: Option<&Path>) -> Result<Self> {
        let compiler = shaderc::Compiler::new().map_err(|e| Error::gpu("starting the shader compiler", e))?;
        let cache_dir = cache_dir.map(Path::to_owned).or_else(super::default_cache_dir);
        Ok(ShaderCompiler {
            compiler,
            sources: Sources::new(shader_dir),
            cache_dir: cache_dir.map(|dir| dir.join("spirv")),
            compiled: Mutex::default(),
            stats: Mutex::default(),
        })
    }

    /// Adds a generated file, which hides one of the same path. For includes written by Rust, and for tests.
    pub fn provide(&mut self, name: &str, text: String) {
        self.sources.provide(name, text);
    }

    /// The variant of `path` (below the root, as in "render/surface.frag") with these defines.
    ///
    /// `#include "a/b.glsl"` is looked up beside the including file, then from the root.
    ///
    /// # Errors
    /// [`Error::Shader`] with the compiler's log, which names files below the root, and lines.
    pub fn compile(&self, path: &str, stage: ShaderStage, defines: &[(&str, String)]) -> Result<Arc<Shader>> {
        let mut defines: Vec<_> = defines.iter().map(|(name, value)| ((*name).to_owned(), value.clone())).collect();
        defines.sort();
        let fail = |log: String| Error::Shader { shader: label(path, &defines), log };
        let text = self.sources.read(path).map_err(&fail)?;
        let key = self.key(path, &text, stage, &defines);
        if let Some(shader) = lock(&self.compiled).get(&key) {
            return Ok(shader.clone());
        }
        let file = self.cache_dir.as_ref().map(|dir| dir.join(format!("{key:032x}.spv")));
        let cached = file.as_deref().and_then(cache::load).and_then(|bytes| {
            let spirv = bytemuck::try_cast_slice(&bytes).map(<[u32]>::to_vec).ok()?;
            let reflection = reflect::reflect(&spirv).ok()?;
            Some((spirv, reflection))
        });
        let (spirv, reflection) = match cached {
            Some(found) => {
                lock(&self.stats).hits += 1;
                found
            }
            None => {
                let start = Instant::now();
                let spirv = self.compile_text(path, &text, stage, &defines).map_err(&fail)?;
                let mut stats = lock(&self.stats);
                stats.misses += 1;
                stats.compile_ms += start.elapsed().as_secs_f64() * 1e3;
                drop(stats);
                let reflection = reflect::reflect(&spirv).map_err(&fail)?;
                if let Some(file) = &file {
                    cache::store(file, bytemuck::cast_slice(&spirv));
                }
                (spirv, reflection)
            }
        };
        let shader = Arc::new(Shader { spirv, reflection, path: path.to_owned(), defines, stage });
        lock(&self.compiled).insert(key, shader.clone());
        Ok(shader)
    }

    /// What compiling cost so far.
    pub fn stats(&self) -> CompileStats {
        *lock(&self.stats)
    }

    /// Names the variant by everything that its SPIR-V depends on.
    fn key(&self, path: &str, text: &str, stage: ShaderStage, defines: &[(String, String)]) -> u128 {
        let (version, revision) = shaderc::get_spirv_version();
        let compiler = format!("{CACHE_FORMAT}, {version:#x}.{revision}");
        let mut parts = vec![compiler.as_bytes(), stage.name().as_bytes(), path.as_bytes(), text.as_bytes()];
        for (name, value) in defines {
            parts.extend([name.as_bytes(), value.as_bytes()]);
        }
        let includes = self.sources.includes(path, text);
        for (name, text) in &includes {
            parts.extend([name.as_bytes(), text.as_bytes()]);
        }
        cache::hash(&parts)
    }

    fn compile_text(
        &self,
        path: &str,
        text: &str,
        stage: ShaderStage,
        defines: &[(String, String)],
    ) -> std::result::Result<Vec<u32>, String> {
        // shaderc's own message for a failed include does not say what was looked for.
        let missing = RefCell::new(None);
        let mut options = shaderc::CompileOptions::new().map_err(|e| e.to_string())?;
        options.set_target_env(shaderc::TargetEnv::Vulkan, shaderc::EnvVersion::Vulkan1_3 as u32);
        options.set_target_spirv(shaderc::SpirvVersion::V1_6);
        options.set_optimization_level(shaderc::OptimizationLevel::Performance);
        // Without it the optimiser strips the names that bindings are found by.
        options.set_generate_debug_info();
        for (name, value) in defines {
            options.add_macro_definition(name, Some(value));
        }
        options.set_include_callback(|name, _, from, _| match self.sources.resolve(name, from) {
            Some((resolved_name, content)) => Ok(shaderc::ResolvedInclude { resolved_name, content }),
            None => {
                let message = format!("{from}: no file \"{name}\" beside it or below the shader root");
                *missing.borrow_mut() = Some(message.clone());
                Err(message)
            }
        });
        let result = self.compiler.compile_into_spirv(text, stage.kind(), path, "main", Some(&options));
        let artifact = result.map_err(|e| match missing.take() {
            Some(missing) => missing,
            None => e.to_string(),
        })?;
        if artifact.get_num_warnings() > 0 {
            tracing::warn!("{}: {}", label(path, defines), artifact.get_warning_messages().trim_end());
        }
        Ok(artifact.as_binary().to_vec())
    }
}

fn label(path: &str, defines: &[(String, String)]) -> String {
    if defines.is_empty() {
        return path.to_owned();
    }
    let list: Vec<_> = defines.iter().map(|(name, value)| format!("{name}={value}")).collect();
    format!("{path} [{}]", list.join(" "))
}
