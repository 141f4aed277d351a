//! Why a file was refused.

use crate::scene::SceneError;

/// Why a model could not be imported. Displays as one line that names the file, the place in it and the cause.
#[derive(Debug, thiserror::Error)]
pub enum ImportError {
    /// The file, or one that it refers to, could not be read.
    #[error("{file}: {place}: {source}")]
    Io {
        /// The model's file.
        file: String,
        /// What was to be read.
        place: String,
        /// What the system said.
        source: std::io::Error,
    },
    /// Neither what is in the file nor its name is of a kind that is read.
    #[error("{file}: unknown kind of file: glTF, GLB, OBJ, STL and PLY are read; {advice}")]
    UnknownKind {
        /// The model's file.
        file: String,
        /// How to have it converted.
        advice: String,
    },
    /// The converter that the user named for such files did not do its work.
    #[error("{file}: converter '{command}': {cause}")]
    Converter {
        /// The model's file.
        file: String,
        /// The command line as configured.
        command: String,
        /// What went wrong.
        cause: String,
    },
    /// The file contradicts the format or itself.
    #[error("{file}: {place}: {cause}")]
    Invalid {
        /// The model's file.
        file: String,
        /// Where, like `accessors[3].bufferView`.
        place: String,
        /// What is wrong there.
        cause: String,
    },
    /// The file cannot be read without something that is not supported.
    #[error("{file}: {place}: {extension} is not supported: {cause}")]
    Unsupported {
        /// The model's file.
        file: String,
        /// Where it is asked for.
        place: String,
        /// The glTF extension or feature.
        extension: String,
        /// Why the file cannot be shown without it.
        cause: String,
    },
    /// The file needs more than [`Limits`](super::Limits) allow.
    #[error("{file}: {place}: {cause}")]
    Limit {
        /// The model's file.
        file: String,
        /// What is too large.
        place: String,
        /// How much it needs and how much is allowed.
        cause: String,
    },
    /// It was called off ([`Cancel`](super::Cancel)).
    #[error("{file}: called off")]
    Cancelled {
        /// The model's file.
        file: String,
    },
    /// The scene could not be finished.
    #[error("{file}: {source}")]
    Scene {
        /// The model's file.
        file: String,
        /// Why.
        source: SceneError,
    },
}

/// An [`ImportError`] that does not know its file yet.
#[derive(Debug)]
pub(super) enum Fault {
    Io { place: String, source: std::io::Error },
    UnknownKind { advice: String },
    Converter { command: String, cause: String },
    Invalid { place: String, cause: String },
    Unsupported { place: String, extension: String, cause: String },
    Limit { place: String, cause: String },
    Cancelled,
    Scene(SceneError),
}

/// The importer's own result.
pub(super) type Fallible<T> = Result<T, Fault>;

impl Fault {
    /// Something at `place` is wrong.
    pub(super) fn invalid(place: impl Into<String>, cause: impl Into<String>) -> Fault {
        Fault::Invalid { place: place.into(), cause: cause.into() }
    }

    /// `place` needs `needed` of something of which `allowed` is the most.
    pub(super) fn limit(place: impl Into<String>, what: &str, needed: u64, allowed: u64) -> Fault {
        Fault::Limit { place: place.into(), cause: format!("{needed} {what} exceed the limit of {allowed}") }
    }

    /// Names the file. Line breaks, which a name in the file may hold, become spaces.
    pub(super) fn in_file(self, file: &str) -> ImportError {
        let line = |s: String| s.replace(|c: char| c.is_control(), " ");
        let file = line(file.to_owned());
        match self {
            Fault::Io { place, source } => ImportError::Io { file, place: line(place), source },
            Fault::UnknownKind { advice } => ImportError::UnknownKind { file, advice: line(advice) },
            Fault::Converter { command, cause } => {
                ImportError::Converter { file, command: line(command), cause: line(cause) }
            }
            Fault::Invalid { place, cause } => ImportError::Invalid { file, place: line(place), cause: line(cause) },
            Fault::Unsupported { place, extension, cause } => {
                ImportError::Unsupported { file, place: line(place), extension: line(extension), cause: line(cause) }
            }
            Fault::Limit { place, cause } => ImportError::Limit { file, place: line(place), cause: line(cause) },
            Fault::Cancelled => ImportError::Cancelled { file },
            Fault::Scene(source) => ImportError::Scene { file, source },
        }
    }
}
