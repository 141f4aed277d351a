//! The header: which elements follow, how many, with which properties.

use crate::import::text::{first_word, name, words};
use crate::import::{Fallible, Fault};

/// How values are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    Little,
    Big,
}

/// The type of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    fn parse(word: &[u8]) -> Option<Scalar> {
        Some(match word {
            b"char" | b"int8" => Scalar::I8,
            b"uchar" | b"uint8" => Scalar::U8,
            b"short" | b"int16" => Scalar::I16,
            b"ushort" | b"uint16" => Scalar::U16,
            b"int" | b"int32" => Scalar::I32,
            b"uint" | b"uint32" => Scalar::U32,
            b"float" | b"float32" => Scalar::F32,
            b"double" | b"float64" => Scalar::F64,
            _ => return None,
        })
    }

    /// Bytes of one.
    pub(super) fn size(self) -> u64 {
        match self {
            Scalar::I8 | Scalar::U8 => 1,
            Scalar::I16 | Scalar::U16 => 2,
            Scalar::I32 | Scalar::U32 | Scalar::F32 => 4,
            Scalar::F64 => 8,
        }
    }

    /// What a colour channel is divided by: whole numbers are shares of the largest, except that wide ones hold bytes too.
    pub(super) fn full(self) -> f64 {
        match self {
            Scalar::F32 | Scalar::F64 => 1.0,
            Scalar::U16 => 65535.0,
            Scalar::I8 | Scalar::U8 | Scalar::I16 | Scalar::I32 | Scalar::U32 => 255.0,
        }
    }
}

/// A property of an element.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Property {
    pub(super) name: String,
    /// The type of a list's length; `None` for a single value.
    pub(super) length: Option<Scalar>,
    pub(super) scalar: Scalar,
}

/// A kind of element.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Element {
    pub(super) name: String,
    pub(super) count: u64,
    pub(super) properties: Vec<Property>,
}

impl Element {
    /// The fewest bytes that one takes.
    pub(super) fn smallest(&self, encoding: Encoding) -> u64 {
        match encoding {
            // A digit and white space.
            Encoding::Ascii => 2 * self.properties.len() as u64,
            _ => self.properties.iter().map(|p| p.length.unwrap_or(p.scalar).size()).sum(),
        }
    }
}

#[derive(Debug, PartialEq)]
pub(super) struct Header {
    pub(super) encoding: Encoding,
    pub(super) elements: Vec<Element>,
    /// What comments name as textures.
    pub(super) textures: Vec<String>,
}

/// More than this many lines is no header.
const MOST_LINES: usize = 10_000;

/// The header, and the bytes behind it.
pub(super) fn read(bytes: &[u8]) -> Fallible<(Header, &[u8])> {
    if !bytes.starts_with(b"ply") {
        return Err(Fault::invalid("header", "a PLY file begins with \"ply\""));
    }
    // Lines end as the first one does; in binary files what follows the last may look like the rest of a line's end.
    let end: &[u8] = match bytes.get(3..) {
        Some([b'\r', b'\n', ..]) => b"\r\n",
        Some([b'\r', ..]) => b"\r",
        _ => b"\n",
    };
    let mut rest = bytes;
    let mut header = Header { encoding: Encoding::Ascii, elements: Vec::new(), textures: Vec::new() };
    let mut format_known = false;
    for line_number in 1..=MOST_LINES {
        let Some(length) = rest.windows(end.len()).position(|w| w == end) else {
            // An ASCII file may have nothing behind its header, not even the end of the line.
            if rest.trim_ascii() == b"end_header" && format_known {
                return Ok((header, &[]));
            }
            return Err(Fault::invalid(format!("line {line_number}"), "the file ends before \"end_header\""));
        };
        let line = &rest[..length];
        rest = &rest[length + end.len()..];
        let Some((word, after)) = first_word(line) else { continue };
        let bad = |cause: &str| Fault::invalid(format!("line {line_number}"), cause);
        match word {
            b"ply" => {}
            b"format" => {
                header.encoding = match words(after).next() {
                    Some(b"ascii") => Encoding::Ascii,
                    Some(b"binary_little_endian") => Encoding::Little,
                    Some(b"binary_big_endian") => Encoding::Big,
                    _ => return Err(bad("a format that PLY does not have")),
                };
                format_known = true;
            }
            b"comment" | b"obj_info" => {
                if let Some((b"TextureFile", file)) = first_word(after) {
                    header.textures.push(name(file));
                }
            }
            b"element" => {
                let mut parts = words(after);
                let (Some(label), Some(count)) = (parts.next(), parts.next()) else {
                    return Err(bad("an element has a name and a count"));
                };
                let count = std::str::from_utf8(count).ok().and_then(|c| c.parse().ok());
                let count = count.ok_or_else(|| bad("the count of an element is no number"))?;
                header.elements.push(Element { name: name(label), count, properties: Vec::new() });
            }
            b"property" => {
                let property = property(after).ok_or_else(|| bad("a property that makes no sense"))?;
                let element = header.elements.last_mut().ok_or_else(|| bad("a property before any element"))?;
                element.properties.push(property);
            }
            b"end_header" if format_known => return Ok((header, rest)),
            b"end_header" => return Err(bad("no format was named")),
            _ => return Err(bad("a word that PLY headers do not have")),
        }
    }
    Err(Fault::invalid("header", format!("has more than {MOST_LINES} lines")))
}

fn property(text: &[u8]) -> Option<Property> {
    let mut parts = words(text);
    let first = parts.next()?;
    let (length, scalar) = if first == b"list" {
        (Some(Scalar::parse(parts.next()?)?), Scalar::parse(parts.next()?)?)
    } else {
        (None, Scalar::parse(first)?)
    };
    Some(Property { name: name(parts.next()?), length, scalar })
}
