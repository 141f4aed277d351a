//! Measuring: the line on the picture, and its length.

use egui::{Align2, Color32, ComboBox, FontId, Pos2, Rect, Stroke, Ui, Window, vec2};
use glam::{DVec2, DVec3};

use super::selection::MARK;
use crate::app::measure::{number, unit};
use crate::app::workspace::{Ask, Workspace};

/// The line and its ends, over the picture.
pub fn overlay(ui: &Ui, picture: Rect, workspace: &Workspace) {
    let (measure, Some(document)) = (&workspace.measure, &workspace.document) else {
        return;
    };
    if !measure.on || measure.ends.is_empty() || workspace.viewport.size.contains(&0) {
        return;
    }
    let offsets = document.seen.arrangement.offsets(&document.scene);
    let camera = &document.seen.camera;
    let frustum = camera.frustum(&document.seen.arrangement.framed_bounds(&document.scene));
    let clip_from_world =
        camera.clip_from_view(frustum, workspace.viewport.size, DVec2::ZERO) * camera.view_from_world();
    let on_screen = |point: DVec3| -> Option<Pos2> {
        let clip = clip_from_world * point.extend(1.0);
        // Behind the eye there is no place on the screen.
        let at = (clip.truncate() / clip.w).truncate();
        (clip.w > 0.0 && at.is_finite() && at.abs().max_element() < 1e4).then(|| {
            let half = picture.size() * 0.5;
            picture.center() + vec2(at.x as f32 * half.x, -at.y as f32 * half.y)
        })
    };
    let unit = unit(&document.file);
    let painter = ui.painter().with_clip_rect(picture);
    let rim = Color32::from_black_alpha(190);
    let points: Vec<Option<Pos2>> = measure
        .ends
        .iter()
        .map(|e| on_screen(e.home() + offsets.get(e.part() as usize).copied().unwrap_or_default()))
        .collect();
    if let [Some(from), Some(to)] = points[..] {
        painter.line_segment([from, to], Stroke::new(4.0, rim));
        painter.line_segment([from, to], Stroke::new(1.8, MARK));
        if let Some(distance) = measure.distance() {
            let text = painter.layout_no_wrap(number(distance.length) + unit, FontId::proportional(13.0), MARK);
            let place = Align2::CENTER_CENTER.anchor_size(from.lerp(to, 0.5) - vec2(0.0, 14.0), text.size());
            painter.rect_filled(place.expand2(vec2(5.0, 2.0)), 3.0, rim);
            painter.galley(place.min, text, MARK);
        }
    }
    for point in points.into_iter().flatten() {
        painter.circle_filled(point, 5.5, rim);
        painter.circle_filled(point, 3.5, MARK);
    }
}

/// The panel, while measuring.
pub fn show(ui: &Ui, picture: Rect, workspace: &mut Workspace) {
    let (measure, Some(document)) = (&mut workspace.measure, &workspace.document) else {
        return;
    };
    if !measure.on {
        return;
    }
    let unit = unit(&document.file);
    let mut open = true;
    let mut copied = None;
    Window::new("Measure")
        .default_pos(picture.left_top() + vec2(10.0, 10.0))
        .default_width(216.0)
        .constrain_to(picture)
        .open(&mut open)
        .resizable(false)
        .collapsible(false)
        .show(ui.ctx(), |ui| {
            ui.set_max_width(230.0);
            match measure.ends.len() {
                0 => ui.label("Click on the first point."),
                1 => ui.label("Click on the second point; again on the first for what is behind it."),
                _ => ui.weak("Another click begins anew."),
            };
            for (i, name) in ["From", "To"].into_iter().enumerate() {
                let Some(end) = measure.ends.get_mut(i) else {
                    continue;
                };
                ui.horizontal(|ui| {
                    let part = |layer: usize| {
                        let part = end.picked.layers.get(layer).map_or(0, |l| l.part as usize);
                        let name = document.scene.parts.get(part).map_or("?", |p| p.name.as_str());
                        format!("{}  {name}", layer + 1)
                    };
                    let texts: Vec<String> = (0..end.picked.layers.len()).map(part).collect();
                    ui.label(name);
                    let list =
                        ComboBox::from_id_salt(("end", i)).width(170.0).truncate().selected_text(&texts[end.layer]);
                    let list = list.show_ui(ui, |ui| {
                        for (layer, text) in texts.iter().enumerate() {
                            ui.selectable_value(&mut end.layer, layer, text);
                        }
                    });
                    let help = format!("{name}: which layer under the click");
                    list.response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::ComboBox, true, help.clone()));
                });
            }
            let Some(distance) = measure.distance() else {
                return;
            };
            ui.separator();
            let [x, y, z] = distance.difference.to_array().map(number);
            let length = number(distance.length);
            let help = "In the file's units, between the points as the file has them: the exploded view \
                        does not count.";
            let shown = ui.heading(format!("{length}{unit}")).on_hover_text(help);
            shown.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Label, true, format!("Length {length}{unit}")));
            for (axis, value) in ["x", "y", "z"].into_iter().zip([&x, &y, &z]) {
                ui.label(format!("Δ{axis} {value}{unit}"));
            }
            ui.horizontal(|ui| {
                if ui.button("Copy").clicked() {
                    copied = Some(format!("{length}\t{x}\t{y}\t{z}"));
                }
                if ui.button("Clear").clicked() {
                    measure.ends.clear();
                }
            });
        });
    if let Some(text) = copied {
        workspace.asks.push(Ask::Copy(text));
    }
    if !open {
        workspace.measure = Default::default();
    }
}
