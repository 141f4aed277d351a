//! The mouse on the picture: drags, clicks, the wheel, and resting.
//!
//! It changes the [`Workspace`] and puts what needs more than that into its asks, so that all of it runs without a window in
//! tests.

use std::time::{Duration, Instant};

use glam::DVec2;

use super::camera::{self, Button, Held, Motion};
use super::pictures::Wish;
use super::workspace::{Ask, Workspace};

/// A drag of fewer pixels is a click.
const CLICK: f64 = 4.0;
/// A cursor that moves fewer pixels rests.
const REST: f64 = 2.0;
/// How long the cursor rests before what is under it is looked up.
pub const HOVERS: Duration = Duration::from_millis(180);
/// Turning the wheel is one gesture until it rests so long.
pub const WHEEL_RESTS: Duration = Duration::from_millis(300);
/// Most notches that one event counts for.
const MOST_NOTCHES: f64 = 50.0;

/// A drag on the picture.
#[derive(Clone, Copy, Debug)]
struct Drag {
    button: Button,
    motion: Option<Motion>,
    from: DVec2,
    at: DVec2,
    /// Pixels that it has gone.
    moved: f64,
}

/// The cursor and what is held.
#[derive(Clone, Copy, Debug, Default)]
pub struct Hand {
    /// Keys that are held.
    pub held: Held,
    /// Where the cursor is, physical pixels of the window.
    pub cursor: DVec2,
    drag: Option<Drag>,
    wheel_at: Option<Instant>,
    /// Where the cursor rests on the picture, and since when.
    rests: Option<(DVec2, Instant)>,
}

impl Hand {
    /// The cursor, from the picture's left top.
    fn pixel(&self, workspace: &Workspace) -> DVec2 {
        self.cursor - DVec2::from(workspace.viewport.origin.map(f64::from))
    }

    /// The pixel of the picture that the cursor is on, if it is on one.
    fn picture_pixel(&self, workspace: &Workspace) -> Option<[u32; 2]> {
        let at = self.pixel(workspace);
        let inside = workspace.viewport.contains(self.cursor);
        inside.then_some([at.x as u32, at.y as u32])
    }

    /// Whether the wheel has been turned a moment ago.
    pub fn is_wheeling(&self) -> bool {
        self.wheel_at.is_some_and(|at| at.elapsed() < WHEEL_RESTS)
    }

    /// When turning the wheel becomes a step, if that is still to come.
    pub fn wheel_rests_at(&self) -> Option<Instant> {
        self.wheel_at.map(|at| at + WHEEL_RESTS).filter(|at| *at > Instant::now())
    }

    /// Another model: what was begun is forgotten.
    pub fn let_go(&mut self) {
        self.drag = None;
        self.rests = None;
    }

    /// The button of the drag under way.
    pub fn dragging(&self) -> Option<Button> {
        self.drag.map(|d| d.button)
    }

    /// A button goes down; `over` says that nothing lies over the picture there.
    pub fn pressed(&mut self, workspace: &mut Workspace, button: Button, over: bool) {
        self.rests = None;
        workspace.hover = None;
        if self.drag.is_some() || !over {
            return;
        }
        let motion = camera::motion(workspace.preferences.mouse, button, self.held);
        let at = self.pixel(workspace);
        self.drag = Some(Drag { button, motion, from: at, at, moved: 0.0 });
        if let Some(document) = &mut workspace.document {
            document.begin_gesture();
        }
    }

    /// A button comes up: the drag that it began ends, or it was a click.
    pub fn released(&mut self, workspace: &mut Workspace, button: Button) {
        let Some(drag) = self.drag.filter(|d| d.button == button) else {
            return;
        };
        self.drag = None;
        #[cfg(test)]
        if super::planted::is(super::planted::Fault::EndlessDrag) {
            return;
        }
        if let Some(document) = &mut workspace.document {
            document.end_gesture();
        }
        if drag.moved >= CLICK {
            return;
        }
        match button {
            Button::Left => self.click(workspace),
            Button::Right => self.ask(workspace, Wish::List),
            Button::Middle => {}
        }
    }

    /// Picks what is under the cursor; once more on the same place is for what lies behind it.
    fn click(&self, workspace: &mut Workspace) {
        let Some(pixel) = self.picture_pixel(workspace) else {
            return;
        };
        if workspace.measure.on {
            if !workspace.measure_next(pixel) {
                self.ask(workspace, Wish::Measure);
            }
        } else if !workspace.pick_next(pixel, self.held.ctrl) {
            self.ask(workspace, Wish::Select { more: self.held.ctrl });
        }
    }

    fn ask(&self, workspace: &mut Workspace, wish: Wish) {
        if let Some(pixel) = self.picture_pixel(workspace)
            && workspace.document.is_some()
        {
            workspace.asks.push(Ask::Pick(pixel, wish));
        }
    }

    /// The cursor moves, and the camera with it if a drag is under way; says whether the camera did.
    pub fn moved(&mut self, workspace: &mut Workspace, to: DVec2, over: bool) -> bool {
        self.cursor = to;
        if self.rests.is_none_or(|(at, _)| (at - to).length() > REST) || !over {
            self.rests = (over && self.drag.is_none()).then(|| (to, Instant::now()));
            if workspace.hover.take().is_some() {
                workspace.asks.push(Ask::Redraw);
            }
        }
        let pixel = self.pixel(workspace);
        let frame = workspace.viewport.frame();
        let (Some(drag), Some(document)) = (&mut self.drag, &mut workspace.document) else {
            return false;
        };
        let delta = pixel - drag.at;
        drag.at = pixel;
        drag.moved += delta.length();
        if drag.moved < CLICK {
            return false;
        }
        let camera = document.seen.camera;
        let pivot = workspace.pivot.unwrap_or(camera.focal_point);
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
        true
    }

    /// The wheel turns over the picture, away from the hand by so many notches.
    pub fn wheel(&mut self, workspace: &mut Workspace, notches: f64) {
        let frame = workspace.viewport.frame();
        let pixel = self.pixel(workspace);
        workspace.hover = None;
        if let Some(document) = &mut workspace.document {
            let factor = camera::zoom_of_wheel(notches.clamp(-MOST_NOTCHES, MOST_NOTCHES));
            document.seen.camera = camera::zoom(&document.seen.camera, frame, pixel, factor, &document.scene.bounds());
            self.wheel_at = Some(Instant::now());
        }
    }

    /// When what is under the resting cursor is to be looked up: only where nothing is known of it, and only once the exact
    /// picture is there, so that it never competes with one. The pixel comes with it.
    pub fn hovers(&self, workspace: &Workspace) -> Option<(Instant, [u32; 2])> {
        let (_, since) = self.rests?;
        let idle = self.drag.is_none() && workspace.is_exact() && workspace.hover.is_none();
        let wanted = workspace.preferences.hover && workspace.layout.stack.is_none();
        let pixel = self.picture_pixel(workspace)?;
        (idle && wanted).then_some((since + HOVERS, pixel))
    }
}
