//! The menus.

use egui::{Button, Label, MenuBar, RichText, ScrollArea, Ui};

use crate::app::camera::{self, Habits};
use crate::app::command_line;
use crate::app::config::Theme;
use crate::app::dialogs::Choice;
use crate::app::loader::HARD_CASE;
use crate::app::panels::{export, models, selection, style, views};
use crate::app::workspace::{Ask, Gravity, Workspace};
use crate::scene::{Presence, builtin};
use crate::settings::looks;
use crate::tradeoff::hard_cases;

/// Sizes of the interface that are offered.
const SCALES: [f32; 6] = [0.8, 0.9, 1.0, 1.25, 1.5, 2.0];

/// Height of the longest menu, about, points.
const LONGEST: f32 = 540.0;

/// Whether a menu may be higher than the window, or than what a large interface leaves of it. Then it is scrolled.
fn is_low(ui: &Ui) -> bool {
    ui.ctx().content_rect().height() < LONGEST
}

/// A menu in a menu. Egui opens none inside of what is scrolled: there, it is part of the menu.
fn submenu(ui: &mut Ui, title: &str, contents: impl FnOnce(&mut Ui)) {
    if is_low(ui) {
        ui.separator();
        ui.weak(title);
        contents(ui);
    } else {
        ui.menu_button(title, contents);
    }
}

/// The bar with all menus, and what file is open.
pub fn show(ui: &mut Ui, workspace: &mut Workspace) {
    MenuBar::new().ui(ui, |ui| {
        type Contents = fn(&mut Ui, &mut Workspace);
        let menus: [(&str, Contents); 6] =
            [("File", file), ("Edit", edit), ("View", view), ("Parts", parts), ("Look", look), ("Help", help)];
        for (name, contents) in menus {
            ui.menu_button(name, |ui| {
                if is_low(ui) {
                    let most = (ui.ctx().content_rect().height() - 60.0).max(80.0);
                    ScrollArea::vertical().max_height(most).show(ui, |ui| contents(ui, workspace));
                } else {
                    contents(ui, workspace);
                }
            });
        }
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            if let Some(document) = &workspace.document {
                let name = document.file.rsplit(['/', '\\']).next().unwrap_or(&document.file);
                let name = Label::new(RichText::new(name).weak()).truncate();
                ui.add(name).on_hover_text(&document.file);
            }
        });
    });
}

fn item(ui: &mut Ui, text: &str, keys: &str) -> bool {
    ui.add(Button::new(text).shortcut_text(keys)).clicked()
}

fn help(ui: &mut Ui, workspace: &mut Workspace) {
    if item(ui, "Keyboard and mouse", "F1") {
        workspace.layout.shortcuts = true;
    }
}

/// Makes the interface one size larger or smaller, or gives it the usual one.
pub fn resize(workspace: &mut Workspace, by: i32) {
    let now = SCALES.iter().position(|s| *s >= workspace.preferences.scale).unwrap_or(SCALES.len() - 1);
    workspace.preferences.scale = match by {
        0 => 1.0,
        by => SCALES[now.saturating_add_signed(by as isize).min(SCALES.len() - 1)],
    };
    workspace.asks.push(Ask::Restyle);
    workspace.asks.push(Ask::Remember);
}

fn file(ui: &mut Ui, workspace: &mut Workspace) {
    if item(ui, "Open…", "Ctrl+O") {
        workspace.asks.push(Ask::Choose(Choice::Open));
    }
    let recent = workspace.preferences.recent.clone();
    ui.add_enabled_ui(!recent.is_empty(), |ui| {
        submenu(ui, "Open recent", |ui| {
            for file in &recent {
                let name = file.rsplit(['/', '\\']).next().unwrap_or(file);
                if ui.button(name).on_hover_text(file).clicked() {
                    workspace.asks.push(Ask::Open(file.clone()));
                }
            }
        });
    });
    submenu(ui, "Built-in models", |ui| {
        egui::ScrollArea::vertical().max_height(420.0).show(ui, |ui| {
            for scene in builtin::names() {
                if ui.button(scene.name).on_hover_text(scene.description).clicked() {
                    workspace.asks.push(Ask::Open(format!("builtin:{}", scene.name)));
                }
            }
        });
    });
    submenu(ui, "Hard cases", |ui| {
        egui::ScrollArea::vertical().max_height(420.0).show(ui, |ui| {
            for (_, case) in hard_cases::all() {
                if ui.button(case.name).on_hover_text(case.why).clicked() {
                    workspace.asks.push(Ask::Open(format!("{HARD_CASE}{}", case.name)));
                }
            }
        });
    });
    ui.separator();
    let open = workspace.document.is_some();
    ui.add_enabled_ui(open, |ui| {
        if item(ui, "Save session…", "Ctrl+S") {
            workspace.asks.push(Ask::Choose(Choice::SaveSession));
        }
        if item(ui, "Save picture…", "Ctrl+P") {
            workspace.asks.push(Ask::Choose(Choice::SavePicture));
        }
        if item(ui, "Write pictures…", "Ctrl+Shift+P") {
            export::ask(workspace);
        }
        if item(ui, "Copy as command line", "Ctrl+Shift+C") {
            copy_command_line(workspace);
        }
    });
    ui.separator();
    if item(ui, "Quit", "Ctrl+Q") {
        workspace.asks.push(Ask::Quit);
    }
}

/// Puts the command that renders what is seen on the clipboard.
pub fn copy_command_line(workspace: &mut Workspace) {
    let Some(document) = &workspace.document else {
        return;
    };
    match command_line::of(document, &workspace.configuration, workspace.viewport.size) {
        Ok(line) => {
            workspace.asks.push(Ask::Copy(line));
            workspace.say(Gravity::Note, "The command line is on the clipboard.");
        }
        Err(reason) => workspace.say(Gravity::Error, reason),
    }
}

fn edit(ui: &mut Ui, workspace: &mut Workspace) {
    let (undo, redo) = workspace.document.as_ref().map_or((false, false), |d| d.ways());
    if ui.add_enabled(undo, Button::new("Undo").shortcut_text("Ctrl+Z")).clicked() {
        workspace.undo();
    }
    if ui.add_enabled(redo, Button::new("Redo").shortcut_text("Ctrl+Shift+Z")).clicked() {
        workspace.redo();
    }
    ui.separator();
    ui.add_enabled_ui(workspace.document.is_some(), |ui| {
        if ui.button("Reset all settings").clicked()
            && let Some(document) = &mut workspace.document
        {
            document.seen.settings = Default::default();
        }
    });
}

/// What can be done with parts.
fn parts(ui: &mut Ui, workspace: &mut Workspace) {
    let some = workspace.document.as_ref().is_some_and(|d| !d.seen.arrangement.selected.is_empty());
    ui.add_enabled_ui(some, |ui| {
        if item(ui, "Isolate selection", "I") {
            selection::isolate(workspace);
        }
        if item(ui, "Ghost selection", "G") {
            selection::set_presence(workspace, Presence::Ghosted);
        }
        if item(ui, "Hide selection", "H") {
            selection::set_presence(workspace, Presence::Hidden);
        }
    });
    ui.add_enabled_ui(workspace.document.is_some(), |ui| {
        if item(ui, "Show every part", "Shift+H") {
            selection::show_all(workspace);
        }
        ui.separator();
        if ui.add(Button::selectable(workspace.measure.on, "Measure").shortcut_text("M")).clicked() {
            workspace.measure.on = !workspace.measure.on;
        }
    });
}

/// Presets: looks, then transfer functions.
fn look(ui: &mut Ui, workspace: &mut Workspace) {
    let Some(document) = &mut workspace.document else {
        ui.weak("No model");
        return;
    };
    let mut failed = None;
    for (i, (name, description)) in looks::presets().enumerate() {
        if i == looks::LOOKS.len() {
            ui.separator();
        }
        if ui.button(name).on_hover_text(description).clicked()
            && let Err(e) = looks::apply(&mut document.seen.settings, name)
        {
            failed = Some(e.to_string());
        }
    }
    if let Some(reason) = failed {
        workspace.say(Gravity::Error, reason);
    }
}

fn view(ui: &mut Ui, workspace: &mut Workspace) {
    ui.add_enabled_ui(workspace.document.is_some(), |ui| {
        for (name, text, keys) in
            [("front", "Front", "1"), ("right", "Right", "3"), ("top", "Top", "7"), ("isometric", "Isometric", "9")]
        {
            if item(ui, text, keys) {
                workspace.look(|f, s, c| camera::named(c, &s.bounds(), f.aspect(), name, false));
            }
        }
        if item(ui, "Perspective or parallel", "5") {
            workspace.look(|_, _, c| Some(camera::other_projection(c)));
        }
        if item(ui, "Show everything", "Home") {
            selection::frame_all(workspace);
        }
        if item(ui, "Show the selection", "F") {
            selection::frame_selected(workspace);
        }
        if item(ui, "Middle where it turns", "C") {
            selection::centre_pivot(workspace);
        }
        submenu(ui, "Saved views", |ui| views::menu(ui, workspace));
        if item(ui, "Save this view…", "Ctrl+D") {
            views::ask(workspace);
        }
    });
    ui.separator();
    ui.add_enabled_ui(workspace.document.is_some(), |ui| {
        if ui.add(Button::selectable(workspace.models.is_some(), "Compare opacity models")).clicked() {
            models::toggle(workspace);
        }
    });
    let before = workspace.preferences.clone();
    let preferences = &mut workspace.preferences;
    ui.checkbox(&mut preferences.parts, "Parts");
    let mut stages = preferences.stages && !preferences.accuracy;
    if ui.checkbox(&mut stages, "Stages").changed() {
        (preferences.stages, preferences.accuracy) = (stages, false);
    }
    if ui.add(Button::selectable(preferences.accuracy, "Accuracy").shortcut_text("A")).clicked() {
        preferences.accuracy = !preferences.accuracy;
    }
    ui.checkbox(&mut preferences.editors, "Transfer functions");
    ui.checkbox(&mut preferences.hover, "Parts under the cursor");
    submenu(ui, "Theme", |ui| {
        for (theme, name) in [(Theme::System, "As the desktop"), (Theme::Dark, "Dark"), (Theme::Light, "Light")] {
            ui.radio_value(&mut preferences.theme, theme, name);
        }
    });
    submenu(ui, "Size of the interface", |ui| {
        for scale in SCALES {
            ui.radio_value(&mut preferences.scale, scale, format!("{:.0} %", scale * 100.0));
        }
    });
    submenu(ui, "Mouse as in", |ui| {
        for (habits, name) in Habits::ALL {
            ui.radio_value(&mut preferences.mouse, habits, name);
        }
    });
    if *preferences != before {
        style::apply(ui.ctx(), preferences);
        workspace.asks.push(Ask::Remember);
    }
}
