//! What keys and mouse do.

use egui::{Grid, Ui, Window};

use crate::app::camera::Habits;
use crate::app::workspace::Workspace;

/// Keys, and what they do.
pub const KEYS: &[(&str, &str)] = &[
    ("Ctrl+O", "Open a file; or drop one on the window"),
    ("Ctrl+Z, Ctrl+Shift+Z or Ctrl+Y", "Undo, redo"),
    ("Ctrl++, Ctrl+-, Ctrl+0", "Larger or smaller interface, usual size"),
    ("1, 3, 7, 9", "Front, right, top, isometric"),
    ("Ctrl+1, 3, 7, 9", "The same from the other side"),
    ("5", "Perspective or parallel"),
    ("Home", "Show everything"),
    ("F", "Show the selection"),
    ("C", "Bring the point that it turns about into the middle"),
    ("Ctrl+D", "Save this view under a name"),
    ("V", "Next saved view"),
    ("I", "Isolate the selection"),
    ("G, H", "Ghost, hide the selection"),
    ("Shift+H", "Show every part"),
    ("M", "Measure between two clicks"),
    ("A", "What is wrong in the picture: the accuracy panel instead of the stages"),
    ("X", "Handles of section planes on the picture: on, off"),
    ("L", "Parts under the cursor: on, off"),
    ("Ctrl+S", "Save the session"),
    ("Ctrl+P", "Save the picture"),
    ("Ctrl+Shift+P", "Write pictures: any size, turntable"),
    ("Ctrl+Shift+C", "Copy as command line"),
    ("F1", "This list"),
    ("Esc", "Give up a drag; dismiss messages; end measuring; hide handles; select nothing"),
    ("Ctrl+Q", "Quit"),
];

/// What the pointer and keys do on handles: of section planes on the picture, and of points in the editors.
pub const HANDLES: &[(&str, &str)] = &[
    ("Arrow of a section plane", "Drag: pull the plane; click: choose it"),
    ("Ring of a section plane", "Drag: tilt it; Shift in steps of 15°"),
    ("Double-click in an editor", "Add a point"),
    ("Drag a point", "Move it; Shift along one axis"),
    ("Drag on empty ground", "Select points; Ctrl scales the curve"),
    ("Delete, Insert, Ctrl+A", "Delete, add, select points"),
    ("Tab, arrows", "Walk over handles, move one; Shift coarse"),
    ("Ctrl with any drag or arrow", "Fine"),
];

fn mouse(habits: Habits) -> [(&'static str, &'static str); 6] {
    let (turn, pan, zoom) = match habits {
        Habits::F3d => ("Left", "Middle or Shift+left", "Right"),
        Habits::Blender => ("Middle or Alt+left", "Shift+middle", "Ctrl+middle"),
        Habits::Cad => ("Middle or right", "Ctrl+middle", "Shift+middle"),
    };
    [
        (turn, "Turn"),
        (pan, "Move"),
        (zoom, "Zoom"),
        ("Wheel", "Zoom to the cursor"),
        ("Click", "Select a part and turn about it; again for what is behind"),
        ("Right click", "Choose among the parts under the cursor"),
    ]
}

fn list(ui: &mut Ui, name: &str, lines: &[(&str, &str)]) {
    Grid::new(name).num_columns(2).spacing([16.0, 4.0]).show(ui, |ui| {
        for (keys, what) in lines {
            ui.monospace(*keys);
            ui.label(*what);
            ui.end_row();
        }
    });
}

/// The list, if it is asked for.
pub fn show(ui: &mut Ui, workspace: &mut Workspace) {
    if !workspace.layout.shortcuts {
        return;
    }
    let mut open = true;
    let middle = ui.ctx().content_rect().center();
    Window::new("Keyboard and mouse")
        .pivot(egui::Align2::CENTER_CENTER)
        .default_pos(middle)
        .open(&mut open)
        .resizable(false)
        .collapsible(false)
        .show(ui.ctx(), |ui| {
            let mouse = mouse(workspace.preferences.mouse);
            // Side by side, or a small window does not hold them.
            let room = ui.ctx().content_rect().size() - egui::vec2(30.0, 70.0);
            let area = egui::ScrollArea::both().max_width(room.x).max_height(room.y);
            area.show(ui, |ui| {
                ui.horizontal_top(|ui| {
                    list(ui, "keys", KEYS);
                    ui.separator();
                    ui.vertical(|ui| {
                        list(ui, "mouse", &mouse);
                        ui.separator();
                        list(ui, "handles", HANDLES);
                    });
                });
            });
        });
    workspace.layout.shortcuts = open;
}
