//! What a worker draws with: a device with a scene on it, and what was drawn ahead of previews of other light.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Instant;

use super::LONGEST_AGAIN;
use super::desk::lock;
use crate::app::pictures::Order;
use crate::app::pictures::lowered::lowered;
use crate::app::pictures::pace::{Change, Paces};
use crate::gpu::Timing;
use crate::plan::Capture;
use crate::render::{Frame, GpuScene, Kept, RenderError, Renderer};
use crate::scene::{Arrangement, Scene};
use crate::settings::Settings;

/// A device with a scene on it.
pub(super) struct Bench {
    pub(super) renderer: Renderer,
    pub(super) software: bool,
    pub(super) scene: Option<Uploaded>,
    /// The model itself, where the scene is a simpler one and something was drawn ahead.
    pub(super) model: Option<Uploaded>,
    /// Set while the layers that the renderer keeps are those of what was drawn ahead.
    pub(super) ahead: Option<Ahead>,
    /// The capture whose sorts are compiled for lists of any length.
    pub(super) warm: Option<Capture>,
}

/// A scene on the device.
pub(super) struct Uploaded {
    pub(super) number: u64,
    /// What was uploaded: the model, or a simpler one.
    pub(super) source: Arc<Scene>,
    pub(super) scene: GpuScene,
    pub(super) arrangement: Arrangement,
}

impl Uploaded {
    pub(super) fn new(renderer: &mut Renderer, source: &Arc<Scene>, number: u64) -> Result<Uploaded, RenderError> {
        let scene = renderer.load(source)?;
        Ok(Uploaded { number, source: Arc::clone(source), scene, arrangement: Arrangement::default() })
    }

    pub(super) fn arrange(&mut self, renderer: &mut Renderer, arrangement: &Arrangement) -> Result<(), RenderError> {
        if self.arrangement != *arrangement {
            renderer.arrange(&mut self.scene, &self.source, arrangement)?;
            self.arrangement = arrangement.clone();
        }
        Ok(())
    }
}

/// How something was drawn ahead.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Ahead {
    /// Width and height.
    pub(super) size: [u32; 2],
    /// Of which viewport.
    pub(super) viewport: [u32; 2],
    /// What its capture took, and all else.
    pub(super) milliseconds: f64,
}

impl Ahead {
    /// What becomes of it where previews are to have the size `paced`. Finer ones wait for the next time, because another size
    /// captures all anew; coarser ones are needed now.
    pub(super) fn at(self, paced: [u32; 2]) -> Option<Ahead> {
        let coarser = paced[0] < self.size[0] || paced[1] < self.size[1];
        match coarser {
            false => Some(self),
            true => (self.milliseconds <= LONGEST_AGAIN).then_some(Ahead { size: paced, ..self }),
        }
    }
}

impl Bench {
    /// Draws an order at the size that previews of other light have: once to capture its layers, if need be, and twice with
    /// them. Gives the time of the faster; `None` if there is something else to do, or layers are not kept.
    pub(super) fn rehearse(
        &mut self,
        order: &Order,
        pace: &Mutex<Paces>,
        cancel: &AtomicBool,
    ) -> Result<Option<f64>, RenderError> {
        let size = lock(pace).of(Change::Light).size(order.size);
        let settings = lowered(&order.seen.settings, divisor(order.size, size));
        let Some(Uploaded { scene, .. }) = self.model.as_ref().or(self.scene.as_ref()) else {
            return Ok(None);
        };
        let mut captured = None;
        let mut fastest: Option<f64> = None;
        for _ in 0..3 {
            // What is there stays there: only a frame that has begun can lose it.
            if cancel.load(Ordering::Relaxed) {
                return Ok(None);
            }
            let before = self.ahead.take();
            let begin = Instant::now();
            // A capture is passes one by one, so that it can be called off between them.
            let usual = self.renderer.timing;
            if self.software && before.is_none() && captured.is_none() {
                self.renderer.timing = Timing::Serial;
            }
            let frame = render(&mut self.renderer, scene, order, &settings, size);
            self.renderer.timing = usual;
            let kept = frame?.report.kept;
            let milliseconds = begin.elapsed().as_secs_f64() * 1e3;
            tracing::debug!("ahead {}: {size:?} in {milliseconds:.1} ms, kept: {kept:?}", order.number);
            if kept == Kept::Features {
                // Of an earlier rest, perhaps.
                let capture = captured.or(before.map(|b| b.milliseconds)).unwrap_or(milliseconds);
                self.ahead = Some(Ahead { size, viewport: order.size, milliseconds: capture });
                if let Some(first) = fastest {
                    return Ok(Some(milliseconds.min(first)));
                }
                fastest = Some(milliseconds);
            } else if captured.replace(milliseconds).is_some() {
                // It leaves no layers behind that could be kept.
                return Ok(None);
            }
        }
        Ok(None)
    }

    /// What the renderer keeps layers of.
    pub(super) fn drawn(&self) -> Option<&Uploaded> {
        self.ahead.and(self.model.as_ref()).or(self.scene.as_ref())
    }
}

/// What is ordered, with these settings and so large.
pub(super) fn render(
    renderer: &mut Renderer,
    scene: &GpuScene,
    order: &Order,
    settings: &Settings,
    size: [u32; 2],
) -> Result<Frame, RenderError> {
    match &order.extras.transfer {
        Some(transfer) => renderer.render_with(scene, &order.seen.camera, settings, transfer, size),
        None => renderer.render(scene, &order.seen.camera, settings, size),
    }
}

/// By how much a preview of this size is coarser than the viewport.
pub(super) fn divisor(viewport: [u32; 2], size: [u32; 2]) -> f64 {
    f64::from(viewport[1].max(1)) / f64::from(size[1].max(1))
}
