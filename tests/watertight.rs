//! Watertight to the ray: millions of rays aimed at the shared walls and vertices of closed meshes, through the GLSL
//! itself, each hit exactly once.
//!
//! Under a constant height the surface is a convex polyhedron, and every ray comes near its middle: it has exactly one
//! front hit over all prisms. None is a miss, two are a double. A rugged height is so gentle, for rays so steep, that the
//! same holds; but a point on a wall that both its prisms report counts as one.

#[path = "rig/closed_mesh.rs"]
mod closed_mesh;
mod rig;

use std::{collections::HashMap, path::Path};

use closed_mesh::Mesh;
use glam::Vec3;
use prism_engine::{
    gpu::{
        Access, Binding, Buffer, BufferDesc, Context, ContextDesc, DescriptorSet, MemoryLocation, Pipeline,
        ShaderCompiler, ShaderStage, Uploader, run_once, vk,
    },
    render,
};
use rig::random::Random;

/// What the rays are aimed at and how they are made; the order of the shader's classes.
const TARGETS: [&str; 3] = ["wall", "mid-edge", "vertex"];
const VIEWS: [&str; 4] = ["pixel", "ray", "along", "axis"];
const CLASSES: usize = TARGETS.len() * VIEWS.len();
/// Misses and doubles that the shader writes down; its `LOGGED`.
const LOGGED: usize = 32;
/// Words of the shader's results before its log.
const COUNTS: usize = 3 * CLASSES + 5;
/// Rays of one dispatch, well under a second each.
const TILE: u32 = 1 << 16;
/// Invocations of a workgroup.
const GROUP: u32 = 64;

/// Level of the surface, and of the height's whole range, on a mesh of radius 1.
const LEVEL: f64 = 0.125;
const SCALE: f64 = 0.5;
/// Levels of a thick shell: its walls are long, and curved where the normals are tilted.
const THICK: [f64; 2] = [-0.2, 0.2];
/// Powers of two, so that a mesh of few bits keeps them.
const SIZES: [f64; 3] = [1.0 / 1024.0, 1.0, 1024.0];

/// How far a prism reaches beyond the levels of the surface in it.
#[derive(Clone, Copy, Debug)]
enum Range {
    /// As the engine has it: room for rounding.
    Padded,
    /// [`THICK`].
    Thick,
    /// Anything from the one to the other, each prism by itself.
    Mixed,
}

/// A search of the march and a height for it.
struct March {
    name: &'static str,
    defines: &'static [&'static str],
    /// Least and greatest level of the surface.
    levels: [f64; 2],
    /// How near to the middle rays pass, as a part of the inradius: the steeper the surface, the nearer.
    inner: f64,
}

/// Under a constant height.
const CONVEX: [March; 3] = [
    March { name: "pom", defines: &[], levels: [LEVEL; 2], inner: 0.95 },
    March { name: "relief", defines: &["MARCH_RELIEF"], levels: [LEVEL; 2], inner: 0.95 },
    March { name: "exact", defines: &["MARCH_EXACT"], levels: [LEVEL; 2], inner: 0.95 },
];

/// The same by the walk from prism to prism; and a rugged height.
const WALKED: [March; 2] = [
    March { name: "walk", defines: &["WALK", "MARCH_EXACT"], levels: [LEVEL; 2], inner: 0.95 },
    March { name: "walk, rugged", defines: &["WALK", "MARCH_EXACT", "RUGGED"], levels: [0.1, 0.15], inner: 0.25 },
];

const RUGGED: [March; 1] =
    [March { name: "exact, rugged", defines: &["MARCH_EXACT", "RUGGED"], levels: [0.1, 0.15], inner: 0.25 }];

/// What became of some rays.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
struct Tally {
    /// By class.
    rays: [u64; CLASSES],
    misses: [u64; CLASSES],
    doubles: [u64; CLASSES],
    /// Hits off the surface, loops that gave up, and rays with more prisms on their way than the shader has room for.
    astray: u64,
    limits: u64,
    overflow: u64,
    /// Rays of a rugged surface with a hit that two prisms report at one point: counted as one.
    twice: u64,
    /// The first misses and doubles, each with all that makes it anew.
    bad: Vec<String>,
}

impl Tally {
    fn add(&mut self, words: &[u32], set: &str) {
        for class in 0..CLASSES {
            self.rays[class] += u64::from(words[class]);
            self.misses[class] += u64::from(words[CLASSES + class]);
            self.doubles[class] += u64::from(words[2 * CLASSES + class]);
        }
        self.astray += u64::from(words[3 * CLASSES]);
        self.limits += u64::from(words[3 * CLASSES + 1]);
        self.overflow += u64::from(words[3 * CLASSES + 2]);
        self.twice += u64::from(words[3 * CLASSES + 3]);
        let logged = (words[COUNTS - 1] as usize).min(LOGGED);
        self.bad.extend(words[COUNTS..].chunks_exact(2).take(logged).map(|entry| {
            let class = entry[0] as usize % CLASSES;
            let (target, view) = (TARGETS[class / VIEWS.len()], VIEWS[class % VIEWS.len()]);
            format!("{set}: ray {}, {target} by {view}: {} hits", entry[0], entry[1])
        }));
    }

    fn traced(&self) -> u64 {
        self.rays.iter().sum()
    }

    fn wrong(&self) -> [u64; 2] {
        [self.misses.iter().sum(), self.doubles.iter().sum()]
    }

    fn table(&self) -> String {
        let rows = (0..CLASSES).map(|class| {
            let (target, view) = (TARGETS[class / VIEWS.len()], VIEWS[class % VIEWS.len()]);
            let [rays, misses, doubles] = [self.rays[class], self.misses[class], self.doubles[class]];
            format!("| {target} | {view} | {rays} | {misses} | {doubles} |\n")
        });
        let [misses, doubles] = self.wrong();
        format!(
            "| aimed at | by | rays | misses | doubles |\n|---|---|---|---|---|\n{}| all | | {} | {misses} | {doubles} |",
            rows.collect::<String>(),
            self.traced()
        )
    }
}

/// Traces rays on a device.
struct Tracer {
    compiler: ShaderCompiler,
    ctx: Context,
}

/// Some rays of one mesh under one march.
struct Run<'a> {
    mesh: &'a Mesh,
    march: &'a March,
    size: f64,
    range: Range,
    /// Whether prisms evaluate walls in canonical order, as they should, or each in its own.
    canonical: bool,
    seed: u32,
    rays: u32,
}

impl Tracer {
    fn new() -> Tracer {
        let ctx = Context::new(&ContextDesc { app: "prism tests", ..ContextDesc::default() }).expect("a device");
        let mut compiler = render::shader_compiler(rig::shader_folder().as_deref()).expect("a compiler");
        compiler.provide("tests/watertight.comp", include_str!("rig/watertight.comp").to_owned());
        compiler.provide("tests/watertight_walk.glsl", include_str!("rig/watertight_walk.glsl").to_owned());
        Tracer { compiler, ctx }
    }

    /// As if a driver contracted cross products: one product of the two is rounded otherwise than the other.
    fn contracted() -> Tracer {
        const CROSS: &str = "a.x * b.y - a.y * b.x";
        let mut tracer = Tracer::new();
        let folder = rig::shader_folder().unwrap_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../shaders"));
        let text = std::fs::read_to_string(folder.join("shell/prism.glsl")).expect("the shader");
        assert_eq!(text.matches(CROSS).count(), 1, "prism.glsl writes cross2 otherwise now");
        // 1 + 2^-23, the next number after 1.
        let text = text.replace(CROSS, "(a.x * b.y) * 1.00000012 - a.y * b.x");
        tracer.compiler.provide("shell/prism.glsl", text);
        tracer
    }

    fn pipeline(&self, march: &March) -> Pipeline {
        let defines: Vec<_> = march.defines.iter().map(|name| (*name, String::new())).collect();
        let shader = self.compiler.compile("tests/watertight.comp", ShaderStage::Compute, &defines);
        let shader = shader.unwrap_or_else(|error| panic!("{error}"));
        Pipeline::compute(&self.ctx, march.name, &shader).expect("a pipeline")
    }

    fn trace(&self, pipeline: &Pipeline, run: &Run<'_>, tally: &mut Tally) {
        let scene = Buffers::new(&self.ctx, run);
        let results = Buffer::new(
            &self.ctx,
            &BufferDesc {
                name: "results",
                size: 4 * (COUNTS + 2 * LOGGED) as u64,
                usage: vk::BufferUsageFlags::STORAGE_BUFFER | vk::BufferUsageFlags::TRANSFER_DST,
                location: MemoryLocation::GpuToCpu,
            },
        )
        .expect("a buffer");
        let bindings = [
            ("corners", Binding::Buffer(&scene.corners)),
            ("prisms", Binding::Buffer(&scene.prisms)),
            ("edges", Binding::Buffer(&scene.edges)),
            ("results", Binding::Buffer(&results)),
            ("adjacency", Binding::Buffer(&scene.adjacency)),
            ("lids", Binding::Buffer(&scene.lids)),
        ];
        // The last two are the walk's.
        let set = DescriptorSet::with_optional(&self.ctx, pipeline, 0, &bindings[..4], &bindings[4..]).expect("a set");
        let size = run.size as f32;
        let aimed = THICK.map(|level| level as f32 * size);
        for first in (0..run.rays).step_by(TILE as usize) {
            let end = run.rays.min(first + TILE);
            run_once(&self.ctx, |cmd| {
                if first == 0 {
                    cmd.fill_buffer(&results, 0);
                    cmd.buffer_barrier(&results, Access::TRANSFER_DST, Access::COMPUTE_WRITE);
                }
                cmd.bind_pipeline(pipeline);
                cmd.bind_set(pipeline, 0, &set);
                let [corners, prisms, edges] = scene.counts;
                let inner = (run.march.inner * run.mesh.inradius()) as f32 * size;
                let reals = [size, inner, SCALE as f32 * size, aimed[0], aimed[1], MAP_SIZE].map(f32::to_bits);
                let mut block = [first, end, run.seed, corners, prisms, edges, 0, 0, 0, 0, 0, 0];
                block[6..].copy_from_slice(&reals);
                cmd.push(pipeline, &block);
                cmd.dispatch((end - first).div_ceil(GROUP), 1, 1);
                cmd.buffer_barrier(&results, Access::COMPUTE_WRITE, Access::COMPUTE_WRITE);
                cmd.buffer_barrier(&results, Access::COMPUTE_WRITE, Access::HOST_READ);
                Ok(())
            })
            .expect("traced");
        }
        self.ctx.check_validation().unwrap_or_else(|error| panic!("{error}"));
        let name = format!("{}, {}, size {}, {:?}, seed {}", run.mesh.name, run.march.name, size, run.range, run.seed);
        tally.add(&results.read::<u32>().expect("the results"), &name);
    }

    /// So many rays, spread over every march, mesh, size and range.
    fn all(&self, marches: &[March], rays: u32, canonical: bool) -> Tally {
        let mut tally = Tally::default();
        let meshes = [Mesh::tilted(), Mesh::exact()];
        let ranges = [Range::Padded, Range::Thick, Range::Mixed];
        let sets = (meshes.len() * marches.len() * SIZES.len() * ranges.len()) as u64;
        let mut set = 0;
        for march in marches {
            let pipeline = self.pipeline(march);
            for mesh in &meshes {
                for (size, range) in SIZES.into_iter().flat_map(|size| ranges.map(|range| (size, range))) {
                    let until = |set: u64| (u64::from(rays) * set / sets) as u32;
                    let rays = until(set + 1) - until(set);
                    let run = Run { mesh, march, size, range, canonical, seed: set as u32, rays };
                    self.trace(&pipeline, &run, &mut tally);
                    set += 1;
                }
            }
        }
        tally
    }
}

/// Texels of the rugged map along the mesh.
const MAP_SIZE: f32 = 12.0;

/// A mesh on the device, as the shader declares it.
struct Buffers {
    corners: Buffer,
    prisms: Buffer,
    edges: Buffer,
    adjacency: Buffer,
    lids: Buffer,
    counts: [u32; 3],
}

impl Buffers {
    fn new(ctx: &Context, run: &Run<'_>) -> Buffers {
        let Mesh { surface, normals, triangles, .. } = run.mesh;
        let place = |v: u32, level: f64| (run.size * run.mesh.at(v, level)).as_vec3();
        let corners: Vec<[[f32; 4]; 2]> = (0..surface.len() as u32)
            .map(|v| {
                // Planar, so continuous over the closed mesh.
                let uv = 0.5 * surface[v as usize].truncate().as_vec2() + 0.5;
                let normal = normals[v as usize].as_vec3();
                [place(v, 0.0).extend(uv.x).to_array(), normal.extend(uv.y).to_array()]
            })
            .collect();
        let mut random = Random(run.seed.into());
        let ranges: Vec<[f64; 2]> = triangles
            .iter()
            .map(|_| {
                let [low, high] = run.march.levels;
                let room = 1e-4 * SCALE + 1e-5 * high;
                let (below, above) = (low - room - THICK[0], THICK[1] - high - room);
                let [down, up] = match run.range {
                    Range::Padded => [0.0; 2],
                    Range::Thick => [1.0; 2],
                    Range::Mixed => [random.next(), random.next()],
                };
                [low - room - down * below, high + room + up * above]
            })
            .collect();
        let wider = |a: [f64; 2], b: &[f64; 2]| [a[0].min(b[0]), a[1].max(b[1])];
        let mut lids = vec![[f64::INFINITY, f64::NEG_INFINITY]; surface.len()];
        for (triangle, range) in triangles.iter().zip(&ranges) {
            triangle.iter().for_each(|v| lids[*v as usize] = wider(lids[*v as usize], range));
        }
        let prisms: Vec<[[u32; 4]; 3]> = triangles
            .iter()
            .zip(&ranges)
            .map(|(triangle, &range)| {
                let reach = triangle.map(|v| lids[v as usize]).iter().fold(range, wider);
                let corners = reach.map(|level| triangle.map(|v| place(v, level)));
                let middle = corners.as_flattened().iter().sum::<Vec3>() / 6.0;
                let radius = corners.as_flattened().iter().map(|c| c.distance(middle)).fold(0.0, f32::max);
                let descends = |k: usize| u32::from(run.canonical && triangle[(k + 1) % 3] > triangle[(k + 2) % 3]);
                let [a, b, c] = *triangle;
                let levels = [range[0], range[1], reach[0], reach[1]].map(|level| (run.size * level) as f32);
                [
                    [a, b, c, descends(0) | descends(1) << 1 | descends(2) << 2],
                    levels.map(f32::to_bits),
                    middle.extend(radius).to_array().map(f32::to_bits),
                ]
            })
            .collect();
        let edges = run.mesh.edges();
        let sides = |t: usize| (0..3).map(move |k| (triangles[t][(k + 1) % 3], triangles[t][(k + 2) % 3], 4 * t + k));
        let owners: HashMap<[u32; 2], u32> =
            (0..triangles.len()).flat_map(sides).map(|(a, b, side)| ([a, b], side as u32)).collect();
        let adjacency: Vec<u32> = (0..triangles.len()).flat_map(sides).map(|(a, b, _)| owners[&[b, a]]).collect();
        let lids: Vec<[f32; 2]> = lids.iter().map(|lid| lid.map(|level| (run.size * level) as f32)).collect();
        let mut uploader = Uploader::new(ctx).expect("an uploader");
        let usage = vk::BufferUsageFlags::STORAGE_BUFFER;
        let buffers = Buffers {
            corners: uploader.buffer("corners", usage, &corners).expect("a buffer"),
            prisms: uploader.buffer("prisms", usage, &prisms).expect("a buffer"),
            edges: uploader.buffer("edges", usage, &edges).expect("a buffer"),
            adjacency: uploader.buffer("adjacency", usage, &adjacency).expect("a buffer"),
            lids: uploader.buffer("lids", usage, &lids).expect("a buffer"),
            counts: [corners.len(), prisms.len(), edges.len()].map(|n| n as u32),
        };
        uploader.finish().expect("uploaded");
        buffers
    }
}

/// Insists that every ray is hit, and none twice.
#[track_caller]
fn hit_once(marches: &[March], rays: u32) {
    let tally = Tracer::new().all(marches, rays, true);
    println!("{}\n{} hits on walls were reported by both prisms", tally.table(), tally.twice);
    assert_eq!(tally.traced(), u64::from(rays), "every ray is traced");
    assert!(tally.rays.iter().all(|n| n * 2 > u64::from(rays) / CLASSES as u64), "every class has its share");
    let shown = tally.bad.iter().take(20).cloned().collect::<Vec<_>>().join("\n");
    assert_eq!(tally.wrong(), [0, 0], "misses and doubles\n{}\n{shown}", tally.table());
    assert_eq!([tally.astray, tally.limits, tally.overflow], [0; 3], "astray, limits reached, no room");
}

#[test]
fn a_million_rays_are_hit_once() {
    hit_once(&CONVEX, 1_000_000);
}

/// Axes run through walls at the very level of the surface, on the far side of the mesh too, where rays leave: what
/// rounds their way up for its end must not find a way down in it.
#[test]
fn a_million_rays_at_a_rugged_surface_are_hit_once() {
    hit_once(&RUGGED, 1_000_000);
}

/// Each ray from the lids that a raster might show it, or from a neighbour of one.
#[test]
fn a_million_rays_walk_to_their_hit() {
    hit_once(&WALKED, 1_000_000);
}

#[test]
#[ignore = "takes minutes: tests/run figures"]
fn ten_million_rays_walk_to_their_hit() {
    hit_once(&WALKED, 10_000_000);
}

#[test]
#[ignore = "takes minutes: tests/run figures"]
fn ten_million_rays_are_hit_once() {
    hit_once(&CONVEX, 10_000_000);
}

/// The test can tell. Were cross products contracted, a wall would look different from its two prisms, and rays would slip
/// through; unless both evaluate it in canonical order.
#[test]
fn the_canonical_order_is_what_keeps_contracted_walls_shut() {
    let tracer = Tracer::contracted();
    let walls = |tally: &Tally| {
        let sum = |counts: &[u64; CLASSES]| counts[..2 * VIEWS.len()].iter().sum::<u64>();
        [sum(&tally.misses), sum(&tally.doubles)]
    };
    let [own, canonical] = [false, true].map(|canonical| {
        let tally = tracer.all(&CONVEX, 200_000, canonical);
        println!("canonical order: {canonical}\n{}", tally.table());
        assert_eq!(tally.traced(), 200_000);
        walls(&tally)
    });
    assert!(own.iter().all(|n| *n > 0), "misses and doubles at walls in each prism's own order: {own:?}");
    assert_eq!(canonical, [0, 0], "misses and doubles at walls in canonical order");
}
