//! The mouse on the picture: drags, clicks and the wheel.

use std::sync::Arc;
use std::time::Instant;

use egui::pos2;
use glam::DVec2;
use winit::event::{MouseButton, MouseScrollDelta};

use super::{Shell, WHEEL_RESTS};
use crate::app::camera::{self, Button, Held, Motion};
use crate::app::pictures::PickOrder;

/// A drag of fewer pixels is a click.
const CLICK: f64 = 4.0;
/// A drag on the picture.
pub(super) struct Drag {
    pub(super) button: MouseButton,
    motion: Option<Motion>,
    from: DVec2,
    at: DVec2,
    /// Pixels that it has gone.
    moved: f64,
}

impl Shell {
    /// Whether the cursor is on the picture and nothing lies over it there.
    pub(super) fn over_picture(&self) -> bool {
        let at = self.cursor / f64::from(self.context.pixels_per_point());
        let layer = self.context.layer_id_at(pos2(at.x as f32, at.y as f32));
        self.workspace.viewport.contains(self.cursor) && layer.is_none_or(|l| l.order == egui::Order::Background)
    }

    /// The cursor, from the picture's left top.
    fn pixel(&self) -> DVec2 {
        self.cursor - DVec2::from(self.workspace.viewport.origin.map(f64::from))
    }

    /// A button goes down: on the picture, a drag begins.
    pub(super) fn pressed(&mut self, button: MouseButton) {
        if self.drag.is_some() || !self.over_picture() {
            return;
        }
        let held = Held {
            shift: self.held.shift_key(),
            ctrl: self.held.control_key() || self.held.super_key(),
            alt: self.held.alt_key(),
        };
        let known = match button {
            MouseButton::Left => Button::Left,
            MouseButton::Middle => Button::Middle,
            MouseButton::Right => Button::Right,
            _ => return,
        };
        let motion = camera::motion(self.workspace.preferences.mouse, known, held);
        self.drag = Some(Drag { button, motion, from: self.pixel(), at: self.pixel(), moved: 0.0 });
        if let Some(document) = &mut self.workspace.document {
            document.begin_gesture();
        }
    }

    /// A button comes up: the drag that it began ends, or it was a click.
    pub(super) fn released(&mut self, button: MouseButton) {
        if self.drag.as_ref().is_some_and(|d| d.button == button) {
            let clicked = button == MouseButton::Left && self.drag.as_ref().is_some_and(|d| d.moved < CLICK);
            self.drag = None;
            if let Some(document) = &mut self.workspace.document {
                document.end_gesture();
            }
            if clicked {
                self.click();
            }
            self.redraw();
        }
    }

    /// Picks what is under the cursor; once more on the same place is for what lies behind it.
    fn click(&mut self) {
        let pixel = self.pixel();
        let pixel = [pixel.x.max(0.0) as u32, pixel.y.max(0.0) as u32];
        if self.workspace.pick_next(pixel, self.held.control_key() || self.held.super_key()) {
            return;
        }
        if let (Some(document), Some(pictures)) = (&self.workspace.document, &self.pictures) {
            pictures.pick(PickOrder {
                scene: Arc::clone(&document.scene),
                scene_number: self.workspace.scene_number,
                seen: self.workspace.resolved(&document.seen),
                size: self.workspace.viewport.size,
                pixel,
            });
        }
    }

    /// Moves the camera with the cursor.
    pub(super) fn moved(&mut self) {
        let pixel = self.pixel();
        let frame = self.workspace.viewport.frame();
        let (Some(drag), Some(document)) = (&mut self.drag, &mut self.workspace.document) else {
            return;
        };
        let delta = pixel - drag.at;
        drag.at = pixel;
        drag.moved += delta.length();
        if drag.moved < CLICK {
            return;
        }
        let camera = document.seen.camera;
        let pivot = self.workspace.pivot.unwrap_or(camera.focal_point);
        document.seen.camera = match drag.motion {
            Some(Motion::Turntable) => camera::turntable(&camera, pivot, frame, delta),
            Some(Motion::Trackball) => camera::trackball(&camera, pivot, frame, delta),
            Some(Motion::Pan) => camera::pan(&camera, frame, delta),
            Some(Motion::Zoom) => {
                let factor = camera::zoom_of_drag(frame, delta.y);
                camera::zoom(&camera, frame, drag.from, factor, &document.scene.bounds())
            }
            None => camera,
        };
        self.order();
    }

    /// The wheel turns over the picture.
    pub(super) fn wheel(&mut self, delta: MouseScrollDelta) {
        let notches = match delta {
            MouseScrollDelta::LineDelta(_, lines) => f64::from(lines),
            MouseScrollDelta::PixelDelta(pixels) => pixels.y / 50.0,
        };
        let frame = self.workspace.viewport.frame();
        let pixel = self.pixel();
        if let Some(document) = &mut self.workspace.document {
            let factor = camera::zoom_of_wheel(notches);
            document.seen.camera = camera::zoom(&document.seen.camera, frame, pixel, factor, &document.scene.bounds());
            self.wheel_at = Some(Instant::now());
            self.repaint_at = Some(Instant::now() + WHEEL_RESTS);
        }
        self.order();
    }
}
