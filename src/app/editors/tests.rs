//! Both editors by what a screen reader reads, with the pointer and with keys.

use std::sync::Arc;

use egui::{Event, Key, Modifiers, PointerButton, Pos2, Vec2, pos2, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use proptest::prelude::*;

use super::title;
use crate::app::camera;
use crate::app::config::Preferences;
use crate::app::document::{Document, Seen};
use crate::app::panels;
use crate::app::workspace::{Ask, Workspace};
use crate::scene::{Arrangement, builtin};
use crate::settings::Settings;
use crate::transfer::{
    ColorMode, ColorPoint, ColorShape, Interpolation, OpacityPoint, OpacityShape, Points, TransferFunction,
    TransferSource,
};

type Window = Harness<'static, Workspace>;

/// Opacities 0.2, 0.5, 0.8 over |κ| 0.2, 0.5, 0.8 at depth 0, and one point at depth 1; three greys over κ.
fn function() -> TransferFunction {
    let text = r#"
        [color]
        interpolation = "linear"
        points = [{ kappa = -0.5, color = 0.75 }, { kappa = 0, color = 0.5 }, { kappa = 0.5, color = 0.25 }]
        [opacity]
        interpolation = "linear"
        curves = [{ depth = 0, points = [[0.2, 0.2], [0.5, 0.5], [0.8, 0.8]] }, { depth = 1, points = [[0.5, 0.9]] }]
    "#;
    TransferFunction::from_toml(text, "test").unwrap()
}

fn window(source: TransferSource) -> Window {
    let mut workspace = Workspace::new(Preferences { parts: false, stages: false, ..Preferences::default() });
    let scene = Arc::new(builtin::build("quads").unwrap());
    let camera = camera::first(&scene.bounds(), 1.0);
    let mut settings = Settings::default();
    settings.opacity.transfer = source;
    let seen = Seen { settings, camera, arrangement: Arrangement::default() };
    workspace.document = Some(Document::new("builtin:quads".to_owned(), scene, seen));
    workspace.scene_number = 1;
    // As the shell does it after every frame.
    let show = |ui: &mut egui::Ui, workspace: &mut Workspace| {
        panels::show(ui, workspace);
        let held = ui.input(|i| i.pointer.any_down());
        workspace.settle(held);
    };
    let mut harness =
        Harness::builder().with_size(vec2(1280.0, 700.0)).with_step_dt(0.02).build_ui_state(show, workspace);
    panels::style::set_up(&harness.ctx);
    harness.run();
    harness
}

fn inline() -> Window {
    window(TransferSource::Inline(Box::new(function())))
}

fn source(window: &Window) -> TransferSource {
    window.state().document.as_ref().unwrap().seen.settings.opacity.transfer.clone()
}

fn now(window: &Window) -> TransferFunction {
    source(window).resolve(None).unwrap()
}

fn opacities(window: &Window) -> Vec<(f64, f64)> {
    let OpacityShape::Curves { curves, .. } = now(window).opacity.shape else { panic!("an image") };
    let curve = window.state().layout.editors.opacities.curve;
    curves.as_slice()[curve].points.as_slice().iter().map(|p| (p.kappa, p.opacity)).collect()
}

fn colors(window: &Window) -> Vec<(f64, [f64; 3])> {
    let ColorShape::Points { points, .. } = now(window).color.shape else { panic!("a strip") };
    points.as_slice().iter().map(|p| (p.kappa, p.color.0)).collect()
}

fn at(window: &Window, label: &str) -> Pos2 {
    window.get_by_label(label).rect().center()
}

/// Where |κ| or κ and height stand on the plot of this name.
fn place(window: &Window, plot: &str, [x, y]: [f64; 2]) -> Pos2 {
    let rect = window.get_by_label(plot).rect();
    pos2(rect.left() + x as f32 * rect.width(), rect.bottom() - y as f32 * rect.height())
}

fn button(window: &mut Window, pos: Pos2, pressed: bool, modifiers: Modifiers) {
    window.event(Event::PointerButton { pos, button: PointerButton::Primary, pressed, modifiers });
    window.step();
}

fn drag(window: &mut Window, from: Pos2, to: Pos2, modifiers: Modifiers) {
    window.event(Event::ModifiersChanged(modifiers));
    window.event(Event::PointerMoved(from));
    window.step();
    button(window, from, true, modifiers);
    for i in 1..=4 {
        window.event(Event::PointerMoved(from + (to - from) * (i as f32 / 4.0)));
        window.step();
    }
    button(window, to, false, modifiers);
    window.event(Event::ModifiersChanged(Modifiers::NONE));
    window.run();
}

fn double_click(window: &mut Window, pos: Pos2) {
    // A click shortly before would make a third of it.
    window.run_steps(40);
    window.event(Event::PointerMoved(pos));
    for pressed in [true, false, true, false] {
        button(window, pos, pressed, Modifiers::NONE);
    }
    window.run();
}

fn undo(window: &mut Window) -> bool {
    let done = window.state_mut().document.as_mut().unwrap().undo();
    window.run();
    done
}

fn close(a: f64, b: f64) -> bool {
    (a - b).abs() < 0.01
}

#[test]
fn a_double_click_adds_a_point_and_undo_takes_it_away() {
    let mut window = inline();
    let on_the_curve = place(&window, "Opacity curve", [0.65, 0.65]);
    double_click(&mut window, on_the_curve);
    let points = opacities(&window);
    assert_eq!(points.len(), 4);
    assert!(close(points[2].0, 0.65) && (points[2].1 - points[2].0).abs() < 1e-12, "on the curve: {points:?}");
    let above = place(&window, "Opacity curve", [0.35, 0.9]);
    double_click(&mut window, above);
    let points = opacities(&window);
    assert!(points.len() == 5 && close(points[1].0, 0.35) && close(points[1].1, 0.9), "{points:?}");
    assert!(undo(&mut window) && undo(&mut window) && !undo(&mut window), "a double-click is one step");
    assert_eq!(now(&window), function());
    let left = place(&window, "Colour curve", [0.125, 0.3]);
    double_click(&mut window, left);
    let points = colors(&window);
    assert!(points.len() == 4 && close(points[0].0, -0.75) && close(points[0].1[0], 0.3), "{points:?}");
    window.get_by_label("Colour point 1");
}

#[test]
fn a_drag_moves_a_point_and_is_one_step() {
    let mut window = inline();
    let plot = window.get_by_label("Opacity curve").rect();
    let way = vec2(0.1 * plot.width(), -0.3 * plot.height());
    let from = at(&window, "Opacity point 2");
    drag(&mut window, from, from + way, Modifiers::NONE);
    let points = opacities(&window);
    assert!(close(points[1].0, 0.6) && close(points[1].1, 0.8), "{points:?}");
    assert!(undo(&mut window) && !undo(&mut window));
    assert_eq!(now(&window), function());
    // Shift keeps to the longer axis, exactly.
    drag(&mut window, from, from + vec2(0.1 * plot.width(), -20.0), Modifiers::SHIFT);
    let points = opacities(&window);
    assert!(close(points[1].0, 0.6) && points[1].1 == 0.5, "{points:?}");
    undo(&mut window);
    drag(&mut window, from, from + vec2(9.0, -0.3 * plot.height()), Modifiers::SHIFT);
    let points = opacities(&window);
    assert!(points[1].0 == 0.5 && close(points[1].1, 0.8), "{points:?}");
    undo(&mut window);
    drag(&mut window, from, from + way, Modifiers::CTRL);
    let points = opacities(&window);
    assert!(close(points[1].0, 0.51) && close(points[1].1, 0.53), "a tenth: {points:?}");
    undo(&mut window);
    drag(&mut window, from, from + vec2(5000.0, -5000.0), Modifiers::NONE);
    let points = opacities(&window);
    assert!(
        points[1].0 < 0.8 && points[1].0 > 0.799 && points[1].1 == 1.0,
        "it stays before its neighbour: {points:?}"
    );
    undo(&mut window);
    let plot = window.get_by_label("Colour curve").rect();
    let from = at(&window, "Colour point 3");
    drag(&mut window, from, from + vec2(0.125 * plot.width(), -0.5 * plot.height()), Modifiers::NONE);
    let points = colors(&window);
    assert!(close(points[2].0, 0.75) && close(points[2].1[2], 0.75), "{points:?}");
}

#[test]
fn escape_puts_a_drag_back() {
    let mut window = inline();
    let from = at(&window, "Opacity point 2");
    window.event(Event::PointerMoved(from));
    button(&mut window, from, true, Modifiers::NONE);
    window.event(Event::PointerMoved(from + vec2(30.0, 30.0)));
    window.step();
    assert_ne!(now(&window), function());
    window.key_press(Key::Escape);
    window.step();
    assert_eq!(now(&window), function());
    window.event(Event::PointerMoved(from + vec2(60.0, 30.0)));
    window.step();
    button(&mut window, from, false, Modifiers::NONE);
    window.run();
    assert_eq!(now(&window), function());
    assert!(!undo(&mut window));
}

#[test]
fn escape_leaves_a_function_its_name() {
    let named = TransferSource::Named("pellucid".to_owned());
    let mut window = window(named.clone());
    let from = at(&window, "Opacity point 2");
    window.event(Event::PointerMoved(from));
    button(&mut window, from, true, Modifiers::NONE);
    window.event(Event::PointerMoved(from + vec2(4.0, -20.0)));
    window.step();
    assert_ne!(source(&window), named);
    window.key_press(Key::Escape);
    window.step();
    assert_eq!(source(&window), named);
    button(&mut window, from, false, Modifiers::NONE);
    window.run();
    assert_eq!(source(&window), named);
    assert!(!undo(&mut window), "there is nothing to take back");
}

#[test]
fn keys_walk_nudge_and_delete() {
    let mut window = inline();
    window.get_by_label("Opacity point 1").focus();
    window.run();
    window.key_press(Key::Tab);
    window.run();
    assert!(window.get_by_label("Opacity point 2").is_focused());
    window.key_press(Key::ArrowUp);
    window.run();
    window.key_press_modifiers(Modifiers::SHIFT, Key::ArrowRight);
    window.run();
    let points = opacities(&window);
    assert!((points[1].0 - 0.55).abs() < 1e-9 && (points[1].1 - 0.51).abs() < 1e-9, "{points:?}");
    assert!(window.get_by_label("Opacity point 2").is_focused(), "arrows do not move on");
    window.key_press(Key::Delete);
    window.run();
    assert_eq!(opacities(&window), [(0.2, 0.2), (0.8, 0.8)]);
    window.key_press(Key::Delete);
    window.run();
    assert!(window.get_by_label("Opacity point 1").is_focused(), "the last one is gone, so the one before it");
    window.key_press(Key::Delete);
    window.run();
    assert_eq!(opacities(&window), [(0.2, 0.2)], "one stays");
    (0..4).for_each(|_| assert!(undo(&mut window)));
    assert_eq!(now(&window), function());
    // A key that is held is one step.
    window.get_by_label("Colour point 1").focus();
    window.run();
    (0..5).for_each(|_| {
        window.key_down(Key::ArrowDown);
        window.step();
    });
    window.key_up(Key::ArrowDown);
    window.run();
    let points = colors(&window);
    assert!((points[0].1[0] - 0.7).abs() < 1e-9, "{points:?}");
    assert!(undo(&mut window) && !undo(&mut window));
    window.get_by_label("Colour point 1").increment_accesskit();
    window.run();
    assert!((colors(&window)[0].1[1] - 0.76).abs() < 1e-9);
}

fn enter(window: &mut Window, label: &str, text: &str) {
    window.get_by_label(label).click();
    window.run();
    window.key_press_modifiers(Modifiers::COMMAND, Key::A);
    window.event(Event::Text(text.to_owned()));
    window.run();
    window.key_press(Key::Enter);
    window.run();
}

#[test]
fn numbers_are_entered_for_what_is_selected() {
    let mut window = inline();
    assert!(window.query_by_label("|κ| of the selected point").is_none(), "nothing is selected");
    window.get_by_label("Opacity point 2").click();
    window.run();
    enter(&mut window, "|κ| of the selected point", "0.625");
    enter(&mut window, "Opacity of the selected points", "12.5");
    assert_eq!(opacities(&window)[1], (0.625, 0.125));
    window.get_by_label("Opacity point 1").click_modifiers(Modifiers::SHIFT);
    window.run();
    assert!(window.query_by_label("|κ| of the selected point").is_none(), "two cannot stand in one place");
    enter(&mut window, "Opacity of the selected points", "75 %");
    assert_eq!(opacities(&window)[..2], [(0.2, 0.75), (0.625, 0.75)]);
    enter(&mut window, "Depth of the curve", "0.25");
    let OpacityShape::Curves { curves, .. } = now(&window).opacity.shape else { unreachable!() };
    assert_eq!(curves.as_slice()[0].depth, 0.25);
    window.get_by_label("Colour point 2").click();
    window.run();
    enter(&mut window, "κ of the selected point", "-0.25");
    enter(&mut window, "Brightness of the selected points", "1");
    assert_eq!(colors(&window)[1], (-0.25, [1.0; 3]));
    // A sign on the picker's button to copy is in no font here.
    window.ctx.set_missing_glyph_policy(egui::MissingGlyphPolicy::Tofu);
    window.get_by_label("Pick the colour of the selected points").click();
    window.run();
    assert!(window.query_by_label("Colour point 2").is_some());
}

#[test]
fn a_band_selects_and_what_is_selected_moves_together() {
    let mut window = inline();
    let (from, to) = (place(&window, "Opacity curve", [0.1, 0.95]), place(&window, "Opacity curve", [0.6, 0.05]));
    drag(&mut window, from, to, Modifiers::NONE);
    assert_eq!(window.state().layout.editors.opacities.gestures.selected, [0, 1].into());
    assert!(!undo(&mut window), "to select changes nothing");
    let plot = window.get_by_label("Opacity curve").rect();
    let at = at(&window, "Opacity point 1");
    drag(&mut window, at, at + vec2(0.1 * plot.width(), -0.1 * plot.height()), Modifiers::NONE);
    let points = opacities(&window);
    assert!(close(points[0].0, 0.3) && close(points[1].0, 0.6) && close(points[1].1, 0.6), "{points:?}");
    assert_eq!(points[2], (0.8, 0.8));
    assert!(undo(&mut window) && !undo(&mut window));
    window.get_by_label("Delete opacity points").click();
    window.run();
    assert_eq!(opacities(&window), [(0.8, 0.8)]);
    let ground = place(&window, "Opacity curve", [0.3, 0.2]);
    drag(&mut window, ground, ground + vec2(0.0, 80.0), Modifiers::CTRL);
    assert_eq!(opacities(&window), [(0.8, 0.4)], "Ctrl on empty ground scales: 80 pixels are half");
}

#[test]
fn curves_are_chosen_added_moved_and_deleted_on_the_map() {
    let mut window = inline();
    window.get_by_label("Farther curve").click();
    window.run();
    assert_eq!(opacities(&window), [(0.5, 0.9)]);
    let middle = place(&window, "Opacity map", [0.5, 0.5]);
    double_click(&mut window, middle);
    let depths = |window: &Window| -> Vec<f64> {
        let OpacityShape::Curves { curves, .. } = now(window).opacity.shape else { unreachable!() };
        curves.as_slice().iter().map(|c| c.depth).collect()
    };
    assert!(depths(&window).len() == 3 && close(depths(&window)[1], 0.5));
    assert_eq!(window.state().layout.editors.opacities.curve, 1, "the new one is chosen");
    let plot = window.get_by_label("Opacity map").rect();
    let from = at(&window, "Depth curve 2");
    drag(&mut window, from, from + vec2(0.25 * plot.width(), 0.0), Modifiers::NONE);
    assert!(close(depths(&window)[1], 0.75), "{:?}", depths(&window));
    window.get_by_label("Depth curve 2").focus();
    window.key_press(Key::ArrowLeft);
    window.run();
    assert!(close(depths(&window)[1], 0.74));
    window.key_press(Key::Delete);
    window.run();
    assert_eq!(depths(&window), [0.0, 1.0]);
    let empty = place(&window, "Opacity map", [0.5, 0.5]);
    drag(&mut window, empty, empty + vec2(0.0, 80.0), Modifiers::CTRL);
    assert_eq!(now(&window).opacity.sample(1.0, 0.5), 0.45);
    (0..5).for_each(|_| assert!(undo(&mut window)));
    assert_eq!(now(&window), function());
}

#[test]
fn choices_presets_and_names() {
    let mut window = window(TransferSource::default());
    window.get_by_label("pellucid");
    window.get_by_label("Between points of colour").click();
    window.run();
    window.get_by_label("linear").click();
    window.run();
    window.get_by_label("pellucid, edited");
    let edited = now(&window);
    assert!(matches!(edited.color.shape, ColorShape::Points { interpolation: Interpolation::Linear, .. }));
    window.get_by_label("Multiply").click();
    window.run();
    assert_eq!(now(&window).color.mode, ColorMode::Multiply);
    window.get_by_label("Preset x-ray").click();
    window.run();
    assert_eq!(source(&window), TransferSource::Named("x-ray".to_owned()));
    assert!(undo(&mut window) && undo(&mut window));
    assert_eq!((now(&window), title(&source(&window)).as_str()), (edited, "pellucid, edited"));
    assert!(undo(&mut window));
    assert_eq!(source(&window), TransferSource::default());
    // Images become points when they are to be edited.
    window.get_by_label("Preset murray-6a-7b").click();
    window.run();
    window.get_by_label("Edit Opacity as points").click();
    window.run();
    assert!(matches!(now(&window).opacity.shape, OpacityShape::Curves { .. }));
    assert!(matches!(now(&window).color.shape, ColorShape::Points { .. }));
    window.get_by_label("Import…").click();
    window.get_by_label("Export…").click();
    window.run();
    assert!(window.state().asks.iter().filter(|a| matches!(a, Ask::Choose(_))).count() == 2);
}

#[test]
fn files_go_out_and_come_in() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = inline();
    let workspace = window.state_mut();
    let path = folder.path().join("mine.toml").to_string_lossy().into_owned();
    let text = super::export(workspace, &path).unwrap();
    std::fs::write(&path, text).unwrap();
    assert!(super::export(workspace, "mine.tiff").unwrap_err().contains(".toml"));
    let csv = super::export(workspace, "mine.csv").unwrap();
    assert!(!csv.is_empty());
    super::import(workspace, &path);
    assert_eq!(source(&window), TransferSource::Named(path));
    assert_eq!(now(&window), function());
    window.run();
    window.get_by_label("mine.toml");
    std::fs::write(folder.path().join("bad.toml"), "[color]\n").unwrap();
    super::import(window.state_mut(), &folder.path().join("bad.toml").to_string_lossy());
    assert!(window.state().messages.last().unwrap().text.contains("bad.toml:"));
}

#[test]
fn two_settings_are_compared() {
    let mut window = inline();
    window.get_by_label("Keep as A").click();
    window.run();
    assert!(window.state().against().is_none(), "nothing is different yet");
    window.get_by_label("Delete curve").click();
    window.run();
    let against = window.state().against().unwrap();
    assert_eq!(*against.transfer, function());
    let edited = now(&window);
    window.get_by_label("Swap A and B").click();
    window.run();
    assert_eq!(now(&window), function());
    assert_eq!(*window.state().against().unwrap().transfer, edited);
    window.get_by_label("Stop comparing").click();
    window.run();
    assert!(window.state().compare.is_none());
}

#[derive(Clone, Debug)]
enum Gesture {
    Drag(u8, f32, f32, u8),
    DoubleClick(bool, f64, f64),
    Key(u8, u8),
    Curve(u8),
    Undo,
    Redo,
}

fn gesture() -> impl Strategy<Value = Gesture> {
    prop_oneof![
        5 => (any::<u8>(), -200.0..200.0_f32, -120.0..120.0_f32, 0..3_u8).prop_map(|(i, x, y, m)| Gesture::Drag(i, x, y, m)),
        3 => (any::<bool>(), 0.0..1.0_f64, 0.0..1.0_f64).prop_map(|(c, x, y)| Gesture::DoubleClick(c, x, y)),
        3 => (any::<u8>(), 0..5_u8).prop_map(|(i, k)| Gesture::Key(i, k)),
        2 => (0..6_u8).prop_map(Gesture::Curve),
        2 => Just(Gesture::Undo),
        1 => Just(Gesture::Redo),
    ]
}

/// Every widget that a gesture may begin on.
fn handles(window: &Window) -> Vec<Pos2> {
    let names = ["Opacity point", "Colour point", "Depth curve"];
    let numbered = names.iter().flat_map(|name| (1..40).map(move |i| format!("{name} {i}")));
    let mut all: Vec<Pos2> = numbered.filter_map(|l| Some(window.query_by_label(&l)?.rect().center())).collect();
    all.extend(["Opacity curve", "Colour curve", "Opacity map"].map(|plot| place(window, plot, [0.05, 0.93])));
    all
}

fn sound(function: &TransferFunction) -> bool {
    let ColorShape::Points { points, .. } = &function.color.shape else { return false };
    let OpacityShape::Curves { curves, .. } = &function.opacity.shape else { return false };
    let curve = |points: &Points<OpacityPoint>| Points::new(points.as_slice().to_vec()).is_ok();
    Points::<ColorPoint>::new(points.as_slice().to_vec()).is_ok()
        && Points::new(curves.as_slice().to_vec()).is_ok()
        && curves.as_slice().iter().all(|c| curve(&c.points))
}

fn perform(window: &mut Window, gesture: &Gesture) {
    match *gesture {
        Gesture::Drag(i, x, y, held) => {
            let all = handles(window);
            let from = all[usize::from(i) % all.len()];
            let held = [Modifiers::NONE, Modifiers::SHIFT, Modifiers::CTRL][usize::from(held)];
            drag(window, from, from + Vec2::new(x, y), held);
        }
        Gesture::DoubleClick(color, x, y) => {
            let at = place(window, if color { "Colour curve" } else { "Opacity curve" }, [x, y]);
            double_click(window, at);
        }
        Gesture::Key(i, key) => {
            let all = handles(window);
            let at = all[usize::from(i) % all.len()];
            drag(window, at, at, Modifiers::NONE);
            window
                .key_press([Key::Delete, Key::ArrowLeft, Key::ArrowUp, Key::Insert, Key::ArrowDown][usize::from(key)]);
            window.run();
        }
        Gesture::Curve(what) => {
            let label =
                ["Add curve", "Delete curve", "Farther curve", "Nearer curve", "Add colour point", "Add opacity point"];
            window.get_by_label(label[usize::from(what)]).click();
            window.run();
        }
        Gesture::Undo => {
            undo(window);
        }
        Gesture::Redo => {
            window.state_mut().document.as_mut().unwrap().redo();
            window.run();
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]
    #[test]
    fn whatever_is_done_is_sound_and_undone_again(gestures in prop::collection::vec(gesture(), 1..14)) {
        let mut window = inline();
        for gesture in &gestures {
            perform(&mut window, gesture);
            prop_assert!(sound(&now(&window)), "{:?}", gesture);
            prop_assert!(!window.state().document.as_ref().unwrap().in_gesture(), "{:?} never ended", gesture);
        }
        let last = now(&window);
        let steps = (0..).take_while(|_| undo(&mut window)).count();
        prop_assert!(steps <= gestures.len(), "{} steps", steps);
        let bits = |f: &TransferFunction| f.to_toml().unwrap();
        prop_assert_eq!(bits(&now(&window)), bits(&function()));
        (0..steps).for_each(|_| assert!(window.state_mut().document.as_mut().unwrap().redo()));
        prop_assert_eq!(now(&window), last);
    }
}

#[test]
fn curves_are_drawn_without_their_straight_points() {
    let on = |f: &dyn Fn(f32) -> f32| (0..=300).map(|i| pos2(i as f32, f(i as f32))).collect::<Vec<_>>();
    let straight = super::without_straight(&on(&|x| 0.5 * x));
    assert_eq!(straight, [pos2(0.0, 0.0), pos2(300.0, 150.0)]);
    let bent = on(&|x| 40.0 * (x / 50.0).sin());
    let drawn = super::without_straight(&bent);
    assert!(drawn.len() < bent.len() / 3, "{}", drawn.len());
    for p in &bent {
        let i = drawn.iter().position(|d| d.x >= p.x).unwrap().max(1);
        let (a, b) = (drawn[i - 1], drawn[i]);
        let at = a.y + (b.y - a.y) * (p.x - a.x) / (b.x - a.x);
        assert!((at - p.y).abs() < 0.15, "{p:?} {at}");
    }
    assert_eq!(super::without_straight(&bent[..1]), bent[..1]);
    assert!(super::without_straight(&[]).is_empty());
}
