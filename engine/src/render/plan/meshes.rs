//! Of each mesh: what is drawn as a shell, with which prisms, and what is left a surface.

use glam::Vec3;

use super::draws::soft;
use super::{Derived, Plan, PlannedPrimitive, Streams, needs, primitive_name};
use crate::scene::{Primitive, Scene};
use crate::settings::{SelfShadow, Settings, Shell};
use crate::shell::{
    certificate::{self, Folds},
    prisms::{self, MAX_OTHERS, ShellGeometry},
    walk::WalkGeometry,
};

/// Plans a mesh's primitives and returns the index of the first.
pub(super) fn plan_mesh(scene: &Scene, index: usize, settings: &Settings, plan: &mut Plan) -> usize {
    let start = plan.primitives.len();
    let mesh = &scene.meshes[index];
    let mut shells = vec![ShellGeometry::default(); mesh.primitives.len()];
    // Of the range of each primitive's levels; a base surface takes the light's way as straight however high.
    let mut headroom = if soft(settings) && !scene.lights.is_empty() { 1.0 } else { 0.0 };
    let shell = settings.resolved_shell();
    // A baseline samples the shell's own surface.
    let shelled = shell != Shell::Off || settings.baseline.is_some();
    // A baseline has its mesh made once.
    let deforms = mesh.deforms && settings.baseline.is_none();
    let name = |p: usize| primitive_name(scene, index, p);
    let mut offsets = match shelled && settings.baseline.is_none() {
        true => needs::offsets(scene, mesh, settings),
        false => vec![None; mesh.primitives.len()],
    };
    for ((p, primitive), moved) in mesh.primitives.iter().enumerate().zip(&mut offsets) {
        let shell = plan.ledger.decide(name(p), "shell", needs::shell(scene, primitive, settings, *moved));
        *moved = moved.filter(|_| !shell);
    }
    // What is moved to one level folds nowhere.
    let moves = offsets.iter().any(Option::is_some);
    let mut factors = vec![f64::from(u8::from(moves)); mesh.shell_normals.len()];
    let takes_shell =
        |(p, moved): (&Primitive, &Option<f64>)| moved.is_none() && prisms::displacement(scene, p).is_some();
    if shelled && mesh.primitives.iter().zip(&offsets).any(takes_shell) {
        let folds = if deforms {
            Folds { factors: vec![1.0; mesh.shell_normals.len()], reduced: Vec::new(), plain: Vec::new() }
        } else {
            certificate::mesh_folds(scene, mesh)
        };
        if !folds.reduced.is_empty() {
            plan.notices.push(format!(
                "mesh '{}': {} shell normals are shortened to keep prisms from folding, {} triangles stay plain",
                mesh.name,
                folds.reduced.len(),
                folds.plain.len()
            ));
        }
        shells = prisms::build(scene, mesh, &folds.factors);
        if headroom > 0.0 {
            headroom = certificate::headroom(scene, mesh, &folds.factors);
            if headroom == 0.0 {
                plan.notices.push(format!(
                    "mesh '{}': its prisms would fold right above the surface, where soft shadows' rays run: they are hard",
                    mesh.name
                ));
            }
        }
        plan.folds.insert(index, folds.reduced);
        for (p, shell) in shells.iter().enumerate().filter(|(_, shell)| shell.left_open > 0) {
            plan.notices.push(format!(
                "mesh '{}' primitive {p}: it meets more than {MAX_OTHERS} other height fields; the first {MAX_OTHERS} are \
                 joined to it, the steps at {} edge(s) to others stay open",
                mesh.name, shell.left_open
            ));
        }
        factors = folds.factors;
        if moves {
            // Nor is anything traced that is connected to it.
            let groups = prisms::groups(mesh);
            let moved =
                |p: usize| (0..groups.len()).any(|other| groups[other] == groups[p] && offsets[other].is_some());
            (0..shells.len()).filter(|p| moved(*p)).for_each(|p| shells[p] = ShellGeometry::default());
        }
    }
    for (p, mut geometry) in shells.into_iter().enumerate() {
        // What a baseline does not displace it draws as it is.
        if settings.baseline.is_some() && !geometry.is_displaced() {
            geometry = ShellGeometry::default();
        }
        let primitive = &mesh.primitives[p];
        let normal = |w: &u32| (mesh.shell_normals[*w as usize] * factors[*w as usize]).as_vec3();
        let shell_normals: Vec<Vec3> = primitive.weld.iter().map(normal).collect();
        let traced = settings.baseline.is_none() && geometry.is_displaced();
        let shadows = settings.self_shadow != SelfShadow::Off && !scene.lights.is_empty() && traced;
        let mapped = settings.shadow_map && !scene.lights.is_empty() && traced;
        let walks = (shell == Shell::Walk && traced) || (shell == Shell::Prism && (shadows || mapped));
        let headroom = if headroom > 0.0 {
            let [low, high] = certificate::t_range(scene, primitive).unwrap_or_default();
            headroom * (high - low)
        } else {
            0.0
        };
        let walk = walks.then(|| WalkGeometry::new(mesh, p, &shell_normals, &geometry));
        let derived = Derived::new(scene, primitive, &geometry, &shell_normals, deforms, &name(p), &mut plan.ledger);
        plan.primitives.push(PlannedPrimitive {
            mesh: index,
            primitive: p,
            shell: geometry,
            walk,
            lids: None,
            hierarchy: shelled && shadows,
            headroom,
            shell_normals,
            derived,
            streams: Streams::default(),
            offset: offsets[p],
            deforms,
        });
    }
    start
}
