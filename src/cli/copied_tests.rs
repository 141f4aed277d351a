//! *Copy as command line* of the window, read again by the program's own parser.

use std::sync::Arc;

use clap::Parser;
use glam::DVec3;
use proptest::prelude::*;

use super::options::{Cli, Command};
use crate::app::camera;
use crate::app::command_line;
use crate::app::document::{Document, Seen};
use crate::scene::arrangement::{MOST_EXPLODED, MOST_SECTIONS};
use crate::scene::{Arrangement, PartLook, PartStyle, Presence, Scene, Section};
use crate::session::configuration::Configuration;
use crate::session::tests::scene_of;
use crate::settings::Settings;

/// Parts in groups, of one name, with names that a shell or an option could take for something else.
fn scene() -> Scene {
    scene_of(&[
        "gear/planet/wheel",
        "gear/planet/pin",
        "gear/sun/wheel",
        "gear/ring",
        "gear",
        "bolt",
        "bolt",
        "-x",
        "it's $5",
        "a:b=c,d",
        "",
    ])
}

fn looks() -> impl Strategy<Value = PartLook> {
    let presence = prop_oneof![Just(Presence::Shown), Just(Presence::Ghosted), Just(Presence::Hidden)];
    let style = prop_oneof![3 => Just(PartStyle::AsSet), 1 => Just(PartStyle::Solid)];
    let opacity = prop_oneof![2 => Just(1.0), 1 => 0.0..=1.0];
    let byte = any::<[u8; 3]>().prop_map(|rgb| rgb.map(|b| f64::from(b) / 255.0));
    let color = prop_oneof![Just(None), byte.prop_map(Some), prop::array::uniform3(0.0..=1.0).prop_map(Some)];
    (presence, opacity, color, style).prop_map(|(presence, opacity, color, style)| PartLook {
        presence,
        opacity,
        color,
        style,
    })
}

fn sections() -> impl Strategy<Value = Section> {
    let axis = prop_oneof![Just(DVec3::X), Just(DVec3::Y), Just(DVec3::Z)];
    let axis = (axis, any::<bool>()).prop_map(|(axis, back)| if back { -axis } else { axis });
    let any_way = prop::array::uniform3(-1.0..=1.0).prop_filter_map("a direction", |v| DVec3::from(v).try_normalize());
    let normal = prop_oneof![axis, any_way];
    (normal, -1e3..1e3, any::<bool>(), any::<bool>()).prop_map(|(normal, offset, enabled, caps)| Section {
        normal,
        offset,
        enabled,
        caps,
    })
}

fn arrangements(parts: u32) -> impl Strategy<Value = Arrangement> {
    let explode = prop_oneof![Just(0.0), 0.0..=MOST_EXPLODED];
    let looked = prop::collection::btree_map(0..parts, looks(), 0..=parts as usize);
    let selected = prop::collection::btree_set(0..parts, 0..=parts as usize);
    (looked, explode, prop::collection::vec(sections(), 0..=MOST_SECTIONS), selected).prop_map(
        |(mut parts, explode, sections, selected)| {
            // As the window keeps them.
            parts.retain(|_, look| *look != PartLook::default());
            Arrangement { parts, explode, sections, selected }
        },
    )
}

/// What the program makes of these words, for a scene that is there already.
fn read(words: &[String], scene: &Scene) -> Result<Arrangement, String> {
    let cli = Cli::try_parse_from(words).map_err(|e| e.to_string())?;
    let Some(Command::Render(args)) = cli.command else { return Err("it is not rendered".to_owned()) };
    let mut arrangement = Arrangement::default();
    args.view.parts.apply(&mut arrangement, scene).map_err(|e| e.message)?;
    args.view.sections.apply(&mut arrangement, scene).map_err(|e| e.message)?;
    arrangement.check(scene).map_err(|e| e.to_string())?;
    Ok(arrangement)
}

proptest! {
    #[test]
    fn an_arrangement_survives_the_command_line(arrangement in arrangements(11)) {
        let scene = Arc::new(scene());
        prop_assert_eq!(scene.parts.len(), 11);
        let camera = camera::first(&scene.bounds(), 1.0);
        let seen = Seen { settings: Settings::default(), camera, arrangement };
        let document = Document::new("model.glb".to_owned(), Arc::clone(&scene), seen);
        let words = command_line::words(&document, &Configuration::default(), [64, 48]).unwrap();
        let again = read(&words, &scene).map_err(|e| TestCaseError::fail(format!("{words:?}: {e}")))?;
        prop_assert_eq!(again, document.seen.arrangement, "{:?}", words);
    }
}

/// The words of a document and what the program makes of them.
fn asked(document: &Document) -> (Vec<String>, Box<super::options::RenderArgs>) {
    let words = command_line::words(document, &Configuration::default(), [30, 20]).unwrap();
    let cli = Cli::try_parse_from(&words).unwrap_or_else(|e| panic!("{words:?}: {e}"));
    match cli.command {
        Some(Command::Render(args)) => (words, args),
        _ => panic!("{words:?}"),
    }
}

#[test]
fn every_setting_and_the_camera_survive_the_command_line() {
    let scene = Arc::new(scene());
    let camera = camera::spun(&camera::first(&scene.bounds(), 1.5), DVec3::ZERO, 33.0);
    let mut all = Settings::default();
    let mut cases = Vec::new();
    for declaration in Settings::declarations() {
        let mut one = Settings::default();
        for settings in [&mut one, &mut all] {
            settings.set(&declaration.path, &declaration.another()).unwrap();
        }
        cases.push((declaration.path, one));
    }
    cases.push(("all of them".to_owned(), all));
    for (what, settings) in cases {
        let seen = Seen { settings, camera, arrangement: Arrangement::default() };
        let document = Document::new("builtin:stack".to_owned(), Arc::clone(&scene), seen);
        let (words, args) = asked(&document);
        let again = args.view.asked(&Configuration::default()).unwrap_or_else(|e| panic!("{words:?}: {e:?}"));
        assert_eq!((again.size, &again.settings), ([30, 20], &document.seen.settings), "{what}");
        let again = args.view.camera.camera(&scene, 1.5).unwrap_or_else(|e| panic!("{words:?}: {e:?}"));
        let way = (again.position - camera.position).length() + (again.direction() - camera.direction()).length();
        assert!(way < 1e-9, "{what}: {again:?}");
    }
}
