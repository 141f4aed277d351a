//! Pointer and keys on the points of a curve, as calls of [`crate::transfer::edit`].
//!
//! Every point is a widget of its own that takes the focus, so Tab walks over them and a screen reader names them. A drag is
//! always worked out anew from the points as they stood when it began; nothing adds up.

use std::collections::BTreeSet;

use egui::{
    Color32, EventFilter, Id, Key, Modifiers, Pos2, Rect, Response, Role, Sense, Stroke, Ui, Vec2, WidgetInfo, vec2,
};

use super::plot::Plot;
use crate::transfer::edit::{self, EditPoint};
use crate::transfer::{ColorPoint, Interpolation, OpacityPoint, Points};

/// Side of the square around a point that takes the pointer.
const HANDLE: f32 = 16.0;
/// How much slower a point moves while Ctrl is held.
const FINE: f32 = 0.1;
/// Pixels of a drag that double a curve.
const DOUBLES: f64 = 80.0;
/// A new point so near to the curve is put onto it, pixels.
const ONTO: f64 = 8.0;

/// A point that is drawn at a height.
pub trait Handle: EditPoint {
    /// What it is called.
    const NAME: &'static str;
    /// Value that scaling leaves where it is.
    const ABOUT: f64;
    /// Where it is drawn, from 0 to 1.
    fn height(value: Self::Value) -> f64;
    /// The value so much higher; it is made allowed by who takes it.
    fn raised(value: Self::Value, by: f64) -> Self::Value;
    /// What it is painted in.
    fn ink(&self) -> Color32;
}

impl Handle for OpacityPoint {
    const NAME: &'static str = "Opacity point";
    const ABOUT: f64 = 0.0;
    fn height(opacity: f64) -> f64 {
        opacity
    }
    fn raised(opacity: f64, by: f64) -> f64 {
        opacity + by
    }
    fn ink(&self) -> Color32 {
        Color32::WHITE
    }
}

impl Handle for ColorPoint {
    const NAME: &'static str = "Colour point";
    const ABOUT: f64 = 0.5;
    fn height(rgb: [f64; 3]) -> f64 {
        rgb.iter().sum::<f64>() / 3.0
    }
    fn raised(rgb: [f64; 3], by: f64) -> [f64; 3] {
        rgb.map(|c| c + by)
    }
    fn ink(&self) -> Color32 {
        super::colour(self.color.0)
    }
}

/// What was done to the points in a frame.
pub struct Outcome<P> {
    /// The points as they are now, if anything changed.
    pub points: Option<Points<P>>,
    /// A gesture begins before that.
    pub begin: bool,
    /// It ends after it.
    pub end: bool,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum What {
    Move,
    Band,
    Scale,
}

#[derive(Clone, Debug)]
struct Drag<P> {
    what: What,
    /// As they stood.
    start: Points<P>,
    /// What was selected.
    selected: BTreeSet<usize>,
    from: Pos2,
    /// How far it has gone, pixels.
    way: Vec2,
}

/// What is selected and under way on one curve.
#[derive(Clone, Debug)]
pub struct Gestures<P> {
    /// Selected points.
    pub selected: BTreeSet<usize>,
    drag: Option<Drag<P>>,
    nudging: bool,
}

impl<P> Default for Gestures<P> {
    fn default() -> Gestures<P> {
        Gestures { selected: BTreeSet::new(), drag: None, nudging: false }
    }
}

impl<P: Handle> Gestures<P> {
    /// Gives up what is under way: the points come from elsewhere now.
    pub fn abandon(&mut self) {
        self.drag = None;
        self.nudging = false;
    }

    /// The same, unless nothing is: what only selects goes on.
    pub fn abandon_busy(&mut self) {
        if self.busy() {
            self.abandon();
        }
    }

    /// Whether a gesture is under way.
    pub fn busy(&self) -> bool {
        self.drag.as_ref().is_some_and(|d| d.what != What::Band) || self.nudging
    }

    /// The widgets of a curve: its ground and its points, painted over whatever is there.
    pub fn show(&mut self, ui: &Ui, plot: &Plot, points: &Points<P>, mode: Interpolation, name: &str) -> Outcome<P> {
        let mut outcome = Outcome { points: None, begin: false, end: false };
        self.selected.retain(|i| *i < points.as_slice().len());
        let id = ui.scope_id().with(name);
        let ground = ui.interact(plot.rect, id, Sense::click_and_drag());
        ground.widget_info(|| WidgetInfo::labeled(Role::Canvas, true, name));
        let handles: Vec<Response> = points
            .as_slice()
            .iter()
            .enumerate()
            .map(|(i, p)| {
                let at = plot.to_screen([p.position(), P::height(p.value())]);
                let rect = Rect::from_center_size(at, Vec2::splat(HANDLE));
                let handle = ui.interact(rect, id.with(i), Sense::click_and_drag());
                let label = format!("{} {}", P::NAME, i + 1);
                handle.widget_info(|| WidgetInfo::slider(true, P::height(p.value()), &label));
                handle
            })
            .collect();
        let (held, pressed) = ui.input(|i| (i.modifiers, i.pointer.press_origin()));
        let fine = held.command || held.ctrl;
        let begin = |what, selected: &BTreeSet<usize>, at: &Response| {
            let now = at.interact_pointer_pos().unwrap_or(plot.rect.center());
            let from = pressed.unwrap_or(now);
            let way = (now - from) * if what == What::Move && fine { FINE } else { 1.0 };
            Some(Drag { what, start: points.clone(), selected: selected.clone(), from, way })
        };
        // The point that the button went down on. In a slow frame the pointer has gone on since, and another widget has the drag.
        let grabbed = pressed.and_then(|from| {
            let distance = |h: &Response| h.rect.center().distance_sq(from);
            let near = handles.iter().enumerate().filter(|(_, h)| h.rect.contains(from));
            near.min_by(|a, b| distance(a.1).total_cmp(&distance(b.1))).map(|(i, _)| i)
        });
        let started = std::iter::once(&ground).chain(&handles).find(|r| r.drag_started());
        for (i, handle) in handles.iter().enumerate() {
            if started.is_some() && grabbed == Some(i) {
                if !self.selected.contains(&i) {
                    self.selected = [i].into();
                }
                self.drag = begin(What::Move, &self.selected, started.unwrap_or(handle));
                outcome.begin = true;
                handle.request_focus();
            } else if handle.clicked() && (held.shift || fine) {
                if !self.selected.remove(&i) {
                    self.selected.insert(i);
                }
                handle.request_focus();
            } else if handle.clicked() || (handle.gained_focus() && self.drag.is_none()) {
                if !(handle.gained_focus() && self.selected.contains(&i)) {
                    self.selected = [i].into();
                }
                handle.request_focus();
            }
        }
        if let Some(started) = started.filter(|_| grabbed.is_none()) {
            let what = if fine { What::Scale } else { What::Band };
            if !held.shift {
                self.selected.clear();
            }
            self.drag = begin(what, &self.selected, started);
            outcome.begin |= what == What::Scale;
            ground.request_focus();
        } else if ground.double_clicked() {
            if let Some(at) = ground.interact_pointer_pos() {
                outcome.points = self.add(plot, points, mode, plot.value_at(at));
            }
            ground.request_focus();
        } else if ground.clicked_by(egui::PointerButton::Primary) && !held.shift && !fine {
            self.selected.clear();
            ground.request_focus();
        }
        let dragged = std::iter::once(&ground).chain(&handles).find(|r| r.dragged() && !r.drag_started());
        self.follow(ui, plot, dragged.map(Response::drag_delta), held, &mut outcome);
        let focused = ground.has_focus().then_some(id).or_else(|| handles.iter().find(|h| h.has_focus()).map(|h| h.id));
        if let Some(focused) = focused {
            let filter = EventFilter { horizontal_arrows: true, vertical_arrows: true, ..EventFilter::default() };
            ui.memory_mut(|m| m.set_focus_lock_filter(focused, filter));
            self.keys(ui, plot, points, mode, &mut outcome);
            let left = outcome.points.as_ref().map_or(points.as_slice().len(), |p| p.as_slice().len());
            if let Some(gone) = handles.get(left..).and_then(|rest| rest.iter().find(|h| h.has_focus())) {
                gone.surrender_focus();
                ui.memory_mut(|m| m.request_focus(id.with(left - 1)));
            }
        }
        for (i, handle) in handles.iter().enumerate() {
            self.asked_by_assistance(ui, handle, i, points, &mut outcome);
        }
        let arrows = [Key::ArrowLeft, Key::ArrowRight, Key::ArrowUp, Key::ArrowDown];
        if self.nudging && !ui.input(|i| arrows.iter().any(|k| i.key_down(*k))) {
            self.nudging = false;
            outcome.end = true;
        }
        self.paint(ui, plot, outcome.points.as_ref().unwrap_or(points), &handles, focused);
        outcome
    }

    /// Goes on with a drag.
    fn follow(&mut self, ui: &Ui, plot: &Plot, way: Option<Vec2>, held: Modifiers, outcome: &mut Outcome<P>) {
        let Some(drag) = &mut self.drag else {
            return;
        };
        let fine = held.command || held.ctrl;
        drag.way += way.unwrap_or_default() * if drag.what == What::Move && fine { FINE } else { 1.0 };
        let cancelled = ui.input(|i| i.key_pressed(Key::Escape));
        match drag.what {
            _ if cancelled => {
                outcome.points = (drag.what != What::Band).then(|| drag.start.clone());
            }
            What::Move => {
                let mut way = drag.way;
                if held.shift {
                    way = if way.x.abs() >= way.y.abs() { vec2(way.x, 0.0) } else { vec2(0.0, way.y) };
                }
                let [dx, dy] = plot.value_of(way);
                let mut points = drag.start.clone();
                edit::shift(&mut points, &drag.selected, dx, |v| P::raised(v, dy));
                outcome.points = Some(points);
            }
            What::Scale => {
                let mut points = drag.start.clone();
                edit::scale(&mut points, (-f64::from(drag.way.y) / DOUBLES).exp2(), P::ABOUT);
                outcome.points = Some(points);
            }
            What::Band => {
                let band = Rect::from_two_pos(drag.from, drag.from + drag.way);
                let points = drag.start.as_slice().iter().enumerate();
                let inside = points
                    .filter(|(_, p)| band.contains(plot.to_screen([p.position(), P::height(p.value())])))
                    .map(|(i, _)| i);
                self.selected = drag.selected.iter().copied().chain(inside).collect();
            }
        }
        if cancelled || !ui.input(|i| i.pointer.any_down()) {
            outcome.end |= drag.what != What::Band;
            self.drag = None;
        }
    }

    /// Adds a point at a place, or on the curve if it is near; it is selected then.
    fn add(&mut self, plot: &Plot, points: &Points<P>, mode: Interpolation, [x, y]: [f64; 2]) -> Option<Points<P>> {
        let mut points = points.clone();
        let index = edit::insert(&mut points, mode, x)?;
        let there = *points.as_slice().get(index)?;
        let rise = y - P::height(there.value());
        if rise.abs() > ONTO * plot.of_one_pixel()[1] {
            edit::move_to(&mut points, index, there.position(), P::raised(there.value(), rise));
        }
        self.selected = [index].into();
        Some(points)
    }

    /// Adds a point on the curve, behind the selected one or where most room is.
    pub fn add_somewhere(&mut self, points: &Points<P>, mode: Interpolation) -> Option<Points<P>> {
        let places: Vec<f64> = points.as_slice().iter().map(|p| p.position()).collect();
        let [from, to] = P::DOMAIN;
        let ends: Vec<f64> = std::iter::once(from).chain(places.iter().copied()).chain([to]).collect();
        let gap = |i: usize| ends[i + 1] - ends[i];
        let widest = (0..ends.len() - 1).max_by(|a, b| gap(*a).total_cmp(&gap(*b)))?;
        let behind = self.selected.last().map(|i| i + 1).filter(|i| *i + 1 < ends.len() && gap(*i) > 0.0);
        let at = behind.unwrap_or(widest);
        let mut points = points.clone();
        let index = edit::insert(&mut points, mode, 0.5 * (ends[at] + ends[at + 1]))?;
        self.selected = [index].into();
        Some(points)
    }

    /// Takes the selected points away; the next one is selected then.
    pub fn delete(&mut self, points: &Points<P>) -> Option<Points<P>> {
        let mut points = points.clone();
        let first = *self.selected.first()?;
        let removed = edit::remove_all(&mut points, &self.selected);
        self.selected = [first.min(points.as_slice().len() - 1)].into();
        (removed > 0).then_some(points)
    }

    fn keys(&mut self, ui: &Ui, plot: &Plot, points: &Points<P>, mode: Interpolation, outcome: &mut Outcome<P>) {
        let held = ui.input(|i| i.modifiers);
        let pressed = |key| ui.input(|i| i.key_pressed(key));
        if pressed(Key::Delete) || pressed(Key::Backspace) {
            outcome.points = self.delete(points);
        } else if pressed(Key::Insert) {
            outcome.points = self.add_somewhere(points, mode);
        } else if (held.command || held.ctrl) && pressed(Key::A) {
            self.selected = (0..points.as_slice().len()).collect();
        }
        let step = match held {
            _ if held.shift => 0.05,
            _ if held.command || held.ctrl => 0.001,
            _ => 0.01,
        };
        let times = |key| ui.input(|i| i.num_presses(key)) as f64;
        let right = times(Key::ArrowRight) - times(Key::ArrowLeft);
        let up = times(Key::ArrowUp) - times(Key::ArrowDown);
        if (right != 0.0 || up != 0.0) && !self.selected.is_empty() && self.drag.is_none() {
            let mut moved = points.clone();
            let dx = right * step * (plot.x[1] - plot.x[0]);
            edit::shift(&mut moved, &self.selected, dx, |v| P::raised(v, up * step));
            outcome.begin |= !self.nudging;
            self.nudging = true;
            outcome.points = Some(moved);
        }
    }

    /// A point raised or lowered by assistive technology.
    fn asked_by_assistance(&self, ui: &Ui, handle: &Response, i: usize, points: &Points<P>, outcome: &mut Outcome<P>) {
        use egui::accesskit::Action;
        let times = |action| ui.input(|input| input.num_accesskit_action_requests(handle.id, action)) as f64;
        let up = times(Action::Increment) - times(Action::Decrement);
        if up != 0.0 {
            let mut moved = points.clone();
            edit::shift(&mut moved, &[i].into(), 0.0, |v| P::raised(v, 0.01 * up));
            outcome.points = Some(moved);
        }
    }

    fn paint(&self, ui: &Ui, plot: &Plot, points: &Points<P>, handles: &[Response], focused: Option<Id>) {
        let painter = ui.painter();
        let visuals = ui.visuals();
        let dark = if visuals.dark_mode { Color32::BLACK } else { Color32::from_gray(40) };
        for (i, p) in points.as_slice().iter().enumerate() {
            let at = plot.to_screen([p.position(), P::height(p.value())]);
            let handle = handles.get(i);
            let hovered = handle.is_some_and(|h| h.hovered() || h.dragged());
            let selected = self.selected.contains(&i);
            let radius = if hovered || selected { 5.5 } else { 4.5 };
            let ring = if selected { visuals.hyperlink_color } else { visuals.text_color() };
            painter.circle(at, radius + 1.5, dark, Stroke::NONE);
            painter.circle(at, radius, p.ink(), Stroke::new(if selected { 2.5 } else { 1.2 }, ring));
            if handle.is_some_and(|h| focused == Some(h.id)) {
                painter.circle_stroke(at, radius + 3.5, Stroke::new(1.5, visuals.text_color()));
            }
        }
        if let Some(drag) = self.drag.as_ref().filter(|d| d.what == What::Band) {
            let band = Rect::from_two_pos(drag.from, drag.from + drag.way).intersect(plot.rect);
            painter.rect_filled(band, 0.0, visuals.hyperlink_color.gamma_multiply(0.18));
            painter.rect_stroke(band, 0.0, Stroke::new(1.0, visuals.hyperlink_color), egui::StrokeKind::Inside);
        }
    }
}
