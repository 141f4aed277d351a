//! The plan beside the stages: what runs and why, what does not and why not, bytes, and milliseconds of the last exact picture.

use egui::{CollapsingHeader, Color32, Grid, Label, RichText, Ui};

use super::status::grouped;
use crate::app::workspace::Workspace;
use crate::gpu::PassTime;
use crate::render::Kept;

/// The plan.
pub fn show(ui: &mut Ui, workspace: &mut Workspace) {
    if workspace.document.is_none() || workspace.capabilities.is_none() {
        return;
    }
    CollapsingHeader::new(RichText::new("Plan").strong()).default_open(false).show_unindented(ui, |ui| {
        // Only where it is looked at: counting caps takes a while.
        workspace.replan();
        let plan = match &workspace.plan {
            None => return,
            Some(Ok(plan)) => plan,
            Some(Err(refusal)) => {
                ui.colored_label(ui.visuals().error_fg_color, refusal);
                return;
            }
        };
        // Times of another view are no times of this one.
        let (times, kept): (&[PassTime], Kept) = match (&workspace.report, &workspace.document) {
            (Some((seen, report)), Some(document)) if *seen == document.seen => (&report.passes, report.kept),
            _ => (&[], Kept::Nothing),
        };
        heading(
            ui,
            "Passes",
            &format!("{} ms", milliseconds(times.iter().map(|t| t.milliseconds).sum())),
            !times.is_empty(),
        );
        for planned in &plan.passes {
            let time =
                times.iter().find(|t| t.pass == planned.pass).map(|t| format!("{} ms", milliseconds(t.milliseconds)));
            let time = time.or_else(|| kept.spares(planned.pass).then(|| "kept".to_owned()));
            line(ui, planned.pass.name(), time.as_deref(), &planned.reason);
        }
        heading(ui, "Not needed", "", false);
        for skipped in &plan.skipped {
            line(ui, skipped.what, None, &skipped.reason);
        }
        heading(ui, "Memory", &bytes(plan.total_bytes()), true);
        Grid::new("buffers").num_columns(2).spacing([8.0, 1.0]).show(ui, |ui| {
            for buffer in &plan.buffers {
                ui.label(RichText::new(buffer.name).small());
                let about = if buffer.exact { "" } else { "about " };
                ui.label(RichText::new(format!("{about}{}", bytes(buffer.bytes))).small().weak());
                ui.end_row();
            }
        });
        if plan.bands.len() > 1 {
            ui.label(RichText::new(format!("drawn in {} bands", plan.bands.len())).small());
        }
    });
}

fn heading(ui: &mut Ui, text: &str, figure: &str, show: bool) {
    ui.add_space(4.0);
    ui.horizontal(|ui| {
        ui.label(RichText::new(text).small().weak());
        if show {
            right(ui, figure, ui.visuals().weak_text_color());
        }
    });
}

fn line(ui: &mut Ui, name: &str, figure: Option<&str>, reason: &str) {
    ui.horizontal(|ui| {
        ui.label(name);
        if let Some(figure) = figure {
            right(ui, figure, ui.visuals().text_color());
        }
    });
    ui.add(Label::new(RichText::new(reason).small().weak()).wrap());
}

fn right(ui: &mut Ui, text: &str, color: Color32) {
    ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
        ui.label(RichText::new(text).small().color(color));
    });
}

/// A time of at least one decimal below 10.
pub fn milliseconds(ms: f64) -> String {
    if ms < 10.0 { format!("{ms:.1}") } else { grouped(ms.round() as u64) }
}

fn bytes(n: u64) -> String {
    match n {
        0..1_000 => format!("{n} B"),
        1_000..1_000_000 => format!("{:.1} kB", n as f64 / 1e3),
        1_000_000..1_000_000_000 => format!("{:.1} MB", n as f64 / 1e6),
        _ => format!("{:.2} GB", n as f64 / 1e9),
    }
}
