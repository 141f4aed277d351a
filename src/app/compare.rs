//! Two settings under a divider: A, which were kept, left of it, and B, the present ones, right of it.
//!
//! Both are exact pictures of the same view, drawn one after the other by the same thread; while the view moves, both are moved
//! along like any other picture. Camera and parts are the present ones on both sides: what is compared is settings.

use std::sync::Arc;

use egui::text::{LayoutJob, TextWrapping};
use egui::{
    Align2, Area, Color32, CursorIcon, FontId, Id, Key, Order, Rect, Sense, Stroke, Ui, WidgetInfo, pos2, vec2,
};

use super::functions::Resolved;
use super::pictures::Against;
use super::viewport::{self, Paint, Shown};
use super::workspace::{Gravity, Workspace};
use crate::math::Camera;

/// Width of what takes the pointer around the divider.
const GRIP: f32 = 14.0;

/// An exact picture of the settings that were kept.
pub struct PictureOfA {
    /// The camera and the viewport that it is of.
    pub view: (Camera, [u32; 2]),
    /// Its pixels.
    pub shown: Arc<Shown>,
}

/// Settings that are compared with the present ones.
pub struct Compare {
    /// A.
    pub kept: Against,
    /// Where the divider stands, from 0 to 1 of the width.
    pub divider: f32,
    /// The picture of A.
    pub shown: Option<PictureOfA>,
    /// What both are called, if not A and B: those of a hard case.
    pub names: Option<[String; 2]>,
}

impl Compare {
    /// With these settings as A.
    pub fn with(kept: Against) -> Compare {
        Compare { kept, divider: 0.5, shown: None, names: None }
    }
}

impl Workspace {
    /// Keeps the present settings as A.
    pub fn keep_for_comparison(&mut self) {
        let resolved: Option<Resolved> = self.transfer();
        match (resolved, &self.document) {
            (Some(Ok(transfer)), Some(document)) => {
                let kept = Against { settings: document.seen.settings.clone(), transfer, shaders: None };
                let divider = self.compare.as_ref().map_or(0.5, |c| c.divider);
                self.compare = Some(Compare { divider, ..Compare::with(kept) });
            }
            (Some(Err(reason)), _) => self.say(Gravity::Error, reason),
            _ => {}
        }
    }

    /// Makes A the present settings and the present ones A, as one step of undo.
    pub fn swap_compared(&mut self) {
        let Some(Ok(transfer)) = self.transfer() else {
            return;
        };
        if let (Some(compare), Some(document)) = (&mut self.compare, &mut self.document) {
            document.settle();
            std::mem::swap(&mut compare.kept.settings, &mut document.seen.settings);
            compare.kept.transfer = transfer;
            compare.kept.shaders = None;
            compare.shown = None;
            compare.names = None;
            document.settle();
        }
    }

    /// What is compared with the present settings, if it is different from them.
    pub fn against(&self) -> Option<Against> {
        let (compare, document) = (self.compare.as_ref()?, self.document.as_ref()?);
        let different = compare.kept.settings != document.seen.settings || compare.kept.shaders.is_some();
        different.then(|| compare.kept.clone())
    }
}

/// What begins, turns and ends a comparison.
pub fn buttons(ui: &mut Ui, workspace: &mut Workspace) {
    if workspace.document.is_none() {
        return;
    }
    let comparing = workspace.compare.is_some();
    let help = "Keeps the present settings as A, and compares whatever is set from now on with them";
    if ui.button(if comparing { "Keep as A again" } else { "Keep as A" }).on_hover_text(help).clicked() {
        workspace.keep_for_comparison();
    }
    if comparing {
        if ui.button("Swap A and B").clicked() {
            workspace.swap_compared();
        }
        if ui.button("Stop comparing").clicked() {
            workspace.compare = None;
        }
    }
}

/// The picture of A over that of B, and the divider.
pub fn show(ui: &mut Ui, rect: Rect, workspace: &mut Workspace) {
    let different = workspace.against().is_some();
    let viewport = workspace.viewport;
    let (Some(compare), Some(document)) = (&mut workspace.compare, &workspace.document) else {
        return;
    };
    let (left, right) = match (different, compare.shown.is_some()) {
        (false, _) => ("A", "B is the same"),
        (true, false) => ("A is drawn …", "B"),
        (true, true) => ("A", "B"),
    };
    let names = compare.names.as_ref().filter(|_| different && compare.shown.is_some());
    let words = names.map_or([left, right], |[left, right]| [left, right]);
    let line = Divider { id: "divider", label: "Divider between A and B", at: compare.divider, words };
    let x = line.x(ui, rect);
    if different && let Some(PictureOfA { view: (camera, size), shown }) = &compare.shown {
        let now = (&document.seen.camera, viewport.size);
        let moved = if (*camera, *size) == (document.seen.camera, viewport.size) {
            None
        } else {
            viewport::moved_along((camera, *size), now, &document.scene.bounds())
        };
        let paint = Paint { picture: Arc::clone(shown), slot: 1, origin: viewport.origin, size: viewport.size, moved };
        let left = rect.with_max_x(x);
        ui.painter().with_clip_rect(left).add(paint.within(rect));
    }
    compare.divider = divider(ui, rect, &line);
}

/// What is drawn between two pictures, and what they are called.
pub struct Divider<'a> {
    /// Another divider has another one.
    pub id: &'static str,
    /// What a screen reader says.
    pub label: &'static str,
    /// Where it stands, from 0 to 1 of the width.
    pub at: f32,
    /// Left and right of it.
    pub words: [&'a str; 2],
}

impl Divider<'_> {
    /// Where it stands, points, on a pixel's edge.
    pub fn x(&self, ui: &Ui, rect: Rect) -> f32 {
        let ppp = ui.ctx().pixels_per_point();
        ((rect.left() + self.at * rect.width()) * ppp).round() / ppp
    }
}

/// Shows a divider over a picture; gives where it has been moved to.
pub fn divider(ui: &mut Ui, rect: Rect, line: &Divider<'_>) -> f32 {
    let x = line.x(ui, rect);
    let grip = Rect::from_x_y_ranges(x - 0.5 * GRIP..=x + 0.5 * GRIP, rect.y_range());
    // An area of its own, so that the pointer on it is not on the picture.
    let area = Area::new(Id::unique(line.id)).order(Order::Middle).fixed_pos(grip.min).constrain(false);
    area.show(ui.ctx(), |ui| {
        let (_, response) = ui.allocate_exact_size(grip.size(), Sense::click_and_drag());
        let response = response.on_hover_and_drag_cursor(CursorIcon::ResizeHorizontal);
        response.widget_info(|| WidgetInfo::slider(true, f64::from(line.at), line.label));
        let mut at = line.at;
        if response.dragged()
            && let Some(pointer) = response.interact_pointer_pos()
        {
            at = (pointer.x - rect.left()) / rect.width().max(1.0);
        }
        if response.has_focus() {
            let filter = egui::EventFilter { horizontal_arrows: true, ..Default::default() };
            ui.memory_mut(|m| m.set_focus_lock_filter(response.id, filter));
            let times = |key| ui.input(|i| i.num_presses(key)) as f32;
            at += 0.02 * (times(Key::ArrowRight) - times(Key::ArrowLeft));
        }
        let painter = ui.painter();
        painter.vline(x, rect.y_range(), Stroke::new(3.0, Color32::from_black_alpha(140)));
        painter.vline(x, rect.y_range(), Stroke::new(1.0, Color32::WHITE));
        let knob = pos2(x, rect.center().y);
        painter.circle(knob, 6.0, Color32::WHITE, Stroke::new(1.5, Color32::from_black_alpha(180)));
        let over = ui.ctx().layer_painter(ui.layer_id()).with_clip_rect(rect);
        let [left, right] = line.words;
        for (word, align, by) in [(left, Align2::RIGHT_TOP, -8.0), (right, Align2::LEFT_TOP, 8.0)] {
            let at = pos2(x, rect.top() + 8.0) + vec2(by, 0.0);
            // What does not fit beside the divider is cut short.
            let room = if by < 0.0 { x - rect.left() } else { rect.right() - x } - 16.0;
            if room < 12.0 {
                continue;
            }
            let mut job = LayoutJob::simple_singleline(word.to_owned(), FontId::proportional(12.5), Color32::WHITE);
            job.wrap = TextWrapping::truncate_at_width(room);
            let galley = over.layout_job(job);
            let plate = align.anchor_size(at, galley.size());
            over.rect_filled(plate.expand2(vec2(4.0, 2.0)), 3.0, Color32::from_black_alpha(150));
            over.galley(plate.min, galley, Color32::WHITE);
        }
        if response.has_focus() {
            painter.circle_stroke(knob, 9.0, Stroke::new(1.5, Color32::WHITE));
        }
        at.clamp(0.0, 1.0)
    })
    .inner
}
