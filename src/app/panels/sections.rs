//! Section planes: up to six, each with its direction, where it stands, and whether the parts that it cuts are closed.
//!
//! A plane is added in the middle of the model, towards an axis or the viewer, and can then be pulled and tilted on the
//! picture ([`super::planes`]); what lies on the side that its direction points
//! to is cut away. Positions are along the direction, in the file's units.

use egui::{CollapsingHeader, ComboBox, DragValue, RichText, Slider, Ui};
use glam::DVec3;

use crate::app::planes::{in_file, range_of};
use crate::app::workspace::Workspace;
use crate::math::Bounds;
use crate::scene::Section;
use crate::scene::arrangement::MOST_SECTIONS;

/// Directions by name.
const DIRECTIONS: &[(&str, DVec3)] = &[
    ("+x", DVec3::X),
    ("−x", DVec3::NEG_X),
    ("+y", DVec3::Y),
    ("−y", DVec3::NEG_Y),
    ("+z", DVec3::Z),
    ("−z", DVec3::NEG_Z),
];

/// A plane through the middle of the box around the model, in the file's coordinates.
pub fn through_the_middle(bounds: &Bounds, normal: DVec3) -> Section {
    let [least, most] = range_of(bounds, normal);
    Section { normal, offset: 0.5 * (least + most), enabled: true, caps: true }
}

/// The same plane in another direction, as far through the model as before.
fn turned(bounds: &Bounds, section: &Section, normal: DVec3) -> Section {
    let [old, new] = [range_of(bounds, section.normal), range_of(bounds, normal)];
    let size = old[1] - old[0];
    let share = if size > 0.0 { ((section.offset - old[0]) / size).clamp(0.0, 1.0) } else { 0.5 };
    Section { normal, offset: new[0] + share * (new[1] - new[0]), ..*section }
}

/// The panel.
pub fn show(ui: &mut Ui, workspace: &mut Workspace) {
    let Some(document) = &mut workspace.document else {
        return;
    };
    // Where the exploded view has the parts: there the planes cut.
    let bounds = in_file(&document.seen.arrangement.framed_bounds(&document.scene), &document.scene);
    let handles = &mut workspace.layout.planes;
    let toward_viewer = -document.seen.camera.direction();
    let sections = &mut document.seen.arrangement.sections;
    let title = if sections.is_empty() { "Sections".to_owned() } else { format!("Sections  {}", sections.len()) };
    CollapsingHeader::new(RichText::new(title).strong()).id_salt("sections").show_unindented(ui, |ui| {
        let before = sections.len();
        ui.horizontal(|ui| {
            ui.label("Add");
            ui.add_enabled_ui(sections.len() < MOST_SECTIONS, |ui| {
                for (name, normal) in DIRECTIONS.iter().filter(|(name, _)| name.starts_with('+')) {
                    let axis = name.trim_start_matches('+');
                    let button = ui.button(axis).on_hover_text(format!("Cut away the side towards +{axis}"));
                    button.widget_info(|| {
                        egui::WidgetInfo::labeled(egui::Role::Button, true, format!("Add a section across {axis}"))
                    });
                    if button.clicked() {
                        sections.push(through_the_middle(&bounds, *normal));
                    }
                }
                let button = ui.button("view").on_hover_text("Cut away the side towards the viewer");
                button.widget_info(|| {
                    egui::WidgetInfo::labeled(egui::Role::Button, true, "Add a section across the view")
                });
                if button.clicked() {
                    sections.push(through_the_middle(&bounds, toward_viewer));
                }
            });
        });
        if sections.len() > before {
            handles.choose(before);
        }
        let mut removed = None;
        for (i, section) in sections.iter_mut().enumerate() {
            ui.push_id(i, |ui| {
                let was = *section;
                if plane(ui, &bounds, i + 1, section) {
                    removed = Some(i);
                } else if *section != was {
                    handles.chosen = i;
                }
            });
        }
        if let Some(i) = removed {
            sections.remove(i);
            handles.chosen = handles.chosen.saturating_sub(usize::from(handles.chosen > i));
        }
        if !sections.is_empty() {
            let help = "Arrows on the picture pull the planes, the ring at an arrow's end tilts its plane (X)";
            ui.checkbox(&mut handles.shown, "Handles on the picture").on_hover_text(help);
        }
        ui.add_space(4.0);
    });
}

/// One plane; whether it is to be removed.
fn plane(ui: &mut Ui, bounds: &Bounds, number: usize, section: &mut Section) -> bool {
    let mut removed = false;
    ui.horizontal(|ui| {
        let enabled = ui.checkbox(&mut section.enabled, format!("Section {number}"));
        enabled.on_hover_text("Whether it cuts");
        let named = DIRECTIONS.iter().find(|(_, n)| *n == section.normal).map(|(name, _)| *name);
        let direction = ComboBox::from_id_salt("direction").width(64.0).selected_text(named.unwrap_or("slanted"));
        let shown = direction.show_ui(ui, |ui| {
            for (name, normal) in DIRECTIONS {
                if ui.selectable_label(named == Some(*name), *name).clicked() {
                    *section = turned(bounds, section, *normal);
                }
            }
        });
        shown.response.on_hover_text("The side that is cut away");
        if ui.button("Flip").on_hover_text("Cut away the other side").clicked() {
            *section = Section { normal: -section.normal, offset: -section.offset, ..*section };
        }
        ui.checkbox(&mut section.caps, "Caps").on_hover_text("Close the parts that it cuts");
        removed = ui.button("Remove").clicked();
    });
    let [least, most] = range_of(bounds, section.normal);
    let size = (most - least).max(f64::MIN_POSITIVE);
    ui.horizontal(|ui| {
        ui.spacing_mut().slider_width = (ui.available_width() - 96.0).max(60.0);
        let slider = ui.add(Slider::new(&mut section.offset, least..=most).show_value(false));
        slider.widget_info(|| egui::WidgetInfo::slider(true, section.offset, format!("Position of section {number}")));
        let field = ui.add(DragValue::new(&mut section.offset).speed(size / 500.0).max_decimals(4));
        field.on_hover_text(format!("Along the direction, in the file's units: {least:.4} to {most:.4}"));
    });
    removed
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::builtin;

    #[test]
    fn a_plane_is_added_in_the_middle_and_turned_as_far_through_as_before() {
        let mut scene = builtin::build("gearbox").unwrap();
        scene.origin = DVec3::new(1000.0, 0.0, 0.0);
        let bounds = in_file(&scene.bounds(), &scene);
        let [least, most] = range_of(&bounds, DVec3::X);
        assert!(least > 900.0 && most > least, "the file's coordinates");
        let middle = through_the_middle(&bounds, DVec3::X);
        assert!((middle.offset - 0.5 * (least + most)).abs() < 1e-9 && middle.enabled && middle.caps);
        let quarter = Section { offset: least + 0.25 * (most - least), ..middle };
        let across = turned(&bounds, &quarter, DVec3::NEG_Y);
        let [least, most] = range_of(&bounds, DVec3::NEG_Y);
        assert!((across.offset - (least + 0.25 * (most - least))).abs() < 1e-9, "{across:?}");
    }
}
