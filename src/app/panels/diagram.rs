//! The work–precision diagram: time against error, both logarithmic, on egui's painter.
//!
//! What nothing measured beats is filled and joined by a line; what is beaten stays, hollow. The present settings have a ring and
//! a label. An error of exactly 0 has no logarithm and stands in a strip at the bottom.

use egui::{Align2, Color32, FontId, Id, Pos2, Rect, Sense, Stroke, Ui, WidgetInfo, pos2, vec2};

use super::style;
use crate::app::accuracy::{Entry, Plotted};
use crate::tradeoff::diagram::{Rectangle, Scale, place_label};
use crate::tradeoff::table::figure;

const HEIGHT: f32 = 230.0;
const LEFT: f32 = 42.0;
const RIGHT: f32 = 8.0;
const TOP: f32 = 8.0;
const BOTTOM: f32 = 34.0;
/// Height of the strip for errors of exactly 0.
const ZERO: f32 = 24.0;
/// How near to a point the pointer means it.
const NEAR: f32 = 9.0;

/// Where points stand.
pub struct Places {
    inner: Rect,
    xs: Scale,
    ys: Scale,
    any_zero: bool,
}

impl Places {
    /// For points in a rectangle.
    pub fn of(points: &[Plotted], rect: Rect) -> Places {
        let inner = Rect::from_min_max(rect.min + vec2(LEFT, TOP), rect.max - vec2(RIGHT, BOTTOM));
        let any_zero = points.iter().any(|p| p.point.error == 0.0);
        let floor = inner.bottom() - if any_zero { ZERO } else { 0.0 };
        let [left, right, floor, top] = [inner.left(), inner.right(), floor, inner.top()].map(f64::from);
        let xs = Scale::over(points.iter().flat_map(|p| p.point.time), left, right);
        let ys = Scale::over(points.iter().map(|p| p.point.error), floor, top);
        Places { inner, xs, ys, any_zero }
    }

    fn y(&self, error: f64) -> f32 {
        if error > 0.0 { self.ys.at(error) as f32 } else { self.inner.bottom() - 0.5 * ZERO }
    }

    /// Where a point stands.
    pub fn at(&self, plotted: &Plotted) -> Pos2 {
        pos2(self.xs.at(plotted.point.time[1]) as f32, self.y(plotted.point.error))
    }
}

/// Which entry is pointed at, here or in the list beside, from one frame to the next.
fn pointed(ui: &Ui) -> Id {
    ui.scope_id().with("pointed at")
}

/// Makes an entry stand out in the diagram from the next frame on.
pub fn point_at(ui: &Ui, id: Id, entry: Option<usize>) {
    let before = ui.data(|d| d.get_temp::<Option<usize>>(id)).flatten();
    if before != entry {
        ui.data_mut(|d| d.insert_temp(id, entry));
        ui.ctx().request_repaint();
    }
}

/// Shows the diagram; gives the entry that was clicked, and where to note what is pointed at.
pub fn show(ui: &mut Ui, points: &[Plotted], entries: &[Entry], error_name: &str) -> (Option<usize>, Id) {
    let id = pointed(ui);
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), HEIGHT), Sense::click());
    let label = format!("Diagram of time against error, {} points", points.len());
    response.widget_info(|| WidgetInfo::labeled(egui::Role::Image, true, &label));
    let places = Places::of(points, rect);
    let near = |at: Pos2| {
        let found = points.iter().map(|p| (places.at(p).distance(at), p)).filter(|(d, _)| *d <= NEAR);
        found.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, p)| p)
    };
    let hovered = response.hover_pos().and_then(near);
    let clicked = response.clicked().then(|| response.interact_pointer_pos().and_then(near)).flatten();
    let elsewhere = ui.data(|d| d.get_temp::<Option<usize>>(id)).flatten();
    grid(ui, &places, rect, points, error_name);
    marks(ui, &places, points, hovered.map(|p| p.entry).or(elsewhere));
    if let Some(plotted) = hovered {
        ui.ctx().set_cursor_icon(egui::CursorIcon::PointingHand);
        let beside = Rect::from_center_size(places.at(plotted), vec2(16.0, 16.0));
        let tip = egui::Tooltip::always_open(ui.ctx().clone(), ui.layer_id(), response.id, beside);
        tip.show(|ui| figures(ui, plotted, &entries[plotted.entry], error_name));
    }
    (clicked.map(|p| p.entry), id)
}

fn grid(ui: &Ui, places: &Places, rect: Rect, points: &[Plotted], error_name: &str) {
    let painter = ui.painter_at(rect);
    let weak = ui.visuals().weak_text_color();
    let line = Stroke::new(1.0, ui.visuals().widgets.noninteractive.bg_stroke.color);
    let inner = places.inner;
    painter.rect_filled(inner, 0.0, ui.visuals().extreme_bg_color);
    let font = FontId::proportional(10.0);
    let mut free = f32::NEG_INFINITY;
    for value in places.xs.ticks() {
        let x = places.xs.at(value) as f32;
        painter.vline(x, inner.y_range(), line);
        let galley = painter.layout_no_wrap(figure(value), font.clone(), weak);
        let left = x - 0.5 * galley.size().x;
        if left > free && left + galley.size().x <= rect.right() {
            free = left + galley.size().x + 4.0;
            painter.galley(pos2(left, inner.bottom() + 3.0), galley, weak);
        }
    }
    if points.iter().any(|p| p.point.error > 0.0) {
        for value in places.ys.ticks() {
            let y = places.ys.at(value) as f32;
            painter.hline(inner.x_range(), y, line);
            painter.text(pos2(inner.left() - 4.0, y), Align2::RIGHT_CENTER, figure(value), font.clone(), weak);
        }
    }
    if places.any_zero {
        let strip = inner.with_min_y(inner.bottom() - ZERO);
        painter.rect_filled(strip, 0.0, ui.visuals().faint_bg_color);
        painter.text(pos2(inner.left() - 4.0, places.y(0.0)), Align2::RIGHT_CENTER, "0", font.clone(), weak);
    }
    let middle = pos2(inner.center().x, rect.bottom());
    let text = format!("{error_name}  over  time of a frame, ms");
    painter.text(middle, Align2::CENTER_BOTTOM, text, FontId::proportional(11.0), weak);
}

fn marks(ui: &Ui, places: &Places, points: &[Plotted], pointed: Option<usize>) {
    let painter = ui.painter_at(places.inner.expand(7.0));
    let (best, beaten) = (style::ACCENT, style::BEATEN);
    let mut front: Vec<&Plotted> = points.iter().filter(|p| p.on_front).collect();
    front.sort_by(|a, b| a.point.time[1].total_cmp(&b.point.time[1]));
    painter.line(front.iter().map(|p| places.at(p)).collect(), Stroke::new(1.5, best.gamma_multiply(0.6)));
    // The best over the beaten.
    for plotted in points.iter().filter(|p| !p.on_front).chain(front.iter().copied()) {
        let at = places.at(plotted);
        let color = if plotted.on_front { best } else { beaten };
        let color = if plotted.point.sure { color } else { color.gamma_multiply(0.6) };
        let [low, _, high] = plotted.point.time.map(|t| places.xs.at(t) as f32);
        painter.hline(low..=high, at.y, Stroke::new(1.0, color.gamma_multiply(0.6)));
        let fill = if plotted.on_front { color } else { ui.visuals().extreme_bg_color };
        painter.circle(at, 3.5, fill, Stroke::new(1.3, color));
        if pointed == Some(plotted.entry) {
            painter.circle_stroke(at, 6.5, Stroke::new(1.5, ui.visuals().strong_text_color()));
        }
    }
    let mut taken: Vec<Rectangle> = points
        .iter()
        .map(|p| {
            let at = places.at(p);
            [at.x - 4.0, at.y - 4.0, at.x + 4.0, at.y + 4.0].map(f64::from)
        })
        .collect();
    let ink = ui.visuals().strong_text_color();
    if let Some(present) = points.iter().find(|p| p.is_present) {
        painter.circle_stroke(places.at(present), 6.5, Stroke::new(2.0, ink));
        label(ui, places, present, "present", ink, &mut taken, true);
    }
    for plotted in front.iter().filter(|p| !p.is_present) {
        label(ui, places, plotted, &plotted.point.label, best, &mut taken, false);
    }
}

/// Writes beside a point, if there is room or it has to be.
fn label(
    ui: &Ui,
    places: &Places,
    plotted: &Plotted,
    text: &str,
    color: Color32,
    taken: &mut Vec<Rectangle>,
    always: bool,
) {
    let painter = ui.painter_at(places.inner);
    let galley = painter.layout_no_wrap(text.to_owned(), FontId::proportional(10.5), color);
    let (at, inner) = (places.at(plotted), places.inner);
    let size = [galley.size().x + 4.0, galley.size().y].map(f64::from);
    let room = [inner.left(), inner.top(), inner.right(), inner.bottom()].map(f64::from);
    let r = place_label([at.x, at.y].map(f64::from), size, &room, taken);
    let hit = taken.iter().any(|t| t[0] < r[2] && r[0] < t[2] && t[1] < r[3] && r[1] < t[3]);
    if (hit || r[0] < room[0] || r[2] > room[2]) && !always {
        return;
    }
    taken.push(r);
    let [left, top, right, bottom] = r.map(|v| v as f32);
    let near = pos2(at.x.clamp(left, right), at.y.clamp(top, bottom));
    if near.distance(at) > 12.0 {
        painter.line_segment([at, near], Stroke::new(0.7, color.gamma_multiply(0.6)));
    }
    painter.galley(pos2(left + 2.0, top), galley, color);
}

/// Everything that was measured of a point.
pub fn figures(ui: &mut Ui, plotted: &Plotted, entry: &Entry, error_name: &str) {
    ui.strong(&entry.row.configuration.name);
    let Ok(measured) = &entry.row.outcome else {
        return;
    };
    let [low, middle, high] = plotted.point.time.map(figure);
    let mut lines = vec![format!("{middle} ms a frame ({low} to {high})")];
    if let Some(ratio) = measured.times.as_ref().and_then(|t| t.ratio) {
        let frames = if ratio.count == 1 { "1 frame".to_owned() } else { format!("{} frames", ratio.count) };
        lines.push(format!("{}× of what was asked for, {frames}", figure(ratio.median)));
    }
    let error = &measured.image;
    lines.push(format!("{error_name}: {}", figure(plotted.point.error)));
    lines.push(format!("error {} at most, {} in the mean, of 255", figure(error.maximum), figure(error.mean)));
    let percent = |share: f64| figure(100.0 * share);
    lines.push(format!(
        "{} % of pixels off by more than 1/255, {} % by 8",
        percent(error.above_1),
        percent(error.above_8)
    ));
    lines.push(format!("FLIP {} in the mean, {} at p99", figure(error.flip_mean), figure(error.flip_p99)));
    if let Some(layers) = &measured.layers {
        lines.push(format!("{} layers lost, {} merged, of {}", layers.lost, layers.merged, layers.layers));
    }
    let word = match (plotted.on_front, plotted.point.sure) {
        (true, _) => "Nothing measured is both faster and closer.",
        (false, true) => "Another one is faster and closer.",
        (false, false) => "Too few frames to tell.",
    };
    lines.push(word.to_owned());
    for text in lines {
        ui.label(egui::RichText::new(text).small());
    }
}
