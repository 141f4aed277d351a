//! What is said, on the picture: what is being opened, errors, notices, and what to do when there is nothing to see.

use std::path::Path;

use egui::{Align2, Area, Color32, Frame, Id, Rect, RichText, Ui, vec2};

use crate::app::dialogs::Choice;
use crate::app::workspace::{Ask, Gravity, Workspace};

/// Everything that lies on the picture.
pub fn show(ui: &mut Ui, picture: Rect, workspace: &mut Workspace) {
    if let Some(loading) = workspace.loading.clone() {
        over(ui, "loading", Align2::CENTER_CENTER, picture, |ui| {
            ui.set_width(280.0);
            ui.label(RichText::new(format!("Opening {}", loading.file)).strong());
            // The bar is of the phase: how long those take that follow nobody knows.
            let (doing, share) = loading.phase.map_or(("beginning", 0.0), |(phase, share)| (phase.name(), share));
            ui.add(egui::ProgressBar::new(share).desired_height(8.0));
            ui.weak(format!("{doing}, {:.0} %", 100.0 * share));
            if ui.button("Cancel").clicked() {
                workspace.asks.push(Ask::CancelLoading);
            }
        });
    } else if workspace.document.is_none() {
        over(ui, "welcome", Align2::CENTER_CENTER, picture, |ui| {
            ui.set_width(300.0);
            ui.heading("Drop a model here");
            ui.weak("glTF, OBJ, STL or PLY; or a session");
            ui.horizontal(|ui| {
                if ui.button("Open…").clicked() {
                    workspace.asks.push(Ask::Choose(Choice::Open));
                }
                if ui.button("Try the gearbox").clicked() {
                    workspace.asks.push(Ask::Open("builtin:gearbox".to_owned()));
                }
            });
            if !workspace.preferences.recent.is_empty() {
                ui.add_space(6.0);
                ui.weak("Recent");
                for file in workspace.preferences.recent.iter().take(5) {
                    let name = file.rsplit(['/', '\\']).next().unwrap_or(file);
                    if ui.link(name).on_hover_text(file).clicked() {
                        workspace.asks.push(Ask::Open(file.clone()));
                    }
                }
            }
        });
    }
    said(ui, picture, workspace);
}

/// A line to type a path into, where the desktop has no dialog for it.
pub fn prompt(ui: &mut Ui, workspace: &mut Workspace) {
    let Some(prompt) = &mut workspace.layout.prompt else {
        return;
    };
    let mut open = true;
    let mut done = false;
    egui::Window::new(prompt.choice.title())
        .anchor(Align2::CENTER_CENTER, vec2(0.0, 0.0))
        .open(&mut open)
        .resizable(false)
        .collapsible(false)
        .show(ui.ctx(), |ui| {
            let line = egui::TextEdit::singleline(&mut prompt.path).desired_width(420.0).hint_text("Path of a file");
            let line = ui.add(line);
            line.widget_info(|| egui::WidgetInfo::labeled(egui::Role::TextInput, true, "Path"));
            let entered = line.lost_focus() && ui.input(|i| i.key_pressed(egui::Key::Enter));
            if !line.has_focus() && !entered {
                line.request_focus();
            }
            let replaces = prompt.replaced.as_deref() == Some(prompt.path.trim());
            if replaces {
                let color = ui.visuals().warn_fg_color;
                ui.colored_label(color, "There is a file of that name. It would be replaced.");
            }
            let word = match prompt.choice {
                _ if replaces => "Replace",
                Choice::Open => "Open",
                Choice::ImportTransfer => "Import",
                Choice::ExportTransfer | Choice::Export => "Export",
                Choice::SaveSession | Choice::SavePicture => "Save",
            };
            done = ui.button(word).clicked() || entered;
        });
    if ui.input(|i| i.key_pressed(egui::Key::Escape)) {
        open = false;
    }
    // The desktop's own dialog asks as well.
    let path = prompt.path.trim();
    if done && prompt.choice.writes() && prompt.replaced.as_deref() != Some(path) && Path::new(path).is_file() {
        prompt.replaced = Some(path.to_owned());
        return;
    }
    if done {
        workspace.asks.push(Ask::Use { choice: prompt.choice, path: prompt.path.clone(), typed: true });
    }
    if done || !open {
        workspace.layout.prompt = None;
    }
}

fn said(ui: &mut Ui, picture: Rect, workspace: &mut Workspace) {
    if workspace.messages.is_empty() && workspace.refusal.is_none() {
        return;
    }
    over(ui, "messages", Align2::LEFT_BOTTOM, picture, |ui| {
        ui.set_max_width((picture.width() - 40.0).clamp(120.0, 520.0));
        if let Some(refusal) = &workspace.refusal {
            ui.colored_label(color(ui, Gravity::Error), format!("No exact picture: {refusal}"));
        }
        let mut done = None;
        for (i, message) in workspace.messages.iter().enumerate().rev().take(4) {
            ui.horizontal_top(|ui| {
                let dismiss = ui.small_button("×").on_hover_text("Dismiss");
                dismiss.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, "Dismiss"));
                if dismiss.clicked() {
                    done = Some(i);
                }
                let lines: Vec<&str> = message.text.lines().collect();
                let text = RichText::new(*lines.first().unwrap_or(&"")).color(color(ui, message.gravity));
                match lines.len() {
                    0 | 1 => {
                        ui.add(egui::Label::new(text).wrap());
                    }
                    n => {
                        // A file may have much to say; it is there when asked for.
                        let title = format!("{n} notices about this file");
                        egui::CollapsingHeader::new(title).id_salt(("message", i)).show(ui, |ui| {
                            for line in lines {
                                ui.add(egui::Label::new(RichText::new(line).small()).wrap());
                            }
                        });
                    }
                }
            });
        }
        if workspace.messages.len() > 1 && ui.small_button("Dismiss all").clicked() {
            workspace.messages.clear();
        } else if let Some(i) = done {
            workspace.messages.remove(i);
        }
    });
}

fn color(ui: &Ui, gravity: Gravity) -> Color32 {
    match gravity {
        Gravity::Error => ui.visuals().error_fg_color,
        Gravity::Notice | Gravity::Note => ui.visuals().text_color(),
    }
}

/// A small plate on the picture.
pub(in crate::app) fn over(ui: &mut Ui, id: &str, place: Align2, picture: Rect, contents: impl FnOnce(&mut Ui)) {
    let offset = match place {
        Align2::LEFT_BOTTOM => vec2(10.0, -10.0),
        Align2::RIGHT_BOTTOM => vec2(-10.0, -10.0),
        Align2::CENTER_TOP => vec2(0.0, 10.0),
        Align2::LEFT_TOP => vec2(10.0, 10.0),
        _ => vec2(0.0, 0.0),
    };
    let at = place.pos_in_rect(&picture) + offset;
    Area::new(Id::unique(id)).pivot(place).fixed_pos(at).constrain_to(picture).show(ui.ctx(), |ui| {
        Frame::popup(ui.style()).show(ui, contents);
    });
}
