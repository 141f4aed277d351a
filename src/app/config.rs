//! What the window remembers from one time to the next: a small TOML file in the user's configuration folder.
//!
//! `$XDG_CONFIG_HOME/pellucid/window.toml`, or below `~/.config`. A file that cannot be read is replaced by the defaults with a
//! message; it never keeps the window from opening.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::camera::Habits;

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
    /// Whether the transfer-function editors are shown.
    pub editors: bool,
    /// Files, newest first.
    pub recent: Vec<String>,
}

impl Default for Preferences {
    fn default() -> Preferences {
        Preferences {
            theme: Theme::default(),
            scale: 1.0,
            mouse: Habits::default(),
            parts: true,
            stages: true,
            editors: true,
            recent: Vec::new(),
        }
    }
}

impl Preferences {
    /// Puts a file at the top of the recent ones. Paths are made absolute, so that they can be found from elsewhere.
    pub fn remember(&mut self, file: &str) {
        let name = if file.starts_with("builtin:") {
            file.to_owned()
        } else {
            std::path::absolute(file).map_or_else(|_| file.to_owned(), |p| p.to_string_lossy().into_owned())
        };
        self.recent.retain(|f| *f != name);
        self.recent.insert(0, name);
        self.recent.truncate(MOST_RECENT);
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
