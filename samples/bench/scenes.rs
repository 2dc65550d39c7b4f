//! The torus and what is varied about it, one thing at a time, in memory.

use std::collections::HashMap;

use glam::{DAffine2, DVec2};
use prism_engine::scene::{HeightMap, HeightTexels, Mesh, Primitive, Scene};

/// How much finer the detail of [`finer_detail`] is.
pub const FINER: u32 = 8;

/// Every pair of triangles with a common longest edge becomes four: on the torus, twice the triangles in the same
/// places.
pub fn doubled(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    for mesh in &mut scene.meshes {
        for p in 0..mesh.primitives.len() {
            split(mesh, p);
        }
    }
    scene
}

fn split(mesh: &mut Mesh, index: usize) {
    let primitive = &mut mesh.primitives[index];
    let longest = |primitive: &Primitive, [a, b, c]: [u32; 3]| {
        let at = |v: u32| primitive.positions[v as usize];
        let turns = [[a, b, c], [b, c, a], [c, a, b]];
        let length = |t: &[u32; 3]| at(t[0]).distance_squared(at(t[1]));
        turns.into_iter().fold([a, b, c], |best, turn| if length(&turn) > length(&best) { turn } else { best })
    };
    let unordered = |a: u32, b: u32| [a.min(b), a.max(b)];
    let turned: Vec<[u32; 3]> = primitive.triangles.iter().map(|t| longest(primitive, *t)).collect();
    let mut choices: HashMap<[u32; 2], u32> = HashMap::new();
    for [a, b, _] in &turned {
        *choices.entry(unordered(*a, *b)).or_default() += 1;
    }
    let mut middles: HashMap<[u32; 2], u32> = HashMap::new();
    let mut triangles = Vec::with_capacity(2 * turned.len());
    for [a, b, c] in turned {
        let edge = unordered(a, b);
        if choices[&edge] != 2 {
            triangles.push([a, b, c]);
            continue;
        }
        let middle = *middles.entry(edge).or_insert_with(|| push_middle(primitive, &mut mesh.shell_normals, edge));
        triangles.extend([[a, middle, c], [middle, b, c]]);
    }
    primitive.triangles = triangles;
}

/// Adds the vertex in the middle of an edge.
fn push_middle(primitive: &mut Primitive, shell_normals: &mut Vec<glam::DVec3>, [a, b]: [u32; 2]) -> u32 {
    let [a, b] = [a as usize, b as usize];
    let id = primitive.positions.len() as u32;
    let normal = shell_normals[primitive.weld[a] as usize] + shell_normals[primitive.weld[b] as usize];
    primitive.weld.push(shell_normals.len() as u32);
    shell_normals.push(normal.normalize_or_zero());
    primitive.positions.push(primitive.positions[a].midpoint(primitive.positions[b]));
    primitive.normals.push((primitive.normals[a] + primitive.normals[b]).normalize_or_zero());
    if !primitive.tangents.is_empty() {
        primitive.tangents.push(primitive.tangents[a].midpoint(primitive.tangents[b]));
    }
    for uvs in primitive.uvs.iter_mut().filter(|uvs| !uvs.is_empty()) {
        uvs.push(uvs[a].midpoint(uvs[b]));
    }
    id
}

/// The same detail in maps of `side`² texels.
pub fn resampled(scene: &Scene, side: u32) -> Scene {
    let mut scene = scene.clone();
    scene.height_maps = scene.height_maps.iter().map(|map| resample(map, side)).collect();
    scene
}

/// Bilinear, at 16 bits; beyond its edge a map repeats.
fn resample(map: &HeightMap, side: u32) -> HeightMap {
    // The two texels of each place along an axis of n, and the second one's share.
    let places = |n: u32| -> Vec<([u32; 2], f64)> {
        let place = |i: u32| {
            let at = (f64::from(i) + 0.5) / f64::from(side) * f64::from(n) - 0.5;
            let wrapped = |i: f64| i.rem_euclid(f64::from(n)) as u32;
            ([wrapped(at.floor()), wrapped(at.floor() + 1.0)], at - at.floor())
        };
        (0..side).map(place).collect()
    };
    let columns = places(map.width);
    let texels = places(map.height).into_iter().flat_map(|(rows, share)| {
        // The map's own texels between its rows first: there are fewer of them.
        let between = |x: u32| map.height(x, rows[0]) * (1.0 - share) + map.height(x, rows[1]) * share;
        let row: Vec<f64> = (0..map.width).map(between).collect();
        let texel = |([a, b], share): &([u32; 2], f64)| {
            let height = row[*a as usize] * (1.0 - share) + row[*b as usize] * share;
            (height * f64::from(u16::MAX)).round() as u16
        };
        columns.iter().map(texel).collect::<Vec<_>>()
    });
    HeightMap {
        name: format!("{} {side}", map.name),
        width: side,
        height: side,
        texels: HeightTexels::U16(texels.collect()),
    }
}

/// The same maps, [`FINER`] times as often on a side.
pub fn finer_detail(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    for displacement in scene.materials.iter_mut().filter_map(|m| m.displacement.as_mut()) {
        displacement.transform = DAffine2::from_scale(DVec2::splat(f64::from(FINER))) * displacement.transform;
    }
    scene
}

/// Triangles of all meshes.
pub fn triangles(scene: &Scene) -> usize {
    scene.meshes.iter().flat_map(|mesh| &mesh.primitives).map(|p| p.triangles.len()).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::assets;
    use prism_engine::scene;

    fn torus() -> Scene {
        scene::load(&assets::find("torus.gltf").unwrap()).unwrap()
    }

    #[test]
    fn doubling_keeps_the_surface_closed_and_its_area() {
        let (once, twice) = (torus(), doubled(&torus()));
        assert_eq!([triangles(&once), triangles(&twice)], [2304, 4608]);
        let area = |scene: &Scene| -> f32 {
            let p = &scene.meshes[0].primitives[0];
            let at = |v: u32| p.positions[v as usize];
            p.triangles.iter().map(|[a, b, c]| (at(*b) - at(*a)).cross(at(*c) - at(*a)).length()).sum()
        };
        assert!((area(&once) / area(&twice) - 1.0).abs() < 1e-5);
        let p = &twice.meshes[0].primitives[0];
        let mut edges: HashMap<[u32; 2], i32> = HashMap::new();
        for t in &p.triangles {
            for k in 0..3 {
                let [a, b] = [t[k], t[(k + 1) % 3]].map(|v| p.weld[v as usize]);
                *edges.entry([a.min(b), a.max(b)]).or_default() += if a < b { 1 } else { -1 };
            }
        }
        assert!(edges.values().all(|sum| *sum == 0), "an edge without a mate");
    }

    #[test]
    fn a_resampled_map_has_the_same_heights() {
        let map = HeightMap { name: "m".into(), width: 2, height: 1, texels: HeightTexels::U8(vec![0, 255]) };
        let fine = resample(&map, 8);
        // Centres at 1/16, 3/16, …; texel 0 is at 4/16, texel 1 at 12/16, and between the last and the first is half.
        let expected = [0.375, 0.125, 0.125, 0.375, 0.625, 0.875, 0.875, 0.625];
        for (x, expected) in (0..8).zip(expected) {
            assert!((fine.height(x, 3) - expected).abs() < 1e-4, "{x}: {}", fine.height(x, 3));
        }
    }
}
