//! The transfer-function editors: colour over κ, opacity over depth and |κ|, on egui's painter.
//!
//! What can be done to points is in [`crate::transfer::edit`], which keeps every function sound whatever it is asked for; here
//! pointer and keys become calls of it ([`gestures`]). A named function is copied into the settings by the first change, and
//! keeps its name for people to read ("pellucid, edited"). Every gesture is one step of undo.
//!
//! The opacity function is edited a curve at a time: the curve of the chosen depth over |κ|, the others faint behind it. The
//! small map beside it shows the whole function, depth to the right and |κ| upwards, with a handle for each curve. Behind all of
//! them, in orange, stand the layers of the picture: where they are is where an edit does anything.

pub mod colors;
pub mod gestures;
pub mod map;
pub mod opacities;
pub mod plot;
mod presets;
#[cfg(test)]
mod tests;

use std::sync::Arc;

use egui::{Color32, ComboBox, Layout, RichText, Ui, vec2};

use crate::app::dialogs::Choice;
use crate::app::workspace::{Ask, Gravity, Workspace};
use crate::render::LayerHistogram;
use crate::settings::OpacityModel;
use crate::transfer::{ColorShape, Format, Interpolation, OpacityShape, TransferFunction, TransferSource, formats};

/// Width of the editors side by side, points, at which all that is above their curves fits.
const LEAST_WIDTH: f32 = 960.0;

/// Width of the name of the functions, points.
const NAME_WIDTH: f32 = 116.0;

/// What the editors keep for themselves.
#[derive(Default)]
pub struct State {
    pub(super) opacities: opacities::State,
    pub(super) colors: colors::State,
    pub(super) map: map::State,
    presets: presets::State,
}

impl State {
    /// All textures are gone, with the device: thumbnails and map are painted again.
    pub fn forget_textures(&mut self) {
        self.presets = presets::State::default();
        self.map.forget_textures();
    }
}

/// What an editor did in a frame.
#[derive(Default)]
pub struct Edit {
    /// The functions as they are now, if anything changed.
    pub function: Option<TransferFunction>,
    /// A gesture begins before that.
    pub begin: bool,
    /// It ends after it.
    pub end: bool,
}

impl Edit {
    /// A change of a copy of the functions.
    fn change(&mut self, of: &TransferFunction, change: impl FnOnce(&mut TransferFunction)) {
        change(self.function.get_or_insert_with(|| of.clone()));
    }
}

/// Both editors, presets, files.
pub fn show(ui: &mut Ui, workspace: &mut Workspace) {
    ui.take_available_space();
    // Where the window is narrower than the three are, they are scrolled to.
    let width = ui.available_width();
    egui::ScrollArea::horizontal().auto_shrink(false).show(ui, |ui| {
        ui.set_width(width.max(LEAST_WIDTH));
        contents(ui, workspace);
    });
}

fn contents(ui: &mut Ui, workspace: &mut Workspace) {
    let Some(resolved) = workspace.transfer() else {
        ui.weak("Transfer functions appear when a model is open.");
        return;
    };
    ui.add_space(3.0);
    toolbar(ui, workspace, resolved.as_deref().ok());
    let function = match resolved {
        Ok(function) => function,
        Err(reason) => {
            ui.colored_label(ui.visuals().error_fg_color, reason);
            return;
        }
    };
    let number = workspace.scene_number;
    let counts = workspace.counts.as_ref().filter(|c| c.scene_number == number).map(|c| Arc::clone(&c.layers));
    // A state that is put back by undo, or another function: whatever is under way is about points that are gone.
    let state = &mut workspace.layout.editors;
    let gesture = workspace.document.as_ref().is_some_and(|d| d.in_gesture());
    if !gesture {
        state.opacities.gestures.abandon_busy();
        state.colors.gestures.abandon_busy();
        state.map.abandon_busy();
    }
    let mut edit = Edit::default();
    let (width, height) = (ui.available_width(), ui.available_height().max(60.0));
    let gap = ui.spacing().item_spacing.x;
    let map_width = (height * 1.1).clamp(120.0, 0.24 * width);
    let rest = width - map_width - 4.0 * gap;
    let parts = [rest * 0.53, map_width, rest * 0.47];
    ui.horizontal_top(|ui| {
        ui.spacing_mut().item_spacing.x = 2.0 * gap;
        let column = |ui: &mut Ui, width: f32, show: &mut dyn FnMut(&mut Ui)| {
            ui.allocate_ui_with_layout(vec2(width, height), Layout::top_down(egui::Align::Min), |ui| {
                ui.set_width(width);
                ui.spacing_mut().item_spacing.x = gap;
                show(ui);
            });
        };
        column(ui, parts[0], &mut |ui| {
            opacities::show(ui, &mut state.opacities, &function, counts.as_deref(), &mut edit);
        });
        column(ui, parts[1], &mut |ui| {
            map::show(ui, &mut state.map, &mut state.opacities, &function, counts.as_deref(), &mut edit);
        });
        column(ui, parts[2], &mut |ui| {
            colors::show(ui, &mut state.colors, &function, counts.as_deref(), &mut edit);
        });
    });
    let is_over = edit.end && ui.input(|i| i.key_pressed(egui::Key::Escape));
    edit.end &= !is_over;
    apply(workspace, edit);
    if is_over && let Some(document) = &mut workspace.document {
        document.abandon_gesture();
    }
}

/// Puts an edit into the document.
fn apply(workspace: &mut Workspace, edit: Edit) {
    let Some(document) = &mut workspace.document else {
        return;
    };
    if edit.begin {
        document.begin_gesture();
    }
    if let Some(mut function) = edit.function {
        let source = &mut document.seen.settings.opacity.transfer;
        if let TransferSource::Named(name) = source {
            function.name = Some(file_name(name).to_owned());
        }
        let error = function.make_editable();
        *source = TransferSource::Inline(Box::new(function));
        if error > 0.0 {
            let text = format!("The image has become control points, within {:.1} % of it.", 100.0 * error);
            workspace.say(Gravity::Notice, text);
        }
    }
    if edit.end
        && let Some(document) = &mut workspace.document
    {
        document.end_gesture();
    }
}

/// Uses the functions in a file; the file stays theirs until they are edited, and is read again when it changes.
pub fn import(workspace: &mut Workspace, path: &str) {
    // A name without a folder or an ending would be one of ours.
    let named = if path.contains(['/', '\\', '.']) { path.to_owned() } else { format!("./{path}") };
    let source = TransferSource::Named(named);
    match (workspace.functions.of(&source), &mut workspace.document) {
        (Ok(_), Some(document)) => {
            document.settle();
            document.seen.settings.opacity.transfer = source;
            document.seen.settings.opacity.follow_transfer();
            document.settle();
        }
        (Err(reason), _) => workspace.say(Gravity::Error, reason),
        (Ok(_), None) => workspace.say(Gravity::Note, "Open a model first."),
    }
}

/// The functions as a file of the format that `path` ends with.
///
/// # Errors
/// A sentence for the user.
pub fn export(workspace: &mut Workspace, path: &str) -> Result<Vec<u8>, String> {
    let function = workspace.transfer().ok_or("there is no model")??;
    let source = workspace.document.as_ref().map(|d| d.seen.settings.opacity.transfer.clone()).unwrap_or_default();
    let endings = || Format::ALL.map(|f| format!(".{}", f.extension())).join(", ");
    let format =
        Format::of_path(path.as_ref()).ok_or_else(|| format!("a name has to end with one of {}", endings()))?;
    let exported = formats::write(&function, format, &title(&source)).map_err(|e| e.to_string())?;
    for notice in exported.notices {
        workspace.say(Gravity::Notice, notice);
    }
    Ok(exported.bytes)
}

fn file_name(path: &str) -> &str {
    path.rsplit(['/', '\\']).next().unwrap_or(path)
}

/// What the functions are called.
pub fn title(source: &TransferSource) -> String {
    match source {
        TransferSource::Named(name) => file_name(name).to_owned(),
        TransferSource::Inline(function) => {
            function.name.as_ref().map_or_else(|| "edited".to_owned(), |name| format!("{name}, edited"))
        }
    }
}

fn toolbar(ui: &mut Ui, workspace: &mut Workspace, function: Option<&TransferFunction>) {
    let mut wanted = None;
    ui.horizontal_wrapped(|ui| {
        // As high as the thumbnails, so that words stand in their middle.
        ui.set_min_height(30.0);
        if let Some(document) = &mut workspace.document {
            let settings = &mut document.seen.settings;
            // As wide whatever the name is: the buttons beside it stay where they are.
            let name = egui::Label::new(RichText::new(title(&settings.opacity.transfer)).strong()).truncate();
            ui.allocate_ui_with_layout(vec2(NAME_WIDTH, 30.0), Layout::left_to_right(egui::Align::Center), |ui| {
                ui.set_min_width(NAME_WIDTH);
                ui.add(name);
            });
            ui.separator();
            wanted = presets::show(ui, &mut workspace.layout.editors.presets, &settings.opacity.transfer);
            ui.separator();
            if settings.opacity.base_model() != OpacityModel::Curvature {
                let name = settings.opacity.base_model().name();
                ui.label(format!("Opacity is {name}: these functions are not in use."));
                if ui.button("Use them").clicked() {
                    settings.opacity.follow_transfer();
                }
            }
        }
        if ui.button("Import…").on_hover_text("TOML, PNG, ParaView JSON or XML, 3D Slicer vp, CSV").clicked() {
            workspace.asks.push(Ask::Choose(Choice::ImportTransfer));
        }
        let export = ui.add_enabled(function.is_some(), egui::Button::new("Export…"));
        if export.on_hover_text("The ending of the name chooses the format").clicked() {
            workspace.asks.push(Ask::Choose(Choice::ExportTransfer));
        }
        ui.separator();
        super::compare::buttons(ui, workspace);
    });
    if let (Some(name), Some(document)) = (wanted, &mut workspace.document) {
        document.seen.settings.opacity.transfer = TransferSource::Named(name.to_owned());
        document.seen.settings.opacity.follow_transfer();
    }
}

/// A value of the colour function on the screen: its numbers are bytes over 255.
pub(super) fn colour(rgb: [f64; 3]) -> Color32 {
    let [r, g, b] = rgb.map(|v| (v.clamp(0.0, 1.0) * 255.0).round() as u8);
    Color32::from_rgb(r, g, b)
}

/// A list of what may lie between points.
fn interpolation(ui: &mut Ui, label: &str, now: Interpolation) -> Option<Interpolation> {
    let word = |mode| match mode {
        Interpolation::Step => "step",
        Interpolation::Linear => "linear",
        Interpolation::Monotone => "smooth",
    };
    let mut chosen = now;
    let list = ComboBox::from_id_salt(label).width(64.0).selected_text(word(now));
    let list = list.show_ui(ui, |ui| {
        for mode in [Interpolation::Step, Interpolation::Linear, Interpolation::Monotone] {
            let choice = ui.selectable_value(&mut chosen, mode, word(mode));
            if mode == Interpolation::Monotone {
                choice.on_hover_text("A monotone cubic: smooth, and never beyond its points");
            }
        }
    });
    list.response.on_hover_text(label).accessible_name(label);
    (chosen != now).then_some(chosen)
}

/// Whether there are points to edit; if not, a way to get them.
fn has_points(ui: &mut Ui, what: &str, image: bool, function: &TransferFunction, edit: &mut Edit) -> bool {
    if image {
        ui.horizontal(|ui| {
            ui.label(format!("{what} from an image."));
            if ui.button("Edit as points").accessible_name(format!("Edit {what} as points")).clicked() {
                edit.change(function, |_| {});
            }
        });
    }
    !image
}

fn is_strip(function: &TransferFunction) -> bool {
    matches!(function.color.shape, ColorShape::Strip(_))
}

fn is_image(function: &TransferFunction) -> bool {
    matches!(function.opacity.shape, OpacityShape::Image(_))
}

/// A number to be typed or dragged, which changes when it is entered.
fn number(ui: &mut Ui, value: &mut f64, range: std::ops::RangeInclusive<f64>, label: &str, percent: bool) -> bool {
    let drag = egui::DragValue::new(value).range(range).update_while_editing(false);
    let drag = if percent {
        drag.speed(0.003)
            .custom_formatter(|v, _| format!("{:.1} %", v * 100.0))
            .custom_parser(|text| text.trim().trim_end_matches('%').trim().parse::<f64>().ok().map(|v| v / 100.0))
    } else {
        drag.speed(0.003).min_decimals(2).max_decimals(4)
    };
    ui.add(drag).accessible_name(label).on_hover_text(label).changed()
}

/// A small button with a sign, and its name for those who cannot see it.
fn sign(ui: &mut Ui, enabled: bool, text: &str, label: &str) -> bool {
    let button = ui.add_enabled(enabled, egui::Button::new(text).min_size(vec2(22.0, 0.0)));
    let button = button.on_hover_text(label);
    button.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, enabled, label));
    button.clicked()
}

/// Paints a curve through places on the screen.
fn line(ui: &Ui, points: Vec<egui::Pos2>, width: f32, color: Color32) {
    ui.painter().add(egui::Shape::line(without_straight(&points), egui::Stroke::new(width, color)));
}

/// Farthest that a drawn curve may be from the sampled one, points of the screen.
const STRAIGHT: f32 = 0.08;

/// A curve without the points between which it is straight. On a software rasterizer the curves of an editor would otherwise
/// take as long as the picture.
fn without_straight(points: &[egui::Pos2]) -> Vec<egui::Pos2> {
    let Some(&first) = points.first() else {
        return Vec::new();
    };
    let (mut kept, mut begin) = (vec![first], 0);
    for end in 2..points.len() {
        let (from, way) = (points[begin], points[end] - points[begin]);
        let off = |p: &egui::Pos2| (way.x * (p.y - from.y) - way.y * (p.x - from.x)).abs();
        if points[begin + 1..end].iter().any(|p| off(p) > STRAIGHT * way.length()) {
            begin = end - 1;
            kept.push(points[begin]);
        }
    }
    kept.extend(points.iter().skip(1).last());
    kept
}

/// Layers over |κ| of all depths, and of those that are nearer to one curve than to any other.
fn counts_near(counts: &LayerHistogram, depths: &[f64], chosen: usize) -> (Vec<u64>, Vec<u64>) {
    let [columns, rows] = counts.map.size();
    let nearest = |x: usize| {
        let depth = (x as f64 + 0.5) / columns as f64;
        (0..depths.len()).min_by(|a, b| (depths[*a] - depth).abs().total_cmp(&(depths[*b] - depth).abs()))
    };
    let near: Vec<bool> = (0..columns).map(|x| nearest(x) == Some(chosen)).collect();
    let row = |y: usize| (0..columns).filter(|x| near[*x]).map(|x| counts.map.count(x, y)).sum();
    (counts.map.over_kappa(), (0..rows).map(row).collect())
}
