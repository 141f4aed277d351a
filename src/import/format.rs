//! Which format a file has: by what is in it, then by its name.
//!
//! Names lie (an STL called `.obj`, a GLB called `.gltf`) and standard input has none, so content comes first. Three things
//! are certain: a GLB's and a PLY's first bytes, and that a binary STL is 84 bytes and 50 for each of the triangles that it
//! says it has. Whether it begins with "solid" says nothing, since many writers of binary files put that there. Text
//! is known by its first words. What no content tells, the extension does, unless the user named a converter for it; an OBJ
//! without a name is recognized by its statements.

use std::collections::BTreeMap;

use super::text::{first_word, lines};

/// The formats that are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Format {
    /// glTF 2.0, as text or binary.
    Gltf,
    /// Wavefront OBJ.
    Obj,
    /// STL, ASCII or binary.
    Stl,
    /// PLY, ASCII or binary.
    Ply,
}

/// So much of a file is looked at.
const HEAD: usize = 1 << 16;

/// Statements by which an OBJ is recognized.
const OBJ_WORDS: &[&str] = &["v", "vt", "vn", "vp", "f", "o", "g", "s", "usemtl", "mtllib", "l", "p"];

impl Format {
    /// What the user reads.
    pub(super) fn name(self) -> &'static str {
        match self {
            Format::Gltf => "glTF",
            Format::Obj => "OBJ",
            Format::Stl => "STL",
            Format::Ply => "PLY",
        }
    }

    /// The format of `bytes` from a file with this extension, in lower case; `None` if it is unknown or to be converted.
    pub(super) fn of(bytes: &[u8], extension: &str, converters: &BTreeMap<String, String>) -> Option<Format> {
        let named = Format::of_extension(extension);
        Format::certain(bytes).or(named).or_else(|| {
            let looks = || Format::likely(bytes);
            if converters.contains_key(extension) { None } else { looks() }
        })
    }

    fn of_extension(extension: &str) -> Option<Format> {
        match extension {
            "gltf" | "glb" => Some(Format::Gltf),
            "obj" => Some(Format::Obj),
            "stl" => Some(Format::Stl),
            "ply" => Some(Format::Ply),
            _ => None,
        }
    }

    fn certain(bytes: &[u8]) -> Option<Format> {
        let head = &bytes[..bytes.len().min(HEAD)];
        let text = without_mark(head).trim_ascii_start();
        let asset = || head.windows(7).any(|w| w == b"\"asset\"");
        if bytes.starts_with(b"glTF") || (text.starts_with(b"{") && asset()) {
            return Some(Format::Gltf);
        }
        if bytes.starts_with(b"ply\n") || bytes.starts_with(b"ply\r") {
            return Some(Format::Ply);
        }
        (is_binary_stl(bytes) || is_ascii_stl(bytes)).then_some(Format::Stl)
    }

    fn likely(bytes: &[u8]) -> Option<Format> {
        let head = &bytes[..bytes.len().min(HEAD)];
        if without_mark(head).trim_ascii_start().starts_with(b"{") {
            return Some(Format::Gltf);
        }
        if head.contains(&0) {
            return None;
        }
        // The last line may be cut.
        let words = lines(without_mark(head)).filter_map(|(_, line)| first_word(line)).map(|(word, _)| word);
        let mut words = words.filter(|word| !word.starts_with(b"#")).take(64).peekable();
        words.peek()?;
        let known = |word: &[u8]| OBJ_WORDS.iter().any(|w| w.as_bytes() == word);
        words.all(known).then_some(Format::Obj)
    }
}

/// Without the byte order mark of UTF-8.
pub(super) fn without_mark(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes)
}

/// How many triangles a binary STL says it has.
pub(super) fn stl_count(bytes: &[u8]) -> Option<u32> {
    let count = bytes.get(80..84)?;
    Some(u32::from_le_bytes(count.try_into().ok()?))
}

/// Whether the length is that of a binary STL.
pub(super) fn is_binary_stl(bytes: &[u8]) -> bool {
    stl_count(bytes).is_some_and(|count| 84 + 50 * u64::from(count) == bytes.len() as u64)
}

/// Whether it is text that begins as an ASCII STL and goes on as one.
pub(super) fn is_ascii_stl(bytes: &[u8]) -> bool {
    let head = &bytes[..bytes.len().min(HEAD)];
    let text = without_mark(head).trim_ascii_start();
    let solid = text.get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
    let ends = text.get(5).is_none_or(u8::is_ascii_whitespace);
    let holds = |word: &[u8]| head.windows(word.len()).any(|w| w.eq_ignore_ascii_case(word));
    solid && ends && !head.contains(&0) && (holds(b"facet") || holds(b"endsolid"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(bytes: &[u8], extension: &str) -> Option<Format> {
        Format::of(bytes, extension, &BTreeMap::new())
    }

    #[test]
    fn content_comes_before_the_name() {
        let mut stl = b"solid of many writers".to_vec();
        stl.resize(80, b' ');
        stl.extend(1_u32.to_le_bytes());
        stl.resize(84 + 50, 0);
        for extension in ["", "obj", "glb", "ply", "stl", "step"] {
            assert_eq!(of(&stl, extension), Some(Format::Stl), "{extension}");
            assert_eq!(of(b"glTF\x02", extension), Some(Format::Gltf), "{extension}");
            assert_eq!(of(b" {\"asset\": {}}", extension), Some(Format::Gltf), "{extension}");
            assert_eq!(of(b"ply\r\nformat ascii 1.0", extension), Some(Format::Ply), "{extension}");
            assert_eq!(of(b"SOLID a\n facet normal", extension), Some(Format::Stl), "{extension}");
        }
        stl.push(0);
        assert_eq!(of(&stl, ""), None, "of another length it is no binary STL");
        assert_eq!(of(&stl, "stl"), Some(Format::Stl), "unless its name says so");
    }

    #[test]
    fn an_obj_is_known_by_its_statements_and_strangers_are_not_known() {
        assert_eq!(of(b"# made\n\nv 0 0 0\r\nvn 0 0 1", ""), Some(Format::Obj));
        assert_eq!(of(b"v 0 0 0\nsome prose", ""), None);
        assert_eq!(of(b"ISO-10303-21;\nHEADER;", "step"), None);
        assert_eq!(of(b"ISO-10303-21;\nHEADER;", "obj"), Some(Format::Obj), "its name says so");
        assert_eq!(of(b"", ""), None);
        assert_eq!(of(b"# only a comment", ""), None);
    }

    #[test]
    fn a_converter_takes_what_only_looks_like_something() {
        let converters = BTreeMap::from([("poly".to_owned(), "x {in} {out}".to_owned())]);
        assert_eq!(Format::of(b"v 0 0 0", "poly", &converters), None);
        assert_eq!(Format::of(b"glTF", "poly", &converters), Some(Format::Gltf));
    }
}
