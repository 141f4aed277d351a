//! The built-in assemblies as files: what `assets/` holds.

use std::path::{Path, PathBuf};

use super::glb::{GlbError, write_glb};
use crate::scene::builtin::{BuiltinError, build};

/// Why the assets could not be written.
#[derive(Debug, thiserror::Error)]
pub enum AssetError {
    /// A scene could not be built.
    #[error(transparent)]
    Builtin(#[from] BuiltinError),
    /// A scene could not be exported.
    #[error("{name}: {source}")]
    Export {
        /// Name of the scene.
        name: &'static str,
        /// What went wrong.
        source: GlbError,
    },
    /// A file could not be written.
    #[error("cannot write {path}: {source}")]
    Write {
        /// Which file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
}

/// Writes `gearbox.glb` and `engine.glb` into `folder`, which is made if it is missing; gives the files.
///
/// # Errors
/// [`AssetError`] if a file cannot be written.
pub fn write_assets(folder: &Path) -> Result<Vec<PathBuf>, AssetError> {
    let failed = |path: &Path| {
        let path = path.to_owned();
        move |source| AssetError::Write { path, source }
    };
    std::fs::create_dir_all(folder).map_err(failed(folder))?;
    let mut written = Vec::new();
    for name in ["gearbox", "engine"] {
        let bytes = write_glb(&build(name)?).map_err(|source| AssetError::Export { name, source })?;
        let path = folder.join(format!("{name}.glb"));
        std::fs::write(&path, bytes).map_err(failed(&path))?;
        written.push(path);
    }
    Ok(written)
}
