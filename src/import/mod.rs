//! Import: bytes to [`Scene`]. Each format has a module; what they share stands beside them.
//!
//! One file passes through: `source` (read or mapped) → `format` (what it is, by its content) or `converter` (a program
//! that the user named makes something readable of it) → the format's own module → `parts` (what becomes a part).
//! `text`, `polygon`, `triangles`, `tangents` and `images` are shared by formats.
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
mod converter;
mod error;
pub mod features;
mod format;
mod gltf;
mod images;
mod notices;
mod obj;
mod parts;
mod phase;
mod ply;
mod polygon;
mod source;
mod steps;
mod stl;
mod tangents;
mod text;
mod triangles;
mod uri;

#[cfg(test)]
mod mutations;

#[cfg(test)]
mod tests;

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::scene::{Notice, NoticeKind, Scene};

pub use error::ImportError;
use error::{Fallible, Fault};
use format::Format;
use notices::Notices;
use parts::Draft;
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
    /// Files of at least so many bytes are mapped instead of read. A mapped file that somebody shortens meanwhile ends the
    /// program: where a file is read because it changes, this is `u64::MAX`, which maps none.
    pub map_from: u64,
    /// How much is taken.
    pub limits: Limits,
    /// Asked between pieces of a file, phases, images and primitives.
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
            map_from: 8 << 20,
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
    /// Parts into which materials or connected components divide a model; where there would be more it is not divided.
    pub parts: u64,
    /// Seconds that a converter may take.
    pub converter_seconds: u64,
}

impl Limits {
    /// [`Limits::triangles`], and no more than have corners that 32 bits can number.
    fn most_triangles(&self) -> u64 {
        self.triangles.min(u64::from(u32::MAX / 3) - 1)
    }
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
            parts: 4096,
            converter_seconds: 300,
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

/// Reads a model from a file. What it refers to, buffers, materials and images, may lie in the same folder or below.
///
/// # Errors
/// [`ImportError`]: the file cannot be read, is of an unknown kind, is malformed, needs an unsupported extension, is over a
/// limit, or its converter failed.
pub fn load_with(path: &Path, options: &ImportOptions) -> Result<Scene, ImportError> {
    let read = || {
        let bytes = source::open(path, options)?;
        let name = path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
        let input = Input { bytes: &bytes, name: &name, extension: extension(path), folder: Some(folder(path)) };
        input.read(Some(path), options)
    };
    read().map_err(|fault| fault.in_file(&path.display().to_string()))
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
    let input = Input { bytes, name, extension: extension(Path::new(name)), folder: base_dir };
    input.read(None, options).map_err(|fault| fault.in_file(name))
}

/// The extension of a path, in lower case, without its dot.
fn extension(path: &Path) -> String {
    path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default()
}

/// The folder of a file.
fn folder(path: &Path) -> &Path {
    path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// What is to be read.
struct Input<'a> {
    bytes: &'a [u8],
    name: &'a str,
    extension: String,
    /// Where files lie that it refers to.
    folder: Option<&'a Path>,
}

impl Input<'_> {
    /// Reads it, or what a converter makes of it; `path` is where it lies, if it is a file.
    fn read(&self, path: Option<&Path>, options: &ImportOptions) -> Fallible<Scene> {
        options.cancel.go_on()?;
        if self.bytes.is_empty() {
            return Err(Fault::invalid("file", "is empty"));
        }
        if let Some(format) = Format::of(self.bytes, &self.extension, &options.converters) {
            return self.read_as(format, options);
        }
        let Some(command) = options.converters.get(&self.extension) else {
            return Err(Fault::UnknownKind { advice: converter::advice(&self.extension) });
        };
        options.progress.tell(Phase::Converting, 0.0);
        let converted = converter::convert(command, path, self.bytes, &self.extension, options)?;
        let fault = |cause: String| Fault::Converter { command: command.clone(), cause };
        let bytes = source::open(&converted.path, options)?;
        let input = Input {
            bytes: &bytes,
            name: self.name,
            extension: extension(&converted.path),
            folder: Some(folder(&converted.path)),
        };
        let format = Format::of(&bytes, &input.extension, &BTreeMap::new());
        let format = format.ok_or_else(|| fault("what it wrote is of no kind that is read".to_owned()))?;
        let read = input.read_as(format, options);
        let mut scene = read.map_err(|e| match e {
            Fault::Cancelled | Fault::Limit { .. } => e,
            other => fault(format!("what it wrote cannot be read: {}", other.in_file("its output"))),
        })?;
        let message = format!("the file was converted to {} by '{command}'", format.name());
        scene.notices.insert(0, Notice { kind: NoticeKind::Approximated, message });
        Ok(scene)
    }

    fn read_as(&self, format: Format, options: &ImportOptions) -> Fallible<Scene> {
        if let Some(wanted) = options.variant.as_ref().filter(|_| format != Format::Gltf) {
            return Err(gltf::unknown_variant(wanted, &[]));
        }
        let draft = match format {
            Format::Gltf => Draft::gltf(gltf::read(self.bytes, self.name, self.folder, options)?),
            Format::Obj => obj::read(self.bytes, self.name, self.folder, options)?,
            Format::Stl => stl::read(self.bytes, self.name, options)?,
            Format::Ply => ply::read(self.bytes, self.name, options)?,
        };
        parts::divide(draft, options)
    }
}
