//! Undo and redo over whatever can be done to a document: random gestures on all panels, both editors and the picture.
//!
//! Each gesture is one step of undo, or none if it changes nothing. After any number of them, so many steps back give the very
//! first view bit for bit, through all those in between, and so many forth the last. What the shell does between two frames is
//! done here in a line.

use std::sync::Arc;

use egui::accesskit::Role;
use egui::{Event, Modifiers, PointerButton, Pos2, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use glam::{DVec2, DVec3};
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::{TestError, TestRunner};
use winit::keyboard::{Key, KeyCode, NamedKey, PhysicalKey, SmolStr};

use super::camera::{self, Button, Held};
use super::config::Preferences;
use super::document::{Document, Seen};
use super::hand::{Hand, WHEEL_RESTS};
use super::pictures::{Picked, Wish};
use super::planted::{self, Fault};
use super::workspace::Workspace;
use super::{keys, panels};
use crate::render::PickedLayer;
use crate::scene::{Arrangement, builtin};
use crate::settings::Settings;

/// What is done, with numbers that choose among what is there.
#[derive(Clone, Debug)]
enum Gesture {
    /// A slider or a number of any panel goes a step up or down: settings, looks of parts, sections, points of curves.
    Step(u16, bool),
    /// A switch of a setting, a section or a part.
    Switch(u16),
    /// A button of the panels and editors.
    Press(usize),
    /// A row of the tree, or its eye.
    Part(u16, bool),
    /// A point of a curve, or a curve, is dragged.
    Edit(u16, f32, f32),
    /// The picture is dragged.
    Drag(Button, bool, f64, f64),
    /// The wheel turns, by notches.
    Wheel(Vec<i8>),
    /// A click finds this part.
    Pick(u32, bool),
    /// A key without Ctrl.
    Key(usize),
}

/// Buttons that change what is seen. A label may stand several times; the first is pressed.
const BUTTONS: [&str; 22] = [
    "Add a section across x",
    "Add a section across y",
    "Add a section across z",
    "Add a section across the view",
    "Flip",
    "Remove",
    "Presence: Ghost",
    "Presence: Hidden",
    "Presence: Shown",
    "Solid",
    "As set",
    "As at first",
    "Isolate",
    "Frame",
    "Show all",
    "Add curve",
    "Delete curve",
    "Add opacity point",
    "Add colour point",
    "Multiply",
    "Preset x-ray",
    "Preset pellucid",
];

fn gesture() -> impl Strategy<Value = Gesture> {
    let button = prop_oneof![Just(Button::Left), Just(Button::Middle), Just(Button::Right)];
    prop_oneof![
        6 => (any::<u16>(), any::<bool>()).prop_map(|(i, up)| Gesture::Step(i, up)),
        2 => any::<u16>().prop_map(Gesture::Switch),
        6 => (0..BUTTONS.len()).prop_map(Gesture::Press),
        2 => (any::<u16>(), any::<bool>()).prop_map(|(i, eye)| Gesture::Part(i, eye)),
        4 => (any::<u16>(), -90.0..90.0_f32, -60.0..60.0_f32).prop_map(|(i, x, y)| Gesture::Edit(i, x, y)),
        4 => (button, any::<bool>(), -90.0..90.0, -60.0..60.0).prop_map(|(b, s, x, y)| Gesture::Drag(b, s, x, y)),
        1 => prop::collection::vec(-3..4_i8, 1..4).prop_map(Gesture::Wheel),
        2 => (0..8_u32, any::<bool>()).prop_map(|(part, more)| Gesture::Pick(part, more)),
        3 => (0..KEYS.len()).prop_map(Gesture::Key),
    ]
}

/// Keys that change what is seen: a letter, or a place of the number row.
const KEYS: [(&str, Option<KeyCode>); 12] = [
    ("f", None),
    ("c", None),
    ("i", None),
    ("g", None),
    ("h", None),
    ("v", None),
    ("1", Some(KeyCode::Digit1)),
    ("3", Some(KeyCode::Digit3)),
    ("5", Some(KeyCode::Digit5)),
    ("9", Some(KeyCode::Digit9)),
    ("Home", None),
    ("Escape", None),
];

struct Desk {
    workspace: Workspace,
    hand: Hand,
}

type Window = Harness<'static, Desk>;

fn window() -> Window {
    let mut workspace = Workspace::new(Preferences::default());
    let scene = Arc::new(builtin::build("stack").unwrap());
    let camera = camera::first(&scene.bounds(), 1.5);
    let mut arrangement = Arrangement::default();
    // Something selected from the start, so that the looks of parts are there.
    arrangement.selected.insert(1);
    let seen = Seen { settings: Settings::default(), camera, arrangement };
    workspace.document = Some(Document::new("builtin:stack".to_owned(), scene, seen));
    workspace.scene_number = 1;
    let show = |ui: &mut egui::Ui, desk: &mut Desk| {
        panels::show(ui, &mut desk.workspace);
        let held = ui.input(|i| i.pointer.any_down());
        desk.workspace.settle(held || desk.hand.is_wheeling());
    };
    let desk = Desk { workspace, hand: Hand::default() };
    let mut window = Harness::builder().with_size(vec2(1500.0, 1000.0)).with_step_dt(0.02).build_ui_state(show, desk);
    panels::style::set_up(&window.ctx);
    // A sign on the colour picker's button is in no font here.
    window.ctx.set_missing_glyph_policy(egui::MissingGlyphPolicy::Tofu);
    window.run();
    for heading in ["2  Features", "Light", "Outline of the selection", "Picture", "Sections"] {
        window.get_by_label(heading).click_accesskit();
        window.run();
    }
    window
}

fn seen(window: &Window) -> Seen {
    window.state().workspace.document.as_ref().unwrap().seen.clone()
}

/// To the last bit: numbers are printed so that they can be read back.
fn bits(seen: &Seen) -> String {
    format!("{seen:?}")
}

/// Where points of the editors are.
fn points(window: &Window) -> Vec<Pos2> {
    let names = ["Opacity point", "Colour point", "Depth curve"];
    let numbered = names.iter().flat_map(|name| (1..12).map(move |i| format!("{name} {i}")));
    numbered.filter_map(|l| Some(window.query_by_label(&l)?.rect().center())).collect()
}

fn drag(window: &mut Window, from: Pos2, by: egui::Vec2) {
    let button = |pos, pressed| Event::PointerButton {
        pos,
        button: PointerButton::Primary,
        pressed,
        modifiers: Modifiers::NONE,
    };
    for event in [Event::PointerMoved(from), button(from, true)] {
        window.event(event);
        window.step();
    }
    for i in 1..=3 {
        window.event(Event::PointerMoved(from + by * (i as f32 / 3.0)));
        window.step();
    }
    window.event(button(from + by, false));
    window.step();
    window.event(Event::PointerGone);
}

fn perform(window: &mut Window, gesture: &Gesture) {
    match *gesture {
        Gesture::Step(i, up) => {
            let all: Vec<_> =
                [Role::Slider, Role::SpinButton].into_iter().flat_map(|r| window.query_all_by_role(r)).collect();
            let node = &all[usize::from(i) % all.len()];
            if up { node.increment_accesskit() } else { node.decrement_accesskit() }
        }
        Gesture::Switch(i) => {
            let all: Vec<_> = window.query_all_by_role(Role::CheckBox).collect();
            all[usize::from(i) % all.len()].click_accesskit();
        }
        Gesture::Press(i) => {
            if let Some(button) = window.query_all_by_label(BUTTONS[i]).next() {
                button.click_accesskit();
            }
        }
        Gesture::Part(i, eye) => {
            let scene = Arc::clone(&window.state().workspace.document.as_ref().unwrap().scene);
            let name = &scene.parts[usize::from(i) % scene.parts.len()].name;
            let ends: &[&str] = if eye { &[" shown", " ghosted", " hidden"] } else { &[""] };
            let labels: Vec<String> = ends.iter().map(|end| format!("{name}{end}")).collect();
            let found = labels.iter().find_map(|label| window.query_all_by_label(label).next());
            if let Some(node) = found {
                node.click_accesskit();
            }
        }
        Gesture::Edit(i, x, y) => {
            let all = points(window);
            if !all.is_empty() {
                drag(window, all[usize::from(i) % all.len()], vec2(x, y));
            }
        }
        Gesture::Drag(button, shift, x, y) => {
            let Desk { workspace, hand } = window.state_mut();
            let from = DVec2::from(workspace.viewport.origin.map(f64::from)) + DVec2::splat(120.0);
            hand.held = Held { shift, ..Held::default() };
            hand.moved(workspace, from, true);
            hand.pressed(workspace, button, true);
            for i in 1..=3 {
                hand.moved(workspace, from + DVec2::new(x, y) * (f64::from(i) / 3.0), true);
            }
            hand.released(workspace, button);
            hand.held = Held::default();
            // A short way is a click, and nobody answers it here.
            workspace.asks.clear();
        }
        Gesture::Wheel(ref notches) => {
            let Desk { workspace, hand } = window.state_mut();
            hand.cursor = DVec2::from(workspace.viewport.origin.map(f64::from)) + DVec2::splat(90.0);
            notches.iter().for_each(|n| hand.wheel(workspace, f64::from(*n)));
            window.step();
            std::thread::sleep(WHEEL_RESTS);
        }
        Gesture::Pick(part, more) => {
            let workspace = &mut window.state_mut().workspace;
            let document = workspace.document.as_ref().unwrap();
            let part = part % document.scene.parts.len() as u32;
            let (of, position) = (document.seen.camera, document.scene.bounds().center());
            let layer = PickedLayer { part, depth: 1.0, position, normal: DVec3::Z, kappa: 0.1, opacity: 0.5 };
            let (scene_number, wish) = (workspace.scene_number, Wish::Select { more });
            workspace.take_picked(Picked { scene_number, wish, pixel: [60, 60], of, layers: vec![layer] });
        }
        Gesture::Key(i) => {
            let (word, place) = KEYS[i];
            let key = match word {
                "Home" => Key::Named(NamedKey::Home),
                "Escape" => Key::Named(NamedKey::Escape),
                letter => Key::Character(SmolStr::new(letter)),
            };
            let place = PhysicalKey::Code(place.unwrap_or(KeyCode::KeyX));
            let workspace = &mut window.state_mut().workspace;
            // Escape would dismiss what is said first.
            workspace.messages.clear();
            keys::press(workspace, &key, place, Held::default(), false);
        }
    }
    window.run();
}

/// Performs all, then goes back and forth.
fn walk(gestures: &[Gesture]) -> Result<(), TestCaseError> {
    let mut window = window();
    let mut states = vec![seen(&window)];
    for gesture in gestures {
        perform(&mut window, gesture);
        let now = seen(&window);
        let document = window.state().workspace.document.as_ref().unwrap();
        prop_assert!(!document.in_gesture(), "{:?} never ended", gesture);
        if Some(&now) != states.last() {
            states.push(now);
        }
    }
    let document = window.state_mut().workspace.document.as_mut().unwrap();
    for state in states.iter().rev().skip(1) {
        prop_assert!(document.undo());
        prop_assert_eq!(bits(&document.seen), bits(state));
    }
    prop_assert!(!document.undo(), "more steps than gestures");
    for state in &states[1..] {
        prop_assert!(document.redo());
        prop_assert_eq!(bits(&document.seen), bits(state));
    }
    prop_assert!(!document.redo());
    Ok(())
}

fn runner(cases: u32) -> TestRunner {
    TestRunner::new(ProptestConfig { cases, failure_persistence: None, ..ProptestConfig::default() })
}

#[test]
fn every_gesture_is_one_step_back_and_forth() {
    let gestures = prop::collection::vec(gesture(), 1..24);
    runner(24).run(&gestures, |gestures| walk(&gestures)).unwrap_or_else(|e| panic!("{e}"));
}

/// A gesture that forgets to become a step is found.
#[test]
fn gestures_that_forget_to_settle_are_found() {
    for fault in [Fault::EndlessDrag, Fault::Unsettled, Fault::LostStep] {
        let gestures = prop::collection::vec(gesture(), 1..24);
        let found = planted::with(fault, || runner(24).run(&gestures, |gestures| walk(&gestures)));
        assert!(matches!(found, Err(TestError::Fail(..))), "{fault:?}: {found:?}");
    }
}

/// Every kind of gesture changes something of what it is for: else the walk would prove nothing.
#[test]
fn all_kinds_of_gestures_change_something() {
    let all = prop::collection::vec(gesture(), 120).new_tree(&mut TestRunner::deterministic()).unwrap().current();
    let mut window = window();
    let mut changed = [0; 9];
    for gesture in &all {
        let before = seen(&window);
        perform(&mut window, gesture);
        let kind = match gesture {
            Gesture::Step(..) => 0,
            Gesture::Switch(_) => 1,
            Gesture::Press(_) => 2,
            Gesture::Part(..) => 3,
            Gesture::Edit(..) => 4,
            Gesture::Drag(..) => 5,
            Gesture::Wheel(_) => 6,
            Gesture::Pick(..) => 7,
            Gesture::Key(_) => 8,
        };
        changed[kind] += usize::from(seen(&window) != before);
    }
    assert!(changed.iter().all(|n| *n > 0), "{changed:?}");
    let last = seen(&window);
    assert!(last.settings != Settings::default() && last.arrangement != Arrangement::default());
}
