//! The panel by its labels, over made-up measurements.

use std::sync::Arc;

use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;

use super::overlay::Overlay;
use super::*;
use crate::app::panels::diagram::Places;
use crate::app::panels::tests::{harness, settings, workspace};
use crate::app::pictures::Kind;
use crate::app::workspace::OnScreen;
use crate::passes::capture::LayerCounts;
use crate::settings::{CaptureKind, NormalEncoding};
use crate::tradeoff::axis::{configurations, named};
use crate::tradeoff::budget::{Choice, Verdict};
use crate::tradeoff::hard_cases;
use crate::tradeoff::statistics::Estimate;
use crate::tradeoff::sweep::Times;

/// `ratio` times the baseline's 10 ms, from `count` frames.
fn measured(ratio: f64, count: usize, mean: f64) -> Measured {
    let estimate = |median: f64| Some(Estimate { median, low: 0.9 * median, high: 1.1 * median, count });
    let times = Times { baseline_samples: vec![10.0; 3], ratio: estimate(ratio), ..Times::default() };
    Measured {
        image: ImageError { mean, maximum: 3.0 * mean, flip_mean: 0.01 * mean, ..ImageError::default() },
        layers: None,
        counts: LayerCounts::default(),
        buffer_bytes: 0,
        times: Some(times),
        thumbnails: None,
    }
}

/// A workspace with the panel open and four configurations swept; with 16 samples nothing was measured.
fn swept() -> Workspace {
    let mut workspace = workspace("quads");
    workspace.preferences.accuracy = true;
    let seen = workspace.document.as_ref().unwrap().seen.clone();
    let axes = named(&["normals".to_owned(), "resolution".to_owned()]).unwrap();
    let rows = configurations(&seen.settings, &axes).unwrap();
    let entries = rows.into_iter().map(|configuration| {
        let outcome = match configuration.name.as_str() {
            axis::AS_ASKED => Ok(measured(1.2, 9, 0.5)),
            "normals=xy15" => Ok(measured(0.5, 9, 4.0)),
            "normals=full" => Ok(measured(2.0, 9, 0.0)),
            "resolution=0.5" => Ok(measured(0.3, 9, 8.0)),
            _ => Err("not measured: called off".to_owned()),
        };
        Entry::from(Row { configuration, outcome })
    });
    let entries = entries.collect();
    workspace.accuracy.swept = Some(Swept { scene_number: workspace.scene_number, seen, size: [256, 160], entries });
    workspace
}

fn undo(harness: &mut Harness<'_, Workspace>) {
    harness.state_mut().undo();
    harness.run();
}

#[test]
fn a_point_of_the_sweep_is_applied_as_one_step_and_marked_as_present() {
    let mut harness = harness(swept());
    harness.get_by_label("Apply as asked: 10 ms, 0.5, best, present");
    harness.get_by_label("Apply normals=full: 20 ms, 0, best");
    harness.get_by_label("Apply normals=xy15: 5 ms, 4, best").click();
    harness.run();
    assert_eq!(settings(&harness).capture.normals, NormalEncoding::Xy15);
    harness.get_by_label("Apply normals=xy15: 5 ms, 4, best, present");
    harness.get_by_label("Apply as asked: 10 ms, 0.5, best");
    assert!(harness.query_by_label("Measured for another view or look.").is_none(), "a technique is no look");
    undo(&mut harness);
    assert_eq!(*settings(&harness), Settings::default());
    assert!(!harness.state().document.as_ref().unwrap().ways().0, "it was one step");
    // By the keyboard.
    harness.get_by_label("Apply normals=full: 20 ms, 0, best").focus();
    harness.run();
    harness.key_press(egui::Key::Enter);
    harness.run();
    assert_eq!(settings(&harness).capture.normals, NormalEncoding::Full);
}

#[test]
fn a_click_on_the_diagram_applies_the_point_under_it() {
    let mut harness = harness(swept());
    let points = harness.state().accuracy.swept.as_ref().unwrap().points(Shows::Mean, None);
    assert_eq!(points.len(), 3);
    let slow = points.iter().find(|p| p.point.error == 0.0).unwrap();
    assert_eq!(slow.point.time, [18.0, 20.0, 22.0], "in milliseconds: times the baseline's");
    let rect = harness.get_by_label("Diagram of time against error, 3 points").rect();
    let places = Places::of(&points, rect);
    let ats: Vec<egui::Pos2> = points.iter().map(|p| places.at(p)).collect();
    assert!(ats.iter().all(|at| rect.contains(*at)), "{ats:?} {rect:?}");
    let by_time = |name: &str| ats[points.iter().position(|p| p.point.label == name).unwrap()];
    assert!(
        by_time("normals=xy15").x < by_time(axis::AS_ASKED).x && by_time(axis::AS_ASKED).x < by_time("normals=full").x
    );
    assert!(
        by_time("normals=xy15").y < by_time(axis::AS_ASKED).y && by_time(axis::AS_ASKED).y < by_time("normals=full").y
    );
    let at = places.at(slow) + egui::vec2(2.0, -2.0);
    harness.hover_at(at);
    harness.run();
    harness.get_by_label_contains("20 ms a frame (18 to 22)");
    harness.drag_at(at);
    harness.drop_at(at);
    harness.run();
    assert_eq!(settings(&harness).capture.normals, NormalEncoding::Full);
}

#[test]
fn results_of_another_view_look_or_model_are_labelled() {
    let mut harness = harness(swept());
    let stale = |h: &Harness<'_, Workspace>, text: &str| h.query_by_label(text).is_some();
    assert!(!stale(&harness, "Measured for another view or look."));
    harness.state_mut().document.as_mut().unwrap().seen.settings.opacity.gain = 2.0;
    harness.run();
    assert!(stale(&harness, "Measured for another view or look."));
    harness.get_by_label("Apply as asked: 10 ms, 0.5, best");
    // What is applied is the technique; the look stays.
    harness.get_by_label("Apply normals=xy15: 5 ms, 4, best").click();
    harness.run();
    assert_eq!((settings(&harness).opacity.gain, settings(&harness).capture.normals), (2.0, NormalEncoding::Xy15));
    undo(&mut harness);
    harness.state_mut().document.as_mut().unwrap().seen.settings.opacity.gain = Settings::default().opacity.gain;
    harness.run();
    assert!(!stale(&harness, "Measured for another view or look."));
    harness.state_mut().look(|_, _, c| Some(c.azimuth(5.0)));
    harness.run();
    assert!(stale(&harness, "Measured for another view or look."));
    harness.state_mut().scene_number += 1;
    harness.run();
    assert!(stale(&harness, "Measured for another model."));
}

#[test]
fn a_smaller_resolution_is_shown_but_not_applied() {
    let mut workspace = swept();
    workspace.accuracy.form.shows = Shows::Sampling;
    let mut harness = harness(workspace);
    harness.get_by_label("Apply resolution=0.5: 3 ms, 8, best").click();
    harness.run();
    assert_eq!(*settings(&harness), Settings::default());
    assert!(harness.state().messages.last().unwrap().text.contains("command line"));
    harness.get_by_label_contains("without figures").click();
    harness.run();
    assert!(harness.query_all_by_label_contains("called off").count() > 0);
}

fn shown(serial: u64) -> Arc<Shown> {
    Arc::new(Shown { serial, size: [2, 2], rgba: vec![255; 16], background: None })
}

/// An exact picture on screen and what was found of it.
fn compared() -> Workspace {
    let mut workspace = workspace("quads");
    workspace.preferences.accuracy = true;
    let seen = workspace.document.as_ref().unwrap().seen.clone();
    workspace.order = 7;
    workspace.screen = Some(OnScreen {
        shown: shown(1),
        number: 7,
        kind: Kind::Exact,
        view: (seen.camera, [2, 2]),
        look: (seen.settings, seen.arrangement),
        size: [2, 2],
        linear: None,
        milliseconds: 1.0,
    });
    let error = ImageError { maximum: 5.0, mean: 0.25, above_1: 0.125, above_8: 0.0, flip_mean: 0.5, flip_p99: 0.75 };
    workspace.accuracy.found =
        Some(Referenced { number: 7, error, reference: shown(2), difference: shown(3), milliseconds: 12.0 });
    workspace
}

#[test]
fn what_was_found_is_shown_of_the_very_picture_alone() {
    let mut harness = harness(compared());
    for label in [
        "Largest error: 5 / 255",
        "Mean error: 0.25 / 255",
        "Pixels off by more than 1/255: 12.5 %",
        "Pixels off by more than 8/255: 0 %",
        "FLIP, mean: 0.5",
        "FLIP, 99th percentile: 0.75",
    ] {
        harness.get_by_label(label);
    }
    let legend = "Colours of differences from 0 to 64 steps of 1/255";
    assert!(harness.query_by_label(legend).is_none() && !harness.state().wants_reference());
    harness.get_by_label("Overlay: Difference").click();
    harness.run();
    assert_eq!(harness.state().accuracy.overlay, Overlay::Difference);
    harness.get_by_label(legend);
    harness.get_by_label("Divider between reference and picture");
    assert!(harness.state().referenced().is_some() && !harness.state().wants_reference(), "it is there");
    // Something changes: what was found is of an earlier picture, and is not shown over this one.
    harness.state_mut().order = 8;
    harness.run();
    assert!(harness.query_by_label(legend).is_none());
    harness.get_by_label("These figures are of an earlier picture.");
    assert!(!harness.state().wants_reference(), "not before the exact picture");
    harness.state_mut().screen.as_mut().unwrap().number = 8;
    assert!(harness.state().wants_reference() && !harness.state().is_at_rest());
    harness.state_mut().take_referenced(Err((8, "the device is lost".to_owned())));
    harness.run();
    assert!(!harness.state().wants_reference(), "not again and again");
    harness.get_by_label("There is no reference: the device is lost");
    harness.get_by_label("Overlay: Off").click();
    harness.run();
    assert!(harness.query_by_label("Divider between reference and picture").is_none());
}

#[test]
fn the_accuracy_panel_asks_for_measuring_shows_and_stops_it() {
    let mut workspace = workspace("quads");
    workspace.preferences.accuracy = true;
    let mut harness = harness(workspace);
    for (button, wanted) in [
        ("Measure all", Wanted::Sweep),
        ("Choose by time", Wanted::Budget(Goal::Time(100.0))),
        ("Choose by error", Wanted::Budget(Goal::Error(0.02))),
    ] {
        harness.get_by_label(button).click();
        harness.run();
        assert_eq!(std::mem::take(&mut harness.state_mut().asks), [Ask::Measure(wanted)]);
    }
    let name = "normals=xy15".to_owned();
    harness.state_mut().accuracy.underway =
        Some(Underway { wanted: Wanted::Sweep, done: 3, of: 12, name, rests: true });
    harness.run();
    harness.get_by_label_contains("3 of 12  normals=xy15  (rests while the window draws)");
    harness.get_by_label("Choose by time").click();
    harness.run();
    assert!(harness.state().asks.is_empty(), "one at a time");
    harness.get_by_label("Stop measuring").click();
    harness.run();
    assert_eq!(harness.state().asks, [Ask::StopMeasuring]);
}

fn chosen() -> Chosen {
    let settings = Settings::from_pairs("capture.kind=bucketed_k_buffer capture.bucketed_k_buffer.k=4").unwrap();
    let choice = Choice {
        name: "k=4".to_owned(),
        settings,
        scale: 1.0,
        flip: 0.01,
        reference_samples: 16,
        time: Estimate { median: 3.0, low: 3.0, high: 3.0, count: 7 },
        asked: 9.0,
        verdict: Verdict::Kept,
        compared: 5,
        cut_short: false,
        reason: "nothing faster was found".to_owned(),
    };
    Chosen { choice, sentence: "within 4 ms: 'k=4', because".to_owned(), not_kept: None }
}

#[test]
fn what_a_budget_chooses_is_told_and_applied_as_one_step() {
    let mut harness = harness(compared());
    let seen = harness.state().document.as_ref().unwrap().seen.clone();
    harness.state_mut().take_chosen(chosen(), 1, seen.clone());
    harness.run();
    harness.get_by_label("within 4 ms: 'k=4', because");
    harness.get_by_label("These are the present settings.");
    assert_eq!(settings(&harness).capture.kind, CaptureKind::BucketedKBuffer);
    undo(&mut harness);
    assert_eq!(*settings(&harness), Settings::default());
    assert!(!harness.state().document.as_ref().unwrap().ways().0);
    // What has changed meanwhile is not overruled.
    harness.state_mut().look(|_, _, c| Some(c.azimuth(5.0)));
    harness.state_mut().take_chosen(chosen(), 1, seen);
    harness.run();
    assert_eq!(*settings(&harness), Settings::default());
    harness.get_by_label("Chosen for another view.");
    harness.get_by_label("Apply").click();
    harness.run();
    assert_eq!(settings(&harness).capture.bucketed_k_buffer.k, 4);
}

#[test]
fn a_hard_case_has_what_fails_left_of_the_divider() {
    let mut workspace = workspace("quads");
    workspace.preferences.accuracy = true;
    let case = |planted: bool| {
        let with = |c: &crate::scene::hard_case::HardCase| {
            c.contrast.is_some_and(|c| c.method().shader.is_some() == planted && c.method().scene.is_none())
                && c.ours.scene.is_none()
                && (planted || c.contrast.is_some_and(|o| o.method().settings != c.ours.settings))
        };
        hard_cases::all().map(|(_, c)| c).find(|c| with(c)).unwrap()
    };
    workspace.show_case(case(true));
    let against = workspace.against().expect("a planted error differs by its shader alone");
    assert_eq!(against.shaders.unwrap().len(), 1);
    let printed = case(false);
    workspace.show_case(printed);
    let kept = &workspace.compare.as_ref().unwrap().kept;
    let contrast = printed.contrast.unwrap();
    assert_eq!(kept.settings, Settings::from_pairs(contrast.method().settings).unwrap());
    assert!(kept.shaders.is_none());
    let harness = harness(workspace);
    harness.get_by_label(printed.name);
    harness.get_by_label_contains(contrast.method().label);
    let mut workspace = harness.into_state();
    workspace.end_case();
    assert!(workspace.compare.is_none() && workspace.accuracy.case.is_none());
    workspace.keep_for_comparison();
    workspace.end_case();
    assert!(workspace.compare.is_some(), "one's own comparison stays");
}
