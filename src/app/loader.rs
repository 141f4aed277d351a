//! Opening a model without holding up the window: a thread, how far it is, and a way to call it off.

use std::io::Read;
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use super::camera;
use crate::import::{self, Cancel, ImportOptions};
use crate::scene::hard_case::{HardCase, Source};
use crate::scene::{Arrangement, Scene, Section, builtin};
use crate::session::{Importing, Session, camera_in_file};
use crate::settings::Settings;
use crate::tradeoff::hard_cases;

/// In front of the name of a generated scene.
const BUILTIN: &str = "builtin:";
/// In front of the name of a hard case: its scene, camera and our settings.
pub const HARD_CASE: &str = "hard-case:";
/// What is said where a hard case's model would be needed as a file.
pub const MADE_IN_MEMORY: &str = "The model of this hard case is made in memory: there is no file to name.";
/// Bytes read between two looks at the flag.
const PIECE: usize = 1 << 20;

/// A model and, if a session file asked for it, what is to be seen of it.
pub struct Opened {
    /// The model.
    pub scene: Scene,
    /// The session; its camera is in the file's coordinates.
    pub session: Option<Session>,
    /// The hard case that it belongs to; the session is of it then.
    pub case: Option<&'static HardCase>,
    /// How it was read.
    pub import: Importing,
}

/// Largest session file that is read, bytes.
const LARGEST_SESSION: u64 = 16 << 20;

/// What the thread is at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Phase {
    /// Reads; the share that is done.
    Reading(f32),
    /// Makes a scene of what was read.
    Building,
}

#[derive(Default)]
struct Shared {
    cancel: Cancel,
    read: AtomicU64,
    total: AtomicU64,
    building: AtomicBool,
    result: Mutex<Option<Result<Opened, String>>>,
}

/// A model on its way.
pub struct Loading {
    /// As it was asked for.
    pub file: String,
    shared: Arc<Shared>,
}

impl Loading {
    /// Begins. A session says itself how its model is read; otherwise `options` do. `wake` is called, from the thread, as it
    /// gets on and when it is done.
    pub fn begin(file: &str, options: &ImportOptions, wake: impl Fn() + Send + 'static) -> Loading {
        let shared = Arc::new(Shared::default());
        let (theirs, name) = (Arc::clone(&shared), file.to_owned());
        let options = ImportOptions { cancel: shared.cancel.clone(), ..options.clone() };
        let run = move || {
            let result =
                std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| load(&name, &options, &theirs, &wake)))
                    .unwrap_or_else(|_| Err(format!("{name}: the importer panicked; the log says where")));
            *theirs.result.lock().unwrap_or_else(PoisonError::into_inner) = Some(result);
            wake();
        };
        if let Err(e) = std::thread::Builder::new().name("loader".to_owned()).spawn(run) {
            *shared.result.lock().unwrap_or_else(PoisonError::into_inner) = Some(Err(format!("{file}: {e}")));
        }
        Loading { file: file.to_owned(), shared }
    }

    /// How far it is.
    pub fn phase(&self) -> Phase {
        let total = self.shared.total.load(Ordering::Relaxed);
        if self.shared.building.load(Ordering::Relaxed) || total == 0 {
            return Phase::Building;
        }
        Phase::Reading(self.shared.read.load(Ordering::Relaxed) as f32 / total as f32)
    }

    /// The scene, or why there is none, once.
    pub fn take(&self) -> Option<Result<Opened, String>> {
        self.shared.result.lock().unwrap_or_else(PoisonError::into_inner).take()
    }
}

impl Drop for Loading {
    /// Calls it off: reading stops, and decoding after the images and primitives at hand; a scene that is there all the same is
    /// thrown away.
    fn drop(&mut self) {
        self.shared.cancel.cancel();
    }
}

fn load(file: &str, options: &ImportOptions, shared: &Shared, wake: &impl Fn()) -> Result<Opened, String> {
    if let Some(name) = file.strip_prefix(HARD_CASE) {
        return hard_case(name);
    }
    let path = Path::new(file);
    if !file.starts_with(BUILTIN) && path.extension().is_some_and(|e| e.eq_ignore_ascii_case("toml")) {
        let said = |e: &dyn std::error::Error| format!("{file}: {}", full(e));
        let mut text = String::new();
        let source = std::fs::File::open(path).map_err(|e| said(&e))?;
        source.take(LARGEST_SESSION).read_to_string(&mut text).map_err(|e| said(&e))?;
        let folder = path.parent().unwrap_or(Path::new(""));
        let session = Session::from_toml(&text).map_err(|e| said(&e))?.rebased(folder);
        let scene = load_scene(session.file(), &session.import().options(options), shared, wake)?;
        let session = session.resolve(&scene).map_err(|e| said(&e))?;
        let import = session.import.clone();
        return Ok(Opened { scene, session: Some(session), case: None, import });
    }
    let scene = load_scene(file, options, shared, wake)?;
    Ok(Opened { scene, session: None, case: None, import: Importing::of(options) })
}

/// A hard case as it is drawn by our method.
fn hard_case(name: &str) -> Result<Opened, String> {
    let (_, case) =
        hard_cases::all().find(|(_, c)| c.name == name).ok_or_else(|| format!("no hard case is called '{name}'"))?;
    let source = case.ours.scene.unwrap_or(case.scene);
    let scene = hard_cases::scene_of(&source).map_err(|e| full(&e))?;
    let mut arrangement = Arrangement::default();
    if let Source::Cut(_, normal, offset) = source {
        arrangement.sections.push(Section { normal, offset, enabled: true, caps: false });
    }
    let file = match source {
        Source::Builtin(scene) | Source::Cut(scene, ..) => {
            format!("{BUILTIN}{}", scene.strip_prefix(BUILTIN).unwrap_or(scene))
        }
        Source::ThroughFile(_) | Source::Bytes(_) => format!("{HARD_CASE}{name}"),
    };
    let settings = Settings::from_pairs(case.ours.settings).map_err(|e| full(&e))?;
    let size = case.size.map(|n| n.max(1));
    let camera = Some(case.camera.of(&scene.bounds(), case.size)).filter(camera::is_sound);
    // A picture of no pixels, which is a case too, has no camera; a window has pixels.
    let camera = camera.unwrap_or_else(|| camera::first(&scene.bounds(), 1.0));
    let camera = camera_in_file(&camera, &scene);
    let import = Importing::default();
    let session = Session { file, size, camera, settings, arrangement, import: import.clone() };
    Ok(Opened { scene, session: Some(session), case: Some(case), import })
}

fn load_scene(file: &str, options: &ImportOptions, shared: &Shared, wake: &impl Fn()) -> Result<Scene, String> {
    if let Some(name) = file.strip_prefix(BUILTIN) {
        return builtin::build(name).map_err(|e| e.to_string());
    }
    let path = Path::new(file);
    let known = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("glb") || e.eq_ignore_ascii_case("gltf"));
    if !known || path.is_dir() {
        // It says what is wrong with the name.
        return import::load_with(path, options).map_err(|e| full(&e));
    }
    let bytes = read(path, options.limits.bytes, shared, wake).map_err(|e| format!("{file}: {e}"))?;
    shared.building.store(true, Ordering::Relaxed);
    wake();
    let name = path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    import::load_bytes_with(&bytes, &name, Some(folder), options).map_err(|e| full(&e))
}

/// An error and whatever caused it, in one line.
fn full(error: &dyn std::error::Error) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(e) = cause {
        let more = e.to_string();
        if !text.contains(&more) {
            text = format!("{text}: {more}");
        }
        cause = e.source();
    }
    text
}

fn read(path: &Path, limit: u64, shared: &Shared, wake: &impl Fn()) -> Result<Vec<u8>, String> {
    let file = std::fs::File::open(path).map_err(|e| e.to_string())?;
    let total = file.metadata().map_err(|e| e.to_string())?.len();
    shared.total.store(total.max(1), Ordering::Relaxed);
    let mut rest = file.take(limit.saturating_add(1));
    let mut bytes = Vec::new();
    let mut piece = vec![0; PIECE];
    loop {
        if shared.cancel.is_cancelled() {
            return Err("called off".to_owned());
        }
        match rest.read(&mut piece).map_err(|e| e.to_string())? {
            0 => break,
            n => bytes.extend_from_slice(&piece[..n]),
        }
        if bytes.len() as u64 > limit {
            return Err(format!("larger than {} MiB", limit >> 20));
        }
        shared.read.store(bytes.len() as u64, Ordering::Relaxed);
        wake();
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wait(loading: &Loading) -> Result<Opened, String> {
        for _ in 0..6000 {
            if let Some(result) = loading.take() {
                return result;
            }
            std::thread::sleep(std::time::Duration::from_millis(5));
        }
        panic!("{} never came", loading.file);
    }

    #[test]
    fn every_hard_case_opens_with_a_camera_that_sees_it() {
        for (_, case) in hard_cases::all() {
            let opened = hard_case(case.name).unwrap_or_else(|e| panic!("{}: {e}", case.name));
            let session = opened.session.unwrap();
            assert_eq!(opened.case.map(|c| c.name), Some(case.name));
            assert!(camera::is_sound(&session.camera), "{}: {:?}", case.name, session.camera);
            assert_eq!(session.settings, Settings::from_pairs(case.ours.settings).unwrap());
        }
    }

    #[test]
    fn a_model_that_is_no_longer_wanted_is_not_decoded() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("stack.glb");
        let bytes = crate::export::glb::write_glb(&builtin::build("stack").unwrap()).unwrap();
        std::fs::write(&path, bytes).unwrap();
        let file = path.to_str().unwrap();
        // Called off when everything is read: what is left is to decode it.
        let shared = Shared::default();
        let wake = || {
            if shared.building.load(Ordering::Relaxed) {
                shared.cancel.cancel();
            }
        };
        let options = ImportOptions { cancel: shared.cancel.clone(), ..ImportOptions::default() };
        let said = load_scene(file, &options, &shared, &wake).map(|_| ()).unwrap_err();
        assert!(said.ends_with("called off"), "{said}");
        assert!(load_scene(file, &ImportOptions::default(), &Shared::default(), &|| {}).is_ok());
    }

    #[test]
    fn scenes_come_and_errors_say_what_is_wrong() {
        let scene = wait(&Loading::begin("builtin:quads", &ImportOptions::default(), || {})).unwrap().scene;
        assert!(!scene.parts.is_empty());
        let folder = tempfile::tempdir().unwrap();
        let broken = folder.path().join("broken.glb");
        std::fs::write(&broken, b"glTF and nothing else").unwrap();
        let session = folder.path().join("session.toml");
        std::fs::write(&session, "file = 3").unwrap();
        for (file, word) in [
            ("builtin:nothing", "nothing"),
            ("hard-case:nothing", "nothing"),
            ("/no/such/file.glb", "/no/such/file.glb"),
            ("/etc/hostname", "hostname"),
            (broken.to_str().unwrap(), "broken"),
            (session.to_str().unwrap(), "session.toml"),
        ] {
            let error = wait(&Loading::begin(file, &ImportOptions::default(), || {})).map(|_| ()).unwrap_err();
            assert!(error.contains(word), "{file}: {error}");
        }
    }
}
