//! How long the window takes to answer the hand: printed, never asserted. With `PELLUCID_TEST_FULL` a minute of it or more;
//! `PELLUCID_TEST_PROGRAM` names the build to be measured.
//!
//! An input is answered by the frame that shows it, from when its event came. Everything is measured with the default look and
//! with illustrative transparency over it, a k-buffer in either: its k captures everything anew.

use std::collections::BTreeMap;
use std::time::Duration;

use pellucid::app::camera;
use pellucid::scene::{Arrangement, Scene, builtin};
use pellucid::session::{Importing, Session, camera_in_file};
use pellucid::settings::Settings;

use super::desk::{Desk, tools_are_there};
use super::models;
use super::support::{full, gpu};

/// Movements a second, as of a mouse that is not in a hurry.
const RATE: u32 = 60;

/// Drags the left button about this place for so many seconds, in one go: a process for each step would be in the way.
fn stir(desk: &Desk, [x, y]: [u32; 2], [wide, high]: [u32; 2], seconds: u32) {
    let mut words = format!("mousemove {x} {y} mousedown 1");
    for i in 1..=seconds * RATE {
        let turn = f64::from(i) * 0.11;
        let at = |middle: u32, reach: u32, wave: f64| (f64::from(middle) + f64::from(reach) * wave).round();
        words += &format!(" mousemove {} {}", at(x, wide, turn.sin()), at(y, high, (0.7 * turn).sin()));
        words += &format!(" sleep {:.4}", 1.0 / f64::from(RATE));
    }
    desk.xdotool(&(words + " mouseup 1"));
}

/// The number after `before` in each line that has it, with what follows the last comma.
fn figures(log: &str, before: &str) -> Vec<(f64, String)> {
    let of = |line: &str| {
        let rest = &line[line.find(before)? + before.len()..];
        let (number, rest) = rest.split_once(" ms")?;
        Some((number.parse().ok()?, rest.rsplit(", ").next()?.to_owned()))
    };
    log.lines().filter_map(of).collect()
}

fn percentile(mut values: Vec<f64>, p: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    values[((values.len() - 1) as f64 * p).round() as usize]
}

/// A slider that is dragged: its name, and the number of those with that name before it.
type Slider = (&'static str, usize);

/// Looks, their settings, and what is dragged in them.
const LOOKS: [(&str, &str, &[Slider]); 3] = [
    ("default", "", &[("Gain", 0)]),
    ("k-buffer", "capture.kind=bucketed_k_buffer", &[("K", 0), ("Gain", 0)]),
    (
        "illustrative",
        "capture.kind=bucketed_k_buffer opacity.model=illustrative opacity.illustrative.base=curvature",
        &[("K", 0), ("Gain", 0), ("Lambda", 2)],
    ),
];

#[test]
fn how_long_the_hand_waits() {
    if !tools_are_there() || gpu("how long the hand waits").is_none() {
        return;
    }
    let drive = models::folder().map(|f| f.join("assemblies/CycloidalDrive.glb")).filter(|f| f.exists());
    let (file, scene) = match drive {
        Some(path) => (path.display().to_string(), pellucid::import::load(&path).unwrap()),
        None => ("builtin:gearbox".to_owned(), builtin::build("gearbox").unwrap()),
    };
    let folder = tempfile::tempdir().unwrap();
    for (look, pairs, sliders) in LOOKS {
        let session = folder.path().join(format!("{look}.toml"));
        std::fs::write(&session, session_of(&file, &scene, pairs)).unwrap();
        println!("{file}, {look}");
        measure(&session.display().to_string(), sliders);
    }
}

fn session_of(file: &str, scene: &Scene, pairs: &str) -> String {
    let size = [720, 520];
    let camera = camera_in_file(&camera::first(&scene.bounds(), 720.0 / 520.0), scene);
    let (file, settings) = (file.to_owned(), Settings::from_pairs(pairs).unwrap());
    let import = Importing::default();
    Session { file, size, camera, settings, arrangement: Arrangement::default(), import }.to_toml(scene).unwrap()
}

/// Turns and drags what there is to drag, each for as long, and prints how long the frames took that showed it.
fn measure(file: &str, sliders: &[Slider]) {
    let seconds = if full() { 20 } else { 1 };
    // Where things are is found in another window of the same size: saying so takes time.
    let desk = Desk::open(&[file]);
    desk.settle();
    let [x, y, w, h] = desk.last_order().unwrap().1;
    // What, where, how far, and how often the wheel is clicked before.
    let mut places = vec![
        ("turning".to_owned(), [x + w / 2, y + h / 2], [w / 5, h / 5], 0),
        ("a point of the opacity curve".to_owned(), desk.place("Opacity point 2").middle(), [12, 12], 0),
    ];
    for &(name, nth) in sliders {
        let (place, clicks) = desk.slider(name, nth);
        let what = if nth == 0 { name.to_owned() } else { format!("{name} {}", nth + 1) };
        places.push((what, place.middle(), [20, 0], clicks));
    }
    desk.quit();

    let desk = Desk::open_blind(&[file]);
    desk.settle();
    println!("  picture of {w}×{h} in a window of 1280×800");
    let mut all = Vec::new();
    for (what, at, reach, clicks) in places {
        desk.wheel_down(clicks);
        let before = desk.log().len();
        stir(&desk, at, reach, seconds);
        desk.settle();
        let log = desk.log().split_off(before);
        let answered = figures(&log, "answered in ");
        let drawn = figures(&log, "drawn in ");
        assert!(answered.len() > 5, "{what}: {} answers\n{log}", answered.len());
        let exact = figures(&log, "exact in ");
        assert!(!exact.is_empty(), "{what}: no exact picture\n{log}");
        let mut by: BTreeMap<&str, usize> = BTreeMap::new();
        for (_, how) in &answered {
            *by.entry(how.as_str()).or_default() += 1;
        }
        let times = |list: &[(f64, String)]| list.iter().map(|(ms, _)| *ms).collect::<Vec<f64>>();
        let (median, p95) = (percentile(times(&answered), 0.5), percentile(times(&answered), 0.95));
        let previews = figures(&log, "] in ");
        println!(
            "  {what}: answered in {median:.0} ms (median), {p95:.0} ms (95 %), {} inputs {by:?}; drawn anew in {:.0} ms (95 %), \
             previews of {:.0} ms (median); exact {:.0} ms after the last",
            answered.len(),
            percentile(times(&drawn), 0.95),
            percentile(times(&previews), 0.5),
            exact.last().map_or(f64::NAN, |(ms, _)| *ms),
        );
        all.extend(times(&answered));
        std::thread::sleep(Duration::from_millis(200));
    }
    println!("  all: answered in {:.0} ms (95 %)", percentile(all, 0.95));
    desk.quit();
}
