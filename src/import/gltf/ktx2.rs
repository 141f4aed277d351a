//! KHR_texture_basisu: KTX2 images in the Basis Universal codecs, to RGBA.
//!
//! The extension allows two codecs: ETC1S, a palette of 4×4 blocks that is packed once more (BasisLZ), and UASTC, 16
//! bytes for each 4×4 block, stored or packed by Zstandard. `basisu` (Apache-2.0, pure Rust) unpacks both, as Basis' own
//! transcoder does. Its container parser is lenient with sizes, so everything that says how much is going to be allocated is
//! checked here first, from the KTX2 specification: magic, sizes, levels, one layer, one face, one depth, the level's length and
//! how long it says it becomes. Only the largest level is decoded; smaller ones are made anew on upload like all others'.
//!
//! Like [`draco`](super::draco), the crate is young: should it panic on a damaged file, that becomes an error.

use std::panic::{AssertUnwindSafe, catch_unwind};

use basisu::{DecodeFlags, SourceFormat, TargetFormat, Transcoder};

use super::{Fallible, Fault, Limits};

const MAGIC: &[u8] = &[0xAB, b'K', b'T', b'X', b' ', b'2', b'0', 0xBB, b'\r', b'\n', 0x1A, b'\n'];
/// Bytes before the level index.
const HEADER: usize = 80;

/// Whether the bytes begin as a KTX2 file.
pub(super) fn is_ktx2(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC)
}

fn word(bytes: &[u8], at: usize) -> Option<u64> {
    Some(u32::from_le_bytes(bytes.get(at..at.checked_add(4)?)?.try_into().ok()?).into())
}

fn long(bytes: &[u8], at: usize) -> Option<u64> {
    Some(u64::from_le_bytes(bytes.get(at..at.checked_add(8)?)?.try_into().ok()?))
}

/// Width and height in pixels, after checking everything that the decoder would allocate by.
pub(super) fn check(bytes: &[u8], place: &str, limits: &Limits) -> Fallible<(u32, u32)> {
    let bad = |cause: String| Fault::invalid(place, cause);
    let cut = || bad("its KTX2 header is cut off".to_owned());
    let number = |at| word(bytes, at).ok_or_else(cut);
    let [format, width, height, depth] = [number(12)?, number(20)?, number(24)?, number(28)?];
    let [layers, faces, levels, packing] = [number(32)?, number(36)?, number(40)?, number(44)?];
    if format != 0 {
        return Err(bad(format!("is a KTX2 file of Vulkan's format {format}: Basis Universal is read")));
    }
    if depth > 1 || layers > 1 || faces != 1 {
        return Err(bad("is a KTX2 file of more than one image".to_owned()));
    }
    let side = width.max(height);
    if side > limits.image_side.into() {
        return Err(Fault::limit(place, "pixels of width or height", side, limits.image_side.into()));
    }
    if width.min(height) == 0 {
        return Err(bad("has no pixels".to_owned()));
    }
    if levels > 32 {
        return Err(bad(format!("says it has {levels} levels")));
    }
    let size = bytes.len() as u64;
    let inside = |offset: u64, length: u64| offset.checked_add(length).is_some_and(|end| end <= size);
    for level in 0..levels.max(1) {
        let at = HEADER + 24 * level as usize;
        let read = |at| long(bytes, at).ok_or_else(cut);
        let (offset, length, unpacked) = (read(at)?, read(at + 8)?, read(at + 16)?);
        if !inside(offset, length) {
            return Err(bad(format!("bytes {offset} to {offset} + {length} of level {level} lie outside the file")));
        }
        // 16 bytes a block; nothing that is unpacked may be longer.
        let blocks = |side: u64| (side >> level).max(1).div_ceil(4);
        let most = blocks(width) * blocks(height) * 16;
        if packing == 2 && unpacked != most {
            return Err(bad(format!("level {level} is to become {unpacked} bytes; its blocks are {most}")));
        }
    }
    for (what, at) in [("data format", 48), ("key and value", 56)] {
        if !inside(number(at)?, number(at + 4)?) {
            return Err(bad(format!("its {what} data lie outside the file")));
        }
    }
    let (offset, length) = (long(bytes, 64).ok_or_else(cut)?, long(bytes, 72).ok_or_else(cut)?);
    if !inside(offset, length) {
        return Err(bad("its global data lie outside the file".to_owned()));
    }
    // Checked: both are at most `image_side`.
    Ok((width as u32, height as u32))
}

/// The largest level of a file that was checked, as RGBA.
pub(super) fn decode(bytes: &[u8], place: &str, limits: &Limits) -> Fallible<(u32, u32, Vec<u8>)> {
    let (width, height) = check(bytes, place, limits)?;
    let bad = |cause: &str| Fault::invalid(place, format!("cannot be decoded: {cause}"));
    let decoded = catch_unwind(AssertUnwindSafe(|| {
        let texture = Transcoder::new(bytes).map_err(|_| "is not a whole Basis Universal texture in KTX2")?;
        if !matches!(texture.source_format(), SourceFormat::Etc1s | SourceFormat::UastcLdr) {
            return Err("its codec is neither ETC1S nor UASTC, which are what glTF allows");
        }
        texture.transcode(0, TargetFormat::Rgba32, DecodeFlags::NONE).map_err(|_| "its first level is damaged")
    }));
    let rgba = match decoded {
        Ok(Ok(rgba)) => rgba,
        Ok(Err(cause)) => return Err(bad(cause)),
        Err(_) => return Err(bad("it is damaged, and its decoder gave up")),
    };
    if rgba.len() as u64 != 4 * u64::from(width) * u64::from(height) {
        return Err(bad("its first level has another size than its header"));
    }
    Ok((width, height, rgba))
}
