//! Handles of section planes on the picture: an outline where a plane meets the box around the model, an arrow that pulls the
//! plane along its normal, and, on the chosen one, a knob at the arrow's end that tilts it.
//!
//! They are shown while planes are edited: from when one is added, or X or the switch in the panel of the sections is pressed,
//! until X, Esc or the switch again. So the viewport is the exact picture and nothing else at all other times. The widgets are
//! areas of their own, so that the pointer on one is not on the picture; what is painted is painted below them, clipped to the
//! picture.

use egui::{
    Area, Color32, CursorIcon, EventFilter, FontId, Id, Key, Order, Pos2, Rect, Response, Sense, Shape, Stroke, Ui,
    Vec2, WidgetInfo, pos2, vec2,
};
use glam::{DVec2, DVec3};

use super::selection::MARK;
use crate::app::document::Document;
use crate::app::measure::number;
use crate::app::planes::{self, Pull, View};
use crate::app::workspace::{Gravity, Workspace};
use crate::math::Bounds;
use crate::scene::Section;

/// Length of the arrow, and how far out the knob is, points.
const ARROW: f32 = 58.0;
const KNOB: f32 = 76.0;
/// Side of the squares that take the pointer.
const GRIP: f32 = 24.0;
/// The handle of an anchor outside the picture stands so far inside it.
const MARGIN: f32 = 24.0;
/// How much slower Ctrl makes it.
const FINE: f64 = 0.1;
/// Points of a drag that tilt by a right angle.
const RIGHT_ANGLE: f64 = 84.0;
/// What lies around lines, so that they are seen on light and dark.
const RIM: Color32 = Color32::from_black_alpha(190);
/// Planes that are not the chosen one.
const OTHERS: Color32 = Color32::from_rgb(0xd6, 0xdb, 0xe2);

/// Which of a plane's handles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum What {
    Pull,
    Tilt,
}

/// A drag of a handle, or keys that move it.
#[derive(Clone, Copy, Debug)]
struct Gesture {
    what: What,
    /// Index of the plane, and how it was.
    index: usize,
    start: Section,
    /// Its anchor then, scene space.
    anchor: DVec3,
    pull: Pull,
    /// How far the pointer has gone, points; slower where Ctrl was held.
    way: DVec2,
}

/// What the handles keep for themselves.
#[derive(Clone, Debug, Default)]
pub struct State {
    /// They are shown.
    pub shown: bool,
    /// Index of the chosen plane.
    pub chosen: usize,
    drag: Option<Gesture>,
    nudging: bool,
    /// A plane that has just been tilted, and about what: its handle stays there until the plane changes.
    tilted: Option<(usize, Section, DVec3)>,
}

impl State {
    /// Shows the handles, with this plane chosen.
    pub fn choose(&mut self, index: usize) {
        self.shown = true;
        self.chosen = index;
    }

    /// Whether a handle is being dragged.
    pub fn is_dragging(&self) -> bool {
        self.drag.is_some()
    }
}

/// Shows or hides the handles.
pub fn toggle(workspace: &mut Workspace) {
    let any = workspace.document.as_ref().is_some_and(|d| !d.seen.arrangement.sections.is_empty());
    let state = &mut workspace.layout.planes;
    if any {
        state.shown = !state.shown;
    } else {
        workspace.say(Gravity::Note, "There is no section plane yet: add one under Sections.");
    }
}

/// What Esc does to the handles: a drag is given up, else they are hidden; says whether there was anything to do.
pub fn escape(workspace: &mut Workspace) -> bool {
    let state = &mut workspace.layout.planes;
    if let (Some(drag), Some(document)) = (state.drag.take(), &mut workspace.document) {
        give_up(document, drag);
        return true;
    }
    std::mem::take(&mut state.shown)
}

fn give_up(document: &mut Document, drag: Gesture) {
    // An undo in between has put everything back already.
    if document.in_gesture()
        && let Some(section) = document.seen.arrangement.sections.get_mut(drag.index)
    {
        *section = drag.start;
    }
    document.end_gesture();
}

/// A plane as it is on the screen.
struct Place {
    outline: Vec<DVec3>,
    anchor: DVec3,
    pull: Pull,
    /// Where the handle stands.
    at: Pos2,
    /// Direction of the arrow.
    toward: Vec2,
}

/// What the picture is seen through.
struct Scenery<'a> {
    view: View,
    /// Around the model where its parts are, scene space.
    bounds: Bounds,
    origin: DVec3,
    picture: Rect,
    points_per_pixel: f32,
    focal_point: DVec3,
    state: &'a State,
}

impl Scenery<'_> {
    fn on_screen(&self, pixel: DVec2) -> Option<Pos2> {
        let near = pixel.is_finite() && pixel.abs().max_element() < 1e5;
        near.then(|| self.picture.min + vec2(pixel.x as f32, pixel.y as f32) * self.points_per_pixel)
    }

    /// Where a plane is; `None` if nothing of it lies before the eye.
    fn place(&self, index: usize, section: &Section) -> Option<Place> {
        let offset = section.offset - section.normal.dot(self.origin);
        let onto = |p: DVec3| p + section.normal * (offset - section.normal.dot(p));
        let outline = planes::outline(&self.bounds, section.normal, offset);
        let middle = planes::middle_of(&outline).unwrap_or_else(|| onto(self.bounds.center()));
        // What is dragged stays under the pointer, though the middle of the outline moves.
        let held = self.state.drag.filter(|d| d.index == index).map(|d| onto(d.anchor));
        let tilted = self.state.tilted.filter(|(i, s, _)| (*i, s) == (index, section)).map(|(_, _, anchor)| anchor);
        let (anchor, pull) = [held, tilted, Some(middle), Some(onto(self.focal_point))]
            .into_iter()
            .flatten()
            .find_map(|anchor| Some((anchor, Pull::new(&self.view, anchor, section.normal)?)))?;
        let inside = self.picture.shrink(MARGIN.min(0.25 * self.picture.size().min_elem()));
        let toward = vec2(pull.toward.x as f32, pull.toward.y as f32);
        let at = self.on_screen(self.view.pixel(anchor)?)?;
        let at = inside.clamp(at);
        // The arrow's end too is kept inside.
        let end = at + KNOB * toward;
        Some(Place { outline, anchor, pull, at: at + (inside.clamp(end) - end), toward })
    }
}

/// The handles, if they are shown.
pub fn show(ui: &Ui, picture: Rect, workspace: &mut Workspace) {
    let state = &mut workspace.layout.planes;
    let Some(document) = &mut workspace.document else {
        return;
    };
    // What is undone or done by something else is no drag any more.
    if !document.in_gesture() {
        state.drag = None;
        state.nudging = false;
    }
    let count = document.seen.arrangement.sections.len();
    state.shown &= count > 0;
    if !state.shown || workspace.viewport.size.contains(&0) {
        return;
    }
    state.chosen = state.chosen.min(count - 1);
    let arrangement = &document.seen.arrangement;
    let bounds = arrangement.framed_bounds(&document.scene);
    let camera = &document.seen.camera;
    let scenery = Scenery {
        view: View::new(camera, &bounds, workspace.viewport.size),
        bounds,
        origin: document.scene.origin,
        picture,
        points_per_pixel: 1.0 / ui.ctx().pixels_per_point(),
        focal_point: camera.focal_point,
        state,
    };
    let sections = arrangement.sections.iter().enumerate().filter(|(_, s)| s.enabled);
    let mut places: Vec<(usize, Place)> = sections.filter_map(|(i, s)| Some((i, scenery.place(i, s)?))).collect();
    let (chosen, view) = (state.chosen, scenery.view);
    // The chosen one lies over the others.
    places.sort_by_key(|(i, _)| *i == chosen);
    let painter = ui.painter().with_clip_rect(picture);
    for (index, place) in &places {
        paint_outline(&painter, &scenery, place, *index == chosen);
    }
    let file = planes::in_file(&bounds, &document.scene);
    for (index, place) in places {
        let section = document.seen.arrangement.sections[index];
        let name = format!("section {}", index + 1);
        let along = |distance: f32| place.at + distance * place.toward;
        let zone = |what: What, part: usize, at: Pos2| -> Response {
            let id = Id::unique(("handle of a section", index, what == What::Tilt, part));
            let area = Area::new(id).order(Order::Middle).fixed_pos(at - Vec2::splat(0.5 * GRIP));
            area.constrain(false)
                .fade_in(false)
                .show(ui.ctx(), |ui| {
                    // Of the arrow only the head is walked to and named.
                    let sense = if part == 0 { Sense::click_and_drag() } else { Sense::CLICK | Sense::DRAG };
                    ui.allocate_exact_size(Vec2::splat(GRIP), sense).1
                })
                .inner
        };
        let head = zone(What::Pull, 0, along(ARROW - 8.0)).on_hover_and_drag_cursor(CursorIcon::Grab);
        head.widget_info(|| WidgetInfo::slider(true, section.offset, format!("Pull {name}")));
        let shaft = zone(What::Pull, 1, along(0.5 * ARROW - 6.0)).on_hover_and_drag_cursor(CursorIcon::Grab);
        let foot = zone(What::Pull, 2, along(2.0)).on_hover_and_drag_cursor(CursorIcon::Grab);
        let knob = (index == chosen).then(|| {
            let knob = zone(What::Tilt, 0, along(KNOB)).on_hover_and_drag_cursor(CursorIcon::Crosshair);
            let rise = section.normal.y.clamp(-1.0, 1.0).asin().to_degrees();
            knob.widget_info(|| WidgetInfo::slider(true, rise, format!("Tilt {name}")));
            knob
        });
        let pulls = [&head, &shaft, &foot].map(|r| (What::Pull, r));
        for (what, response) in pulls.into_iter().chain(knob.iter().map(|k| (What::Tilt, k))) {
            let started = response.drag_started_by(egui::PointerButton::Primary);
            if started || response.clicked() || response.gained_focus() {
                state.chosen = index;
            }
            if started {
                document.begin_gesture();
                let now = response.interact_pointer_pos().unwrap_or(place.at);
                let from = ui.input(|i| i.pointer.press_origin()).unwrap_or(now);
                let way = points(now - from) * pace(ui);
                state.drag = Some(Gesture { what, index, start: section, anchor: place.anchor, pull: place.pull, way });
            }
            if started || response.clicked() {
                let focus = if what == What::Tilt { response } else { &head };
                focus.request_focus();
            }
            if let Some(drag) = state.drag.as_mut().filter(|d| (d.index, d.what) == (index, what))
                && response.dragged()
                && !started
            {
                drag.way += points(response.drag_delta()) * pace(ui);
            }
        }
        if let Some(drag) = state.drag.filter(|d| d.index == index) {
            let moved = dragged(ui, &view, document, &file, &drag);
            if let Some(section) = document.seen.arrangement.sections.get_mut(index) {
                *section = moved;
            }
            if ui.input(|i| i.key_pressed(Key::Escape)) {
                give_up(document, drag);
                state.drag = None;
            } else if !ui.input(|i| i.pointer.any_down()) {
                document.end_gesture();
                state.drag = None;
                state.tilted = (drag.what == What::Tilt).then_some((index, moved, drag.anchor));
            }
        }
        for (what, response) in [(What::Pull, Some(&head)), (What::Tilt, knob.as_ref())] {
            if let Some(response) = response {
                keys(ui, state, document, (&view, &file), what, (index, &place), response);
            }
        }
        let over = [Some(&head), Some(&shaft), Some(&foot)].into_iter().flatten().any(|r| r.hovered() || r.dragged());
        let look = Look {
            chosen: state.chosen == index,
            over: [over, knob.as_ref().is_some_and(|k| k.hovered() || k.dragged())],
            focused: [head.has_focus(), knob.as_ref().is_some_and(Response::has_focus)],
            knob: knob.is_some(),
        };
        paint_handle(&painter, &place, &look);
        if state.drag.is_some_and(|d| d.index == index) {
            let section = document.seen.arrangement.sections[index];
            paint_number(&painter, along(KNOB + 26.0), &section);
        }
    }
    let arrows = [Key::ArrowLeft, Key::ArrowRight, Key::ArrowUp, Key::ArrowDown];
    if state.nudging && !ui.input(|i| arrows.iter().any(|k| i.key_down(*k))) {
        state.nudging = false;
        document.end_gesture();
    }
}

fn points(v: Vec2) -> DVec2 {
    DVec2::new(f64::from(v.x), f64::from(v.y))
}

/// What a way of the pointer or a key counts for.
fn pace(ui: &Ui) -> f64 {
    if ui.input(|i| i.modifiers.command || i.modifiers.ctrl) { FINE } else { 1.0 }
}

/// The plane as a drag has it.
fn dragged(ui: &Ui, view: &View, document: &Document, file: &Bounds, drag: &Gesture) -> Section {
    let pixels = drag.way * f64::from(ui.ctx().pixels_per_point());
    match drag.what {
        What::Pull => planes::moved(&drag.start, file, drag.pull.distance(pixels)),
        What::Tilt => {
            let way = drag.way * (0.5 * std::f64::consts::PI / RIGHT_ANGLE);
            let normal = planes::tilted(drag.start.normal, view.axes_at(drag.anchor), way);
            let normal = if ui.input(|i| i.modifiers.shift) { planes::snapped(normal) } else { normal };
            planes::about(&drag.start, drag.anchor + document.scene.origin, normal)
        }
    }
}

/// Arrow keys on a handle that has the focus, and what assistive technology asks of it.
fn keys(
    ui: &Ui,
    state: &mut State,
    document: &mut Document,
    (view, file): (&View, &Bounds),
    what: What,
    (index, place): (usize, &Place),
    handle: &Response,
) {
    use egui::accesskit::Action;
    let mut way = DVec2::ZERO;
    if handle.has_focus() && state.drag.is_none() {
        let filter = EventFilter { horizontal_arrows: true, vertical_arrows: true, ..EventFilter::default() };
        ui.memory_mut(|m| m.set_focus_lock_filter(handle.id, filter));
        let times = |key| ui.input(|i| i.num_presses(key)) as f64;
        let right = times(Key::ArrowRight) - times(Key::ArrowLeft);
        way = DVec2::new(right, times(Key::ArrowDown) - times(Key::ArrowUp));
        if way != DVec2::ZERO && !state.nudging {
            state.nudging = true;
            document.begin_gesture();
        }
    }
    let times = |action| ui.input(|i| i.num_accesskit_action_requests(handle.id, action)) as f64;
    let asked = times(Action::Increment) - times(Action::Decrement);
    way.y -= asked;
    let Some(section) = document.seen.arrangement.sections.get_mut(index).filter(|_| way != DVec2::ZERO) else {
        return;
    };
    let shift = ui.input(|i| i.modifiers.shift);
    *section = match what {
        What::Pull => {
            let [least, most] = planes::range_of(file, section.normal);
            let step = (most - least) / if shift { 20.0 } else { 200.0 } * pace(ui);
            planes::moved(section, file, (way.x - way.y) * step)
        }
        What::Tilt => {
            let degrees = if shift { planes::SNAP } else { pace(ui) };
            let normal = planes::tilted(section.normal, view.axes_at(place.anchor), way * degrees.to_radians());
            planes::about(section, place.anchor + document.scene.origin, normal)
        }
    };
}

/// How a handle is to look.
struct Look {
    chosen: bool,
    /// The pointer is on the arrow, on the knob.
    over: [bool; 2],
    /// The arrow has the focus, the knob has.
    focused: [bool; 2],
    knob: bool,
}

/// Where the plane meets the box around the model.
fn paint_outline(painter: &egui::Painter, scenery: &Scenery<'_>, place: &Place, chosen: bool) {
    let corners = &place.outline;
    let lines = (0..corners.len()).filter_map(|i| {
        let [from, to] = scenery.view.line(corners[i], corners[(i + 1) % corners.len()])?;
        // Ends far outside are brought near: what is seen stays.
        let reach = f64::from(scenery.picture.size().max_elem() / scenery.points_per_pixel) * 4.0;
        let near = |p: DVec2| p.clamp(DVec2::splat(-reach), DVec2::splat(reach));
        let inside = |p: DVec2| near(p) == p;
        let pair = if inside(from) && inside(to) { [from, to] } else { brought_near(from, to, reach)? };
        Some([scenery.on_screen(pair[0])?, scenery.on_screen(pair[1])?])
    });
    let lines: Vec<[Pos2; 2]> = lines.collect();
    let (width, ink) = if chosen { (1.8, MARK) } else { (1.2, OTHERS) };
    for pair in &lines {
        painter.line_segment(*pair, Stroke::new(width + 2.2, RIM));
    }
    for pair in &lines {
        painter.line_segment(*pair, Stroke::new(width, ink));
    }
}

/// What of a line lies in the square from −`reach` to `reach`.
fn brought_near(from: DVec2, to: DVec2, reach: f64) -> Option<[DVec2; 2]> {
    let (mut first, mut last) = (0.0_f64, 1.0_f64);
    let way = to - from;
    for (start, step) in [(from.x, way.x), (from.y, way.y)] {
        if step == 0.0 {
            if start.abs() > reach {
                return None;
            }
            continue;
        }
        let (a, b) = ((-reach - start) / step, (reach - start) / step);
        first = first.max(a.min(b));
        last = last.min(a.max(b));
    }
    (first < last).then(|| [from + first * way, from + last * way])
}

/// The arrow and the knob.
fn paint_handle(painter: &egui::Painter, place: &Place, look: &Look) {
    let ink = if look.chosen { MARK } else { OTHERS };
    let (at, toward) = (place.at, place.toward);
    let across = vec2(-toward.y, toward.x);
    let width = if look.over[0] { 3.2 } else { 2.2 };
    let tip = at + ARROW * toward;
    let neck = at + (ARROW - 13.0) * toward;
    let head = |more: f32| {
        vec![
            tip + 1.6 * more * toward,
            neck - more * toward + (6.0 + more) * across,
            neck - more * toward - (6.0 + more) * across,
        ]
    };
    if look.knob {
        painter.line_segment([tip, at + (KNOB - 6.0) * toward], Stroke::new(3.4, RIM));
    }
    painter.line_segment([at, neck], Stroke::new(width + 2.4, RIM));
    painter.add(Shape::convex_polygon(head(1.8), RIM, Stroke::NONE));
    painter.circle_filled(at, 5.2, RIM);
    painter.line_segment([at, neck], Stroke::new(width, ink));
    painter.add(Shape::convex_polygon(head(0.0), ink, Stroke::NONE));
    painter.circle_filled(at, 3.4, ink);
    if place.pull.facing {
        // There is no telling from the arrow that the plane faces the viewer.
        painter.circle_stroke(at, 8.0, Stroke::new(3.4, RIM));
        painter.circle_stroke(at, 8.0, Stroke::new(1.4, ink));
    }
    if look.focused[0] {
        painter.circle_stroke(at + (ARROW - 8.0) * toward, 12.0, Stroke::new(1.5, Color32::WHITE));
    }
    if look.knob {
        let knob = at + KNOB * toward;
        painter.line_segment([tip, knob - 6.0 * toward], Stroke::new(1.2, ink));
        painter.circle_stroke(knob, 6.5, Stroke::new(5.0, RIM));
        painter.circle_stroke(knob, 6.5, Stroke::new(if look.over[1] { 3.2 } else { 2.2 }, ink));
        if look.focused[1] {
            painter.circle_stroke(knob, 12.0, Stroke::new(1.5, Color32::WHITE));
        }
    }
}

/// Where the plane is, while it is dragged.
fn paint_number(painter: &egui::Painter, at: Pos2, section: &Section) {
    let n = section.normal;
    let text = format!("{}  ·  {:.2} {:.2} {:.2}", number(section.offset), n.x, n.y, n.z).replace("-0.00", "0.00");
    let text = painter.layout_no_wrap(text, FontId::proportional(12.5), MARK);
    let plate = Rect::from_center_size(at, text.size() + vec2(10.0, 4.0));
    let room = painter.clip_rect().shrink(4.0);
    let shift = vec2(
        (room.left() - plate.left()).max(0.0) - (plate.right() - room.right()).max(0.0),
        (room.top() - plate.top()).max(0.0) - (plate.bottom() - room.bottom()).max(0.0),
    );
    let plate = plate.translate(shift);
    painter.rect_filled(plate, 3.0, RIM);
    painter.galley(pos2(plate.left() + 5.0, plate.top() + 2.0), text, MARK);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_cut_to_what_can_be_painted() {
        let near = brought_near(DVec2::new(-1e6, 0.0), DVec2::new(1e6, 0.0), 100.0).unwrap();
        assert!(
            (near[0] - DVec2::new(-100.0, 0.0)).length() < 1e-6 && (near[1] - DVec2::new(100.0, 0.0)).length() < 1e-6
        );
        assert_eq!(brought_near(DVec2::new(-5.0, 200.0), DVec2::new(5.0, 200.0), 100.0), None);
        assert_eq!(brought_near(DVec2::new(150.0, 0.0), DVec2::new(0.0, 150.0), 70.0), None);
        let inside = [DVec2::new(1.0, 2.0), DVec2::new(-3.0, 50.0)];
        assert_eq!(brought_near(inside[0], inside[1], 100.0), Some(inside));
    }
}
