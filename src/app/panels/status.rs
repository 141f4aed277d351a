//! The line at the bottom: what kind of picture is shown, what is in it, how long it took, on what.

use egui::{Color32, Label, RichText, Ui};

use super::room::Room;
use crate::app::pictures::Kind;
use crate::app::workspace::Workspace;
use crate::plan::Capture;
use crate::render::FrameReport;

/// The status line.
pub fn show(ui: &mut Ui, workspace: &Workspace, room: &Room) {
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 14.0;
        // First, because the rest may not fit then either.
        let out = room.left_out(&workspace.preferences);
        if !out.is_empty() {
            let help = "The picture keeps some of a small window. They are back when it is larger.";
            ui.label(format!("no room: {}", out.join(", "))).on_hover_text(help);
        }
        let Some(screen) = &workspace.screen else {
            ui.weak(if workspace.document.is_some() { "starting the renderer" } else { "no model" });
            right(ui, workspace);
            return;
        };
        let [width, height] = screen.size;
        let exact = workspace.is_exact();
        let (word, color, help) = if exact {
            let help = "What `pellucid render` draws, bit for bit.";
            ("exact", Color32::from_rgb(0x4c, 0xa6, 0x8a), help)
        } else {
            let help = "Drawn to be in time: fewer pixels, on a software rasterizer often fewer triangles, or the view of \
                        a moment ago. The exact picture follows when nothing moves.";
            ("preview", Color32::from_rgb(0xd0, 0x94, 0x3c), help)
        };
        ui.label(RichText::new(word).color(color).strong()).on_hover_text(help);
        ui.label(format!("{width}×{height}"));
        ui.label(format!("{} ms", grouped(screen.milliseconds.round() as u64)));
        if exact
            && screen.kind == Kind::Exact
            && let Some((_, report)) = &workspace.report
        {
            layers(ui, report);
        }
        right(ui, workspace);
    });
}

/// What draws.
fn right(ui: &mut Ui, workspace: &Workspace) {
    ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
        if let Some(adapter) = &workspace.adapter {
            ui.add(Label::new(RichText::new(adapter).weak()).truncate());
        }
    });
}

/// What became of the layers of a picture.
pub fn layers(ui: &mut Ui, report: &FrameReport) {
    let layers = &report.layers;
    if report.plan.capture != Capture::None {
        ui.label(format!("{} layers stored", grouped(layers.stored)));
        ui.label(format!("{} merged", grouped(layers.merged)));
        let dropped = format!("{} dropped", grouped(layers.dropped));
        if layers.dropped > 0 {
            let help = "Farther layers than the capture has room for. The picture is what these settings give, exactly; \
                        `compacted` or a larger k shows them.";
            ui.colored_label(ui.visuals().warn_fg_color, dropped).on_hover_text(help);
        } else {
            ui.label(dropped);
        }
    }
    if layers.lost > 0 {
        ui.colored_label(ui.visuals().error_fg_color, format!("{} LOST", grouped(layers.lost)));
    }
}

/// A number with thin gaps between thousands.
pub fn grouped(n: u64) -> String {
    let digits = n.to_string();
    let mut out = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            out.push('\u{202f}');
        }
        out.push(digit);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::grouped;

    #[test]
    fn thousands_are_apart() {
        assert_eq!(grouped(7), "7");
        assert_eq!(grouped(1_234_567), "1\u{202f}234\u{202f}567");
    }
}
