//! A session: everything that is seen, as one TOML file.
//!
//! ```toml
//! file = "gearbox.glb"          # or builtin:NAME; a relative path counts from the session's folder
//! size = [1280, 800]
//!
//! [camera]                      # in the file's coordinates
//! position = [3.0, 2.0, 4.0]
//! focal_point = [0.0, 0.0, 0.0]
//! view_up = [0.0, 1.0, 0.0]
//! projection = { kind = "perspective", fov_y = 0.5235987755982988 }   # radians
//!
//! [settings]                    # as in a settings file
//! opacity.gain = 1.5
//!
//! [arrangement]
//! explode = 0.5
//! selected = ["housing/bolt#2"]
//!
//! [[arrangement.parts]]
//! part = "housing/cover"
//! presence = "ghosted"          # or "shown", "hidden"
//! opacity = 0.5
//! color = [0.8, 0.1, 0.1]       # sRGB
//! style = "solid"               # or "as_set"
//!
//! [[arrangement.sections]]
//! normal = [1.0, 0.0, 0.0]
//! offset = 0.25
//! enabled = true
//! caps = true
//!
//! [import]                      # how the model is read; left out where it is as usual
//! parts = "component"           # or "node", "material", "file"
//! variant = "midnight"
//! crease_angle = 40.0           # degrees
//! ```
//!
//! Numbers are written so that they are read as the same bits. Parts are named by path ([`PartNames`]) and become indices
//! when the scene is there: [`Session::from_toml`] gives a [`SessionFile`], [`SessionFile::resolve`] the session.

pub mod configuration;
mod importing;
mod names;

use std::collections::{BTreeMap, BTreeSet};
use std::io::Read;
use std::path::Path;

use glam::DVec3;
use serde::{Deserialize, Serialize};

pub use importing::{Importing, LIMITS, Limit, PARTS, count, crease_angle, parts_name, parts_named};
pub use names::{PartNameError, PartNames};

use crate::math::{Camera, Projection};
use crate::scene::{Arrangement, ArrangementError, PartLook, PartStyle, Presence, Scene, Section};
use crate::settings::{Settings, SettingsError};
use crate::transfer::{TransferSource, place_of};

/// In front of the name of a generated scene.
const BUILTIN: &str = "builtin:";
/// Largest session file that is read, bytes.
const LARGEST: u64 = 64 << 20;

/// What a session file says.
///
/// # Errors
/// What the system says; [`std::io::ErrorKind::FileTooLarge`] beyond 64 MiB.
pub fn read_text(path: &Path) -> std::io::Result<String> {
    let mut text = String::new();
    std::fs::File::open(path)?.take(LARGEST + 1).read_to_string(&mut text)?;
    if text.len() as u64 > LARGEST {
        let reason = format!("larger than {} MiB", LARGEST >> 20);
        return Err(std::io::Error::new(std::io::ErrorKind::FileTooLarge, reason));
    }
    Ok(text)
}

/// Everything that is seen.
#[derive(Clone, Debug, PartialEq)]
pub struct Session {
    /// The model, or `builtin:NAME`.
    pub file: String,
    /// Width and height of the picture, pixels.
    pub size: [u32; 2],
    /// The camera, in the file's coordinates.
    pub camera: Camera,
    /// Settings.
    pub settings: Settings,
    /// How the parts are shown.
    pub arrangement: Arrangement,
    /// How the model is read.
    pub import: Importing,
}

/// A session whose scene is not there yet: its parts still have names.
#[derive(Clone, Debug, PartialEq)]
pub struct SessionFile {
    file: String,
    size: [u32; 2],
    camera: Camera,
    settings: Settings,
    arrangement: ArrangementText,
    import: Importing,
}

/// Why a session cannot be read or written.
#[derive(Debug, thiserror::Error)]
pub enum SessionError {
    /// The text is no TOML, or does not have the tables of a session.
    #[error("{line}:{column}: {reason}")]
    Syntax {
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// What is wrong.
        reason: String,
    },
    /// A value that makes no picture.
    #[error("{what}: expected {expected}")]
    Value {
        /// What it is.
        what: &'static str,
        /// What is allowed.
        expected: &'static str,
    },
    /// A setting is unknown or out of its range.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// A part has no such name.
    #[error(transparent)]
    Part(#[from] PartNameError),
    /// A part is listed more than once.
    #[error("part '{part}' is listed twice")]
    Twice {
        /// Its path.
        part: String,
    },
    /// A number of the arrangement is out of its range.
    #[error(transparent)]
    Arrangement(#[from] ArrangementError),
    /// The session has no TOML form.
    #[error("session: {0}")]
    Unwritable(String),
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct SessionText {
    file: String,
    size: [u32; 2],
    camera: CameraText,
    #[serde(default)]
    settings: toml::Table,
    #[serde(default)]
    arrangement: ArrangementText,
    #[serde(default, skip_serializing_if = "is_default")]
    import: Importing,
}

/// [`Camera`], refusing what it does not know.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct CameraText {
    position: DVec3,
    focal_point: DVec3,
    view_up: DVec3,
    projection: Projection,
}

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct ArrangementText {
    explode: f64,
    selected: Vec<String>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    parts: Vec<PartText>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    sections: Vec<SectionText>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct PartText {
    part: String,
    #[serde(default, skip_serializing_if = "is_default")]
    presence: Presence,
    #[serde(default = "one", skip_serializing_if = "is_one")]
    opacity: f64,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    color: Option<[f64; 3]>,
    #[serde(default, skip_serializing_if = "is_default")]
    style: PartStyle,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct SectionText {
    normal: DVec3,
    offset: f64,
    #[serde(default = "yes")]
    enabled: bool,
    #[serde(default = "yes")]
    caps: bool,
}

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

fn one() -> f64 {
    1.0
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde asks with a reference")]
fn is_one(value: &f64) -> bool {
    *value == 1.0
}

fn yes() -> bool {
    true
}

/// The camera moved by a vector.
fn moved(camera: &Camera, by: DVec3) -> Camera {
    if by == DVec3::ZERO {
        return *camera;
    }
    Camera { position: camera.position + by, focal_point: camera.focal_point + by, ..*camera }
}

/// A scene's camera in its file's coordinates, as sessions have it.
pub fn camera_in_file(camera: &Camera, scene: &Scene) -> Camera {
    moved(camera, scene.origin)
}

/// A camera in the file's coordinates, in the scene: what the renderer takes.
///
/// Far from the origin the way there and back rounds; a picture that a session has to repeat is drawn with the camera that
/// came out of this.
pub fn camera_in_scene(camera: &Camera, scene: &Scene) -> Camera {
    moved(camera, -scene.origin)
}

fn check_view(size: [u32; 2], camera: &Camera) -> Result<(), SessionError> {
    let wrong = |what, expected| Err(SessionError::Value { what, expected });
    if size.contains(&0) {
        return wrong("size", "width and height of at least 1");
    }
    if ![camera.position, camera.focal_point, camera.view_up].iter().all(|v| v.is_finite()) {
        return wrong("camera", "finite numbers");
    }
    let toward = camera.focal_point - camera.position;
    if toward.length() == 0.0 {
        return wrong("camera.focal_point", "another point than camera.position");
    }
    // Also where the way up has no length.
    if camera.view_up.normalize_or_zero().cross(toward.normalize_or_zero()).length() <= 1e-9 {
        return wrong("camera.view_up", "a direction other than the one that the camera looks along");
    }
    match camera.projection {
        Projection::Perspective { fov_y } if !(fov_y > 0.0 && fov_y < std::f64::consts::PI) => {
            wrong("camera.projection.fov_y", "radians between 0 and pi")
        }
        Projection::Orthographic { height } if !(height > 0.0 && height.is_finite()) => {
            wrong("camera.projection.height", "a number greater than 0")
        }
        _ => Ok(()),
    }
}

impl Session {
    /// Writes the session, with the scene's parts by path.
    ///
    /// # Errors
    /// [`SessionError`] if the session does not fit the scene, or holds what cannot be read again.
    pub fn to_toml(&self, scene: &Scene) -> Result<String, SessionError> {
        check_view(self.size, &self.camera)?;
        self.arrangement.check(scene)?;
        // Paths are only made where parts are named: a file may have very many.
        let named = !self.arrangement.parts.is_empty() || !self.arrangement.selected.is_empty();
        let names = named.then(|| PartNames::new(scene));
        let path = |part: u32| names.as_ref().and_then(|n| n.path(part)).unwrap_or_default().to_owned();
        let unwritable = |e: &dyn std::fmt::Display| SessionError::Unwritable(e.to_string());
        let looks = self.arrangement.parts.iter().filter(|(_, look)| **look != PartLook::default());
        let text = SessionText {
            file: self.file.clone(),
            size: self.size,
            camera: CameraText {
                position: self.camera.position,
                focal_point: self.camera.focal_point,
                view_up: self.camera.view_up,
                projection: self.camera.projection,
            },
            settings: toml::Table::try_from(&self.settings).map_err(|e| unwritable(&e))?,
            arrangement: ArrangementText {
                explode: self.arrangement.explode,
                selected: self.arrangement.selected.iter().map(|&part| path(part)).collect(),
                parts: looks
                    .map(|(&part, look)| PartText {
                        part: path(part),
                        presence: look.presence,
                        opacity: look.opacity,
                        color: look.color,
                        style: look.style,
                    })
                    .collect(),
                sections: (self.arrangement.sections.iter())
                    .map(|s| SectionText { normal: s.normal, offset: s.offset, enabled: s.enabled, caps: s.caps })
                    .collect(),
            },
            import: self.import.clone(),
        };
        toml::to_string_pretty(&text).map_err(|e| unwritable(&e))
    }

    /// Reads a session. Everything but the names of parts is checked here.
    ///
    /// # Errors
    /// [`SessionError`] for bad syntax, unknown names and values out of range.
    pub fn from_toml(text: &str) -> Result<SessionFile, SessionError> {
        let parsed: SessionText = toml::from_str(text).map_err(|e| {
            let (line, column, reason) = place_of(text, &e);
            SessionError::Syntax { line, column, reason }
        })?;
        let CameraText { position, focal_point, view_up, projection } = parsed.camera;
        let camera = Camera { position, focal_point, view_up, projection };
        check_view(parsed.size, &camera)?;
        if !(0.0..=180.0).contains(&parsed.import.crease_angle) {
            return Err(SessionError::Value { what: "import.crease_angle", expected: "degrees from 0 to 180" });
        }
        let mut settings = Settings::default();
        settings.merge(&parsed.settings)?;
        let SessionText { file, size, arrangement, import, .. } = parsed;
        let file = SessionFile { file, size, camera, settings, arrangement, import };
        file.values().check_values()?;
        Ok(file)
    }

    /// The session as it is written into `folder`: its paths count from there where they lie below it, and are absolute
    /// otherwise.
    ///
    /// # Errors
    /// [`SessionError::Unwritable`] if the current folder cannot be found.
    pub fn for_folder(mut self, folder: &Path) -> Result<Session, SessionError> {
        let absolute = |path: &Path| std::path::absolute(path).map_err(|e| SessionError::Unwritable(e.to_string()));
        let here = std::env::current_dir().map_err(|e| SessionError::Unwritable(e.to_string()))?;
        let folder = here.join(folder);
        let folder = absolute(&folder)?;
        let shortened = |path: &str| -> Result<String, SessionError> {
            let path = absolute(Path::new(path))?;
            Ok(path.strip_prefix(&folder).unwrap_or(&path).to_string_lossy().into_owned())
        };
        if !self.file.starts_with(BUILTIN) {
            self.file = shortened(&self.file)?;
        }
        self.settings.opacity.transfer = match std::mem::take(&mut self.settings.opacity.transfer).rebased(&here) {
            TransferSource::Named(path) if Path::new(&path).is_absolute() => {
                let short = shortened(&path)?;
                // A bare word would be taken for a name.
                TransferSource::Named(if short.contains(['/', '\\', '.']) { short } else { format!("./{short}") })
            }
            other => other,
        };
        Ok(self)
    }
}

impl SessionFile {
    /// The model, or `builtin:NAME`.
    pub fn file(&self) -> &str {
        &self.file
    }

    /// Width and height of the picture, pixels.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// The settings.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// How the model is read.
    pub fn import(&self) -> &Importing {
        &self.import
    }

    /// The session with its relative paths counted from `folder`, where its file lies.
    #[must_use]
    pub fn rebased(mut self, folder: &Path) -> SessionFile {
        if !self.file.starts_with(BUILTIN) {
            self.file = folder.join(&self.file).to_string_lossy().into_owned();
        }
        self.settings.opacity.transfer = std::mem::take(&mut self.settings.opacity.transfer).rebased(folder);
        self
    }

    /// The arrangement's numbers, with parts in the order of the file.
    fn values(&self) -> Arrangement {
        let ArrangementText { explode, parts, sections, .. } = &self.arrangement;
        let look = |p: &PartText| PartLook { presence: p.presence, opacity: p.opacity, color: p.color, style: p.style };
        let section =
            |s: &SectionText| Section { normal: s.normal, offset: s.offset, enabled: s.enabled, caps: s.caps };
        Arrangement {
            parts: parts.iter().enumerate().map(|(i, p)| (i as u32, look(p))).collect(),
            explode: *explode,
            sections: sections.iter().map(section).collect(),
            selected: BTreeSet::new(),
        }
    }

    /// The session for its scene.
    ///
    /// # Errors
    /// [`SessionError`] for a part that the scene does not have, with the nearest that it has, or that is listed twice.
    pub fn resolve(self, scene: &Scene) -> Result<Session, SessionError> {
        let mut arrangement = self.values();
        let looks = std::mem::take(&mut arrangement.parts);
        if !(looks.is_empty() && self.arrangement.selected.is_empty()) {
            let names = PartNames::new(scene);
            let mut parts = BTreeMap::new();
            for (text, (_, look)) in self.arrangement.parts.iter().zip(looks) {
                if parts.insert(names.part(&text.part)?, look).is_some() {
                    return Err(SessionError::Twice { part: text.part.clone() });
                }
            }
            arrangement.parts = parts;
            for path in &self.arrangement.selected {
                if !arrangement.selected.insert(names.part(path)?) {
                    return Err(SessionError::Twice { part: path.clone() });
                }
            }
        }
        let SessionFile { file, size, camera, settings, import, .. } = self;
        Ok(Session { file, size, camera, settings, arrangement, import })
    }
}

#[cfg(test)]
pub(crate) mod tests;
