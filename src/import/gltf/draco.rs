//! KHR_draco_mesh_compression: primitives whose triangles and attributes are one Draco stream.
//!
//! Draco keeps a mesh's connectivity as a walk over its triangles (edgebreaker) or as plain indices, and attributes as
//! quantized integers that are predicted from their neighbours. The primitive's accessors say type and count of what comes
//! out, but have no data of their own.
//!
//! Sources: the extension's specification at Khronos, and the Draco bitstream. The stream is decoded by `draco-core`
//! (Apache-2.0, pure Rust), with ceilings on what it may make. Then each attribute and the indices become accessors of their
//! own, and the primitive is pointed to those: whatever reads geometry knows nothing of Draco and checks as
//! for any file. Where we differ, and why:
//!
//! - The crate is a young port with much indexing. A damaged stream should end in an error, but should it end in a panic, that
//!   is caught here and becomes one too ([`Fault::Invalid`]). Nothing of it is kept.
//! - Encoders split vertices and drop triangles without area, so counts may differ from the accessors'. The stream counts,
//!   and it is told. What is more than four times as much as the accessors say, and over 65 536 elements, is refused, so
//!   that a file cannot hide how large it is.
//! - A stream for triangle strips still decodes to triangles, and is read as such.

use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};

use draco_core::{
    AttributeValueIndex, DataType, DecodeLimits, DecoderBuffer, ErrorKind, Mesh, MeshDecoder, PointAttribute,
    PointIndex,
};
use gltf_json::accessor::{ComponentType, Type};
use gltf_json::mesh::{Mode, Semantic};
use gltf_json::validation::Checked;
use gltf_json::{Index, Root};
use rayon::prelude::*;
use serde::Deserialize;

use super::accessor::Data;
use super::budget::Budget;
use super::steps::{Steps, settle};
use super::{Fallible, Fault, ImportOptions, Limits, Notices};
use crate::import::Phase;
use crate::scene::NoticeKind;

const NAME: &str = "KHR_draco_mesh_compression";
/// Of so many elements or fewer a stream may always be.
const ALWAYS: u64 = 1 << 16;

/// The extension's object in a primitive.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Stored {
    buffer_view: u32,
    attributes: BTreeMap<String, u32>,
}

/// One attribute out of a stream, as an accessor would have it.
struct Column {
    semantic: Semantic,
    component: ComponentType,
    shape: Type,
    normalized: bool,
    bytes: Vec<u8>,
}

/// What came out of one primitive's stream.
pub(super) struct Decoded {
    mesh: usize,
    primitive: usize,
    place: String,
    vertices: u64,
    indices: Vec<u8>,
    columns: Vec<Column>,
    /// Whether the stream has attributes that this program does not read, and that are taken out.
    others: Vec<Checked<Semantic>>,
}

/// A stream that is to be decoded.
struct Stream<'a> {
    mesh: usize,
    primitive: usize,
    place: String,
    bytes: &'a [u8],
    stored: Stored,
    source: &'a gltf_json::mesh::Primitive,
    /// Bytes charged for what the accessors say.
    charged: u64,
    vertices: u64,
    corners: u64,
}

fn object(source: &gltf_json::mesh::Primitive) -> Option<&serde_json::Value> {
    source.extensions.as_ref()?.others.get(NAME)
}

/// The accessors whose data is in Draco streams: they need no buffer view.
pub(super) fn accessors(root: &Root) -> Vec<bool> {
    let mut inside = vec![false; root.accessors.len()];
    for source in root.meshes.iter().flat_map(|m| &m.primitives).filter(|p| object(p).is_some()) {
        for index in source.attributes.values().chain(&source.indices) {
            if let Some(inside) = inside.get_mut(index.value()) {
                *inside = true;
            }
        }
    }
    inside
}

/// Decodes the streams of all primitives.
pub(super) fn decode(
    root: &Root,
    data: &Data,
    budget: &Budget,
    options: &ImportOptions,
    notices: &mut Notices,
) -> Fallible<Vec<Decoded>> {
    let mut streams = Vec::new();
    for (m, mesh) in root.meshes.iter().enumerate() {
        for (p, source) in mesh.primitives.iter().enumerate() {
            let Some(object) = object(source) else { continue };
            let place = format!("meshes[{m}].primitives[{p}].extensions.{NAME}");
            let stored = Stored::deserialize(object).map_err(|e| Fault::invalid(&place, e.to_string()))?;
            let stream = Stream::check(m, p, place, stored, source, data)?;
            budget.take(stream.charged, &stream.place)?;
            streams.push(stream);
        }
    }
    let steps = Steps::new(options, Phase::Geometry, [0.0, 0.5], streams.len());
    let decoded: Vec<Fallible<(Decoded, Notices)>> = streams
        .into_par_iter()
        .map(|stream| {
            steps.each(|| {
                let mut told = Notices::default();
                let decoded = stream.decode(data, &options.limits, &mut told)?;
                let held = decoded.columns.iter().map(|c| c.bytes.len()).sum::<usize>() + decoded.indices.len();
                budget.take((held as u64).saturating_sub(stream.charged), &stream.place)?;
                Ok((decoded, told))
            })
        })
        .collect();
    let mut all = Vec::with_capacity(decoded.len());
    for (decoded, told) in settle(decoded)? {
        notices.append(told);
        all.push(decoded);
    }
    Ok(all)
}

/// Points the primitives to what came out of their streams.
pub(super) fn install<'a>(root: &mut Root, data: &mut Data<'a>, decoded: &'a [Decoded]) {
    for stream in decoded {
        let source = root.meshes.get_mut(stream.mesh).and_then(|m| m.primitives.get_mut(stream.primitive));
        let Some(source) = source else { continue };
        for other in &stream.others {
            source.attributes.remove(other);
        }
        for column in &stream.columns {
            let place = format!("{}.attributes.{}", stream.place, column.semantic.to_string());
            let index =
                data.add(place, stream.vertices, column.component, column.shape, column.normalized, &column.bytes);
            source.attributes.insert(Checked::Valid(column.semantic.clone()), Index::new(index));
        }
        let place = format!("{} (indices)", stream.place);
        let corners = (stream.indices.len() / 4) as u64;
        let index = data.add(place, corners, ComponentType::U32, Type::Scalar, false, &stream.indices);
        source.indices = Some(Index::new(index));
        source.mode = Checked::Valid(Mode::Triangles);
    }
}

/// Whether the program reads the attribute.
fn is_read(semantic: &Semantic) -> bool {
    use Semantic::{Colors, Normals, Positions, Tangents, TexCoords};
    matches!(semantic, Positions | Normals | Tangents | Colors(0) | TexCoords(0 | 1))
}

impl<'a> Stream<'a> {
    fn check(
        mesh: usize,
        primitive: usize,
        place: String,
        stored: Stored,
        source: &'a gltf_json::mesh::Primitive,
        data: &Data<'a>,
    ) -> Fallible<Stream<'a>> {
        let view = Index::<gltf_json::buffer::View>::new(stored.buffer_view);
        let bytes = data.view(view, &format!("{place}.bufferView"))?;
        match source.mode {
            Checked::Valid(Mode::Triangles | Mode::TriangleStrip) => {}
            _ => return Err(Fault::invalid(place, "goes with triangles and triangle strips only")),
        }
        let (mut vertices, mut charged) = (0, 0_u64);
        for (semantic, &index) in &source.attributes {
            let accessor = data.accessor(index, &format!("{place}.attributes.{}", semantic.to_string()))?;
            vertices = vertices.max(accessor.count);
            charged = charged.saturating_add(accessor.count.saturating_mul(accessor.size()));
        }
        let corners = match source.indices {
            Some(index) => data.accessor(index, &format!("{place} (indices)"))?.count,
            None => vertices,
        };
        charged = charged.saturating_add(corners.saturating_mul(4));
        Ok(Stream { mesh, primitive, place, bytes, stored, source, charged, vertices, corners })
    }

    fn decode(&self, data: &Data, limits: &Limits, notices: &mut Notices) -> Fallible<Decoded> {
        let ceiling = |said: u64, limit: u64| said.saturating_mul(4).max(ALWAYS).min(limit);
        let faces = ceiling(self.corners / 3, limits.triangles);
        let points = ceiling(self.vertices, limits.vertices);
        let bytes = ceiling(self.charged, limits.bytes).max(1 << 20);
        let ceilings =
            DecodeLimits::default().with_max_faces(faces).with_max_points(points).with_max_decoded_bytes(bytes);
        let bad = |cause: String| Fault::invalid(&self.place, cause);
        let decoded = catch_unwind(AssertUnwindSafe(|| {
            let mut mesh = Mesh::new();
            let mut buffer = DecoderBuffer::new(self.bytes).with_limits(ceilings);
            MeshDecoder::new().decode(&mut buffer, &mut mesh).map(|()| mesh)
        }));
        let mesh = match decoded {
            Ok(Ok(mesh)) => mesh,
            Ok(Err(e)) if e.kind() == ErrorKind::LimitExceeded => {
                let cause =
                    format!("the stream holds far more than its accessors say, or than is allowed: {}", e.message());
                return Err(Fault::Limit { place: self.place.clone(), cause });
            }
            Ok(Err(e)) => return Err(bad(format!("the stream cannot be decoded: {}", e.message()))),
            Err(_) => return Err(bad("the stream is damaged: its decoder gave up".to_owned())),
        };
        let count = mesh.num_points();
        if count as u64 > points || mesh.num_faces() as u64 > faces {
            return Err(Fault::limit(&self.place, "vertices of the stream", count as u64, points));
        }
        let different = count as u64 != self.vertices || 3 * mesh.num_faces() as u64 != self.corners;
        let what =
            "Draco streams have other numbers of vertices or indices than their accessors say; the streams count";
        notices.count(NoticeKind::Repaired, what, different.into(), &self.place);
        let mut indices = Vec::with_capacity(mesh.num_faces().saturating_mul(12));
        for corner in mesh.faces().iter().flatten() {
            if corner.0 as usize >= count {
                return Err(bad(format!("a triangle of the stream has vertex {}, there are {count}", corner.0)));
            }
            indices.extend(corner.0.to_le_bytes());
        }
        let (mut columns, mut others) = (Vec::new(), Vec::new());
        for (semantic, &index) in &self.source.attributes {
            let name = match semantic {
                Checked::Valid(valid) => valid.to_string(),
                // Its name is gone; accessors of unknown attributes are not read, so it does not matter which it is.
                Checked::Invalid => {
                    others.push(Checked::Invalid);
                    continue;
                }
            };
            let Some(&id) = self.stored.attributes.get(&name) else { continue };
            let Checked::Valid(semantic) = semantic else { continue };
            let place = format!("{}.attributes.{name}", self.place);
            let Some(attribute) = mesh.attribute_by_unique_id(id) else {
                return Err(Fault::invalid(place, format!("the stream has no attribute {id}")));
            };
            if !is_read(semantic) {
                others.push(Checked::Valid(semantic.clone()));
                continue;
            }
            let accessor = data.accessor(index, &place)?;
            let components = accessor.shape.multiplicity();
            if usize::from(attribute.num_components()) != components {
                let cause = format!("has {} components, its accessor {components}", attribute.num_components());
                return Err(Fault::invalid(place, cause));
            }
            columns.push(Column {
                semantic: semantic.clone(),
                component: accessor.component,
                shape: accessor.shape,
                normalized: accessor.normalized,
                bytes: values(attribute, count, components, accessor.component, &place)?,
            });
        }
        let (mesh, primitive, place) = (self.mesh, self.primitive, self.place.clone());
        Ok(Decoded { mesh, primitive, place, vertices: count as u64, indices, columns, others })
    }
}

/// An attribute's values, vertex by vertex, in the accessor's type.
fn values(
    attribute: &PointAttribute,
    count: usize,
    components: usize,
    component: ComponentType,
    place: &str,
) -> Fallible<Vec<u8>> {
    let stored = match attribute.data_type() {
        DataType::Int8 => Some(ComponentType::I8),
        DataType::Uint8 => Some(ComponentType::U8),
        DataType::Int16 => Some(ComponentType::I16),
        DataType::Uint16 => Some(ComponentType::U16),
        DataType::Uint32 => Some(ComponentType::U32),
        DataType::Float32 => Some(ComponentType::F32),
        _ => None,
    };
    let bad = |cause: &str| Fault::invalid(place, cause);
    if stored != Some(component) && component == ComponentType::F32 {
        return Ok(attribute.read_f32s(count, components).into_iter().flat_map(f32::to_le_bytes).collect());
    }
    if stored != Some(component) {
        let cause = format!("is {:?} in the stream, its accessor {component:?}", attribute.data_type());
        return Err(Fault::invalid(place, cause));
    }
    let size = components.saturating_mul(component.size());
    let stride = usize::try_from(attribute.byte_stride()).unwrap_or_default();
    let data = attribute.buffer().data();
    let mut bytes = Vec::with_capacity(count.saturating_mul(size));
    for point in 0..count {
        let AttributeValueIndex(value) = attribute.mapped_index(PointIndex(point as u32));
        let value = (value as usize).checked_mul(stride).and_then(|at| data.get(at..at.checked_add(size)?));
        bytes.extend_from_slice(value.ok_or_else(|| bad("the stream has too few values"))?);
    }
    Ok(bytes)
}
