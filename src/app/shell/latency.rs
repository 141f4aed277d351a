//! How long inputs wait for the frame that shows them: logged, for the test that holds it.

use std::time::Instant;

use super::Shell;
use crate::app::pictures::Kind;

impl Shell {
    /// Logs how long inputs waited for the frame that has just been drawn.
    pub(super) fn note_latency(&mut self) {
        let Some(screen) = &self.workspace.screen else {
            return;
        };
        let ms = |came: Instant| came.elapsed().as_secs_f64() * 1e3;
        // The picture is moved along with the camera, so the frame answers whatever only moves that.
        let follows = self.picture_follows();
        let up_to = if follows { self.workspace.order } else { screen.number };
        while let Some(&(number, came)) = self.inputs.front()
            && number <= up_to
        {
            self.inputs.pop_front();
            let how = if number <= screen.number { screen.kind.name() } else { "moved" };
            tracing::debug!("answered in {:.1} ms, input {number}, {how}", ms(came));
        }
        while let Some(&(number, came)) = self.undrawn.front()
            && number <= screen.number
        {
            self.undrawn.pop_front();
            tracing::debug!("drawn in {:.1} ms, input {number}, {} {}", ms(came), screen.kind.name(), screen.number);
        }
        if let Some((number, came)) = self.last_input
            && screen.kind == Kind::Exact
            && number == screen.number
        {
            self.last_input = None;
            tracing::debug!("exact in {:.1} ms, input {number}", ms(came));
        }
    }
}
