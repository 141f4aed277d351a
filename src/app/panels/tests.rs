//! The panels by what a screen reader reads: labels, roles, values.

mod every_panel;

use std::sync::Arc;

use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;

use crate::app::camera;
use crate::app::config::Preferences;
use crate::app::dialogs::Choice;
use crate::app::document::{Document, Seen};
use crate::app::panels::{self, stages};
use crate::app::pictures::{Picked, Wish};
use crate::app::workspace::{Ask, Gravity, Workspace};
use crate::plan::Capabilities;
use crate::render::PickedLayer;
use crate::scene::{Arrangement, PartLook, PartStyle, Presence, builtin};
use crate::settings::{CaptureKind, OpacityModel, Settings};

pub(in crate::app) fn workspace(file: &str) -> Workspace {
    let mut workspace = Workspace::new(Preferences::default());
    let scene = Arc::new(builtin::build(file).unwrap());
    let camera = camera::first(&scene.bounds(), 1.0);
    let seen = Seen { settings: Settings::default(), camera, arrangement: Arrangement::default() };
    workspace.document = Some(Document::new(format!("builtin:{file}"), scene, seen));
    workspace.scene_number = 1;
    workspace
}

pub(in crate::app) fn harness(workspace: Workspace) -> Harness<'static, Workspace> {
    let show = |ui: &mut egui::Ui, workspace: &mut Workspace| panels::show(ui, workspace);
    let mut harness = Harness::builder().with_size(egui::vec2(1280.0, 3600.0)).build_ui_state(show, workspace);
    super::style::set_up(&harness.ctx);
    harness.run();
    harness
}

pub(in crate::app) fn settings<'a>(harness: &'a Harness<'_, Workspace>) -> &'a Settings {
    &harness.state().document.as_ref().unwrap().seen.settings
}

fn open_everything(harness: &mut Harness<'_, Workspace>) {
    for (stage, title) in stages::STAGES {
        if !matches!(*stage, "capture" | "opacity") {
            harness.get_by_label(title).click();
            harness.run();
        }
    }
    // What has no effect is put away in each of them.
    for i in 0..harness.query_all_by_label_contains(stages::PUT_AWAY).count() {
        harness.get_all_by_label_contains(stages::PUT_AWAY).nth(i).unwrap().click();
        harness.run();
    }
}

#[test]
fn every_declared_setting_can_be_reached_and_reset() {
    let mut changed = workspace("quads");
    let document = changed.document.as_mut().unwrap();
    let mut expected = Vec::new();
    for declaration in Settings::declarations() {
        // Something that is not the default, whatever the range.
        use crate::settings::Range;
        let value = match (declaration.range, &declaration.default) {
            (Range::Integer(least, most), default) => {
                if default.as_integer() == Some(least) {
                    most.to_string()
                } else {
                    least.to_string()
                }
            }
            (Range::Real(least, most), default) => {
                if default.as_float() == Some(least) {
                    most.to_string()
                } else {
                    least.to_string()
                }
            }
            (Range::Choice(names), default) => {
                names.iter().find(|n| Some(**n) != default.as_str()).unwrap().to_string()
            }
            (Range::Switch, default) => (!default.as_bool().unwrap()).to_string(),
            (Range::Color { .. }, _) => "#ffffff".to_owned(),
            (Range::Text, _) => "x-ray".to_owned(),
        };
        document.seen.settings.set(&declaration.path, &value).unwrap();
        expected.push((declaration.path.clone(), format!("Reset {}", stages::title_of(&declaration.path))));
    }
    let mut harness = harness(changed);
    open_everything(&mut harness);
    for (path, label) in &expected {
        // Two settings may have one title; each reset takes the first that is left.
        let before = settings(&harness).clone();
        harness.get_all_by_label(label).next().unwrap_or_else(|| panic!("{path}: no '{label}'")).click();
        harness.run();
        assert!(*settings(&harness) != before, "{path}: '{label}' changes nothing");
    }
    assert_eq!(*settings(&harness), Settings::default());
}

#[test]
fn lists_switches_and_sliders_change_what_they_say() {
    let mut harness = harness(workspace("quads"));
    harness.get_by_label("Model").click();
    harness.run();
    harness.get_by_label("constant").click();
    harness.run();
    assert_eq!(settings(&harness).opacity.model, OpacityModel::Constant);
    harness.get_by_label("Kind").click();
    harness.run();
    harness.get_by_label("bucketed k buffer").click();
    harness.run();
    assert_eq!(settings(&harness).capture.kind, CaptureKind::BucketedKBuffer);
    open_everything(&mut harness);
    harness.get_by_label("Reverse check").click();
    harness.run();
    assert!(!settings(&harness).features.reverse_check);
    // One step of undo for each click.
    let document = harness.state_mut().document.as_mut().unwrap();
    document.settle();
    assert!(document.undo());
    assert_eq!(document.seen.settings, Settings::default(), "without a shell nothing settles in between");
}

#[test]
fn parts_are_found_hidden_and_isolated_by_name() {
    let mut harness = harness(workspace("gearbox"));
    let name = {
        let scene = &harness.state().document.as_ref().unwrap().scene;
        // A name that only one part has.
        let unique = |n: &str| scene.parts.iter().filter(|p| p.name.contains(n)).count() == 1;
        scene.parts.iter().find(|p| unique(&p.name)).unwrap().name.clone()
    };
    harness.get_by_label("Search parts").focus();
    harness.get_by_label("Search parts").type_text(&name);
    harness.run();
    harness.get_by_label(&format!("{name} shown")).click();
    harness.run();
    harness.get_by_label(&format!("{name} ghosted")).click();
    harness.run();
    harness.get_by_label(&format!("{name} hidden"));
    let document = harness.state().document.as_ref().unwrap();
    let part = document.scene.parts.iter().position(|p| p.name == name).unwrap() as u32;
    let arrangement = &document.seen.arrangement;
    assert_eq!(arrangement.look(part).presence, Presence::Hidden);
    assert_eq!(arrangement.parts.len(), 1);
    harness.get_by_label("Show all").click();
    harness.run();
    harness.get_by_label(&name).click();
    harness.run();
    let arrangement = &harness.state().document.as_ref().unwrap().seen.arrangement;
    assert_eq!(*arrangement, Arrangement { selected: [part].into(), ..Arrangement::default() });
}

#[test]
fn the_plan_says_what_runs_and_what_does_not() {
    let mut planned = workspace("quads");
    planned.capabilities = Some(Capabilities { max_storage_buffers: 16, ..Capabilities::default() });
    let mut harness = harness(planned);
    harness.get_by_label("Plan").click();
    harness.run();
    assert!(matches!(harness.state().plan, Some(Ok(_))), "{:?}", harness.state().plan);
    harness.get_by_label("Not needed");
    harness.get_by_label("curvature");
    harness.state_mut().document.as_mut().unwrap().seen.settings.opacity.model = OpacityModel::Opaque;
    harness.run();
    harness.get_by_label("opaque");
}

#[test]
fn messages_can_be_dismissed_and_without_a_model_there_is_a_way_on() {
    let mut empty = Workspace::new(Preferences::default());
    empty.say(Gravity::Error, "Something went wrong.");
    let mut harness = harness(empty);
    harness.get_by_label("Something went wrong.");
    harness.get_by_label("Dismiss").click();
    harness.run();
    assert!(harness.query_by_label("Something went wrong.").is_none());
    harness.get_by_label("Try the gearbox").click();
    harness.run();
    assert_eq!(harness.state().asks, [Ask::Open("builtin:gearbox".to_owned())]);
    harness.state_mut().layout.shortcuts = true;
    harness.run();
    harness.get_by_label("Undo, redo");
}

#[test]
fn section_planes_are_added_moved_and_removed() {
    let mut harness = harness(workspace("quads"));
    harness.get_by_label("Sections").click();
    harness.run();
    harness.get_by_label("Add a section across x").click();
    harness.run();
    harness.get_by_label("Add a section across the view").click();
    harness.run();
    let sections = |h: &Harness<'_, Workspace>| h.state().document.as_ref().unwrap().seen.arrangement.sections.clone();
    let added = sections(&harness);
    assert_eq!(added.len(), 2);
    assert_eq!(added[0].normal, glam::DVec3::X);
    let camera = harness.state().document.as_ref().unwrap().seen.camera;
    assert!(added[1].normal.dot(camera.direction()) < -0.99, "towards the viewer");
    harness.get_by_label("Position of section 1").focus();
    harness.key_press(egui::Key::ArrowRight);
    harness.run();
    assert!(sections(&harness)[0].offset > added[0].offset);
    harness.get_by_label("Section 1").click();
    harness.run();
    assert!(!sections(&harness)[0].enabled);
    harness.get_all_by_label("Remove").next().unwrap().click();
    harness.run();
    assert_eq!(sections(&harness), [added[1]]);
}

fn layer(part: u32, position: glam::DVec3) -> PickedLayer {
    PickedLayer { part, depth: 1.0, position, normal: glam::DVec3::Z, kappa: 0.1, opacity: 0.5 }
}

/// Layers under the middle of the picture, as a thread finds them.
fn picked(workspace: &Workspace, wish: Wish, layers: &[(u32, glam::DVec3)]) -> Picked {
    Picked {
        scene_number: workspace.scene_number,
        wish,
        pixel: [60, 60],
        of: workspace.document.as_ref().unwrap().seen.camera,
        layers: layers.iter().map(|&(part, position)| layer(part, position)).collect(),
    }
}

fn arrangement<'a>(harness: &'a Harness<'_, Workspace>) -> &'a Arrangement {
    &harness.state().document.as_ref().unwrap().seen.arrangement
}

#[test]
fn looks_of_the_selection_are_changed_together() {
    let mut chosen = workspace("stack");
    let document = chosen.document.as_mut().unwrap();
    document.seen.arrangement.selected = [0, 2].into();
    let mut harness = harness(chosen);
    harness.get_by_label("2 parts");
    harness.get_by_label("Presence: Ghost").click();
    harness.run();
    harness.get_by_label("Own colour").click();
    harness.run();
    harness.get_by_label("Colour of the part");
    harness.get_by_label("Solid").click();
    harness.run();
    let look = arrangement(&harness).look(2);
    assert_eq!((look.presence, look.style), (Presence::Ghosted, PartStyle::Solid));
    assert!(look.color.is_some() && arrangement(&harness).look(0) == look && arrangement(&harness).parts.len() == 2);
    // The keyboard moves the sliders.
    for label in ["Part opacity", "Explode"] {
        harness.get_by_role_and_label(egui::accesskit::Role::Slider, label).focus();
        harness.run();
        harness.key_press(if label == "Explode" { egui::Key::ArrowRight } else { egui::Key::ArrowLeft });
        harness.run();
    }
    assert!(arrangement(&harness).look(2).opacity < 1.0 && arrangement(&harness).explode > 0.0);
    harness.get_by_label("As at first").click();
    harness.run();
    assert!(arrangement(&harness).parts.is_empty());
    harness.get_by_label("Isolate").click();
    harness.run();
    assert_eq!(arrangement(&harness).look(1).presence, Presence::Ghosted);
    assert_eq!(arrangement(&harness).look(0), PartLook::default());
    let before = harness.state().document.as_ref().unwrap().seen.camera;
    harness.get_by_label("Frame").click();
    harness.run();
    assert_ne!(harness.state().document.as_ref().unwrap().seen.camera, before);
}

#[test]
fn parts_under_the_cursor_are_shown_and_chosen_from() {
    let mut hovering = workspace("stack");
    let at = glam::DVec3::ZERO;
    let name = |w: &Workspace, part: usize| w.document.as_ref().unwrap().scene.parts[part].name.clone();
    let (first, second) = (name(&hovering, 1), name(&hovering, 2));
    hovering.take_picked(picked(&hovering, Wish::Hover, &[(1, at), (1, at), (2, at)]));
    assert!(hovering.hover.is_some());
    // A thread may answer for a model that is gone.
    let stale = Picked { scene_number: 99, ..picked(&hovering, Wish::Select { more: false }, &[(1, at)]) };
    hovering.take_picked(stale);
    assert!(hovering.picked.is_none());
    let mut harness = harness(hovering);
    harness.get_by_label(&format!("{first}  ×2"));
    let list = picked(harness.state(), Wish::List, &[(1, at), (1, at), (2, at)]);
    harness.state_mut().take_picked(list);
    harness.run();
    // The tree has the same name; the list comes after it.
    let nodes: Vec<_> = harness.get_all_by_label(&second).collect();
    nodes.last().unwrap().click();
    harness.run();
    assert_eq!(arrangement(&harness).selected, [2].into());
    assert!(harness.state().layout.stack.is_none());
    assert_eq!(harness.state().picked.as_ref().map(|p| p.1), Some(2), "the layer, not the line of the list");
}

#[test]
fn two_clicks_measure_and_the_layer_can_be_changed() {
    let mut measuring = workspace("stack");
    measuring.measure.on = true;
    let (a, b) = (glam::DVec3::ZERO, glam::DVec3::new(3.0, 4.0, 0.0));
    let mut harness = harness(measuring);
    harness.get_by_label("Click on the first point.");
    for layers in [vec![(0, a)], vec![(1, b), (2, b * 2.0)]] {
        let found = picked(harness.state(), Wish::Measure, &layers);
        harness.state_mut().take_picked(found);
        harness.run();
    }
    harness.get_by_label("Length 5");
    harness.get_by_label("Δx 3");
    assert!(harness.state_mut().measure_next([61, 60]), "a click on the last point goes to the layer behind");
    harness.run();
    harness.get_by_label("Length 10");
    harness.get_by_label("Copy").click();
    harness.run();
    assert_eq!(harness.state().asks, [Ask::Copy("10\t6\t8\t0".to_owned())]);
    harness.get_by_label("Clear").click();
    harness.run();
    assert!(harness.state().measure.ends.is_empty() && harness.state().measure.on);
}

#[test]
fn views_are_saved_recalled_and_forgotten() {
    let mut harness = harness(workspace("stack"));
    let camera = |h: &Harness<'_, Workspace>| h.state().document.as_ref().unwrap().seen.camera;
    let first = camera(&harness);
    panels::views::ask(harness.state_mut());
    harness.run();
    harness.get_by_label("Name of the view").type_text(" from here");
    harness.run();
    harness.get_by_label("Save view").click();
    harness.run();
    let name = harness.state().preferences.views_of("builtin:stack")[0].name.clone();
    assert!(name.contains("from here"), "{name}");
    harness.state_mut().look(|_, _, c| Some(camera::other_projection(c)));
    panels::views::next(harness.state_mut());
    assert_eq!(camera(&harness), first);
    harness.get_by_label("View").click();
    harness.run();
    harness.get_by_label_contains("Saved views").click();
    harness.run();
    harness.get_by_label(&format!("Forget {name}")).click();
    harness.run();
    assert!(harness.state().preferences.views.is_empty());
}

#[test]
fn menus_apply_looks_and_open_hard_cases() {
    let mut harness = harness(workspace("stack"));
    harness.get_by_label("Look").click();
    harness.run();
    harness.get_by_label("plain").click();
    harness.run();
    assert_eq!(settings(&harness).opacity.model, OpacityModel::Constant);
    harness.get_by_label("File").click();
    harness.run();
    harness.get_by_label_contains("Hard cases").click();
    harness.run();
    let (_, case) = crate::tradeoff::hard_cases::all().next().unwrap();
    harness.get_by_label(case.name).click();
    harness.run();
    assert!(harness.state().asks.contains(&Ask::Open(format!("hard-case:{}", case.name))));
}

#[test]
fn pictures_of_any_size_are_asked_for() {
    let mut harness = harness(workspace("stack"));
    panels::export::ask(harness.state_mut());
    harness.run();
    harness.get_by_label("1920×1080").click();
    harness.run();
    harness.get_by_label("With background").click();
    harness.run();
    harness.get_by_label("Turntable").click();
    harness.run();
    let form = harness.state().layout.export.clone().unwrap();
    assert_eq!((form.size, form.background, form.turntable), ([1920, 1080], false, true));
    harness.get_by_label("Write…").click();
    harness.run();
    assert_eq!(harness.state().asks, [Ask::Choose(Choice::Export)]);
    harness.state_mut().exporting = Some((3, 10));
    harness.run();
    harness.get_by_label("Writing pictures: 3 of 10");
    harness.get_by_label("Cancel").click();
    harness.run();
    assert!(harness.state().asks.contains(&Ask::CancelExport));
}
