//! The whole opacity function, seen from above: depth to the right, |κ| upwards, white is opaque.
//!
//! Every curve is an upright line with a handle; dragging it changes its depth, a double-click puts a new curve in.

use egui::{
    Color32, ColorImage, EventFilter, Key, Rect, Role, Sense, Stroke, TextureHandle, TextureOptions, Ui, WidgetInfo,
    pos2, vec2,
};

use super::plot::{Plot, Tick};
use super::{Edit, interpolation, opacities, sign};
use crate::render::LayerHistogram;
use crate::transfer::{OpacityCurve, OpacityFunction, OpacityShape, Points, TransferFunction, edit};

const ACROSS: &[Tick] = &[(0.0, "0 near"), (0.5, "depth"), (1.0, "1 far")];
const UPWARDS: &[Tick] = &[(0.0, "flat"), (0.5, "|κ|"), (1.0, "sharp")];
/// Samples along either side.
const SIDE: usize = 64;
/// Width of what takes the pointer around a curve.
const GRIP: f32 = 12.0;
/// Pixels of a drag that double everything.
const DOUBLES: f64 = 80.0;

/// Pictures that are painted once, and what is under way.
#[derive(Default)]
pub struct State {
    opacity: Option<(OpacityFunction, bool, TextureHandle)>,
    counts: Option<(u64, bool, TextureHandle)>,
    drag: Option<Drag>,
    nudging: bool,
}

struct Drag {
    start: Points<OpacityCurve>,
    /// The curve; `None` scales all.
    curve: Option<usize>,
    way: egui::Vec2,
}

impl State {
    pub(super) fn abandon_busy(&mut self) {
        self.drag = None;
        self.nudging = false;
    }

    pub(super) fn forget_textures(&mut self) {
        self.opacity = None;
        self.counts = None;
    }

    /// The function as a picture.
    pub(super) fn image_of(&mut self, ui: &Ui, function: &TransferFunction) -> TextureHandle {
        let dark = ui.visuals().dark_mode;
        if let Some((of, with, handle)) = &self.opacity
            && *of == function.opacity
            && *with == dark
        {
            return handle.clone();
        }
        let image = picture(&function.opacity, [SIDE, SIDE], dark);
        let handle = ui.ctx().load_texture("opacity map", image, TextureOptions::LINEAR);
        self.opacity = Some((function.opacity.clone(), dark, handle.clone()));
        handle
    }

    fn image_of_counts(&mut self, ui: &Ui, counts: &LayerHistogram) -> TextureHandle {
        let dark = ui.visuals().dark_mode;
        if let Some((of, with, handle)) = &self.counts
            && *of == counts.serial
            && *with == dark
        {
            return handle.clone();
        }
        let ink = super::plot::counted(dark);
        let pixels =
            counts.map.log_image().into_iter().map(|level| ink.gamma_multiply(f32::from(level) / 255.0 * 0.85));
        let image = ColorImage::new(counts.map.size(), pixels.collect());
        let handle = ui.ctx().load_texture("layers", image, TextureOptions::NEAREST);
        self.counts = Some((counts.serial, dark, handle.clone()));
        handle
    }
}

/// An opacity function as a picture.
pub fn picture(function: &OpacityFunction, [width, height]: [usize; 2], dark: bool) -> ColorImage {
    let (clear, solid) = if dark { (24.0, 235.0) } else { (250.0, 40.0) };
    let mut pixels = Vec::with_capacity(width * height);
    let share = |i: usize, n: usize| i as f64 / (n - 1).max(1) as f64;
    let sampler = function.sampler();
    for y in (0..height).rev() {
        let row = sampler.row(share(y, height));
        let shade = |x| Color32::from_gray((clear + (solid - clear) * row(share(x, width))) as u8);
        pixels.extend((0..width).map(shade));
    }
    ColorImage::new([width, height], pixels)
}

/// The map and its curves.
pub fn show(
    ui: &mut Ui,
    state: &mut State,
    one: &mut opacities::State,
    function: &TransferFunction,
    counts: Option<&LayerHistogram>,
    edit: &mut Edit,
) {
    let curves = match &function.opacity.shape {
        OpacityShape::Curves { curves, depth_interpolation, .. } => Some((curves, *depth_interpolation)),
        OpacityShape::Image(_) => None,
    };
    if let Some((curves, between)) = curves {
        ui.horizontal(|ui| {
            ui.strong("Map");
            if let Some(to) = interpolation(ui, "Between curves", between) {
                edit.change(function, |f| {
                    f.opacity.set_interpolation(None, Some(to));
                });
            }
            if sign(ui, true, "+", "Add curve") {
                let depths: Vec<f64> = curves.as_slice().iter().map(|c| c.depth).collect();
                add(edit, one, function, free_depth(&depths));
            }
            if sign(ui, curves.as_slice().len() > 1, "−", "Delete curve") {
                remove(edit, one, function);
            }
        });
    }
    let (outer, _) = ui.allocate_exact_size(ui.available_size(), Sense::hover());
    let plot = Plot::within(outer, [0.0, 1.0], [0.0, 1.0]);
    plot.paint_axes(ui, ACROSS, UPWARDS);
    let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
    ui.painter().image(state.image_of(ui, function).id(), plot.rect, whole, Color32::WHITE);
    if let Some(counts) = counts {
        ui.painter().image(state.image_of_counts(ui, counts).id(), plot.rect, whole, Color32::WHITE);
    }
    if let Some((curves, _)) = curves {
        handles(ui, state, one, &plot, function, curves, edit);
    }
}

/// In the middle of the widest gap.
fn free_depth(depths: &[f64]) -> f64 {
    let ends: Vec<f64> = std::iter::once(0.0).chain(depths.iter().copied()).chain([1.0]).collect();
    let widest = ends.windows(2).max_by(|a, b| (a[1] - a[0]).total_cmp(&(b[1] - b[0])));
    widest.map_or(0.5, |gap| 0.5 * (gap[0] + gap[1]))
}

fn add(edit: &mut Edit, one: &mut opacities::State, function: &TransferFunction, depth: f64) {
    edit.change(function, |f| {
        if let Some(index) = edit::insert_curve(&mut f.opacity, depth) {
            one.choose(index);
        }
    });
}

fn remove(edit: &mut Edit, one: &mut opacities::State, function: &TransferFunction) {
    let curve = one.curve;
    edit.change(function, |f| {
        if let Some(curves) = f.opacity.curves_mut() {
            edit::remove(curves, curve);
        }
    });
    one.choose(curve.saturating_sub(1));
    one.gestures = Default::default();
}

fn handles(
    ui: &Ui,
    state: &mut State,
    one: &mut opacities::State,
    plot: &Plot,
    function: &TransferFunction,
    curves: &Points<OpacityCurve>,
    edit: &mut Edit,
) {
    let id = ui.scope_id().with("map");
    let ground = ui.interact(plot.rect, id, Sense::click_and_drag());
    ground.widget_info(|| WidgetInfo::labeled(Role::Canvas, true, "Opacity map"));
    let held = ui.input(|i| i.modifiers);
    let fine = held.command || held.ctrl;
    if ground.double_clicked()
        && let Some(at) = ground.interact_pointer_pos()
    {
        add(edit, one, function, plot.value_at(at)[0]);
    } else if ground.clicked_by(egui::PointerButton::Primary)
        && let Some(at) = ground.interact_pointer_pos()
    {
        let nearest = |curve: &OpacityCurve| (curve.depth - plot.value_at(at)[0]).abs();
        let all = curves.as_slice().iter().enumerate();
        if let Some((i, _)) = all.min_by(|a, b| nearest(a.1).total_cmp(&nearest(b.1))) {
            one.choose(i);
        }
    }
    let pressed = ui.input(|i| i.pointer.press_origin());
    let on_a_curve = |from: egui::Pos2| {
        curves.as_slice().iter().any(|c| (plot.to_screen([c.depth, 0.0]).x - from.x).abs() <= 0.5 * GRIP)
    };
    if ground.drag_started() && fine && !pressed.is_some_and(on_a_curve) {
        let way = ground.total_drag_delta().unwrap_or_default();
        state.drag = Some(Drag { start: curves.clone(), curve: None, way });
        edit.begin = true;
    }
    let mut moving = ground.dragged().then(|| ground.drag_delta()).filter(|_| !ground.drag_started());
    let put = |edit: &mut Edit, new: Points<OpacityCurve>| {
        edit.change(function, |f| {
            if let Some(curves) = f.opacity.curves_mut() {
                *curves = new;
            }
        });
    };
    let mut removed = false;
    for (i, curve) in curves.as_slice().iter().enumerate() {
        let x = plot.to_screen([curve.depth, 0.0]).x;
        let rect = Rect::from_x_y_ranges(x - 0.5 * GRIP..=x + 0.5 * GRIP, plot.rect.y_range());
        let handle = ui.interact(rect, id.with(i), Sense::click_and_drag());
        let handle = handle.on_hover_cursor(egui::CursorIcon::ResizeHorizontal);
        let name = format!("Depth curve {}", i + 1);
        handle.widget_info(|| WidgetInfo::slider(true, curve.depth, &name));
        if handle.clicked() || handle.gained_focus() || handle.drag_started() {
            one.choose(i);
            handle.request_focus();
        }
        if handle.drag_started() {
            let way = handle.total_drag_delta().unwrap_or_default();
            state.drag = Some(Drag { start: curves.clone(), curve: Some(i), way });
            edit.begin = true;
        } else if handle.dragged() {
            moving = Some(handle.drag_delta());
        }
        if handle.has_focus() {
            let filter = EventFilter { horizontal_arrows: true, ..EventFilter::default() };
            ui.memory_mut(|m| m.set_focus_lock_filter(handle.id, filter));
            let times = |key| ui.input(|i| i.num_presses(key)) as f64;
            let step = if held.shift { 0.05 } else { 0.01 } * if fine { 0.1 } else { 1.0 };
            let right = times(Key::ArrowRight) - times(Key::ArrowLeft);
            if right != 0.0 && state.drag.is_none() {
                edit.begin |= !state.nudging;
                state.nudging = true;
                let mut new = curves.clone();
                edit::move_curve(&mut new, i, curve.depth + right * step);
                put(edit, new);
            }
            removed |= ui.input(|i| i.key_pressed(Key::Delete) || i.key_pressed(Key::Backspace));
        }
        let chosen = one.curve == i;
        let ink = if chosen { ui.visuals().hyperlink_color } else { Color32::from_gray(128) };
        let width = if chosen || handle.hovered() { 2.5 } else { 1.5 };
        let painter = ui.painter();
        painter.vline(x, plot.rect.y_range(), Stroke::new(width + 1.5, Color32::from_black_alpha(120)));
        painter.vline(x, plot.rect.y_range(), Stroke::new(width, ink));
        for point in curve.points.as_slice() {
            let at = plot.to_screen([curve.depth, point.kappa]);
            painter.circle(at, 3.0, Color32::WHITE, Stroke::new(1.0, Color32::BLACK));
        }
        if handle.has_focus() {
            let rect = rect.shrink2(vec2(2.0, 0.0));
            painter.rect_stroke(rect, 2.0, Stroke::new(1.0, ui.visuals().text_color()), egui::StrokeKind::Outside);
        }
    }
    if let Some(drag) = &mut state.drag {
        drag.way += moving.unwrap_or_default() * if drag.curve.is_some() && fine { 0.1 } else { 1.0 };
        let mut new = drag.start.clone();
        let cancelled = ui.input(|i| i.key_pressed(Key::Escape));
        match drag.curve {
            _ if cancelled => {}
            Some(i) => {
                let from = drag.start.as_slice().get(i).map_or(f64::NAN, |c| c.depth);
                edit::move_curve(&mut new, i, from + plot.value_of(drag.way)[0]);
            }
            None => edit::scale_curves(&mut new, (-f64::from(drag.way.y) / DOUBLES).exp2()),
        }
        put(edit, new);
        if cancelled || !ui.input(|i| i.pointer.any_down()) {
            state.drag = None;
            edit.end = true;
        }
    }
    if state.nudging && !ui.input(|i| i.key_down(Key::ArrowLeft) || i.key_down(Key::ArrowRight)) {
        state.nudging = false;
        edit.end = true;
    }
    if removed {
        remove(edit, one, function);
    }
}
