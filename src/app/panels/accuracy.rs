//! The accuracy panel: what is wrong in the picture, by how much, and what it would cost to have it right.

use egui::{Button, CollapsingHeader, DragValue, Grid, Label, ProgressBar, RichText, ScrollArea, Ui, WidgetInfo, vec2};

use super::{diagram, plan, status, style};
use crate::app::accuracy::overlay::Overlay;
use crate::app::accuracy::{Plotted, SECONDS, SIDES, Shows, Wanted};
use crate::app::workspace::{Ask, Workspace};
use crate::tradeoff::budget::Goal;
use crate::tradeoff::image_error::ImageError;
use crate::tradeoff::table::figure;

/// Height of the table of passes, points.
const PASSES: f32 = 150.0;

/// The panel.
pub fn show(ui: &mut Ui, workspace: &mut Workspace) {
    ui.take_available_width();
    if workspace.document.is_none() {
        ui.weak("Figures appear when a model is open.");
        return;
    }
    case(ui, workspace);
    section(ui, "This picture", |ui| picture(ui, workspace));
    section(ui, "Against the reference", |ui| reference(ui, workspace));
    section(ui, "Time against error", |ui| sweep(ui, workspace));
    section(ui, "Budget", |ui| budget(ui, workspace));
}

fn section(ui: &mut Ui, title: &str, contents: impl FnOnce(&mut Ui)) {
    CollapsingHeader::new(RichText::new(title).strong()).default_open(true).show_unindented(ui, |ui| {
        contents(ui);
        ui.add_space(6.0);
    });
}

fn small(ui: &mut Ui, text: impl Into<String>) {
    ui.add(Label::new(RichText::new(text).small()).wrap());
}

/// In a grid, whose columns are as wide as what is in them.
fn cell(ui: &mut Ui, text: impl Into<String>) {
    ui.add(Label::new(RichText::new(text).small()).extend());
}

fn weak(ui: &mut Ui, text: impl Into<String>) {
    ui.add(Label::new(RichText::new(text).small().weak()).wrap());
}

fn notice(ui: &mut Ui, text: impl Into<String>) {
    let color = ui.visuals().warn_fg_color;
    ui.add(Label::new(RichText::new(text).small().color(color)).wrap());
}

/// The hard case that is open.
fn case(ui: &mut Ui, workspace: &Workspace) {
    let Some(case) = &workspace.accuracy.case else {
        return;
    };
    section(ui, "Hard case", |ui| {
        ui.strong(case.name);
        weak(ui, case.why);
        let [width, height] = case.size;
        weak(ui, format!("Measured at {width}×{height} pixels: {}. The window draws it at its own size.", case.bound));
        match &case.contrast {
            Ok(words) => small(ui, format!("Left of the divider {words}; right of it ours.")),
            Err(reason) => notice(ui, reason),
        }
    });
}

/// Of the last exact picture: what each pass took, and what became of the layers.
fn picture(ui: &mut Ui, workspace: &Workspace) {
    let Some((seen, report)) = &workspace.report else {
        weak(ui, "There is no exact picture yet.");
        return;
    };
    if workspace.document.as_ref().is_some_and(|d| d.seen != *seen) {
        weak(ui, "Of the last exact picture, before the view or a setting changed:");
    }
    ui.horizontal_wrapped(|ui| status::layers(ui, report));
    let longest = report.passes.iter().map(|p| p.milliseconds).fold(0.0, f64::max);
    let sum = report.passes.iter().map(|p| p.milliseconds).sum();
    ui.horizontal(|ui| {
        ui.label(format!("{} ms", plan::milliseconds(report.milliseconds)));
        ui.weak(format!("{} of it in passes", plan::milliseconds(sum)));
    });
    let table = |ui: &mut Ui| {
        for pass in &report.passes {
            cell(ui, pass.pass.name());
            let (rect, _) = ui.allocate_exact_size(vec2(84.0, 9.0), egui::Sense::hover());
            let share = if longest > 0.0 { (pass.milliseconds / longest) as f32 } else { 0.0 };
            let bar = egui::Rect::from_min_size(rect.min, vec2((rect.width() * share).max(1.0), rect.height()));
            ui.painter().rect_filled(bar, 1.0, ui.visuals().selection.bg_fill);
            cell(ui, format!("{} ms", plan::milliseconds(pass.milliseconds)));
            ui.end_row();
        }
    };
    // As high whatever runs: another setting is not to move what is below away from under the pointer.
    ScrollArea::vertical()
        .id_salt("passes")
        .max_height(PASSES)
        .min_scrolled_height(PASSES)
        .auto_shrink(false)
        .show(ui, |ui| Grid::new("pass times").num_columns(3).spacing([8.0, 1.0]).show(ui, table));
}

/// What is over the picture, and how far the picture is off.
fn reference(ui: &mut Ui, workspace: &mut Workspace) {
    ui.horizontal(|ui| {
        for overlay in Overlay::ALL {
            let help = match overlay {
                Overlay::Off => "The picture alone",
                Overlay::Difference => "Its difference to the reference in false colours, left of a divider",
                Overlay::Reference => "The reference, left of a divider",
            };
            let on = workspace.accuracy.overlay == overlay;
            let button = ui.add(Button::selectable(on, overlay.name())).on_hover_text(help);
            let label = format!("Overlay: {}", overlay.name());
            button.widget_info(|| WidgetInfo::selected(egui::Role::Button, true, on, &label));
            if button.clicked() {
                workspace.accuracy.overlay = overlay;
                workspace.asks.push(Ask::Redraw);
            }
        }
        let off = workspace.accuracy.overlay == Overlay::Off;
        let help = "Draws the reference of this view once: every fragment, full precision, exact order";
        if ui.add_enabled(off, Button::new("Compare once")).on_hover_text(help).clicked() {
            workspace.accuracy.once = true;
            workspace.asks.push(Ask::Redraw);
        }
    });
    let wanted = workspace.accuracy.overlay != Overlay::Off || workspace.accuracy.once;
    let fault = workspace.accuracy.fault.as_ref().filter(|(number, _)| *number == workspace.order);
    let current = workspace.referenced().is_some();
    if let (Some((_, reason)), true) = (fault, wanted || workspace.accuracy.found.is_none()) {
        let text = RichText::new(format!("There is no reference: {reason}")).small();
        ui.add(Label::new(text.color(ui.visuals().error_fg_color)).wrap());
    } else if workspace.accuracy.drawing.is_some() {
        weak(ui, "The reference is being drawn …");
    } else if wanted && !current {
        weak(ui, "The reference follows the exact picture …");
    }
    let Some(found) = &workspace.accuracy.found else {
        if !wanted {
            weak(ui, "Nothing has been compared yet.");
        }
        return;
    };
    if !current {
        notice(ui, "These figures are of an earlier picture.");
    }
    ui.scope(|ui| {
        if !current {
            ui.multiply_opacity(0.6);
        }
        errors(ui, &found.error);
        weak(ui, format!("The reference took {} ms.", plan::milliseconds(found.milliseconds)));
    });
}

fn errors(ui: &mut Ui, error: &ImageError) {
    let percent = |share: f64| format!("{} %", figure(100.0 * share));
    let rows = [
        ("Largest error", format!("{} / 255", figure(error.maximum))),
        ("Mean error", format!("{} / 255", figure(error.mean))),
        ("Pixels off by more than 1/255", percent(error.above_1)),
        ("Pixels off by more than 8/255", percent(error.above_8)),
        ("FLIP, mean", figure(error.flip_mean)),
        ("FLIP, 99th percentile", figure(error.flip_p99)),
    ];
    Grid::new("errors").num_columns(2).spacing([12.0, 1.0]).show(ui, |ui| {
        for (name, value) in rows {
            cell(ui, name);
            let shown = ui.label(RichText::new(&value).small().strong());
            let label = format!("{name}: {value}");
            shown.widget_info(|| WidgetInfo::labeled(egui::Role::Label, true, &label));
            ui.end_row();
        }
    });
}

/// How much is measured, how far that is, and what came of it.
fn sweep(ui: &mut Ui, workspace: &mut Workspace) {
    let form = &mut workspace.accuracy.form;
    ui.horizontal(|ui| {
        ui.label("Size");
        let side = ui.add(DragValue::new(&mut form.side).range(SIDES).suffix(" px"));
        side.widget_info(|| WidgetInfo::labeled(egui::Role::SpinButton, true, "Longest side of the pictures measured"));
        ui.label("Time limit");
        let seconds = ui.add(DragValue::new(&mut form.seconds).range(SECONDS).suffix(" s"));
        seconds.widget_info(|| WidgetInfo::labeled(egui::Role::SpinButton, true, "Time limit for measuring"));
    });
    match &workspace.accuracy.underway {
        None => {
            let help = "Measures every technique around the present settings, as `pellucid tradeoff` does, in the frames \
                        that the window does not need";
            if ui.button("Measure all").on_hover_text(help).clicked() {
                workspace.measure(Wanted::Sweep);
            }
        }
        Some(underway) => {
            let share = if underway.of > 0 { underway.done as f32 / underway.of as f32 } else { 0.0 };
            let word = match underway.wanted {
                Wanted::Sweep if underway.of > 0 => format!("{} of {}", underway.done, underway.of),
                Wanted::Sweep => String::new(),
                Wanted::Budget(_) => format!("frame {}", underway.done),
            };
            let resting = if underway.rests { "  (rests while the window draws)" } else { "" };
            ui.horizontal(|ui| {
                let stop = ui.button("Stop");
                stop.widget_info(|| WidgetInfo::labeled(egui::Role::Button, true, "Stop measuring"));
                if stop.clicked() {
                    workspace.asks.push(Ask::StopMeasuring);
                }
                ui.add(ProgressBar::new(share).desired_height(10.0).desired_width(ui.available_width()));
            });
            weak(ui, format!("{word}  {}{resting}", underway.name));
        }
    }
    results(ui, workspace);
}

fn results(ui: &mut Ui, workspace: &mut Workspace) {
    let (Some(swept), Some(document)) = (&workspace.accuracy.swept, &workspace.document) else {
        return;
    };
    if swept.entries.is_empty() {
        return;
    }
    let [width, height] = swept.size;
    let current = swept.is_of(workspace.scene_number, &document.seen);
    if swept.scene_number != workspace.scene_number {
        notice(ui, "Measured for another model.");
    } else if !current {
        notice(ui, "Measured for another view or look.");
    }
    let mut shows = workspace.accuracy.form.shows;
    let combo =
        egui::ComboBox::from_id_salt("error shown").selected_text(shows.name()).width(ui.available_width() - 8.0);
    let combo = combo.show_ui(ui, |ui| {
        for each in Shows::ALL {
            ui.selectable_value(&mut shows, each, each.name());
        }
    });
    combo.response.widget_info(|| WidgetInfo::labeled(egui::Role::ComboBox, true, "Error shown"));
    let points = swept.points(shows, current.then_some(&document.seen.settings));
    let (clicked, pointed) = diagram::show(ui, &points, &swept.entries, shows.name());
    weak(
        ui,
        format!("At {width}×{height} pixels. A click applies a setting. Filled: nothing is both faster and closer."),
    );
    let unsure = points.iter().filter(|p| !p.point.sure).count();
    if unsure > 0 {
        let each = if unsure == 1 { "1 has" } else { &format!("{unsure} have") };
        weak(ui, format!("{each} too few frames to tell, and are not among the best: a longer limit gives more."));
    }
    if current && !points.iter().any(|p| p.is_present) {
        weak(ui, "The present settings are not among those measured.");
    }
    let mut apply = clicked;
    let mut sorted: Vec<&Plotted> = points.iter().collect();
    sorted.sort_by(|a, b| a.point.time[1].total_cmp(&b.point.time[1]));
    let mut pointed_at = None;
    ScrollArea::vertical()
        .id_salt("points")
        .min_scrolled_height(170.0)
        .max_height(170.0)
        .auto_shrink([false, true])
        .show(ui, |ui| {
            ui.spacing_mut().item_spacing.y = 1.0;
            for plotted in sorted {
                let [time, error] = [plotted.point.time[1], plotted.point.error].map(figure);
                let text = RichText::new(&plotted.point.label).small();
                let text = if plotted.on_front { text.strong().color(style::ACCENT) } else { text };
                let value = RichText::new(format!("{time} ms  {error}")).small();
                let button = Button::selectable(plotted.is_present, text).right_text(value).truncate();
                let row = ui.add_sized(vec2(ui.available_width() - 10.0, 17.0), button);
                let place = match (plotted.on_front, plotted.is_present) {
                    (true, true) => ", best, present",
                    (true, false) => ", best",
                    (false, true) => ", present",
                    (false, false) => "",
                };
                let label = format!("Apply {}: {time} ms, {error}{place}", plotted.point.label);
                row.widget_info(|| WidgetInfo::selected(egui::Role::Button, true, plotted.is_present, &label));
                if row.hovered() || row.has_focus() {
                    pointed_at = Some(plotted.entry);
                }
                if row.clicked() {
                    apply = Some(plotted.entry);
                }
                row.on_hover_ui(|ui| diagram::figures(ui, plotted, &swept.entries[plotted.entry], shows.name()));
            }
        });
    diagram::point_at(ui, pointed, pointed_at);
    let without: Vec<(&str, &str)> = swept
        .entries
        .iter()
        .filter_map(|e| match &e.row.outcome {
            Err(reason) => Some((e.row.configuration.short.as_str(), reason.as_str())),
            Ok(measured) if measured.times.is_none() => {
                Some((e.row.configuration.short.as_str(), "no times: a longer limit gives them"))
            }
            Ok(_) => None,
        })
        .collect();
    if !without.is_empty() {
        let title = format!("{} without figures", without.len());
        CollapsingHeader::new(RichText::new(title).small()).id_salt("without figures").show(ui, |ui| {
            for (name, reason) in without {
                weak(ui, format!("{name}: {reason}"));
            }
        });
    }
    workspace.accuracy.form.shows = shows;
    if let Some(entry) = apply {
        workspace.apply_row(entry);
    }
}

/// Promises of time and error, and what was chosen for the last one.
fn budget(ui: &mut Ui, workspace: &mut Workspace) {
    let mut goal = None;
    let busy = workspace.accuracy.underway.is_some();
    let form = &mut workspace.accuracy.form;
    Grid::new("budgets").num_columns(3).spacing([8.0, 3.0]).show(ui, |ui| {
        ui.label("As accurate as possible within");
        let field = DragValue::new(&mut form.milliseconds).range(0.1..=600_000.0).speed(1.0).suffix(" ms");
        let field = ui.add(field.max_decimals(1));
        field.widget_info(|| WidgetInfo::labeled(egui::Role::SpinButton, true, "Budget of time"));
        let button = ui.add_enabled(!busy, Button::new("Choose"));
        button.widget_info(|| WidgetInfo::labeled(egui::Role::Button, !busy, "Choose by time"));
        if button.clicked() {
            goal = Some(Goal::Time(form.milliseconds));
        }
        ui.end_row();
        ui.label("As fast as possible below FLIP");
        let field = DragValue::new(&mut form.flip).range(0.0..=1.0).speed(0.001).max_decimals(4);
        let field = ui.add(field);
        field.widget_info(|| WidgetInfo::labeled(egui::Role::SpinButton, true, "Budget of error"));
        let button = ui.add_enabled(!busy, Button::new("Choose"));
        button.widget_info(|| WidgetInfo::labeled(egui::Role::Button, !busy, "Choose by error"));
        if button.clicked() {
            goal = Some(Goal::Error(form.flip));
        }
        ui.end_row();
    });
    weak(ui, "Chosen from what is measured at the size of the window, within the time limit above.");
    let mut apply = None;
    if let (Some(told), Some(document)) = (&workspace.accuracy.told, &workspace.document) {
        small(ui, &told.sentence);
        let applied = crate::app::accuracy::technique(&document.seen.settings) == told.technique;
        if told.scene_number != workspace.scene_number {
            notice(ui, "Chosen for another model.");
        } else if document.seen.camera != told.seen.camera || document.seen.arrangement != told.seen.arrangement {
            notice(ui, "Chosen for another view.");
        }
        if applied {
            weak(ui, "These are the present settings.");
        } else if ui.button("Apply").on_hover_text("Makes what was chosen the present settings").clicked() {
            apply = Some(told.technique.clone());
        }
    }
    if let Some(goal) = goal {
        workspace.measure(Wanted::Budget(goal));
    }
    if let Some(technique) = apply {
        workspace.apply_technique(&technique);
    }
}
