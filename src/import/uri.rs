//! References to other data: `data:` URIs, and files confined to the model's folder.
//!
//! A model may come from a stranger, so a reference must not reach out of its folder: no scheme, no absolute path, no
//! `..`, no symbolic link that leads out, and what is opened must be a plain file.

use std::borrow::Cow;
use std::path::{Component, Path};

use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};

use super::source::{self, Meanwhile};
use super::{Fallible, Fault};

/// Base64 with or without its padding.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &STANDARD,
    GeneralPurposeConfig::new()
        .with_decode_padding_mode(DecodePaddingMode::Indifferent)
        .with_decode_allow_trailing_bits(true),
);

/// The bytes that `uri`, found at `place`, stands for.
pub(super) fn resolve(
    uri: &str,
    place: &str,
    folder: Option<&Path>,
    limit: u64,
    meanwhile: Meanwhile,
) -> Fallible<Vec<u8>> {
    if uri.get(..5).is_some_and(|scheme| scheme.eq_ignore_ascii_case("data:")) {
        return data(&uri[5..], place, limit);
    }
    let path = percent_encoding::percent_decode_str(uri).decode_utf8();
    let path =
        path.map_err(|_| Fault::invalid(place, format!("{:?} is not UTF-8 after percent-decoding", short(uri))))?;
    file(&path, place, folder, limit, meanwhile)
}

/// So much of a reference is shown in errors.
fn short(reference: &str) -> String {
    reference.chars().take(200).collect()
}

/// The bytes of the file at `path`, found at `place` and written as in the file system, in `folder` or below.
pub(super) fn file(
    path: &str,
    place: &str,
    folder: Option<&Path>,
    limit: u64,
    meanwhile: Meanwhile,
) -> Fallible<Vec<u8>> {
    let shown = short(path);
    let refuse = |cause: &str| Fault::invalid(place, format!("{shown:?} {cause}"));
    // Windows exporters write backslashes.
    let path = path.replace('\\', "/");
    if path.is_empty() || path.contains('\0') {
        return Err(refuse("is not a path"));
    }
    if path.split('/').next().is_some_and(|first| first.contains(':')) {
        return Err(refuse("has a scheme or drive: only files in the model's folder are read"));
    }
    let relative = Path::new(&path);
    if !relative.components().all(|c| matches!(c, Component::Normal(_) | Component::CurDir)) {
        return Err(refuse("leads out of the model's folder"));
    }
    let Some(folder) = folder else {
        return Err(refuse("refers to a file, but the model was not read from a folder"));
    };
    let io = |source| Fault::Io { place: format!("{place} {shown:?}"), source };
    let folder = folder.canonicalize().map_err(io)?;
    let full = folder.join(relative).canonicalize().map_err(io)?;
    if !full.starts_with(&folder) {
        return Err(refuse("is a link that leads out of the model's folder"));
    }
    source::read_plain(&full, limit, &format!("{place} {shown:?}"), meanwhile)
}

/// The part of a data URI after `data:`.
fn data(rest: &str, place: &str, limit: u64) -> Fallible<Vec<u8>> {
    let Some((kind, content)) = rest.split_once(',') else {
        return Err(Fault::invalid(place, "a data URI without a comma"));
    };
    if content.len() as u64 > limit.saturating_mul(3) {
        return Err(Fault::limit(place, "characters", content.len() as u64, limit.saturating_mul(3)));
    }
    let decoded: Cow<[u8]> = percent_encoding::percent_decode_str(content).into();
    let base64 = kind.rsplit(';').next().is_some_and(|last| last.eq_ignore_ascii_case("base64"));
    if !base64 {
        return Ok(decoded.into_owned());
    }
    BASE64.decode(decoded).map_err(|e| Fault::invalid(place, format!("base64 data: {e}")))
}
