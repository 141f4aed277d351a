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
    gltf::features()
}

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
