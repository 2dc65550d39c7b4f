//! What a SPIR-V module reads and writes.

use ash::vk;
use spirq::{
    ReflectConfig,
    entry_point::ExecutionModel,
    ty::{DescriptorType, Type},
    var::Variable,
};

use super::ShaderStage;

/// A module's interface. Only what the optimised code still uses appears.
#[derive(Clone, Debug)]
pub struct Reflection {
    /// The execution model that the SPIR-V declares.
    pub stage: ShaderStage,
    /// Descriptors by set and binding.
    pub bindings: Vec<BindingInfo>,
    /// Bytes of the push constant block; 0 without one.
    pub push_constant_size: u32,
    /// The push constant block's members.
    pub push_constants: Vec<BlockMember>,
    /// Location and name of each output variable.
    pub outputs: Vec<(u32, String)>,
    /// Workgroup size of compute, task and mesh shaders.
    pub local_size: Option<[u32; 3]>,
}

/// One descriptor.
#[derive(Clone, Debug)]
pub struct BindingInfo {
    /// Descriptor set.
    pub set: u32,
    /// Binding in it.
    pub binding: u32,
    /// The variable's name; of a block without an instance name, the block's.
    pub name: String,
    /// Kind of descriptor.
    pub ty: vk::DescriptorType,
    /// Array size; 1 for a plain descriptor.
    pub count: u32,
    /// Members of a buffer block.
    pub members: Vec<BlockMember>,
}

/// A member of a block, however deep: "lights[].color" is one of the first element of `lights`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BlockMember {
    /// Path from the block; elements of arrays are marked "[]".
    pub path: String,
    /// Bytes from the block's start, in the first element of each array.
    pub offset: u32,
    /// Bytes; 0 for an array without a length.
    pub size: u32,
    /// Bytes from element to element, of an array.
    pub stride: Option<u32>,
}

pub(super) fn reflect(spirv: &[u32]) -> Result<Reflection, String> {
    let entries = ReflectConfig::new().spv(spirv).reflect().map_err(|e| format!("reading the SPIR-V: {e}"))?;
    let entry = entries.into_iter().next().ok_or("the SPIR-V has no entry point")?;
    let stage = match entry.exec_model {
        ExecutionModel::Vertex => ShaderStage::Vertex,
        ExecutionModel::TessellationControl => ShaderStage::TessControl,
        ExecutionModel::TessellationEvaluation => ShaderStage::TessEvaluation,
        ExecutionModel::Geometry => ShaderStage::Geometry,
        ExecutionModel::TaskEXT => ShaderStage::Task,
        ExecutionModel::MeshEXT => ShaderStage::Mesh,
        ExecutionModel::Fragment => ShaderStage::Fragment,
        ExecutionModel::GLCompute => ShaderStage::Compute,
        other => return Err(format!("execution model {other:?} is not used by this engine")),
    };
    let mut reflection = Reflection {
        stage,
        bindings: Vec::new(),
        push_constant_size: 0,
        push_constants: Vec::new(),
        outputs: Vec::new(),
        local_size: local_size(spirv),
    };
    for variable in entry.vars {
        match variable {
            Variable::Descriptor { name, desc_bind, desc_ty, ty, nbind } => {
                let (set, binding) = desc_bind.into_inner();
                reflection.bindings.push(BindingInfo {
                    set,
                    binding,
                    name: variable_name(name, &ty),
                    ty: descriptor_type(&desc_ty)
                        .ok_or_else(|| format!("descriptor {set}.{binding}: {desc_ty:?} is not used by this engine"))?,
                    count: nbind,
                    members: members(&ty),
                });
            }
            Variable::PushConstant { ty, .. } => {
                reflection.push_constant_size = ty.nbyte().unwrap_or_default() as u32;
                reflection.push_constants = members(&ty);
            }
            Variable::Output { name, location, ty } => {
                reflection.outputs.push((location.loc(), variable_name(name, &ty)));
            }
            Variable::Input { .. } | Variable::SpecConstant { .. } => {}
        }
    }
    reflection.bindings.sort_by_key(|b| (b.set, b.binding));
    reflection.outputs.sort();
    Ok(reflection)
}

fn variable_name(name: Option<String>, ty: &Type) -> String {
    let block = || match ty {
        Type::Struct(block) => block.name.clone(),
        _ => None,
    };
    name.filter(|n| !n.is_empty()).or_else(block).unwrap_or_default()
}

fn descriptor_type(ty: &DescriptorType) -> Option<vk::DescriptorType> {
    Some(match ty {
        DescriptorType::CombinedImageSampler() => vk::DescriptorType::COMBINED_IMAGE_SAMPLER,
        DescriptorType::StorageImage(_) => vk::DescriptorType::STORAGE_IMAGE,
        DescriptorType::UniformBuffer() => vk::DescriptorType::UNIFORM_BUFFER,
        DescriptorType::StorageBuffer(_) => vk::DescriptorType::STORAGE_BUFFER,
        _ => return None,
    })
}

fn members(ty: &Type) -> Vec<BlockMember> {
    let mut list = Vec::new();
    if matches!(ty, Type::Struct(_)) {
        walk(ty, "", 0, &mut list);
    }
    list
}

fn walk(ty: &Type, path: &str, offset: u32, list: &mut Vec<BlockMember>) {
    let size = ty.nbyte().unwrap_or_default() as u32;
    match ty {
        Type::Struct(block) => {
            if !path.is_empty() {
                list.push(BlockMember { path: path.to_owned(), offset, size, stride: None });
            }
            for member in &block.members {
                let name = member.name.as_deref().unwrap_or_default();
                let path = if path.is_empty() { name.to_owned() } else { format!("{path}.{name}") };
                walk(&member.ty, &path, offset + member.offset.unwrap_or_default() as u32, list);
            }
        }
        Type::Array(array) => {
            let stride = array.stride.map(|s| s as u32);
            list.push(BlockMember { path: path.to_owned(), offset, size, stride });
            walk(&array.element_ty, &format!("{path}[]"), offset, list);
        }
        _ => list.push(BlockMember { path: path.to_owned(), offset, size, stride: None }),
    }
}

/// The workgroup size, from the execution mode `LocalSize` or, as glslang writes for SPIR-V 1.6, `LocalSizeId`.
fn local_size(spirv: &[u32]) -> Option<[u32; 3]> {
    const OP_EXECUTION_MODE: u32 = 16;
    const OP_CONSTANT: u32 = 43;
    const OP_EXECUTION_MODE_ID: u32 = 331;
    const LOCAL_SIZE: u32 = 17;
    const LOCAL_SIZE_ID: u32 = 38;
    for (opcode, operands) in instructions(spirv) {
        match (opcode, operands) {
            (OP_EXECUTION_MODE, &[_, LOCAL_SIZE, x, y, z]) => return Some([x, y, z]),
            (OP_EXECUTION_MODE_ID, &[_, LOCAL_SIZE_ID, x, y, z]) => {
                let constant = |id: u32| {
                    instructions(spirv).find_map(|(opcode, operands)| match (opcode, operands) {
                        (OP_CONSTANT, &[_, result, value]) if result == id => Some(value),
                        _ => None,
                    })
                };
                return Some([constant(x)?, constant(y)?, constant(z)?]);
            }
            _ => {}
        }
    }
    None
}

/// Opcode and operands of each instruction.
fn instructions(spirv: &[u32]) -> impl Iterator<Item = (u32, &[u32])> {
    const HEADER: usize = 5;
    let mut words = spirv.get(HEADER..).unwrap_or_default();
    std::iter::from_fn(move || {
        let first = words.first()?;
        let (instruction, rest) = words.split_at_checked((first >> 16) as usize)?;
        words = rest;
        Some((first & 0xffff, instruction.get(1..)?))
    })
}
