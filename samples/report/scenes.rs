//! The scenes, and what is varied about them, one thing at a time.

use std::path::Path;

use glam::{DQuat, DVec3, Vec2};
use prism_engine::{
    error::{Error, Result},
    scene::{self, Adjustment, Camera, Projection, Scene},
    shell::certificate,
};

use crate::{app::assets, bench::scenes};

/// The report's own scenes: a word for each, and its file.
pub const NAMED: &[(&str, &str)] = &[
    ("torus", "torus.gltf"),
    ("suzanne", "suzanne.gltf"),
    ("plane", "plane.gltf"),
    ("terrain", "terrain.gltf"),
    ("cliffs", "stability_cliffs.gltf"),
    ("needles", "stability_needles.gltf"),
];

/// Vertical field of view of a camera that stands at an angle, degrees.
const TILTED_FOV_Y: f64 = 40.0;
/// Its distance from the plane's middle, in the plane's sizes.
const TILTED_DISTANCE: f64 = 1.2;

/// Loads a scene by its word, or a glTF file.
pub fn load(name: &str, aspect: f64) -> Result<Scene> {
    let file = match NAMED.iter().find(|(word, _)| *word == name) {
        Some((_, asset)) => assets::find(asset)?,
        None if Path::new(name).extension().is_some() => Path::new(name).to_owned(),
        None => {
            let words: Vec<&str> = NAMED.iter().map(|(word, _)| *word).collect();
            return Err(Error::Usage(format!(
                "--scenes {name}: no such scene; there are {}, and glTF files by their names",
                words.join(", ")
            )));
        }
    };
    Ok(scene::load(&file)?.with_defaults(aspect))
}

/// What a scene has otherwise than its file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Change {
    /// Nothing.
    None,
    /// The height scale, in parts of the largest that folds no prism.
    OfFoldLimit(f64),
    /// The same detail in maps of so many texels a side.
    MapSide(u32),
    /// The torus from so many rows around and along.
    Grid([u32; 2]),
    /// Maps halved so often: smoother.
    Halved(u32),
    /// Maps so many times on a side: stiffer.
    Repeated(u32),
}

impl Change {
    /// The changed scene.
    pub fn make(self, scene: &Scene) -> Result<Scene> {
        let mut changed = scene.clone();
        match self {
            Change::None => {}
            Change::OfFoldLimit(part) => {
                let scale = if part == 0.0 { 0.0 } else { part * fold_limit(scene)? };
                changed.adjust(&Adjustment { height_scale: Some(scale), ..Adjustment::default() })?;
            }
            Change::MapSide(side) => changed = scenes::resampled(scene, side),
            Change::Grid(rows) => grid(&mut changed, rows),
            Change::Halved(times) => changed.adjust(&Adjustment { height_lod: times, ..Adjustment::default() })?,
            Change::Repeated(times) => {
                let uv_scale = Some([f64::from(times); 2]);
                changed.adjust(&Adjustment { uv_scale, ..Adjustment::default() })?;
            }
        }
        Ok(changed)
    }
}

/// The largest height scale that folds no prism.
fn fold_limit(scene: &Scene) -> Result<f64> {
    let folds = |scale: f64| {
        let mut changed = scene.clone();
        changed.adjust(&Adjustment { height_scale: Some(scale), ..Adjustment::default() })?;
        Ok(changed.meshes.iter().any(|mesh| !certificate::mesh_folds(&changed, mesh).reduced.is_empty()))
    };
    let (low, high) = scene.bounds().unwrap_or_default();
    let (mut holds, mut fails) = (0.0, low.distance(high));
    // To a thousandth of the scene.
    for _ in 0..10 {
        let middle = 0.5 * (holds + fails);
        if folds(middle)? { fails = middle } else { holds = middle }
    }
    Ok(holds)
}

/// Radii of the torus of `torus.gltf`, and how often the map goes around and along it (assets/make/shapes.py).
const TORUS: ([f64; 2], [f64; 2]) = ([1.0, 0.4], [5.0, 2.0]);

/// Replaces the scene's first primitive by a torus of so many rows.
fn grid(scene: &mut Scene, [around, along]: [u32; 2]) {
    let ([major, minor], repeat) = TORUS;
    let Some(mesh) = scene.meshes.first_mut() else { return };
    let primitive = &mut mesh.primitives[0];
    let turn = |i: u32, n: u32| std::f64::consts::TAU * f64::from(i % n) / f64::from(n);
    let rows = || (0..=along).flat_map(|j| (0..=around).map(move |i| (i, j)));
    let normal = |(i, j): (u32, u32)| {
        let (a, b) = (turn(i, around), -turn(j, along));
        DVec3::new(b.cos() * a.cos(), b.sin(), -b.cos() * a.sin())
    };
    let position = |(i, j): (u32, u32)| {
        let a = turn(i, around);
        major * DVec3::new(a.cos(), 0.0, -a.sin()) + minor * normal((i, j))
    };
    let uv = |(i, j): (u32, u32)| {
        let share = |i: u32, n: u32| f64::from(i) / f64::from(n);
        Vec2::new((repeat[0] * share(i, around)) as f32, (repeat[1] * share(j, along)) as f32)
    };
    primitive.positions = rows().map(|at| position(at).as_vec3()).collect();
    primitive.normals = rows().map(|at| normal(at).as_vec3()).collect();
    primitive.uvs = [rows().map(uv).collect(), Vec::new()];
    primitive.tangents = Vec::new();
    primitive.weld = rows().map(|(i, j)| (j % along) * around + i % around).collect();
    let corner = |i: u32, j: u32| j * (around + 1) + i;
    primitive.triangles = (0..along)
        .flat_map(|j| (0..around).map(move |i| (i, j)))
        .flat_map(|(i, j)| {
            let [a, b, c, d] = [corner(i, j), corner(i, j + 1), corner(i + 1, j + 1), corner(i + 1, j)];
            [[a, b, c], [a, c, d]]
        })
        .collect();
    mesh.shell_normals = vec![DVec3::ZERO; (around * along) as usize];
    mesh.update_shell_normals();
}

/// Where a scene is seen from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Place {
    /// Its own camera.
    Own,
    /// Its own camera, at so many times the distance from the scene's middle.
    Distance(f64),
    /// Toward the middle of a plane, so many degrees from its normal +Y.
    Tilted(f64),
    /// Its own camera, turned about the scene's middle by so many degrees.
    Turned(f64),
}

impl Place {
    /// The camera.
    pub fn camera(self, scene: &Scene, aspect: f64) -> Result<Camera> {
        let bounds = scene.bounds().unwrap_or_default();
        let middle = bounds.0.midpoint(bounds.1);
        let own = scene.camera.unwrap_or_else(|| scene::frame(bounds, aspect));
        let mut camera = own;
        match self {
            Place::Own => {}
            Place::Distance(factor) => {
                // Along its own axis, so that what is in the middle of the picture stays there.
                let axis = -own.transform.matrix3.z_axis.normalize();
                let distance = (middle - own.transform.translation).dot(axis);
                camera.transform.translation += axis * distance * (1.0 - factor);
                if let Projection::Perspective { far, .. } = &mut camera.projection {
                    *far = None;
                }
            }
            Place::Tilted(degrees) => {
                let (sin, cos) = degrees.to_radians().sin_cos();
                let distance = TILTED_DISTANCE * bounds.0.distance(bounds.1);
                let top = DVec3::new(middle.x, bounds.1.y, middle.z);
                camera = Camera::look_at(top + distance * DVec3::new(0.0, cos, sin), top, TILTED_FOV_Y)?;
            }
            Place::Turned(degrees) => {
                let turn = DQuat::from_rotation_y(degrees.to_radians());
                camera.transform.translation = middle + turn * (own.transform.translation - middle);
                camera.transform.matrix3 = glam::DMat3::from_quat(turn) * own.transform.matrix3;
            }
        }
        Ok(camera)
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    #[test]
    fn the_torus_of_the_sweep_is_that_of_the_file() {
        let file = load("torus", 1.0).unwrap();
        let made = Change::Grid([48, 24]).make(&file).unwrap();
        let [file, made] = [&file, &made].map(|scene| &scene.meshes[0]);
        assert_eq!(made.primitives[0].triangles.len(), file.primitives[0].triangles.len());
        let near = |a: &Vec3, b: &Vec3| a.distance(*b) < 1e-5;
        let [a, b] = [file, made].map(|mesh| &mesh.primitives[0]);
        // The file's vertices were reordered: each of them is one of ours, with its normal and UV.
        for v in 0..a.positions.len() {
            let same = (0..b.positions.len()).any(|w| {
                near(&a.positions[v], &b.positions[w])
                    && near(&a.normals[v], &b.normals[w])
                    && a.uvs[0][v].distance(b.uvs[0][w]) < 1e-5
                    && a.weld.len() == b.weld.len()
            });
            assert!(same, "vertex {v}");
        }
        let up = |mesh: &prism_engine::scene::Mesh| mesh.shell_normals.iter().map(|n| n.y.abs()).sum::<f64>();
        assert!((up(file) - up(made)).abs() < 1e-3, "{} {}", up(file), up(made));
    }

    #[test]
    fn nothing_folds_at_the_fold_limit_and_something_above() {
        let torus = load("torus", 1.0).unwrap();
        let folded = |part: f64| {
            let scene = Change::OfFoldLimit(part).make(&torus).unwrap();
            scene.meshes.iter().any(|mesh| !certificate::mesh_folds(&scene, mesh).reduced.is_empty())
        };
        assert!(!folded(1.0) && folded(1.02));
    }

    #[test]
    fn an_unknown_scene_is_told_with_those_there_are() {
        let error = load("nonesuch", 1.0).unwrap_err();
        assert_eq!(error.exit_code(), 2);
        assert!(error.to_string().contains("torus, suzanne, plane"), "{error}");
    }
}
