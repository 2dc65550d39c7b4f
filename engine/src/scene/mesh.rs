//! Meshes: vertices and triangles as the engine draws them, checked.

use glam::{DAffine2, DVec3, Vec2, Vec3, Vec4};
use gltf::json::{
    self,
    mesh::{Mode, Semantic},
    validation::Checked,
};

use super::{Material, Primitive, accessor::Buffers, document::Document, tangents, triangles, weld};
use crate::error::{Error, Result};

/// Normals and tangents shorter than this have no direction.
const LEAST_LENGTH: f64 = 1e-6;

/// Vectors whose squared length is this close to 1 are unit vectors up to rounding, and keep their bits.
const UNIT_TOLERANCE: f64 = 1e-6;

/// "mesh 0 'Torus' primitive 1".
pub(super) fn primitive_label(doc: &Document, mesh: usize, primitive: usize) -> String {
    format!("{} primitive {primitive}", doc.mesh_label(mesh))
}

/// Imports meshes, after the materials, which decide what a primitive needs.
pub(super) struct Importer<'a> {
    pub doc: &'a Document,
    pub buffers: &'a Buffers<'a>,
    /// [`super::Scene::materials`]; the default material, if any primitive uses it, is the last.
    pub materials: &'a [Material],
    pub notices: &'a mut Vec<String>,
}

impl Importer<'_> {
    /// A mesh's triangle primitives and its shell normals.
    pub fn mesh(&mut self, index: usize) -> Result<(Vec<Primitive>, Vec<DVec3>)> {
        let doc = self.doc;
        let mut primitives = Vec::new();
        for (i, source) in doc.meshes[index].primitives.iter().enumerate() {
            let by = primitive_label(doc, index, i);
            primitives.extend(self.primitive(source, &by)?);
        }
        let shell_normals = weld::weld(&mut primitives);
        Ok((primitives, shell_normals))
    }

    /// A primitive, or nothing (and a notice) where it has nothing to draw.
    fn primitive(&mut self, source: &json::mesh::Primitive, by: &str) -> Result<Option<Primitive>> {
        let Some(mut primitive) = self.vertices(source, by)? else {
            self.notices.push(format!("{by}: has no positions and was left out"));
            return Ok(None);
        };
        match self.triangles(source, by, primitive.positions.len())? {
            Some(triangles) => primitive.triangles = triangles,
            None => {
                self.notices.push(format!("{by}: points and lines are not drawn"));
                return Ok(None);
            }
        }
        match primitive.drop_degenerate() {
            0 => {}
            count => self.notices.push(format!("{by}: {count} triangle(s) without area were left out")),
        }
        if primitive.triangles.is_empty() {
            self.notices.push(format!("{by}: has no triangles and was left out"));
            return Ok(None);
        }
        if source.targets.as_ref().is_some_and(|targets| !targets.is_empty()) {
            self.notices.push(format!("{by}: morph targets are ignored"));
        }
        if source.attributes.contains_key(&Checked::Valid(Semantic::Colors(0))) {
            self.notices.push(format!("{by}: vertex colours are ignored"));
        }

        if primitive.normals.is_empty() {
            // Tangents belong to normals: glTF wants both ignored together.
            primitive.tangents.clear();
            primitive.flatten();
        }
        let material = &self.materials[primitive.material];
        self.notice_missing_uvs(&primitive, material, by);
        primitive.displacement_scale = self.displacement_scale(&primitive, material, by)?;
        primitive.own_tangents = !primitive.tangents.is_empty();
        if !primitive.own_tangents
            && let Some((tex_coord, transform)) = tangent_space(material, &primitive)
        {
            tangents::generate(&mut primitive, tex_coord, transform);
        }
        Ok(Some(primitive))
    }

    /// The per-vertex arrays that the file has, checked; nothing without positions.
    fn vertices(&self, source: &json::mesh::Primitive, by: &str) -> Result<Option<Primitive>> {
        let Some(positions) = self.attribute::<3>(source, Semantic::Positions, "positions", by, None)? else {
            return Ok(None);
        };
        let count = Some(positions.len());
        let normals = self.attribute::<3>(source, Semantic::Normals, "normals", by, count)?;
        let tangents = self.attribute::<4>(source, Semantic::Tangents, "tangents", by, count)?;
        let uv = |set, what| self.attribute::<2>(source, Semantic::TexCoords(set), what, by, count);
        let uvs = [uv(0, "TEXCOORD_0")?, uv(1, "TEXCOORD_1")?];
        let material = source.material.map_or(self.materials.len() - 1, |material| material.value());
        Ok(Some(Primitive {
            material,
            positions: positions.into_iter().map(Vec3::from).collect(),
            normals: match normals {
                Some(normals) => self.unit_normals(normals, source, by)?,
                None => Vec::new(),
            },
            tangents: match tangents {
                Some(tangents) => self.unit_tangents(tangents, source, by)?,
                None => Vec::new(),
            },
            own_tangents: false,
            uvs: uvs.map(|uvs| uvs.into_iter().flatten().map(Vec2::from).collect()),
            triangles: Vec::new(),
            weld: Vec::new(),
            displacement_scale: 0.0,
        }))
    }

    /// An attribute's values, all finite and as many as there are vertices; nothing if the file has none.
    fn attribute<const N: usize>(
        &self,
        source: &json::mesh::Primitive,
        semantic: Semantic,
        what: &str,
        by: &str,
        vertices: Option<usize>,
    ) -> Result<Option<Vec<[f32; N]>>> {
        let coordinates = matches!(semantic, Semantic::TexCoords(_));
        let Some(&index) = source.attributes.get(&Checked::Valid(semantic)) else {
            return Ok(None);
        };
        let purpose = format!("{what} of {by}");
        let values = match coordinates {
            true => self.buffers.fractions::<N>(index, &purpose)?,
            false => self.buffers.floats::<N>(index, &purpose)?,
        };
        let wrong = |problem: String| self.accessor_error(index, &purpose, problem);
        if let Some(vertices) = vertices.filter(|vertices| *vertices != values.len()) {
            return Err(wrong(format!("has {} elements for {vertices} positions", values.len())));
        }
        if let Some(element) = values.iter().position(|value| !value.iter().all(|x| x.is_finite())) {
            return Err(wrong(format!("element {element} is not finite: {:?}", values[element])));
        }
        Ok(Some(values))
    }

    fn accessor_error(&self, index: json::Index<json::Accessor>, purpose: &str, problem: String) -> Error {
        let object = format!("accessor {} ({purpose})", index.value());
        self.doc.error(object, problem, "correct the mesh and export it again")
    }

    fn attribute_error(
        &self,
        source: &json::mesh::Primitive,
        semantic: Semantic,
        purpose: &str,
        problem: String,
    ) -> Error {
        match source.attributes.get(&Checked::Valid(semantic)) {
            Some(&index) => self.accessor_error(index, purpose, problem),
            None => self.doc.error(purpose, problem, "correct the mesh and export it again"),
        }
    }

    fn unit_normals(&self, normals: Vec<[f32; 3]>, source: &json::mesh::Primitive, by: &str) -> Result<Vec<Vec3>> {
        let unit = |(i, normal): (usize, [f32; 3])| {
            unit(normal.into()).ok_or_else(|| {
                let problem = format!("element {i} has length zero");
                self.attribute_error(source, Semantic::Normals, &format!("normals of {by}"), problem)
            })
        };
        normals.into_iter().enumerate().map(unit).collect()
    }

    fn unit_tangents(&self, tangents: Vec<[f32; 4]>, source: &json::mesh::Primitive, by: &str) -> Result<Vec<Vec4>> {
        let unit = |(i, [x, y, z, w]): (usize, [f32; 4])| {
            let tangent = unit(Vec3::new(x, y, z)).filter(|_| w.abs() == 1.0);
            tangent.map(|tangent| tangent.extend(w)).ok_or_else(|| {
                let problem = format!("element {i} has length zero, or a w other than 1 and -1");
                self.attribute_error(source, Semantic::Tangents, &format!("tangents of {by}"), problem)
            })
        };
        tangents.into_iter().enumerate().map(unit).collect()
    }

    /// The triangles, with every index below `vertices`; nothing for points and lines.
    fn triangles(&self, source: &json::mesh::Primitive, by: &str, vertices: usize) -> Result<Option<Vec<[u32; 3]>>> {
        let doc = self.doc;
        let too_many = || doc.error(by, "has more corners than 32 bits can number", "split the mesh");
        let vertices = u32::try_from(vertices).map_err(|_| too_many())?;
        let Checked::Valid(mode) = source.mode else {
            return Err(doc.error(by, "its mode is none of glTF's", "export it as triangles"));
        };
        let indices = match source.indices {
            Some(index) => {
                let purpose = format!("indices of {by}");
                let indices = self.buffers.indices(index, &purpose)?;
                if let Some(past) = indices.iter().position(|&index| index >= vertices) {
                    let problem = format!("element {past} is {}, past the end of {vertices} vertices", indices[past]);
                    return Err(self.accessor_error(index, &purpose, problem));
                }
                indices
            }
            None => (0..vertices).collect(),
        };
        if mode == Mode::Triangles && indices.len() % 3 != 0 {
            let problem = format!("has {} corners, no multiple of three", indices.len());
            return Err(doc.error(by, problem, "correct the mesh and export it again"));
        }
        let triangles = triangles::assemble(mode, &indices);
        if triangles.as_ref().is_some_and(|triangles| triangles.len() > (u32::MAX / 3) as usize) {
            return Err(too_many());
        }
        Ok(triangles)
    }

    fn displacement_scale(&self, primitive: &Primitive, material: &Material, by: &str) -> Result<f64> {
        let Some(displacement) = &material.displacement else {
            return Ok(0.0);
        };
        let set = displacement.tex_coord;
        let error = |problem: String, mend: &str| self.doc.error(by, problem, mend);
        if primitive.uvs[set].is_empty() {
            return Err(error(
                format!("has no TEXCOORD_{set}, which the displacement of material '{}' reads", material.name),
                "unwrap the mesh, or remove the displacement",
            ));
        }
        if !displacement.relative || displacement.scale == 0.0 {
            return Ok(displacement.scale);
        }
        let (mesh, uv) = primitive.areas(set);
        let scale = displacement.scale * (mesh / uv).sqrt();
        if scale.is_finite() {
            return Ok(scale);
        }
        Err(error(
            format!("its TEXCOORD_{set} covers no area, to which material '{}' has a relative scale", material.name),
            "unwrap the mesh, or set relative to false",
        ))
    }

    fn notice_missing_uvs(&mut self, primitive: &Primitive, material: &Material, by: &str) {
        let textures = material.textures();
        for set in 0..primitive.uvs.len() {
            if primitive.uvs[set].is_empty() && textures.iter().flatten().any(|texture| texture.tex_coord == set) {
                self.notices.push(format!(
                    "{by}: has no TEXCOORD_{set}, which material '{}' reads: its textures are read at (0, 0)",
                    material.name
                ));
            }
        }
    }
}

/// The UV set and transform that tangents of a primitive must follow: the normal map's, else the height map's; nothing
/// where no map needs tangents, or the primitive lacks the coordinates.
pub(crate) fn tangent_space(material: &Material, primitive: &Primitive) -> Option<(usize, DAffine2)> {
    let normal = material.normal.map(|(texture, _)| (texture.tex_coord, texture.transform));
    let displaced = material.displacement.map(|displaced| (displaced.tex_coord, displaced.transform));
    [normal, displaced].into_iter().flatten().find(|(tex_coord, _)| !primitive.uvs[*tex_coord].is_empty())
}

/// A unit vector in the direction of a finite one, unless that is too short to have any.
fn unit(vector: Vec3) -> Option<Vec3> {
    let exact = vector.as_dvec3();
    let squared = exact.length_squared();
    if (squared - 1.0).abs() <= UNIT_TOLERANCE {
        return Some(vector);
    }
    (squared > LEAST_LENGTH * LEAST_LENGTH).then(|| (exact / squared.sqrt()).as_vec3())
}
