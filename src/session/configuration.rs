//! The configuration file: what counts where neither a command line nor a session says anything.
//!
//! ```toml
//! [settings]                    # for the window and for pictures: any setting, by path
//! opacity.gain = 1.2
//!
//! [render]                      # for pictures only
//! size = "1600x1200"
//! preset = "x-ray"              # counts less than [settings]
//! samples = 4
//! background = "#ffffff"
//! bits = 16                     # of a channel of a PNG
//!
//! [import]
//! parts = "component"           # or auto, node, material, file
//! crease_angle = 40             # degrees
//! limits.bytes = "8G"
//!
//! [converters]                  # from an ending to a program
//! step = "gmsh {in} -2 -clcurv 20 -format stl -o {out.stl}"
//! ```
//!
//! Files are read in the order in which they count, least first: those of the system (`pellucid/config.toml` below each folder
//! of `$XDG_CONFIG_DIRS`, of which the first counts most; `/etc/xdg` if there is none), the user's (below `$XDG_CONFIG_HOME`,
//! or `~/.config`), and one that is named. They are merged value by value, and each value keeps the file and line that it is
//! from. Nothing in a file is passed over: a key that does not exist is an error with its line and the nearest name, in the
//! file of a system too, so that a typing error does not become a puzzle.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::io::Read;
use std::path::{Path, PathBuf};

use toml::Value;
use toml::de::DeTable;

use super::importing::{Importing, LIMITS, Limit, count, parts_name, parts_named};
use crate::import::ImportOptions;
use crate::settings::looks::{self, presets};
use crate::settings::{Settings, nearest};
use crate::transfer::{TransferSource, place_of};

/// Picture size unless another is asked for.
pub const SIZE: [u32; 2] = [1000, 1000];
/// Bits of a channel of a PNG unless others are asked for.
pub const BITS: u8 = 8;
/// Largest file that is read, bytes.
const LARGEST: u64 = 1 << 20;
/// What a configuration is called in its folder.
const NAME: &str = "pellucid/config.toml";
/// Keys of `[render]`.
const RENDER: [&str; 5] = ["size", "preset", "samples", "background", "bits"];

/// Why there is no configuration.
#[derive(Debug, thiserror::Error)]
pub enum ConfigurationError {
    /// A file is there, or is named, and cannot be read.
    #[error("{}: {source}", path.display())]
    Io {
        /// Which.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// A file says something that is not allowed.
    #[error("{}:{line}: {reason}", path.display())]
    Line {
        /// Which.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// What is wrong there.
        reason: String,
    },
}

/// Where configurations are looked for.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Places {
    /// Those of the system, the one that counts least first.
    pub system: Vec<PathBuf>,
    /// The user's.
    pub user: Option<PathBuf>,
    /// One that is named: it has to be there.
    pub named: Option<PathBuf>,
}

impl Places {
    /// As the environment says; `variable` reads it.
    pub fn of(variable: impl Fn(&str) -> Option<OsString>, named: Option<&Path>) -> Places {
        // Relative folders are to be passed over, says the XDG base directory specification.
        let folder = |name: &str| variable(name).map(PathBuf::from).filter(|p| p.is_absolute());
        let dirs = variable("XDG_CONFIG_DIRS").filter(|d| !d.is_empty()).unwrap_or_else(|| "/etc/xdg".into());
        let mut system: Vec<PathBuf> =
            std::env::split_paths(&dirs).filter(|p| p.is_absolute()).map(|p| p.join(NAME)).collect();
        system.reverse();
        let own = folder("XDG_CONFIG_HOME").or_else(|| folder("APPDATA"));
        let user = own.or_else(|| Some(folder("HOME")?.join(".config"))).map(|p| p.join(NAME));
        Places { system, user, named: named.map(Path::to_path_buf) }
    }

    /// All of them, the one that counts least first, and whether it has to be there.
    fn all(&self) -> impl Iterator<Item = (&PathBuf, bool)> {
        let unnamed = self.system.iter().chain(&self.user).map(|p| (p, false));
        unnamed.chain(self.named.iter().map(|p| (p, true)))
    }
}

/// A value and where it is from.
#[derive(Clone, Debug, PartialEq)]
struct Entry {
    value: Value,
    path: PathBuf,
    line: usize,
}

/// What configuration files say, merged.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Configuration {
    /// By dotted key.
    entries: BTreeMap<String, Entry>,
    /// Files that were looked for, and whether they are there.
    files: Vec<(PathBuf, bool)>,
}

impl Configuration {
    /// Reads and merges the files.
    ///
    /// # Errors
    /// [`ConfigurationError`] for a file that cannot be read, and for one that says something that is not allowed.
    pub fn read(places: &Places) -> Result<Configuration, ConfigurationError> {
        let mut all = Configuration::default();
        for (path, needed) in places.all() {
            let failed = |source| ConfigurationError::Io { path: path.clone(), source };
            match std::fs::File::open(path) {
                Ok(file) => {
                    let mut text = String::new();
                    file.take(LARGEST + 1).read_to_string(&mut text).map_err(failed)?;
                    if text.len() as u64 > LARGEST {
                        let reason = format!("larger than {} MiB", LARGEST >> 20);
                        return Err(failed(std::io::Error::new(std::io::ErrorKind::FileTooLarge, reason)));
                    }
                    all.add(path, &text)?;
                    all.files.push((path.clone(), true));
                }
                Err(e)
                    if !needed
                        && matches!(e.kind(), std::io::ErrorKind::NotFound | std::io::ErrorKind::NotADirectory) =>
                {
                    all.files.push((path.clone(), false));
                }
                Err(e) => return Err(failed(e)),
            }
        }
        Ok(all)
    }

    /// Adds what a file says, over what is there.
    fn add(&mut self, path: &Path, text: &str) -> Result<(), ConfigurationError> {
        let fault = |line, reason| ConfigurationError::Line { path: path.to_path_buf(), line, reason };
        let bad = |e: &toml::de::Error| {
            let (line, _, reason) = place_of(text, e);
            fault(line, reason)
        };
        let spans = DeTable::parse(text).map_err(|e| bad(&e))?;
        let mut lines = BTreeMap::new();
        lines_of(text, spans.get_ref(), "", &mut lines);
        let table: toml::Table = toml::from_str(text).map_err(|e| bad(&e))?;
        let mut leaves = Vec::new();
        leaves_of(&table, "", &mut leaves);
        for (key, value) in leaves {
            let line = lines.get(&key).copied().unwrap_or(1);
            let value = checked(&key, value, path).map_err(|reason| fault(line, reason))?;
            self.entries.insert(key, Entry { value, path: path.to_path_buf(), line });
        }
        Ok(())
    }

    fn value(&self, key: &str) -> Option<&Value> {
        self.entries.get(key).map(|e| &e.value)
    }

    fn text(&self, key: &str) -> Option<&str> {
        self.value(key).and_then(Value::as_str)
    }

    /// Settings with which the window begins: the built-in ones under `[settings]`.
    pub fn settings(&self) -> Settings {
        self.over(Settings::default())
    }

    /// Settings of a picture of which the command line says nothing: the built-in ones, under the preset of `[render]` unless
    /// another one takes its place, under `[settings]`, under the rest of `[render]`.
    pub fn picture_settings(&self, with_preset: bool) -> Settings {
        let mut settings = Settings::default();
        if let Some(preset) = self.text("render.preset").filter(|_| with_preset) {
            // It was found when the file was read.
            let _ = looks::apply(&mut settings, preset);
        }
        let mut settings = self.over(settings);
        for (key, path) in [("render.samples", "image.samples"), ("render.background", "image.background")] {
            if let Some(value) = self.value(key) {
                let text = value.as_str().map_or_else(|| value.to_string(), str::to_owned);
                // It was checked when the file was read.
                let _ = settings.set(path, &text);
            }
        }
        settings
    }

    fn over(&self, mut settings: Settings) -> Settings {
        let mut tree = toml::Table::new();
        for (key, entry) in &self.entries {
            if let Some(path) = key.strip_prefix("settings.") {
                insert(&mut tree, path, entry.value.clone());
            }
        }
        // Each was checked when its file was read.
        let _ = settings.merge(&tree);
        settings
    }

    /// The size of a picture of which the command line says nothing.
    pub fn size(&self) -> [u32; 2] {
        self.text("render.size").and_then(|t| picture_size(t).ok()).unwrap_or(SIZE)
    }

    /// Bits of a channel of a PNG of which the command line says nothing.
    pub fn bits(&self) -> u8 {
        self.value("render.bits").and_then(Value::as_integer).and_then(|n| u8::try_from(n).ok()).unwrap_or(BITS)
    }

    /// What is imported how; converters too.
    pub fn import_options(&self) -> ImportOptions {
        let mut options = ImportOptions::default();
        if let Some(by) = self.text("import.parts").and_then(|t| parts_named(t).ok()) {
            options.parts = by;
        }
        if let Some(angle) = self.value("import.crease_angle").and_then(number) {
            options.crease_angle = angle;
        }
        for limit in LIMITS {
            if let Some(n) = self.value(&format!("import.limits.{}", limit.name)).and_then(|v| counted(v).ok()) {
                // It was checked when the file was read.
                let _ = limit.set(&mut options.limits, n);
            }
        }
        let converters = self.entries.iter().filter_map(|(key, entry)| {
            Some((key.strip_prefix("converters.")?.to_owned(), entry.value.as_str()?.to_owned()))
        });
        options.converters.extend(converters);
        options
    }

    /// The choices of an import that sessions keep.
    pub fn importing(&self) -> Importing {
        Importing::of(&self.import_options())
    }

    /// Everything that counts, as a file in which each line says where its value is from.
    pub fn listing(&self) -> String {
        let mut out = String::new();
        for (path, there) in &self.files {
            out += &format!("# {}: {}\n", path.display(), if *there { "read" } else { "not there" });
        }
        if self.files.is_empty() {
            out += "# no files are read\n";
        }
        let mut say = |key: &str, built_in: Option<Value>, unset: &str| {
            out += &match (self.entries.get(key), built_in) {
                (Some(e), _) => format!("{} = {}  # {}:{}\n", bare(key), e.value, e.path.display(), e.line),
                (None, Some(value)) => format!("{} = {value}  # built in\n", bare(key)),
                (None, None) => format!("# {} is not set: {unset}\n", bare(key)),
            };
        };
        for d in Settings::declarations() {
            say(&format!("settings.{}", d.path), Some(d.default), "");
        }
        let text = |t: String| Some(Value::String(t));
        say("render.size", text(format!("{}x{}", SIZE[0], SIZE[1])), "");
        say("render.preset", None, "settings are the built-in ones");
        say("render.samples", None, "settings.image.samples counts");
        say("render.background", None, "settings.image.background counts");
        say("render.bits", Some(Value::Integer(i64::from(BITS))), "");
        let ImportOptions { parts, crease_angle, limits, .. } = ImportOptions::default();
        say("import.parts", text(parts_name(parts).to_owned()), "");
        say("import.crease_angle", Some(Value::Float(crease_angle)), "");
        for limit in LIMITS {
            let value = i64::try_from(limit.get(&limits)).unwrap_or(i64::MAX);
            say(&format!("import.limits.{}", limit.name), Some(Value::Integer(value)), "");
        }
        for key in self.entries.keys().filter(|k| k.starts_with("converters.")) {
            say(key, None, "");
        }
        out
    }
}

/// A dotted key as TOML has it: the ending of a converter may need quotes.
fn bare(key: &str) -> String {
    let plain =
        |word: &str| !word.is_empty() && word.chars().all(|c| c.is_ascii_alphanumeric() || c == '_' || c == '-');
    match key.strip_prefix("converters.") {
        Some(ending) if !plain(ending) => format!("converters.{}", Value::String(ending.to_owned())),
        _ => key.to_owned(),
    }
}

/// The line of every key.
fn lines_of(text: &str, table: &DeTable<'_>, before: &str, lines: &mut BTreeMap<String, usize>) {
    for (key, value) in table {
        let path = format!("{before}{}", key.get_ref());
        let line = text.get(..key.span().start).map_or(0, |t| t.matches('\n').count()) + 1;
        if let Some(inner) = value.get_ref().as_table() {
            lines_of(text, inner, &format!("{path}."), lines);
        }
        lines.insert(path, line);
    }
}

/// What has to be checked: values, and tables where a value is meant, by dotted key.
fn leaves_of(table: &toml::Table, before: &str, leaves: &mut Vec<(String, Value)>) {
    for (key, value) in table {
        let path = format!("{before}{key}");
        let whole =
            path.strip_prefix("settings.").is_some_and(|p| Settings::default().get(p).is_some_and(|v| !v.is_table()));
        match value {
            Value::Table(inner) if !whole && is_table(&path) => leaves_of(inner, &format!("{path}."), leaves),
            _ => leaves.push((path, value.clone())),
        }
    }
}

/// Whether a key is that of a table.
fn is_table(path: &str) -> bool {
    ["settings", "render", "import", "import.limits", "converters"].contains(&path) || path.starts_with("settings.")
}

/// The value of a key, if it is one and may be this; a sentence if not.
fn checked(key: &str, value: Value, path: &Path) -> Result<Value, String> {
    let (room, rest) = key.split_once('.').unwrap_or((key, ""));
    let expected = |what: &str| Err(format!("{key} = {value}: expected {what}"));
    let unknown = |names: &[&str]| {
        let hint = nearest(rest, names.iter().copied()).map(|n| format!("; did you mean '{room}.{n}'?"));
        Err(format!("no key is called '{key}'{}", hint.unwrap_or_default()))
    };
    match (room, rest) {
        ("settings" | "render" | "import" | "converters", "") => expected("a table"),
        ("settings", setting) => {
            let mut tree = toml::Table::new();
            insert(&mut tree, setting, value.clone());
            Settings::default().merge(&tree).map_err(|e| e.to_string())?;
            // Its paths count from the file's folder.
            if setting == "opacity.transfer"
                && let Value::String(name) = &value
                && let TransferSource::Named(name) =
                    TransferSource::Named(name.clone()).rebased(path.parent().unwrap_or(Path::new("")))
            {
                return Ok(Value::String(name));
            }
            Ok(value)
        }
        ("render", "size") => match value.as_str().map(picture_size) {
            Some(Ok(_)) => Ok(value),
            _ => expected("width and height in pixels, as in \"1600x1200\""),
        },
        ("render", "preset") => {
            let name = value.as_str().unwrap_or_default();
            if presets().any(|(known, _)| known == name) {
                return Ok(value);
            }
            let hint = nearest(name, presets().map(|(known, _)| known)).map(|n| format!("; did you mean '{n}'?"));
            expected(&format!("a name that `pellucid presets` lists{}", hint.unwrap_or_default()))
        }
        ("render", "samples" | "background") => {
            let text = value.as_str().map_or_else(|| value.to_string(), str::to_owned);
            match Settings::default().set(&format!("image.{rest}"), &text) {
                Ok(()) => Ok(value),
                Err(e) => Err(format!("{key}: {e}")),
            }
        }
        ("render", "bits") => match value.as_integer() {
            Some(8 | 16) => Ok(value),
            _ => expected("8 or 16"),
        },
        ("render", _) => unknown(&RENDER),
        ("import", "parts") => match value.as_str().map(parts_named) {
            Some(Ok(_)) => Ok(value),
            Some(Err(e)) => Err(format!("{key} = {e}")),
            None => expected("auto, node, material, component or file"),
        },
        ("import", "crease_angle") => match number(&value) {
            Some(angle) if (0.0..=180.0).contains(&angle) => Ok(value),
            _ => expected("degrees from 0 to 180"),
        },
        ("import", "limits") => expected("a table"),
        ("import", limit) if limit.starts_with("limits.") => {
            let limit = Limit::named(&limit["limits.".len()..])?;
            let n = counted(&value).map_err(|e| format!("{key} = {e}"))?;
            limit.set(&mut crate::import::Limits::default(), n)?;
            Ok(value)
        }
        ("import", _) => unknown(&["parts", "crease_angle", "limits"]),
        ("converters", ending) => match value.as_str() {
            Some(line) if line.contains("{in}") && writes(line) && ending == ending.to_lowercase() => Ok(value),
            Some(_) if ending != ending.to_lowercase() => Err(format!("{key}: endings are written in lower case")),
            _ => expected("a command line with {in} and {out} in it, or {out.stl} and the like"),
        },
        _ => {
            let hint = nearest(room, ["settings", "render", "import", "converters"]);
            let hint = hint.map(|n| format!("; did you mean [{n}]?")).unwrap_or_default();
            Err(format!("no key is called '{room}'{hint}"))
        }
    }
}

/// Whether a converter's line says where it writes: `{out}`, or with an ending, as `{out.stl}`.
fn writes(line: &str) -> bool {
    ["{out}", "{out.", "{out:"].iter().any(|o| line.contains(o))
}

fn number(value: &Value) -> Option<f64> {
    value.as_float().or_else(|| value.as_integer().map(|n| n as f64))
}

/// A count as a number, or as text with k, M, G or T.
fn counted(value: &Value) -> Result<u64, String> {
    match value {
        Value::String(text) => count(text),
        Value::Integer(n) => u64::try_from(*n).map_err(|_| format!("{n}: expected a number that is not negative")),
        other => Err(format!("{other}: expected a whole number, as in 4096 or \"4G\"")),
    }
}

/// Puts a value into a tree by its dotted key.
fn insert(tree: &mut toml::Table, key: &str, value: Value) {
    let mut at = tree;
    let mut words: Vec<&str> = key.split('.').collect();
    let Some(last) = words.pop() else { return };
    for word in words {
        let next = at.entry(word.to_owned()).or_insert_with(|| Value::Table(toml::Table::new()));
        if !next.is_table() {
            *next = Value::Table(toml::Table::new());
        }
        match next {
            Value::Table(inner) => at = inner,
            _ => return,
        }
    }
    at.insert(last.to_owned(), value);
}

/// Parses `WxH`: both whole and at least 1.
///
/// # Errors
/// A sentence with the form.
pub fn picture_size(text: &str) -> Result<[u32; 2], String> {
    let side = |s: &str| s.parse::<u32>().ok().filter(|n| *n > 0 && s.bytes().all(|b| b.is_ascii_digit()));
    text.split_once('x')
        .and_then(|(w, h)| Some([side(w)?, side(h)?]))
        .ok_or_else(|| "expected width and height in pixels, at least 1, as in 1920x1080".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::import::PartsBy;

    fn said(text: &str) -> String {
        Configuration::default().add(Path::new("c.toml"), text).map_err(|e| e.to_string()).unwrap_err()
    }

    #[test]
    fn later_files_count_more_value_by_value() {
        let mut all = Configuration::default();
        let first =
            "[settings]\nopacity.gain = 2\nopacity.constant = 0.5\n[import]\nlimits.bytes = '1M'\nparts = 'file'\n";
        all.add(Path::new("/a/one.toml"), first).unwrap();
        let second = "settings.opacity.gain = 3\n[import]\nlimits.triangles = 9\ncrease_angle = 40\n[converters]\nstep = 'x {in} {out.stl}'\n\
                      [render]\nsize = '64x32'\nsamples = 3\npreset = 'plain'\nbits = 16\n";
        all.add(Path::new("/b/two.toml"), second).unwrap();
        let settings = all.settings();
        assert_eq!((settings.opacity.gain, settings.opacity.constant, settings.image.samples), (3.0, 0.5, 1));
        let options = all.import_options();
        assert_eq!((options.parts, options.crease_angle), (Some(PartsBy::File), 40.0));
        assert_eq!((options.limits.bytes, options.limits.triangles), (1 << 20, 9));
        assert_eq!(options.converters, [("step".to_owned(), "x {in} {out.stl}".to_owned())].into());
        assert_eq!((all.size(), all.bits()), ([64, 32], 16));
        // The preset says 0.3, [settings] counts more; another preset takes its place.
        let picture = all.picture_settings(true);
        assert_eq!((picture.image.samples, picture.opacity.constant), (3, 0.5));
        assert_ne!(picture.opacity.model, all.picture_settings(false).opacity.model);
        let listing = all.listing();
        for line in [
            "settings.opacity.gain = 3  # /b/two.toml:1\n",
            "settings.opacity.constant = 0.5  # /a/one.toml:3\n",
            "settings.opacity.ghost = 0.06  # built in\n",
            "import.limits.bytes = \"1M\"  # /a/one.toml:5\n",
            "converters.step = \"x {in} {out.stl}\"  # /b/two.toml:6\n",
        ] {
            assert!(listing.contains(line), "{line}: {listing}");
        }
        // What is printed is a configuration that says the same.
        let mut again = Configuration::default();
        again.add(Path::new("c.toml"), &listing).unwrap();
        assert_eq!((again.settings(), again.import_options()), (settings, options));
        assert_eq!(again.size(), all.size());
    }

    #[test]
    fn what_is_wrong_has_its_line_and_a_suggestion() {
        for (text, line, words) in [
            ("[settings]\nopacity.gian = 2", 2, "did you mean 'opacity.gain'"),
            ("[settings]\n[settings.opacity]\ngain = -1", 3, "opacity.gain"),
            ("\n[render]\nsizes = '1x1'", 3, "did you mean 'render.size'"),
            ("[render]\nsize = '0x1'", 2, "1600x1200"),
            ("[render]\npreset = 'papr'", 2, "did you mean 'paper'"),
            ("[render]\nsamples = 0", 2, "image.samples"),
            ("[render]\nbits = 12", 2, "8 or 16"),
            ("[import]\nparts = 'components'", 2, "did you mean 'component'"),
            ("[import]\ncrease_angle = 'wide'", 2, "0 to 180"),
            ("[import]\nlimits.bites = 3", 2, "did you mean 'bytes'"),
            ("[import.limits]\nbytes = '3X'", 2, "4G"),
            ("[import]\nlimits = 3", 2, "a table"),
            ("[import]\nvariant = 'x'", 2, "no key is called 'import.variant'"),
            ("[converter]\nstep = 'x'", 1, "did you mean [converters]"),
            ("[converters]\nstep = 'x {in}'", 2, "{out}"),
            ("[converters]\nSTEP = 'x {in} {out}'", 2, "lower case"),
            ("\nsettings = 4", 2, "a table"),
            ("[settings]\nopacity = 4", 2, "opacity"),
            ("[settings]\n\nx = ", 3, ""),
        ] {
            let said = said(text);
            assert!(said.starts_with(&format!("c.toml:{line}: ")) && said.contains(words), "{text:?}: {said}");
        }
    }

    #[test]
    fn files_are_where_the_environment_says() {
        let places = |pairs: &[(&str, &str)]| {
            Places::of(|name| pairs.iter().find(|(n, _)| *n == name).map(|(_, v)| OsString::from(v)), None)
        };
        let usual = places(&[("HOME", "/home/u")]);
        assert_eq!(usual.system, [PathBuf::from("/etc/xdg/pellucid/config.toml")]);
        assert_eq!(usual.user, Some("/home/u/.config/pellucid/config.toml".into()));
        let own = places(&[("HOME", "/home/u"), ("XDG_CONFIG_HOME", "/c"), ("XDG_CONFIG_DIRS", "/one:rel:/two")]);
        assert_eq!(own.system, ["/two/pellucid/config.toml", "/one/pellucid/config.toml"].map(PathBuf::from));
        assert_eq!(own.user, Some("/c/pellucid/config.toml".into()));
        assert_eq!(places(&[("XDG_CONFIG_HOME", "relative")]).user, None);
        // What is not there is no fault, unless it was named.
        let folder = tempfile::tempdir().unwrap();
        let missing = folder.path().join("missing.toml");
        let read = Configuration::read(&Places { user: Some(missing.clone()), ..Places::default() }).unwrap();
        assert!(read.settings() == Settings::default() && read.listing().contains("missing.toml: not there"));
        let named = Places { named: Some(missing), ..Places::default() };
        assert!(Configuration::read(&named).unwrap_err().to_string().contains("missing.toml: "));
    }

    #[test]
    fn transfer_functions_count_from_the_file() {
        let mut all = Configuration::default();
        all.add(Path::new("/c/x/config.toml"), "settings.opacity.transfer = 'look.toml'").unwrap();
        assert_eq!(all.settings().opacity.transfer, TransferSource::Named("/c/x/look.toml".to_owned()));
        all.add(Path::new("/c/x/config.toml"), "settings.opacity.transfer = 'x-ray'").unwrap();
        assert_eq!(all.settings().opacity.transfer, TransferSource::Named("x-ray".to_owned()));
    }
}
