//! Handles of section planes with the pointer and with keys.

use std::sync::Arc;

use egui::accesskit::Role;
use egui::{Event, Key, Modifiers, PointerButton, Pos2, Vec2, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use glam::DVec3;
use winit::keyboard::{Key as Pressed, KeyCode, NamedKey, PhysicalKey};

use crate::app::camera::{self, Held};
use crate::app::config::Preferences;
use crate::app::document::{Document, Seen};
use crate::app::workspace::Workspace;
use crate::app::{keys, panels};
use crate::math::{Camera, Projection};
use crate::scene::{Arrangement, Section, builtin};
use crate::settings::Settings;

type Window = Harness<'static, Workspace>;

/// From the front in parallel, one plane across x and one across z in the middle, handles shown.
fn window() -> Window {
    let mut workspace = Workspace::new(Preferences { parts: false, editors: false, ..Preferences::default() });
    let scene = Arc::new(builtin::build("stack").unwrap());
    let first = camera::other_projection(&camera::first(&scene.bounds(), 1.0));
    let camera = camera::named(&first, &scene.bounds(), 1.0, "front", false).unwrap();
    let bounds = crate::app::planes::in_file(&scene.bounds(), &scene);
    let sections = [DVec3::X, DVec3::Z].map(|n| panels::sections::through_the_middle(&bounds, n)).into();
    let arrangement = Arrangement { sections, ..Arrangement::default() };
    let seen = Seen { settings: Settings::default(), camera, arrangement };
    workspace.document = Some(Document::new("builtin:stack".to_owned(), scene, seen));
    workspace.scene_number = 1;
    workspace.layout.planes.choose(0);
    // As the shell does it after every frame.
    let show = |ui: &mut egui::Ui, workspace: &mut Workspace| {
        panels::show(ui, workspace);
        let held = ui.input(|i| i.pointer.any_down());
        if let Some(document) = workspace.document.as_mut().filter(|_| !held) {
            document.settle();
        }
    };
    let mut window =
        Harness::builder().with_size(vec2(1000.0, 700.0)).with_step_dt(0.02).build_ui_state(show, workspace);
    panels::style::set_up(&window.ctx);
    window.run();
    window
}

fn planes(window: &Window) -> [Section; 2] {
    window.state().document.as_ref().unwrap().seen.arrangement.sections.clone().try_into().unwrap()
}

fn center(window: &Window, label: &str) -> Pos2 {
    window.get_by_label(label).rect().center()
}

/// Scene units of a point of the screen.
fn unit(window: &Window) -> f64 {
    let Camera { projection: Projection::Orthographic { height }, .. } =
        window.state().document.as_ref().unwrap().seen.camera
    else {
        panic!("parallel")
    };
    height / f64::from(window.state().viewport.size[1])
}

fn button(window: &mut Window, pos: Pos2, pressed: bool, modifiers: Modifiers) {
    window.event(Event::PointerButton { pos, button: PointerButton::Primary, pressed, modifiers });
    window.step();
}

/// Presses the button on a handle and moves; it stays down.
fn pull(window: &mut Window, label: &str, by: Vec2, modifiers: Modifiers) -> Pos2 {
    let from = center(window, label);
    window.event(Event::ModifiersChanged(modifiers));
    window.event(Event::PointerMoved(from));
    window.step();
    button(window, from, true, modifiers);
    for i in 1..=4 {
        window.event(Event::PointerMoved(from + by * (i as f32 / 4.0)));
        window.step();
    }
    from + by
}

fn drag(window: &mut Window, label: &str, by: Vec2, modifiers: Modifiers) {
    let to = pull(window, label, by, modifiers);
    button(window, to, false, modifiers);
    window.event(Event::ModifiersChanged(Modifiers::NONE));
    window.run();
}

/// Within what a sixteenth of a point, to which egui rounds, is worth here.
fn close(a: f64, b: f64) -> bool {
    (a - b).abs() < 1e-3 * (1.0 + b.abs())
}

#[test]
fn planes_are_pulled_by_their_arrows_in_one_step() {
    let mut window = window();
    let (before, unit) = (planes(&window), unit(&window));
    drag(&mut window, "Pull section 1", vec2(40.0, 25.0), Modifiers::NONE);
    let after = planes(&window);
    assert!(close(after[0].offset, before[0].offset + 40.0 * unit), "{after:?} from {before:?}, {unit}");
    assert_eq!((after[0].normal, after[1]), (DVec3::X, before[1]));
    // Slower with Ctrl.
    drag(&mut window, "Pull section 1", vec2(-40.0, 0.0), Modifiers::CTRL);
    assert!(close(planes(&window)[0].offset, after[0].offset - 4.0 * unit));
    // The plane that faces the viewer goes up and down, and is the chosen one then.
    drag(&mut window, "Pull section 2", vec2(0.0, -20.0), Modifiers::NONE);
    assert!(close(planes(&window)[1].offset, before[1].offset + 20.0 * unit));
    assert_eq!(window.state().layout.planes.chosen, 1);
    // Far out it stops at the end of the model.
    drag(&mut window, "Pull section 1", vec2(5000.0, 0.0), Modifiers::NONE);
    let document = window.state_mut().document.as_mut().unwrap();
    assert!(close(document.seen.arrangement.sections[0].offset, document.scene.bounds().max.x));
    for _ in 0..4 {
        assert!(document.undo());
    }
    assert_eq!(document.seen.arrangement.sections, before);
    assert!(!document.undo(), "one step a drag");
}

#[test]
fn a_knob_tilts_its_plane_about_its_middle() {
    let mut window = window();
    let before = planes(&window)[0];
    assert!(window.query_by_label("Tilt section 2").is_none(), "only the chosen one has a knob");
    // From the right inwards it comes to face the viewer: 84 points are a right angle.
    drag(&mut window, "Tilt section 1", vec2(-42.0, 0.0), Modifiers::NONE);
    let turned = planes(&window)[0];
    assert!((turned.normal - DVec3::new(1.0, 0.0, 1.0).normalize()).length() < 1e-3, "{turned:?}");
    let middle = window.state().document.as_ref().unwrap().scene.bounds().center();
    assert!(close(turned.normal.dot(middle), turned.offset), "through the same point: {turned:?}");
    let document = window.state_mut().document.as_mut().unwrap();
    assert!(document.undo() && document.seen.arrangement.sections[0] == before && !document.undo());
    window.run();
    drag(&mut window, "Tilt section 1", vec2(-3.0, -25.0), Modifiers::SHIFT);
    let snapped = planes(&window)[0].normal;
    let degrees = snapped.y.asin().to_degrees();
    assert!(degrees > 10.0 && close(degrees / 15.0, (degrees / 15.0).round()), "{snapped}");
}

#[test]
fn escape_gives_a_drag_up_and_then_hides_the_handles() {
    let mut window = window();
    let before = planes(&window);
    let to = pull(&mut window, "Pull section 1", vec2(60.0, 0.0), Modifiers::NONE);
    assert_ne!(planes(&window), before);
    // As the shell hears it, before any frame.
    let escape = |window: &mut Window| {
        let (key, place) = (Pressed::Named(NamedKey::Escape), PhysicalKey::Code(KeyCode::Escape));
        keys::press(window.state_mut(), &key, place, Held::default(), false);
    };
    escape(&mut window);
    assert_eq!(planes(&window), before);
    window.event(Event::PointerMoved(to + vec2(30.0, 0.0)));
    window.step();
    button(&mut window, to, false, Modifiers::NONE);
    window.run();
    assert_eq!(planes(&window), before, "what is given up does not go on");
    // And as egui hears it.
    let to = pull(&mut window, "Tilt section 1", vec2(-30.0, 9.0), Modifiers::NONE);
    assert_ne!(planes(&window), before);
    window.key_press(Key::Escape);
    window.step();
    button(&mut window, to, false, Modifiers::NONE);
    window.run();
    assert_eq!(planes(&window), before);
    assert!(!window.state_mut().document.as_mut().unwrap().undo(), "no step of what was given up");
    assert!(window.state().layout.planes.shown);
    escape(&mut window);
    window.run();
    assert!(!window.state().layout.planes.shown && window.query_by_label("Pull section 1").is_none());
    let x = Pressed::Character("x".into());
    keys::press(window.state_mut(), &x, PhysicalKey::Code(KeyCode::KeyX), Held::default(), false);
    window.run();
    window.get_by_label("Pull section 1");
}

#[test]
fn keys_move_the_handle_that_has_the_focus() {
    let mut window = window();
    let before = planes(&window);
    let bounds = window.state().document.as_ref().unwrap().scene.bounds();
    let size = bounds.max.x - bounds.min.x;
    window.get_by_role_and_label(Role::Slider, "Pull section 1").focus();
    window.run();
    window.key_press(Key::ArrowRight);
    window.run();
    assert!(close(planes(&window)[0].offset, before[0].offset + size / 200.0));
    window.key_press_modifiers(Modifiers::SHIFT, Key::ArrowDown);
    window.run();
    assert!(close(planes(&window)[0].offset, before[0].offset + size / 200.0 - size / 20.0));
    window.get_by_role_and_label(Role::Slider, "Tilt section 1").focus();
    window.run();
    for _ in 0..10 {
        window.key_press(Key::ArrowLeft);
        window.run();
    }
    let toward = planes(&window)[0].normal.z.asin().to_degrees();
    assert!(close(toward, 10.0), "{toward}");
    window.get_by_label("Pull section 2").focus();
    window.run();
    assert_eq!(window.state().layout.planes.chosen, 1, "focus chooses");
    window.get_by_label("Tilt section 2");
    let document = window.state_mut().document.as_mut().unwrap();
    let steps = (0..).take_while(|_| document.undo()).count();
    assert_eq!((steps, document.seen.arrangement.sections.as_slice()), (12, before.as_slice()));
}

#[test]
fn an_undo_in_the_middle_ends_a_drag_and_hidden_planes_have_no_handle() {
    let mut window = window();
    let before = planes(&window);
    let to = pull(&mut window, "Pull section 1", vec2(60.0, 0.0), Modifiers::NONE);
    window.state_mut().undo();
    window.event(Event::PointerMoved(to + vec2(30.0, 0.0)));
    window.step();
    button(&mut window, to, false, Modifiers::NONE);
    window.run();
    assert_eq!(planes(&window), before);
    window.state_mut().document.as_mut().unwrap().seen.arrangement.sections[0].enabled = false;
    window.run();
    assert!(window.query_by_label("Pull section 1").is_none());
    window.get_by_label("Pull section 2");
    // Wherever the camera stands, nothing breaks, and what is before the eye can be reached.
    let bounds = window.state().document.as_ref().unwrap().scene.bounds();
    for position in [bounds.center(), bounds.center() + DVec3::Z * 0.01, bounds.max * 100.0, bounds.center() - DVec3::Z]
    {
        let projection = Projection::Perspective { fov_y: 1.0 };
        let focal_point = bounds.center() - DVec3::Z * 5.0;
        let camera = Camera { position, focal_point, view_up: DVec3::Y, projection };
        window.state_mut().document.as_mut().unwrap().seen.camera = camera;
        window.run();
    }
}
