//! Opacity over |κ| at the chosen depth.

use egui::{Rect, Sense, Ui};

use super::gestures::Gestures;
use super::plot::{self, Plot, Tick};
use super::{Edit, counts_near, has_points, interpolation, line, number, sign};
use crate::render::LayerHistogram;
use crate::transfer::{OpacityPoint, OpacityShape, TransferFunction, edit};

const ACROSS: &[Tick] = &[(0.0, "0 flat"), (0.25, "0.25"), (0.5, "0.5"), (0.75, "0.75"), (1.0, "|κ| 1 sharp")];
const UPWARDS: &[Tick] = &[(0.0, "0 %"), (0.5, "50 %"), (1.0, "100 %")];

/// What is selected.
#[derive(Default)]
pub struct State {
    /// The curve that is edited.
    pub curve: usize,
    /// Whether it is chosen: at first it is the one with most layers near it.
    settled: bool,
    /// On it.
    pub gestures: Gestures<OpacityPoint>,
}

impl State {
    /// Edits another curve.
    pub fn choose(&mut self, curve: usize) {
        self.settled = true;
        if curve != self.curve {
            self.curve = curve;
            self.gestures = Gestures::default();
        }
    }
}

/// The editor of one curve.
pub fn show(
    ui: &mut Ui,
    state: &mut State,
    function: &TransferFunction,
    counts: Option<&LayerHistogram>,
    edit: &mut Edit,
) {
    has_points(ui, "Opacity", super::is_image(function), function, edit);
    let (mode, curves) = match &function.opacity.shape {
        OpacityShape::Curves { interpolation, curves, .. } => (*interpolation, curves.as_slice()),
        OpacityShape::Image(_) => return,
    };
    if state.curve >= curves.len() {
        state.choose(curves.len() - 1);
    }
    let depths: Vec<f64> = curves.iter().map(|c| c.depth).collect();
    if let Some(counts) = counts.filter(|_| !state.settled) {
        let near = |curve: &usize| counts_near(counts, &depths, *curve).1.iter().sum::<u64>();
        state.choose((0..curves.len()).max_by_key(near).unwrap_or(0));
    }
    let chosen = state.curve;
    let points = &curves[chosen].points;
    let set = |edit: &mut Edit, new: crate::transfer::Points<OpacityPoint>| {
        edit.change(function, |f| {
            if let Some(curves) = f.opacity.curves_mut() {
                edit::with_curve(curves, chosen, |points| *points = new);
            }
        });
    };
    ui.horizontal(|ui| {
        ui.strong("Opacity").on_hover_text(
            "Of a layer by its curvature, at one depth. Double-click adds a point, Delete takes it away. Shift locks an axis of \
             a drag, Ctrl makes it fine; Ctrl on empty ground scales the curve.",
        );
        ui.label("at depth");
        let mut depth = curves[chosen].depth;
        if number(ui, &mut depth, 0.0..=1.0, "Depth of the curve", false) {
            edit.change(function, |f| {
                if let Some(curves) = f.opacity.curves_mut() {
                    edit::move_curve(curves, chosen, depth);
                }
            });
        }
        if sign(ui, chosen > 0, "‹", "Nearer curve") {
            state.choose(chosen - 1);
        }
        if sign(ui, chosen + 1 < curves.len(), "›", "Farther curve") {
            state.choose(chosen + 1);
        }
        ui.separator();
        if let Some(to) = interpolation(ui, "Between points of opacity", mode) {
            edit.change(function, |f| {
                f.opacity.set_interpolation(Some(to), None);
            });
        }
        if sign(ui, true, "+", "Add opacity point")
            && let Some(new) = state.gestures.add_somewhere(points, mode)
        {
            set(edit, new);
        }
        let any = !state.gestures.selected.is_empty();
        if sign(ui, any && points.as_slice().len() > 1, "−", "Delete opacity points")
            && let Some(new) = state.gestures.delete(points)
        {
            set(edit, new);
        }
        let selected: Vec<usize> = state.gestures.selected.iter().copied().collect();
        let Some(point) = selected.first().and_then(|i| points.as_slice().get(*i)) else {
            return;
        };
        let (mut kappa, mut opacity) = (point.kappa, point.opacity);
        let one = selected.len() == 1;
        if one {
            ui.label("|κ|");
        }
        let moved = one && number(ui, &mut kappa, 0.0..=1.0, "|κ| of the selected point", false);
        let raised = number(ui, &mut opacity, 0.0..=1.0, "Opacity of the selected points", true);
        if moved || raised {
            let mut new = points.clone();
            for &i in &selected {
                let at = points.as_slice().get(i).map_or(f64::NAN, |p| p.kappa);
                let old = points.as_slice().get(i).map_or(f64::NAN, |p| p.opacity);
                edit::move_to(&mut new, i, if moved { kappa } else { at }, if raised { opacity } else { old });
            }
            set(edit, new);
        }
        if !one {
            ui.weak(format!("{} points", selected.len()));
        }
    });
    let (outer, _) = ui.allocate_exact_size(ui.available_size(), Sense::hover());
    let plot = Plot::within(outer, [0.0, 1.0], [0.0, 1.0]);
    plot.paint_axes(ui, ACROSS, UPWARDS);
    let dark = ui.visuals().dark_mode;
    if let Some(counts) = counts {
        let (all, near) = counts_near(counts, &depths, chosen);
        let full = all.iter().copied().max().unwrap_or(0);
        plot.paint_counts(ui.painter(), &all, full, plot::counted(dark).gamma_multiply(0.28));
        plot.paint_counts(ui.painter(), &near, full, plot::counted(dark).gamma_multiply(0.62));
    }
    let outcome = {
        let accent = ui.visuals().hyperlink_color;
        let faint = ui.visuals().text_color().gamma_multiply(0.3);
        let sampler = function.opacity.sampler();
        let across = |i: usize| plot.samples().map(|k| plot.to_screen([k, sampler.on_curve(i, k)])).collect();
        for i in (0..curves.len()).filter(|&i| i != chosen) {
            line(ui, across(i), 1.0, faint);
        }
        line(ui, across(chosen), 2.0, accent);
        state.gestures.show(ui, &plot, points, mode, "Opacity curve")
    };
    edit.begin |= outcome.begin;
    edit.end |= outcome.end;
    if let Some(new) = outcome.points {
        set(edit, new);
    }
    hovered(ui, &plot, plot.rect);
}

/// What stands under the pointer, in a corner.
fn hovered(ui: &Ui, plot: &Plot, rect: Rect) {
    if let Some(at) = ui.ctx().pointer_hover_pos().filter(|p| rect.contains(*p) && ui.ui_contains_pointer()) {
        let [kappa, opacity] = plot.value_at(at);
        let text = format!("|κ| {kappa:.2}   {:.0} %", opacity * 100.0);
        let font = egui::FontId::proportional(10.5);
        let ink = ui.visuals().text_color();
        ui.painter().text(rect.right_top() + egui::vec2(-4.0, 3.0), egui::Align2::RIGHT_TOP, text, font, ink);
    }
}
