//! New pipelines for shaders that have changed, made beside the frames that still use the old ones.

use std::{collections::HashMap, sync::Arc};

use super::pipelines::{variant_pipeline, variant_shaders};
use super::{Output, Renderer, Variant, explain};
use crate::{
    error::Result,
    gpu::{Context, Pipeline, Shader, ShaderCompiler},
};

/// What it takes to make a frame's pipelines anew, on any thread.
pub struct Recipe {
    ctx: Context,
    output: Output,
    /// The pipelines in use, and what they were made of.
    used: Vec<(Variant, Vec<Arc<Shader>>)>,
}

/// Pipelines whose shaders have changed.
pub struct Rebuilt(Vec<(Variant, Pipeline)>);

impl Rebuilt {
    /// How many.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Whether the change has no effect on the frame.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

impl Recipe {
    /// Compiles all shaders as they are now and makes the pipelines of those that differ.
    ///
    /// # Errors
    /// [`crate::error::Error::Shader`], with file and line, where one does not compile.
    pub fn rebuild(&self, compiler: &ShaderCompiler) -> Result<Rebuilt> {
        let mut rebuilt = Vec::new();
        for (variant, old) in &self.used {
            let new = variant_shaders(compiler, variant)?;
            if new.iter().zip(old).any(|(new, old)| new.spirv != old.spirv) {
                rebuilt.push((*variant, variant_pipeline(&self.ctx, self.output, variant, &new)?));
            }
        }
        Ok(Rebuilt(rebuilt))
    }
}

impl Renderer {
    /// What it takes to make the pipelines of the frame as it is drawn now.
    pub fn recipe(&self) -> Recipe {
        let shaders = |variant: Variant| (variant, self.pipelines[&variant].shaders().to_vec());
        Recipe {
            ctx: self.ctx.clone(),
            output: self.output,
            used: explain::variants(&self.plan).into_iter().map(shaders).collect(),
        }
    }

    /// Draws with these pipelines from the next frame on. Those of other settings are made anew when they are asked for.
    ///
    /// # Errors
    /// Where they do not fit what the frame gives them; the old ones then stay.
    pub fn adopt(&mut self, compiler: &ShaderCompiler, rebuilt: Rebuilt) -> Result<()> {
        let used = explain::variants(&self.plan);
        let mut kept: HashMap<Variant, Arc<Pipeline>> = std::mem::take(&mut self.pipelines);
        let mut old: Vec<(Variant, Arc<Pipeline>)> = Vec::new();
        for (variant, pipeline) in rebuilt.0 {
            old.extend(kept.insert(variant, Arc::new(pipeline)).map(|pipeline| (variant, pipeline)));
        }
        kept.retain(|variant, _| used.contains(variant));
        self.pipelines = kept;
        let settings = self.settings.clone();
        let adopted = self.set_settings(compiler, &settings);
        if adopted.is_err() {
            self.pipelines.extend(old);
        }
        adopted
    }
}
