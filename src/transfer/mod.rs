//! Transfer functions: colour over curvature (1D), opacity over depth and absolute curvature (2D).
//!
//! Section 5.2 of the Bucketed k-Buffer paper modulates the lit colour of a layer by a function of its curvature κ, and
//! its opacity by a function of |κ| and depth. Both are data here: they are baked into tables of 256 and 256×256
//! entries ([`TransferTables`]) that every renderer samples alike, so that changing one compiles no shader, and the
//! planner reads off the tables themselves whether curvature is needed at all.
//!
//! We differ from the paper in two things. Its colour function multiplies; ours tints by default ([`ColorMode::Tint`]),
//! because a dark material stays dark under any factor. And its functions are images; ours are TOML with control
//! points, which a person can read and edit, or images where that is what somebody has.
//!
//! A file in `transfer_functions/`:
//!
//! ```toml
//! [color]
//! mode = "tint"                # or "multiply"
//! interpolation = "monotone"   # or "linear", "step"
//! points = [                   # or image = "strip.png": its first row, κ from left to right
//!     { kappa = -1.0, color = 0.9 },
//!     { kappa = 0.0, color = [0.5, 0.5, 0.5] },
//!     { kappa = 1.0, color = "#202020" },
//! ]
//!
//! [opacity]
//! interpolation = "monotone"       # along |κ|
//! depth_interpolation = "linear"   # from curve to curve
//! curves = [                       # or image = "map.png": depth to the right, |κ| upwards, white is opaque
//!     { depth = 0.0, points = [[0.0, 0.1], [1.0, 0.9]] },
//!     { depth = 1.0, points = [[0.0, 0.4], [1.0, 1.0]] },
//! ]
//! ```
//!
//! Before them may stand `name = "…"`, which is for people only. The same may stand in a settings file under
//! `[opacity.transfer]`. Files of other programs are read and
//! written too: [`formats`]. What an editor does to points is [`edit`].

mod color;
pub mod edit;
mod error;
pub mod formats;
mod histogram;
mod opacity;
mod points;
mod presets;
mod raster;
mod tables;

use std::io::Read;
use std::path::{Path, PathBuf};

use serde::de::value::MapAccessDeserializer;
use serde::de::{Deserializer, MapAccess, Visitor};
use serde::{Deserialize, Serialize};

pub(crate) use color::hex;
pub use color::{ColorFunction, ColorMode, ColorPoint, ColorShape, ColorValue};
pub use error::TransferError;
pub(crate) use error::place_of;
pub use formats::{Exported, Format, Imported};
pub use histogram::Histogram2d;
pub use opacity::{OpacityCurve, OpacityFunction, OpacityPoint, OpacitySampler, OpacityShape};
pub use points::{ControlPoint, Interpolation, Points};
pub use presets::{Preset, names, presets};
pub use raster::Raster;
pub use tables::{TABLE_SIZE, TransferTables};

/// Larger files are refused.
const LARGEST_FILE: u64 = 64 << 20;

/// How curvature and depth of a layer make its colour and opacity.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TransferFunction {
    /// What it was made from, for people; no picture depends on it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Colour over κ.
    pub color: ColorFunction,
    /// Opacity over (depth, |κ|).
    pub opacity: OpacityFunction,
}

impl TransferFunction {
    /// Neutral colour and one opacity everywhere.
    pub fn uniform(opacity: f64) -> TransferFunction {
        TransferFunction { name: None, color: ColorFunction::neutral(), opacity: OpacityFunction::uniform(opacity) }
    }

    /// Reads the TOML form. Images that it names are not loaded; [`TransferSource::resolve`] does both.
    ///
    /// `path` is what errors call the text.
    ///
    /// # Errors
    /// [`TransferError::Text`] with line, column and reason.
    pub fn from_toml(text: &str, path: &str) -> Result<TransferFunction, TransferError> {
        toml::from_str(text).map_err(|e| TransferError::in_text(path, text, &e))
    }

    /// Writes the TOML form. An image is written as its path.
    ///
    /// # Errors
    /// [`TransferError::File`] if a value has no TOML form; none does today.
    pub fn to_toml(&self) -> Result<String, TransferError> {
        toml::to_string_pretty(self).map_err(|e| TransferError::file("transfer function", e))
    }

    fn load_images(&mut self, folder: &Folder) -> Result<(), TransferError> {
        for raster in self.rasters().filter(|r| !r.is_loaded()) {
            let path = raster.path().to_owned();
            let png = folder.read(&path)?;
            raster.load(&png).map_err(|reason| TransferError::file(folder.show(&path), reason))?;
        }
        Ok(())
    }

    /// The path of an image that has not been loaded, if there is one.
    fn not_loaded(&self) -> Option<&str> {
        let strip = match &self.color.shape {
            ColorShape::Strip(raster) => Some(raster),
            ColorShape::Points { .. } => None,
        };
        let map = match &self.opacity.shape {
            OpacityShape::Image(raster) => Some(raster),
            OpacityShape::Curves { .. } => None,
        };
        strip.into_iter().chain(map).find(|r| !r.is_loaded()).map(Raster::path)
    }

    fn rasters(&mut self) -> impl Iterator<Item = &mut Raster> {
        let strip = match &mut self.color.shape {
            ColorShape::Strip(raster) => Some(raster),
            ColorShape::Points { .. } => None,
        };
        let map = match &mut self.opacity.shape {
            OpacityShape::Image(raster) => Some(raster),
            OpacityShape::Curves { .. } => None,
        };
        strip.into_iter().chain(map)
    }
}

/// Where transfer functions come from. In text a string is a name or a path, a table is the functions themselves.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum TransferSource {
    /// A name from `transfer_functions/`, or a path.
    Named(String),
    /// The functions, written where they are used. Images that are not loaded yet are when it is resolved.
    Inline(Box<TransferFunction>),
}

impl Default for TransferSource {
    fn default() -> TransferSource {
        TransferSource::Named("pellucid".to_owned())
    }
}

impl TransferSource {
    /// Finds, reads and checks the functions, images included.
    ///
    /// A string without a folder and an extension is a name from [`names`]; any other is a path to a file of any of the
    /// [`formats`], and `PATH#NAME` is a map by its name where a file holds several. Relative paths, and those of
    /// images in an inline function, count from `base_dir`, or from the current folder where that is `None`.
    ///
    /// # Errors
    /// [`TransferError`] for a name that does not exist, a file that cannot be read, and anything wrong inside.
    pub fn resolve(&self, base_dir: Option<&Path>) -> Result<TransferFunction, TransferError> {
        self.import(base_dir, None).map(|imported| imported.function)
    }

    /// The same with what was mapped, approximated or left out on the way. `map` chooses among several maps in one
    /// file, as `#NAME` does.
    ///
    /// # Errors
    /// As [`TransferSource::resolve`], and for a map that does not exist.
    pub fn import(&self, base_dir: Option<&Path>, map: Option<&str>) -> Result<Imported, TransferError> {
        let base = || Folder::Disk(base_dir.map(Path::to_path_buf).unwrap_or_default());
        let (mut imported, folder) = match self {
            TransferSource::Inline(function) => {
                (Imported { function: (**function).clone(), notices: Vec::new() }, base())
            }
            TransferSource::Named(name) if is_name(name) => {
                if !names().contains(&name.as_str()) {
                    return Err(TransferError::unknown(name));
                }
                (read(&Folder::Embedded, &format!("{name}.toml"), map)?, Folder::Embedded)
            }
            TransferSource::Named(path) => {
                let on_disk = |path: &str| base_dir.map_or_else(|| PathBuf::from(path), |b| b.join(path));
                let (path, map) = match path.rsplit_once('#') {
                    Some((file, name)) if map.is_none() && !on_disk(path).exists() => (file, Some(name)),
                    _ => (path.as_str(), map),
                };
                let imported = read(&base(), path, map)?;
                (imported, Folder::Disk(on_disk(path).parent().map(Path::to_path_buf).unwrap_or_default()))
            }
        };
        imported.function.load_images(&folder)?;
        Ok(imported)
    }
}

impl TransferSource {
    /// The same source with its relative paths, images of an inline function included, counted from `folder`: for a
    /// settings file that is used from elsewhere.
    #[must_use]
    pub fn rebased(self, folder: &Path) -> TransferSource {
        let join = |path: &str| folder.join(path).to_string_lossy().into_owned();
        match self {
            TransferSource::Named(name) if is_name(&name) => TransferSource::Named(name),
            TransferSource::Named(path) => TransferSource::Named(join(&path)),
            TransferSource::Inline(mut function) => {
                for raster in function.rasters().filter(|r| !r.is_loaded()) {
                    *raster = Raster::named(join(raster.path()));
                }
                TransferSource::Inline(function)
            }
        }
    }
}

fn is_name(text: &str) -> bool {
    !text.contains(['/', '\\', '.'])
}

fn read(folder: &Folder, path: &str, map: Option<&str>) -> Result<Imported, TransferError> {
    formats::read(&folder.read(path)?, &folder.show(path), map)
}

/// Where paths count from.
enum Folder {
    /// `transfer_functions/` inside the program.
    Embedded,
    /// A folder; the empty path is the current one.
    Disk(PathBuf),
}

impl Folder {
    fn show(&self, path: &str) -> String {
        match self {
            Folder::Embedded => format!("transfer_functions/{path}"),
            Folder::Disk(folder) => folder.join(path).display().to_string(),
        }
    }

    fn read(&self, path: &str) -> Result<Vec<u8>, TransferError> {
        let failed = |reason: &dyn std::fmt::Display| TransferError::file(self.show(path), reason);
        match self {
            Folder::Embedded => presets::file(path).map(<[u8]>::to_vec).ok_or_else(|| failed(&"not in the program")),
            Folder::Disk(folder) => {
                let mut bytes = Vec::new();
                let file = std::fs::File::open(folder.join(path)).map_err(|e| failed(&e))?;
                file.take(LARGEST_FILE + 1).read_to_end(&mut bytes).map_err(|e| failed(&e))?;
                if bytes.len() as u64 > LARGEST_FILE {
                    return Err(failed(&"larger than 64 MiB"));
                }
                Ok(bytes)
            }
        }
    }
}

/// Written by hand because an untagged enumeration would hide what is wrong inside a table.
impl<'de> Deserialize<'de> for TransferSource {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<TransferSource, D::Error> {
        struct Either;
        impl<'de> Visitor<'de> for Either {
            type Value = TransferSource;
            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("a transfer function: a name, a path, or a table with color and opacity")
            }
            fn visit_str<E: serde::de::Error>(self, name: &str) -> Result<TransferSource, E> {
                Ok(TransferSource::Named(name.to_owned()))
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<TransferSource, A::Error> {
                let function = TransferFunction::deserialize(MapAccessDeserializer::new(map))?;
                Ok(TransferSource::Inline(Box::new(function)))
            }
        }
        deserializer.deserialize_any(Either)
    }
}

#[cfg(test)]
mod tests;
