//! Files that somebody edits beside the window: read again when they change.
//!
//! Two kinds. The transfer functions in use, if they are in a file: one that the settings name by its path, and, where the
//! program runs in a checkout of itself, one of `transfer_functions/`. And the shaders: those below the folder that
//! `PELLUCID_SHADERS` names, or `shaders/` of a checkout. A checkout is a current folder whose `Cargo.toml` is this program's;
//! anywhere else only what is in the program is used, so an installed program cannot be changed by where it is started.
//!
//! A thread of its own waits until the files have been still for `STILL`, reads them and checks them; only what is sound is
//! taken over. What is not is said once, with file and line, and the last good one stays.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::Duration;

use notify::{RecursiveMode, Watcher};

use crate::gpu::{GpuError, check_shader, shader_files};
use crate::passes::shaders::all_shaders;
use crate::transfer::{Imported, TransferSource};

/// How long a file has to be left alone before it is read: editors write in several steps.
const STILL: Duration = Duration::from_millis(150);

/// Texts that stand in for shader modules, by module.
pub type ShaderTexts = BTreeMap<String, String>;

/// What has changed.
#[derive(Debug)]
pub enum Changed {
    /// A transfer function in use: how the settings name it, and what it says now.
    Function(String, Result<Imported, String>),
    /// Shaders that differ from those in the program; they are valid.
    Shaders(Arc<ShaderTexts>),
    /// A shader is not valid: file, line and why.
    BrokenShader(String),
    /// Nothing can be watched.
    Fault(String),
}

enum Told {
    Event,
    /// The transfer function in use: its name in the settings.
    Use(Option<String>),
}

/// A thread that watches.
pub struct Watch {
    told: Sender<Told>,
    changes: Receiver<Changed>,
    used: Option<String>,
}

/// Folders that are worked in.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Workshop {
    /// Shaders.
    pub shaders: Option<PathBuf>,
    /// Transfer functions by name.
    pub functions: Option<PathBuf>,
}

impl Workshop {
    /// The folders, given the current one and what `PELLUCID_SHADERS` says.
    pub fn find(current: &Path, shaders: Option<PathBuf>) -> Workshop {
        let manifest = std::fs::read_to_string(current.join("Cargo.toml")).unwrap_or_default();
        let ours = manifest.lines().any(|l| l.trim() == concat!("name = \"", env!("CARGO_PKG_NAME"), "\""));
        let folder = |name: &str| Some(current.join(name)).filter(|f| ours && f.is_dir());
        Workshop { shaders: shaders.or_else(|| folder("shaders")), functions: folder("transfer_functions") }
    }

    /// The file of transfer functions that the settings name.
    fn file_of(&self, name: &str) -> Option<PathBuf> {
        if name.contains(['/', '\\', '.']) {
            let on_disk = PathBuf::from(name);
            // After `#` may stand which of several maps.
            let without = name.rsplit_once('#').map(|(file, _)| PathBuf::from(file));
            return if on_disk.exists() { Some(on_disk) } else { without.or(Some(on_disk)) };
        }
        self.functions.as_ref().map(|folder| folder.join(format!("{name}.toml"))).filter(|f| f.is_file())
    }

    /// Reads a named function from its file.
    fn read(&self, name: &str) -> Result<Imported, String> {
        let source = match self.file_of(name) {
            Some(file) if !name.contains(['/', '\\', '.']) => file.to_string_lossy().into_owned(),
            _ => name.to_owned(),
        };
        TransferSource::Named(source).import(None, None).map_err(|e| e.to_string())
    }
}

impl Watch {
    /// Starts watching; `wake` is called, from the thread, when there is something to [`Watch::take`].
    pub fn start(workshop: Workshop, wake: impl Fn() + Send + 'static) -> Watch {
        let (told, orders) = channel();
        let (sender, changes) = channel();
        let events = told.clone();
        let tell = move |change| {
            // The window may be gone.
            let _ = sender.send(change);
            wake();
        };
        let spawned = std::thread::Builder::new().name("watch".to_owned()).spawn(move || {
            let heard = move |event: notify::Result<notify::Event>| {
                if event.is_ok_and(|e| !e.kind.is_access()) {
                    let _ = events.send(Told::Event);
                }
            };
            match notify::recommended_watcher(heard) {
                Ok(watcher) => Thread::new(workshop, watcher, tell).run(&orders),
                Err(e) => tell(Changed::Fault(format!("Files cannot be watched: {e}"))),
            }
        });
        if let Err(e) = spawned {
            tracing::error!("files are not watched: {e}");
        }
        Watch { told, changes, used: None }
    }

    /// Says which transfer functions are in use.
    pub fn follow(&mut self, source: Option<&TransferSource>) {
        let name = match source {
            Some(TransferSource::Named(name)) => Some(name.clone()),
            _ => None,
        };
        if name != self.used {
            self.used.clone_from(&name);
            let _ = self.told.send(Told::Use(name));
        }
    }

    /// What has changed since the last call.
    pub fn take(&self) -> Vec<Changed> {
        self.changes.try_iter().collect()
    }
}

/// What lives on the thread.
struct Thread<W, T> {
    workshop: Workshop,
    watcher: W,
    tell: T,
    /// Folders that are watched.
    folders: BTreeSet<PathBuf>,
    used: Option<String>,
    function: Option<Result<Imported, String>>,
    shaders: ShaderTexts,
    complaint: Option<String>,
}

impl<W: Watcher, T: Fn(Changed)> Thread<W, T> {
    fn new(workshop: Workshop, watcher: W, tell: T) -> Thread<W, T> {
        Thread {
            workshop,
            watcher,
            tell,
            folders: BTreeSet::new(),
            used: None,
            function: None,
            shaders: ShaderTexts::new(),
            complaint: None,
        }
    }

    fn run(&mut self, orders: &Receiver<Told>) {
        if let Some(folder) = self.workshop.shaders.clone() {
            if let Err(e) = self.watcher.watch(&folder, RecursiveMode::Recursive) {
                (self.tell)(Changed::Fault(format!("{} cannot be watched: {e}", folder.display())));
            }
            self.look_at_shaders();
        }
        while let Ok(told) = orders.recv() {
            let mut changed = self.obey(told);
            // Until it has been still for a while.
            loop {
                match orders.recv_timeout(STILL) {
                    Ok(told) => changed |= self.obey(told),
                    Err(RecvTimeoutError::Timeout) => break,
                    Err(RecvTimeoutError::Disconnected) => return,
                }
            }
            if changed {
                self.look_at_function();
                self.look_at_shaders();
            }
        }
    }

    /// Whether anything may have changed.
    fn obey(&mut self, told: Told) -> bool {
        let Told::Use(name) = told else {
            return true;
        };
        self.used = name;
        self.function = None;
        let Some(name) = &self.used else {
            return false;
        };
        let Some(file) = self.workshop.file_of(name) else {
            return false;
        };
        // The folder, because editors put a new file in the place of the old one.
        let folder = file.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new(".")).to_path_buf();
        if !self.folders.contains(&folder) {
            match self.watcher.watch(&folder, RecursiveMode::NonRecursive) {
                Ok(()) => {
                    self.folders.insert(folder);
                }
                Err(e) => (self.tell)(Changed::Fault(format!("{} cannot be watched: {e}", folder.display()))),
            }
        }
        // As it is in use now: what is the same later is no news. A name stands for what is in the program.
        let in_program = !name.contains(['/', '\\', '.']);
        let now = if in_program {
            TransferSource::Named(name.clone()).import(None, None).map_err(|e| e.to_string())
        } else {
            self.workshop.read(name)
        };
        self.function = Some(now);
        in_program
    }

    fn look_at_function(&mut self) {
        let Some(name) = self.used.clone().filter(|n| self.workshop.file_of(n).is_some()) else {
            return;
        };
        let read = self.workshop.read(&name);
        if self.function.as_ref() != Some(&read) {
            self.function = Some(read.clone());
            (self.tell)(Changed::Function(name, read));
        }
    }

    fn look_at_shaders(&mut self) {
        let Some(folder) = &self.workshop.shaders else {
            return;
        };
        let texts = texts_below(folder);
        let same = texts == self.shaders;
        match check(&self.shaders, &texts) {
            Ok(()) => {
                self.complaint = None;
                if !same {
                    self.shaders.clone_from(&texts);
                    (self.tell)(Changed::Shaders(Arc::new(texts)));
                }
            }
            Err(e) => {
                let complaint = format!("{} (the last good shaders are kept)", in_folder(&e, folder));
                if self.complaint.as_ref() != Some(&complaint) {
                    self.complaint = Some(complaint.clone());
                    (self.tell)(Changed::BrokenShader(complaint));
                }
            }
        }
    }
}

/// Shader modules that read differently below a folder than in the program. A file that is not there is the program's.
fn texts_below(folder: &Path) -> ShaderTexts {
    shader_files()
        .into_iter()
        .filter_map(|(path, own)| {
            let text = std::fs::read_to_string(folder.join(&path)).ok().filter(|text| text != own)?;
            Some((path.strip_suffix(".wgsl")?.to_owned(), text))
        })
        .collect()
}

/// Checks every shader that any plan can ask for and that has changed between two sets of texts.
fn check(before: &ShaderTexts, after: &ShaderTexts) -> Result<(), GpuError> {
    let changed: BTreeSet<String> = before
        .keys()
        .chain(after.keys())
        .filter(|module| before.get(*module) != after.get(*module))
        .map(|module| format!("{module}.wgsl"))
        .collect();
    if changed.is_empty() {
        return Ok(());
    }
    let mut seen = BTreeSet::new();
    for shader in all_shaders() {
        check_shader(&shader.spec, after, &changed, &mut seen)?;
    }
    Ok(())
}

fn in_folder(error: &GpuError, folder: &Path) -> String {
    match error {
        GpuError::Shader { file, line, reason } => {
            format!("{}:{line}: {}", folder.join(file).display(), reason.trim())
        }
        other => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Instant;

    fn wait(watch: &Watch) -> Changed {
        let begin = Instant::now();
        loop {
            if let Some(change) = watch.take().pop() {
                return change;
            }
            assert!(begin.elapsed() < Duration::from_secs(60), "nothing was heard");
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    #[test]
    fn a_function_that_is_edited_is_read_and_a_broken_one_says_where() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mine.toml");
        let write = |opacity: &str| {
            let text = format!(
                "[color]\npoints = [{{ kappa = 0, color = 0.5 }}]\n[opacity]\ncurves = [{{ depth = 0, points = [[0, {opacity}]] }}]\n"
            );
            // As many editors do: another file in its place.
            let draft = folder.path().join("mine.toml~");
            std::fs::write(&draft, text).unwrap();
            std::fs::rename(&draft, &path).unwrap();
        };
        write("0.25");
        let mut watch = Watch::start(Workshop::default(), || {});
        let name = path.to_string_lossy().into_owned();
        watch.follow(Some(&TransferSource::Named(name.clone())));
        std::thread::sleep(4 * STILL);
        assert!(watch.take().is_empty(), "nothing has changed yet");
        write("0.75");
        match wait(&watch) {
            Changed::Function(of, Ok(imported)) => {
                assert_eq!((of, imported.function.opacity.sample(0.0, 0.0)), (name, 0.75));
            }
            other => panic!("{other:?}"),
        }
        write("7");
        match wait(&watch) {
            Changed::Function(_, Err(reason)) => assert!(reason.contains("mine.toml:4:"), "{reason}"),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn shaders_are_checked_before_they_are_taken() {
        let folder = tempfile::tempdir().unwrap();
        let module = "passes/opacity/transfer";
        let (_, own) = shader_files().into_iter().find(|(p, _)| *p == format!("{module}.wgsl")).unwrap();
        std::fs::create_dir_all(folder.path().join("passes/opacity")).unwrap();
        let file = folder.path().join(format!("{module}.wgsl"));
        std::fs::write(&file, own).unwrap();
        let workshop = Workshop { shaders: Some(folder.path().to_path_buf()), functions: None };
        let watch = Watch::start(workshop, || {});
        std::thread::sleep(4 * STILL);
        assert!(watch.take().is_empty(), "they are those of the program");
        let changed = own.replacen("return transfer.gain", "return 0.5 * transfer.gain", 1);
        assert_ne!(changed, own);
        std::fs::write(&file, &changed).unwrap();
        match wait(&watch) {
            Changed::Shaders(texts) => assert_eq!(*texts, [(module.to_owned(), changed.clone())].into()),
            other => panic!("{other:?}"),
        }
        let line = changed.lines().position(|l| l.contains("0.5 * transfer.gain")).unwrap() + 1;
        std::fs::write(&file, changed.replace("0.5 * transfer.gain", "nonsense * transfer.gain")).unwrap();
        match wait(&watch) {
            Changed::BrokenShader(reason) => {
                assert!(reason.contains(&format!("transfer.wgsl:{line}:")) && reason.contains("nonsense"), "{reason}");
            }
            other => panic!("{other:?}"),
        }
        std::fs::write(&file, own).unwrap();
        assert!(matches!(wait(&watch), Changed::Shaders(texts) if texts.is_empty()));
    }

    #[test]
    fn only_a_checkout_is_a_workshop() {
        let folder = tempfile::tempdir().unwrap();
        let here = folder.path();
        std::fs::create_dir(here.join("shaders")).unwrap();
        std::fs::write(here.join("Cargo.toml"), "[package]\nname = \"another\"\n").unwrap();
        assert_eq!(Workshop::find(here, None), Workshop::default());
        let named = Some(PathBuf::from("/elsewhere"));
        assert_eq!(Workshop::find(here, named.clone()), Workshop { shaders: named, functions: None });
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        let both = Workshop { shaders: Some(root.join("shaders")), functions: Some(root.join("transfer_functions")) };
        assert_eq!(Workshop::find(root, None), both);
        assert_eq!(both.file_of("pellucid"), Some(root.join("transfer_functions/pellucid.toml")));
        assert_eq!(both.file_of("no such"), None);
        assert_eq!(Workshop::default().file_of("a/b.json#map"), Some(PathBuf::from("a/b.json")));
    }
}
