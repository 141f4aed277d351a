//! `render --watch`: the picture again whenever what it is made from changes.
//!
//! Followed are the model, the files that it names (buffers, textures, materials: beside it or one folder below), the session,
//! the settings file and the file of transfer functions. The system tells that something happened in their folders; whether
//! anything changed is then judged by size and time of the files themselves, when they have been still for `STILL`, so that
//! writing the picture into the same folder draws no other one. What was seen before a picture is begun counts, so a file that
//! changes while it is drawn is not missed.
//!
//! A file that is broken leaves the last good picture where it is, and says why. Ctrl-C calls off what is being done and ends
//! with 0; a second one ends at once.

use std::collections::{BTreeMap, BTreeSet};
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, SystemTime};

use notify::{RecursiveMode, Watcher};

use super::failure::{Exit, Failure};
use super::load::{BUILTIN, STDIN};
use super::options::RenderArgs;
use super::output::{self, Progress};
use super::picture::{Encoding, Studio, draw};
use crate::import::Cancel;
use crate::session::configuration::Configuration;
use crate::transfer::TransferSource;

/// How long files have to be left alone before they are read: editors write in several steps.
const STILL: Duration = Duration::from_millis(150);
/// How much of a model is searched for the names of other files, bytes.
const SEARCHED: u64 = 16 << 20;
/// Most files of a folder that are looked at.
const MOST_FILES: usize = 4096;

enum Told {
    Changed,
    Stop,
}

/// Files and what they were when they were last looked at; `None` for one that is not there.
type Prints = BTreeMap<PathBuf, Option<(SystemTime, u64)>>;

fn print_of(path: &Path) -> Option<(SystemTime, u64)> {
    let facts = std::fs::metadata(path).ok()?;
    Some((facts.modified().ok()?, facts.len()))
}

/// Draws, waits, and draws again, until it is stopped.
///
/// # Errors
/// [`Failure`] of a command line that can never work, and of an adapter that is not there.
pub fn run(args: &RenderArgs, configuration: &Configuration, encoding: Encoding) -> Result<(), Failure> {
    let usage = |text: &str| Err(Failure::new(Exit::Usage, format!("--watch: {text}")));
    let Some(target) = args.output.as_deref().filter(|o| *o != Path::new(STDIN)) else {
        return usage("a picture that is drawn again needs a file: -o picture.png");
    };
    if args.view.file.as_deref() == Some(Path::new(STDIN)) {
        return usage("standard input is read once");
    }
    let (told, orders) = channel();
    let stopped = Arc::new(AtomicBool::new(false));
    let cancel = Cancel::default();
    let (stop, off, end) = (Arc::clone(&stopped), cancel.clone(), told.clone());
    let handled = ctrlc::set_handler(move || {
        if stop.swap(true, Ordering::SeqCst) {
            std::process::exit(130);
        }
        off.cancel();
        let _ = end.send(Told::Stop);
    });
    handled.map_err(|e| Failure::of(Exit::General, &e))?;
    let heard = move |event: notify::Result<notify::Event>| {
        if event.is_ok_and(|e| !e.kind.is_access()) {
            let _ = told.send(Told::Changed);
        }
    };
    let mut watcher = notify::recommended_watcher(heard).map_err(|e| Failure::of(Exit::General, &e))?;
    let mut folders = BTreeSet::new();
    let mut studio = Studio::default();
    studio.cancel = Some(Arc::clone(&stopped));
    let mut before = Prints::new();
    let mut first = true;
    loop {
        let now: Prints = before.keys().map(|path| (path.clone(), print_of(path))).collect();
        if first || now != before {
            before = now;
            let (followed, drawn) = once(args, configuration, encoding, &mut studio, &cancel, target);
            if stopped.load(Ordering::SeqCst) {
                return Ok(());
            }
            match drawn {
                Err(failure) if first && matches!(failure.exit, Exit::Usage | Exit::NoAdapter) => return Err(failure),
                Err(failure) => {
                    let kept = if target.exists() { "; the last picture stays" } else { "" };
                    output::complain(&format!("{}{kept}", failure.line()));
                }
                Ok(()) => {}
            }
            first = false;
            // What was followed already keeps how it was before the picture was begun.
            for path in followed {
                before.entry(path.clone()).or_insert_with(|| print_of(&path));
                watch_folder(&mut watcher, &mut folders, &path);
            }
        }
        if !wait(&orders) {
            return Ok(());
        }
    }
}

fn watch_folder(watcher: &mut impl Watcher, folders: &mut BTreeSet<PathBuf>, path: &Path) {
    // The folder, because editors put a new file in the place of the old one.
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new(".")).to_path_buf();
    if folders.contains(&folder) {
        return;
    }
    if let Err(e) = watcher.watch(&folder, RecursiveMode::NonRecursive) {
        output::complain(&format!("pellucid: {}: cannot be watched: {e}", folder.display()));
    }
    folders.insert(folder);
}

/// Waits until something has happened and it has been still for a while; no if it is to stop.
fn wait(orders: &Receiver<Told>) -> bool {
    match orders.recv() {
        Ok(Told::Changed) => {}
        Ok(Told::Stop) | Err(_) => return false,
    }
    loop {
        match orders.recv_timeout(STILL) {
            Ok(Told::Changed) => {}
            Ok(Told::Stop) | Err(RecvTimeoutError::Disconnected) => return false,
            Err(RecvTimeoutError::Timeout) => return true,
        }
    }
}

/// Draws one picture, and says which files it was made from, as far as that is known.
fn once(
    args: &RenderArgs,
    configuration: &Configuration,
    encoding: Encoding,
    studio: &mut Studio,
    cancel: &Cancel,
    target: &Path,
) -> (BTreeSet<PathBuf>, Result<(), Failure>) {
    let mut followed: BTreeSet<PathBuf> =
        [&args.view.session, &args.view.look.settings].into_iter().flatten().cloned().collect();
    let named = |file: &Path| file.to_str().is_none_or(|t| !t.starts_with(BUILTIN));
    followed.extend(args.view.file.clone().filter(|f| named(f)));
    followed.extend(args.view.look.transfer.as_deref().and_then(function_file));
    let mut asked = match args.view.asked(configuration) {
        Ok(asked) => asked,
        Err(failure) => return (followed, Err(failure)),
    };
    if named(&asked.file) {
        followed.extend(files_of(&asked.file));
    }
    if let TransferSource::Named(name) = &asked.settings.opacity.transfer {
        followed.extend(function_file(name));
    }
    // The picture is not made from itself, even if a model names it.
    let own = std::path::absolute(target).ok();
    followed.retain(|path| std::path::absolute(path).ok() != own);
    asked.options.cancel = cancel.clone();
    // Read, not mapped: what is watched is about to be written, and a mapping that is cut off ends the program.
    asked.options.map_from = u64::MAX;
    let progress = Progress::new();
    let drawn = draw(args, asked, encoding, studio, &progress).and_then(|drawn| match drawn {
        Some(drawn) => {
            output::write(target, &drawn.bytes(encoding)?)?;
            drawn.write_stats(args)?;
            drawn.say(&progress);
            Ok(())
        }
        None => Ok(()),
    });
    (followed, drawn)
}

/// The file that a name of transfer functions stands for, if it is one.
fn function_file(name: &str) -> Option<PathBuf> {
    if !name.contains(['/', '\\', '.']) {
        return None;
    }
    let whole = PathBuf::from(name);
    // After `#` may stand which of several maps.
    let without = name.rsplit_once('#').map(|(file, _)| PathBuf::from(file));
    Some(if whole.exists() { whole } else { without.unwrap_or(whole) })
}

/// A model and the files beside it or one folder below whose names stand in it.
fn files_of(model: &Path) -> BTreeSet<PathBuf> {
    let mut all = BTreeSet::from([model.to_path_buf()]);
    let folder = model.parent().unwrap_or(Path::new(""));
    let mut text = beginning(model);
    let mut beside = entries(folder, "");
    // Materials of an OBJ are in files of their own, which name the textures.
    for (name, path) in &beside {
        if name.to_ascii_lowercase().ends_with(".mtl") && contains(&text, name) {
            let more = beginning(path);
            text.push(b'\n');
            text.extend(more);
        }
    }
    let inner: Vec<(String, PathBuf)> = beside.iter().filter(|(_, p)| p.is_dir()).cloned().collect();
    for (name, path) in inner {
        beside.extend(entries(&path, &format!("{name}/")));
    }
    // A URI writes blanks and the like as %20.
    let decoded: Vec<u8> = percent_encoding::percent_decode(&text).collect();
    let named = |name: &str| contains(&text, name) || contains(&decoded, name);
    all.extend(beside.into_iter().filter(|(name, path)| path.is_file() && named(name)).map(|(_, path)| path));
    all
}

fn entries(folder: &Path, before: &str) -> Vec<(String, PathBuf)> {
    let list = std::fs::read_dir(if folder.as_os_str().is_empty() { Path::new(".") } else { folder });
    let named = |entry: std::fs::DirEntry| {
        let name = entry.file_name();
        Some((format!("{before}{}", name.to_str()?), folder.join(&name)))
    };
    list.into_iter().flatten().flatten().take(MOST_FILES).filter_map(named).collect()
}

fn beginning(path: &Path) -> Vec<u8> {
    let mut bytes = Vec::new();
    if path.is_file()
        && let Ok(file) = std::fs::File::open(path)
    {
        // What cannot be read is said when the model is.
        let _ = file.take(SEARCHED).read_to_end(&mut bytes);
    }
    bytes
}

fn contains(text: &[u8], name: &str) -> bool {
    let name = name.as_bytes();
    let Some(&first) = name.first() else { return false };
    let starts = text.iter().enumerate().filter(|(_, b)| **b == first).map(|(at, _)| at);
    starts.into_iter().any(|at| text[at..].starts_with(name))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_that_a_model_names_are_followed_and_no_others() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        std::fs::create_dir(path("maps")).unwrap();
        for name in ["a.bin", "b.png", "wood grain.png", "other.png", "maps/steel.png", "maps/none.png"] {
            std::fs::write(path(name), b"x").unwrap();
        }
        let gltf = r#"{"buffers":[{"uri":"a.bin"}],"images":[{"uri":"wood%20grain.png"},{"uri":"maps/steel.png"}]}"#;
        std::fs::write(path("m.gltf"), gltf).unwrap();
        let names = |files: &[&str]| files.iter().map(|f| path(f)).collect::<BTreeSet<_>>();
        assert_eq!(files_of(&path("m.gltf")), names(&["m.gltf", "a.bin", "wood grain.png", "maps/steel.png"]));
        std::fs::write(path("m.mtl"), "newmtl a\nmap_Kd b.png\n").unwrap();
        std::fs::write(path("m.obj"), "mtllib m.mtl\nv 0 0 0\n").unwrap();
        assert_eq!(files_of(&path("m.obj")), names(&["m.obj", "m.mtl", "b.png"]));
        assert_eq!(files_of(&path("missing.glb")), names(&["missing.glb"]));
    }

    #[test]
    fn functions_are_followed_where_they_are_files() {
        assert_eq!(function_file("x-ray"), None);
        assert_eq!(function_file("maps/a.json#Hot"), Some("maps/a.json".into()));
        assert_eq!(function_file("./look"), Some("./look".into()));
    }
}
