//! The renderer without the program around it: many frames on one device, each beside its reference.

// Every test file is a program of its own and uses its own part of this.
#![allow(dead_code)]

pub mod exactness;
pub mod holes;
pub mod lights;
pub mod random;
pub mod record;
pub mod square;
pub mod worst;

use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

use glam::Vec3;
use prism_engine::{
    aov::Aov,
    error::Result,
    gpu::{
        Access, Context, ContextDesc, Feature, Frames, Image, ImageDesc, PassTimers, Pipeline, Shader, ShaderCompiler,
        ShaderStage, read_image, vk,
    },
    render::{
        self, Output, Renderer,
        culling::Counts,
        deform::{Pose, Vectors},
        plan::Plan,
    },
    scene::{self, Camera, Light, Scene},
    settings::{Settings, Shell, Stage},
};

/// Both stages that can make a shell.
pub const STAGES: [Stage; 2] = [Stage::Mesh, Stage::Geometry];

/// Both shells.
pub const SHELLS: [Shell; 2] = [Shell::Prism, Shell::Walk];

/// A scene of the project's assets.
pub fn asset(name: &str) -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets").join(name);
    scene::load(&path).unwrap_or_else(|error| panic!("{error}"))
}

/// A shell by the default march, which is exact; loops that give up are counted.
pub fn exact(shell: Shell, stage: Stage) -> Settings {
    Settings { shell, stage, count_limits: true, ..Settings::default() }
}

/// Shaders to be tested in place of the project's own, by the variable `PRISM_SHADERS`, to look into a bug.
pub fn shader_folder() -> Option<PathBuf> {
    std::env::var_os("PRISM_SHADERS").map(PathBuf::from)
}

/// Format of the picture.
pub const FORMAT: vk::Format = vk::Format::R8G8B8A8_SRGB;

/// A device that has both stages.
pub struct Rig {
    compiler: ShaderCompiler,
    ctx: Context,
}

impl Rig {
    /// The first device that serves.
    pub fn new() -> Rig {
        Rig::asking(&[Feature::MeshShader, Feature::GeometryShader, Feature::FragmentStoresAndAtomics])
    }

    /// The first device that has these features, and nothing more enabled.
    pub fn asking(required: &[Feature]) -> Rig {
        let desc = ContextDesc { app: "prism tests", required, ..ContextDesc::default() };
        let ctx = Context::new(&desc).unwrap_or_else(|error| panic!("{error}"));
        Rig { compiler: render::shader_compiler(shader_folder().as_deref()).expect("a compiler"), ctx }
    }

    /// Name and driver of the device.
    pub fn device(&self) -> String {
        format!("{}, {}", self.ctx.device_name(), self.ctx.driver().trim())
    }

    /// What is enabled on the device.
    pub fn context(&self) -> &Context {
        &self.ctx
    }

    /// Names of all allocations on the device.
    pub fn allocations(&self) -> Vec<String> {
        self.ctx.memory_report().into_iter().map(|(name, _)| name).collect()
    }

    /// Puts a scene on the device, to be drawn with AOVs.
    pub fn easel(&self, scene: &Scene, settings: &Settings, extent: [u32; 2]) -> Easel {
        self.try_easel(scene, settings, extent).expect("a renderer")
    }

    /// The same, or why it cannot be.
    pub fn try_easel(&self, scene: &Scene, settings: &Settings, extent: [u32; 2]) -> Result<Easel> {
        self.try_easel_with(scene, settings, extent, true)
    }

    /// The same, with AOVs or without.
    pub fn try_easel_with(&self, scene: &Scene, settings: &Settings, extent: [u32; 2], aov: bool) -> Result<Easel> {
        let format = FORMAT;
        let output = Output { color_format: format, aov };
        let usage = vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::TRANSFER_SRC;
        let desc = ImageDesc { name: "picture", extent, format, usage, ..ImageDesc::default() };
        Ok(Easel {
            renderer: Renderer::new(&self.ctx, &self.compiler, scene, settings, output)?,
            frames: Frames::new(&self.ctx, 1).expect("a frame"),
            slot: 0,
            target: Image::new(&self.ctx, &desc).expect("a target"),
            ctx: self.ctx.clone(),
        })
    }
}

/// A scene on the device.
pub struct Easel {
    renderer: Renderer,
    frames: Frames,
    /// Of the last frame.
    slot: usize,
    target: Image,
    /// Last, so that it outlives what was made from it.
    ctx: Context,
}

impl Easel {
    /// One frame. A message of the validation layer is a failure.
    pub fn draw(&mut self, camera: &Camera) -> Aov {
        self.draw_posed(camera, None)
    }

    /// The same, with a mesh in a pose of its own: its index and its positions.
    pub fn draw_posed(&mut self, camera: &Camera, pose: Option<(usize, &[Vec3])>) -> Aov {
        let mut frame = self.frames.begin().expect("the last frame has run");
        self.slot = frame.slot();
        frame.cmd.image_barrier(&self.target, Access::COLOR_WRITE.discarded(), Access::COLOR_WRITE);
        if let Some((mesh, positions)) = pose {
            let pose = Pose { positions: Vectors::Slice(positions), normals: None };
            self.renderer.deform(&mut frame.cmd, self.slot, mesh, &pose, None).expect("posed");
        }
        self.renderer.record(&mut frame.cmd, self.slot, camera, &self.target, None).expect("recorded");
        self.frames.submit_and_wait(frame).expect("drawn");
        self.ctx.validation_log().check().unwrap_or_else(|error| panic!("{error}"));
        self.renderer.read_aov().expect("its AOVs")
    }

    /// Records a frame that is not drawn, which takes lavapipe no compilation: the names of its passes, in order.
    pub fn passes(&mut self, camera: &Camera) -> Vec<String> {
        let mut timers = PassTimers::new(&self.ctx, 16, 1).expect("timers");
        let mut frame = self.frames.begin().expect("the last frame has run");
        frame.cmd.image_barrier(&self.target, Access::COLOR_WRITE.discarded(), Access::COLOR_WRITE);
        let slot = frame.slot();
        self.renderer.record(&mut frame.cmd, slot, camera, &self.target, Some(&mut timers)).expect("recorded");
        drop(frame);
        self.ctx.validation_log().check().unwrap_or_else(|error| panic!("{error}"));
        timers.resolve(slot).into_iter().map(|pass| pass.name.to_string()).collect()
    }

    /// One frame's picture, RGBA.
    pub fn picture(&mut self, camera: &Camera) -> Vec<u8> {
        let mut frame = self.frames.begin().expect("the last frame has run");
        frame.cmd.image_barrier(&self.target, Access::COLOR_WRITE.discarded(), Access::COLOR_WRITE);
        let slot = frame.slot();
        self.renderer.record(&mut frame.cmd, slot, camera, &self.target, None).expect("recorded");
        self.frames.submit_and_wait(frame).expect("drawn");
        self.ctx.validation_log().check().unwrap_or_else(|error| panic!("{error}"));
        read_image(&self.ctx, &self.target, Access::COLOR_WRITE).expect("the picture")
    }

    /// Every pipeline that a frame binds, by name.
    pub fn pipelines(&self) -> Vec<(String, &Pipeline)> {
        self.renderer.pipelines()
    }

    /// The plan in force.
    pub fn plan(&self) -> &Plan {
        self.renderer.plan()
    }

    /// Draws with another light from now on, as the scene's only one.
    pub fn set_light(&mut self, light: Light) {
        self.renderer.set_light(0, light);
    }

    /// The shaders of every pipeline that draws a shell.
    pub fn shell_shaders(&self) -> Vec<Arc<Shader>> {
        let pipelines = self.renderer.pipelines();
        let shells = pipelines.iter().filter(|(name, _)| name.starts_with("shell"));
        shells.flat_map(|(_, pipeline)| pipeline.shaders().to_vec()).collect()
    }

    /// Loops of the last frame that gave up.
    pub fn limits_reached(&self) -> u32 {
        self.renderer.limits_reached(self.slot).expect("a counter").expect("the settings ask for it")
    }

    /// What became of the last frame's prisms.
    pub fn culled(&self) -> Counts {
        self.renderer.culled(self.slot).expect("counts").expect("the settings ask for them")
    }

    /// Insists that every shell of the scene goes through `stage`, by the SPIR-V of the pipelines that are bound: a
    /// fallback to the other stage would otherwise pass for it.
    #[track_caller]
    pub fn assert_stage(&self, stage: Stage) {
        let expected: &[ShaderStage] = match stage {
            Stage::Mesh => &[ShaderStage::Mesh, ShaderStage::Fragment],
            _ => &[ShaderStage::Vertex, ShaderStage::Geometry, ShaderStage::Fragment],
        };
        let pipelines = self.renderer.pipelines();
        let shells: Vec<_> = pipelines.iter().filter(|(name, _)| name.starts_with("shell")).collect();
        assert!(!shells.is_empty(), "no pipeline draws a shell");
        for (name, pipeline) in shells {
            assert_eq!(pipeline.execution_models(), expected, "pipeline '{name}', stage {stage}");
        }
    }
}

/// Whether two frames are the same to the bit, which `==` on floats is not.
pub fn same_bits(a: &Aov, b: &Aov) -> bool {
    fn bits<const N: usize>(values: &[[f32; N]]) -> impl Iterator<Item = u32> {
        values.iter().flatten().map(|v| v.to_bits())
    }
    let ones = |aov: &Aov| {
        [&aov.depth, &aov.height_at_hit, &aov.shadow].into_iter().flatten().map(|v| v.to_bits()).collect::<Vec<_>>()
    };
    let threes =
        |aov: &Aov| [&aov.position, &aov.normal, &aov.color].into_iter().flat_map(|v| bits(v)).collect::<Vec<_>>();
    ones(a) == ones(b) && threes(a) == threes(b) && bits(&a.uv).eq(bits(&b.uv))
}
