//! Self-shadow in a shell against the f64 reference's light visibility. `tests/run figures` sweeps every scene of the
//! table of figures, with lights from overhead to 1° above the horizon.
//!
//! The reference's occluders are those of the ray under test: the shaded primitive's own displaced surface. What other
//! primitives and objects cast is the shadow map's. `PRISM_SCENE=NAME` leaves the other scenes out of the sweep, and no
//! table and picture of it are written then.

mod rig;

use std::fs;

use glam::DVec3;
use image::RgbImage;
use prism_engine::{
    aov::Aov,
    scene::{Camera, HeightMap, HeightSource, HeightTexels, Light, Scene},
    settings::{SelfShadow, Settings, Shell, Stage},
    shell::reference::{Reference, Shadows},
};
use rig::{
    Easel, Rig, SHELLS,
    exactness::SCENES,
    lights::{SUNS, difference, lit_by, near_lights, sun},
    record,
};

/// Pixels of the sweep, and of what every run checks.
const SWEEP: [u32; 2] = [128, 72];
const GLANCE: [u32; 2] = [96, 54];

/// Pixels that may be wrong, of those covered.
const WRONG: f64 = 1e-3;

fn settings(shell: Shell, stage: Stage) -> Settings {
    Settings { self_shadow: SelfShadow::Hard, ..rig::exact(shell, stage) }
}

/// Pixels that both cover, those of them whose light differs, and those that the reference has in shadow.
fn compare(test: &Aov, truth: &Aov) -> [usize; 3] {
    let both = (0..truth.depth.len()).filter(|&i| test.depth[i].is_finite() && truth.depth[i].is_finite());
    both.fold([0; 3], |[covered, wrong, dark], i| {
        let differs = (test.shadow[i] < 0.5) != (truth.shadow[i] < 0.5);
        [covered + 1, wrong + usize::from(differs), dark + usize::from(truth.shadow[i] < 0.5)]
    })
}

fn truth(scene: &Scene, light: Light, camera: &Camera, size: [u32; 2]) -> Aov {
    Reference::new(&lit_by(scene, light)).render(camera, size[0], size[1], Shadows::TraceOwn)
}

const HEADER: &str = "\
| scene, shell, stage, light | covered | in shadow | wrong | share | limits | |
|---|---|---|---|---|---|---|";

/// Cells drawn so far.
#[derive(Default)]
struct Table {
    rows: Vec<String>,
    missed: Vec<String>,
}

impl Table {
    fn new() -> Table {
        println!("{HEADER}");
        Table::default()
    }

    /// Draws a cell, prints it and keeps it in mind. Returns what it drew.
    fn cell(&mut self, name: &str, easel: &mut Easel, light: Light, truth: &Aov, camera: &Camera) -> Aov {
        easel.set_light(light);
        let test = easel.draw(camera);
        let ([covered, wrong, dark], limits) = (compare(&test, truth), easel.limits_reached());
        let share = wrong as f64 / covered.max(1) as f64;
        let missed = covered == 0 || share > WRONG || limits > 0;
        let verdict = if missed { "**MISSED**" } else { "met" };
        let line = format!("| {name} | {covered} | {dark} | {wrong} | {share:.1e} | {limits} | {verdict} |");
        println!("{line}");
        self.rows.push(line.clone());
        if missed {
            self.missed.push(line);
        }
        test
    }

    /// Writes it to `tests/figures/shadow_DEVICE.md`.
    fn write(&self, device: &str) {
        let name = record::device_name(device);
        let [width, height] = SWEEP;
        let text = format!(
            "# Self-shadow of the exact march\n\n{device}; {width}×{height}; {}. Written by `tests/run figures`.\n\n\
             What each pixel sees of a sun so many degrees above the horizon, against the light visibility of the f64 \
             reference. To be reached in every cell: wrong on at most 1 in 1,000 of the pixels that both cover, no loop \
             that reached its limit. {} cells, {} missed.\n\n![Differences](shadow_{name}.png)\n\nA row a scene, in the \
             table's order, a column a sun, in the walk: light grey is lit, dark grey is not, red is lit here alone, blue \
             in the reference alone.\n\n{HEADER}\n{}\n",
            record::date(),
            self.rows.len(),
            self.missed.len(),
            self.rows.join("\n")
        );
        fs::write(record::path(&format!("shadow_{name}.md")), text).expect("the table");
    }

    fn ends_with(self, cells: usize) {
        assert_eq!(self.rows.len(), cells);
        assert!(self.missed.is_empty(), "{}", self.missed.join("\n"));
    }
}

#[test]
#[ignore = "takes minutes: tests/run figures"]
fn every_scene_sees_its_light_as_the_reference_does() {
    let rig = Rig::new();
    let chosen = |name: &&str| std::env::var("PRISM_SCENE").map_or(true, |only| only == *name);
    let mut table = Table::new();
    let mut sheet = RgbImage::new(SUNS.len() as u32 * SWEEP[0], SCENES.len() as u32 * SWEEP[1]);
    for (i, name) in SCENES.into_iter().enumerate().filter(|(_, name)| chosen(name)) {
        let scene = rig::asset(&format!("{name}.gltf"));
        let camera = scene.camera.expect("the assets have cameras");
        let truths = SUNS.map(|at| truth(&scene, sun(at), &camera, SWEEP));
        for (j, shell) in SHELLS.into_iter().enumerate() {
            // Both stages, in turns.
            let stage = rig::STAGES[(i + j) % 2];
            let mut easel = rig.easel(&lit_by(&scene, sun(SUNS[0])), &settings(shell, stage), SWEEP);
            easel.assert_stage(stage);
            // The rays of both shells are the same code; what differs is where they start.
            let suns = SUNS.into_iter().zip(&truths).enumerate();
            for (column, (at, truth)) in suns.filter(|(_, (at, _))| shell == Shell::Walk || at[0] == 45.0) {
                let label = format!("{name} {shell} {stage} {}°", at[0]);
                let test = table.cell(&label, &mut easel, sun(at), truth, &camera);
                if shell == Shell::Walk {
                    let [x, y] = [column, i].map(|n| n as i64);
                    let place = [x * i64::from(SWEEP[0]), y * i64::from(SWEEP[1])];
                    image::imageops::replace(&mut sheet, &difference(&test, truth), place[0], place[1]);
                }
            }
        }
    }
    if SCENES.iter().all(chosen) {
        table.write(&rig.device());
        let name = record::device_name(&rig.device());
        sheet.save(record::path(&format!("shadow_{name}.png"))).expect("the picture");
    }
    table.ends_with(SCENES.iter().filter(|name| chosen(name)).count() * (SUNS.len() + 1));
}

/// Suns, a point light and a spot light: on the torus prism by prism, and in the walk on the cube, where the light from
/// overhead runs within the levels of four faces.
#[test]
fn every_kind_of_light_is_seen_as_the_reference_sees_it() {
    let rig = Rig::new();
    let mut table = Table::new();
    let scenes = ["torus", "cube"].into_iter().zip([DVec3::new(0.6, 0.9, 0.3), DVec3::new(1.4, 1.8, 2.2)]);
    for ((shell, stage), (name, near)) in SHELLS.into_iter().zip(rig::STAGES).zip(scenes) {
        let scene = rig::asset(&format!("{name}.gltf"));
        let camera = scene.camera.expect("the assets have cameras");
        let mut easel = rig.easel(&lit_by(&scene, sun(SUNS[0])), &settings(shell, stage), GLANCE);
        easel.assert_stage(stage);
        let suns = SUNS.map(|at| (format!("{}°", at[0]), sun(at)));
        for (kind, light) in suns.into_iter().chain(near_lights(near).map(|(kind, light)| (kind.to_owned(), light))) {
            let truth = truth(&scene, light, &camera, GLANCE);
            table.cell(&format!("{name} {shell} {stage} {kind}"), &mut easel, light, &truth, &camera);
        }
    }
    table.ends_with(SHELLS.len() * (SUNS.len() + 2));
}

/// A ball without detail, displaced by a constant height: what faces the light sees it, to the terminator.
#[test]
fn a_smooth_ball_casts_nothing_on_itself() {
    let rig = Rig::new();
    let mut scene = rig::asset("shadows.gltf");
    // But for one step: of a constant map the plan makes no shell.
    let flat = HeightTexels::U16((0..16).map(|texel| 51_400 + u16::from(texel == 5)).collect());
    scene.height_maps.push(HeightMap { name: "flat".into(), width: 4, height: 4, texels: flat });
    let map = HeightSource::Map(scene.height_maps.len() - 1);
    let displacement = scene.materials.iter().find_map(|material| material.displacement);
    let ball = scene.instances.iter().find(|instance| instance.name == "ball in the ring").expect("a ball").clone();
    for primitive in &mut scene.meshes[ball.mesh].primitives {
        let material = &mut scene.materials[primitive.material];
        material.displacement = displacement;
        let displacement = material.displacement.as_mut().expect("the floor has some");
        (displacement.source, displacement.scale, displacement.relative) = (map, 0.05, false);
        primitive.displacement_scale = 0.05;
    }
    let at = ball.transform.translation;
    let camera = Camera::look_at(at + DVec3::new(0.3, 0.25, 0.4), at, 50.0).expect("a view");
    scene.instances = vec![ball];
    let light = sun([35.0, 10.0]);
    let mut easel = rig.easel(&lit_by(&scene, light), &settings(Shell::Prism, Stage::Mesh), GLANCE);
    let aov = easel.draw(&camera);
    let facing = |i: usize| DVec3::from_array(aov.normal[i].map(f64::from)).dot(-light.direction);
    let covered: Vec<_> = (0..aov.depth.len()).filter(|&i| aov.depth[i].is_finite()).collect();
    let wrong = covered.iter().filter(|&&i| (aov.shadow[i] > 0.5) != (facing(i) > 0.0) && facing(i).abs() > 1e-4);
    assert_eq!((covered.len() > 500, wrong.count(), easel.limits_reached()), (true, 0, 0));
}
