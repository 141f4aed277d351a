//! What of each format is read, as a table: for `pellucid formats`, for `docs/formats.md`, and for whoever asks.
//!
//! Rows come from the readers themselves where they have lists (glTF's extensions, the faults that its validator knows), and
//! stand here where they do not. `docs/formats.md` is written from it and a test holds both against each other; with
//! `PELLUCID_UPDATE_DOCS` set the test writes the file anew.

use std::fmt::Write;

use super::gltf;
use super::gltf::validator::{Handling, ISSUES};

/// What happens to a feature of a format.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Treatment {
    /// It is shown as the file means it.
    Read,
    /// Something like it is shown, with a notice.
    Approximated,
    /// It is left out, with a notice.
    Ignored,
    /// A file that cannot do without it is refused.
    Refused,
}

impl Treatment {
    /// In words.
    pub fn name(self) -> &'static str {
        match self {
            Treatment::Read => "read",
            Treatment::Approximated => "approximated",
            Treatment::Ignored => "ignored with a notice",
            Treatment::Refused => "refused",
        }
    }
}

/// One row.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Feature {
    /// The format, as people call it.
    pub format: &'static str,
    /// The feature: an extension's name, or a few words.
    pub feature: &'static str,
    /// What happens to it.
    pub treatment: Treatment,
    /// More about that; may be empty.
    pub note: &'static str,
}

/// All rows, format by format.
pub fn table() -> Vec<Feature> {
    let others = OTHERS.iter().map(|&(format, feature, treatment, note)| Feature { format, feature, treatment, note });
    gltf::features().into_iter().chain(others).collect()
}

/// Rows of the formats without lists of their own.
const OTHERS: &[(&str, &str, Treatment, &str)] = {
    use Treatment::{Approximated, Ignored, Read, Refused};
    &[
        ("OBJ", "polygons", Read, "concave ones too; triangulated in their plane"),
        ("OBJ", "negative indices, continued lines, bytes that are not UTF-8", Read, ""),
        ("OBJ", "indices that point nowhere", Refused, "with the number of the line"),
        ("OBJ", "objects and groups", Read, "parts; without them connected components are"),
        ("OBJ", "smoothing groups", Read, "where there are no normals"),
        ("OBJ", "colours behind vertices", Read, "as sRGB"),
        ("OBJ", "coordinates far from the origin", Read, "in double precision, and re-based"),
        (
            "OBJ",
            "materials (MTL)",
            Approximated,
            "Phong's terms become metalness and roughness, without a notice for each",
        ),
        ("OBJ", "material files and textures that are missing", Ignored, "the model is shown without"),
        ("OBJ", "points, lines, curves, surfaces of higher order", Ignored, "only polygons are shown"),
        ("STL", "ASCII and binary", Read, "told apart by length"),
        ("STL", "normals of facets", Approximated, "computed from welded triangles, with a crease angle"),
        ("STL", "solids of an ASCII file", Read, "parts; a single one is divided into connected components"),
        ("STL", "coordinates far from the origin", Read, "as exact as their 32 bits; moved to the origin"),
        ("STL", "colours in the attribute bytes", Ignored, "two dialects contradict each other"),
        ("PLY", "ASCII, binary of both byte orders", Read, ""),
        ("PLY", "polygons and triangle strips", Read, ""),
        ("PLY", "normals, texture coordinates", Read, ""),
        ("PLY", "colours of vertices and faces", Read, "as sRGB"),
        ("PLY", "coordinates in double precision", Read, "re-based where they lie far from the origin"),
        ("PLY", "other elements and properties", Ignored, ""),
        ("all others", "STEP, IGES, FBX, USD and so on", Refused, "unless the configuration names a converter"),
    ]
};

/// The table as plain text, a row a line.
pub fn text() -> String {
    let rows = table();
    let width = |of: fn(&Feature) -> &str| rows.iter().map(|r| of(r).chars().count()).max().unwrap_or_default();
    let (format, feature) = (width(|r| r.format), width(|r| r.feature));
    let mut out = String::new();
    for row in &rows {
        // Writing to a string cannot fail.
        let _ = writeln!(
            out,
            "{:format$}  {:feature$}  {:21}  {}",
            row.format,
            row.feature,
            row.treatment.name(),
            row.note
        );
    }
    out.lines().map(|line| format!("{}\n", line.trim_end())).collect()
}

/// `docs/formats.md`.
pub fn markdown() -> String {
    let mut out = String::from(
        "# What is read of each format\n\nWritten by `pellucid formats --markdown`; a test holds it against the program. \
         Whatever is approximated, ignored or mended is told when the file is loaded.\n",
    );
    let mut format = "";
    for row in table() {
        if row.format != format {
            format = row.format;
            let _ = write!(out, "\n## {format}\n\n| feature | what happens | |\n|---|---|---|\n");
        }
        let _ = writeln!(out, "| {} | {} | {} |", row.feature, row.treatment.name(), row.note);
    }
    out.push_str(
        "\n## Faults of glTF files\n\nThe codes are those of the Khronos glTF validator.\n\n\
         | code | what happens | |\n|---|---|---|\n",
    );
    for issue in ISSUES {
        let handling = match issue.handling {
            Handling::Refused => "refused",
            Handling::Told => "read, with a notice",
            Handling::AsItIs => "read as it is",
            Handling::NotRead => "about what is not read",
        };
        let _ = writeln!(out, "| `{}` | {handling} | {} |", issue.code, issue.what);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_document_is_what_the_program_says() {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/formats.md");
        if std::env::var_os("PELLUCID_UPDATE_DOCS").is_some() {
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(&path, markdown()).unwrap();
        }
        let written = std::fs::read_to_string(&path).unwrap_or_default();
        assert!(
            written == markdown(),
            "{} is not what the program says: run this test with PELLUCID_UPDATE_DOCS=1",
            path.display()
        );
    }

    #[test]
    fn rows_are_told_apart() {
        let mut rows: Vec<(&str, &str)> = table().iter().map(|r| (r.format, r.feature)).collect();
        let all = rows.len();
        rows.sort_unstable();
        rows.dedup();
        assert_eq!(rows.len(), all);
        assert!(text().lines().count() == all && !text().contains(" \n"));
    }
}
