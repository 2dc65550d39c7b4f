//! Shadow maps against closed forms, and against the f64 reference, which sends a ray toward the light from every hit.

mod rig;

use std::fs;

use glam::{DAffine2, DAffine3, DMat3, DVec2, DVec3, Vec3};
use image::RgbImage;
use prism_engine::{
    aov::Aov,
    render::variant::Pass,
    scene::{
        Ambient, Camera, ColorImage, Displacement, HeightMap, HeightSource, HeightTexels, Instance, Light, LightKind,
        Material, Projection, Sampler, Scene, TextureRef, Wrap,
    },
    settings::{March, Settings, Shell, Stage},
    shell::reference::{Reference, Shadows},
};
use rig::{Rig, SHELLS, STAGES, exactness::SCENES, lights::difference, record, square::square};

const EXTENT: [u32; 2] = [160, 90];

fn mapped(shell: Shell, stage: Stage, size: u32, cascades: u32) -> Settings {
    Settings { shadow_map: true, shadow_map_size: size, cascades, ..rig::exact(shell, stage) }
}

/// The level at which the displaced sheet of [`sheet_over_floor`] stands.
const TOP: f64 = 1.4;
/// Half its side.
const HALF: f64 = 0.5;

/// A plain floor at y = 0, and over it a sheet whose map lifts it from y = 1 to [`TOP`].
fn sheet_over_floor(light: Light) -> Scene {
    let displacement = Displacement {
        source: HeightSource::Map(0),
        wrap: [Wrap::Repeat; 2],
        tex_coord: 0,
        transform: DAffine2::IDENTITY,
        scale: 0.8,
        relative: false,
        midlevel: 0.5,
        border_wall: false,
    };
    let lifted = Material { name: "lifted".into(), displacement: Some(displacement), ..Material::default() };
    let instance = |mesh: usize, y: f64| Instance {
        name: format!("instance {mesh}"),
        mesh,
        transform: DAffine3::from_translation(DVec3::new(0.0, y, 0.0)),
    };
    Scene {
        file: "sheet over floor".into(),
        meshes: vec![square(3.0, 0, 0.0), square(HALF as f32, 1, 0.8)],
        materials: vec![Material::default(), lifted],
        images: Vec::new(),
        height_maps: vec![HeightMap {
            name: "one".into(),
            width: 2,
            height: 2,
            // One step short of constant: of a constant map the plan makes no shell.
            texels: HeightTexels::U16(vec![65535, 65535, 65535, 65534]),
        }],
        instances: vec![instance(0, 0.0), instance(1, 1.0)],
        camera: Some(Camera::look_at(DVec3::new(0.4, 4.0, 4.0), DVec3::new(0.4, 0.2, 0.0), 50.0).unwrap()),
        lights: vec![light],
        ambient: Ambient::default(),
        notices: Vec::new(),
    }
}

fn lamp(position: DVec3, direction: DVec3, kind: LightKind) -> Light {
    Light { intensity: DVec3::splat(3.0), position, direction: direction.normalize(), range: None, kind }
}

fn sun() -> Light {
    lamp(DVec3::ZERO, DVec3::new(0.9, -1.0, 0.3), LightKind::Directional)
}

/// Where the way from a point of the floor to the light crosses the level `y`, horizontally.
fn crossing(light: &Light, floor: DVec3, y: f64) -> DVec2 {
    let way = match light.kind {
        LightKind::Directional => -light.direction,
        _ => light.position - floor,
    };
    let at = floor + y / way.y * way;
    DVec2::new(at.x, at.z)
}

/// How far a point of the horizontal plane lies within the sheet; negative: outside.
fn within_sheet(at: DVec2) -> f64 {
    HALF - at.abs().max_element()
}

/// Draws a floor at y = 0 under a sheet at y = `top` and compares every pixel of the floor farther than `reach` from the
/// shadow's edge, measured at the sheet. Returns how many are dark.
#[track_caller]
fn floor_is_right(rig: &Rig, scene: &Scene, top: f64, settings: &Settings, reach: f64) -> usize {
    let drawn = rig.easel(scene, settings, EXTENT).draw(&scene.camera.unwrap());
    floor_of(&drawn, scene, top, settings, reach, within_sheet)
}

/// The same of a frame, with a sheet of another outline at `top`.
#[track_caller]
fn floor_of(
    drawn: &Aov,
    scene: &Scene,
    top: f64,
    settings: &Settings,
    reach: f64,
    within: impl Fn(DVec2) -> f64,
) -> usize {
    let light = scene.lights[0];
    let (mut dark, mut judged, mut wrong) = (0, 0, Vec::new());
    for i in (0..drawn.depth.len()).filter(|i| drawn.depth[*i].is_finite()) {
        let at = Vec3::from_array(drawn.position[i]).as_dvec3();
        let in_cone = match light.kind {
            LightKind::Spot { outer, .. } => (at - light.position).normalize().dot(light.direction) > outer.cos(),
            _ => true,
        };
        let inside = within(crossing(&light, at, top));
        if at.y.abs() > 1e-4 || !in_cone || inside.abs() <= reach {
            continue;
        }
        judged += 1;
        dark += usize::from(inside > 0.0);
        if (drawn.shadow[i] > 0.5) == (inside > 0.0) || !(0.0..=1.0).contains(&drawn.shadow[i]) {
            wrong.push((i, at, drawn.shadow[i], inside));
        }
    }
    let name = format!("{:?} {} {} {} cascades", light.kind, settings.shell, settings.stage, settings.cascades);
    println!("{name}: {} of {judged} wrong, {dark} dark", wrong.len());
    assert!(judged > 5000 && wrong.is_empty(), "{name}: {} of {judged}, the first {:?}", wrong.len(), wrong.first());
    dark
}

/// The shadow is the displaced sheet's, in its place: the flat one's would be 0.36 aside.
#[test]
fn a_sheet_casts_from_where_its_detail_is() {
    let rig = Rig::new();
    // One map of 512 texels holds a sphere of radius 4.4.
    let texel = 2.0 * 4.5 / 512.0;
    for (shell, stage) in SHELLS.into_iter().flat_map(|shell| STAGES.map(|stage| (shell, stage))) {
        assert!(floor_is_right(&rig, &sheet_over_floor(sun()), TOP, &mapped(shell, stage, 512, 1), 2.0 * texel) > 200);
    }
}

#[test]
fn cascades_spots_and_points_agree_with_the_closed_form() {
    let rig = Rig::new();
    let texel = 2.0 * 4.5 / 512.0;
    let settings = |cascades| mapped(Shell::Walk, Stage::Mesh, 512, cascades);
    let right =
        |light, cascades, reach| floor_is_right(&rig, &sheet_over_floor(light), TOP, &settings(cascades), reach);
    right(sun(), 3, 2.0 * texel);
    // The sheet hides the middle of a cone that reaches past it; texels at the floor, as seen from the lamp.
    let above = DVec3::new(-0.6, 4.0, 0.3);
    for outer in [0.9, 1.3] {
        let spot = LightKind::Spot { inner: 0.2, outer };
        right(lamp(above, DVec3::new(0.1, -1.0, 0.0), spot), 1, 0.04);
    }
    right(lamp(above, DVec3::NEG_Y, LightKind::Point), 1, 0.04);
}

/// Without a shell the depth offset lifts the floor before it looks for its lights: the shadow is that of the lifted one.
#[test]
fn a_base_surface_is_shadowed_where_its_offset_puts_it() {
    let mut scene = sheet_over_floor(sun());
    scene.meshes = vec![square(3.0, 1, 0.8), square(HALF as f32, 0, 0.0)];
    scene.instances[0].transform = DAffine3::from_translation(DVec3::new(0.0, 1.0 - TOP, 0.0));
    let settings = Settings { march: March::Relief, ..mapped(Shell::Off, Stage::Auto, 512, 1) };
    assert!(floor_is_right(&Rig::new(), &scene, 1.0, &settings, 4.0 * 4.5 / 512.0) > 150);
}

/// What the next tests allow beside an edge: two texels of a map that holds the floor and the sheet.
const REACH: f64 = 2.0 * 2.0 * 4.6 / 512.0;

fn relief() -> Settings {
    Settings { march: March::Relief, ..mapped(Shell::Prism, Stage::Mesh, 512, 1) }
}

/// What alphaMode MASK cuts out of the sheet lets light through.
#[test]
fn a_masked_sheet_casts_what_is_left_of_it() {
    let mut scene = sheet_over_floor(sun());
    let rgba = [[255; 3].as_slice(), &[0], &[255; 4]].concat();
    scene.images.push(ColorImage { name: "half".into(), width: 2, height: 1, rgba, srgb: true });
    // The sheet's UVs run from -1 to 1; the image's left texel is cut.
    let transform = DAffine2::from_scale_angle_translation(DVec2::splat(0.5), 0.0, DVec2::splat(0.5));
    let sampler = Sampler { nearest: true, no_mips: true, ..Sampler::default() };
    scene.materials[1].base_color = Some(TextureRef { image: 0, sampler, tex_coord: 0, transform });
    scene.materials[1].alpha_cutoff = Some(0.5);
    let drawn = Rig::new().easel(&scene, &relief(), EXTENT).draw(&scene.camera.unwrap());
    let dark = floor_of(&drawn, &scene, TOP, &relief(), REACH, |at| within_sheet(at).min(at.x));
    assert!(dark > 80, "{dark}");
}

/// A sheet that is somewhere else than in the file casts from where it is.
#[test]
fn a_posed_sheet_casts_from_its_pose() {
    let mut scene = sheet_over_floor(sun());
    scene.meshes[1].deforms = true;
    let aside = DVec2::new(-0.35, 0.25);
    let moved = |p: &Vec3| 0.5 * *p + Vec3::new(aside.x as f32, 0.0, aside.y as f32);
    let pose: Vec<Vec3> = scene.meshes[1].primitives[0].positions.iter().map(moved).collect();
    let drawn = Rig::new().easel(&scene, &relief(), EXTENT).draw_posed(&scene.camera.unwrap(), Some((1, &pose)));
    // What a pose may reach makes the map's texels larger.
    let dark = floor_of(&drawn, &scene, TOP, &relief(), 2.0 * REACH, |at| 0.5 * within_sheet(2.0 * (at - aside)));
    assert!(dark > 10, "{dark}");
}

/// An instance that is sheared, stretched and mirrored casts from where its detail then is.
#[test]
fn a_sheared_and_mirrored_sheet_casts_from_where_its_detail_is() {
    let mut scene = sheet_over_floor(sun());
    let axes = DMat3::from_cols(DVec3::new(-1.2, 0.0, 0.3), DVec3::new(0.5, 1.0, -0.2), DVec3::new(0.2, 0.0, 0.8));
    assert!(axes.determinant() < 0.0);
    scene.instances[1].transform.matrix3 = axes;
    let drawn = Rig::new().easel(&scene, &relief(), EXTENT).draw(&scene.camera.unwrap());
    let level = TOP - 1.0;
    // In the mesh distances differ by what the transform does to them.
    let dark = floor_of(&drawn, &scene, TOP, &relief(), 1.5 * REACH, |at| {
        let mesh = axes.inverse() * (DVec3::new(at.x, level, at.y));
        within_sheet(DVec2::new(mesh.x, mesh.z))
    });
    assert!(dark > 150, "{dark}");
}

/// Each light has its own maps: what two lights leave is the sum of what each one does, and the AOV has the first one's
/// shadow.
#[test]
fn two_lights_cast_at_once() {
    let rig = Rig::new();
    let spot = lamp(DVec3::new(-0.6, 4.0, 0.3), DVec3::new(0.1, -1.0, 0.0), LightKind::Spot { inner: 0.2, outer: 0.9 });
    let draw = |lights: &[Light]| {
        let mut scene = sheet_over_floor(sun());
        scene.lights = lights.to_vec();
        rig.easel(&scene, &relief(), EXTENT).draw(&scene.camera.unwrap())
    };
    let [none, one, other] = [&[][..], &[sun()], &[spot]].map(draw);
    let both = draw(&[sun(), spot]);
    assert!(both.shadow == one.shadow);
    for i in 0..both.color.len() {
        let [both, none, one, other] = [&both, &none, &one, &other].map(|aov| Vec3::from_array(aov.color[i]));
        let wrong = (both + none - one - other).abs().max_element();
        assert!(wrong < 1e-5 * (1.0 + both.max_element()), "pixel {i}: {wrong}");
    }
    let dark = |aov: &Aov| aov.shadow.iter().filter(|s| **s == 0.0).count();
    let different = one.shadow.iter().zip(&other.shadow).filter(|(a, b)| a != b).count();
    assert!(dark(&one) > 200 && dark(&other) > 200 && different > 200, "{different}");
}

/// Nothing is made for shadows that nothing casts.
#[test]
fn a_plain_sheet_alone_has_no_shadow_map() {
    let rig = Rig::new();
    let mut scene = sheet_over_floor(sun());
    let camera = scene.camera.unwrap();
    let settings = mapped(Shell::Walk, Stage::Mesh, 512, 1);
    let names = |rig: &Rig| rig.allocations().into_iter().filter(|name| name.contains("shadow")).count();
    let mut easel = rig.easel(&scene, &settings, EXTENT);
    easel.draw(&camera);
    assert!(names(&rig) > 1, "the sheet casts on the floor");
    let blockers = easel.plan().shadow_maps.as_ref().map_or(0, |maps| maps.draws.len());
    assert_eq!(blockers, 3, "lids, borders, floor");
    drop(easel);
    scene.instances.truncate(1);
    let mut easel = rig.easel(&scene, &settings, EXTENT);
    let drawn = easel.draw(&camera);
    assert!(drawn.shadow.iter().all(|s| *s == 1.0));
    assert!(easel.plan().shadow_maps.is_none() && easel.plan().draws.iter().all(|d| d.variant.pass == Pass::Shade));
    assert!(easel.plan().notices.iter().any(|n| n.contains("no shadow map")), "{:?}", easel.plan().notices);
    assert_eq!(names(&rig), 0);
}

/// A frame's shadows beside the reference's.
#[derive(Clone, Copy, Debug, Default)]
struct Compared {
    /// Pixels that both see.
    seen: usize,
    /// Where more than half of the light is wrong.
    wrong: usize,
    /// Light leaking: lit where the reference has it dark, and every ray within a texel of the pixel's own is blocked on
    /// its way from the pixel to the light. Where one is not, the edge of what casts the shadow runs between the texels
    /// that the map has there.
    leaks: usize,
    /// Shadow acne: dark where the reference has it lit, farther than two texels from any edge of the reference's shadow.
    acne: usize,
}

/// What the reference says around a pixel.
struct Truth<'a> {
    reference: &'a Reference,
    camera: Camera,
    light: Light,
    aov: Aov,
}

impl Truth<'_> {
    /// Whether light and shadow meet within `reach` of a pixel's hit, across the light, as far as the picture and the
    /// places between its pixels show.
    fn edge_near(&self, pixel: usize, reach: f64) -> bool {
        let at = |i: usize| Vec3::from_array(self.aov.position[i]).as_dvec3();
        let lit = self.aov.shadow[pixel] > 0.5;
        let near = |p: DVec3| (p - at(pixel)).reject_from_normalized(self.light.direction).length() <= reach;
        if (0..self.aov.depth.len())
            .any(|i| self.aov.depth[i].is_finite() && (self.aov.shadow[i] > 0.5) != lit && near(at(i)))
        {
            return true;
        }
        let Projection::Perspective { fov_y, .. } = self.camera.projection else { panic!("a perspective") };
        let half = (0.5 * fov_y).tan();
        let (x, y) = (pixel % EXTENT[0] as usize, pixel / EXTENT[0] as usize);
        // Windows of two pixels around, and of three reaches around.
        let footprint = 2.0 * half * f64::from(self.aov.depth[pixel]) / f64::from(EXTENT[1]);
        let windows = [2.0, 3.0 * reach / footprint];
        (0..2 * 33 * 33).any(|i| {
            let [dx, dy] = [i % 33, i / 33 % 33].map(|n| (f64::from(n) / 16.0 - 1.0) * windows[i as usize / (33 * 33)]);
            let across = (2.0 * (x as f64 + 0.5 + dx) - f64::from(EXTENT[0])) / f64::from(EXTENT[1]);
            let up = 1.0 - 2.0 * (y as f64 + 0.5 + dy) / f64::from(EXTENT[1]);
            let direction = self.camera.transform.transform_vector3(DVec3::new(half * across, half * up, -1.0));
            let hit = self.reference.trace(self.camera.transform.translation, direction, 0.0);
            hit.is_some_and(|hit| self.reference.lit(&hit, &self.light) != lit && near(hit.position))
        })
    }

    /// Whether all light that runs within `reach` of a pixel's own ray, to either side, is blocked on its way from the
    /// pixel's depth on.
    fn in_the_dark(&self, pixel: usize, reach: f64) -> bool {
        let at = Vec3::from_array(self.aov.position[pixel]).as_dvec3();
        let toward = -self.light.direction;
        let (u, v) = toward.any_orthonormal_pair();
        (0..17 * 17).all(|i| {
            let [x, y] = [i % 17, i / 17].map(|n| f64::from(n) / 8.0 - 1.0);
            let beside = DVec2::new(x, y).length() > 1.0;
            beside || self.reference.blocked(at + reach * (x * u + y * v), toward, [1e-6, f64::INFINITY])
        })
    }

    fn compare(&self, drawn: &Aov, texel: f64) -> Compared {
        let mut result = Compared::default();
        let both = |i: usize| drawn.depth[i].is_finite() && self.aov.depth[i].is_finite();
        for i in (0..drawn.depth.len()).filter(|i| both(*i)) {
            let lit = self.aov.shadow[i] > 0.5;
            result.seen += 1;
            if (drawn.shadow[i] > 0.5) != lit {
                result.wrong += 1;
                result.leaks += usize::from(!lit && self.in_the_dark(i, texel));
                result.acne += usize::from(lit && !self.edge_near(i, 2.0 * texel));
            }
        }
        result
    }
}

/// What one map of a directional light holds: half the diagonal of the box around all vertices, and its margin.
fn radius(scene: &Scene) -> f64 {
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for instance in &scene.instances {
        for p in scene.meshes[instance.mesh].primitives.iter().flat_map(|primitive| &primitive.positions) {
            let p = instance.transform.transform_point3(p.as_dvec3());
            (low, high) = (low.min(p), high.max(p));
        }
    }
    0.55 * (high - low).length()
}

const HEADER: &str = "\
| scene | map, texels a side | texel, mesh units | pixels | wrong | leaks | acne | |
|---|---|---|---|---|---|---|---|";

/// Texels a side of the maps of a sweep.
const SIZES: [u32; 3] = [128, 512, 2048];

/// What a sweep tells: a row a map, those that miss, and where each differs, a row a scene and a column a map.
struct Sweep {
    rows: Vec<String>,
    missed: Vec<String>,
    sheet: RgbImage,
}

/// Draws scenes by maps of more and more texels, tells each, and returns the rows and those that miss: light leaks, one
/// in a thousand pixels has acne, or the error neither fell by a quarter nor lies under 3 in 1,000.
fn sweep(rig: &Rig, names: &[&str]) -> Sweep {
    let [width, height] = EXTENT;
    let sheet = RgbImage::new(SIZES.len() as u32 * width, names.len() as u32 * height);
    let mut swept = Sweep { rows: Vec::new(), missed: Vec::new(), sheet };
    println!("{HEADER}");
    for (line, name) in names.iter().enumerate() {
        let mut scene = rig::asset(&format!("{name}.gltf"));
        let light = scene.lights.first().copied().unwrap_or_else(|| rig::lights::sun([45.0, 70.0]));
        scene.lights = vec![light];
        let camera = scene.camera.expect("the assets have cameras");
        let reference = Reference::new(&scene);
        let aov = reference.render(&camera, EXTENT[0], EXTENT[1], Shadows::Trace);
        let truth = Truth { reference: &reference, camera, light, aov };
        let mut last = usize::MAX;
        for (column, size) in SIZES.into_iter().enumerate() {
            let texel = 2.0 * radius(&scene) / f64::from(size);
            let settings = mapped(Shell::Walk, Stage::Mesh, size, 1);
            let drawn = rig.easel(&scene, &settings, EXTENT).draw(&camera);
            let [x, y] = [column as i64 * i64::from(width), line as i64 * i64::from(height)];
            image::imageops::replace(&mut swept.sheet, &difference(&drawn, &truth.aov), x, y);
            let c = truth.compare(&drawn, texel);
            let falls = c.wrong <= last - last / 4 || 1000 * c.wrong <= 3 * c.seen;
            let met = c.seen >= 3000 && falls && c.leaks == 0 && 1000 * c.acne <= c.seen;
            let verdict = if met { "met" } else { "**MISSED**" };
            let Compared { seen, wrong, leaks, acne } = c;
            let row = format!("| {name} | {size} | {texel:.5} | {seen} | {wrong} | {leaks} | {acne} | {verdict} |");
            println!("{row}");
            if !met {
                swept.missed.push(row.clone());
            }
            swept.rows.push(row);
            last = wrong;
        }
    }
    swept
}

/// The finer the map, the fewer pixels are wrong; no light leaks.
#[test]
fn errors_fall_with_the_texel() {
    let Sweep { rows, missed, .. } = sweep(&Rig::new(), &["torus", "cube", "cloth"]);
    assert_eq!(rows.len(), 9);
    assert!(missed.is_empty(), "{}", missed.join("\n"));
}

/// Scenes in which one thing shades another, over heights of a map and of a function.
const OTHERS: [&str; 2] = ["shadows", "procedural"];

/// Every scene of the table of figures, and [`OTHERS`]; writes `tests/figures/shadow_map_DEVICE.md` and its picture.
#[test]
#[ignore = "takes minutes: tests/run figures"]
fn every_scene_by_its_map_alone() {
    let rig = Rig::new();
    let names = [&SCENES[..], &OTHERS].concat();
    let Sweep { rows, missed, sheet } = sweep(&rig, &names);
    let [width, height] = EXTENT;
    let name = record::device_name(&rig.device());
    let text = format!(
        "# Shadow maps alone: error against texel size\n\n{}; {width}×{height}, one map; {}. Written by `tests/run \
         figures`.\n\nWrong: more than half of the light differs from the f64 reference's light visibility. A leak is \
         lit where the reference is dark and all light within a texel of the pixel's own ray is blocked on its way from \
         the pixel on; acne is dark where the reference is lit, two texels or more from any edge of its shadow. To be \
         reached: no leak, acne on at most 1 in 1,000 pixels, an error that falls by a quarter at least from map to map or \
         lies under 3 in 1,000. {} cells, {} missed.\n\n![Differences](shadow_map_{name}.png)\n\nA row a scene, in the \
         table's order, a column a map: light grey is lit, dark grey is not, red is lit here alone, blue in the reference \
         alone.\n\n{HEADER}\n{}\n",
        rig.device(),
        record::date(),
        rows.len(),
        missed.len(),
        rows.join("\n")
    );
    fs::write(record::path(&format!("shadow_map_{name}.md")), text).expect("the table");
    sheet.save(record::path(&format!("shadow_map_{name}.png"))).expect("the picture");
    assert_eq!(rows.len(), 3 * names.len());
    assert!(missed.is_empty(), "{}", missed.join("\n"));
}
