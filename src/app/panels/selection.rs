//! What is selected: how it is shown, its box, and what can be done with it; and how far parts move apart.

use std::collections::BTreeSet;

use egui::{Button, Color32, DragValue, Grid, RichText, Slider, Ui};

use crate::app::camera;
use crate::app::document::Document;
use crate::app::measure::{number, unit};
use crate::app::workspace::{Gravity, Workspace};
use crate::math::Bounds;
use crate::scene::arrangement::MOST_EXPLODED;
use crate::scene::{Arrangement, PartLook, PartStyle, Presence};

/// Colour that a part begins with when it is given one: orange is told from the blues and greys of most models.
const FIRST_COLOR: [f64; 3] = [0.902, 0.624, 0.0];

/// The panel.
pub fn show(ui: &mut Ui, workspace: &mut Workspace) {
    let Some(document) = &mut workspace.document else {
        return;
    };
    let arrangement = &mut document.seen.arrangement;
    ui.spacing_mut().slider_width = 86.0;
    ui.add_space(4.0);
    ui.horizontal(|ui| {
        let label = ui.label("Explode");
        let slider = Slider::new(&mut arrangement.explode, 0.0..=MOST_EXPLODED).fixed_decimals(2);
        let help = "Moves parts away from the middle of what they belong to.";
        ui.add(slider).labelled_by(label.id).on_hover_text(help);
    });
    let selected: Vec<u32> = arrangement.selected.iter().copied().collect();
    let Some(&first) = selected.first() else {
        return;
    };
    ui.separator();
    let title = match selected.as_slice() {
        [one] => document.scene.parts.get(*one as usize).map_or("?", |p| p.name.as_str()).to_owned(),
        many => format!("{} parts", many.len()),
    };
    ui.add(egui::Label::new(RichText::new(title).strong()).truncate());
    looks(ui, arrangement, &selected, first);
    extent(ui, document, &selected);
    let mut act: Option<fn(&mut Workspace)> = None;
    ui.horizontal_wrapped(|ui| {
        for (text, keys, what) in [
            ("Isolate", "I", isolate as fn(&mut Workspace)),
            ("Frame", "F", frame_selected),
            ("As at first", "", forget_looks),
        ] {
            let help = match text {
                "Isolate" => "Ghosts everything else",
                "Frame" => "Fills the picture with it",
                _ => "Takes back presence, opacity, colour and style",
            };
            let help = if keys.is_empty() { help.to_owned() } else { format!("{help} ({keys})") };
            if ui.button(text).on_hover_text(help).clicked() {
                act = Some(what);
            }
        }
    });
    if let Some(act) = act {
        act(workspace);
    }
}

/// What is done to each of the selected parts.
type Change = Box<dyn Fn(&mut PartLook)>;

/// The looks of the selected parts. What is changed is changed for all of them.
fn looks(ui: &mut Ui, arrangement: &mut Arrangement, selected: &[u32], first: u32) {
    let look = arrangement.look(first);
    let same = |of: fn(&PartLook) -> PartLook| selected.iter().all(|&p| of(&arrangement.look(p)) == of(&look));
    let plain = PartLook::default();
    let mixed = [
        !same(|l| PartLook { presence: l.presence, ..PartLook::default() }),
        !same(|l| PartLook { opacity: l.opacity, ..PartLook::default() }),
        !same(|l| PartLook { color: l.color, ..PartLook::default() }),
        !same(|l| PartLook { style: l.style, ..PartLook::default() }),
    ];
    let mut change: Option<Change> = None;
    let name = |ui: &mut Ui, text: &str, mixed: bool| {
        let label = ui.label(if mixed { RichText::new(text).italics() } else { RichText::new(text) });
        if mixed { label.on_hover_text("Not the same for all selected parts") } else { label }
    };
    Grid::new("looks").num_columns(2).spacing([6.0, 4.0]).show(ui, |ui| {
        name(ui, "Presence", mixed[0]);
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 2.0;
            for (presence, text) in
                [(Presence::Shown, "Shown"), (Presence::Ghosted, "Ghost"), (Presence::Hidden, "Hidden")]
            {
                let on = !mixed[0] && look.presence == presence;
                let button = ui.add(Button::selectable(on, text));
                let label = format!("Presence: {text}");
                button.widget_info(|| egui::WidgetInfo::selected(egui::Role::Button, true, on, label.clone()));
                if button.clicked() {
                    change = Some(Box::new(move |l| l.presence = presence));
                }
            }
        });
        ui.end_row();
        let label = name(ui, "Part opacity", mixed[1]);
        let mut opacity = look.opacity;
        let slider = ui.add(Slider::new(&mut opacity, 0.0..=1.0).fixed_decimals(2)).labelled_by(label.id);
        if slider.on_hover_text("Times what the opacity model gives").changed() {
            change = Some(Box::new(move |l| l.opacity = opacity.clamp(0.0, 1.0)));
        }
        ui.end_row();
        name(ui, "Part colour", mixed[2]);
        ui.horizontal(|ui| {
            let mut own = look.color.is_some();
            let switch = ui.checkbox(&mut own, "");
            switch.widget_info(|| egui::WidgetInfo::selected(egui::Role::CheckBox, true, own, "Own colour"));
            if switch.on_hover_text("Its own colour instead of the file's").changed() {
                let color = own.then_some(FIRST_COLOR);
                change = Some(Box::new(move |l| l.color = color));
            }
            if let Some(color) = look.color {
                let mut steps = color.map(|c| (c * 255.0).round() as u8);
                let button = ui.color_edit_button_srgb(&mut steps);
                button.widget_info(|| egui::WidgetInfo::labeled(egui::Role::ColorWell, true, "Colour of the part"));
                if button.changed() {
                    let color = steps.map(|s| f64::from(s) / 255.0);
                    change = Some(Box::new(move |l| l.color = Some(color)));
                }
                let [r, g, b] = steps;
                ui.monospace(format!("#{r:02x}{g:02x}{b:02x}"));
            }
        });
        ui.end_row();
        name(ui, "Part style", mixed[3]);
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 2.0;
            for (style, text, help) in [
                (PartStyle::AsSet, "As set", "The opacity model acts on it"),
                (PartStyle::Solid, "Solid", "Opaque whatever the opacity model says"),
            ] {
                let button = ui.add(Button::selectable(!mixed[3] && look.style == style, text));
                if button.on_hover_text(help).clicked() {
                    change = Some(Box::new(move |l| l.style = style));
                }
            }
        });
        ui.end_row();
    });
    if let Some(change) = change {
        for &part in selected {
            change(arrangement.parts.entry(part).or_insert(plain));
        }
        arrangement.parts.retain(|_, look| *look != plain);
    }
}

/// The box around parts where the file has them, scene space.
fn box_of(document: &Document, parts: &[u32]) -> Bounds {
    let boxes = parts.iter().filter_map(|&p| document.scene.parts.get(p as usize)).map(|p| p.bounds);
    boxes.filter(|b| !b.is_empty()).fold(Bounds::EMPTY, Bounds::union)
}

fn extent(ui: &mut Ui, document: &Document, selected: &[u32]) {
    let bounds = box_of(document, selected);
    if bounds.is_empty() {
        return;
    }
    let list = |v: glam::DVec3| format!("{}, {}, {}", number(v.x), number(v.y), number(v.z));
    let size = bounds.size();
    let help = format!(
        "The box around it in the file's units:\nfrom {}\nto {}",
        list(bounds.min + document.scene.origin),
        list(bounds.max + document.scene.origin)
    );
    let text = format!("Box {} × {} × {}{}", number(size.x), number(size.y), number(size.z), unit(&document.file));
    ui.add(egui::Label::new(RichText::new(text).small()).truncate()).on_hover_text(help);
}

/// The parts that are selected; says so if there are none.
fn wanted(workspace: &mut Workspace) -> Option<BTreeSet<u32>> {
    let selected = workspace.document.as_ref().map(|d| d.seen.arrangement.selected.clone())?;
    if selected.is_empty() {
        workspace.say(Gravity::Note, "Nothing is selected: click on a part first.");
        return None;
    }
    Some(selected)
}

/// Changes the arrangement as one step.
fn arrange(workspace: &mut Workspace, change: impl FnOnce(&mut Arrangement, u32)) {
    if let Some(document) = &mut workspace.document {
        document.settle();
        let count = document.scene.parts.len() as u32;
        change(&mut document.seen.arrangement, count);
        document.seen.arrangement.parts.retain(|_, look| *look != PartLook::default());
        document.settle();
    }
}

/// Ghosts everything that is not selected.
pub fn isolate(workspace: &mut Workspace) {
    if let Some(selected) = wanted(workspace) {
        arrange(workspace, |a, count| a.isolate(&selected, count));
    }
}

/// Shows, ghosts or hides what is selected.
pub fn set_presence(workspace: &mut Workspace, presence: Presence) {
    if let Some(selected) = wanted(workspace) {
        arrange(workspace, |a, _| {
            for part in selected {
                a.parts.entry(part).or_default().presence = presence;
            }
        });
    }
}

/// Shows every part.
pub fn show_all(workspace: &mut Workspace) {
    arrange(workspace, |a, _| a.parts.values_mut().for_each(|look| look.presence = Presence::Shown));
}

/// Takes back the looks of what is selected.
fn forget_looks(workspace: &mut Workspace) {
    if let Some(selected) = wanted(workspace) {
        arrange(workspace, |a, _| a.parts.retain(|part, _| !selected.contains(part)));
    }
}

/// Fills the picture with everything.
pub fn frame_all(workspace: &mut Workspace) {
    let Some(bounds) = workspace.document.as_ref().map(|d| d.seen.arrangement.framed_bounds(&d.scene)) else {
        return;
    };
    workspace.look(|f, _, c| Some(camera::framed(c, &bounds, f.aspect())));
    workspace.pivot = None;
}

/// Fills the picture with what is selected, where the exploded view has it.
pub fn frame_selected(workspace: &mut Workspace) {
    if let Some(selected) = wanted(workspace) {
        frame_parts(workspace, selected);
    }
}

/// Fills the picture with these parts.
pub fn frame_parts(workspace: &mut Workspace, parts: impl IntoIterator<Item = u32>) {
    let Some(document) = &workspace.document else {
        return;
    };
    let offsets = document.seen.arrangement.offsets(&document.scene);
    let boxes = parts.into_iter().filter_map(|p| Some((document.scene.parts.get(p as usize)?, offsets[p as usize])));
    let moved = boxes.filter(|(p, _)| !p.bounds.is_empty());
    let bounds =
        moved.fold(Bounds::EMPTY, |all, (p, by)| all.union(Bounds { min: p.bounds.min + by, max: p.bounds.max + by }));
    if bounds.is_empty() {
        return;
    }
    workspace.look(|f, _, c| Some(camera::framed(c, &bounds, f.aspect())));
    workspace.pivot = None;
}

/// Brings the point that turning turns about into the middle.
pub fn centre_pivot(workspace: &mut Workspace) {
    match workspace.pivot {
        Some(pivot) => workspace.look(|_, _, c| Some(camera::centred(c, pivot))),
        None => workspace.say(Gravity::Note, "Click on a part first: that sets the point to turn about."),
    }
}

/// Width and height of a picture, edited as numbers.
pub(super) fn size_fields(ui: &mut Ui, size: &mut [u32; 2], most: u32) {
    for (n, name) in size.iter_mut().zip(["Width", "Height"]) {
        let field = ui.add(DragValue::new(n).range(1..=most).suffix(" px"));
        field.widget_info(|| egui::WidgetInfo::labeled(egui::Role::SpinButton, true, name));
    }
}

/// The colour in which what is measured is drawn: seen on light and dark alike under its dark rim.
pub(super) const MARK: Color32 = Color32::from_rgb(0xff, 0xd2, 0x4a);
