//! How long the window takes to answer the hand: printed, never asserted. With `PELLUCID_TEST_FULL` a minute of it.

use std::collections::BTreeMap;
use std::time::Duration;

use super::desk::{Desk, Place, tools_are_there};
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

#[test]
fn how_long_the_hand_waits() {
    if !tools_are_there() || gpu("how long the hand waits").is_none() {
        return;
    }
    let drive = models::folder().map(|f| f.join("assemblies/CycloidalDrive.glb")).filter(|f| f.exists());
    let file = drive.map_or_else(|| "builtin:gearbox".to_owned(), |f| f.display().to_string());
    let seconds = if full() { 20 } else { 1 };
    // Where things are is found in another window of the same size: saying so takes time.
    let desk = Desk::open(&[&file]);
    desk.settle();
    let [x, y, w, h] = desk.last_order().unwrap().1;
    let mut places = vec![
        ("turning", [x + w / 2, y + h / 2], [w / 5, h / 5]),
        ("dragging a point of the opacity curve", desk.place("Opacity point 2").middle(), [12, 12]),
    ];
    // Settings that can be seen without scrolling: one of the last stages, one of the first.
    for (what, name) in [("dragging the gain", "Gain"), ("dragging the number of layers", "K")] {
        let seen = |p: &Place| p.top as u32 >= y && p.bottom as u32 <= y + h;
        // The slider is the widest of what has this name, and the label the first.
        let named = desk.find_all(name).into_iter().skip(1).filter(seen);
        match named.max_by_key(|p| p.right - p.left) {
            Some(place) => places.push((what, place.middle(), [20, 0])),
            None => println!("SKIPPED: {what}: it is not in sight"),
        }
    }
    desk.quit();

    let desk = Desk::open_blind(&[&file]);
    desk.settle();
    println!("{file}, picture of {w}×{h} in a window of 1280×800");
    let mut all = Vec::new();
    for (what, at, reach) in places {
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
        println!(
            "{what}: answered in {median:.0} ms (median), {p95:.0} ms (95 %), {} inputs {by:?}; drawn anew in {:.0} ms (95 %); \
             exact {:.0} ms after the last",
            answered.len(),
            percentile(times(&drawn), 0.95),
            exact.last().map_or(f64::NAN, |(ms, _)| *ms),
        );
        all.extend(times(&answered));
        std::thread::sleep(Duration::from_millis(200));
    }
    println!("all: answered in {:.0} ms (95 %)", percentile(all, 0.95));
    desk.quit();
}
