//! Why a transfer function was refused.

use super::names;

/// Why a transfer function was refused: file, place and cause.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum TransferError {
    /// No embedded transfer function has this name.
    #[error("no transfer function is called '{name}'; there are {known} (a path has a '/' or an extension)")]
    Unknown {
        /// The name that was given.
        name: String,
        /// The names that exist.
        known: String,
    },
    /// A file cannot be read, or an image is not a usable PNG.
    #[error("{path}: {reason}")]
    File {
        /// The file.
        path: String,
        /// The cause.
        reason: String,
    },
    /// A text is malformed or says something that is not allowed.
    #[error("{path}:{line}:{column}: {reason}")]
    Text {
        /// The file.
        path: String,
        /// Line, from 1.
        line: usize,
        /// Column in characters, from 1.
        column: usize,
        /// The cause.
        reason: String,
    },
}

impl TransferError {
    pub(super) fn unknown(name: &str) -> TransferError {
        TransferError::Unknown { name: name.to_owned(), known: names().join(", ") }
    }

    pub(super) fn file(path: impl ToString, reason: impl ToString) -> TransferError {
        TransferError::File { path: path.to_string(), reason: reason.to_string() }
    }

    /// What is wrong in a line of a text.
    pub(super) fn at_line(path: &str, line: usize, reason: impl ToString) -> TransferError {
        TransferError::Text { path: path.to_owned(), line, column: 1, reason: reason.to_string() }
    }

    /// A TOML error at the line and column where its span starts.
    pub(super) fn in_text(path: &str, text: &str, error: &toml::de::Error) -> TransferError {
        let (line, column, reason) = place_of(text, error);
        TransferError::Text { path: path.to_owned(), line, column, reason }
    }
}

/// Line and column (from 1, in characters) of a TOML error in its text, and its message in one line.
pub(crate) fn place_of(text: &str, error: &toml::de::Error) -> (usize, usize, String) {
    let before = error.span().and_then(|span| text.get(..span.start)).unwrap_or_default();
    let line_start = before.rfind('\n').map_or(0, |at| at + 1);
    let reason = error.message().lines().collect::<Vec<_>>().join("; ");
    (before.matches('\n').count() + 1, before[line_start..].chars().count() + 1, reason)
}
