//! What is written as pictures: of which size, over what, one or a turntable; and how far that is.

use egui::{DragValue, Rect, Ui, Window};

use super::{messages, selection};
use crate::app::dialogs::Choice;
use crate::app::exports::{Form, LONGEST_SIDE, MOST_FRAMES};
use crate::app::workspace::{Ask, Workspace};

/// Opens the panel with the size of the viewport.
pub fn ask(workspace: &mut Workspace) {
    if workspace.document.is_some() {
        let size = workspace.viewport.size.map(|n| n.clamp(1, LONGEST_SIDE));
        workspace.layout.export = Some(Form { size, background: true, turntable: false, frames: 72 });
    }
}

/// The panel, and the bar while pictures are written.
pub fn show(ui: &mut Ui, picture: Rect, workspace: &mut Workspace) {
    if let Some((done, of)) = workspace.exporting {
        messages::over(ui, "exporting", egui::Align2::CENTER_TOP, picture, |ui| {
            ui.set_width(240.0);
            ui.label(format!("Writing pictures: {done} of {of}"));
            ui.add(egui::ProgressBar::new(done as f32 / of.max(1) as f32).desired_height(8.0));
            if ui.button("Cancel").clicked() {
                workspace.asks.push(Ask::CancelExport);
            }
        });
    }
    let viewport = workspace.viewport.size;
    let Some(form) = &mut workspace.layout.export else {
        return;
    };
    let (mut open, mut write) = (true, false);
    Window::new("Write pictures")
        .default_pos(picture.center() - egui::vec2(130.0, 90.0))
        .default_width(216.0)
        .open(&mut open)
        .resizable(false)
        .collapsible(false)
        .show(ui.ctx(), |ui| {
            ui.horizontal(|ui| {
                ui.label("Size");
                selection::size_fields(ui, &mut form.size, LONGEST_SIDE);
            });
            ui.horizontal(|ui| {
                let sizes =
                    [("As seen", viewport.map(|n| n.max(1))), ("1920×1080", [1920, 1080]), ("3840×2160", [3840, 2160])];
                for (text, size) in sizes {
                    if ui.small_button(text).clicked() {
                        form.size = size;
                    }
                }
            });
            ui.checkbox(&mut form.background, "With background");
            ui.checkbox(&mut form.turntable, "Turntable").on_hover_text(
                "The frames of one full turn about the vertical line through the middle of the view, as numbered files",
            );
            ui.add_enabled_ui(form.turntable, |ui| {
                ui.horizontal(|ui| {
                    ui.label("Frames");
                    let field = ui.add(DragValue::new(&mut form.frames).range(2..=MOST_FRAMES));
                    field.widget_info(|| egui::WidgetInfo::labeled(egui::Role::SpinButton, true, "Frames"));
                });
            });
            write = ui.button("Write…").clicked();
        });
    if write {
        workspace.asks.push(Ask::Choose(Choice::Export));
    }
    if !open {
        workspace.layout.export = None;
    }
}
