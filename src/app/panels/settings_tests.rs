//! Every setting has a widget, and what the widget sets comes back from a session file.

use std::sync::Arc;

use egui::accesskit::Role;
use egui::{Key, Modifiers};
use egui_kittest::kittest::{NodeT, Queryable};
use egui_kittest::{Harness, Node};

use crate::app::camera;
use crate::app::config::Preferences;
use crate::app::document::{Document, Seen};
use crate::app::panels::{self, stages};
use crate::app::workspace::Workspace;
use crate::scene::{Arrangement, builtin};
use crate::session::Session;
use crate::settings::{Declaration, Range, Settings};

type Window = Harness<'static, Workspace>;

fn window() -> Window {
    let preferences = Preferences { parts: false, editors: false, ..Preferences::default() };
    let mut workspace = Workspace::new(preferences);
    let scene = Arc::new(builtin::build("quads").unwrap());
    let camera = camera::first(&scene.bounds(), 1.0);
    let seen = Seen { settings: Settings::default(), camera, arrangement: Arrangement::default() };
    workspace.document = Some(Document::new("builtin:quads".to_owned(), scene, seen));
    workspace.scene_number = 1;
    let show = |ui: &mut egui::Ui, workspace: &mut Workspace| panels::show(ui, workspace);
    let mut window = Harness::builder().with_size(egui::vec2(1280.0, 2600.0)).build_ui_state(show, workspace);
    super::style::set_up(&window.ctx);
    window.run();
    for (stage, title) in stages::STAGES {
        if !matches!(*stage, "capture" | "opacity") {
            window.get_by_label(title).click();
            window.run();
        }
    }
    // What has no effect is put away in each of them.
    let count = window.query_all_by_label_contains(stages::PUT_AWAY).count();
    assert!(count >= 2, "{count}");
    for i in 0..count {
        window.get_all_by_label_contains(stages::PUT_AWAY).nth(i).unwrap().click();
        window.run();
    }
    window
}

fn settings(window: &Window) -> Settings {
    window.state().document.as_ref().unwrap().seen.settings.clone()
}

/// The widget of a setting by its role and title. Several settings may have one title: they stand in the order in which they
/// are declared.
fn widget<'a>(window: &'a Window, declaration: &Declaration, role: Role) -> Node<'a> {
    let title = stages::title_of(&declaration.path);
    let is_like = |d: &&Declaration| {
        let kind = std::mem::discriminant(&d.range);
        kind == std::mem::discriminant(&declaration.range) && stages::title_of(&d.path) == title
    };
    let all = Settings::declarations();
    let number = all.iter().filter(is_like).position(|d| d.path == declaration.path).unwrap();
    let called = |node: &Node<'_>| node.accesskit_node().label().as_deref() == Some(title.as_str());
    let found = window.query_all_by_role(role).filter(called).nth(number);
    found.unwrap_or_else(|| panic!("{}: no {role:?} called '{title}'", declaration.path))
}

/// Sets a setting to what a text says, by its widget.
fn set(window: &mut Window, declaration: &Declaration, text: &str) {
    let choose = |window: &mut Window| {
        widget(window, declaration, Role::ComboBox).click();
        window.run();
        // What is open lies over everything else.
        window.get_all_by_label(&text.replace('_', " ")).last().unwrap().click();
    };
    match declaration.range {
        Range::Integer(..) | Range::Real(..) => {
            widget(window, declaration, Role::Slider);
            widget(window, declaration, Role::SpinButton).set_value_accesskit(text.parse().unwrap());
        }
        Range::Switch => widget(window, declaration, Role::CheckBox).click(),
        Range::Choice(_) => choose(window),
        Range::Text
            if window.query_by_role_and_label(Role::ComboBox, &stages::title_of(&declaration.path)).is_some() =>
        {
            choose(window);
        }
        Range::Text | Range::Color { .. } => {
            widget(window, declaration, Role::TextInput).focus();
            window.run();
            window.key_press_modifiers(Modifiers::COMMAND, Key::A);
            widget(window, declaration, Role::TextInput).type_text(text);
            window.run();
            window.key_press(Key::Enter);
        }
    }
    window.run();
}

#[test]
fn every_setting_has_a_widget_and_survives_the_session_file() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = window();
    window.state_mut().viewport.size = [64, 48];
    for declaration in Settings::declarations() {
        let text = declaration.another();
        let mut expected = Settings::default();
        expected.set(&declaration.path, &text).unwrap();
        assert_ne!(expected, Settings::default(), "{}", declaration.path);
        set(&mut window, &declaration, &text);
        assert_eq!(settings(&window), expected, "{} = {text} by its widget", declaration.path);
        // As the window saves it.
        let written = window.state().session(folder.path()).unwrap();
        let scene = &window.state().document.as_ref().unwrap().scene;
        let read = Session::from_toml(&written).and_then(|s| s.resolve(scene)).unwrap();
        assert_eq!(read.settings, expected, "{}:\n{written}", declaration.path);
        window.state_mut().document.as_mut().unwrap().seen.settings = Settings::default();
        window.run();
    }
}
