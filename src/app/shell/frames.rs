//! A frame of the window: laid out by egui, then drawn. The one goes without the other where only events have to be seen.

use std::time::{Duration, Instant};

use egui::ViewportId;
use winit::event_loop::ActiveEventLoop;

use super::{LONGEST_REST, Release, Shell, workshop};
use crate::app::loader::Loading;
use crate::app::panels;
use crate::app::surface::Drawn;
use crate::app::watch::Watch;
use crate::app::workspace::{Gravity, LoadingView};

/// A frame before it is drawn.
pub(super) struct LaidOut {
    shapes: Vec<egui::epaint::ClippedShape>,
    pixels_per_point: f32,
    /// When egui wants to be asked again.
    pub(super) again: Option<Instant>,
}

impl Shell {
    /// Shows egui what has come and asks for the picture that is to be seen then; gives what is to be drawn, if the window has
    /// a size. What changes of textures is kept until something is drawn.
    pub(super) fn lay_out(&mut self, event_loop: &ActiveEventLoop) -> Option<LaidOut> {
        let view = |l: &Loading| LoadingView { file: l.file.clone(), phase: l.phase() };
        self.workspace.loading = self.loading.as_ref().map(view);
        let open = self.open.as_mut()?;
        let size = open.window.inner_size();
        if size.width == 0 || size.height == 0 {
            return None;
        }
        let input = open.egui.take_egui_input(&open.window);
        let workspace = &mut self.workspace;
        let output = self.context.run_ui(input, |ui| panels::show(ui, workspace));
        self.places.note(output.platform_output.accesskit_update.as_ref(), output.pixels_per_point);
        open.egui.handle_platform_output_with_event_loop(&open.window, event_loop, output.platform_output);
        let wheel = self.hand.is_wheeling();
        let held = self.context.input(|i| i.pointer.any_down());
        self.workspace.settle(held || wheel);
        self.order();
        self.unseen.clear();
        let waker = self.waker();
        let watch = self.watch.get_or_insert_with(|| Watch::start(workshop(), waker));
        watch.follow(self.workspace.document.as_ref().map(|d| &d.seen.settings.opacity.transfer));
        self.textures.append(output.textures_delta);
        let delay = output.viewport_output.get(&ViewportId::ROOT).map_or(Duration::MAX, |v| v.repaint_delay);
        let again = Instant::now().checked_add(delay).filter(|_| delay < Duration::from_secs(3600));
        Some(LaidOut { shapes: output.shapes, pixels_per_point: output.pixels_per_point, again })
    }

    /// Draws the window.
    pub(super) fn frame(&mut self, event_loop: &ActiveEventLoop) {
        let begin = Instant::now();
        let Some(laid) = self.lay_out(event_loop) else {
            return;
        };
        let shown = self.workspace.screen.as_ref().map(|s| (s.number, s.kind));
        let Some(open) = &mut self.open else {
            return;
        };
        let laid_out = begin.elapsed();
        let shapes = self.context.tessellate(laid.shapes, laid.pixels_per_point);
        let trace = tracing::enabled!(tracing::Level::DEBUG);
        let textures = std::mem::take(&mut self.textures);
        let drawn = open.surface.draw(&shapes, textures, laid.pixels_per_point, trace);
        if let Some(complaint) = open.surface.complaint().filter(|_| drawn != Drawn::Lost) {
            self.workspace.say(Gravity::Error, format!("The window's graphics device reports: {complaint}"));
        }
        self.frames += 1;
        self.rest_until = Instant::now() + begin.elapsed().min(LONGEST_REST);
        let milliseconds = begin.elapsed().as_secs_f64() * 1e3;
        // The tests of the window wait for this line.
        tracing::debug!(
            target: "pellucid::app::shell",
            "frame {} in {milliseconds:.1} ms, {:.1} of it layout",
            self.frames,
            laid_out.as_secs_f64() * 1e3
        );
        match drawn {
            Drawn::Presented => {
                self.reopened = 0;
                self.note_latency();
                self.note_turn(shown, milliseconds);
                self.places.note_shown(&self.workspace);
            }
            Drawn::Skipped => {}
            Drawn::Again => open.window.request_redraw(),
            Drawn::Lost => self.reopen(event_loop),
        }
        if self.release == Release::None {
            self.release = Release::Soon;
        }
        // A frame at the end of turning the wheel makes a step of it.
        let rested = self.hand.wheel_rests_at();
        self.repaint_at = [laid.again, rested].into_iter().flatten().min();
        self.fulfil(event_loop);
    }
}
