//! One section for each stage of the pipeline, made from the declarations that the command line is made from.
//!
//! A setting is shown as what its range allows: a slider, a list, a switch, text. Its help is its tooltip; beside a value that is
//! not the default stands what puts it back. Whatever is set here goes through [`Settings::set`], so nothing can be set that
//! the command line would refuse.

use std::sync::LazyLock;

use egui::{Align, CollapsingHeader, Color32, ComboBox, DragValue, Layout, RichText, Slider, TextEdit, Ui, vec2};

use crate::app::workspace::{Gravity, Workspace};
use crate::settings::{CaptureKind, Declaration, OpacityModel, Range, Settings, text_at};
use crate::transfer;

static DECLARATIONS: LazyLock<Vec<Declaration>> = LazyLock::new(Settings::declarations);

/// The stages by the first word of their settings' paths, and how they are titled.
pub const STAGES: &[(&str, &str)] = &[
    ("capture", "1  Capture"),
    ("features", "2  Features"),
    ("opacity", "3  Opacity"),
    ("light", "Light"),
    ("outline", "Outline of the selection"),
    ("image", "Picture"),
];

/// What stands over the settings of a stage that have no part in the picture, and are put away there.
pub const PUT_AWAY: &str = "Without effect now";

/// Width of the labels.
const LABELS: f32 = 104.0;
/// Size of an icon.
const ICON: egui::Vec2 = vec2(14.0, 14.0);

/// All stages.
pub fn show(ui: &mut Ui, workspace: &mut Workspace) {
    ui.take_available_width();
    let Some(document) = &mut workspace.document else {
        ui.weak("Settings appear when a model is open.");
        return;
    };
    let settings = &mut document.seen.settings;
    // Once a frame, not once a setting: it writes the whole tree.
    let Ok(values) = toml::Value::try_from(&*settings) else {
        return;
    };
    let mut change = None;
    for (stage, title) in STAGES {
        let open = matches!(*stage, "capture" | "opacity");
        CollapsingHeader::new(RichText::new(*title).strong()).id_salt(stage).default_open(open).show_unindented(
            ui,
            |ui| {
                let of_stage = |d: &&Declaration| d.path.split('.').next() == Some(*stage);
                let (used, idle): (Vec<_>, Vec<_>) =
                    DECLARATIONS.iter().filter(of_stage).partition(|d| matters(settings, &d.path));
                let typing = &mut workspace.layout.typing;
                change = rows(ui, &used, &values, typing).or(change.take());
                if !idle.is_empty() {
                    let title = RichText::new(format!("{PUT_AWAY} ({})", idle.len())).small().weak();
                    CollapsingHeader::new(title).id_salt((stage, "idle")).show_unindented(ui, |ui| {
                        ui.multiply_opacity(0.6);
                        change = rows(ui, &idle, &values, typing).or(change.take());
                    });
                }
                ui.add_space(4.0);
            },
        );
    }
    if let Some((path, text)) = change
        && let Err(reason) = settings.set(path, &text)
    {
        workspace.say(Gravity::Error, reason.to_string());
    }
}

/// Settings one below the other, in their groups; gives the path and new value of one that was changed.
fn rows(
    ui: &mut Ui,
    declarations: &[&'static Declaration],
    values: &toml::Value,
    typing: &mut Option<(String, String)>,
) -> Option<(&'static str, String)> {
    let mut change = None;
    let mut group = String::new();
    for declaration in declarations {
        let words: Vec<&str> = declaration.path.split('.').collect();
        let inner = words[1..words.len() - 1].join(".");
        if inner != group {
            ui.add_space(2.0);
            ui.label(RichText::new(title_of(&inner)).small().weak());
            group = inner;
        }
        let Some(value) = words.iter().try_fold(values, |at, key| at.get(*key)) else {
            continue;
        };
        if let Some(text) = row(ui, declaration, value, typing) {
            change = Some((declaration.path.as_str(), text));
        }
    }
    change
}

/// Whether a setting has any part in the picture, given the others. What has none is put away and dimmed, not locked.
fn matters(settings: &Settings, path: &str) -> bool {
    let base = settings.opacity.base_model();
    let illustrated = settings.opacity.model == OpacityModel::Illustrative;
    let stylized = base == OpacityModel::Curvature;
    match path {
        "opacity.constant" => base == OpacityModel::Constant,
        "opacity.adaptive" => base == OpacityModel::Adaptive,
        _ if path.starts_with("opacity.angle.") => base == OpacityModel::AngleBased,
        _ if path.starts_with("opacity.variation.") => base == OpacityModel::NormalVariation,
        _ if path.starts_with("opacity.equal_share.") => base == OpacityModel::EqualShare,
        _ if path.starts_with("opacity.illustrative.") => illustrated,
        _ if path.starts_with("capture.linked_list.") => settings.capture.kind == CaptureKind::LinkedList,
        _ if path.starts_with("features.curvature.") => stylized,
        "opacity.transfer" | "opacity.gain" => stylized,
        _ if path.starts_with("capture.bucketed_k_buffer.") => settings.capture.kind == CaptureKind::BucketedKBuffer,
        _ if path.starts_with("features.") => stylized || illustrated || base == OpacityModel::NormalVariation,
        _ => true,
    }
}

/// `crease_angle` as *Crease angle*.
pub fn title_of(word: &str) -> String {
    let spaced = word.rsplit('.').next().unwrap_or(word).replace('_', " ");
    let mut letters = spaced.chars();
    letters.next().map(|first| first.to_uppercase().chain(letters).collect()).unwrap_or_default()
}

/// A setting in a line; gives its new value as text if it was changed.
fn row(
    ui: &mut Ui,
    declaration: &Declaration,
    value: &toml::Value,
    typing: &mut Option<(String, String)>,
) -> Option<String> {
    let title = title_of(&declaration.path);
    let mut next = None;
    ui.horizontal(|ui| {
        let (rect, label) = ui.allocate_exact_size(vec2(LABELS, ui.spacing().interact_size.y), egui::Sense::hover());
        let help = format!("{}\n\n{} · {}", declaration.help, declaration.path, declaration.range);
        let changed = *value != declaration.default;
        let text = RichText::new(&title);
        let text = if changed { text.strong() } else { text };
        let mut within =
            ui.new_child(egui::UiBuilder::new().max_rect(rect).layout(Layout::left_to_right(Align::Center)));
        let label_id = within.add(egui::Label::new(text).truncate()).id;
        label.on_hover_text(&help);
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            if changed {
                let back = put_back(ui).on_hover_text(format!("Back to {}", declaration.default));
                let named = format!("Reset {title}");
                back.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, &named));
                if back.clicked() {
                    next = text_at(&Settings::default(), &declaration.path);
                }
            } else {
                ui.allocate_exact_size(ICON, egui::Sense::hover());
            }
            ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                if let Some(text) = control(ui, declaration, value, label_id, typing, &title) {
                    next = Some(text);
                }
            });
        });
    });
    next
}

/// An arrow that turns back: the font has none.
fn put_back(ui: &mut Ui) -> egui::Response {
    let (rect, response) = ui.allocate_exact_size(ICON, egui::Sense::click());
    let stroke = egui::Stroke::new(1.3, ui.style().interact(&response).fg_stroke.color);
    let center = rect.center();
    let at = |turn: f32| center + 4.0 * egui::Vec2::angled(turn * std::f32::consts::TAU);
    let arc: Vec<egui::Pos2> = (0..=12).map(|i| at(-0.45 + 0.75 * i as f32 / 12.0)).collect();
    let head = arc[0];
    ui.painter().add(egui::Shape::line(arc, stroke));
    ui.painter().line_segment([head, head + vec2(0.5, -3.5)], stroke);
    ui.painter().line_segment([head, head + vec2(3.5, -0.2)], stroke);
    response
}

fn control(
    ui: &mut Ui,
    declaration: &Declaration,
    value: &toml::Value,
    label: egui::Id,
    typing: &mut Option<(String, String)>,
    title: &str,
) -> Option<String> {
    // A long number takes from the slider, not from what puts it back.
    let number = 8.0 * value.to_string().len().min(12) as f32 + 16.0 + ui.spacing().item_spacing.x;
    let room = (ui.available_width() - number).max(24.0);
    ui.spacing_mut().slider_width = ui.spacing().slider_width.min(room);
    match declaration.range {
        Range::Integer(least, most) => {
            let mut n = value.as_integer()?;
            let slider = Slider::new(&mut n, least..=most).logarithmic(most - least > 200).show_value(false);
            let moved = ui.add(slider).labelled_by(label).changed();
            let drag = DragValue::new(&mut n).range(least..=most).speed(0.1);
            let typed = ui.add(drag).labelled_by(label).changed();
            (moved || typed).then(|| n.to_string())
        }
        Range::Real(least, most) => {
            let mut x = value.as_float()?;
            let usual = declaration.default.as_float().unwrap_or(most);
            // A range that reaches far beyond the usual is finer near zero.
            let far = most / usual.abs().max(1e-9) > 12.0;
            let smallest = if usual > 0.0 { usual / 50.0 } else { most / 1000.0 };
            let slider = Slider::new(&mut x, least..=most)
                .logarithmic(far)
                .smallest_positive(smallest)
                .smart_aim(true)
                .show_value(false);
            let moved = ui.add(slider).labelled_by(label).changed();
            if moved {
                // Three digits are as much as a slider can mean.
                x = three_digits(x).clamp(least, most);
            }
            let speed = (x.abs() * 0.01).max(smallest * 0.5);
            let drag = DragValue::new(&mut x).range(least..=most).speed(speed).max_decimals(6);
            let typed = ui.add(drag).labelled_by(label).changed();
            (moved || typed).then(|| x.to_string())
        }
        Range::Switch => {
            let mut on = value.as_bool()?;
            ui.add(egui::Checkbox::without_text(&mut on)).labelled_by(label).changed().then(|| on.to_string())
        }
        Range::Choice(names) => {
            let mut chosen = value.as_str()?.to_owned();
            list(ui, declaration, &mut chosen, names, label)
        }
        Range::Text if declaration.path == "opacity.transfer" => {
            let names = transfer::names();
            match value.as_str() {
                Some(name) => list(ui, declaration, &mut name.to_owned(), &names, label),
                None => {
                    ui.weak("edited");
                    None
                }
            }
        }
        Range::Text | Range::Color { .. } => text(ui, declaration, value, label, typing, title),
    }
}

fn list(
    ui: &mut Ui,
    declaration: &Declaration,
    chosen: &mut String,
    names: &[&str],
    label: egui::Id,
) -> Option<String> {
    let before = chosen.clone();
    let width = ui.available_width().min(190.0);
    let response = ComboBox::from_id_salt(&declaration.path)
        .width(width)
        .selected_text(chosen.replace('_', " "))
        .show_ui(ui, |ui| {
            for name in names {
                ui.selectable_value(chosen, (*name).to_owned(), name.replace('_', " "));
            }
        })
        .response;
    response.labelled_by(label);
    (*chosen != before).then(|| chosen.clone())
}

/// Text is taken over when it is entered, not at every key; a colour has a picker beside it.
fn text(
    ui: &mut Ui,
    declaration: &Declaration,
    value: &toml::Value,
    label: egui::Id,
    typing: &mut Option<(String, String)>,
    title: &str,
) -> Option<String> {
    let current = value.as_str()?.to_owned();
    let mut next = None;
    if let Some(rgb) = color_of(&current) {
        let mut rgb = rgb;
        let picker = ui.color_edit_button_srgb(&mut rgb);
        picker.widget_info(|| egui::WidgetInfo::labeled(egui::Role::ColorWell, true, format!("Pick {title}")));
        if picker.changed() {
            next = Some(format!("#{:02x}{:02x}{:02x}", rgb[0], rgb[1], rgb[2]));
        }
    }
    let mut shown = match typing {
        Some((path, typed)) if *path == declaration.path => typed.clone(),
        _ => current.clone(),
    };
    let width = (ui.available_width() - 2.0).clamp(40.0, 120.0);
    let edit = ui.add(TextEdit::singleline(&mut shown).desired_width(width)).labelled_by(label);
    if edit.lost_focus() {
        *typing = None;
        if shown != current && !ui.input(|i| i.key_pressed(egui::Key::Escape)) {
            next = Some(shown);
        }
    } else if edit.has_focus() {
        *typing = Some((declaration.path.clone(), shown));
    }
    next
}

fn color_of(text: &str) -> Option<[u8; 3]> {
    let color = Color32::from_hex(text).ok().filter(|_| text.len() == 7)?;
    Some([color.r(), color.g(), color.b()])
}

fn three_digits(x: f64) -> f64 {
    if x == 0.0 || !x.is_finite() {
        return x;
    }
    let scale = 10_f64.powi(2 - x.abs().log10().floor() as i32);
    (x * scale).round() / scale
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_setting_belongs_to_a_stage() {
        for d in DECLARATIONS.iter() {
            assert!(STAGES.iter().any(|(stage, _)| d.path.starts_with(&format!("{stage}."))), "{}", d.path);
        }
        assert_eq!(title_of("features.curvature.crease_angle"), "Crease angle");
    }

    #[test]
    fn sliders_mean_three_digits() {
        assert_eq!(three_digits(0.012_345), 0.0123);
        assert_eq!(three_digits(1234.0), 1230.0);
        assert_eq!(three_digits(0.0), 0.0);
    }
}
