//! EXT_meshopt_compression and KHR_meshopt_compression: buffer views that are stored compressed.
//!
//! A view with the extension has its content in a stream elsewhere: vertices as differences of bytes (`ATTRIBUTES`),
//! triangle lists by what the last edges and vertices were (`TRIANGLES`), other indices as differences (`INDICES`). A
//! filter may follow, which makes unit vectors of two components, quaternions of three, floats of a shared exponent, or
//! RGBA of YCoCg. What comes out is as long as the view says, and accessors read it as if it had been stored so. The
//! view's own buffer may be a placeholder without data (`fallback`).
//!
//! Sources: the two extensions' specifications at Khronos. The streams are decoded by `meshoptimizer-rs`, a port of
//! Kapoulkine's library (MIT) in safe Rust, with its vector code left out; it checks streams against their
//! length before it allocates and returns errors for bad ones. Everything that the file says about a stream is checked
//! here first, and charged to the file's budget. Where we differ:
//!
//! - A view is always decoded, though a file that only *uses* the extension may bring the same data uncompressed: one way
//!   through the code instead of two.
//! - The EXT extension knows version 0 of the vertex codec only; version 1 and the colour filter came with KHR. Both
//!   are read under either name, and told under the older one.
//! - Octahedral vectors of zeros have no direction, and C++ leaves open what becomes of them. They become +z, and are told.

use gltf_json::Root;
use meshoptimizer_rs::codec;
use meshoptimizer_rs::{Error, Limits as CodecLimits, Workspace};
use rayon::prelude::*;
use serde::Deserialize;

use super::accessor::slice;
use super::budget::Budget;
use super::steps::{Steps, settle};
use super::{Fallible, Fault, ImportOptions, Notices};
use crate::import::Phase;
use crate::scene::NoticeKind;

/// Both names; the newer one is preferred.
const NAMES: [&str; 2] = ["KHR_meshopt_compression", "EXT_meshopt_compression"];

/// The extension's object in a buffer view.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Stored {
    buffer: u64,
    #[serde(default)]
    byte_offset: u64,
    byte_length: u64,
    byte_stride: u64,
    count: u64,
    mode: String,
    #[serde(default)]
    filter: Option<String>,
}

#[derive(Clone, Copy, PartialEq)]
enum Mode {
    Attributes,
    Triangles,
    Indices,
}

#[derive(Clone, Copy, PartialEq)]
enum Filter {
    None,
    Octahedral,
    Quaternion,
    Exponential,
    Color,
}

/// A stream with what is to come out of it, checked.
struct Stream<'a> {
    view: usize,
    place: String,
    newer: bool,
    bytes: &'a [u8],
    mode: Mode,
    filter: Filter,
    count: usize,
    stride: usize,
}

/// Whether a buffer holds nothing: views of it are stored elsewhere.
pub(super) fn is_placeholder(buffer: &gltf_json::Buffer) -> bool {
    let object = |name| buffer.extensions.as_ref().and_then(|e| e.others.get(name));
    NAMES.into_iter().filter_map(object).any(|o| o.get("fallback").and_then(|f| f.as_bool()) == Some(true))
}

fn object(view: &gltf_json::buffer::View) -> Option<(&'static str, &serde_json::Value)> {
    let others = &view.extensions.as_ref()?.others;
    NAMES.into_iter().find_map(|name| Some((name, others.get(name)?)))
}

/// The content of each buffer view that is stored compressed, by view.
pub(super) fn decode<B: AsRef<[u8]>>(
    root: &Root,
    buffers: &[B],
    budget: &Budget,
    options: &ImportOptions,
    notices: &mut Notices,
) -> Fallible<Vec<Option<Vec<u8>>>> {
    let mut streams = Vec::new();
    for (i, view) in root.buffer_views.iter().enumerate() {
        if let Some((name, object)) = object(view) {
            let place = format!("bufferViews[{i}].extensions.{name}");
            let stored = Stored::deserialize(object).map_err(|e| Fault::invalid(&place, e.to_string()))?;
            let stream = check(view, i, name == NAMES[0], &stored, buffers, place)?;
            budget.take((stream.count * stream.stride) as u64, &stream.place)?;
            streams.push(stream);
        }
    }
    let begin = if root.buffers.iter().any(|buffer| buffer.uri.is_some()) { super::buffers::SHARE } else { 0.0 };
    let steps = Steps::new(options, Phase::Parsing, [begin, 1.0], streams.len());
    let decoded: Vec<Fallible<(Vec<u8>, Notices)>> =
        streams.par_iter().map(|stream| steps.each(|| stream.decode())).collect();
    let mut views: Vec<Option<Vec<u8>>> = vec![None; root.buffer_views.len()];
    for (stream, (bytes, told)) in streams.iter().zip(settle(decoded)?) {
        notices.append(told);
        views[stream.view] = Some(bytes);
    }
    Ok(views)
}

/// Checks what a file says of a stream, before anything is made of it.
fn check<'a, B: AsRef<[u8]>>(
    view: &gltf_json::buffer::View,
    index: usize,
    newer: bool,
    stored: &Stored,
    buffers: &'a [B],
    place: String,
) -> Fallible<Stream<'a>> {
    let wrong = |member: &str, cause: String| Err(Fault::invalid(format!("{place}.{member}"), cause));
    let mode = match stored.mode.as_str() {
        "ATTRIBUTES" => Mode::Attributes,
        "TRIANGLES" => Mode::Triangles,
        "INDICES" => Mode::Indices,
        other => return wrong("mode", format!("{other:?} is none of ATTRIBUTES, TRIANGLES and INDICES")),
    };
    let filter = match stored.filter.as_deref() {
        None | Some("NONE") => Filter::None,
        Some("OCTAHEDRAL") => Filter::Octahedral,
        Some("QUATERNION") => Filter::Quaternion,
        Some("EXPONENTIAL") => Filter::Exponential,
        Some("COLOR") => Filter::Color,
        Some(other) => return wrong("filter", format!("{other:?} is not a filter of the extension")),
    };
    let Some(buffer) = usize::try_from(stored.buffer).ok().and_then(|i| buffers.get(i)) else {
        let cause = format!("refers to buffer {}, the file has {}", stored.buffer, buffers.len());
        return wrong("buffer", cause);
    };
    let buffer = buffer.as_ref();
    let Some(bytes) = slice(buffer, stored.byte_offset, stored.byte_length) else {
        let (offset, length) = (stored.byte_offset, stored.byte_length);
        let cause = format!("bytes {offset} to {offset} + {length} lie outside its buffer of {}", buffer.len());
        return wrong("byteLength", cause);
    };
    let stride = stored.byte_stride;
    let fits = match mode {
        Mode::Attributes => (4..=256).contains(&stride) && stride.is_multiple_of(4),
        Mode::Triangles | Mode::Indices => stride == 2 || stride == 4,
    };
    if !fits {
        return wrong("byteStride", format!("{stride} does not go with {}", stored.mode));
    }
    let filter_fits = match filter {
        Filter::None => true,
        _ if mode != Mode::Attributes => false,
        Filter::Octahedral | Filter::Color => stride == 4 || stride == 8,
        Filter::Quaternion => stride == 8,
        Filter::Exponential => true,
    };
    if !filter_fits {
        let filter = stored.filter.as_deref().unwrap_or_default();
        return wrong("filter", format!("{filter} does not go with {} of {stride} bytes", stored.mode));
    }
    if mode == Mode::Triangles && !stored.count.is_multiple_of(3) {
        return wrong("count", format!("{} indices are not whole triangles", stored.count));
    }
    let total = stored.count.checked_mul(stride);
    if total != Some(view.byte_length.0) {
        let cause = format!("{} elements of {stride} bytes are not the view's {}", stored.count, view.byte_length.0);
        return wrong("count", cause);
    }
    let view_stride = view.byte_stride.map_or(stride, |s| s.0 as u64);
    if mode == Mode::Attributes && view_stride != stride && view_stride != 0 {
        return wrong("byteStride", format!("is {stride}, that of the view is {view_stride}"));
    }
    let (Ok(count), Ok(stride)) = (usize::try_from(stored.count), usize::try_from(stride)) else {
        return wrong("count", format!("{} elements are more than can be addressed", stored.count));
    };
    Ok(Stream { view: index, place: place.clone(), newer, bytes, mode, filter, count, stride })
}

impl Stream<'_> {
    fn decode(&self) -> Fallible<(Vec<u8>, Notices)> {
        let mut notices = Notices::default();
        if self.count == 0 {
            return Ok((Vec::new(), notices));
        }
        let bad = |cause: String| Fault::invalid(&self.place, cause);
        let fail = |error: Error| match error {
            Error::InvalidStream => bad("the stream is malformed or cut off".to_owned()),
            Error::UnsupportedVersion => bad("the stream is of a version that is not known".to_owned()),
            other => bad(format!("the stream cannot be decoded: {other}")),
        };
        // What it holds is the output, which was charged; the work is bounded by both lengths.
        let most = self.count * self.stride;
        let work = (most as u64).saturating_add(self.bytes.len() as u64).saturating_mul(4);
        let mut workspace = Workspace::new(CodecLimits { max_bytes: most.saturating_mul(2), max_work: work });
        let (count, stride, bytes) = (self.count, self.stride, self.bytes);
        let mut out = match self.mode {
            Mode::Attributes => codec::decode_vertex_buffer(count, stride, bytes, &mut workspace),
            Mode::Triangles => codec::decode_index_buffer(count, stride, bytes, &mut workspace),
            Mode::Indices => codec::decode_index_sequence(count, stride, bytes, &mut workspace),
        }
        .map_err(fail)?;
        if self.filter == Filter::Octahedral {
            let directionless = give_direction(&mut out, stride);
            let what = "compressed unit vectors were zero and became +z";
            notices.count(NoticeKind::Repaired, what, directionless, &self.place);
        }
        match self.filter {
            Filter::None => {}
            Filter::Octahedral => codec::decode_filter_oct(&mut out, count, stride, &mut workspace).map_err(fail)?,
            Filter::Quaternion => codec::decode_filter_quat(&mut out, count, stride, &mut workspace).map_err(fail)?,
            Filter::Exponential => codec::decode_filter_exp(&mut out, count, stride, &mut workspace).map_err(fail)?,
            Filter::Color => codec::decode_filter_color(&mut out, count, stride, &mut workspace).map_err(fail)?,
        }
        let newer = self.filter == Filter::Color
            || (self.mode == Mode::Attributes && codec::decode_vertex_version(bytes).is_ok_and(|v| v > 0));
        let what =
            "buffer views under EXT_meshopt_compression use what only KHR_meshopt_compression has, and were read";
        notices.count(NoticeKind::Repaired, what, (newer && !self.newer).into(), &self.place);
        Ok((out, notices))
    }
}

/// Sets the third component of octahedral vectors that have none but zeros, so that they point along +z.
fn give_direction(bytes: &mut [u8], stride: usize) -> u64 {
    let width = stride / 4;
    let mut count = 0;
    for vector in bytes.chunks_exact_mut(stride) {
        if vector.iter().take(3 * width).all(|&b| b == 0)
            && let Some(z) = vector.get_mut(2 * width)
        {
            *z = 1;
            count += 1;
        }
    }
    count
}
