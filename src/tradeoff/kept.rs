//! Choices between runs: what was measured is kept, and what was chosen is told in words. Both faces of the program use it.
//!
//! Measurements are kept in the user's cache folder, one file for each machine (adapter, driver, program), scene (a digest of
//! all that is drawn), view, size and look. When any of them changes, another file is meant, and it is measured anew.

use std::hash::{DefaultHasher, Hasher};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::budget::{BudgetError, Choice, Goal, Measurements, Options, Verdict, choose};
use super::report::COMMIT;
use super::workbench::Workbench;
use crate::gpu::AdapterFacts;
use crate::math::Camera;
use crate::scene::{Arrangement, Scene};
use crate::settings::Settings;

/// Everything that measurements depend on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Key {
    program: String,
    adapter: Vec<String>,
    cores: usize,
    scene: u64,
    /// A digest of how its parts are shown.
    arrangement: u64,
    camera: Camera,
    size: [u32; 2],
    background: Option<[f32; 3]>,
    look: Settings,
}

impl Key {
    fn new(scene: &Scene, camera: &Camera, settings: &Settings, facts: &AdapterFacts, options: &Options) -> Key {
        // Another build may be another program under the same version.
        let built = std::env::current_exe().and_then(std::fs::metadata).map(|m| (m.len(), m.modified().ok()));
        let AdapterFacts { name, driver, driver_info, backend, device_type, .. } = facts;
        Key {
            program: format!("{} {} {built:?}", env!("CARGO_PKG_VERSION"), COMMIT.unwrap_or_default()),
            adapter: [name, driver, driver_info, backend, device_type].map(Clone::clone).to_vec(),
            cores: std::thread::available_parallelism().map_or(1, std::num::NonZero::get),
            scene: scene.digest(),
            arrangement: 0,
            camera: *camera,
            size: options.size,
            background: options.background,
            look: settings.clone(),
        }
    }

    fn arranged(mut self, arrangement: &Arrangement) -> Key {
        let mut hasher = DefaultHasher::new();
        hasher.write(format!("{arrangement:?}").as_bytes());
        self.arrangement = hasher.finish();
        self
    }

    fn file_name(&self) -> String {
        let mut hasher = DefaultHasher::new();
        hasher.write(serde_json::to_string(self).unwrap_or_default().as_bytes());
        format!("{:016x}.json", hasher.finish())
    }
}

/// A file in the cache.
#[derive(Serialize, Deserialize)]
struct Kept {
    /// Of what.
    key: Key,
    measurements: Measurements,
}

/// The folder for measurements: `$XDG_CACHE_HOME/pellucid/measurements` or what the system uses instead.
fn cache_folder() -> Option<PathBuf> {
    directories::ProjectDirs::from("", "", "pellucid").map(|d| d.cache_dir().join("measurements"))
}

fn read(path: &Path, key: &Key) -> Option<Measurements> {
    let kept: Kept = serde_json::from_slice(&std::fs::read(path).ok()?).ok()?;
    let sound = |ms: &f64| ms.is_finite() && *ms > 0.0;
    let all_sound = kept
        .measurements
        .entries
        .iter()
        .all(|e| e.frames.iter().all(sound) && e.error.is_none_or(|e| (0.0..=1.0).contains(&e.flip_mean)));
    (kept.key == *key && all_sound).then_some(kept.measurements)
}

/// Whole or not at all.
fn write(path: &Path, key: &Key, measurements: Measurements) -> std::io::Result<()> {
    let folder = path.parent().unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder)?;
    let text = serde_json::to_string_pretty(&Kept { key: key.clone(), measurements })? + "\n";
    let unfinished = path.with_extension(format!("{}.part", std::process::id()));
    let written = std::fs::write(&unfinished, text).and_then(|()| std::fs::rename(&unfinished, path));
    if written.is_err() {
        // There may be none.
        let _ = std::fs::remove_file(&unfinished);
    }
    written
}

/// What settings are chosen for.
#[derive(Clone, Copy)]
pub struct Subject<'a> {
    /// The model.
    pub scene: &'a Scene,
    /// How its parts are shown.
    pub arrangement: &'a Arrangement,
    /// From where.
    pub camera: &'a Camera,
    /// What was asked for.
    pub settings: &'a Settings,
    /// What it is drawn on.
    pub facts: &'a AdapterFacts,
}

/// Settings for a promise, and what to tell of them.
#[derive(Clone, Debug, PartialEq)]
pub struct Chosen {
    /// What was chosen.
    pub choice: Choice,
    /// In words.
    pub sentence: String,
    /// Why the measurements could not be kept.
    pub not_kept: Option<String>,
}

/// Chooses settings for `goal` with what was measured before, measures on `bench` what is not known yet, and keeps it.
/// `longer` says how a user gives more time. `progress` hears how many frames were drawn and what is drawn next.
///
/// # Errors
/// [`BudgetError`] if nothing can be drawn, or if it was called off; what was measured until then is kept.
pub fn chosen(
    bench: &mut dyn Workbench,
    subject: Subject<'_>,
    goal: Goal,
    options: &Options,
    (remeasure, longer): (bool, &str),
    progress: &mut dyn FnMut(usize, &str),
) -> Result<Chosen, BudgetError> {
    let Subject { scene, arrangement, camera, settings, facts } = subject;
    let key = Key::new(scene, camera, settings, facts, options).arranged(arrangement);
    let path = cache_folder().map(|folder| folder.join(key.file_name()));
    let kept = path.as_ref().and_then(|path| read(path, &key));
    let known = if remeasure { None } else { kept.clone() };
    let mut measurements = known.clone().unwrap_or_default();
    let mut count = 0;
    let choice = choose(bench, settings, goal, options, &mut measurements, &mut |name| {
        count += 1;
        progress(count, name);
    });
    let fresh = known.unwrap_or_default() != measurements;
    let mut not_kept = None;
    if let Some(path) = path.as_ref().filter(|_| fresh) {
        // What measuring anew did not reach is not lost.
        for old in kept.map(|k| k.entries).unwrap_or_default() {
            if !measurements.entries.iter().any(|e| e.settings == old.settings && e.scale == old.scale) {
                measurements.entries.push(old);
            }
        }
        // A picture is worth more than a cache.
        not_kept = write(path, &key, measurements).err().map(|e| format!("{}: {e}", path.display()));
    }
    let choice = choice?;
    let source = match (fresh, &path) {
        (true, _) => format!("measured now in {count} frames"),
        (false, Some(path)) => format!("measured before: {}", path.display()),
        (false, None) => "measured before".to_owned(),
    };
    let sentence = sentence(goal, &choice, &source, longer);
    Ok(Chosen { choice, sentence, not_kept })
}

/// What is promised, in words.
pub fn promise(goal: Goal) -> String {
    match goal {
        Goal::Time(limit) => format!("within {} ms", (limit * 1000.0).round() / 1000.0),
        Goal::Error(limit) => format!("below FLIP {limit}"),
    }
}

fn sentence(goal: Goal, choice: &Choice, source: &str, longer: &str) -> String {
    let Choice { name, flip, time, compared, reason, verdict, cut_short, reference_samples, .. } = choice;
    let promise = promise(goal);
    let verdict = match verdict {
        Verdict::Kept => "",
        Verdict::Unsure => ", which keeps it as far as so few frames tell",
        Verdict::Broken => ", WHICH DOES NOT KEEP THE PROMISE",
    };
    let frames = if time.count == 1 { "1 frame".to_owned() } else { format!("{} frames", time.count) };
    let short = if *cut_short { format!("; the time for measuring ended early ({longer})") } else { String::new() };
    format!(
        "{promise}: '{name}'{verdict}, {:.1} ms a frame ({:.1} to {:.1}, {frames}), FLIP {flip:.4} against {reference_samples} samples; {reason}; {compared} \
         configurations compared, {source}{short}",
        time.median, time.low, time.high
    )
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;
    use crate::scene::builtin;
    use crate::tradeoff::budget::Entry;

    fn facts(name: &str) -> AdapterFacts {
        AdapterFacts {
            name: name.to_owned(),
            driver: "driver".to_owned(),
            driver_info: "1".to_owned(),
            backend: "vulkan".to_owned(),
            device_type: "Cpu".to_owned(),
            features: Vec::new(),
            limits: Vec::new(),
            capabilities: crate::plan::Capabilities::default(),
            unusable: None,
        }
    }

    #[test]
    fn measurements_are_kept_for_one_machine_scene_view_and_look() {
        let folder = tempfile::tempdir().unwrap();
        let scene = builtin::build("quads?layers=2&parts=1").unwrap();
        let camera = |angle| {
            let (direction, up) = (glam::DVec3::NEG_Z, glam::DVec3::Y);
            Camera::framing(&scene.bounds(), direction, up, 1.0, 0.9, false, 0.1 + 0.2).azimuth(angle)
        };
        let options = Options { size: [8, 8], background: Some([0.1; 3]), limit: Duration::ZERO, resize: true };
        let settings = Settings::default();
        let key = Key::new(&scene, &camera(33.3), &settings, &facts("a"), &options);
        let entry = Entry {
            name: "k=4".to_owned(),
            settings: settings.clone(),
            scale: 0.1875,
            error: None,
            frames: vec![0.1 + 0.2],
            refused: None,
        };
        let measurements = Measurements { entries: vec![entry] };
        let path = folder.path().join("deep").join(key.file_name());
        assert_eq!(read(&path, &key), None);
        write(&path, &key, measurements.clone()).unwrap();
        assert_eq!(read(&path, &key), Some(measurements), "as it was written");

        let mut look = settings.clone();
        look.light.key = 3.0;
        let mut other = scene.clone();
        other.parts[0].world_from_part.w_axis.y = 0.5;
        let others = [
            Key::new(&scene, &camera(33.3), &settings, &facts("b"), &options),
            Key::new(&scene, &camera(33.3), &settings, &facts("a"), &options).arranged(&Arrangement::default()),
            Key::new(&scene, &camera(33.4), &settings, &facts("a"), &options),
            Key::new(&scene, &camera(33.3), &look, &facts("a"), &options),
            Key::new(&other, &camera(33.3), &settings, &facts("a"), &options),
            Key::new(&scene, &camera(33.3), &settings, &facts("a"), &Options { size: [8, 9], ..options }),
        ];
        for other in others {
            assert!(other.file_name() != key.file_name() && read(&path, &other).is_none(), "{other:?}");
        }
        std::fs::write(&path, "{").unwrap();
        assert_eq!(read(&path, &key), None, "a broken file is no file");
    }

    #[test]
    fn a_choice_is_told_with_its_reason() {
        let choice = Choice {
            name: "k=8, resolution=0.5".to_owned(),
            settings: Settings::default(),
            scale: 0.5,
            flip: 0.021,
            time: crate::tradeoff::statistics::Estimate { median: 28.0, low: 27.0, high: 30.04, count: 7 },
            asked: 90.0,
            reference_samples: 16,
            verdict: Verdict::Kept,
            compared: 23,
            cut_short: false,
            reason: "'k=8', with FLIP 0.0100, takes 60.0 ms".to_owned(),
        };
        let text = sentence(Goal::Time(33.0), &choice, "measured now in 9 frames", "--measure-seconds");
        assert_eq!(
            text,
            "within 33 ms: 'k=8, resolution=0.5', 28.0 ms a frame (27.0 to 30.0, 7 frames), FLIP 0.0210 against 16 \
             samples; 'k=8', with FLIP 0.0100, takes 60.0 ms; 23 configurations compared, measured now in 9 frames"
        );
        let broken = Choice { verdict: Verdict::Broken, cut_short: true, ..choice };
        let text = sentence(Goal::Error(0.001), &broken, "measured now in 9 frames", "--measure-seconds");
        assert!(
            text.contains("below FLIP 0.001")
                && text.contains("DOES NOT KEEP")
                && text.ends_with("early (--measure-seconds)")
        );
    }
}
