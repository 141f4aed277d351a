//! What panels, keys and the mouse have asked for, done after the frame or the event.

use std::sync::Arc;
use std::time::Instant;

use egui::pos2;
use winit::event::{ElementState, KeyEvent, MouseButton, MouseScrollDelta};
use winit::event_loop::ActiveEventLoop;

use super::{Event, Shell};
use crate::app::camera::{Button, Held};
use crate::app::exports::{Exporting, Job};
use crate::app::hand::WHEEL_RESTS;
use crate::app::models;
use crate::app::panels::style;
use crate::app::pictures::{PickOrder, Wish};
use crate::app::workspace::{Ask, Gravity};
use crate::app::{config, dialogs, keys};

/// The button as gestures know it.
pub(super) fn known(button: MouseButton) -> Option<Button> {
    match button {
        MouseButton::Left => Some(Button::Left),
        MouseButton::Middle => Some(Button::Middle),
        MouseButton::Right => Some(Button::Right),
        _ => None,
    }
}

impl Shell {
    /// Does what has been asked for.
    pub(super) fn fulfil(&mut self, event_loop: &ActiveEventLoop) {
        let asks = std::mem::take(&mut self.workspace.asks);
        let redraw = !asks.is_empty();
        for ask in asks {
            match ask {
                Ask::Open(file) => self.load(&file),
                Ask::CancelLoading => self.loading = None,
                Ask::Copy(text) => self.context.copy_text(text),
                Ask::Redraw => {}
                Ask::Restyle => style::apply(&self.context, &self.workspace.preferences),
                Ask::Pick(pixel, wish) => self.pick(pixel, wish),
                Ask::Export(path) => self.export(&path),
                Ask::DrawModels => {
                    let job = models::Job::of(&self.workspace);
                    self.models = job.map(|job| models::Drawing::begin(job, self.waker()));
                }
                Ask::Measure(wanted) => self.measure(wanted),
                Ask::StopMeasuring => self.accuracy.stop(),
                Ask::CancelExport => {
                    if let Some(exporting) = &self.exporting {
                        exporting.cancel();
                    }
                }
                Ask::Remember => {
                    if let Some(path) = config::path()
                        && let Err(reason) = self.workspace.preferences.write(&path)
                    {
                        self.workspace.say(Gravity::Error, format!("The preferences cannot be written: {reason}"));
                    }
                }
                Ask::Quit => self.quit = true,
                Ask::Choose(choice) => {
                    let proxy = self.proxy.clone();
                    let window = self.open.as_ref().map(|o| Arc::clone(&o.window));
                    let file = self.workspace.document.as_ref().map(|d| d.file.clone());
                    let converted = self.workspace.configuration.import_options().converters.into_keys().collect();
                    dialogs::choose(choice, window.as_deref(), file.as_deref(), converted, move |chosen| {
                        let _ = proxy.send_event(Event::Chosen(chosen));
                    });
                }
                Ask::Use { choice, path, typed } => {
                    dialogs::fulfil(&mut self.workspace, choice, &path, typed);
                    // It may have asked for something in turn.
                    self.fulfil(event_loop);
                }
            }
        }
        if self.quit {
            event_loop.exit();
        } else if redraw {
            self.redraw();
        }
    }

    /// Looks up the layers under a pixel.
    pub(super) fn pick(&mut self, pixel: [u32; 2], wish: Wish) {
        if let (Some(document), Some(pictures)) = (&self.workspace.document, &self.pictures) {
            pictures.pick(PickOrder {
                scene: Arc::clone(&document.scene),
                scene_number: self.workspace.scene_number,
                seen: self.workspace.resolved(&document.seen),
                size: self.workspace.viewport.size,
                pixel,
                wish,
            });
        }
    }

    /// Looks up what is under the cursor once it has rested long enough; says when to look again.
    pub(super) fn hover(&mut self) -> Option<Instant> {
        let order = self.workspace.order;
        let (at, pixel) = self.hand.hovers(&self.workspace).filter(|(_, p)| self.hovered != Some((order, *p)))?;
        if at > Instant::now() {
            return Some(at);
        }
        // Once for a picture and a place: what is not there is not looked for again and again.
        self.hovered = Some((order, pixel));
        self.pick(pixel, Wish::Hover);
        None
    }

    fn export(&mut self, path: &str) {
        if self.exporting.is_some() {
            self.workspace.say(Gravity::Error, "Pictures are being written already.");
            return;
        }
        match Job::of(&self.workspace, path) {
            Ok(job) => {
                self.exporting = Some(Exporting::begin(job, self.waker()));
                self.workspace.layout.export = None;
            }
            Err(reason) => self.workspace.say(Gravity::Error, reason),
        }
    }

    /// Takes how far pictures for files are; says whether anything is to be shown.
    pub(super) fn collect_export(&mut self) -> bool {
        let before = self.workspace.exporting;
        if let Some(result) = self.exporting.as_ref().and_then(Exporting::take) {
            self.exporting = None;
            match result {
                Ok(said) => self.workspace.say(Gravity::Note, said),
                Err(reason) => self.workspace.say(Gravity::Error, reason),
            }
        }
        self.workspace.exporting = self.exporting.as_ref().map(|e| (e.done(), e.count));
        self.workspace.exporting != before
    }

    /// Takes the pictures of opacity models; says whether anything is to be shown.
    pub(super) fn collect_models(&mut self) -> bool {
        let Some(models) = &mut self.workspace.models else {
            self.models = None;
            return false;
        };
        let drawn = self.models.as_ref().map(models::Drawing::take).unwrap_or_default();
        let any = !drawn.is_empty();
        drawn.into_iter().for_each(|outcome| models.take(outcome));
        any
    }

    /// A key; says whether it means anything.
    pub(super) fn key(&mut self, event: &KeyEvent) -> bool {
        let typing = self.context.text_edit_focused();
        // It closes the menu, and no more.
        let escape = winit::keyboard::Key::Named(winit::keyboard::NamedKey::Escape);
        if event.logical_key == escape && egui::Popup::is_any_open(&self.context) {
            return false;
        }
        if event.state == ElementState::Pressed {
            self.note_key(&event.logical_key);
            #[cfg(debug_assertions)]
            if self.is_trial(&event.logical_key) {
                return true;
            }
        }
        event.state == ElementState::Pressed
            && keys::press(&mut self.workspace, &event.logical_key, event.physical_key, self.hand.held, typing)
    }

    /// Keys by which a test breaks what may break at any time; in no build that people are given.
    #[cfg(debug_assertions)]
    fn is_trial(&mut self, key: &winit::keyboard::Key) -> bool {
        use winit::keyboard::{Key, NamedKey};
        let Some(open) = self.open.as_mut().filter(|_| std::env::var_os("PELLUCID_TRIALS").is_some()) else {
            return false;
        };
        match key {
            Key::Named(NamedKey::F8) => open.surface.lose(false),
            Key::Named(NamedKey::F9) => open.surface.lose(true),
            _ => return false,
        }
        true
    }

    /// Takes over which keys are held.
    pub(super) fn hold(&mut self, held: winit::keyboard::ModifiersState) {
        self.hand.held =
            Held { shift: held.shift_key(), ctrl: held.control_key() || held.super_key(), alt: held.alt_key() };
    }

    /// Whether the cursor is on the picture and nothing lies over it there.
    pub(super) fn over_picture(&self) -> bool {
        let at = self.hand.cursor / f64::from(self.context.pixels_per_point());
        let layer = self.context.layer_id_at(pos2(at.x as f32, at.y as f32));
        self.workspace.viewport.contains(self.hand.cursor) && layer.is_none_or(|l| l.order == egui::Order::Background)
    }

    /// The wheel turns over the picture.
    pub(super) fn wheel(&mut self, delta: MouseScrollDelta) {
        let notches = match delta {
            MouseScrollDelta::LineDelta(_, lines) => f64::from(lines),
            MouseScrollDelta::PixelDelta(pixels) => pixels.y / 50.0,
        };
        self.hand.wheel(&mut self.workspace, notches);
        self.repaint_at = Some(Instant::now() + WHEEL_RESTS);
        self.order();
    }
}
