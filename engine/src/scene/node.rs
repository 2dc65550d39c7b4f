//! The node graph of the default scene, walked once.

use glam::{DAffine3, DMat3, DMat4, DQuat, DVec3};
use gltf::json;

use super::document::{Document, label};
use crate::error::Result;

/// A node of the default scene.
#[derive(Clone, Copy)]
pub(super) struct Reached {
    /// Index in the file.
    pub node: usize,
    /// Node to world.
    pub world: DAffine3,
}

/// The nodes of the default scene, depth first. Without a default scene it is the first one; without any scene all
/// nodes without a parent are its roots.
pub(super) fn walk(doc: &Document) -> Result<Vec<Reached>> {
    let roots = roots(doc, &parents(doc)?)?;
    let mut reached = Vec::new();
    let mut stack: Vec<_> = roots.into_iter().rev().map(|node| (node, DAffine3::IDENTITY)).collect();
    let mut seen = vec![false; doc.nodes.len()];
    while let Some((node, parent)) = stack.pop() {
        // No node has two parents and none is its own ancestor, but a scene may list a child or one root twice.
        if std::mem::replace(&mut seen[node], true) {
            return Err(doc.error(
                doc.node_label(node),
                "occurs twice in its scene",
                "list each root once in the scene, and no child of another node",
            ));
        }
        let world = parent * local(doc, node)?;
        if !world.is_finite() {
            return Err(doc.error(
                doc.node_label(node),
                "its transform to the world is not finite",
                "use numbers that do not overflow",
            ));
        }
        reached.push(Reached { node, world });
        stack.extend(children(&doc.nodes[node]).rev().map(|child| (child, world)));
    }
    Ok(reached)
}

/// What is left of a transform for drawing.
pub(super) enum Extent {
    /// It maps volumes to volumes.
    Full,
    /// All scales are zero: glTF's way to hide a node.
    Hidden,
    /// It flattens space.
    Flat,
}

impl Extent {
    /// Of a node's transform to the world.
    pub fn of(matrix: &DMat3) -> Self {
        let lengths = matrix.x_axis.length() * matrix.y_axis.length() * matrix.z_axis.length();
        // Relative to the axes' lengths, so that a tiny model is not mistaken for a flat one; f32 input cannot
        // describe a shear anywhere near this strong on purpose.
        const LEAST_VOLUME: f64 = 1e-10;
        if *matrix == DMat3::ZERO {
            Extent::Hidden
        } else if matrix.determinant().abs() > LEAST_VOLUME * lengths {
            Extent::Full
        } else {
            Extent::Flat
        }
    }
}

fn children(node: &json::Node) -> impl DoubleEndedIterator<Item = usize> {
    node.children.iter().flatten().map(|child| child.value())
}

/// Each node's parent. glTF wants trees: with one parent each, what no root reaches lies on a cycle.
fn parents(doc: &Document) -> Result<Vec<Option<usize>>> {
    let mut parents = vec![None; doc.nodes.len()];
    for (index, node) in doc.nodes.iter().enumerate() {
        for child in node.children.iter().flatten() {
            doc.lookup(&doc.nodes, *child, "node", &doc.node_label(index))?;
            if let Some(other) = parents[child.value()].replace(index) {
                return Err(doc.error(
                    doc.node_label(child.value()),
                    format!("is a child of node {other} and of node {index}"),
                    "copy the node, so that each has one parent",
                ));
            }
        }
    }
    let mut reached = vec![false; doc.nodes.len()];
    let mut stack: Vec<_> = (0..doc.nodes.len()).filter(|&node| parents[node].is_none()).collect();
    while let Some(node) = stack.pop() {
        reached[node] = true;
        stack.extend(children(&doc.nodes[node]));
    }
    match reached.iter().position(|reached| !reached) {
        Some(node) => Err(doc.error(
            doc.node_label(node),
            "is below itself: its nodes form a cycle",
            "remove one of the cycle's children",
        )),
        None => Ok(parents),
    }
}

fn roots(doc: &Document, parents: &[Option<usize>]) -> Result<Vec<usize>> {
    let (index, scene) = match doc.scene {
        Some(index) => (index.value(), doc.lookup(&doc.scenes, index, "scene", "scene")?),
        None => match doc.scenes.first() {
            Some(scene) => (0, scene),
            None => {
                return Ok((0..doc.nodes.len()).filter(|&node| parents[node].is_none()).collect());
            }
        },
    };
    let object = label("scene", index, scene.name.as_deref());
    for root in &scene.nodes {
        doc.lookup(&doc.nodes, *root, "node", &object)?;
    }
    Ok(scene.nodes.iter().map(|root| root.value()).collect())
}

/// A node's own transform, in f64.
fn local(doc: &Document, index: usize) -> Result<DAffine3> {
    let node = &doc.nodes[index];
    let wrong =
        |problem: &str| doc.error(doc.node_label(index), problem, "correct it, or apply the transform to the mesh");
    let transform = match &node.matrix {
        Some(columns) => {
            let matrix = DMat4::from_cols_array(&columns.map(f64::from));
            let bottom = matrix.row(3);
            if !matrix.is_finite() {
                return Err(wrong("its matrix is not finite"));
            }
            if bottom != glam::DVec4::W {
                return Err(wrong("its matrix is not affine: the fourth row is not 0 0 0 1"));
            }
            DAffine3::from_mat4(matrix)
        }
        None => {
            let translation = node.translation.map_or(DVec3::ZERO, |v| v.map(f64::from).into());
            let scale = node.scale.map_or(DVec3::ONE, |v| v.map(f64::from).into());
            let rotation = node.rotation.map_or(DQuat::IDENTITY, |q| DQuat::from_array(q.0.map(f64::from)));
            // Files round their quaternions; one without a length has no direction, though.
            let length = rotation.length();
            if !(length.is_finite() && length > 1e-6) {
                return Err(wrong("its rotation is no unit quaternion"));
            }
            DAffine3::from_scale_rotation_translation(scale, rotation * length.recip(), translation)
        }
    };
    if !transform.is_finite() {
        return Err(wrong("its translation or scale is not finite"));
    }
    Ok(transform)
}
