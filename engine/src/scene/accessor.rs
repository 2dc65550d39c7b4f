//! Buffers, buffer views and accessors: every byte that is read was checked to be there.

use std::{borrow::Cow, cell::OnceCell, path::Path};

use gltf::json::{
    self, Index,
    accessor::{ComponentType, Type},
    validation::{Checked, USize64},
};

use super::{document::Document, uri};
use crate::error::Result;

/// An accessor without a buffer view stands for zeros, so its size is bound by nothing in the file. No mesh that this
/// engine could draw comes near this many elements.
const MOST_ELEMENTS_WITHOUT_DATA: usize = 1 << 24;

/// The largest stride that glTF allows.
const MOST_STRIDE: usize = 252;

/// A file's buffers, each loaded when it is first read.
pub(super) struct Buffers<'a> {
    doc: &'a Document,
    loaded: Vec<OnceCell<Cow<'a, [u8]>>>,
}

/// What an accessor must look like for its use.
#[derive(Clone, Copy)]
struct Shape {
    type_: Type,
    components: usize,
    /// Component types that glTF allows here.
    allowed: &'static [ComponentType],
    /// Integers are fractions of their type's maximum.
    normalized: bool,
}

impl<'a> Buffers<'a> {
    /// No buffer loaded yet.
    pub fn new(doc: &'a Document) -> Self {
        Buffers { doc, loaded: doc.buffers.iter().map(|_| OnceCell::new()).collect() }
    }

    /// The bytes of a buffer view that `by` refers to.
    pub fn view(&self, index: Index<json::buffer::View>, by: &str) -> Result<&[u8]> {
        let doc = self.doc;
        let view = doc.lookup(&doc.views, index, "buffer view", by)?;
        let object = format!("buffer view {}", index.value());
        doc.lookup(&doc.buffers, view.buffer, "buffer", &object)?;
        let bytes = self.buffer(view.buffer.value())?;
        let start = view.byte_offset.unwrap_or_default();
        range(bytes, start, view.byte_length).ok_or_else(|| {
            doc.error(
                object,
                format!(
                    "covers {} bytes from {} on, but buffer {} has {}",
                    view.byte_length.0,
                    start.0,
                    view.buffer.value(),
                    bytes.len()
                ),
                "correct byteOffset and byteLength, or export the file again",
            )
        })
    }

    /// Float vectors that must be stored as such. `purpose` completes "accessor 7 (…)".
    pub fn floats<const N: usize>(&self, index: Index<json::Accessor>, purpose: &str) -> Result<Vec<[f32; N]>> {
        let shape = Shape { type_: vector(N), components: N, allowed: &[ComponentType::F32], normalized: false };
        self.read(index, purpose, shape)
    }

    /// Float vectors that may be stored as fractions in 8 or 16 bits, as texture coordinates.
    pub fn fractions<const N: usize>(&self, index: Index<json::Accessor>, purpose: &str) -> Result<Vec<[f32; N]>> {
        let allowed = &[ComponentType::F32, ComponentType::U8, ComponentType::U16];
        self.read(index, purpose, Shape { type_: vector(N), components: N, allowed, normalized: true })
    }

    /// Vertex indices.
    pub fn indices(&self, index: Index<json::Accessor>, purpose: &str) -> Result<Vec<u32>> {
        let allowed = &[ComponentType::U8, ComponentType::U16, ComponentType::U32];
        let shape = Shape { type_: Type::Scalar, components: 1, allowed, normalized: false };
        let (bytes, component) = self.elements(index, purpose, shape)?;
        Ok(bytes.chunks_exact(component.size()).map(unsigned).collect())
    }

    fn read<const N: usize>(&self, index: Index<json::Accessor>, purpose: &str, shape: Shape) -> Result<Vec<[f32; N]>> {
        let (bytes, component) = self.elements(index, purpose, shape)?;
        let size = component.size();
        let decode = |bytes: &[u8]| match component {
            ComponentType::U8 => unsigned(bytes) as f32 / f32::from(u8::MAX),
            ComponentType::U16 => unsigned(bytes) as f32 / f32::from(u16::MAX),
            _ => f32::from_bits(unsigned(bytes)),
        };
        let element = |bytes: &[u8]| std::array::from_fn(|i| decode(&bytes[i * size..][..size]));
        Ok(bytes.chunks_exact(N * size).map(element).collect())
    }

    /// An accessor's elements, tightly packed, sparse values applied.
    fn elements(&self, index: Index<json::Accessor>, purpose: &str, shape: Shape) -> Result<(Vec<u8>, ComponentType)> {
        let doc = self.doc;
        let object = format!("accessor {} ({purpose})", index.value());
        let accessor = doc.lookup(&doc.accessors, index, "accessor", purpose)?;
        let component = self.component(accessor, &object, shape)?;
        let size = component.size() * shape.components;
        let Some(count) = usize::try_from(accessor.count.0).ok().filter(|count| *count > 0) else {
            let problem = format!("has a count of {}", accessor.count.0);
            return Err(doc.error(object, problem, "give it at least one element"));
        };

        let mut elements = match accessor.buffer_view {
            Some(view) => {
                let bytes = self.view(view, &object)?;
                let offset = accessor.byte_offset.unwrap_or_default();
                // `view` has looked it up already.
                let stride = doc.views[view.value()].byte_stride.map_or(size, |stride| stride.0);
                if stride < size || stride > MOST_STRIDE.max(size) {
                    let problem = format!("its buffer view's stride is {stride}, its elements take {size} bytes");
                    return Err(doc.error(object, problem, "correct byteStride"));
                }
                strided(bytes, offset, stride, size, count).ok_or_else(|| {
                    doc.error(
                        object.as_str(),
                        format!(
                            "reads out of its range: {count} elements of {size} bytes at a stride of {stride} from \
                             byte {} on, but buffer view {} has {} bytes",
                            offset.0,
                            view.value(),
                            bytes.len()
                        ),
                        "correct count and byteOffset, or export the file again",
                    )
                })?
            }
            None if count <= MOST_ELEMENTS_WITHOUT_DATA => vec![0; count * size],
            None => {
                let problem = format!("has {count} elements and no buffer view");
                return Err(doc.error(object, problem, "give it a buffer view"));
            }
        };
        if let Some(sparse) = &accessor.sparse {
            self.apply_sparse(sparse, &object, &mut elements, size)?;
        }
        Ok((elements, component))
    }

    fn component(&self, accessor: &json::Accessor, object: &str, shape: Shape) -> Result<ComponentType> {
        let wrong = |problem: String| {
            let mend = format!("store it as {:?} of {:?}", shape.type_, shape.allowed);
            self.doc.error(object, problem, mend)
        };
        match accessor.type_ {
            Checked::Valid(type_) if type_ == shape.type_ => {}
            Checked::Valid(type_) => return Err(wrong(format!("holds {type_:?}"))),
            Checked::Invalid => return Err(wrong("has a type that glTF does not know".to_owned())),
        }
        let component = match accessor.component_type {
            Checked::Valid(component) => component.0,
            Checked::Invalid => {
                return Err(wrong("has a componentType that glTF does not know".to_owned()));
            }
        };
        if !shape.allowed.contains(&component) {
            return Err(wrong(format!("has components of type {component:?}")));
        }
        if shape.normalized && component != ComponentType::F32 && !accessor.normalized {
            return Err(wrong("holds integers that are not normalized".to_owned()));
        }
        Ok(component)
    }

    fn apply_sparse(
        &self,
        sparse: &json::accessor::sparse::Sparse,
        object: &str,
        elements: &mut [u8],
        size: usize,
    ) -> Result<()> {
        let doc = self.doc;
        let wrong = |problem: String| doc.error(object, problem, "correct 'sparse', or export the file again");
        let Checked::Valid(component) = sparse.indices.component_type else {
            return Err(wrong("its sparse indices have a componentType that is no unsigned integer".to_owned()));
        };
        let width = component.0.size();
        let outside = |part: &str| wrong(format!("its sparse {part} reach past the end of their buffer view"));
        let part = |view, offset, element: usize| {
            let length = u64::try_from(element).ok().and_then(|element| sparse.count.0.checked_mul(element));
            self.view(view, object).map(|bytes| length.and_then(|length| range(bytes, offset, USize64(length))))
        };
        let indices =
            part(sparse.indices.buffer_view, sparse.indices.byte_offset, width)?.ok_or_else(|| outside("indices"))?;
        let values =
            part(sparse.values.buffer_view, sparse.values.byte_offset, size)?.ok_or_else(|| outside("values"))?;
        for (index, value) in indices.chunks_exact(width).zip(values.chunks_exact(size)) {
            let index = unsigned(index) as usize;
            let count = elements.len() / size;
            match elements.chunks_exact_mut(size).nth(index) {
                Some(element) => element.copy_from_slice(value),
                None => {
                    return Err(wrong(format!("its sparse indices name element {index}, it has {count}")));
                }
            }
        }
        Ok(())
    }

    /// A buffer's bytes, `byteLength` of them. The index is one of the document's.
    fn buffer(&self, index: usize) -> Result<&[u8]> {
        let cell = &self.loaded[index];
        let bytes = match cell.get() {
            Some(bytes) => bytes,
            None => {
                let bytes = self.load(index)?;
                cell.get_or_init(|| bytes)
            }
        };
        // A GLB chunk is padded, and a file may hold more: what counts is the declared length.
        range(bytes, USize64(0), self.doc.buffers[index].byte_length).ok_or_else(|| {
            self.doc.error(
                format!("buffer {index}"),
                format!("has {} bytes, its byteLength is {}", bytes.len(), self.doc.buffers[index].byte_length.0),
                "copy or export the file again",
            )
        })
    }

    fn load(&self, index: usize) -> Result<Cow<'a, [u8]>> {
        let doc = self.doc;
        match (&doc.buffers[index].uri, &doc.bin) {
            (Some(uri), _) => match uri::read(folder(&doc.file), uri) {
                Ok(bytes) => Ok(Cow::Owned(bytes)),
                Err(refusal) => Err(doc.error(format!("buffer {index}"), refusal.problem, refusal.mend)),
            },
            (None, Some(bin)) if index == 0 => Ok(Cow::Borrowed(bin)),
            _ => Err(doc.error(
                format!("buffer {index}"),
                "has no uri, and the file has no binary chunk for it",
                "give it a uri, or export the file again",
            )),
        }
    }
}

/// The folder that relative URIs start from.
pub(super) fn folder(file: &Path) -> &Path {
    match file.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    }
}

fn vector(components: usize) -> Type {
    match components {
        2 => Type::Vec2,
        3 => Type::Vec3,
        _ => Type::Vec4,
    }
}

/// Copies `count` elements into a tight array, or says with `None` that some lie outside.
fn strided(bytes: &[u8], offset: USize64, stride: usize, size: usize, count: usize) -> Option<Vec<u8>> {
    let span = stride.checked_mul(count - 1)?.checked_add(size)?;
    let bytes = range(bytes, offset, USize64::from(span))?;
    if stride == size {
        return Some(bytes.to_vec());
    }
    Some(bytes.chunks(stride).flat_map(|element| &element[..size]).copied().collect())
}

/// `length` bytes from `start` on, if they are all there.
fn range(bytes: &[u8], start: USize64, length: USize64) -> Option<&[u8]> {
    let start = usize::try_from(start.0).ok()?;
    let length = usize::try_from(length.0).ok()?;
    bytes.get(start..)?.get(..length)
}

/// A little-endian unsigned integer of at most four bytes.
fn unsigned(bytes: &[u8]) -> u32 {
    bytes.iter().rev().fold(0, |value, &byte| value << 8 | u32::from(byte))
}
