//! Views that are saved under a name, for each file.

use egui::{Key, TextEdit, Ui, Window};

use crate::app::config::SavedView;
use crate::app::workspace::{Ask, Gravity, Workspace};
use crate::session::{camera_in_file, camera_in_scene};

/// Longest name, characters.
const LONGEST_NAME: usize = 80;

/// Asks for a name.
pub fn ask(workspace: &mut Workspace) {
    if let Some(document) = &workspace.document {
        let count = workspace.preferences.views_of(&document.file).len();
        workspace.layout.naming = Some(format!("View {}", count + 1));
    }
}

/// The views in a menu.
pub fn menu(ui: &mut Ui, workspace: &mut Workspace) {
    let Some(document) = &workspace.document else {
        return;
    };
    let file = document.file.clone();
    let views = workspace.preferences.views_of(&file).to_vec();
    if views.is_empty() {
        ui.weak("None of this file");
    }
    for view in views {
        ui.horizontal(|ui| {
            if ui.button(&view.name).clicked() {
                recall(workspace, &view);
            }
            let forget = ui.small_button("×").on_hover_text("Forget it");
            let label = format!("Forget {}", view.name);
            forget.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, label.clone()));
            if forget.clicked() {
                workspace.preferences.forget_view(&file, &view.name);
                workspace.asks.push(Ask::Remember);
            }
        });
    }
}

fn recall(workspace: &mut Workspace, view: &SavedView) {
    workspace.look(|_, scene, _| Some(camera_in_scene(&view.camera, scene)));
    workspace.pivot = None;
}

/// Goes to the view after the one that is seen, or to the first.
pub fn next(workspace: &mut Workspace) {
    let Some(document) = &workspace.document else {
        return;
    };
    let views = workspace.preferences.views_of(&document.file);
    let is_seen = |v: &SavedView| camera_in_scene(&v.camera, &document.scene) == document.seen.camera;
    let after = views.iter().position(is_seen).map_or(0, |i| i + 1);
    match views.get(after).or(views.first()).cloned() {
        Some(view) => recall(workspace, &view),
        None => workspace.say(Gravity::Note, "No view of this file is saved: Ctrl+D saves one."),
    }
}

/// The question for a name.
pub fn show(ui: &Ui, workspace: &mut Workspace) {
    let Some(name) = &mut workspace.layout.naming else {
        return;
    };
    let (mut open, mut done) = (true, false);
    Window::new("Save this view")
        .anchor(egui::Align2::CENTER_CENTER, egui::Vec2::ZERO)
        .open(&mut open)
        .resizable(false)
        .collapsible(false)
        .show(ui.ctx(), |ui| {
            let line = ui.add(TextEdit::singleline(name).desired_width(220.0).char_limit(LONGEST_NAME));
            line.widget_info(|| egui::WidgetInfo::labeled(egui::Role::TextInput, true, "Name of the view"));
            let entered = line.lost_focus() && ui.input(|i| i.key_pressed(Key::Enter));
            if !line.has_focus() && !entered {
                line.request_focus();
            }
            done = ui.button("Save view").clicked() || entered;
        });
    let name = name.trim().to_owned();
    if ui.input(|i| i.key_pressed(Key::Escape)) || !open {
        workspace.layout.naming = None;
    } else if done && !name.is_empty() {
        workspace.layout.naming = None;
        if let Some(document) = &workspace.document {
            let camera = camera_in_file(&document.seen.camera, &document.scene);
            workspace.preferences.save_view(&document.file, SavedView { name, camera });
            workspace.asks.push(Ask::Remember);
        }
    }
}
