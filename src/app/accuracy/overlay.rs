//! The reference or the difference over the picture, left of a divider, with what the colours mean.

use std::sync::Arc;

use egui::{Align2, Color32, FontId, Rect, Sense, Ui, WidgetInfo, pos2, vec2};

use crate::app::compare::{self, Divider};
use crate::app::panels::messages;
use crate::app::viewport::Paint;
use crate::app::workspace::Workspace;
use crate::tradeoff::difference::{self, STOPS};

/// What lies over the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Overlay {
    /// Nothing.
    #[default]
    Off,
    /// The difference in false colours.
    Difference,
    /// The reference.
    Reference,
}

impl Overlay {
    /// All of them.
    pub const ALL: [Overlay; 3] = [Overlay::Off, Overlay::Difference, Overlay::Reference];

    /// In a word.
    pub fn name(self) -> &'static str {
        match self {
            Overlay::Off => "Off",
            Overlay::Difference => "Difference",
            Overlay::Reference => "Reference",
        }
    }

    /// Where the divider stands at first: a difference is looked at whole.
    fn first(self) -> f32 {
        if self == Overlay::Difference { 0.85 } else { 0.5 }
    }
}

/// What is over the picture while it is on: only of the very picture on screen, never of another.
pub fn show(ui: &mut Ui, rect: Rect, workspace: &mut Workspace) {
    let overlay = workspace.accuracy.overlay;
    if overlay == Overlay::Off || workspace.document.is_none() {
        return;
    }
    let found = workspace.referenced().map(|f| match overlay {
        Overlay::Reference => Arc::clone(&f.reference),
        _ => Arc::clone(&f.difference),
    });
    let place = workspace.accuracy.divider.get_or_insert((overlay, overlay.first()));
    if place.0 != overlay {
        *place = (overlay, overlay.first());
    }
    let at = place.1;
    let words = [if found.is_some() { overlay.name() } else { "Reference is drawn …" }, "Picture"];
    let divider = Divider { id: "accuracy divider", label: "Divider between reference and picture", at, words };
    if let Some(picture) = found.clone() {
        let (origin, size) = (workspace.viewport.origin, workspace.viewport.size);
        let paint = Paint { picture, slot: 1, origin, size, moved: None };
        let left = rect.with_max_x(divider.x(ui, rect));
        ui.painter().with_clip_rect(left).add(paint.within(rect));
    }
    let at = compare::divider(ui, rect, &divider);
    workspace.accuracy.divider = Some((overlay, at));
    if overlay == Overlay::Difference && found.is_some() {
        messages::over(ui, "difference legend", Align2::LEFT_TOP, rect, legend);
    }
}

/// The colours and their steps.
pub fn legend(ui: &mut Ui) {
    const SIZE: egui::Vec2 = vec2(212.0, 10.0);
    ui.label(egui::RichText::new("Largest channel difference, steps of 1/255").small());
    let (area, response) = ui.allocate_exact_size(SIZE + vec2(12.0, 14.0), Sense::hover());
    response.widget_info(|| {
        WidgetInfo::labeled(egui::Role::Image, true, "Colours of differences from 0 to 64 steps of 1/255")
    });
    let bar = Rect::from_min_size(area.min + vec2(6.0, 0.0), SIZE);
    let last = STOPS.len() - 1;
    let x = |at: f32| bar.left() + bar.width() * at / last as f32;
    for (i, pair) in STOPS.windows(2).enumerate() {
        const PIECES: usize = 8;
        for piece in 0..PIECES {
            let [from, to] = [piece, piece + 1].map(|p| i as f32 + p as f32 / PIECES as f32);
            let steps = pair[0].0 + (pair[1].0 - pair[0].0) * (piece as f64 + 0.5) / PIECES as f64;
            let [r, g, b] = difference::color(steps);
            let piece = Rect::from_x_y_ranges(x(from)..=x(to), bar.y_range());
            ui.painter().rect_filled(piece, 0.0, Color32::from_rgb(r, g, b));
        }
    }
    let ink = ui.visuals().text_color();
    for (i, (steps, _)) in STOPS.iter().enumerate() {
        let text = if i == last { format!("{steps}+") } else { steps.to_string() };
        let at = pos2(x(i as f32), bar.bottom() + 2.0);
        ui.painter().text(at, Align2::CENTER_TOP, text, FontId::proportional(10.0), ink);
    }
}
