//! Another engine's shaders, with bindings and names of its own, compile against `shaders/shell/` alone.

use std::{fs, path::Path};

use prism_engine::gpu::{ShaderCompiler, ShaderStage};

fn shell() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../shaders/shell")
}

/// Every file of the library, by its path in it.
fn files(folder: &Path, prefix: &str, found: &mut Vec<(String, String)>) {
    for entry in fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry")) {
        let name = format!("{prefix}{}", entry.file_name().to_string_lossy());
        if entry.path().is_dir() {
            files(&entry.path(), &format!("{name}/"), found);
        } else if name.ends_with(".glsl") {
            found.push((name, fs::read_to_string(entry.path()).expect("text")));
        }
    }
}

fn library() -> Vec<(String, String)> {
    let mut found = Vec::new();
    files(&shell(), "", &mut found);
    assert!(found.len() > 20, "{}", found.len());
    found
}

/// A compiler that has the library and nothing else of ours.
fn compiler(folder: &Path) -> ShaderCompiler {
    let mut compiler = ShaderCompiler::new(Some(folder), Some(folder)).expect("a compiler");
    for (name, text) in library() {
        compiler.provide(&format!("shell/{name}"), text);
    }
    compiler
}

fn compiles(compiler: &mut ShaderCompiler, name: &str, text: String, defines: &[(&str, String)]) {
    compiler.provide(name, text);
    compiler.compile(name, ShaderStage::Fragment, defines).unwrap_or_else(|error| panic!("{defines:?}: {error}"));
}

#[test]
fn the_library_binds_nothing_and_includes_itself_alone() {
    for (name, text) in library() {
        for (number, line) in (1..).zip(text.lines()) {
            let code = line.split("//").next().unwrap_or_default();
            assert!(!code.contains("layout("), "{name}:{number}: {line}");
            if let Some(included) = code.trim().strip_prefix("#include") {
                assert!(included.trim().starts_with("\"shell/"), "{name}:{number}: {line}");
            }
        }
    }
}

#[test]
fn the_readme_s_shader_compiles() {
    let readme = fs::read_to_string(shell().join("README.md")).expect("the page");
    let code = readme.split("```glsl").nth(1).and_then(|rest| rest.split("```").next()).expect("a shader");
    let folder = tempfile::tempdir().expect("a folder");
    compiles(&mut compiler(folder.path()), "theirs/rock.frag", code.trim_start().to_owned(), &[]);
    // And every file has its line in it.
    for (name, _) in library().iter().filter(|(name, _)| !name.contains('/') && name != "refine.glsl") {
        assert!(readme.contains(&format!("[{name}]")), "{name} is not in the README");
    }
}

/// The hook, in three ways.
const HOOK: &str = "
#if HOOK == 0
layout(set = 3, binding = 11) uniform sampler2D gravel;
layout(set = 3, binding = 12) uniform sampler2D gravel_cones;
#define HEIGHT_MAP gravel
#define CONE_MAP gravel_cones
vec2 height_size() { return vec2(textureSize(gravel, 0)); }
#include \"shell/height.glsl\"
vec2 height_bounds(ivec2 first, ivec2 last) { return vec2(0.0, 1.0); }
#ifdef MARCH_EXACT
#include \"shell/exact.glsl\"
#endif
#ifdef MARCH_CONE
#include \"shell/cone.glsl\"
#endif
#elif HOOK == 1
#define HEIGHT_PROCEDURE PROCEDURE_COBBLES
#include \"shell/procedures.glsl\"
#ifdef MARCH_EXACT
#include \"shell/exact_procedural.glsl\"
#endif
#else
float height_at(vec2 uv, float lod) { return 0.5 + 0.5 * sin(6.0 * uv.x) * cos(5.0 * uv.y); }
vec2 height_gradient(vec2 uv, float lod) {
    return 0.5 * vec2(6.0 * cos(6.0 * uv.x) * cos(5.0 * uv.y), -5.0 * sin(6.0 * uv.x) * sin(5.0 * uv.y));
}
vec2 height_size() { return vec2(64.0); }
#endif
#ifdef DITHERED_START
float search_start() { return fract(dot(gl_FragCoord.xy, vec2(0.7548, 0.5698))); }
#endif
";

/// A surface, and a shell out of buffers that are laid out as the engine likes.
const PLANE: &str = "
#include \"shell/plane.glsl\"
#include \"shell/normals.glsl\"
layout(location = 4) in vec4 theirs[4];
layout(location = 2) out vec4 painted;
void main() {
    vec3 up = normalize(theirs[1].xyz);
    mat3x2 frame = frame_jacobian(up, theirs[2], theirs[3].x);
    PlaneMarch march = PlaneMarch(0.1, 0.5, -0.05, 0.05, 4, 40, 5, 16, 0.01, theirs[3].y);
    PlaneHit hit = plane_trace(march, plane_ray(theirs[0].xy, frame, theirs[0].xyz, up, 1e-3));
    PlaneRay way = plane_ray(hit.uv, frame, up + theirs[2].xyz, up, 1e-3);
    float lit = plane_lit(march, hit, way, plane_steps(march, way.cosine));
    painted = vec4(shading_gradient(hit.uv, 0.0), hit.t, lit);
}
";

const SHELL: &str = "
#include \"shell/prism.glsl\"
#include \"shell/march.glsl\"
struct Cell { uvec4 word; vec4 span; vec4 across[3]; uvec4 beside; };
layout(std430, set = 1, binding = 20) readonly buffer Cells { Cell cells[]; };
layout(std430, set = 1, binding = 21) readonly buffer Points { vec4 points[]; };
uvec4 walk_corners(uint prism) { return cells[prism].word; }
vec4 walk_range(uint prism) { return cells[prism].span; }
uint walk_neighbour(uint prism, int wall) { return cells[prism].beside[wall]; }
vec4 walk_neighbour_uv(uint prism, int wall) { return cells[prism].across[wall]; }
vec2 walk_lids(uint vertex) { return points[3u * vertex + 2u].zw; }
float walk_growth(uint vertex) { return 1e-3; }
vec3 walk_position(uint vertex) { return points[3u * vertex].xyz; }
vec3 walk_shell(uint vertex) { return points[3u * vertex + 1u].xyz; }
vec2 walk_uv(uint vertex) { return points[3u * vertex + 2u].xy; }
#include \"shell/walk.glsl\"
#include \"shell/shadow.glsl\"
layout(push_constant) uniform Their { vec4 row[3]; };
layout(location = 9) flat in uvec2 named;
layout(location = 0) out vec4 painted;
void main() {
    MarchSettings settings;
    settings.scale = 0.1;
    settings.midlevel = 0.5;
    settings.min_steps = 4;
    settings.max_steps = 32;
    settings.refine_steps = 6;
    settings.tolerance = 0.01;
    settings.map_size = height_size();
    settings.two_sided = false;
    settings.step_limit = 16;
    WalkRay ray = pixel_ray(row[0], row[1], row[2], gl_FragCoord.xy, 1.0);
    Standing at = walk_stand(ray, named.x, 2);
    WalkStart start = walk_start(ray, 0.05, at);
    WalkTrail trail = NO_TRAIL;
    WalkHit hit = walk(ray, settings, at, start, 400, trail);
    int limits = 0;
    bool dark = shadow_blocked(ShadowStart(vec3(0.0), hit.prism, hit.lambda, hit.t, hit.wall, 1.0),
                               ShadowWay(vec3(0.0, 0.0, 1.0), 1e30), settings, 400, limits);
    painted = vec4(hit.lambda, dark ? 0.0 : hit.t);
}
";

#[test]
fn every_march_compiles_behind_foreign_hooks_and_bindings() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut compiler = compiler(folder.path());
    let on = |name: &'static str| (name, String::new());
    let marches: [&[(&str, String)]; 9] = [
        &[],
        &[on("MARCH_STEEP")],
        &[on("MARCH_RELIEF"), on("DITHERED_START")],
        &[on("MARCH_SECANT"), on("NORMALS_SOBEL")],
        &[on("MARCH_CONTACT"), on("NORMALS_4_TAP")],
        &[on("MARCH_OFFSET")],
        &[on("MARCH_CONE")],
        &[on("MARCH_CONE"), on("CONE_RELAXED")],
        &[on("MARCH_EXACT")],
    ];
    let mut compiled = 0;
    for march in marches {
        let is = |name: &str| march.iter().any(|(define, _)| *define == name);
        for hook in 0..3 {
            // The hook is the hook for all marches with steps. The exact one needs bounds, which a bare function has not.
            if hook > 0 && !march.is_empty() && !(hook == 1 && is("MARCH_EXACT")) {
                continue;
            }
            for (what, body) in [("plane", PLANE), ("shell", SHELL)] {
                // Offset limiting follows no ray.
                if what == "shell" && is("MARCH_OFFSET") {
                    continue;
                }
                let head = "#version 460\n#extension GL_GOOGLE_include_directive : require\n";
                let mut defines = march.to_vec();
                defines.push(("HOOK", hook.to_string()));
                compiles(&mut compiler, &format!("theirs/{what}.frag"), format!("{head}{HOOK}{body}"), &defines);
                compiled += 1;
            }
        }
    }
    assert_eq!(compiled, 23);
}
