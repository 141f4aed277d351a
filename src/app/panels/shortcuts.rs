//! What keys and mouse do.

use egui::{Grid, Ui, Window};

use crate::app::camera::Habits;
use crate::app::workspace::Workspace;

/// Keys, and what they do.
pub const KEYS: &[(&str, &str)] = &[
    ("Ctrl+O", "Open a file; or drop one on the window"),
    ("Ctrl+Z, Ctrl+Shift+Z", "Undo, redo"),
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
    ("L", "Parts under the cursor: on, off"),
    ("Ctrl+S", "Save the session"),
    ("Ctrl+P", "Save the picture"),
    ("Ctrl+Shift+P", "Write pictures: any size, turntable"),
    ("Ctrl+Shift+C", "Copy as command line"),
    ("F1", "This list"),
    ("Esc", "Dismiss messages; end measuring; select nothing"),
    ("Ctrl+Q", "Quit"),
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
            Grid::new("shortcuts").num_columns(2).spacing([16.0, 4.0]).show(ui, |ui| {
                for (keys, what) in KEYS.iter().copied().chain(mouse(workspace.preferences.mouse)) {
                    ui.monospace(keys);
                    ui.label(what);
                    ui.end_row();
                }
            });
        });
    workspace.layout.shortcuts = open;
}
