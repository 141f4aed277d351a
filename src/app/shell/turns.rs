//! Whose turn it is: the window's frames and the previews that they show, where one processor draws both.
//!
//! A preview begins when the frame that shows the one before is on the screen and the events that came meanwhile have been
//! dealt with, so that it is one of the newest input. Until it is there, frames that could not show the input anyway wait.

use std::time::{Duration, Instant};

use winit::event_loop::ActiveEventLoop;

use super::{Release, Shell};
use crate::app::pictures::Kind;

/// How long frames wait for a preview, at most, from the frame before.
const LONGEST_WAIT: Duration = Duration::from_millis(60);
/// Share of a new time in the smoothed one.
const NEW_SHARE: f64 = 0.2;

impl Shell {
    /// Whether a frame can show what was asked for last without another picture: the view was moved at most.
    pub(super) fn picture_follows(&self) -> bool {
        let (Some(screen), Some(document)) = (&self.workspace.screen, &self.workspace.document) else {
            return false;
        };
        document.seen.settings == screen.look.0 && document.seen.arrangement == screen.look.1
    }

    /// Whether a preview is on its way without which a frame would not show what was asked for.
    pub(super) fn waits_for_preview(&self) -> bool {
        self.pictures.as_ref().is_some_and(|p| p.previewing()) && !self.picture_follows()
    }

    /// Until when a frame that only follows the pointer waits.
    pub(super) fn rests_until(&self) -> Instant {
        if self.waits_for_preview() { self.rest_until + LONGEST_WAIT } else { self.rest_until }
    }

    /// Takes account of how long a frame took that shows a preview for the first time.
    pub(super) fn note_turn(&mut self, shown: Option<(u64, Kind)>, milliseconds: f64) {
        let Some((number, Kind::Preview)) = shown else {
            return;
        };
        if self.turned == Some(number) {
            return;
        }
        self.turned = Some(number);
        self.frame_time = match self.frame_time {
            0.0 => milliseconds,
            time => time + NEW_SHARE * (milliseconds - time),
        };
        if let Some(pictures) = &self.pictures {
            pictures.frame_takes(self.frame_time);
        }
    }

    /// Lets the next preview begin, if its turn has come; says whether the loop has to come by again at once.
    pub(super) fn take_turns(&mut self, event_loop: &ActiveEventLoop) -> bool {
        match self.release {
            Release::None => false,
            Release::Soon => {
                self.release = Release::Now;
                true
            }
            Release::Now => {
                self.release = Release::None;
                // What has been moved on a panel is asked for now, and drawn with the preview.
                if !self.unseen.is_empty()
                    && let Some(laid) = self.lay_out(event_loop)
                {
                    let at = laid.again.map_or(self.rests_until(), |at| at.min(self.rests_until()));
                    self.repaint_at = Some(self.repaint_at.map_or(at, |before| before.min(at)));
                    self.fulfil(event_loop);
                }
                if let Some(pictures) = &self.pictures {
                    pictures.shown();
                }
                false
            }
        }
    }
}
