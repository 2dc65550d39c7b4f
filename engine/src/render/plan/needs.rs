//! What one primitive or material needs, each with its reason. A new need is a function here and a line where it is
//! decided.

use std::collections::HashSet;

use glam::{DVec3, Vec3};

use super::ledger::Need;
use crate::render::variant::{READ_TOGETHER, TEXTURE_NAMES, Vertices};
use crate::scene::{HeightMap, HeightTexels, Instance, Light, LightKind, Material, Mesh, Primitive, Scene};
use crate::settings::{DepthPrepass, PrismCulling, SelfShadow, Settings, Shell, Stage};
use crate::shell::{
    bounds, certificate,
    prisms::{self, ShellGeometry, Wall},
};

/// Alpha comes this near its cut-off by the rounding of filters only.
const ALPHA_ROOM: f32 = 1e-3;

/// A surface is flat, and its coordinates are one affine map of it, up to this part of its size.
const FLAT: f64 = 1e-5;

/// Slopes and light directions are told apart by this factor.
const SLOPE_ROOM: f64 = 1.01;

/// Whether a primitive is drawn as a shell of prisms. `moved`: see [`offsets`].
pub fn shell(scene: &Scene, primitive: &Primitive, settings: &Settings, moved: Option<f64>) -> Need {
    let material = &scene.materials[primitive.material];
    let Some(displacement) = material.displacement else {
        return Need::No("its material asks for no displacement".into());
    };
    if primitive.displacement_scale == 0.0 {
        return Need::No("its displacement's scale is 0".into());
    }
    if settings.baseline.is_some() {
        return Need::No("a baseline stands in for it".into());
    }
    if settings.resolved_shell() == Shell::Off {
        return Need::No("--shell off: its base surface".into());
    }
    match moved {
        Some(level) => {
            Need::Idle(format!("its heights are all the same: the surface itself, moved by {level} along its normals"))
        }
        None => Need::Yes(match displacement.source.map() {
            Some(map) => format!("height map '{}' displaces it", scene.height_maps[map].name),
            None => "a height function displaces it".into(),
        }),
    }
}

/// The level of a displaced primitive whose heights are all the same, wherever its triangles read them.
fn constant_level(scene: &Scene, primitive: &Primitive, settings: &Settings) -> Option<f64> {
    let displacement = prisms::displacement(scene, primitive)?;
    let map = &scene.height_maps[displacement.source.map()?];
    let level = |height: f64| (height - displacement.midlevel) * primitive.displacement_scale;
    let (low, high) = map.min_max();
    // Walls at its borders reach down to the map's lowest level, and other heights hide the sky.
    if low == high || displacement.border_wall || settings.ambient_occlusion {
        return (low == high).then(|| level(low));
    }
    let uvs = prisms::height_uvs(primitive, &displacement);
    let height = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|v| uvs[v as usize].as_dvec2());
        bounds::constant_over(map, displacement.wrap, a.min(b).min(c), a.max(b).max(c))
    };
    let mut heights = primitive.triangles.iter().map(height);
    let first = heights.next()??;
    heights.all(|height| height == Some(first)).then(|| level(first))
}

/// For each displaced primitive of a mesh the level at which its triangles are its whole displaced surface; none where it
/// takes a shell: heights that vary, steps or folds, in it or in what it is connected to, shadows of its own, or a fade.
pub fn offsets(scene: &Scene, mesh: &Mesh, settings: &Settings) -> Vec<Option<f64>> {
    let displaced = |p: &Primitive| prisms::displacement(scene, p).is_some();
    let none = vec![None; mesh.primitives.len()];
    if mesh.deforms || settings.self_shadow != SelfShadow::Off || settings.lod_fade.is_some() {
        return none;
    }
    let mut levels: Vec<_> = mesh.primitives.iter().map(|p| constant_level(scene, p, settings)).collect();
    if levels.iter().all(Option::is_none) {
        return none;
    }
    let groups = prisms::groups(mesh);
    let folds: HashSet<u32> = certificate::mesh_folds(scene, mesh).reduced.iter().map(|(weld, _)| *weld).collect();
    let own = levels.clone();
    for (p, level) in levels.iter_mut().enumerate() {
        let connected = || (0..groups.len()).filter(|other| groups[*other] == groups[p]);
        // A plain neighbour is a step away, unless the level is its own.
        let at_level = |other: usize| match displaced(&mesh.primitives[other]) {
            true => own[other] == own[p],
            false => own[p] == Some(0.0),
        };
        let folded = |other: usize| mesh.primitives[other].weld.iter().any(|weld| folds.contains(weld));
        *level = level.filter(|_| connected().all(|other| at_level(other) && !folded(other)));
    }
    levels
}

/// Code for steps at the walls of a primitive's prisms.
pub fn steps(geometry: &ShellGeometry, deforms: bool) -> Need {
    if deforms {
        return Need::Yes("a pose may make any neighbour plain".into());
    }
    let of = |kind: Wall| geometry.prisms.iter().flat_map(|p| p.walls).filter(|wall| *wall == kind).count();
    let [seams, plain, closed] = [Wall::Seam, Wall::Plain, Wall::Closed].map(of);
    Need::when(
        seams + plain + closed > 0,
        format!("{seams} walls at seams, {plain} beside plain triangles, {closed} at closed borders"),
        "the heights agree across all its walls",
    )
}

/// Code for triangles that are traced though nothing displaces them.
pub fn plain_prisms(geometry: &ShellGeometry, deforms: bool) -> Need {
    if deforms {
        return Need::Yes("a pose may make any triangle plain".into());
    }
    let plain = geometry.prisms.iter().filter(|prism| prism.plain).count();
    Need::when(plain > 0, format!("{plain} of its triangles are plain"), "all its triangles are displaced")
}

/// Code that takes one step where a triangle has one height.
pub fn one_heights(geometry: &ShellGeometry, settings: &Settings) -> Need {
    let level = geometry.prisms.iter().filter(|prism| prism.one_height).count();
    match settings.keep_all {
        true => Need::No("--keep-all marches in every prism".into()),
        false => Need::asked(
            level > 0,
            format!("{level} of its triangles have one height each"),
            "no triangle has one height all over",
        ),
    }
}

/// Each texture of a material, in the order of [`Material::textures`], and which pairs of [`READ_TOGETHER`] are one.
pub fn textures(material: &Material) -> ([Need; 7], [bool; 2]) {
    let (mut needed, all) = (each_texture(material), material.textures());
    let pairs = READ_TOGETHER.map(|(first, second, _)| {
        let read = |slot: usize| matches!(needed[slot], Need::Yes(_));
        let one = all[first] == all[second] && read(first) && read(second);
        if one {
            needed[second] = Need::Idle(format!("it is {}, read once for both", TEXTURE_NAMES[first]));
        }
        one
    });
    (needed, pairs)
}

fn each_texture(material: &Material) -> [Need; 7] {
    let masked = material.alpha_cutoff.is_some();
    let need = |has: bool, read: bool, why_not: &str| match has {
        true => Need::when(read, "the material has it", why_not),
        false => Need::No("the material has none".into()),
    };
    let (matt, metal) = (material.specular == 0.0, all_metal(material));
    let black = material.base_color_factor.truncate() == Vec3::ZERO;
    [
        need(material.base_color.is_some(), !black || masked, "its factor is black"),
        need(
            material.metallic_roughness.is_some(),
            material.metallic != 0.0 || material.roughness != 0.0,
            "both its factors are 0",
        ),
        need(material.normal.is_some(), material.normal.is_some_and(|(_, scale)| scale != 0.0), "its scale is 0"),
        need(
            material.occlusion.is_some(),
            material.occlusion.is_some_and(|(_, strength)| strength != 0.0),
            "its strength is 0",
        ),
        need(material.emissive.is_some(), material.emissive_factor != Vec3::ZERO, "its factor is black"),
        need(material.specular_map.is_some(), !matt && !metal, if matt { "its factor is 0" } else { METAL }),
        need(
            material.specular_color.is_some(),
            !matt && !metal && material.specular_color_factor != Vec3::ZERO,
            if metal { METAL } else { "its factor or the specular one is 0" },
        ),
    ]
}

/// Shell normals of a primitive's vertices. `read`: of these, by its draws or poses.
pub fn shell_normals(read: Vertices) -> Need {
    match read {
        Vertices::None => Need::No("no draw reads its vertices".into()),
        Vertices::Surface => Need::Idle("its triangles are drawn as they are".into()),
        Vertices::Shell => Need::Yes("its shell, poses or tangent frames are with them".into()),
    }
}

/// A UV set, or tangents, of a primitive's vertices. `derived`: it is their coordinates in the height map.
pub fn stream(has: bool, read: bool, derived: bool) -> Need {
    match (read, has) {
        (true, _) if derived => Need::Idle("it is the coordinates in the height map".into()),
        (true, _) => Need::Yes("a texture, parallax or the surface data read it".into()),
        (false, true) => Need::Idle("nothing that is drawn reads it".into()),
        (false, false) => Need::No("the mesh has none, or has no use for it".into()),
    }
}

/// Why metal has no use for `KHR_materials_specular`.
const METAL: &str = "it is all metal, which reflects its base colour";

fn all_metal(material: &Material) -> bool {
    material.metallic == 1.0 && material.metallic_roughness.is_none()
}

/// Code for another reflection than the 4 % of a common dielectric.
pub fn specular(material: &Material) -> Need {
    let asked = material.specular != 1.0
        || material.specular_color_factor != Vec3::ONE
        || material.specular_map.is_some()
        || material.specular_color.is_some();
    match asked {
        true => Need::when(!all_metal(material), "the material changes it", METAL),
        false => Need::No("it reflects 4 %".into()),
    }
}

/// alphaMode MASK.
pub fn alpha_mask(scene: &Scene, material: &Material) -> Need {
    let Some(cutoff) = material.alpha_cutoff else { return Need::No("alphaMode is not MASK".into()) };
    let least = material.base_color.map_or(255, |texture| {
        let alphas = scene.images[texture.image].rgba.chunks_exact(4).map(|texel| texel[3]);
        alphas.min().unwrap_or(255)
    });
    let least = material.base_color_factor.w * f32::from(least) / 255.0;
    Need::when(
        least < cutoff + ALPHA_ROOM,
        format!("alpha may fall below the cut-off of {cutoff}"),
        format!("alpha is {least} or more everywhere, the cut-off {cutoff}"),
    )
}

/// 16 bits of a map's texels.
pub fn sixteen_bits(map: &HeightMap) -> Need {
    match &map.texels {
        HeightTexels::U8(_) => Need::No("the file has 8".into()),
        HeightTexels::F16(_) => Need::Yes("half floats are asked for".into()),
        HeightTexels::U16(texels) => Need::when(
            !texels.iter().all(|texel| texel % 257 == 0),
            "its heights are not all among 256 even steps",
            "8 hold each of its heights exactly",
        ),
    }
}

/// The chain of a colour image's mips. `between`: some sampler reads it at them.
pub fn mips(extent: [u32; 2], between: bool) -> Need {
    match extent {
        [1, 1] => Need::No("it is one texel".into()),
        _ => Need::when(between, "it is read at the size it has on screen", "its samplers ask for none"),
    }
}

/// That of a height map, in an image of its own. `lods`: some base surface reads it so.
pub fn height_mips(lods: bool) -> Need {
    Need::asked(lods, "--height-lod auto: each pixel reads them at its own", "heights are read at full size only")
}

/// Prisms of a primitive from which on it pays to drop unseen ones: below, all are made in the time that testing them takes.
const CULLED_FROM: usize = 4096;

/// Dropping a primitive's prisms that lie outside the view or, lids, face away, before the stage that makes them.
pub fn culling(settings: &Settings, stage: Stage, prisms: usize) -> Need {
    match settings.prism_culling {
        PrismCulling::Off => Need::No("--prism-culling off, or a mesh stage without a task stage".into()),
        _ if settings.keep_all => Need::No("--keep-all draws every prism".into()),
        PrismCulling::Auto if prisms < CULLED_FROM => {
            Need::No(format!("its {prisms} prisms are made in the time that testing them would take"))
        }
        PrismCulling::Auto if stage == Stage::Geometry && settings.resolved_shell() == Shell::Walk => {
            Need::No("a pass that lists lids for the geometry stage costs what it spares".into())
        }
        PrismCulling::Auto => Need::Yes(format!("many of {prisms} prisms may lie outside the view")),
        asked => Need::Yes(format!("--prism-culling {asked}")),
    }
}

/// Dropping those too that what is nearer hides. `named`: walks begin at the lids of a visibility buffer.
pub fn hidden_culling(settings: &Settings, named: bool) -> Need {
    match settings.prism_culling {
        PrismCulling::Hidden => Need::Yes("--prism-culling hidden".into()),
        PrismCulling::Auto if settings.msaa > 1 => Need::No("a pixel has several depths".into()),
        PrismCulling::Auto if settings.depth_prepass == DepthPrepass::On => Need::No("depth comes first".into()),
        PrismCulling::Auto if named => Need::No("the visibility buffer spares their traces".into()),
        PrismCulling::Auto => Need::Yes("what lies behind others traces its rays in vain".into()),
        PrismCulling::Off | PrismCulling::View => Need::No("not asked for".into()),
    }
}

/// Shadow rays of a primitive's shell. `steps`: its walls have some.
pub fn self_shadow(
    scene: &Scene,
    instance: &Instance,
    primitive: &Primitive,
    mesh: &Mesh,
    settings: &Settings,
    steps: bool,
) -> Need {
    if settings.self_shadow == SelfShadow::Off {
        return Need::No("--self-shadow off".into());
    }
    if scene.lights.is_empty() {
        return Need::No("the scene has no light".into());
    }
    let grazed = Need::Yes("a light may graze its detail".into());
    // Soft ones come from all around the light.
    if !settings.still || steps || mesh.deforms || settings.self_shadow != SelfShadow::Hard {
        return grazed;
    }
    let Some(sheet) = Sheet::of(scene, mesh, primitive) else { return grazed };
    let slopes = scene.lights.iter().map(|light| sheet.least_slope(instance, light));
    let least = slopes.fold(f64::INFINITY, f64::min);
    if sheet.steepest * SLOPE_ROOM >= least {
        return grazed;
    }
    Need::Idle(format!(
        "it is flat, nowhere steeper than {:.3}, and all light comes at {least:.3} or steeper",
        sheet.steepest
    ))
}

/// A primitive whose displaced surface is a graph over one plane, as steep as its height field makes it.
struct Sheet {
    /// Corners.
    points: Vec<DVec3>,
    /// Unit.
    normal: DVec3,
    /// Levels.
    range: [f64; 2],
    /// Greatest rise of the surface, per unit along the plane.
    steepest: f64,
}

impl Sheet {
    fn of(scene: &Scene, mesh: &Mesh, primitive: &Primitive) -> Option<Sheet> {
        let displacement = prisms::displacement(scene, primitive)?;
        let map = &scene.height_maps[displacement.source.map()?];
        let points: Vec<DVec3> = primitive.positions.iter().map(|p| p.as_dvec3()).collect();
        let uvs = prisms::height_uvs(primitive, &displacement);
        let corners = |triangle: &[u32; 3]| triangle.map(|v| points[v as usize]);
        let [a, b, c] = corners(primitive.triangles.first()?);
        let normal = (b - a).cross(c - a).normalize_or_zero();
        let size = points.iter().map(|p| p.distance(a)).fold(0.0, f64::max);
        let flat = |v: &u32| (points[*v as usize] - a).dot(normal).abs() <= FLAT * size;
        let upright = |v: &u32| mesh.shell_normals[primitive.weld[*v as usize] as usize].dot(normal) >= 1.0 - FLAT;
        if normal == DVec3::ZERO || !primitive.triangles.as_flattened().iter().all(|v| flat(v) && upright(v)) {
            return None;
        }
        // The gradients of u and v along the plane, the same on every triangle: so the field goes on beyond the borders.
        let gradients = |triangle: &[u32; 3]| {
            let [p, q, r] = corners(triangle);
            let [s, t, u] = triangle.map(|v| uvs[v as usize].as_dvec2());
            let (e1, e2) = (q - p, r - p);
            let across = e1.cross(e2);
            let squared = across.length_squared();
            let (g1, g2) = (e2.cross(across) / squared, across.cross(e1) / squared);
            let (d1, d2) = (t - s, u - s);
            [g1 * d1.x + g2 * d2.x, g1 * d1.y + g2 * d2.y]
        };
        let first = gradients(primitive.triangles.first()?);
        let near = |g: [DVec3; 2]| (0..2).all(|i| g[i].abs_diff_eq(first[i], FLAT * first[i].length()));
        let uv_of = |v: &u32| uvs[*v as usize].as_dvec2();
        let origin = primitive.triangles.as_flattened().first()?;
        let affine = |v: &u32| {
            let moved = points[*v as usize] - points[*origin as usize];
            let predicted = uv_of(origin) + glam::DVec2::new(first[0].dot(moved), first[1].dot(moved));
            predicted.abs_diff_eq(uv_of(v), FLAT * (1.0 + predicted.abs().max_element()))
        };
        if !primitive.triangles.iter().all(|t| near(gradients(t)) && t.iter().all(affine)) {
            return None;
        }
        let [along_u, along_v] = steepest(map);
        let steepest = primitive.displacement_scale * (along_u * first[0].length() + along_v * first[1].length());
        let (low, high) = scene.displacement_range(primitive);
        Some(Sheet { points, normal, range: [low, high], steepest })
    }

    /// How steeply the least steep ray of a light falls on it, per unit along the plane.
    fn least_slope(&self, instance: &Instance, light: &Light) -> f64 {
        let back = instance.transform.inverse();
        if light.kind == LightKind::Directional {
            let way = back.transform_vector3(-light.direction);
            let rise = way.dot(self.normal);
            return rise.abs() / (way - rise * self.normal).length();
        }
        let at = back.transform_point3(light.position);
        let slope = |p: &DVec3| {
            let way = at - *p;
            let rise = way.dot(self.normal);
            // From the level nearest to the light; between the levels it may shine along the surface.
            let clear = (rise - self.range[1]).max(self.range[0] - rise).max(0.0);
            clear / (way - rise * self.normal).length()
        };
        // The farthest point of a polygon is a corner.
        self.points.iter().map(slope).fold(f64::INFINITY, f64::min)
    }
}

/// Greatest change of height per unit of u and of v between neighbouring texels, around the edges too.
fn steepest(map: &HeightMap) -> [f64; 2] {
    let (w, h) = (map.width, map.height);
    let mut most = [0.0f64; 2];
    for (x, y) in (0..h).flat_map(|y| (0..w).map(move |x| (x, y))) {
        let here = map.height(x, y);
        most[0] = most[0].max((map.height((x + 1) % w, y) - here).abs());
        most[1] = most[1].max((map.height(x, (y + 1) % h) - here).abs());
    }
    [most[0] * f64::from(w), most[1] * f64::from(h)]
}
