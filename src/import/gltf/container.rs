//! The outer shell: a GLB's chunks, or a text file as it is.

use super::{Fallible, Fault, Notices};

/// The JSON text and the binary chunk, if there is one.
#[derive(Debug)]
pub(super) struct Parts<'a> {
    pub(super) json: &'a [u8],
    pub(super) binary: Option<&'a [u8]>,
}

const JSON: u32 = 0x4E4F_534A;
const BIN: u32 = 0x004E_4942;

/// Finds the JSON and the binary chunk. Which of the two forms a file has is told by its first bytes, not its name.
pub(super) fn split<'a>(bytes: &'a [u8], notices: &mut Notices) -> Fallible<Parts<'a>> {
    if bytes.is_empty() {
        return Err(Fault::invalid("file", "is empty"));
    }
    if bytes.starts_with(b"glTF") {
        return chunks(bytes, notices);
    }
    let json = match bytes.strip_prefix(b"\xEF\xBB\xBF") {
        Some(rest) => {
            notices.repaired("the file starts with a byte order mark, which was skipped".to_owned());
            rest
        }
        None => bytes,
    };
    if json.iter().find(|b| !b.is_ascii_whitespace()) != Some(&b'{') {
        return Err(Fault::invalid("file", "is neither a GLB (it does not start with \"glTF\") nor a JSON object"));
    }
    Ok(Parts { json, binary: None })
}

fn word(bytes: &[u8], at: u64) -> Option<u32> {
    let at = usize::try_from(at).ok()?;
    Some(u32::from_le_bytes(bytes.get(at..at.checked_add(4)?)?.try_into().ok()?))
}

fn chunks<'a>(bytes: &'a [u8], notices: &mut Notices) -> Fallible<Parts<'a>> {
    let size = bytes.len() as u64;
    let (Some(version), Some(length)) = (word(bytes, 4), word(bytes, 8)) else {
        return Err(Fault::invalid("GLB header", format!("ends after {size} of 12 bytes")));
    };
    if version != 2 {
        return Err(Fault::invalid("GLB header", format!("version {version}: version 2 is read")));
    }
    if u64::from(length) != size {
        return Err(Fault::invalid("GLB header", format!("says {length} bytes, the file has {size}")));
    }
    let (mut json, mut binary) = (None, None);
    let mut at = 12_u64;
    let mut index = 0_u64;
    while at < size {
        let place = format!("GLB chunk {index}");
        let (Some(length), Some(kind)) = (word(bytes, at), word(bytes, at + 4)) else {
            return Err(Fault::invalid(place, "its header is cut off"));
        };
        let start = at + 8;
        let end = start + u64::from(length);
        let Some(content) = bytes.get(start as usize..end.min(usize::MAX as u64) as usize) else {
            return Err(Fault::invalid(place, format!("has {length} bytes, {} are left", size - start)));
        };
        if length % 4 != 0 {
            notices.repaired(format!("{place}: its length {length} is not a multiple of 4"));
        }
        match (index, kind) {
            (0, JSON) => json = Some(content),
            (0, _) => return Err(Fault::invalid(place, "the first chunk must be JSON")),
            (1, BIN) => binary = Some(content),
            (_, JSON | BIN) => return Err(Fault::invalid(place, "a second JSON chunk, or a BIN chunk out of place")),
            _ => notices.ignored(format!("{place}: chunks of type {kind:#010x} are not known")),
        }
        at = end;
        index += 1;
    }
    let Some(mut json) = json else {
        return Err(Fault::invalid("GLB", "has no JSON chunk"));
    };
    // Some exporters pad with zeros instead of spaces.
    while let Some(rest) = json.strip_suffix(b"\0") {
        json = rest;
    }
    Ok(Parts { json, binary })
}
