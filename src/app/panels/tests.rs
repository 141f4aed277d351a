//! The panels by what a screen reader reads: labels, roles, values.

use std::sync::Arc;

use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;

use crate::app::camera;
use crate::app::config::Preferences;
use crate::app::document::{Document, Seen};
use crate::app::panels::{self, stages};
use crate::app::workspace::{Ask, Gravity, Workspace};
use crate::plan::Capabilities;
use crate::scene::{Arrangement, Presence, builtin};
use crate::settings::{CaptureKind, OpacityModel, Settings};

fn workspace(file: &str) -> Workspace {
    let mut workspace = Workspace::new(Preferences::default());
    let scene = Arc::new(builtin::build(file).unwrap());
    let camera = camera::first(&scene.bounds(), 1.0);
    let seen = Seen { settings: Settings::default(), camera, arrangement: Arrangement::default() };
    workspace.document = Some(Document::new(format!("builtin:{file}"), scene, seen));
    workspace.scene_number = 1;
    workspace
}

fn harness(workspace: Workspace) -> Harness<'static, Workspace> {
    let show = |ui: &mut egui::Ui, workspace: &mut Workspace| panels::show(ui, workspace);
    let mut harness = Harness::builder().with_size(egui::vec2(1280.0, 1600.0)).build_ui_state(show, workspace);
    super::style::set_up(&harness.ctx);
    harness.run();
    harness
}

fn settings<'a>(harness: &'a Harness<'_, Workspace>) -> &'a Settings {
    &harness.state().document.as_ref().unwrap().seen.settings
}

fn open_everything(harness: &mut Harness<'_, Workspace>) {
    for (stage, title) in stages::STAGES {
        if !matches!(*stage, "capture" | "opacity") {
            harness.get_by_label(title).click();
            harness.run();
        }
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
            (Range::Text, _) if declaration.path == "image.background" => "#ffffff".to_owned(),
            (Range::Text, _) => "x-ray".to_owned(),
        };
        document.seen.settings.set(&declaration.path, &value).unwrap();
        expected.push((declaration.path.clone(), format!("Reset {}", stages::title_of(&declaration.path))));
    }
    let mut harness = harness(changed);
    open_everything(&mut harness);
    for (path, label) in &expected {
        // Two settings may have one title; each reset takes the first that is left.
        harness.get_all_by_label(label).next().unwrap_or_else(|| panic!("{path}: no '{label}'")).click();
        harness.run();
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
