//! Includes, variants, reflection, errors and the cache.

use super::*;

const MAIN: &str = "#version 460
#include \"lib/height.glsl\"
layout(set = 1, binding = 2) uniform Frame { mat4 clip; vec3 eye; float time; };
struct Light { vec3 color; float power; };
layout(set = 1, binding = 3) readonly buffer Lights { uint count; Light items[]; } lights;
layout(push_constant) uniform Push { vec2 scale; uint id; } push;
layout(location = 0) out vec4 color;
layout(location = 1) out uint id;
void main() {
    color = clip * vec4(eye * time * height() * lights.items[lights.count].color, push.scale.y);
    id = push.id;
}";

const LIB: &str = "#include \"value.glsl\"
float height() { return VALUE * float(STEPS); }";

fn files(value: &'static str) -> [(&'static str, &'static str); 3] {
    [("render/main.frag", MAIN), ("lib/height.glsl", LIB), ("lib/value.glsl", value)]
}

fn compile(compiler: &ShaderCompiler, steps: u32) -> std::sync::Arc<Shader> {
    compiler.compile("render/main.frag", ShaderStage::Fragment, &[("STEPS", steps.to_string())]).unwrap()
}

#[test]
fn variants_are_cached_by_content() {
    let dir = TempDir::new("cache");
    let first = compiler(&dir, &files("#define VALUE 1.5"));
    let eight = compile(&first, 8);
    assert_ne!(eight.spirv, compile(&first, 9).spirv);
    assert_eq!(compile(&first, 8).spirv, eight.spirv);
    let stats = first.stats();
    assert_eq!((stats.hits, stats.misses), (0, 2));
    assert!(stats.compile_ms > 0.0);

    let second = compiler(&dir, &files("#define VALUE 1.5"));
    assert_eq!(compile(&second, 8).spirv, eight.spirv);
    assert_eq!((second.stats().hits, second.stats().misses), (1, 0));

    // Another include two levels down is another variant.
    let third = compiler(&dir, &files("#define VALUE 2.5"));
    assert_ne!(compile(&third, 8).spirv, eight.spirv);
    assert_eq!((third.stats().hits, third.stats().misses), (0, 1));

    for entry in std::fs::read_dir(dir.0.join("spirv")).unwrap() {
        let path = entry.unwrap().path();
        let mut bytes = std::fs::read(&path).unwrap();
        *bytes.last_mut().unwrap() ^= 1;
        std::fs::write(&path, bytes).unwrap();
    }
    let fourth = compiler(&dir, &files("#define VALUE 1.5"));
    assert_eq!(compile(&fourth, 8).spirv, eight.spirv);
    assert_eq!((fourth.stats().hits, fourth.stats().misses), (0, 1), "a damaged file is compiled again");
}

#[test]
fn a_cache_that_cannot_be_written_is_no_error() {
    let dir = TempDir::new("no-cache");
    let file = dir.0.join("a file, not a folder");
    std::fs::write(&file, "").unwrap();
    let mut compiler = ShaderCompiler::new(None, Some(&file)).unwrap();
    for (name, text) in files("#define VALUE 1.5") {
        compiler.provide(name, text.to_owned());
    }
    compile(&compiler, 8);
}

#[test]
fn shaders_are_read_from_a_folder() {
    let dir = TempDir::new("folder");
    for (name, text) in files("#define VALUE 1.5") {
        let path = dir.0.join("shaders").join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    }
    let from_folder = ShaderCompiler::new(Some(&dir.0.join("shaders")), Some(&dir.0)).unwrap();
    let provided = compiler(&TempDir::new("folder-twin"), &files("#define VALUE 1.5"));
    assert_eq!(compile(&from_folder, 8).spirv, compile(&provided, 8).spirv);
}

#[test]
fn reflection_names_bindings_members_and_outputs() {
    let dir = TempDir::new("reflect");
    let shader = compile(&compiler(&dir, &files("#define VALUE 1.5")), 8);
    let reflection = &shader.reflection;
    assert_eq!(reflection.stage, ShaderStage::Fragment);
    assert_eq!(reflection.outputs, [(0, "color".to_owned()), (1, "id".to_owned())]);
    let places: Vec<_> = reflection.bindings.iter().map(|b| (b.set, b.binding, b.name.as_str(), b.ty)).collect();
    assert_eq!(
        places,
        [(1, 2, "Frame", vk::DescriptorType::UNIFORM_BUFFER), (1, 3, "lights", vk::DescriptorType::STORAGE_BUFFER)]
    );
    let offset = |binding: usize, path: &str| {
        let members = &reflection.bindings[binding].members;
        members.iter().find(|m| m.path == path).map(|m| (m.offset, m.stride))
    };
    assert_eq!(offset(0, "eye"), Some((64, None)));
    assert_eq!(offset(0, "time"), Some((76, None)));
    assert_eq!(offset(1, "items"), Some((16, Some(16))));
    assert_eq!(offset(1, "items[].power"), Some((28, None)));
    assert_eq!(reflection.push_constant_size, 12);
    assert_eq!(reflection.push_constants[1].path, "id");
}

#[test]
fn an_error_names_file_and_line() {
    let dir = TempDir::new("error");
    let compiler = compiler(&dir, &files("#define VALUE 1.5"));
    let error = compiler.compile("render/main.frag", ShaderStage::Fragment, &[]).unwrap_err().to_string();
    assert!(error.contains("lib/height.glsl:2"), "STEPS is not defined there: {error}");
    let missing = self::compiler(&dir, &[("a.frag", "#version 460\n#include \"b.glsl\"\nvoid main() {}")]);
    let error = missing.compile("a.frag", ShaderStage::Fragment, &[]).unwrap_err().to_string();
    assert!(error.contains("a.frag") && error.contains("b.glsl"), "{error}");
    let error = missing.compile("no.frag", ShaderStage::Fragment, &[]).unwrap_err().to_string();
    assert!(error.contains("no.frag"), "{error}");
}
