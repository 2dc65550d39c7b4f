//! What decides on walls reaches the driver as the shaders have it: the SPIR-V carries the decoration that forbids
//! contraction. tests/watertight.rs shows what it is for.

mod rig;

use std::{
    collections::{HashMap, HashSet},
    sync::Arc,
};

use prism_engine::{
    gpu::{Shader, ShaderStage},
    render,
    settings::{Shell, Stage},
};
use rig::{Rig, SHELLS};

/// Results that must not be contracted, by opcode, and what they are made of; of a SPIR-V module.
struct Uncontracted {
    decorated: HashSet<u32>,
    /// Result → opcode and operands.
    results: HashMap<u32, (u32, Vec<u32>)>,
}

impl Uncontracted {
    const F_ADD: u32 = 129;
    const F_SUB: u32 = 131;
    const F_MUL: u32 = 133;

    fn new(spirv: &[u32]) -> Uncontracted {
        const HEADER: usize = 5;
        const OP_DECORATE: u32 = 71;
        const NO_CONTRACTION: u32 = 42;
        let mut module = Uncontracted { decorated: HashSet::new(), results: HashMap::new() };
        let mut rest = &spirv[HEADER..];
        while let Some(first) = rest.first() {
            let (instruction, after) = rest.split_at((first >> 16) as usize);
            match (first & 0xffff, instruction) {
                (OP_DECORATE, [_, target, NO_CONTRACTION]) => {
                    module.decorated.insert(*target);
                }
                (op @ (Self::F_ADD | Self::F_SUB | Self::F_MUL), [_, _, result, operands @ ..]) => {
                    module.results.insert(*result, (op, operands.to_vec()));
                }
                _ => {}
            }
            rest = after;
        }
        module
    }

    /// Whether a result is this operation, decorated, and so are both of its operands.
    fn is(&self, result: u32, op: u32, operands: impl Fn(u32) -> bool) -> bool {
        let made = self.results.get(&result);
        self.decorated.contains(&result) && made.is_some_and(|(o, of)| *o == op && of.iter().all(|x| operands(*x)))
    }

    /// a.x b.y - a.y b.x
    fn is_cross(&self, result: u32) -> bool {
        self.is(result, Self::F_SUB, |x| self.is(x, Self::F_MUL, |_| true))
    }

    /// Discriminants, b b - (4 a) c: `exit_level` has one.
    fn discriminants(&self) -> usize {
        let product = |x: u32| self.is(x, Self::F_MUL, |_| true);
        let of_product = |x: u32| product(x) && self.results[&x].1.iter().any(|factor| product(*factor));
        let is_one = |result: u32| {
            self.is(result, Self::F_SUB, product) && self.results[&result].1.last().is_some_and(|x| of_product(*x))
        };
        self.decorated.iter().filter(|result| is_one(**result)).count()
    }

    /// Cross products, and sums of two of them: `wall_quadratic` has four and one.
    fn cross_products_and_sums(&self) -> [usize; 2] {
        let crosses = self.decorated.iter().filter(|r| self.is_cross(**r)).count();
        let sums = self.decorated.iter().filter(|r| self.is(**r, Self::F_ADD, |x| self.is_cross(x))).count();
        [crosses, sums]
    }
}

/// "precise" has reached the code that the driver gets: what decides on a wall is not contracted, in any stage.
#[test]
fn no_stage_contracts_what_decides_on_walls() {
    let rig = Rig::new();
    let scene = rig::asset("torus.gltf");
    let mut seen = HashSet::new();
    for (shell, stage) in SHELLS.into_iter().flat_map(|shell| rig::STAGES.map(|stage| (shell, stage))) {
        let easel = rig.easel(&scene, &rig::exact(shell, stage), [8, 8]);
        easel.assert_stage(stage);
        for shader in easel.shell_shaders() {
            let module = Uncontracted::new(&shader.spirv);
            println!("{shell}: {}: {} results", shader.label(), module.decorated.len());
            let places = match shader.stage {
                // Outlines are placed by the same products as the pixels' rays.
                ShaderStage::Mesh | ShaderStage::Geometry => {
                    // The geometry stage only chooses lids; the vertex stage places them.
                    !module.decorated.is_empty() || shader.path == "render/lids.geom"
                }
                ShaderStage::Vertex => !module.decorated.is_empty() || shader.path != "render/lids.vert",
                ShaderStage::Fragment => {
                    let [crosses, sums] = module.cross_products_and_sums();
                    let roots = module.discriminants();
                    println!("    {crosses} cross products, {sums} sums of two, {roots} discriminants");
                    // The walk also decides by the discriminants of its walls' roots.
                    crosses >= 4 && sums >= 1 && (shell != Shell::Walk || roots >= 1)
                }
                _ => true,
            };
            assert!(places, "{} lacks NoContraction", shader.label());
            if shader.stage == ShaderStage::Fragment {
                assert_eq!(Uncontracted::new(&without_precise(&shader).spirv).decorated.len(), 0, "it is by 'precise'");
            }
            seen.insert((shell, stage == Stage::Mesh, shader.stage));
        }
    }
    for (mesh, stage) in [(true, ShaderStage::Mesh), (true, ShaderStage::Fragment), (false, ShaderStage::Geometry)] {
        for shell in SHELLS {
            assert!(seen.contains(&(shell, mesh, stage)), "{shell}, {stage:?} was not looked at");
        }
    }
}

/// The same variant, "precise" left out.
fn without_precise(shader: &Shader) -> Arc<Shader> {
    let compiler = render::shader_compiler(rig::shader_folder().as_deref()).expect("a compiler");
    let mut defines: Vec<_> = shader.defines.iter().map(|(name, value)| (name.as_str(), value.clone())).collect();
    defines.push(("precise", String::new()));
    compiler.compile(&shader.path, shader.stage, &defines).unwrap_or_else(|error| panic!("{error}"))
}
