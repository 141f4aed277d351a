//! Opening a model without holding up the window: a thread, how far it is, and a way to call it off.
//!
//! A file is read as the command line reads it, by [`import::load_with`]: whatever its format, the importer says how far it
//! is, ends when it is called off, and finds the same words for what is wrong.

use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use super::camera;
use crate::import::{self, Cancel, ImportOptions, Phase, Progress};
use crate::scene::hard_case::{HardCase, Source};
use crate::scene::{Arrangement, Scene, Section, builtin};
use crate::session::{self, Importing, Session, camera_in_file};
use crate::settings::Settings;
use crate::tradeoff::hard_cases;

/// In front of the name of a generated scene.
const BUILTIN: &str = "builtin:";
/// In front of the name of a hard case: its scene, camera and our settings.
pub const HARD_CASE: &str = "hard-case:";
/// What is said where a hard case's model would be needed as a file.
pub const MADE_IN_MEMORY: &str = "The model of this hard case is made in memory: there is no file to name.";
/// Between two wakes while a phase goes on: the importer tells of every piece, which may be thousands a second.
const BETWEEN_WAKES: Duration = Duration::from_millis(34);

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

/// How far the importer is.
#[derive(Default)]
struct Told {
    /// What it is at, and the share of that which is done.
    now: Option<(Phase, f32)>,
    /// When this was last shown to whoever waits.
    woken: Option<Instant>,
}

impl Told {
    /// Takes what the importer tells; says whether to wake whoever waits.
    fn hear(&mut self, phase: Phase, share: f32, at: Instant) -> bool {
        let before = self.now.filter(|now| now.0 == phase);
        // Threads may tell their pieces in another order than they have counted them.
        self.now = Some((phase, before.map_or(share, |now| now.1.max(share))));
        // Phases are few, and the next word about one may be long in coming.
        let rested = self.woken.is_none_or(|last| at.saturating_duration_since(last) >= BETWEEN_WAKES);
        let wake = before.is_none() || rested;
        if wake {
            self.woken = Some(at);
        }
        wake
    }
}

#[derive(Default)]
struct Shared {
    cancel: Cancel,
    told: Mutex<Told>,
    result: Mutex<Option<Result<Opened, String>>>,
}

impl Shared {
    /// `options`, by which an import tells and asks here; `wake` is called as it gets on.
    fn options(self: &Arc<Shared>, options: &ImportOptions, wake: impl Fn() + Send + Sync + 'static) -> ImportOptions {
        let shared = Arc::clone(self);
        let progress = Progress::to(move |phase, share| {
            let mut told = shared.told.lock().unwrap_or_else(PoisonError::into_inner);
            let awaited = told.hear(phase, share, Instant::now());
            drop(told);
            if awaited {
                wake();
            }
        });
        ImportOptions { cancel: self.cancel.clone(), progress, ..options.clone() }
    }
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
    pub fn begin(file: &str, options: &ImportOptions, wake: impl Fn() + Clone + Send + Sync + 'static) -> Loading {
        let shared = Arc::new(Shared::default());
        let (theirs, name) = (Arc::clone(&shared), file.to_owned());
        let options = shared.options(options, wake.clone());
        let run = move || {
            let result = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| load(&name, &options)))
                .unwrap_or_else(|_| Err(format!("{name}: the importer panicked; the log says where")));
            *theirs.result.lock().unwrap_or_else(PoisonError::into_inner) = Some(result);
            wake();
        };
        if let Err(e) = std::thread::Builder::new().name("loader".to_owned()).spawn(run) {
            *shared.result.lock().unwrap_or_else(PoisonError::into_inner) = Some(Err(format!("{file}: {e}")));
        }
        Loading { file: file.to_owned(), shared }
    }

    /// What the importer is at, and the share of that which is done; nothing before it says so, nor where a scene is
    /// generated.
    pub fn phase(&self) -> Option<(Phase, f32)> {
        self.shared.told.lock().unwrap_or_else(PoisonError::into_inner).now
    }

    /// The scene, or why there is none, once.
    pub fn take(&self) -> Option<Result<Opened, String>> {
        self.shared.result.lock().unwrap_or_else(PoisonError::into_inner).take()
    }
}

impl Drop for Loading {
    /// Calls it off: reading stops, and what comes after it at the next piece; a scene that is there all the same is thrown
    /// away.
    fn drop(&mut self) {
        self.shared.cancel.cancel();
    }
}

fn load(file: &str, options: &ImportOptions) -> Result<Opened, String> {
    if let Some(name) = file.strip_prefix(HARD_CASE) {
        return hard_case(name);
    }
    let path = Path::new(file);
    if !file.starts_with(BUILTIN) && path.extension().is_some_and(|e| e.eq_ignore_ascii_case("toml")) {
        let said = |e: &dyn std::error::Error| format!("{file}: {}", full(e));
        let text = session::read_text(path).map_err(|e| said(&e))?;
        let folder = path.parent().unwrap_or(Path::new(""));
        let session = Session::from_toml(&text).map_err(|e| said(&e))?.rebased(folder);
        let scene = load_scene(session.file(), &session.import().options(options))?;
        let session = session.resolve(&scene).map_err(|e| said(&e))?;
        let import = session.import.clone();
        return Ok(Opened { scene, session: Some(session), case: None, import });
    }
    let scene = load_scene(file, options)?;
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

fn load_scene(file: &str, options: &ImportOptions) -> Result<Scene, String> {
    match file.strip_prefix(BUILTIN) {
        Some(name) => builtin::build(name).map_err(|e| e.to_string()),
        None => import::load_with(Path::new(file), options).map_err(|e| full(&e)),
    }
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

    /// One model in each format that is read, in a folder.
    fn models(folder: &Path) -> Vec<String> {
        use crate::export::{glb, mesh_files};
        let scene = builtin::build("stack").unwrap();
        let files = [
            ("stack.glb", glb::write_glb(&scene).unwrap()),
            ("stack.obj", mesh_files::write_obj(&scene, "stack.mtl")),
            ("stack.stl", mesh_files::write_stl_binary(&scene)),
            ("stack-text.stl", mesh_files::write_stl_ascii(&scene)),
            ("stack.ply", mesh_files::write_ply(&scene, mesh_files::PlyEncoding::LittleEndian)),
        ];
        let write = |(name, bytes): (&str, Vec<u8>)| {
            let path = folder.join(name);
            std::fs::write(&path, bytes).unwrap();
            path.to_str().unwrap().to_owned()
        };
        files.map(write).to_vec()
    }

    #[test]
    fn every_format_tells_how_far_it_is_and_can_be_called_off() {
        let folder = tempfile::tempdir().unwrap();
        for file in models(folder.path()) {
            for at in [None, Some(Phase::Reading), Some(Phase::Parsing), Some(Phase::Geometry)] {
                let shared = Arc::new(Shared::default());
                let seen: Arc<Mutex<Vec<Phase>>> = Arc::default();
                let (theirs, list) = (Arc::clone(&shared), Arc::clone(&seen));
                let wake = move || {
                    let Some((phase, share)) = theirs.told.lock().unwrap().now else {
                        panic!("woken without a word");
                    };
                    assert!((0.0..=1.0).contains(&share));
                    list.lock().unwrap().push(phase);
                    if Some(phase) == at {
                        theirs.cancel.cancel();
                    }
                };
                let options = ImportOptions { map_from: u64::MAX, ..ImportOptions::default() };
                let loaded = load_scene(&file, &shared.options(&options, wake));
                let mut seen = seen.lock().unwrap().clone();
                seen.dedup();
                match at {
                    None => {
                        assert!(loaded.unwrap().triangle_count() > 0, "{file}");
                        for phase in [Phase::Reading, Phase::Parsing, Phase::Geometry, Phase::Parts, Phase::Finishing] {
                            assert!(seen.contains(&phase), "{file}: {seen:?}");
                        }
                    }
                    Some(at) => {
                        let said = loaded.map(|_| ()).unwrap_err();
                        assert_eq!(said, format!("{file}: called off"));
                        assert_eq!(seen.last(), Some(&at), "{file}: it goes on");
                    }
                }
            }
        }
    }

    #[cfg(unix)]
    #[test]
    fn a_converter_tells_how_far_it_is_and_is_called_off() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("part.slow");
        std::fs::write(&path, "anything").unwrap();
        let mut options = ImportOptions::default();
        options.converters.insert("slow".to_owned(), "sh -c 'sleep 600' {in} {out}".to_owned());
        let shared = Arc::new(Shared::default());
        let theirs = Arc::clone(&shared);
        let wake = move || {
            if theirs.told.lock().unwrap().now.is_some_and(|now| now.0 == Phase::Converting) {
                theirs.cancel.cancel();
            }
        };
        let file = path.to_str().unwrap();
        let said = load_scene(file, &shared.options(&options, wake)).map(|_| ()).unwrap_err();
        assert_eq!(said, format!("{file}: called off"));
    }

    #[test]
    fn the_window_is_woken_when_a_phase_begins_and_seldom_while_it_goes_on() {
        let (mut told, start) = (Told::default(), Instant::now());
        let second = |i: u32| start + Duration::from_secs(1) * i / 10_000;
        let woken = (0..10_000).filter(|&i| told.hear(Phase::Geometry, i as f32 / 1e4, second(i))).count();
        assert!((20..=30).contains(&woken), "{woken} wakes in a second");
        assert!(told.hear(Phase::Parts, 0.0, second(9_999)), "a phase begins");
        assert!(!told.hear(Phase::Parts, 0.5, second(9_999)));
        // A piece that was counted before another and is told after it.
        assert!(!told.hear(Phase::Parts, 0.4, second(9_999)));
        assert_eq!(told.now, Some((Phase::Parts, 0.5)));
    }

    #[test]
    fn what_is_wrong_with_a_file_is_said_as_on_the_command_line() {
        let folder = tempfile::tempdir().unwrap();
        let sound = models(folder.path());
        let mut files: Vec<String> = sound.clone();
        for file in sound {
            let bytes = std::fs::read(&file).unwrap();
            let (stem, ending) = file.rsplit_once('.').unwrap();
            for (name, content) in
                [("cut", &bytes[..bytes.len() / 3]), ("other", &b"neither this nor that"[..]), ("empty", b"")]
            {
                let path = format!("{stem}-{name}.{ending}");
                std::fs::write(&path, content).unwrap();
                files.push(path);
            }
        }
        files.extend([folder.path().to_str().unwrap().to_owned(), format!("{}/none.glb", folder.path().display())]);
        let mut refused = 0;
        for file in &files {
            let ours = wait(&Loading::begin(file, &ImportOptions::default(), || {})).map(|o| o.scene.digest());
            let theirs = import::load_with(Path::new(file), &ImportOptions::default());
            refused += usize::from(theirs.is_err());
            assert_eq!(ours, theirs.map(|s| s.digest()).map_err(|e| e.to_string()), "{file}");
        }
        assert!(refused >= 10, "{refused} of {} are refused", files.len());
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
