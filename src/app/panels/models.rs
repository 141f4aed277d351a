//! Five opacity models beside each other: the one that is clicked on is taken.

use egui::{Button, Image, Rect, TextureOptions, Ui, Window, vec2};

use crate::app::models::Models;
use crate::app::workspace::{Ask, Workspace};

/// Opens the panel, or closes it.
pub fn toggle(workspace: &mut Workspace) {
    workspace.models = match workspace.models {
        None if workspace.document.is_some() => Some(Models::default()),
        _ => None,
    };
}

/// The panel.
pub fn show(ui: &mut Ui, picture: Rect, workspace: &mut Workspace) {
    let (exact, order) = (workspace.is_exact(), workspace.order);
    let (Some(models), Some(document)) = (&mut workspace.models, &mut workspace.document) else {
        return;
    };
    if exact && models.number != order {
        models.number = order;
        models.failed = None;
        workspace.asks.push(Ask::DrawModels);
    }
    let (mut open, mut wanted) = (true, None);
    Window::new("Opacity models")
        .default_pos(picture.left_top() + vec2(12.0, 48.0))
        .default_width(picture.width().min(1000.0) - 24.0)
        .open(&mut open)
        .collapsible(false)
        .show(ui.ctx(), |ui| {
            let present = document.seen.settings.opacity.model;
            let width = ((ui.available_width() - 4.0 * ui.spacing().item_spacing.x) / 5.0 - 12.0).max(48.0);
            ui.horizontal_wrapped(|ui| {
                for picture in &mut models.pictures {
                    let texture = picture.texture.get_or_insert_with(|| {
                        ui.ctx().load_texture(picture.name, picture.image.clone(), TextureOptions::LINEAR)
                    });
                    ui.vertical(|ui| {
                        let [w, h] = picture.image.size.map(|n| n as f32);
                        let image = Image::new(&*texture).fit_to_exact_size(vec2(width, width * h / w));
                        let button = ui.add(Button::image(image).selected(picture.model == present));
                        let name = picture.name;
                        button.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, name));
                        if button.on_hover_text("Click to take it").clicked() {
                            wanted = Some(picture.model);
                        }
                        ui.label(name);
                    });
                }
            });
            match &models.failed {
                Some(reason) => {
                    ui.label(reason);
                }
                None if models.pictures.len() < 5 => {
                    ui.weak("Drawing…");
                }
                None => {}
            }
        });
    if let Some(model) = wanted {
        document.settle();
        document.seen.settings.opacity.model = model;
        document.settle();
    }
    if !open {
        workspace.models = None;
    }
}
