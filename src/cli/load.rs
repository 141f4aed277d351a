//! From what stands on the command line to a scene: a file, `-` for standard input, or `builtin:NAME`.

use std::io::Read;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use serde::Serialize;

use super::failure::{Exit, Failure};
use super::output::Progress;
use crate::export::assets;
use crate::import::{self, ImportOptions, Phase};
use crate::scene::builtin::{self, BuiltinError};
use crate::scene::{Notice, Scene};
use crate::settings::nearest;

/// In front of the name of a generated scene.
pub const BUILTIN: &str = "builtin:";
/// Stands for standard input.
pub const STDIN: &str = "-";
/// What is read from standard input is called.
const STDIN_NAME: &str = "standard input";

/// How long reading a model took.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Times {
    /// By phase, in the order in which they began. A moment counts for the phase that was told last.
    pub phases: Vec<PhaseTime>,
    /// From the first byte to the scene, what belongs to no phase included.
    pub milliseconds: f64,
}

/// One phase of reading a model.
#[derive(Clone, Debug, Serialize)]
pub struct PhaseTime {
    /// Its name.
    pub phase: &'static str,
    /// How long it took, wall time.
    pub milliseconds: f64,
}

/// Adds up the time of phases as they are told.
#[derive(Default)]
struct Clock {
    now: Option<(Phase, Instant)>,
    all: Vec<(Phase, Duration)>,
}

impl Clock {
    fn begin(&mut self, phase: Option<Phase>, at: Instant) {
        if let Some((before, since)) = self.now {
            if Some(before) == phase {
                return;
            }
            let took = at.saturating_duration_since(since);
            match self.all.iter_mut().find(|(p, _)| *p == before) {
                Some((_, sum)) => *sum += took,
                None => self.all.push((before, took)),
            }
        }
        self.now = phase.map(|p| (p, at));
    }
}

/// Reads a file or generates a scene, and says every notice in one line on standard error.
///
/// # Errors
/// [`Exit::Usage`] for a generated scene that does not exist, [`Exit::Input`] for a file that cannot be read.
pub fn scene(file: &Path, options: &ImportOptions, progress: &Progress) -> Result<Scene, Failure> {
    timed(file, options, progress).map(|(scene, _)| scene)
}

/// The same, and how long it took.
///
/// # Errors
/// As [`scene`].
pub fn timed(file: &Path, options: &ImportOptions, progress: &Progress) -> Result<(Scene, Times), Failure> {
    let (scene, times) = quietly(file, options, progress)?;
    say(file, &scene.notices, progress);
    Ok((scene, times))
}

/// Says notices, one line each.
pub fn say(file: &Path, notices: &[Notice], progress: &Progress) {
    for notice in notices {
        progress.say(&format!("{}: {}: {}", shown(file), notice.kind.name(), notice.message));
    }
}

/// Reads a model without saying its notices.
///
/// # Errors
/// As [`scene`].
pub fn quietly(file: &Path, options: &ImportOptions, progress: &Progress) -> Result<(Scene, Times), Failure> {
    let name = shown(file);
    progress.stage(&format!("reading {name}"));
    let clock = Arc::new(Mutex::new(Clock::default()));
    let (told, bar) = (Arc::clone(&clock), progress.importing(&name));
    let listener = import::Progress::to(move |phase, done| {
        told.lock().unwrap_or_else(PoisonError::into_inner).begin(Some(phase), Instant::now());
        bar(phase, done);
    });
    let options = ImportOptions { progress: listener, ..options.clone() };
    let begin = Instant::now();
    let input = |e: &(dyn std::error::Error + 'static)| Failure::about(Exit::Input, &name, e);
    let scene = match file.to_str() {
        Some(STDIN) => {
            let bytes = standard_input(options.limits.bytes)?;
            import::load_bytes_with(&bytes, STDIN_NAME, None, &options).map_err(|e| input(&e))?
        }
        Some(text) if text.starts_with(BUILTIN) => {
            builtin::build(&text[BUILTIN.len()..]).map_err(|e| Failure::new(Exit::Usage, unknown_scene(&e)))?
        }
        _ => import::load_with(file, &options).map_err(|e| input(&e))?,
    };
    let end = Instant::now();
    let mut clock = clock.lock().unwrap_or_else(PoisonError::into_inner);
    clock.begin(None, end);
    let milliseconds = |d: Duration| d.as_secs_f64() * 1e3;
    let phase =
        |(phase, took): &(Phase, Duration)| PhaseTime { phase: phase.name(), milliseconds: milliseconds(*took) };
    let phases = clock.all.iter().map(phase).collect();
    Ok((scene, Times { phases, milliseconds: milliseconds(end.saturating_duration_since(begin)) }))
}

/// A file as messages name it.
pub fn shown(file: &Path) -> String {
    if file == Path::new(STDIN) { STDIN_NAME.to_owned() } else { file.display().to_string() }
}

fn standard_input(limit: u64) -> Result<Vec<u8>, Failure> {
    let mut bytes = Vec::new();
    let read = std::io::stdin().lock().take(limit.saturating_add(1)).read_to_end(&mut bytes);
    read.map_err(|e| Failure::about(Exit::Input, STDIN_NAME, &e))?;
    if bytes.len() as u64 > limit {
        let cause = format!("{STDIN_NAME}: more than the limit of {limit} bytes; --limit bytes=… allows more");
        return Err(Failure::new(Exit::Input, cause));
    }
    Ok(bytes)
}

fn unknown_scene(error: &BuiltinError) -> String {
    let hint = match error {
        BuiltinError::Unknown { name, .. } => nearest(name, builtin::names().iter().map(|b| b.name)),
        _ => None,
    };
    hint.map_or_else(|| error.to_string(), |hint| format!("{error}; did you mean '{hint}'?"))
}

/// Writes the generated scenes as files, and names them on standard output.
///
/// # Errors
/// [`Exit::General`] if a file cannot be written.
pub fn write_assets(folder: &Path) -> Result<(), Failure> {
    let written = assets::write_assets(folder).map_err(|e| Failure::of(Exit::General, &e))?;
    let lines: String = written.iter().map(|path| format!("{}\n", path.display())).collect();
    super::output::print(lines.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_times_of_phases_add_up_however_they_alternate() {
        let mut clock = Clock::default();
        let start = Instant::now();
        let at = |ms: u64| start + Duration::from_millis(ms);
        for (phase, ms) in [(Phase::Reading, 0), (Phase::Images, 10), (Phase::Geometry, 15), (Phase::Images, 35)] {
            clock.begin(Some(phase), at(ms));
            // Told again inside of it.
            clock.begin(Some(phase), at(ms + 1));
        }
        clock.begin(None, at(40));
        let ms: Vec<(Phase, u128)> = clock.all.iter().map(|(p, d)| (*p, d.as_millis())).collect();
        assert_eq!(ms, [(Phase::Reading, 10), (Phase::Images, 10), (Phase::Geometry, 20)]);
    }

    #[test]
    fn scenes_that_do_not_exist_are_usage_with_the_nearest() {
        let load = |name: &str| scene(Path::new(name), &ImportOptions::default(), &Progress::new());
        let failure = load("builtin:gearbocks").unwrap_err();
        assert_eq!(failure.exit, Exit::Usage);
        assert!(failure.message.contains("did you mean 'gearbox'"), "{failure:?}");
        assert!(!load("builtin:xyzzyxyzzy").unwrap_err().message.contains("did you mean"));
    }
}
