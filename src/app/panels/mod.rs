//! What stands around the picture, one function a panel. All of them work on the [`Workspace`] alone.

pub mod accuracy;
pub mod diagram;
pub mod export;
pub mod measure;
pub mod menu;
pub mod messages;
pub mod models;
pub mod parts;
pub mod plan;
pub mod planes;
#[cfg(test)]
mod planes_tests;
pub mod room;
pub mod sections;
pub mod selection;
#[cfg(test)]
mod settings_tests;
pub mod shortcuts;
pub mod stack;
pub mod stages;
pub mod status;
pub mod style;
#[cfg(test)]
pub(in crate::app) mod tests;
pub mod views;

use egui::{CentralPanel, Frame, Panel, Pos2, Rect, ScrollArea, Sense, Ui};

use super::accuracy::overlay::{self, Overlay};
use super::viewport::{self, Paint};
use super::workspace::{Viewport, Workspace};
use super::{compare, editors};
use room::Room;

/// Everything, from the outside in.
pub fn show(ui: &mut Ui, workspace: &mut Workspace) {
    Panel::top("menu").show(ui, |ui| menu::show(ui, workspace));
    let room = Room::of(ui.available_size(), &workspace.preferences, &workspace.layout.sizes);
    Panel::bottom("status").show(ui, |ui| status::show(ui, workspace, &room));
    if let Some(size) = room.editors {
        let shown = size.panel(Panel::bottom(size.id("editors"))).show(ui, |ui| editors::show(ui, workspace));
        size.remember(shown.response.rect.height(), &mut workspace.layout.sizes.editors);
    }
    if let Some(size) = room.accuracy {
        let shown = size.panel(Panel::right(size.id("accuracy"))).show(ui, |ui| {
            ScrollArea::vertical().auto_shrink(false).show(ui, |ui| accuracy::show(ui, workspace));
        });
        size.remember(shown.response.rect.width(), &mut workspace.layout.sizes.accuracy);
    }
    if let Some(size) = room.stages {
        let shown = size.panel(Panel::right(size.id("stages"))).show(ui, |ui| {
            ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
                stages::show(ui, workspace);
                sections::show(ui, workspace);
                plan::show(ui, workspace);
            });
        });
        size.remember(shown.response.rect.width(), &mut workspace.layout.sizes.stages);
    }
    if let Some(size) = room.parts {
        let shown = size.panel(Panel::left(size.id("parts"))).show(ui, |ui| parts::show(ui, workspace));
        size.remember(shown.response.rect.width(), &mut workspace.layout.sizes.parts);
    }
    CentralPanel::default().frame(Frame::NONE).show(ui, |ui| picture(ui, workspace));
    messages::prompt(ui, workspace);
    views::show(ui, workspace);
    shortcuts::show(ui, workspace);
}

/// The picture, and what lies on it.
fn picture(ui: &mut Ui, workspace: &mut Workspace) {
    let ppp = ui.ctx().pixels_per_point();
    let rect = ui.max_rect();
    let pixel = |v: f32| (v * ppp).round().max(0.0) as u32;
    let (left, top) = (pixel(rect.left()), pixel(rect.top()));
    let size = [pixel(rect.right()).saturating_sub(left), pixel(rect.bottom()).saturating_sub(top)];
    workspace.viewport = Viewport { origin: [left, top], size };
    let point = |x: u32, y: u32| Pos2::new(x as f32 / ppp, y as f32 / ppp);
    let rect = Rect::from_min_max(point(left, top), point(left + size[0], top + size[1]));
    let response = ui.allocate_rect(rect, Sense::click_and_drag());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Canvas, true, "Viewport"));
    match &workspace.screen {
        Some(screen) => {
            let moved = workspace.document.as_ref().filter(|d| (d.seen.camera, size) != screen.view).and_then(|d| {
                let (then, of) = &screen.view;
                viewport::moved_along((then, *of), (&d.seen.camera, size), &d.scene.bounds())
            });
            let paint = Paint { picture: screen.shown.clone(), slot: 0, origin: [left, top], size, moved };
            ui.painter().add(paint.within(rect));
            if workspace.accuracy.overlay == Overlay::Off {
                compare::show(ui, rect, workspace);
            } else {
                overlay::show(ui, rect, workspace);
            }
        }
        None => {
            ui.painter().rect_filled(rect, 0.0, style::behind_the_picture(ui.visuals().dark_mode));
        }
    }
    planes::show(ui, rect, workspace);
    measure::overlay(ui, rect, workspace);
    messages::show(ui, rect, workspace);
    export::show(ui, rect, workspace);
    models::show(ui, rect, workspace);
    measure::show(ui, rect, workspace);
    stack::show(ui, rect, workspace);
}
