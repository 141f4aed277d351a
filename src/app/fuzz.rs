//! Random events against everything of the window but the window: mouse, keys, panels, files, answers of threads.
//!
//! What winit, the threads and the dialogs would do is done here in a few lines; the rest is the code that runs in the window.
//! After every event what is seen must be sound: it fits the model, all of it is in range, and undo leads back to sound values.

use std::panic::catch_unwind;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use egui::{Event, Modifiers, PointerButton, Pos2, RawInput, Rect, vec2};
use glam::{DVec2, DVec3};
use winit::keyboard::{Key, KeyCode, NamedKey, PhysicalKey, SmolStr};

use super::camera::{self, Button, Held};
use super::config::Preferences;
use super::dialogs::{self, Choice, Prompt};
use super::document::Seen;
use super::hand::Hand;
use super::loader::Loading;
use super::panels::{self, style};
use super::pictures::{Picked, Wish};
use super::planted::{self, Fault};
use super::workspace::{Ask, Workspace};
use super::{exports, keys};
use crate::export::glb::write_glb;
use crate::plan::Capabilities;
use crate::render::PickedLayer;
use crate::scene::builtin;
use crate::scene::builtin::Random;
use crate::settings::Settings;

const EVENTS: u32 = 2000;

/// A number below `n`.
fn below(random: &mut Random, n: u32) -> u32 {
    (random.bits() % u64::from(n.max(1))) as u32
}

fn real(random: &mut Random, from: f64, to: f64) -> f64 {
    from + (to - from) * f64::from(below(random, 1 << 20)) / f64::from(1 << 20)
}

/// Something that an event did wrong.
fn check(seen: &Seen, workspace: &Workspace) -> Result<(), String> {
    let document = workspace.document.as_ref().ok_or("no model")?;
    seen.arrangement.check(&document.scene).map_err(|e| e.to_string())?;
    if !camera::is_sound(&seen.camera) {
        return Err(format!("{:?}", seen.camera));
    }
    // A settings file accepts exactly what is in range.
    let text = seen.settings.to_toml().map_err(|e| e.to_string())?;
    let back = Settings::from_toml(&text).map_err(|e| e.to_string())?;
    if back != seen.settings {
        return Err("the settings do not survive their file".to_owned());
    }
    Ok(())
}

/// Undoes everything and does it again: every step is sound and the way back leads to the same.
fn check_history(workspace: &mut Workspace) -> Result<(), String> {
    let Some(document) = &mut workspace.document else {
        return Ok(());
    };
    document.end_gesture();
    let last = document.seen.clone();
    let mut steps = 0;
    while workspace.document.as_mut().is_some_and(|d| d.undo()) {
        steps += 1;
        let seen = workspace.document.as_ref().map(|d| d.seen.clone()).ok_or("no model")?;
        check(&seen, workspace).map_err(|e| format!("{steps} steps back: {e}"))?;
    }
    let mut again = 0;
    while workspace.document.as_mut().is_some_and(|d| d.redo()) {
        again += 1;
    }
    let back = workspace.document.as_ref().is_some_and(|d| d.seen == last);
    if back && steps == again { Ok(()) } else { Err(format!("{steps} steps back, {again} forth: elsewhere")) }
}

struct Desk {
    random: Random,
    context: egui::Context,
    workspace: Workspace,
    hand: Hand,
    size: [u32; 2],
    held: Modifiers,
    files: Vec<String>,
    folder: PathBuf,
    time: f64,
}

impl Desk {
    fn new(seed: u64, folder: &Path) -> Desk {
        let write = |name: &str, bytes: &[u8]| {
            let path = folder.join(name);
            std::fs::write(&path, bytes).unwrap();
            path.to_string_lossy().into_owned()
        };
        let stack = builtin::build("stack").unwrap();
        let good = write_glb(&stack).unwrap();
        let half = &good[..good.len() / 2];
        let files = vec![
            write("good.glb", &good),
            write("half.glb", half),
            write("text.glb", b"this is no model"),
            write("empty.gltf", b""),
            write("session.toml", b"file = 'good.glb'\nsize = [0, 0]\n"),
            folder.to_string_lossy().into_owned(),
            "/no/such/file.glb".to_owned(),
            "builtin:stack".to_owned(),
            "builtin:quads?parts=3&layers=4".to_owned(),
            "builtin:quads?parts=zero".to_owned(),
            "hard-case:none".to_owned(),
            format!("hard-case:{}", crate::tradeoff::hard_cases::all().next().unwrap().1.name),
        ];
        let mut workspace = Workspace::new(Preferences::default());
        workspace.capabilities = Some(Capabilities { max_storage_buffers: 16, ..Capabilities::default() });
        let context = egui::Context::default();
        style::set_up(&context);
        Desk {
            random: Random::new(seed),
            context,
            workspace,
            hand: Hand::default(),
            size: [900, 700],
            held: Modifiers::NONE,
            files,
            folder: folder.to_owned(),
            time: 0.0,
        }
    }

    fn pick<T: Copy>(&mut self, of: &[T]) -> T {
        of[below(&mut self.random, of.len() as u32) as usize]
    }

    fn open(&mut self, file: &str) {
        let loading = Loading::begin(file, &crate::import::ImportOptions::default(), || {});
        loop {
            match loading.take() {
                Some(Ok(opened)) => {
                    self.workspace.open(file.to_owned(), opened);
                    self.hand.let_go();
                    return;
                }
                Some(Err(reason)) => return self.workspace.say(super::workspace::Gravity::Error, reason),
                None => std::thread::sleep(Duration::from_millis(1)),
            }
        }
    }

    /// A frame, as the shell draws it.
    fn frame(&mut self, mut events: Vec<Event>) {
        if self.size.contains(&0) {
            return;
        }
        self.time += 0.05;
        events.insert(0, Event::ModifiersChanged(self.held));
        let size = vec2(self.size[0] as f32, self.size[1] as f32);
        let input = RawInput {
            screen_rect: Some(Rect::from_min_size(Pos2::ZERO, size)),
            time: Some(self.time),
            events,
            ..RawInput::default()
        };
        let workspace = &mut self.workspace;
        let mut output = self.context.run_ui(input, |ui| panels::show(ui, workspace));
        // Nothing is drawn, so nothing is uploaded.
        output.textures_delta.clear();
        let held = self.context.input(|i| i.pointer.any_down());
        self.workspace.settle(held);
    }

    /// What the shell would do, as far as it needs no display.
    fn fulfil(&mut self) {
        for _ in 0..4 {
            for ask in std::mem::take(&mut self.workspace.asks) {
                match ask {
                    Ask::Open(file) => self.open(&file),
                    Ask::Pick(pixel, wish) => self.answer(pixel, wish),
                    Ask::Choose(choice) => {
                        let path = match choice {
                            Choice::Open => {
                                self.files[below(&mut self.random, self.files.len() as u32) as usize].clone()
                            }
                            _ if below(&mut self.random, 3) == 0 => "/no/such/folder/x.png".to_owned(),
                            _ => {
                                self.folder.join(format!("written.{}", choice.ending())).to_string_lossy().into_owned()
                            }
                        };
                        if below(&mut self.random, 2) == 0 {
                            self.workspace.layout.prompt = Some(Prompt::new(choice, &path));
                        } else {
                            dialogs::fulfil(&mut self.workspace, choice, &path, false);
                        }
                    }
                    Ask::Use { choice, path, typed } => {
                        // Whatever was typed, only this folder is written to.
                        let name = path.rsplit('/').next().unwrap_or_default();
                        let path = match choice {
                            Choice::Open | Choice::ImportTransfer => path,
                            _ if path.starts_with("/no/such") => path,
                            _ => self.folder.join(name).to_string_lossy().into_owned(),
                        };
                        dialogs::fulfil(&mut self.workspace, choice, &path, typed);
                    }
                    Ask::Export(path) => {
                        if let Ok(job) = exports::Job::of(&self.workspace, &path) {
                            assert!((1..=exports::MOST_FRAMES).contains(&job.count()));
                            assert!(job.form.size.iter().all(|n| (1..=exports::LONGEST_SIDE).contains(n)));
                        }
                    }
                    Ask::Measure(_) | Ask::StopMeasuring | Ask::DrawModels => {}
                    Ask::CancelLoading
                    | Ask::Copy(_)
                    | Ask::Redraw
                    | Ask::Restyle
                    | Ask::CancelExport
                    | Ask::Remember
                    | Ask::Quit => {}
                }
            }
        }
    }

    /// Layers as a thread finds them, sometimes of a model that is gone.
    fn answer(&mut self, pixel: [u32; 2], wish: Wish) {
        let Some(document) = &self.workspace.document else {
            return;
        };
        let (parts, of) = (document.scene.parts.len() as u32, document.seen.camera);
        let bounds = document.scene.bounds();
        let count = below(&mut self.random, 9);
        let layers = (0..count)
            .map(|i| PickedLayer {
                part: below(&mut self.random, parts),
                depth: f64::from(i),
                position: bounds.center() + DVec3::splat(real(&mut self.random, -1.0, 1.0)),
                normal: DVec3::Z,
                kappa: 0.0,
                opacity: 0.5,
            })
            .collect();
        let gone = below(&mut self.random, 8) == 0;
        let layers: Vec<PickedLayer> = layers;
        let layers = if gone {
            layers.into_iter().map(|l| PickedLayer { part: l.part + 10_000, ..l }).collect()
        } else {
            layers
        };
        let scene_number = self.workspace.scene_number.wrapping_sub(u64::from(gone));
        self.workspace.take_picked(Picked { scene_number, wish, pixel, of, layers });
    }

    fn at(&mut self) -> DVec2 {
        let out = below(&mut self.random, 20) == 0;
        let reach = |n: u32| if out { (-500.0, f64::from(n) + 500.0) } else { (0.0, f64::from(n)) };
        let ((x0, x1), (y0, y1)) = (reach(self.size[0]), reach(self.size[1]));
        DVec2::new(real(&mut self.random, x0, x1), real(&mut self.random, y0, y1)).round()
    }

    fn over(&self) -> bool {
        let at = Pos2::new(self.hand.cursor.x as f32, self.hand.cursor.y as f32);
        let layer = self.context.layer_id_at(at);
        self.workspace.viewport.contains(self.hand.cursor) && layer.is_none_or(|l| l.order == egui::Order::Background)
    }

    fn go(&mut self, to: DVec2) -> Event {
        self.hand.cursor = to;
        let over = self.over();
        self.hand.moved(&mut self.workspace, to, over);
        Event::PointerMoved(Pos2::new(to.x as f32, to.y as f32))
    }

    fn button(&mut self, button: Button, pressed: bool) -> Event {
        let over = self.over();
        if pressed {
            self.hand.pressed(&mut self.workspace, button, over);
        } else {
            self.hand.released(&mut self.workspace, button);
        }
        let pos = Pos2::new(self.hand.cursor.x as f32, self.hand.cursor.y as f32);
        let known = match button {
            Button::Left => PointerButton::Primary,
            Button::Middle => PointerButton::Middle,
            Button::Right => PointerButton::Secondary,
        };
        Event::PointerButton { pos, button: known, pressed, modifiers: self.held }
    }

    fn hold(&mut self) {
        let [shift, ctrl, alt] = [5, 4, 8].map(|n| below(&mut self.random, n) == 0);
        self.held = Modifiers { shift, ctrl, alt, command: ctrl, ..Modifiers::NONE };
        self.hand.held = Held { shift, ctrl, alt };
    }

    /// One event, whatever comes.
    fn event(&mut self) -> String {
        const BUTTONS: [Button; 4] = [Button::Left, Button::Left, Button::Middle, Button::Right];
        match below(&mut self.random, 20) {
            0..=4 => {
                let (to, button) = (self.at(), self.pick(&BUTTONS));
                self.hold();
                let mut events = vec![self.go(to)];
                self.frame(std::mem::take(&mut events));
                // Now and then again and again on the same place.
                let times = self.pick(&[1, 1, 2, 8]);
                for _ in 0..times {
                    let down = self.button(button, true);
                    let up = self.button(button, false);
                    self.frame(vec![down, up]);
                    self.fulfil();
                }
                format!("{times} {button:?} clicks at {to}")
            }
            5..=8 => {
                let (from, button) = (self.at(), self.pick(&BUTTONS));
                self.hold();
                let moved = self.go(from);
                self.frame(vec![moved]);
                let down = self.button(button, true);
                self.frame(vec![down]);
                let mut at = from;
                for _ in 0..below(&mut self.random, 6) {
                    at = self.at();
                    let moved = self.go(at);
                    self.frame(vec![moved]);
                }
                // Now and then the button comes up elsewhere, unheard.
                if below(&mut self.random, 12) == 0 {
                    self.hand.let_go();
                    if let Some(document) = &mut self.workspace.document {
                        document.end_gesture();
                    }
                    self.frame(vec![Event::PointerGone]);
                }
                let up = self.button(button, false);
                self.frame(vec![up]);
                format!("{button:?} drag from {from} to {at}")
            }
            9..=10 => {
                let to = self.at();
                let moved = self.go(to);
                let notches = self.pick(&[-1.0, 1.0, 0.0, 0.1, -400.0, 1e6, f64::NAN, f64::INFINITY]);
                if self.over() {
                    self.hand.wheel(&mut self.workspace, notches);
                }
                self.frame(vec![moved]);
                format!("wheel by {notches} at {to}")
            }
            11..=15 => {
                self.hold();
                let key = self.key();
                let typing = self.context.text_edit_focused();
                let place = PhysicalKey::Code(self.pick(&[
                    KeyCode::Digit1,
                    KeyCode::Numpad3,
                    KeyCode::Digit5,
                    KeyCode::Digit7,
                    KeyCode::KeyQ,
                ]));
                keys::press(&mut self.workspace, &key, place, self.hand.held, typing);
                let typed = match &key {
                    Key::Character(text) => vec![Event::Text(text.to_string())],
                    _ => {
                        let key =
                            self.pick(&[egui::Key::Tab, egui::Key::Enter, egui::Key::Escape, egui::Key::ArrowRight]);
                        let press = |pressed| Event::Key {
                            key,
                            physical_key: None,
                            pressed,
                            repeat: false,
                            modifiers: Modifiers::NONE,
                        };
                        vec![press(true), press(false)]
                    }
                };
                self.frame(typed);
                format!("key {key:?} with {:?}", self.hand.held)
            }
            16..=17 => {
                self.size = self.pick(&[[0, 0], [1, 1], [900, 0], [320, 240], [900, 700], [1600, 1200], [40_000, 30]]);
                self.frame(Vec::new());
                format!("size {:?}", self.size)
            }
            18 => {
                let file = self.files[below(&mut self.random, self.files.len() as u32) as usize].clone();
                self.open(&file);
                self.frame(Vec::new());
                format!("drop of {file}")
            }
            _ => {
                let wish = self.pick(&[Wish::Hover, Wish::List, Wish::Measure, Wish::Select { more: true }]);
                self.answer([30, 40], wish);
                self.frame(Vec::new());
                format!("a late answer for {wish:?}")
            }
        }
    }

    fn key(&mut self) -> Key {
        const NAMED: [NamedKey; 4] = [NamedKey::F1, NamedKey::Home, NamedKey::Escape, NamedKey::Tab];
        if below(&mut self.random, 4) == 0 {
            return Key::Named(self.pick(&NAMED));
        }
        let letters: Vec<char> = "abcdfghilmopqsvxyzZ1357-.".chars().collect();
        let letter = self.pick(&letters);
        Key::Character(SmolStr::new(letter.to_string()))
    }
}

/// So many random events.
///
/// # Errors
/// What they have done wrong, with the last of them. Whatever panics, panics.
fn fuzz(seed: u64, events: u32) -> Result<(), String> {
    let folder = tempfile::tempdir().unwrap();
    let mut desk = Desk::new(seed, folder.path());
    let mut seen = 0;
    let mut log: Vec<String> = Vec::new();
    for n in 0..events {
        if n % 250 == 0 {
            desk.open("builtin:stack");
        }
        log.push(desk.event());
        desk.fulfil();
        let tail = || log[log.len().saturating_sub(6)..].join("\n");
        if let Some(document) = &desk.workspace.document {
            seen += 1;
            check(&document.seen, &desk.workspace).map_err(|e| format!("seed {seed}, event {n}: {e}\n{}", tail()))?;
        }
        if n % 100 == 99 {
            check_history(&mut desk.workspace).map_err(|e| format!("seed {seed}, event {n}: {e}\n{}", tail()))?;
        }
    }
    assert_eq!(seen, events, "a model is always there");
    let scene = desk.workspace.document.as_ref().map(|d| Arc::clone(&d.scene)).unwrap();
    assert!(!scene.parts.is_empty());
    Ok(())
}

/// Two thousand events in all; a fault names the seed and the last events.
#[test]
fn whatever_comes_what_is_seen_stays_sound() {
    for seed in 1..=4 {
        fuzz(seed, EVENTS / 4).unwrap_or_else(|e| panic!("{e}"));
    }
}

/// What would be the use of it otherwise: broken code is found within as many events.
#[test]
fn faults_that_are_planted_are_found() {
    for fault in [Fault::LateAnswers, Fault::PastTheEnd, Fault::LostStep] {
        let broken = |seed| planted::with(fault, || catch_unwind(|| fuzz(seed, EVENTS / 4)));
        assert!((1..=4).any(|seed| !matches!(broken(seed), Ok(Ok(())))), "{fault:?}");
    }
}
