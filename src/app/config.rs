//! What the window remembers from one time to the next: a small TOML file in the user's configuration folder.
//!
//! `$XDG_CONFIG_HOME/pellucid/window.toml`, or below `~/.config`. A file that cannot be read is replaced by the defaults with a
//! message; it never keeps the window from opening.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::camera::{self, Habits};
use super::loader::HARD_CASE;
use crate::math::Camera;

/// Recent files that are remembered.
const MOST_RECENT: usize = 12;

/// Light or dark.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Theme {
    /// As the desktop says.
    System,
    /// Dark: the picture stands out.
    #[default]
    Dark,
    /// Light.
    Light,
}

/// What is remembered.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Preferences {
    /// Light or dark.
    pub theme: Theme,
    /// Size of everything but the picture, times the display's own.
    pub scale: f32,
    /// Habits of the mouse.
    pub mouse: Habits,
    /// Whether the list of parts is shown.
    pub parts: bool,
    /// Whether the stages are shown.
    pub stages: bool,
    /// Whether the accuracy panel is shown, in place of the stages.
    pub accuracy: bool,
    /// Whether the transfer-function editors are shown.
    pub editors: bool,
    /// Whether the layers under the resting cursor are shown beside it.
    pub hover: bool,
    /// Files, newest first.
    pub recent: Vec<String>,
    /// Views that were saved, by file.
    pub views: BTreeMap<String, Vec<SavedView>>,
}

/// A camera with a name.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SavedView {
    /// What the user calls it.
    pub name: String,
    /// In the file's coordinates.
    pub camera: Camera,
}

impl Default for Preferences {
    fn default() -> Preferences {
        Preferences {
            theme: Theme::default(),
            scale: 1.0,
            mouse: Habits::default(),
            parts: true,
            stages: true,
            accuracy: false,
            editors: true,
            hover: true,
            recent: Vec::new(),
            views: BTreeMap::new(),
        }
    }
}

impl Preferences {
    /// Puts a file at the top of the recent ones. Paths are made absolute, so that they can be found from elsewhere.
    pub fn remember(&mut self, file: &str) {
        let name = known_as(file);
        self.recent.retain(|f| *f != name);
        self.recent.insert(0, name);
        self.recent.truncate(MOST_RECENT);
    }

    /// The views that were saved of a file.
    pub fn views_of(&self, file: &str) -> &[SavedView] {
        self.views.get(&known_as(file)).map_or(&[], Vec::as_slice)
    }

    /// Saves a view of a file, instead of one that has this name already.
    pub fn save_view(&mut self, file: &str, view: SavedView) {
        let views = self.views.entry(known_as(file)).or_default();
        match views.iter_mut().find(|v| v.name == view.name) {
            Some(old) => *old = view,
            None => views.push(view),
        }
    }

    /// Forgets a view of a file.
    pub fn forget_view(&mut self, file: &str, name: &str) {
        let key = known_as(file);
        if let Some(views) = self.views.get_mut(&key) {
            views.retain(|v| v.name != name);
            if views.is_empty() {
                self.views.remove(&key);
            }
        }
    }

    /// Reads a file; the defaults if there is none.
    ///
    /// # Errors
    /// A sentence if there is one that cannot be understood.
    pub fn read(path: &Path) -> Result<Preferences, String> {
        let text = match std::fs::read_to_string(path) {
            Ok(text) => text,
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(Preferences::default()),
            Err(e) => return Err(format!("{}: {e}", path.display())),
        };
        let mut read: Preferences =
            toml::from_str(&text).map_err(|e| format!("{}: {}", path.display(), e.message()))?;
        if !(0.5..=3.0).contains(&read.scale) {
            read.scale = 1.0;
        }
        for views in read.views.values_mut() {
            views.retain(|v| camera::is_sound(&v.camera));
        }
        read.views.retain(|_, views| !views.is_empty());
        Ok(read)
    }

    /// Writes a file, whole or not at all.
    ///
    /// # Errors
    /// A sentence if it cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), String> {
        let failed = |e: &dyn std::fmt::Display| format!("{}: {e}", path.display());
        let text = toml::to_string_pretty(self).map_err(|e| failed(&e))?;
        let folder = path.parent().unwrap_or(Path::new("."));
        std::fs::create_dir_all(folder).map_err(|e| failed(&e))?;
        let draft = path.with_extension(format!("{}.tmp", std::process::id()));
        std::fs::write(&draft, text).and_then(|()| std::fs::rename(&draft, path)).map_err(|e| failed(&e))
    }
}

/// What a file is remembered as: its absolute path, so that it is found from elsewhere; generated scenes by their name.
fn known_as(file: &str) -> String {
    if file.starts_with("builtin:") || file.starts_with(HARD_CASE) {
        return file.to_owned();
    }
    std::path::absolute(file).map_or_else(|_| file.to_owned(), |p| p.to_string_lossy().into_owned())
}

/// Where preferences lie; `None` where the system names no folder for them.
pub fn path() -> Option<PathBuf> {
    let set = |name: &str| std::env::var_os(name).map(PathBuf::from).filter(|p| p.is_absolute());
    let folder = set("XDG_CONFIG_HOME").or_else(|| set("APPDATA")).or_else(|| Some(set("HOME")?.join(".config")))?;
    Some(folder.join("pellucid").join("window.toml"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read_and_damage_is_said() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("deep").join("window.toml");
        assert_eq!(Preferences::read(&path), Ok(Preferences::default()));
        let mut preferences = Preferences { theme: Theme::Light, mouse: Habits::Cad, ..Preferences::default() };
        preferences.remember("/a.glb");
        preferences.write(&path).unwrap();
        assert_eq!(Preferences::read(&path), Ok(preferences));
        std::fs::write(&path, "scale = 'large'").unwrap();
        assert!(Preferences::read(&path).unwrap_err().contains("window.toml"));
        std::fs::write(&path, "scale = 1e9\nunknown = 3").unwrap();
        assert_eq!(Preferences::read(&path), Ok(Preferences::default()), "odd values and later versions are survived");
    }

    #[test]
    fn views_are_kept_by_file_and_broken_ones_are_left_out() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("window.toml");
        let camera = camera::first(&crate::scene::builtin::build("stack").unwrap().bounds(), 1.3);
        let view = |name: &str, camera| SavedView { name: name.to_owned(), camera };
        let mut preferences = Preferences::default();
        preferences.remember("/b.glb");
        preferences.save_view("/a.glb", view("side", camera));
        preferences.save_view("/a.glb", view("flat", camera::other_projection(&camera)));
        preferences.save_view("/a.glb", view("side", camera::spun(&camera, camera.focal_point, 30.0)));
        assert_eq!(preferences.views_of("/a.glb").len(), 2);
        preferences.write(&path).unwrap();
        assert_eq!(Preferences::read(&path), Ok(preferences.clone()), "bit for bit");
        let broken = Camera { position: camera.focal_point, ..camera };
        let mut bad = preferences.clone();
        bad.save_view("builtin:stack", view("broken", broken));
        bad.write(&path).unwrap();
        assert_eq!(Preferences::read(&path), Ok(preferences.clone()));
        preferences.forget_view("/a.glb", "side");
        preferences.forget_view("/a.glb", "flat");
        assert!(preferences.views.is_empty());
    }

    #[test]
    fn recent_files_are_unique_newest_first_and_few() {
        let mut preferences = Preferences::default();
        for i in 0..20 {
            preferences.remember(&format!("/{i}.glb"));
        }
        preferences.remember("/15.glb");
        preferences.remember("builtin:gearbox");
        assert_eq!(preferences.recent[..3], ["builtin:gearbox", "/15.glb", "/19.glb"]);
        assert_eq!(preferences.recent.len(), MOST_RECENT);
    }
}
