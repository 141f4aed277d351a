//! Import: bytes to [`Scene`]. Each format has a module; what they share stands beside them.
//!
//! Files come from anywhere, so nothing in them is believed: every index, offset, length and count is checked in `u64`
//! before it is used, numbers must be finite, references stay inside the model's folder, and sizes have limits. There
//! are three outcomes for whatever a file says:
//!
//! - it is shown as the file means it;
//! - it cannot be shown, or was mended, and the scene is still worth seeing: a [`Notice`](crate::scene::Notice), one
//!   sentence each;
//! - it contradicts itself, is missing, or needs something unsupported to be readable: an [`ImportError`] that names
//!   file, place and cause. Nothing panics.

pub mod cases;
mod error;
pub mod features;
mod gltf;
mod notices;
mod phase;
mod uri;

#[cfg(test)]
mod tests;

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::scene::Scene;

pub use error::ImportError;
use error::{Fallible, Fault};
use notices::Notices;
pub use phase::{Phase, Progress};

/// What the importer does where the file leaves it open, and how much it takes.
#[derive(Clone, Debug, PartialEq)]
pub struct ImportOptions {
    /// Missing normals are smoothed over edges that turn by at most this angle, in degrees.
    pub crease_angle: f64,
    /// Whether normals that are plain averages of their facets are re-weighted
    /// ([`reweighted_normals`](crate::scene::reweighted_normals)), and flat ones inside edges of curved facets interpolated
    /// ([`interpolated_normals`](crate::scene::interpolated_normals)).
    pub reweight_normals: bool,
    /// What becomes a part; `None` is what suits the format.
    pub parts: Option<PartsBy>,
    /// The material variant to show, by name (KHR_materials_variants); `None` shows the file's default.
    pub variant: Option<String>,
    /// Programs that turn other formats into ones that are read: from a file's extension, in lower case, to a command line
    /// in which `{in}` and `{out}` stand for the files.
    pub converters: BTreeMap<String, String>,
    /// How much is taken.
    pub limits: Limits,
    /// Asked between phases, images and primitives.
    pub cancel: Cancel,
    /// Told how far it is.
    pub progress: Progress,
}

/// What becomes a part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PartsBy {
    /// Every node, object or group that the file names.
    Node,
    /// All triangles of one material.
    Material,
    /// Triangles that are connected, vertices at one place taken for one.
    Component,
    /// The whole file.
    File,
}

impl Default for ImportOptions {
    fn default() -> ImportOptions {
        ImportOptions {
            crease_angle: 30.0,
            reweight_normals: true,
            parts: None,
            variant: None,
            converters: BTreeMap::new(),
            limits: Limits::default(),
            cancel: Cancel::default(),
            progress: Progress::default(),
        }
    }
}

/// A flag by which an import is called off from another thread; copies share it.
#[derive(Clone, Debug, Default)]
pub struct Cancel(Arc<AtomicBool>);

impl Cancel {
    /// Calls it off: whatever asks ends with [`ImportError::Cancelled`] soon.
    pub fn cancel(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether it has been called off.
    pub fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    fn go_on(&self) -> Fallible<()> {
        if self.is_cancelled() { Err(Fault::Cancelled) } else { Ok(()) }
    }
}

impl PartialEq for Cancel {
    /// Always: options that differ in nothing else read the same scene.
    fn eq(&self, _: &Cancel) -> bool {
        true
    }
}

/// Limits on what one file may take. What exceeds one is refused with [`ImportError::Limit`].
#[derive(Clone, Debug, PartialEq)]
pub struct Limits {
    /// Bytes of one file, and of all buffers of a model together.
    pub bytes: u64,
    /// Elements of one accessor, and vertices of all primitives together.
    pub vertices: u64,
    /// Triangles of all meshes together (before instancing).
    pub triangles: u64,
    /// Width and height of an image, pixels.
    pub image_side: u32,
    /// Pixels of all images together.
    pub image_pixels: u64,
    /// Levels of the node hierarchy.
    pub node_depth: u64,
    /// Instances that EXT_mesh_gpu_instancing makes, all nodes together.
    pub instances: u64,
}

impl Default for Limits {
    fn default() -> Limits {
        Limits {
            bytes: 4 << 30,
            vertices: 1 << 27,
            triangles: 1 << 27,
            image_side: 16_384,
            image_pixels: 1 << 29,
            node_depth: 1024,
            instances: 1 << 20,
        }
    }
}

/// Reads a model from a file with default options.
///
/// # Errors
/// See [`load_with`].
pub fn load(path: &Path) -> Result<Scene, ImportError> {
    load_with(path, &ImportOptions::default())
}

/// Reads a model from a file. Its buffers and images may lie in the same folder or below.
///
/// # Errors
/// [`ImportError`]: the file cannot be read, is of an unknown kind, is malformed, needs an unsupported extension, or is
/// over a limit.
pub fn load_with(path: &Path, options: &ImportOptions) -> Result<Scene, ImportError> {
    let file = path.display().to_string();
    let extension = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
    if !matches!(extension.as_str(), "gltf" | "glb") {
        return Err(ImportError::UnknownKind { file });
    }
    let bytes = uri::read_file(path, options.limits.bytes).map_err(|fault| fault.in_file(&file))?;
    let folder = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    let name = path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
    gltf::read(&bytes, &name, Some(folder), options).map_err(|fault| fault.in_file(&file))
}

/// Reads a model from memory with default options. `name` is the scene's name and stands for the file in errors;
/// references to other files are looked up in `base_dir` and refused without one.
///
/// # Errors
/// See [`load_with`].
pub fn load_bytes(bytes: &[u8], name: &str, base_dir: Option<&Path>) -> Result<Scene, ImportError> {
    load_bytes_with(bytes, name, base_dir, &ImportOptions::default())
}

/// Reads a model from memory, as [`load_bytes`].
///
/// # Errors
/// See [`load_with`].
pub fn load_bytes_with(
    bytes: &[u8],
    name: &str,
    base_dir: Option<&Path>,
    options: &ImportOptions,
) -> Result<Scene, ImportError> {
    gltf::read(bytes, name, base_dir, options).map_err(|fault| fault.in_file(name))
}
