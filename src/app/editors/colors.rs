//! Colour over κ.

use egui::{Color32, Mesh, Rect, Role, Sense, Ui, WidgetInfo, pos2};

use super::gestures::{Gestures, Handle};
use super::plot::{self, Plot, Tick};
use super::{Edit, colour, has_points, interpolation, line, number, sign};
use crate::render::LayerHistogram;
use crate::transfer::edit::{self, EditPoint};
use crate::transfer::{ColorMode, ColorPoint, ColorShape, Points, TransferFunction};

const ACROSS: &[Tick] = &[(-1.0, "κ −1 convex"), (-0.5, "−0.5"), (0.0, "0 flat"), (0.5, "0.5"), (1.0, "1 concave")];
const UPWARDS: &[Tick] = &[(0.0, "black"), (0.5, "as lit"), (1.0, "white")];
const UPWARDS_TIMES: &[Tick] = &[(0.0, "black"), (0.5, "as lit"), (1.0, "× 2")];
/// Height of the strip of colours above the plot.
const STRIP: f32 = 12.0;

/// What is selected.
#[derive(Default)]
pub struct State {
    /// On the curve.
    pub gestures: Gestures<ColorPoint>,
}

impl State {
    /// Selected points.
    pub fn selected(&self) -> Vec<usize> {
        self.gestures.selected.iter().copied().collect()
    }
}

/// The editor of the colour function.
pub fn show(
    ui: &mut Ui,
    state: &mut State,
    function: &TransferFunction,
    counts: Option<&LayerHistogram>,
    edit: &mut Edit,
) {
    let set = |edit: &mut Edit, new: Points<ColorPoint>| {
        edit.change(function, |f| {
            if let Some((_, points)) = f.color.points_mut() {
                *points = new;
            }
        });
    };
    has_points(ui, "Colour", super::is_strip(function), function, edit);
    if let ColorShape::Points { interpolation: mode, points } = &function.color.shape {
        ui.horizontal(|ui| {
            ui.strong("Colour").on_hover_text(
                "What the lit colour of a layer becomes by its curvature: in the middle it stays as it is. A point is drawn at \
                 the mean of its channels.",
            );
            if let Some(to) = interpolation(ui, "Between points of colour", *mode) {
                edit.change(function, |f| {
                    f.color.set_interpolation(to);
                });
            }
            let tint = function.color.mode == ColorMode::Tint;
            let acts = ui.selectable_label(!tint, "× 2").on_hover_text(
                "Multiply: up to twice as bright, instead of towards white",
            );
            acts.widget_info(|| WidgetInfo::selected(Role::CheckBox, true, !tint, "Multiply"));
            if acts.clicked() {
                let to = if tint { ColorMode::Multiply } else { ColorMode::Tint };
                edit.change(function, |f| f.color.mode = to);
            }
            if sign(ui, true, "+", "Add colour point")
                && let Some(new) = state.gestures.add_somewhere(points, *mode)
            {
                set(edit, new);
            }
            let any = !state.gestures.selected.is_empty();
            if sign(ui, any && points.as_slice().len() > 1, "−", "Delete colour points")
                && let Some(new) = state.gestures.delete(points)
            {
                set(edit, new);
            }
            if let Some(new) = entries(ui, &state.selected(), points) {
                set(edit, new);
            }
        });
    }
    let (outer, _) = ui.allocate_exact_size(ui.available_size(), Sense::hover());
    let plot = Plot::within(outer.with_min_y(outer.top() + STRIP), [-1.0, 1.0], [0.0, 1.0]);
    let upwards = if function.color.mode == ColorMode::Tint { UPWARDS } else { UPWARDS_TIMES };
    plot.paint_axes(ui, ACROSS, upwards);
    strip(ui, Rect::from_x_y_ranges(plot.rect.x_range(), outer.top()..=outer.top() + STRIP), function);
    let dark = ui.visuals().dark_mode;
    if let Some(counts) = counts {
        let full = counts.kappa.iter().copied().max().unwrap_or(0);
        plot.paint_counts(ui.painter(), &counts.kappa, full, plot::counted(dark).gamma_multiply(0.45));
    }
    let color_at = function.color.sampler();
    let values: Vec<(f64, [f64; 3])> = plot.samples().map(|k| (k, color_at(k))).collect();
    let channels =
        [Color32::from_rgb(0xe0, 0x50, 0x50), Color32::from_rgb(0x40, 0xb0, 0x60), Color32::from_rgb(0x50, 0x80, 0xf0)];
    if values.iter().any(|(_, [r, g, b])| r != g || g != b) {
        for (c, ink) in channels.into_iter().enumerate() {
            line(ui, values.iter().map(|(k, v)| plot.to_screen([*k, v[c]])).collect(), 1.0, ink);
        }
    }
    let mean = values.iter().map(|(k, v)| plot.to_screen([*k, <ColorPoint as Handle>::height(*v)])).collect();
    line(ui, mean, 2.0, ui.visuals().hyperlink_color);
    if let ColorShape::Points { interpolation: mode, points } = &function.color.shape {
        let outcome = state.gestures.show(ui, &plot, points, *mode, "Colour curve");
        edit.begin |= outcome.begin;
        edit.end |= outcome.end;
        if let Some(new) = outcome.points {
            set(edit, new);
        }
    }
}

/// Numbers and the colour of the selected points.
fn entries(ui: &mut Ui, selected: &[usize], points: &Points<ColorPoint>) -> Option<Points<ColorPoint>> {
    let point = *points.as_slice().get(*selected.first()?)?;
    let (mut kappa, mut rgb) = (point.kappa, point.value());
    let one = selected.len() == 1;
    if one {
        ui.label("κ");
    }
    let moved = one && number(ui, &mut kappa, -1.0..=1.0, "κ of the selected point", false);
    let mut bytes = colour(rgb).to_array();
    let mut shown = [bytes[0], bytes[1], bytes[2]];
    let picker = ui.color_edit_button_srgb(&mut shown);
    picker.widget_info(|| WidgetInfo::labeled(Role::ColorWell, true, "Pick the colour of the selected points"));
    let mut recoloured = false;
    for (c, byte) in shown.into_iter().enumerate() {
        // Only what was picked: a byte holds less than a number.
        if byte != bytes[c] {
            bytes[c] = byte;
            rgb[c] = f64::from(byte) / 255.0;
            recoloured = true;
        }
    }
    let mut grey = <ColorPoint as Handle>::height(rgb);
    let before = grey;
    if number(ui, &mut grey, 0.0..=1.0, "Brightness of the selected points", false) {
        rgb = <ColorPoint as Handle>::raised(rgb, grey - before);
        recoloured = true;
    }
    if !one {
        ui.weak(format!("{} points", selected.len()));
    }
    if !moved && !recoloured {
        return None;
    }
    let mut new = points.clone();
    for &i in selected {
        let old = points.as_slice().get(i)?;
        let to = if moved { kappa } else { old.kappa };
        edit::move_to(&mut new, i, to, if recoloured { rgb } else { old.value() });
    }
    Some(new)
}

/// The colours themselves.
pub fn strip(ui: &Ui, rect: Rect, function: &TransferFunction) {
    const PIECES: u32 = 96;
    let mut mesh = Mesh::default();
    let color_at = function.color.sampler();
    for i in 0..=PIECES {
        let share = i as f32 / PIECES as f32;
        let color = colour(color_at(2.0 * f64::from(share) - 1.0));
        let x = rect.left() + share * rect.width();
        mesh.colored_vertex(pos2(x, rect.top()), color);
        mesh.colored_vertex(pos2(x, rect.bottom() - 2.0), color);
        if i > 0 {
            let v = 2 * i;
            mesh.add_triangle(v - 2, v - 1, v);
            mesh.add_triangle(v - 1, v + 1, v);
        }
    }
    ui.painter().add(egui::Shape::mesh(mesh));
}
