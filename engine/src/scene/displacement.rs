//! The extras of a material: `displacement` (DESIGN section 2), `depthOffset`.

use glam::DAffine2;
use gltf::json::{Index, extras::RawValue};
use serde_json::{Map, Value};

use super::{
    DepthOffset, Displacement, HeightSource, Procedure, Wrap,
    document::Document,
    image::Images,
    texture::{self, Info, TRANSFORM},
};
use crate::error::{Error, Result};

const ROLE: &str = "displacement texture";

/// Reads a material's extras; `by` names the material. Extras without these are somebody else's.
pub(super) fn import(
    doc: &Document,
    by: &str,
    extras: &RawValue,
    images: &mut Images,
    notices: &mut Vec<String>,
) -> Result<(Option<Displacement>, Option<DepthOffset>)> {
    let extras: Value = serde_json::from_str(extras.get())
        .map_err(|error| doc.error(by, format!("its extras cannot be understood ({error})"), "correct them"))?;
    let request = |name: &str| match extras.get(name) {
        None | Some(Value::Null) => Ok(None),
        Some(Value::Object(request)) => Ok(Some(request)),
        Some(other) => Err(wrong_type(doc, by, &format!("extras.{name}"), other, "an object")),
    };
    match (request("displacement")?, request("depthOffset")?) {
        (None, None) => Ok((None, None)),
        (Some(fields), None) => {
            let fields = Fields { doc, by, path: "extras.displacement", fields };
            Ok((Some(displacement(&fields, images, notices)?), None))
        }
        (None, Some(fields)) => {
            let fields = Fields { doc, by, path: "extras.depthOffset", fields };
            Ok((None, Some(depth_offset(&fields, notices)?)))
        }
        (Some(_), Some(_)) => Err(doc.error(
            by,
            "its extras have both 'displacement' and 'depthOffset', but displaced detail has a depth of its own",
            "keep one of them",
        )),
    }
}

fn depth_offset(fields: &Fields, notices: &mut Vec<String>) -> Result<DepthOffset> {
    fields.notice_unknown(&["distance", "dither"], notices);
    let distance = fields.number("distance")?.filter(|&distance| distance >= 0.0).ok_or_else(|| {
        fields.doc.error(fields.by, "its extras.depthOffset has no 'distance' of at least 0", "give it in world units")
    })?;
    Ok(DepthOffset { distance, dither: fields.flag("dither")?.unwrap_or(true) })
}

fn displacement(fields: &Fields, images: &mut Images, notices: &mut Vec<String>) -> Result<Displacement> {
    let Fields { doc, by, .. } = *fields;
    let source = source(fields, notices)?;
    // A texture brings its own.
    let tex_coord = matches!(source, Source::Procedure(..)).then_some("texCoord");
    let known = ["texture", "scale", "relative", "midlevel", "border", "procedural"].into_iter().chain(tex_coord);
    fields.notice_unknown(&known.collect::<Vec<_>>(), notices);
    let scale = fields.number("scale")?.ok_or_else(|| {
        doc.error(
            by,
            "its extras.displacement has no 'scale'",
            "give the scale in mesh units, or 0 for a plain surface",
        )
    })?;
    if scale < 0.0 {
        return Err(doc.error(
            by,
            format!("its extras.displacement.scale is {scale}, below zero"),
            "make it positive and invert the height map, or move midlevel",
        ));
    }
    let border_wall = match fields.text("border")? {
        None | Some("open") => false,
        Some("wall") => true,
        Some(other) => {
            return Err(doc.error(
                by,
                format!("its extras.displacement.border is '{other}'"),
                "use \"open\" or \"wall\"",
            ));
        }
    };
    let relative = fields.flag("relative")?.unwrap_or(false);
    let midlevel = fields.number("midlevel")?.unwrap_or(0.5);

    // Decoding comes last: a wrong number is told at once.
    let (source, wrap, tex_coord, transform) = match source {
        Source::Texture(texture) => {
            let (image, sampler) = texture::resolve(doc, by, ROLE, texture.index)?;
            (HeightSource::Map(images.height(image)?), sampler.wrap, texture.tex_coord, texture.transform)
        }
        Source::Procedure(procedure, tex_coord) => {
            (HeightSource::Procedure(procedure), [Wrap::Repeat; 2], tex_coord, DAffine2::IDENTITY)
        }
    };
    Ok(Displacement { source, wrap, tex_coord, transform, scale, relative, midlevel, border_wall })
}

/// Where the heights come from, before any image is decoded.
enum Source {
    Texture(Info),
    /// With its UV set.
    Procedure(Procedure, usize),
}

/// The source of the heights, of which there must be exactly one.
fn source(fields: &Fields, notices: &mut Vec<String>) -> Result<Source> {
    let Fields { doc, by, .. } = *fields;
    let texture = fields.object("texture")?;
    let procedural = fields.text("procedural")?;
    match (texture, procedural) {
        (Some(texture), None) => texture_info(doc, by, texture, notices).map(Source::Texture),
        (None, Some(name)) => Ok(Source::Procedure(procedure(doc, by, name)?, uv_set(fields)?)),
        (Some(_), Some(_)) => {
            Err(doc.error(by, "its extras.displacement has both 'texture' and 'procedural'", "keep one of them"))
        }
        (None, None) => Err(doc.error(
            by,
            "its extras.displacement has neither 'texture' nor 'procedural'",
            "give a height map as 'texture', or a function's name as 'procedural'",
        )),
    }
}

fn procedure(doc: &Document, by: &str, name: &str) -> Result<Procedure> {
    Procedure::ALL.into_iter().find(|procedure| procedure.name() == name).ok_or_else(|| {
        let known: Vec<_> = Procedure::ALL.iter().map(|procedure| format!("\"{}\"", procedure.name())).collect();
        doc.error(
            by,
            format!(
                "its extras.displacement.procedural is '{name}', but the height functions are {}",
                known.join(", ")
            ),
            "name one of them, or give a height map as 'texture'",
        )
    })
}

/// The UV set of a procedure.
fn uv_set(fields: &Fields) -> Result<usize> {
    match fields.index("texCoord")? {
        None | Some(0) => Ok(0),
        Some(1) => Ok(1),
        Some(other) => Err(fields.doc.error(
            fields.by,
            format!("its extras.displacement reads TEXCOORD_{other}, but only UV sets 0 and 1 are supported"),
            "move the coordinates to TEXCOORD_0 or TEXCOORD_1",
        )),
    }
}

fn texture_info(doc: &Document, by: &str, texture: &Map<String, Value>, notices: &mut Vec<String>) -> Result<Info> {
    let fields = Fields { doc, by, path: "extras.displacement.texture", fields: texture };
    fields.notice_unknown(&["index", "texCoord", "extensions", "extras"], notices);
    let index = fields
        .index("index")?
        .ok_or_else(|| doc.error(by, "its extras.displacement.texture has no 'index'", "give the texture's index"))?;
    let tex_coord = fields.index("texCoord")?.unwrap_or(0);
    let extensions = fields.object("extensions")?;
    if let Some(extensions) = extensions {
        let path = "extras.displacement.texture.extensions";
        Fields { doc, by, path, fields: extensions }.notice_unknown(&[TRANSFORM], notices);
    }
    let extension = extensions.and_then(|extensions| extensions.get(TRANSFORM));
    let transform = texture::transform_in(doc, by, ROLE, extension)?;
    Info::new(doc, by, ROLE, Index::new(index), tex_coord, transform.as_ref())
}

/// A JSON object that is read field by field, so that each complaint names its field.
struct Fields<'a> {
    doc: &'a Document,
    by: &'a str,
    path: &'a str,
    fields: &'a Map<String, Value>,
}

impl<'a> Fields<'a> {
    fn typed<T>(&self, key: &str, wanted: &str, read: impl Fn(&'a Value) -> Option<T>) -> Result<Option<T>> {
        match self.fields.get(key) {
            None => Ok(None),
            Some(value) => match read(value) {
                Some(read) => Ok(Some(read)),
                None => Err(wrong_type(self.doc, self.by, &format!("{}.{key}", self.path), value, wanted)),
            },
        }
    }

    fn number(&self, key: &str) -> Result<Option<f64>> {
        self.typed(key, "a finite number", |value| value.as_f64().filter(|number| number.is_finite()))
    }

    fn index(&self, key: &str) -> Result<Option<u32>> {
        self.typed(key, "an index", |value| value.as_u64().and_then(|index| index.try_into().ok()))
    }

    fn flag(&self, key: &str) -> Result<Option<bool>> {
        self.typed(key, "true or false", Value::as_bool)
    }

    fn text(&self, key: &str) -> Result<Option<&'a str>> {
        self.typed(key, "a string", Value::as_str)
    }

    fn object(&self, key: &str) -> Result<Option<&'a Map<String, Value>>> {
        self.typed(key, "an object", Value::as_object)
    }

    fn notice_unknown(&self, known: &[&str], notices: &mut Vec<String>) {
        for key in self.fields.keys().filter(|key| !known.contains(&key.as_str())) {
            notices.push(format!("{}: {}.{key} is not known and was ignored", self.by, self.path));
        }
    }
}

fn wrong_type(doc: &Document, by: &str, path: &str, value: &Value, wanted: &str) -> Error {
    doc.error(by, format!("its {path} is {value}"), format!("make it {wanted}"))
}
