//! Buffers: the binary chunk, files, data URIs. All are read, used or not: a model that lacks a part says so at once.

use std::borrow::Cow;
use std::path::Path;

use gltf_json::Root;

use super::{Fallible, Fault, Limits, Notices, uri};

/// The bytes of every buffer, exactly `byteLength` each.
pub(super) fn read<'a>(
    root: &Root,
    binary: Option<&'a [u8]>,
    folder: Option<&Path>,
    limits: &Limits,
    notices: &mut Notices,
) -> Fallible<Vec<Cow<'a, [u8]>>> {
    let mut buffers = Vec::new();
    let mut total = 0_u64;
    let mut binary_used = false;
    for (i, buffer) in root.buffers.iter().enumerate() {
        let length = buffer.byte_length.0;
        let place = format!("buffers[{i}]");
        total = total.saturating_add(length);
        if total > limits.bytes {
            return Err(Fault::limit(place, "bytes of buffers", total, limits.bytes));
        }
        let (bytes, source) = match (&buffer.uri, binary) {
            (Some(uri), _) => {
                (Cow::Owned(uri::resolve(uri, &format!("{place}.uri"), folder, limits.bytes)?), "its data")
            }
            (None, Some(chunk)) if i == 0 => {
                binary_used = true;
                // A chunk is padded to a multiple of 4.
                if chunk.len() as u64 > length.saturating_add(3) {
                    let surplus = chunk.len() as u64 - length;
                    notices.repaired(format!("{place}: the binary chunk is {surplus} bytes longer than byteLength"));
                }
                (Cow::Borrowed(chunk), "the binary chunk")
            }
            (None, _) => return Err(Fault::invalid(place, "has no uri, and there is no binary chunk for it")),
        };
        let held = bytes.len() as u64;
        if held < length {
            let place = format!("{place}.byteLength");
            return Err(Fault::invalid(place, format!("is {length}, {source} has {held} bytes")));
        }
        // Checked: length ≤ held, which is a usize.
        let length = length as usize;
        buffers.push(match bytes {
            Cow::Borrowed(bytes) => Cow::Borrowed(&bytes[..length]),
            Cow::Owned(mut bytes) => {
                bytes.truncate(length);
                Cow::Owned(bytes)
            }
        });
    }
    if binary.is_some_and(|chunk| !chunk.is_empty()) && !binary_used {
        notices.ignored("the GLB's binary chunk belongs to no buffer".to_owned());
    }
    Ok(buffers)
}
