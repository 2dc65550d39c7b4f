//! Prisms that no pixel can show are dropped before the stage that makes them, and the frame is the same to the bit. How
//! many each test drops is held between two counts made here in f64.

mod rig;

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use prism_engine::{
    aov::Aov,
    gpu::Feature,
    render::{
        culling::Counts,
        plan::{self, PlannedPrimitive},
    },
    scene::{Camera, Projection, Scene},
    settings::{March, PrismCulling, Settings, Shell, Stage},
    shell::reference::Reference,
};
use rig::{Rig, random::Random, same_bits};

const EXTENT: [u32; 2] = [96, 54];

/// Scenes with shells of all kinds: closed and open, with seams, borders, folds and steps.
const SHELLS: [&str; 7] =
    ["torus", "cube", "suzanne", "cloth", "stability_seams", "stability_slivers", "stability_needles"];

/// Pixels that tests may keep prisms within, of where they would be dropped.
const ROOM: f64 = 2.5;

fn able() -> Rig {
    use Feature as F;
    Rig::asking(&[F::TaskShader, F::MeshShader, F::GeometryShader, F::FragmentStoresAndAtomics])
}

fn settings(shell: Shell, stage: Stage, prism_culling: PrismCulling) -> Settings {
    Settings { shell, stage, prism_culling, march: March::Relief, count_limits: true, ..Settings::default() }
}

/// The torus from all around, from near, with most of it behind the eye, and from between its lids and bases.
fn cameras(scene: &Scene) -> Vec<Camera> {
    let around = |angle: f64, distance: f64, height: f64| {
        let at = DVec3::new(distance * angle.cos(), height, distance * angle.sin());
        Camera::look_at(at, DVec3::ZERO, 40.0).expect("an eye away from its target")
    };
    let ring = scene.instances[0].transform.transform_point3(DVec3::from(scene.meshes[0].primitives[0].positions[0]));
    vec![
        around(0.1 * TAU, 3.0, 1.2),
        around(0.35 * TAU, 2.6, 0.1),
        around(0.6 * TAU, 1.3, 0.3),
        Camera::look_at(1.01 * ring, 1.01 * ring + DVec3::new(0.3, 0.2, -1.0), 50.0).expect("two points"),
    ]
}

/// What a point is on screen, in pixels, and its view depth.
fn project(camera: &Camera, at: DVec3) -> (DVec2, f64) {
    let Projection::Perspective { fov_y, .. } = camera.projection else { panic!("a perspective") };
    let seen = camera.transform.inverse().transform_point3(at);
    let focal = 0.5 * f64::from(EXTENT[1]) / (0.5 * fov_y).tan();
    let middle = DVec2::new(f64::from(EXTENT[0]), f64::from(EXTENT[1])) / 2.0;
    (middle + focal * DVec2::new(seen.x, -seen.y) / -seen.z, -seen.z)
}

/// The corners of a prism at two levels of its vertices, world.
fn hull(scene: &Scene, planned: &PlannedPrimitive, prism: usize, levels: [[f64; 2]; 3]) -> [[DVec3; 2]; 3] {
    let primitive = plan::source(scene, planned);
    let corners = planned.shell.prisms[prism].corners;
    std::array::from_fn(|k| {
        let v = corners[k] as usize;
        let at = |t: f64| DVec3::from(primitive.positions[v]) + t * DVec3::from(planned.shell_normals[v]);
        levels[k].map(|t| scene.instances[0].transform.transform_point3(at(t)))
    })
}

/// Whether all points lie `pixels` or more beyond one side of the picture, and before the near plane none.
fn is_outside(camera: &Camera, points: &[DVec3], pixels: f64) -> bool {
    let Projection::Perspective { fov_y, near, .. } = camera.projection else { panic!("a perspective") };
    let half = [0, 1].map(|axis| 0.5 * f64::from(EXTENT[axis]) + pixels);
    let focal = 0.5 * f64::from(EXTENT[1]) / (0.5 * fov_y).tan();
    let seen: Vec<_> = points.iter().map(|p| camera.transform.inverse().transform_point3(*p)).collect();
    let beyond = |side: &dyn Fn(DVec3) -> f64| seen.iter().all(|p| side(*p) > 0.0);
    [1.0, -1.0]
        .iter()
        .any(|sign| beyond(&|p| sign * focal * p.x + half[0] * p.z) || beyond(&|p| sign * focal * p.y + half[1] * p.z))
        || beyond(&|p| p.z + near)
}

/// How many prisms a test may drop, and how many it must.
#[derive(Debug, Default)]
struct Bracket {
    most: u32,
    least: u32,
}

impl Bracket {
    fn add(&mut self, may: bool, must: bool) {
        self.most += u32::from(may);
        self.least += u32::from(must);
    }

    #[track_caller]
    fn holds(&self, count: u32, of: &str) {
        println!("{of}: {count}, of {} to {}", self.least, self.most);
        assert!((self.least..=self.most).contains(&count), "{of}: {count}, and {self:?}");
    }
}

/// Lids without bases over a closed shell: those outside, and of the others those that face away.
fn lids(scene: &Scene, planned: &PlannedPrimitive, camera: &Camera) -> [Bracket; 2] {
    let walk = planned.walk.as_ref().expect("a walk");
    let mut brackets = [Bracket::default(), Bracket::default()];
    for prism in 0..planned.shell.prisms.len() {
        let levels = planned.shell.prisms[prism].corners.map(|v| [walk.lids[v as usize][1]; 2]);
        let lid = hull(scene, planned, prism, levels).map(|[lid, _]| lid);
        brackets[0].add(is_outside(camera, &lid, 0.0), is_outside(camera, &lid, ROOM));
        let [a, b, c] = lid.map(|p| project(camera, p));
        let area = (b.0 - a.0).perp_dot(c.0 - a.0);
        let size = (a.0.max(b.0).max(c.0) - a.0.min(b.0).min(c.0)).element_sum();
        let ahead = [a, b, c].iter().all(|p| p.1 > 0.1);
        let outside = is_outside(camera, &lid, ROOM);
        // On screen y grows downwards: what is counter-clockwise seen from the eye has a negative area.
        let may = ahead && area > 0.0 && !outside;
        brackets[1].add(may, may && area > 0.125 * size && !is_outside(camera, &lid, 0.0));
    }
    brackets
}

/// Outlines: those outside.
fn outlines(scene: &Scene, planned: &PlannedPrimitive, camera: &Camera) -> Bracket {
    let mut bracket = Bracket::default();
    for (index, prism) in planned.shell.prisms.iter().enumerate() {
        let hull = hull(scene, planned, index, [prism.range; 3]);
        let points = hull.as_flattened();
        bracket.add(is_outside(camera, points, 0.0), is_outside(camera, points, ROOM));
    }
    bracket
}

#[test]
fn the_frame_is_the_same_and_only_what_no_pixel_shows_is_dropped() {
    let rig = able();
    let scene = rig::asset("torus.gltf").with_defaults(16.0 / 9.0);
    for (shell, stage) in rig::SHELLS.into_iter().flat_map(|shell| rig::STAGES.map(|stage| (shell, stage))) {
        let easel = |culling| rig.easel(&scene, &settings(shell, stage, culling), EXTENT);
        let (mut all, mut hidden) = (easel(PrismCulling::Off), easel(PrismCulling::Hidden));
        // The tests are the same, without depth; one of each kind of shell and stage is enough.
        let mut view = ((shell == Shell::Walk) == (stage == Stage::Mesh)).then(|| easel(PrismCulling::View));
        for (number, camera) in cameras(&scene).iter().enumerate() {
            let of = format!("{shell} {stage}, camera {number}");
            let whole = all.draw(camera);
            assert!(whole.depth.iter().filter(|z| z.is_finite()).count() > 400, "{of} shows next to nothing");
            // The first frame goes by what another camera saw, the second by this one's own.
            for frame in 0..2 {
                assert!(same_bits(&whole, &hidden.draw(camera)), "{of}: the hidden, frame {frame}");
            }
            let counts = hidden.culled();
            println!("{of}: {counts:?}");
            let Counts { shown, outside, away, hidden } = counts;

            let planned = &all.plan().primitives[0];
            let prisms = planned.shell.prisms.len() as u32;
            // Where the near plane may cut the shell, what it may cut is drawn as borders too, and bases.
            let cut = shell == Shell::Walk && number >= 2;
            assert_eq!(shown + outside + away + hidden > prisms, cut, "{of}");
            if let Some(view) = &mut view {
                assert!(same_bits(&whole, &view.draw(camera)), "{of}: outside the view");
                assert_eq!((view.culled().outside, view.culled().hidden), (outside, 0), "{of}");
            }
            if shell == Shell::Prism {
                outlines(&scene, planned, camera).holds(outside, &format!("{of}, outside"));
            } else if !cut {
                let [out, back] = lids(&scene, planned, camera);
                out.holds(outside, &format!("{of}, outside"));
                back.holds(away, &format!("{of}, away"));
            }
            // Much is dropped where much is not seen: half of the ring lies behind the other, or most of it behind the eye.
            let least = [prisms / 4, prisms / 2, prisms / 2, 9 * prisms / 10][number];
            assert!(outside + away + hidden > least, "{of}: {counts:?}");
        }
    }
}

/// Whether each pixel shows the same point, to rounding.
fn same_points(a: &Aov, b: &Aov) -> bool {
    (0..a.depth.len()).all(|i| {
        let near = |a: &[f32], b: &[f32], most: f32| a.iter().zip(b).all(|(a, b)| (a - b).abs() <= most);
        let depth = a.depth[i] == b.depth[i] || (a.depth[i] / b.depth[i] - 1.0).abs() < 1e-6;
        depth && near(&a.normal[i], &b.normal[i], 1e-4) && near(&a.uv[i], &b.uv[i], 1e-5)
    })
}

/// The frame around shells of all kinds, from many eyes, one after the other: each goes by what the last one saw.
#[test]
#[ignore = "some minutes; tests/run figures"]
fn the_frame_is_the_same_in_every_scene() {
    let rig = able();
    let mut random = Random(5);
    for name in SHELLS {
        let scene = rig::asset(&format!("{name}.gltf")).with_defaults(16.0 / 9.0);
        let (low, high) = scene.bounds().expect("a scene");
        let (middle, radius) = (low.midpoint(high), 0.5 * low.distance(high));
        for (shell, stage) in rig::SHELLS.into_iter().flat_map(|shell| rig::STAGES.map(|stage| (shell, stage))) {
            let easel = |culling| rig.easel(&scene, &settings(shell, stage, culling), EXTENT);
            let (mut all, mut hidden) = (easel(PrismCulling::Off), easel(PrismCulling::Hidden));
            let (mut dropped, mut unlike) = (0, 0);
            for eye in 0..24 {
                let at = middle + (0.6 + 1.5 * random.next()) * radius * random.in_ball().normalize_or(DVec3::X);
                let camera = Camera::look_at(at, middle + 0.5 * radius * random.in_ball(), 40.0).expect("two points");
                let (whole, culled) = (all.draw(&camera), hidden.draw(&camera));
                // Where Suzanne's shell overlaps itself two lids may meet the same point, and another one is left of them.
                assert!(same_points(&whole, &culled), "{name}, {shell} {stage}, eye {eye} at {at}");
                unlike += u32::from(!same_bits(&whole, &culled));
                dropped += hidden.culled().hidden;
            }
            println!("{name}, {shell} {stage}: {dropped} hidden, {unlike} frames not to the bit");
            assert!(unlike == 0 || (name == "suzanne" && shell == Shell::Walk), "{name}, {shell} {stage}: {unlike}");
        }
    }
}

/// Where a ray meets a triangle: in lengths of `direction`, and whether it sees its front.
fn crossing(origin: DVec3, direction: DVec3, [a, b, c]: [DVec3; 3]) -> Option<(f64, bool)> {
    let (p, q) = (direction.cross(c - a), origin - a);
    let volume = (b - a).dot(p);
    let (u, v) = (q.dot(p) / volume, direction.dot(q.cross(b - a)) / volume);
    let inside = volume != 0.0 && u >= -1e-12 && v >= -1e-12 && u + v <= 1.0 + 1e-12;
    inside.then(|| ((c - a).dot(q.cross(b - a)) / volume, volume > 0.0))
}

/// Where a ray enters the hull of some points: it does through a triangle of three of them.
fn entry(origin: DVec3, direction: DVec3, points: &[DVec3]) -> Option<f64> {
    let n = points.len();
    let triples = (0..n).flat_map(|i| (i + 1..n).flat_map(move |j| (j + 1..n).map(move |k| [i, j, k])));
    let crossings = triples.filter_map(|ids| Some(crossing(origin, direction, ids.map(|i| points[i]))?.0));
    crossings.filter(|distance| *distance > 0.0).reduce(f64::min)
}

/// What a walk draws: lids and bases as triangles, borders as the hulls of their corners, world.
struct Walked {
    triangles: Vec<[DVec3; 3]>,
    hulls: Vec<[DVec3; 6]>,
}

impl Walked {
    fn new(scene: &Scene, planned: &PlannedPrimitive) -> Walked {
        let walk = planned.walk.as_ref().expect("a walk");
        let mut walked = Walked { triangles: Vec::new(), hulls: Vec::new() };
        for (index, prism) in planned.shell.prisms.iter().enumerate() {
            if walk.is_border(index) {
                let corners = hull(scene, planned, index, [walk.reach[index]; 3]);
                walked.hulls.push(std::array::from_fn(|i| corners[i / 2][i % 2]));
            }
            if !prism.plain {
                let corners = hull(scene, planned, index, prism.corners.map(|v| walk.lids[v as usize]));
                walked.triangles.push(corners.map(|[_, lid]| lid));
                let [a, b, c] = corners.map(|[base, _]| base);
                walked.triangles.extend(walk.is_open().then_some([a, c, b]));
            }
        }
        walked
    }

    /// Where a ray first meets something of it.
    fn met(&self, origin: DVec3, direction: DVec3) -> f64 {
        let front = |triangle: &[DVec3; 3]| {
            crossing(origin, direction, *triangle).filter(|(distance, front)| *front && *distance > 0.0)
        };
        let triangles = self.triangles.iter().filter_map(front).map(|(distance, _)| distance);
        let hulls = self.hulls.iter().filter_map(|points| entry(origin, direction, points));
        triangles.chain(hulls).fold(f64::INFINITY, f64::min)
    }
}

/// A prism is hidden once the nearest corner of what is drawn of it, and so all of that, lies behind other depth: no pixel
/// can show anything found from there. For that, whatever a ray hits must lie behind the lid, base or border where it came
/// into the shell, which is drawn at the same pixel. So it is, in f64, around shells of all kinds.
#[test]
fn what_is_hit_lies_behind_what_is_drawn_of_its_shell() {
    let mut random = Random(11);
    let (mut rays, mut hits) = (0, 0);
    for name in SHELLS {
        let scene = rig::asset(&format!("{name}.gltf"));
        let plan = plan::plan(&scene, &settings(Shell::Walk, Stage::Mesh, PrismCulling::Off), Stage::Mesh, false);
        let reference = Reference::new(&scene);
        let shells = plan.primitives.iter().filter(|planned| planned.walk.is_some());
        let shells: Vec<_> = shells.map(|planned| (planned, Walked::new(&scene, planned))).collect();
        let (low, high) = scene.bounds().expect("a scene");
        let (middle, radius) = (low.midpoint(high), 0.5 * low.distance(high));
        for _ in 0..1500 {
            let eye = middle + (1.5 + random.next()) * radius * random.in_ball().normalize_or(DVec3::X);
            let direction = (middle + 0.8 * radius * random.in_ball() - eye).normalize();
            rays += 1;
            let Some(hit) = reference.trace(eye, direction, 0.0) else { continue };
            let of = |planned: &PlannedPrimitive| planned.primitive == hit.primitive;
            let Some((_, walked)) = shells.iter().find(|(planned, _)| of(planned)) else { continue };
            hits += 1;
            let met = walked.met(eye, direction);
            assert!(met <= hit.distance + 1e-9 * radius, "{name}: met at {met}, and hit at {}", hit.distance);
        }
    }
    println!("{hits} hits of {rays} rays");
    assert!(hits > rays / 4, "{hits} of {rays}");
}

/// What cannot be honoured is refused, and what needs nothing of it has none.
#[test]
fn culling_is_planned_where_it_can_be() {
    let torus = rig::asset("torus.gltf");
    let refused = |settings: Settings| plan::check(&torus, &settings).expect_err("refused").exit_code();
    let view = settings(Shell::Walk, Stage::Mesh, PrismCulling::View);
    let hidden = Settings { prism_culling: PrismCulling::Hidden, ..view.clone() };
    assert_eq!(refused(Settings { shell: Shell::Off, march: March::Pom, ..view.clone() }), 2);
    assert_eq!(refused(Settings { keep_all: true, ..view.clone() }), 2);
    assert_eq!(refused(Settings { msaa: 4, ..hidden.clone() }), 2);
    assert!(plan::check(&torus, &Settings { msaa: 4, ..view.clone() }).is_ok());
    for stage in rig::STAGES {
        let auto = Settings { prism_culling: PrismCulling::Auto, ..view.clone() };
        for (settings, culled) in [(&auto, false), (&view, true), (&hidden, true)] {
            let plan = plan::plan(&torus, settings, stage, false);
            for draw in &plan.draws {
                assert_eq!(draw.variant.cull.is_some(), culled, "{stage}: {}", settings.prism_culling);
                assert_eq!(draw.cull.is_some(), culled && stage == Stage::Geometry);
                assert_eq!(draw.hides(), settings.prism_culling == PrismCulling::Hidden);
            }
            let decision = plan.ledger.find("torus.0", "culling").expect("a decision");
            assert!(decision.kept == culled && !decision.why.is_empty());
        }
    }
}
