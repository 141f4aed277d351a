//! Checked access to typed data in buffers.
//!
//! [`Data::new`] checks every buffer view and accessor of the file, used or not, so that reading an element afterwards
//! cannot fail. Elements are read one by one, by index: a primitive reads only the vertices that it uses.

use std::borrow::Cow;
use std::collections::HashMap;

use gltf_json::accessor::{ComponentType, Type};
use gltf_json::validation::Checked;
use gltf_json::{Index, Root};

use super::{Fallible, Fault, Limits, Notices, draco};
use crate::scene::NoticeKind;

/// An accessor without a buffer view, all zeros but for its sparse part, may have this many elements.
const MOST_WITHOUT_DATA: u64 = 1 << 24;

/// The buffers with the views and accessors on them.
pub(super) struct Data<'a> {
    views: Vec<View<'a>>,
    accessors: Vec<Accessor<'a>>,
}

struct View<'a> {
    bytes: &'a [u8],
    /// Where it begins in its buffer.
    offset: u64,
    stride: Option<u64>,
}

/// A checked accessor.
pub(super) struct Accessor<'a> {
    /// `accessors[i]`.
    pub(super) place: String,
    /// Number of elements.
    pub(super) count: u64,
    /// Type of one component.
    pub(super) component: ComponentType,
    /// Components of an element.
    pub(super) shape: Type,
    /// Whether integers stand for fractions of their range.
    pub(super) normalized: bool,
    /// From the first element on; `None` stands for zeros.
    bytes: Option<&'a [u8]>,
    stride: usize,
    /// Elements that are replaced.
    sparse: HashMap<u32, &'a [u8]>,
}

impl<'a> Data<'a> {
    /// Checks all views and accessors. Views that were stored compressed have their content in `decoded`.
    pub(super) fn new(
        root: &Root,
        buffers: &'a [Cow<'_, [u8]>],
        decoded: &'a [Option<Vec<u8>>],
        limits: &Limits,
        notices: &mut Notices,
    ) -> Fallible<Data<'a>> {
        let mut views = Vec::with_capacity(root.buffer_views.len());
        for (i, view) in root.buffer_views.iter().enumerate() {
            let place = format!("bufferViews[{i}]");
            let Some(buffer) = buffers.get(view.buffer.value()) else {
                return Err(missing(format!("{place}.buffer"), "buffer", view.buffer.value(), buffers.len()));
            };
            let (offset, length) = (view.byte_offset.map_or(0, |o| o.0), view.byte_length.0);
            let outside = |held: u64| {
                let cause = format!("bytes {offset} to {offset} + {length} lie outside its buffer of {held}");
                Fault::invalid(&place, cause)
            };
            let bytes = match decoded.get(i).and_then(Option::as_ref) {
                Some(decoded) => {
                    // Its own buffer may hold nothing, but says how much it would.
                    let said = root.buffers.get(view.buffer.value()).map_or(0, |b| b.byte_length.0);
                    if offset.checked_add(length).is_none_or(|end| end > said) {
                        return Err(outside(said));
                    }
                    decoded
                }
                None => slice(buffer, offset, length).ok_or_else(|| outside(buffer.len() as u64))?,
            };
            // Zero is how some exporters write "tightly packed".
            let stride = view.byte_stride.map(|s| s.0 as u64).filter(|&s| s != 0);
            views.push(View { bytes, offset, stride });
        }
        let mut data = Data { views, accessors: Vec::new() };
        let elsewhere = draco::accessors(root);
        // Each has a table of its own, and many may share their data.
        let mut replaced = 0_u64;
        for (i, sparse) in root.accessors.iter().enumerate().filter_map(|(i, a)| Some((i, a.sparse.as_ref()?))) {
            replaced = replaced.saturating_add(sparse.count.0);
            if replaced > limits.vertices {
                let place = format!("accessors[{i}].sparse.count");
                return Err(Fault::limit(place, "sparse elements of all accessors so far", replaced, limits.vertices));
            }
        }
        for (i, accessor) in root.accessors.iter().enumerate() {
            let elsewhere = elsewhere.get(i).copied().unwrap_or_default();
            let accessor = data.check(accessor, format!("accessors[{i}]"), elsewhere, limits, notices)?;
            data.accessors.push(accessor);
        }
        Ok(data)
    }

    /// The bytes of a buffer view that `place` refers to.
    pub(super) fn view<T>(&self, index: Index<T>, place: &str) -> Fallible<&'a [u8]> {
        self.find(index, place).map(|view| view.bytes)
    }

    fn find<T>(&self, index: Index<T>, place: &str) -> Fallible<&View<'a>> {
        self.views.get(index.value()).ok_or_else(|| missing(place, "buffer view", index.value(), self.views.len()))
    }

    /// The accessor that `place` refers to.
    pub(super) fn accessor<T>(&self, index: Index<T>, place: &str) -> Fallible<&Accessor<'a>> {
        self.accessors.get(index.value()).ok_or_else(|| missing(place, "accessor", index.value(), self.accessors.len()))
    }

    /// An accessor of its own on packed bytes, which must be as many as `count` elements; gives its index.
    pub(super) fn add(
        &mut self,
        place: String,
        count: u64,
        component: ComponentType,
        shape: Type,
        normalized: bool,
        bytes: &'a [u8],
    ) -> u32 {
        let stride = element_size(component, shape) as usize;
        let (bytes, sparse) = (Some(bytes), HashMap::new());
        self.accessors.push(Accessor { place, count, component, shape, normalized, bytes, stride, sparse });
        // A file of 2^32 accessors is longer than any that is read.
        (self.accessors.len() - 1) as u32
    }

    /// `elsewhere` says that the data is in a stream that the accessor does not name.
    fn check(
        &self,
        accessor: &gltf_json::Accessor,
        place: String,
        elsewhere: bool,
        limits: &Limits,
        notices: &mut Notices,
    ) -> Fallible<Accessor<'a>> {
        let Checked::Valid(component) = accessor.component_type else {
            return Err(Fault::invalid(format!("{place}.componentType"), "is not one of glTF's component types"));
        };
        let Checked::Valid(shape) = accessor.type_ else {
            return Err(Fault::invalid(format!("{place}.type"), "is not one of glTF's types"));
        };
        let component = component.0;
        let size = element_size(component, shape);
        let count = accessor.count.0;
        if count > limits.vertices {
            return Err(Fault::limit(format!("{place}.count"), "elements", count, limits.vertices));
        }
        // Without a view nothing in the file bounds the count.
        let without_data = limits.vertices.min(MOST_WITHOUT_DATA);
        if accessor.buffer_view.is_none() && !elsewhere && count > without_data {
            return Err(Fault::limit(format!("{place}.count"), "elements without a buffer view", count, without_data));
        }
        let offset = accessor.byte_offset.map_or(0, |o| o.0);
        let mut stride = size;
        let mut bytes = None;
        if let Some(index) = accessor.buffer_view {
            let view = self.find(index, &format!("{place}.bufferView"))?;
            let width = component.size() as u64;
            let total = view.offset.wrapping_add(offset);
            let unaligned = !offset.is_multiple_of(width) || !total.is_multiple_of(width);
            let what = "accessors do not begin at a multiple of their numbers' size; they were read where they begin";
            notices.count(NoticeKind::Repaired, what, unaligned.into(), &place);
            stride = view.stride.unwrap_or(size);
            if stride < size {
                let cause = format!("elements of {size} bytes do not fit the view's byteStride {stride}");
                return Err(Fault::invalid(place, cause));
            }
            // The last element need not be followed by the rest of its stride.
            let needed = if count == 0 { 0 } else { (count - 1).saturating_mul(stride).saturating_add(size) };
            bytes = Some(slice(view.bytes, offset, needed).ok_or_else(|| {
                let held = view.bytes.len();
                Fault::invalid(
                    &place,
                    format!("{count} elements from byte {offset} need {needed} bytes, its view has {held}"),
                )
            })?);
        }
        let sparse = match &accessor.sparse {
            Some(sparse) => self.sparse(sparse, &format!("{place}.sparse"), count, size, notices)?,
            None => HashMap::new(),
        };
        let normalized = accessor.normalized;
        let whole = matches!(component, ComponentType::F32 | ComponentType::U32);
        let what = "accessors are normalized but of a type that cannot be; where it matters they are read as they are";
        notices.count(NoticeKind::Repaired, what, (normalized && whole).into(), &place);
        let stride = usize::try_from(stride).map_err(|_| Fault::invalid(&place, "byteStride is too large"))?;
        Ok(Accessor { place, count, component, shape, normalized, bytes, stride, sparse })
    }

    fn sparse(
        &self,
        sparse: &gltf_json::accessor::sparse::Sparse,
        place: &str,
        count: u64,
        size: u64,
        notices: &mut Notices,
    ) -> Fallible<HashMap<u32, &'a [u8]>> {
        let replaced = sparse.count.0;
        if replaced > count {
            return Err(Fault::invalid(
                format!("{place}.count"),
                format!("{replaced} of {count} elements are replaced"),
            ));
        }
        let Checked::Valid(component) = sparse.indices.component_type else {
            let place = format!("{place}.indices.componentType");
            return Err(Fault::invalid(place, "is not an unsigned integer type"));
        };
        let part = |name: &str, view, offset: u64, size: u64| -> Fallible<&'a [u8]> {
            let place = format!("{place}.{name}");
            let bytes = self.view::<gltf_json::buffer::View>(view, &format!("{place}.bufferView"))?;
            slice(bytes, offset, replaced.saturating_mul(size))
                .ok_or_else(|| Fault::invalid(place, format!("{replaced} elements do not fit its buffer view")))
        };
        let (indices, values) = (&sparse.indices, &sparse.values);
        let width = component.0.size();
        let positions = part("indices", indices.buffer_view, indices.byte_offset.0, width as u64)?;
        let values = part("values", values.buffer_view, values.byte_offset.0, size)?;
        let mut map = HashMap::with_capacity(positions.len() / width);
        let (mut last, mut falling) = (None, 0);
        for (i, (at, value)) in positions.chunks_exact(width).zip(values.chunks_exact(size as usize)).enumerate() {
            let at = unsigned(at);
            if u64::from(at) >= count {
                let cause = format!("element {at} is to be replaced, there are {count}");
                return Err(Fault::invalid(format!("{place}.indices, number {i}"), cause));
            }
            falling += u64::from(last.is_some_and(|last| at <= last));
            last = Some(at);
            map.insert(at, value);
        }
        let what = "sparse indices do not rise; the last value for an element counts";
        notices.count(NoticeKind::Repaired, what, falling, place);
        Ok(map)
    }
}

impl Accessor<'_> {
    /// The bytes of one element; `None` for a zero or one that does not exist.
    fn element(&self, index: u32) -> Option<&[u8]> {
        if let Some(value) = self.sparse.get(&index) {
            return Some(value);
        }
        let start = (index as usize).checked_mul(self.stride)?;
        self.bytes?.get(start..)
    }

    /// The first `N` components of an element as numbers, normalized if the accessor says so; zero where there are none.
    pub(super) fn numbers<const N: usize>(&self, index: u32) -> [f32; N] {
        self.numbers_as(index, self.normalized)
    }

    /// As [`Accessor::numbers`], with integers normalized or not whatever the accessor says.
    pub(super) fn numbers_as<const N: usize>(&self, index: u32, normalized: bool) -> [f32; N] {
        let mut out = [0.0; N];
        if let Some(bytes) = self.element(index) {
            let width = self.component.size();
            let components = self.shape.multiplicity();
            for (value, bytes) in out.iter_mut().zip(bytes.chunks_exact(width)).take(components) {
                *value = number(bytes, self.component, normalized);
            }
        }
        out
    }

    /// The first component of an element of an unsigned type.
    pub(super) fn index(&self, index: u32) -> u32 {
        self.element(index).and_then(|bytes| bytes.get(..self.component.size())).map_or(0, unsigned)
    }

    /// Bytes of an element.
    pub(super) fn size(&self) -> u64 {
        element_size(self.component, self.shape)
    }

    /// What an element is, for messages: `VEC3 of F32`.
    pub(super) fn describe(&self) -> String {
        let normalized = if self.normalized { "normalized " } else { "" };
        format!("{:?} of {normalized}{:?}", self.shape, self.component)
    }
}

/// An index into nothing.
pub(super) fn missing(place: impl Into<String>, what: &str, index: usize, count: usize) -> Fault {
    Fault::invalid(place, format!("refers to {what} {index}, the file has {count}"))
}

pub(super) fn slice(bytes: &[u8], offset: u64, length: u64) -> Option<&[u8]> {
    let start = usize::try_from(offset).ok()?;
    let end = usize::try_from(offset.checked_add(length)?).ok()?;
    bytes.get(start..end)
}

/// Bytes of an element. The columns of a matrix start at multiples of 4 bytes.
fn element_size(component: ComponentType, shape: Type) -> u64 {
    let width = component.size() as u64;
    let column = |rows: u64| (rows * width).next_multiple_of(4);
    match shape {
        Type::Scalar => width,
        Type::Vec2 => 2 * width,
        Type::Vec3 => 3 * width,
        Type::Vec4 => 4 * width,
        Type::Mat2 => 2 * column(2),
        Type::Mat3 => 3 * column(3),
        Type::Mat4 => 4 * column(4),
    }
}

/// A little-endian unsigned integer of up to 4 bytes.
fn unsigned(bytes: &[u8]) -> u32 {
    bytes.iter().take(4).rev().fold(0, |value, &byte| value << 8 | u32::from(byte))
}

/// One component. Normalized integers follow glTF 2.0, 3.6.2.2.
fn number(bytes: &[u8], component: ComponentType, normalized: bool) -> f32 {
    let bits = unsigned(bytes);
    let (value, full) = match component {
        ComponentType::F32 => return f32::from_bits(bits),
        ComponentType::I8 => (f64::from(bits as u8 as i8), 127.0),
        ComponentType::U8 => (f64::from(bits), 255.0),
        ComponentType::I16 => (f64::from(bits as u16 as i16), 32_767.0),
        ComponentType::U16 => (f64::from(bits), 65_535.0),
        ComponentType::U32 => (f64::from(bits), f64::from(u32::MAX)),
    };
    if normalized { (value / full).max(-1.0) as f32 } else { value as f32 }
}
