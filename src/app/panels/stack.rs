//! The parts under the cursor in depth order: beside the cursor while it rests, and as a list to choose from.

use egui::{Align2, Area, Button, Frame, Id, Order, Pos2, Rect, RichText, Ui, vec2};

use super::selection;
use crate::app::document::Document;
use crate::app::pictures::Picked;
use crate::app::workspace::Workspace;
use crate::scene::Presence;

/// Lines beside the cursor.
const MOST_LINES: usize = 10;

/// A run of layers of one part, for show.
struct Line {
    part: u32,
    /// The first of them.
    layer: usize,
    count: usize,
    opacity: f32,
}

/// Layers next to each other that are of one part, as one line.
fn lines(picked: &Picked) -> Vec<Line> {
    let mut lines: Vec<Line> = Vec::new();
    for (layer, found) in picked.layers.iter().enumerate() {
        match lines.last_mut() {
            Some(line) if line.part == found.part => {
                line.count += 1;
                line.opacity = line.opacity.max(found.opacity);
            }
            _ => lines.push(Line { part: found.part, layer, count: 1, opacity: found.opacity }),
        }
    }
    lines
}

fn text_of(line: &Line, document: &Document) -> String {
    let name = document.scene.parts.get(line.part as usize).map_or("?", |p| p.name.as_str());
    let name = if name.chars().count() > 40 { name.chars().take(39).chain(['…']).collect() } else { name.to_owned() };
    if line.count > 1 { format!("{name}  ×{}", line.count) } else { name }
}

/// Where a pixel of the picture is on the screen.
fn place(picture: Rect, picked: &Picked, points_per_pixel: f32) -> Pos2 {
    picture.min + vec2(picked.pixel[0] as f32, picked.pixel[1] as f32) * points_per_pixel
}

/// Both.
pub fn show(ui: &Ui, picture: Rect, workspace: &mut Workspace) {
    if workspace.layout.stack.is_some() {
        list(ui, picture, workspace);
    } else {
        hover(ui, picture, workspace);
    }
}

/// What lies under the cursor, while it rests there. The cursor goes through it.
fn hover(ui: &Ui, picture: Rect, workspace: &Workspace) {
    let (Some(picked), Some(document)) = (&workspace.hover, &workspace.document) else {
        return;
    };
    if picked.layers.is_empty() || workspace.layout.prompt.is_some() {
        return;
    }
    let at = place(picture, picked, ui.ctx().pixels_per_point().recip()) + vec2(16.0, 14.0);
    let all = lines(picked);
    let area = Area::new(Id::unique("hover")).order(Order::Tooltip).interactable(false).fixed_pos(at);
    area.constrain_to(picture).show(ui.ctx(), |ui| {
        Frame::popup(ui.style()).inner_margin(5.0).show(ui, |ui| {
            ui.spacing_mut().item_spacing.y = 1.0;
            let selected = &document.seen.arrangement.selected;
            for line in all.iter().take(MOST_LINES) {
                let text = RichText::new(text_of(line, document)).small();
                let text = if selected.contains(&line.part) { text.strong() } else { text };
                ui.add(egui::Label::new(text).extend());
            }
            if all.len() > MOST_LINES {
                ui.weak(RichText::new(format!("{} more", all.len() - MOST_LINES)).small());
            }
        });
    });
}

/// The list that a click with the right button opens.
fn list(ui: &Ui, picture: Rect, workspace: &mut Workspace) {
    let (Some(picked), Some(document)) = (&workspace.layout.stack, &workspace.document) else {
        return;
    };
    let at = place(picture, picked, ui.ctx().pixels_per_point().recip());
    let all = lines(picked);
    let mut chosen = None;
    let mut act: Option<fn(&mut Workspace)> = None;
    let shown = Area::new(Id::unique("stack"))
        .order(Order::Foreground)
        .pivot(Align2::LEFT_TOP)
        .fixed_pos(at)
        .constrain_to(picture)
        .accessible_name("Parts under the cursor")
        .show(ui.ctx(), |ui| {
            Frame::menu(ui.style()).show(ui, |ui| {
                ui.set_max_width(280.0);
                ui.weak(RichText::new("Nearest first").small());
                egui::ScrollArea::vertical().max_height(260.0).show(ui, |ui| {
                    for line in &all {
                        let selected = document.seen.arrangement.selected.contains(&line.part);
                        let button = ui.add(Button::selectable(selected, text_of(line, document)).truncate());
                        let help = format!("Opacity {:.2}; with Ctrl, one more", line.opacity);
                        if button.on_hover_text(help).clicked() {
                            chosen = Some(line.layer);
                        }
                    }
                });
                if !document.seen.arrangement.selected.is_empty() {
                    ui.separator();
                    for (text, what) in [
                        ("Isolate the selection", selection::isolate as fn(&mut Workspace)),
                        ("Frame the selection", selection::frame_selected),
                        ("Hide the selection", |w| selection::set_presence(w, Presence::Hidden)),
                    ] {
                        if ui.button(text).clicked() {
                            act = Some(what);
                        }
                    }
                }
            });
        });
    if let Some(layer) = chosen {
        let more = ui.input(|i| i.modifiers.command);
        workspace.choose_from_stack(layer, more);
    } else if let Some(act) = act {
        workspace.layout.stack = None;
        act(workspace);
    } else if shown.response.clicked_elsewhere() {
        workspace.layout.stack = None;
    }
}
