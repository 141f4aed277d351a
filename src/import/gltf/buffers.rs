//! Buffers: the binary chunk, files, data URIs. All are read, used or not: a model that lacks a part says so at once.

use std::borrow::Cow;
use std::path::Path;

use gltf_json::Root;

use super::budget::Budget;
use super::{Fallible, Fault, ImportOptions, Notices, meshopt, uri};
use crate::import::Phase;
use crate::scene::NoticeKind;

/// The share of parsing that reading buffers is, where there are some outside the file.
pub(super) const SHARE: f32 = 0.5;

/// The bytes of every buffer, exactly `byteLength` each.
pub(super) fn read<'a>(
    root: &Root,
    binary: Option<&'a [u8]>,
    folder: Option<&Path>,
    budget: &Budget,
    options: &ImportOptions,
    notices: &mut Notices,
) -> Fallible<Vec<Cow<'a, [u8]>>> {
    let elsewhere = root.buffers.iter().filter(|buffer| buffer.uri.is_some());
    let total = elsewhere.fold(0_u64, |sum, buffer| sum.saturating_add(buffer.byte_length.0));
    let mut before = 0_u64;
    let mut buffers = Vec::new();
    let mut binary_used = false;
    for (i, buffer) in root.buffers.iter().enumerate() {
        let length = buffer.byte_length.0;
        let place = format!("buffers[{i}]");
        // Views of it are stored compressed, elsewhere.
        if buffer.uri.is_none() && meshopt::is_placeholder(buffer) {
            buffers.push(Cow::Borrowed(&[][..]));
            continue;
        }
        budget.take(length, &place)?;
        let (bytes, source) = match (&buffer.uri, binary) {
            (Some(uri), _) => {
                tell_kind(uri, &place, notices);
                let meanwhile = |read: u64| {
                    let share = (before as f64 + read as f64) / (total as f64).max(1.0);
                    options.progress.tell(Phase::Parsing, SHARE * share as f32);
                    options.cancel.go_on()
                };
                let bytes = uri::resolve(uri, &format!("{place}.uri"), folder, options.limits.bytes, &meanwhile)?;
                before = before.saturating_add(bytes.len() as u64);
                (Cow::Owned(bytes), "its data")
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
        let data = buffer.uri.as_ref().is_some_and(|uri| uri.starts_with("data:"));
        let what = "buffers in data URIs are longer than they say; the rest is ignored";
        notices.count(NoticeKind::Repaired, what, (data && held > length).into(), &place);
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

/// Tells a data URI that says it is something else than bytes.
fn tell_kind(uri: &str, place: &str, notices: &mut Notices) {
    let Some(rest) = uri.strip_prefix("data:") else { return };
    let kind = rest.split([';', ',']).next().unwrap_or_default();
    let odd = !matches!(kind, "" | "application/octet-stream" | "application/gltf-buffer");
    let what = "buffers in data URIs say that they are something else; they were read as bytes";
    notices.count(NoticeKind::Repaired, what, odd.into(), place);
}
