//! What the other tests of panels leave out, so that each panel is operated by name (`tests/program/structure.rs` counts them).

use egui::accesskit::{Role, Toggled};
use egui_kittest::kittest::NodeT;

use super::*;
use crate::app::camera::Habits;
use crate::app::config::Theme;
use crate::app::dialogs;
use crate::app::dialogs::Prompt;
use crate::app::exports::Form;
use crate::app::models;
use crate::app::pictures::Kind;
use crate::app::viewport::Shown;
use crate::app::workspace::{LoadingView, OnScreen};
use crate::import::Phase;

type Window = Harness<'static, Workspace>;

fn click(window: &mut Window, label: &str) {
    window.get_by_label(label).click();
    window.run();
}

/// Opens a menu and clicks on one of its items, whose name may go on with its keys.
fn choose(window: &mut Window, menu: &str, item: &str) {
    // A panel may have the name of a menu; its heading is no button.
    window.get_by_role_and_label(Role::Button, menu).click();
    window.run();
    let found = window.get_all_by_label_contains(item).find(|n| n.accesskit_node().role() != Role::Label);
    found.unwrap_or_else(|| panic!("{menu}: {item}")).click();
    window.run();
}

fn seen(window: &Window) -> Seen {
    window.state().document.as_ref().unwrap().seen.clone()
}

fn type_into(window: &mut Window, label: &str, text: &str) {
    window.get_by_label(label).focus();
    window.run();
    window.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::A);
    window.get_by_label(label).type_text(text);
    window.run();
}

#[test]
fn the_menu_of_files_asks_for_what_it_says() {
    let mut with_recent = workspace("stack");
    with_recent.preferences.recent = vec!["/models/pump.glb".to_owned()];
    let mut window = harness(with_recent);
    for (item, ask) in [
        ("Open…", Ask::Choose(Choice::Open)),
        ("Save session…", Ask::Choose(Choice::SaveSession)),
        ("Save picture…", Ask::Choose(Choice::SavePicture)),
        ("Quit", Ask::Quit),
    ] {
        choose(&mut window, "File", item);
        assert_eq!(std::mem::take(&mut window.state_mut().asks), [ask], "{item}");
    }
    choose(&mut window, "File", "Copy as command line");
    let asks = std::mem::take(&mut window.state_mut().asks);
    assert!(matches!(&asks[..], [Ask::Copy(line)] if line.starts_with("pellucid render builtin:stack")), "{asks:?}");
    choose(&mut window, "File", "Open recent");
    window.get_by_label("pump.glb").click();
    window.run();
    assert_eq!(std::mem::take(&mut window.state_mut().asks), [Ask::Open("/models/pump.glb".to_owned())]);
    choose(&mut window, "File", "Built-in models");
    window.get_by_label("engine").click();
    window.run();
    assert_eq!(std::mem::take(&mut window.state_mut().asks), [Ask::Open("builtin:engine".to_owned())]);
    choose(&mut window, "File", "Write pictures…");
    assert!(window.state().layout.export.is_some());
}

#[test]
fn the_menu_undoes_resets_and_moves_the_camera() {
    let mut window = harness(workspace("stack"));
    let first = seen(&window);
    choose(&mut window, "View", "Front");
    choose(&mut window, "View", "Perspective or parallel");
    let turned = seen(&window);
    assert!(turned.camera.projection != first.camera.projection && turned.camera.position != first.camera.position);
    choose(&mut window, "Edit", "Undo");
    assert_eq!(seen(&window).camera.projection, first.camera.projection);
    choose(&mut window, "Edit", "Redo");
    assert_eq!(seen(&window), turned);
    window.state_mut().document.as_mut().unwrap().seen.settings.opacity.gain = 3.0;
    choose(&mut window, "Edit", "Reset all settings");
    assert_eq!(*settings(&window), Settings::default());
    choose(&mut window, "View", "Show everything");
    assert_ne!(seen(&window).camera, turned.camera);
}

#[test]
fn the_menu_of_parts_acts_on_what_is_selected() {
    let mut window = harness(workspace("stack"));
    let presence = |w: &Window, part| arrangement(w).look(part).presence;
    window.state_mut().document.as_mut().unwrap().seen.arrangement.selected = [1].into();
    window.run();
    for (item, own, other) in [
        ("Ghost selection", Presence::Ghosted, Presence::Shown),
        ("Hide selection", Presence::Hidden, Presence::Shown),
        ("Show every part", Presence::Shown, Presence::Shown),
        ("Isolate selection", Presence::Shown, Presence::Ghosted),
    ] {
        choose(&mut window, "Parts", item);
        assert_eq!((presence(&window, 1), presence(&window, 0)), (own, other), "{item}");
    }
}

#[test]
fn the_menu_shows_and_hides_panels_and_remembers_that() {
    let mut window = harness(workspace("stack"));
    for (item, inside) in [("Parts", "Search parts"), ("Stages", "1  Capture"), ("Transfer functions", "Opacity curve")]
    {
        for there in [false, true] {
            click(&mut window, "View");
            let switch = window.get_by_role_and_label(Role::CheckBox, item);
            switch.click();
            window.run();
            window.key_press(egui::Key::Escape);
            window.run();
            assert_eq!(window.query_by_label(inside).is_some(), there, "{item}");
        }
    }
    assert!(window.state().asks.contains(&Ask::Remember));
    click(&mut window, "View");
    window.get_by_label_contains("Mouse as in").click();
    window.run();
    click(&mut window, "Blender");
    assert_eq!(window.state().preferences.mouse, Habits::Blender);
}

#[test]
fn the_style_follows_theme_and_size() {
    let mut window = harness(workspace("stack"));
    for (name, theme, dark) in [("Light", Theme::Light, false), ("Dark", Theme::Dark, true)] {
        click(&mut window, "View");
        window.get_by_label_contains("Theme").click();
        window.run();
        // A stage is called Light too; the menu comes last.
        let button = window.get_all_by_label(name).find(|n| n.accesskit_node().role() == Role::RadioButton);
        button.unwrap().click();
        window.run();
        assert_eq!((window.state().preferences.theme, window.ctx.global_style().visuals.dark_mode), (theme, dark));
        window.key_press(egui::Key::Escape);
        window.run();
    }
    click(&mut window, "View");
    window.get_by_label_contains("Size of the interface").click();
    window.run();
    click(&mut window, "125 %");
    assert_eq!((window.state().preferences.scale, window.ctx.zoom_factor()), (1.25, 1.25));
}

#[test]
fn messages_tell_how_far_loading_is_and_let_it_be_called_off() {
    let mut window = harness(workspace("stack"));
    for (phase, said) in [
        (None, "beginning, 0 %"),
        (Some((Phase::Reading, 0.5)), "reading, 50 %"),
        (Some((Phase::Images, 1.0)), "decoding images, 100 %"),
    ] {
        window.state_mut().loading = Some(LoadingView { file: "pump.glb".to_owned(), phase });
        window.run();
        window.get_by_label("Opening pump.glb");
        window.get_by_label(said);
    }
    click(&mut window, "Cancel");
    assert_eq!(std::mem::take(&mut window.state_mut().asks), [Ask::CancelLoading]);
    window.state_mut().loading = None;
    window.state_mut().refusal = Some("too deep".to_owned());
    window.state_mut().say(Gravity::Notice, "one thing\nand another");
    window.run();
    window.get_by_label("No exact picture: too deep");
    click(&mut window, "2 notices about this file");
    window.get_by_label("and another");
}

#[test]
fn a_path_that_is_of_no_use_is_asked_for_again() {
    let mut window = harness(workspace("stack"));
    window.state_mut().layout.prompt = Some(Prompt::new(Choice::SaveSession, ""));
    window.run();
    type_into(&mut window, "Path", "/no/such/folder/a.toml");
    click(&mut window, "Save");
    let Some(Ask::Use { choice, path, typed }) = window.state_mut().asks.pop() else {
        panic!("nothing was asked for");
    };
    dialogs::fulfil(window.state_mut(), choice, &path, typed);
    let kept = Prompt::new(Choice::SaveSession, "/no/such/folder/a.toml");
    assert_eq!(window.state().layout.prompt, Some(kept));
    // The desktop's dialog has let its path go; it is not replaced by a line to type into.
    window.state_mut().layout.prompt = None;
    dialogs::fulfil(window.state_mut(), choice, &path, false);
    assert_eq!(window.state().layout.prompt, None);
}

#[test]
fn a_file_that_is_there_is_replaced_only_when_told_so() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("there.toml");
    std::fs::write(&path, "old").unwrap();
    let path = path.to_string_lossy().into_owned();
    let mut window = harness(workspace("stack"));
    window.state_mut().layout.prompt = Some(Prompt::new(Choice::SaveSession, ""));
    window.run();
    type_into(&mut window, "Path", &path);
    click(&mut window, "Save");
    assert!(window.state().asks.is_empty());
    window.get_by_label("There is a file of that name. It would be replaced.");
    click(&mut window, "Replace");
    assert_eq!(window.state().asks, [Ask::Use { choice: Choice::SaveSession, path, typed: true }]);
    assert!(window.state().layout.prompt.is_none());
}

#[test]
fn nothing_is_written_over_the_open_model_or_under_a_false_name() {
    let folder = tempfile::tempdir().unwrap();
    let model = folder.path().join("own.toml");
    std::fs::write(&model, "a model").unwrap();
    let mut open = workspace("stack");
    open.document.as_mut().unwrap().file = model.to_string_lossy().into_owned();
    let other = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    for (choice, path) in [
        (Choice::SaveSession, model.to_string_lossy().into_owned()),
        (Choice::ExportTransfer, model.to_string_lossy().into_owned()),
        (Choice::SaveSession, other("a.glb")),
        (Choice::SavePicture, other("a.jpg")),
    ] {
        dialogs::fulfil(&mut open, choice, &path, false);
        assert_eq!(open.messages.pop().map(|m| m.gravity), Some(Gravity::Error), "{path}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    assert_eq!(std::fs::read_to_string(&model).unwrap(), "a model");
}

#[test]
fn the_interface_is_made_larger_and_smaller_by_keys() {
    let mut window = workspace("stack");
    let scales = [1, 1, 1, 1, -1, 0, -1, -1, -1].map(|by| {
        crate::app::panels::menu::resize(&mut window, by);
        window.preferences.scale
    });
    assert_eq!(scales, [1.25, 1.5, 2.0, 2.0, 1.5, 1.0, 0.9, 0.8, 0.8]);
    assert!(window.asks.contains(&Ask::Restyle) && window.asks.contains(&Ask::Remember));
}

#[test]
fn in_a_low_window_menus_are_scrolled() {
    let mut window = sized(egui::vec2(1280.0, 300.0), workspace("stack"));
    window.get_by_role_and_label(Role::Button, "View").click();
    window.run();
    let bottom = window.get_by_label_contains("Mouse as in").rect().bottom();
    assert!(bottom > 300.0, "{bottom}: there is something to scroll to");
    window.get_by_label("Blender").scroll_to_me();
    window.run();
    let bottom = window.get_by_label("Blender").rect().bottom();
    assert!(bottom < 300.0, "{bottom}");
    click(&mut window, "Blender");
    assert_eq!(window.state().preferences.mouse, Habits::Blender);
}

#[test]
fn messages_are_dismissed_one_by_one_or_all() {
    let mut window = harness(workspace("stack"));
    for text in ["a", "b", "c"] {
        window.state_mut().say(Gravity::Error, text);
    }
    window.run();
    click(&mut window, "Dismiss all");
    assert!(window.state().messages.is_empty());
}

#[test]
fn clicks_on_one_place_go_through_the_parts_there() {
    let mut stack = workspace("stack");
    let at = glam::DVec3::ZERO;
    let layers = [(0, at), (0, at), (1, at), (0, at), (2, at), (2, at)];
    stack.take_picked(picked(&stack, Wish::Select { more: false }, &layers));
    let mut found = Vec::new();
    for _ in 0..5 {
        let arrangement = &stack.document.as_ref().unwrap().seen.arrangement;
        found.push((arrangement.selected.iter().copied().collect::<Vec<_>>(), stack.picked.as_ref().unwrap().1));
        assert!(stack.pick_next([60, 60], false));
    }
    let expected = [(0, 0), (1, 2), (0, 3), (2, 4), (0, 0)].map(|(part, layer)| (vec![part], layer));
    assert_eq!(found, expected);
}

fn sized(size: egui::Vec2, workspace: Workspace) -> Window {
    let show = |ui: &mut egui::Ui, workspace: &mut Workspace| panels::show(ui, workspace);
    let mut window = Harness::builder().with_size(size).build_ui_state(show, workspace);
    crate::app::panels::style::set_up(&window.ctx);
    window.run();
    window
}

#[test]
fn room_is_left_for_the_picture_and_what_is_left_out_is_named() {
    let mut window = sized(egui::vec2(1280.0, 800.0), workspace("stack"));
    let picture = |w: &Window| w.state().viewport.size.map(|n| n as f32);
    window.run();
    let before = picture(&window);
    assert!(window.query_by_label_contains("no room").is_none());
    window.set_size(egui::vec2(380.0, 300.0));
    window.run();
    window.get_by_label("no room: parts, stages, editors");
    assert!(picture(&window)[0] > 350.0 && picture(&window)[1] > 200.0, "{:?}", picture(&window));
    // 640 and 480 without the harness's margins.
    window.set_size(egui::vec2(656.0, 496.0));
    window.run();
    window.get_by_label("no room: parts");
    assert!(picture(&window)[0] >= panels::room::LEAST_PICTURE.x, "{:?}", picture(&window));
    // All of it is back, as large as it was.
    window.set_size(egui::vec2(1280.0, 800.0));
    window.run();
    window.run();
    // To the pixel to which egui rounds the height of a line.
    let off = picture(&window).iter().zip(before).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(off <= 1.0, "{:?} {before:?}", picture(&window));
}

#[test]
fn in_a_low_window_the_parts_lie_on_nothing_else() {
    let mut chosen = workspace("stack");
    chosen.document.as_mut().unwrap().seen.arrangement.selected = [1].into();
    let found = picked(&chosen, Wish::Select { more: false }, &[(1, glam::DVec3::ZERO), (2, glam::DVec3::ZERO)]);
    chosen.take_picked(found);
    // What 1280×800 leaves at one and a half times the size.
    let window = sized(egui::vec2(853.0, 533.0), chosen);
    let rect = |label: &str| window.get_by_label(label).rect();
    let (search, explode) = (rect("Search parts"), window.get_all_by_label("Explode").next().unwrap().rect());
    assert!(search.bottom() + 40.0 < explode.top(), "{search:?} {explode:?}");
    let row = window.get_all_by_role(Role::Button).filter(|n| {
        let rect = n.rect();
        rect.left() < 200.0 && rect.top() > search.bottom() && rect.bottom() < explode.top()
    });
    assert!(row.count() > 0, "the tree has a row");
}

#[test]
fn messages_ask_for_a_path_where_there_is_no_dialog() {
    for (choice, word) in [(Choice::SaveSession, "Save"), (Choice::Open, "Open"), (Choice::ImportTransfer, "Import")] {
        let mut window = harness(workspace("stack"));
        window.state_mut().layout.prompt = Some(Prompt::new(choice, "old"));
        window.run();
        type_into(&mut window, "Path", "/tmp/new.toml");
        click(&mut window, word);
        assert_eq!(window.state().asks, [Ask::Use { choice, path: "/tmp/new.toml".to_owned(), typed: true }]);
        assert!(window.state().layout.prompt.is_none());
    }
}

#[test]
fn the_status_names_the_kind_of_picture() {
    let mut window = harness(workspace("stack"));
    window.get_by_label("starting the renderer");
    let now = seen(&window);
    let shown = Arc::new(Shown { serial: 1, size: [4, 3], rgba: vec![0; 48], background: None });
    let on_screen = |kind| OnScreen {
        shown: Arc::clone(&shown),
        number: 7,
        kind,
        view: (now.camera, [4, 3]),
        look: (now.settings.clone(), now.arrangement.clone()),
        size: [4, 3],
        linear: None,
        milliseconds: 1234.4,
    };
    window.state_mut().order = 7;
    window.state_mut().adapter = Some("an adapter".to_owned());
    for (kind, word) in [(Kind::Exact, "exact"), (Kind::Preview, "preview")] {
        window.state_mut().screen = Some(on_screen(kind));
        window.run();
        for label in [word, "4×3", "1\u{202f}234 ms", "an adapter"] {
            window.get_by_label(label);
        }
    }
    // An exact picture of what was seen before is none of what is seen now.
    window.state_mut().screen = Some(on_screen(Kind::Exact));
    window.state_mut().order = 8;
    window.run();
    window.get_by_label("preview");
}

#[test]
fn the_stack_acts_on_the_selection() {
    let mut window = harness(workspace("stack"));
    let at = glam::DVec3::ZERO;
    window.state_mut().document.as_mut().unwrap().seen.arrangement.selected = [2].into();
    for (button, of_two, of_one) in [
        ("Isolate the selection", Presence::Shown, Presence::Ghosted),
        ("Hide the selection", Presence::Hidden, Presence::Ghosted),
    ] {
        let list = picked(window.state(), Wish::List, &[(1, at), (2, at)]);
        window.state_mut().take_picked(list);
        window.run();
        click(&mut window, button);
        assert!(window.state().layout.stack.is_none(), "it closes");
        assert_eq!(arrangement(&window).look(2).presence, of_two, "{button}");
        assert_eq!(arrangement(&window).look(1).presence, of_one, "{button}");
    }
}

#[test]
fn the_parts_panel_lists_layers_at_the_click() {
    let mut window = harness(workspace("stack"));
    let at = glam::DVec3::ZERO;
    let found = picked(window.state(), Wish::Select { more: false }, &[(1, at), (2, at), (3, at)]);
    window.state_mut().take_picked(found);
    window.run();
    assert_eq!(arrangement(&window).selected, [1].into());
    let third = format!("3  {}", window.state().document.as_ref().unwrap().scene.parts[3].name);
    click(&mut window, &third);
    assert_eq!(arrangement(&window).selected, [3].into());
}

#[test]
fn sections_are_turned_flipped_and_left_open() {
    let mut window = harness(workspace("stack"));
    click(&mut window, "Sections");
    click(&mut window, "Add a section across x");
    let section = |w: &Window| arrangement(w).sections[0];
    let added = section(&window);
    click(&mut window, "Flip");
    assert_eq!((section(&window).normal, section(&window).offset), (-added.normal, -added.offset));
    click(&mut window, "Caps");
    assert!(!section(&window).caps);
    let list = window.get_all_by_role(Role::ComboBox).find(|n| n.value().as_deref() == Some("−x"));
    list.expect("the list of directions").click();
    window.run();
    click(&mut window, "+z");
    assert_eq!(section(&window).normal, glam::DVec3::Z);
    window.get_by_role_and_label(Role::CheckBox, "Section 1");
    let enabled = window.get_by_label("Section 1").accesskit_node().toggled();
    assert_eq!(enabled, Some(Toggled::True));
}

#[test]
fn stages_take_text_when_it_is_entered() {
    let mut window = harness(workspace("stack"));
    click(&mut window, "Picture");
    let background = |w: &Window| settings(w).image.background.clone();
    let field = |w: &Window| {
        let all: Vec<_> = w.get_all_by_label("Background").collect();
        let text = all.iter().find(|n| n.accesskit_node().role() == Role::TextInput).expect("a field").rect();
        text.center()
    };
    for (text, there) in [("#102030", "#102030"), ("no colour", "#102030")] {
        let at = field(&window);
        for pressed in [true, false] {
            let button = egui::PointerButton::Primary;
            window.event(egui::Event::PointerMoved(at));
            window.event(egui::Event::PointerButton { pos: at, button, pressed, modifiers: Default::default() });
        }
        window.run();
        window.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::A);
        window.event(egui::Event::Text(text.to_owned()));
        window.run();
        assert_ne!(background(&window), text, "not while it is typed");
        assert!(window.state().messages.is_empty());
        window.key_press(egui::Key::Enter);
        window.run();
        assert_eq!(background(&window), there);
    }
    assert!(window.state().messages.last().is_some_and(|m| m.gravity == Gravity::Error), "what is no colour is said");
}

#[test]
fn shortcuts_are_listed_and_put_away() {
    let mut window = harness(workspace("stack"));
    choose(&mut window, "Help", "Keyboard and mouse");
    assert!(window.state().layout.shortcuts);
    for (keys, what) in super::super::shortcuts::KEYS {
        assert!(window.query_all_by_label(what).next().is_some(), "{keys}");
    }
    click(&mut window, "Close window");
    assert!(!window.state().layout.shortcuts);
}

#[test]
fn the_export_panel_takes_sizes_and_frames() {
    let mut window = harness(workspace("stack"));
    window.state_mut().layout.export = Some(Form { size: [64, 48], background: true, turntable: true, frames: 72 });
    window.run();
    let frames = |w: &Window| w.state().layout.export.as_ref().map(|f| f.frames);
    window.get_by_role_and_label(Role::SpinButton, "Frames").click();
    window.run();
    window.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::A);
    window.event(egui::Event::Text("90".to_owned()));
    window.run();
    window.key_press(egui::Key::Enter);
    window.run();
    assert_eq!(frames(&window), Some(90));
    let viewport = window.state().viewport.size;
    click(&mut window, "As seen");
    assert_eq!(window.state().layout.export.as_ref().map(|f| f.size), Some(viewport));
    click(&mut window, "Close window");
    assert!(window.state().layout.export.is_none());
}

#[test]
fn the_measure_panel_chooses_the_layer_of_an_end() {
    let mut measuring = workspace("stack");
    measuring.measure.on = true;
    let (a, b) = (glam::DVec3::ZERO, glam::DVec3::new(0.0, 0.0, 2.0));
    let mut window = harness(measuring);
    for layers in [vec![(0, a), (1, -b)], vec![(2, b)]] {
        let found = picked(window.state(), Wish::Measure, &layers);
        window.state_mut().take_picked(found);
        window.run();
    }
    window.get_by_label("Length 2");
    click(&mut window, "From: which layer under the click");
    let second = format!("2  {}", window.state().document.as_ref().unwrap().scene.parts[1].name);
    click(&mut window, &second);
    window.get_by_label("Length 4");
    click(&mut window, "Close window");
    assert!(!window.state().measure.on);
}

#[test]
fn opacity_models_are_taken_by_a_click() {
    let mut window = harness(workspace("stack"));
    choose(&mut window, "View", "Compare opacity models");
    let model = OpacityModel::AngleBased;
    let image = egui::ColorImage::filled([30, 20], egui::Color32::GRAY);
    let picture = models::Picture { name: "angle-based", model, image, texture: None };
    window.state_mut().models.as_mut().unwrap().take(Ok(picture));
    window.run();
    window.get_by_role_and_label(Role::Button, "angle-based").click();
    window.run();
    assert_eq!(seen(&window).settings.opacity.model, model);
    window.state_mut().undo();
    window.run();
    assert_eq!(seen(&window).settings, Settings::default());
    window.state_mut().models.as_mut().unwrap().take(Err("no adapter".to_owned()));
    window.run();
    window.get_by_label("no adapter");
    click(&mut window, "Close window");
    assert!(window.state().models.is_none());
}
