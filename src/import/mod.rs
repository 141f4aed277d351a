//! Import: bytes to [`Scene`], for glTF 2.0 as text (`.gltf`) and binary (`.glb`).
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
//!
//! From the `gltf` crates only the JSON types are used (`gltf-json`): its reader panics on several malformed files, and
//! its validation refuses extensions that this program reads or can do without.
//!
//! One file passes through the modules in this order: `container` (GLB chunks) → `document` (JSON, place by place)
//! → `extensions` (what is required, what is left out) → `buffers` and `uri` → `accessor` → `images` →
//! `materials` → `geometry` (with `attributes`, `tangents` and the scene's normals) → `nodes`.

mod accessor;
mod attributes;
mod buffers;
pub mod cases;
mod container;
mod document;
mod error;
mod extensions;
mod geometry;
mod images;
mod materials;
mod nodes;
mod notices;
mod tangents;
mod uri;

#[cfg(test)]
mod tests;

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::scene::Scene;

pub use error::ImportError;
use error::{Fallible, Fault};
use notices::Notices;

/// What the importer does where the file leaves it open, and how much it takes.
#[derive(Clone, Debug, PartialEq)]
pub struct ImportOptions {
    /// Missing normals are smoothed over edges that turn by at most this angle, in degrees.
    pub crease_angle: f64,
    /// Whether normals that are plain averages of their facets are re-weighted
    /// ([`reweighted_normals`](crate::scene::reweighted_normals)), and flat ones inside edges of curved facets interpolated
    /// ([`interpolated_normals`](crate::scene::interpolated_normals)).
    pub reweight_normals: bool,
    /// How much is taken.
    pub limits: Limits,
    /// Asked between phases, images and primitives.
    pub cancel: Cancel,
}

impl Default for ImportOptions {
    fn default() -> ImportOptions {
        ImportOptions {
            crease_angle: 30.0,
            reweight_normals: true,
            limits: Limits::default(),
            cancel: Cancel::default(),
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
    import(&bytes, &name, Some(folder), options).map_err(|fault| fault.in_file(&file))
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
    import(bytes, name, base_dir, options).map_err(|fault| fault.in_file(name))
}

fn import(bytes: &[u8], name: &str, folder: Option<&Path>, options: &ImportOptions) -> Fallible<Scene> {
    let mut notices = Notices::default();
    let parts = container::split(bytes, &mut notices)?;
    let document = document::parse(parts.json, &mut notices)?;
    extensions::report(&document, &mut notices)?;
    let root = &document.root;
    let buffers = buffers::read(root, parts.binary, folder, &options.limits, &mut notices)?;
    let data = accessor::Data::new(root, &buffers, &options.limits)?;
    options.cancel.go_on()?;
    let images = images::read(root, &data, folder, options, &mut notices)?;
    let mut textures = materials::textures(root, images.len(), &mut notices)?;
    let mut materials = materials::read(root, textures.len(), &mut notices)?;
    materials::drop_unusable(&mut textures, &mut materials);
    let geometry = geometry::read(root, &data, materials, options, &mut notices)?;
    let hierarchy = nodes::read(root, geometry.meshes.len(), &options.limits, &mut notices)?;
    let mut scene = Scene {
        name: name.to_owned(),
        nodes: hierarchy.nodes,
        meshes: geometry.meshes,
        materials: geometry.materials,
        textures,
        images,
        ..Scene::default()
    };
    let meshes_shown = scene.nodes.iter().filter_map(|n| n.mesh).any(|m| scene.meshes[m].triangle_count() > 0);
    if !meshes_shown {
        notices.ignored("the file shows no triangles: the scene is empty".to_owned());
    }
    scene.notices = notices.into_vec();
    options.cancel.go_on()?;
    let mut scene = scene.finish().map_err(Fault::Scene)?;
    // After finishing, so that cameras are in the re-based space.
    scene.cameras = nodes::cameras(root, &hierarchy.cameras, &scene);
    Ok(scene)
}
