//! A thread with a device of its own that draws what it was last asked for.

use std::collections::BTreeSet;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::Sender;
use std::sync::{Arc, Condvar, Mutex};
use std::time::Instant;

use super::lowered::{lowered, see_through};
use super::pace::{Change, Paces};
use super::simplify::simplified;
use super::{Counted, Delivery, Extras, Fault, Kind, Order, PickOrder, Picked, Picture, STILL, Wish};
use crate::app::document::Seen;
use crate::app::watch::ShaderTexts;
use crate::export::image::parse_background;
use crate::export::png::rgba8;
use crate::gpu::{Gpu, GpuError, GpuOptions, Timing};
use crate::render::{FrameReport, Kept, RenderError, Renderer};
use crate::scene::{Arrangement, Scene};

mod bench;
mod desk;
#[cfg(test)]
mod tests;

use bench::{Ahead, Bench, Uploaded, divisor, render};
use desk::{Desk, Work, lock};

/// Triangles of a preview on a software rasterizer.
const SOFTWARE_TRIANGLES: u64 = 8_000;
/// Triangles of a model that is drawn ahead there, at most: whoever moves it meanwhile waits for its upload, once, or a pass over
/// all of them.
const MOST_AHEAD: u64 = 1_000_000;
/// Sizes that are tried ahead with the hope for a finer one.
const MOST_REHEARSED: usize = 5;
/// How long a preview may take to capture the model again that was drawn ahead, milliseconds.
const LONGEST_AGAIN: f64 = 400.0;

/// A thread that draws.
pub struct Worker {
    desk: Arc<Desk>,
    kind: Kind,
    thread: Option<std::thread::JoinHandle<()>>,
}

impl Worker {
    /// Starts the thread; the device is opened there. `deliver` is called after everything sent.
    pub fn start(
        kind: Kind,
        pace: Arc<Mutex<Paces>>,
        sender: Sender<Delivery>,
        wake: Arc<dyn Fn() + Send + Sync>,
    ) -> Worker {
        let desk = Arc::new(Desk { slot: Mutex::default(), posted: Condvar::new(), cancel: Arc::default() });
        let theirs = Arc::clone(&desk);
        let run = move || {
            let cancel = Arc::clone(&theirs.cancel);
            let mut studio =
                Studio { kind, pace, bench: None, cancel, shaders: Arc::default(), refused: None, said: None };
            // Whether the window is still there.
            let deliver = |delivery: Delivery| {
                let there = sender.send(delivery).is_ok();
                wake();
                there
            };
            while let Some(work) = theirs.next() {
                let there = match work {
                    Work::Pick(order) => studio.pick(&order).is_none_or(&deliver),
                    Work::Ahead(order) => {
                        studio.draw_ahead(&order);
                        true
                    }
                    Work::Draw(order) => match studio.fill(&order) {
                        None => {
                            theirs.take_back(*order);
                            true
                        }
                        Some(Delivery::Picture(picture)) => {
                            let report = picture.report.clone();
                            theirs.finished(kind);
                            deliver(Delivery::Picture(picture))
                                && studio.afterwards(&order, &report, &theirs).into_iter().all(&deliver)
                        }
                        Some(other) => deliver(other),
                    },
                };
                theirs.rest();
                if !(there && studio.said.take().is_none_or(|text| deliver(Delivery::Said(text)))) {
                    return;
                }
            }
        };
        let thread = std::thread::Builder::new().name(kind.name().to_owned()).spawn(run).ok();
        if thread.is_none() {
            tracing::error!("no thread could be started for the {} picture", kind.name());
        }
        Worker { desk, kind, thread }
    }

    /// Asks for a picture instead of whatever was asked for before. An exact picture at work is abandoned; a preview is
    /// finished, so that there is one now and then.
    pub fn post(&self, mut order: Order) {
        let mut slot = lock(&self.desk.slot);
        if let Some(passed_over) = &slot.order {
            order.change = order.change.and(passed_over.change);
            order.same_settings &= passed_over.same_settings;
        }
        self.desk.cancel.store(self.kind == Kind::Exact || slot.ahead_at_work, Ordering::Relaxed);
        slot.order = Some(order);
        slot.ahead = None;
        self.desk.posted.notify_one();
    }

    /// Whether something is being drawn or waits to be.
    pub fn is_busy(&self) -> bool {
        let slot = lock(&self.desk.slot);
        slot.at_work || slot.order.is_some()
    }

    /// The next preview need not wait any longer.
    pub fn release(&self) {
        if lock(&self.desk.slot).shut_until.take().is_some() {
            self.desk.posted.notify_one();
        }
    }

    /// Asks for the layers under a pixel, before anything else; a picture at work is begun again afterwards. What is only
    /// hovered over waits until nothing else is wanted, and is given up for anything that is.
    pub fn pick(&self, order: PickOrder) {
        let mut slot = lock(&self.desk.slot);
        if order.wish == Wish::Hover {
            slot.hover = Some(order);
        } else {
            self.desk.cancel.store(true, Ordering::Relaxed);
            slot.pick = Some(order);
        }
        self.desk.posted.notify_one();
    }

    /// Draws this, which is shown exactly by now, for the sake of its layers: previews of other light will be of the model
    /// itself and not of a simpler one. It is given up for anything that is ordered.
    pub fn draw_ahead(&self, order: Order) {
        let mut slot = lock(&self.desk.slot);
        if slot.order.is_none() {
            slot.ahead = Some(order);
            self.desk.posted.notify_one();
        }
    }

    /// Nothing is hovered over any more.
    pub fn stop_hovering(&self) {
        lock(&self.desk.slot).hover = None;
    }

    /// Abandons everything.
    pub fn clear(&self) {
        let mut slot = lock(&self.desk.slot);
        slot.order = None;
        slot.pick = None;
        slot.hover = None;
        slot.ahead = None;
        self.desk.cancel.store(true, Ordering::Relaxed);
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        let mut slot = lock(&self.desk.slot);
        slot.closed = true;
        self.desk.cancel.store(true, Ordering::Relaxed);
        self.desk.posted.notify_one();
        drop(slot);
        if let Some(thread) = self.thread.take()
            && thread.join().is_err()
        {
            tracing::error!("the thread of the {} picture ended badly", self.kind.name());
        }
    }
}

/// What lives on the thread.
struct Studio {
    kind: Kind,
    pace: Arc<Mutex<Paces>>,
    bench: Option<Bench>,
    cancel: Arc<AtomicBool>,
    /// Texts that stand in for shader modules.
    shaders: Arc<ShaderTexts>,
    /// Those that a device has refused: the ones before are kept.
    refused: Option<Arc<ShaderTexts>>,
    said: Option<String>,
}

impl Studio {
    /// Draws what was ordered. A device that failed is given up and another one tried, once.
    fn fill(&mut self, order: &Order) -> Option<Delivery> {
        let mut result = self.attempt(order);
        if let Err(RenderError::Gpu(GpuError::Lost(_) | GpuError::Device(_) | GpuError::Exhausted)) = &result {
            tracing::warn!("{} picture: the device failed and is opened again", self.kind.name());
            self.bench = None;
            result = self.attempt(order);
        }
        if let Err(RenderError::Gpu(GpuError::Shader { file, line, reason })) = &result
            && !order.extras.shaders.is_empty()
            && self.refused.as_ref() != Some(&order.extras.shaders)
        {
            self.said = Some(format!("{file}:{line}: {} (the program's own shaders are used)", reason.trim()));
            self.refused = Some(Arc::clone(&order.extras.shaders));
            self.bench = None;
            result = self.attempt(order);
        }
        match result {
            Ok(picture) => Some(Delivery::Picture(Box::new(picture))),
            Err(RenderError::Cancelled) => None,
            Err(error) => {
                let refused = matches!(
                    error,
                    RenderError::Refused(_)
                        | RenderError::PixelTooDeep { .. }
                        | RenderError::RowTooDeep { .. }
                        | RenderError::Transfer(_)
                );
                if !refused {
                    self.bench = None;
                }
                let fault = Fault { number: order.number, kind: self.kind, message: error.to_string() };
                Some(Delivery::Fault(fault))
            }
        }
    }

    /// What comes with a picture that has just been drawn, if there is time: its layers counted, and the one that it is
    /// compared with.
    fn afterwards(&mut self, order: &Order, report: &FrameReport, desk: &Desk) -> Vec<Delivery> {
        let mut all = Vec::new();
        // Beside previews one after the other, counting would be in the way.
        let idle = |kind| if kind == Kind::Preview { desk.stays_idle(STILL) } else { desk.is_idle() };
        if order.extras.counts
            && idle(self.kind)
            && let Some(bench) = &self.bench
            && let Some(uploaded) = bench.drawn()
        {
            let begin = Instant::now();
            // Pixels of a moment ago are worth no fault: the next picture will say what is wrong.
            let counted = catch_unwind(AssertUnwindSafe(|| {
                bench.renderer.layer_histogram(report, &uploaded.scene, &order.seen.camera).ok().flatten()
            }));
            if let Ok(Some(mut counts)) = counted {
                counts.serial = 2 * order.number + u64::from(self.kind == Kind::Exact);
                let milliseconds = begin.elapsed().as_secs_f64() * 1e3;
                tracing::debug!(
                    "{} {}: {} layers counted in {milliseconds:.1} ms",
                    self.kind.name(),
                    order.number,
                    counts.map.total()
                );
                all.push(Delivery::Counts(Box::new(Counted {
                    kind: self.kind,
                    scene_number: order.scene_number,
                    seen: order.seen.clone(),
                    layers: Arc::new(counts),
                })));
            }
        }
        // The next view may have longer lists, or the next size find some: whose hand is waiting waits for no compiler.
        if self.kind == Kind::Preview
            && let Some(bench) = self.bench.as_mut().filter(|b| b.warm != Some(report.plan.capture))
            && desk.stays_idle(STILL)
        {
            bench.warm = Some(report.plan.capture);
            if let Err(error) = bench.renderer.warm_up(&report.plan) {
                tracing::warn!("sorts of longer lists could not be compiled: {error}");
            }
        }
        if self.kind == Kind::Exact
            && desk.is_idle()
            && let Some(against) = &order.extras.against
        {
            let mut other = order.clone();
            other.seen.settings = against.settings.clone();
            other.extras = Extras {
                transfer: Some(Arc::clone(&against.transfer)),
                against: None,
                shaders: Arc::clone(against.shaders.as_ref().unwrap_or(&order.extras.shaders)),
                ..order.extras.clone()
            };
            match self.fill(&other) {
                Some(Delivery::Picture(picture)) => all.push(Delivery::Compared(picture)),
                Some(Delivery::Fault(fault)) => {
                    all.push(Delivery::Said(format!("There is no exact picture of A: {}", fault.message)));
                }
                _ => {}
            }
        }
        all
    }

    /// Makes the device take over texts of shaders.
    fn take_shaders(&mut self, wanted: &Arc<ShaderTexts>) {
        if *wanted == self.shaders || self.refused.as_ref() == Some(wanted) {
            return;
        }
        if let Some(bench) = &mut self.bench {
            let modules: BTreeSet<&String> = self.shaders.keys().chain(wanted.keys()).collect();
            for module in modules {
                bench.renderer.replace_shader(module, wanted.get(module).cloned());
            }
        }
        self.shaders = Arc::clone(wanted);
    }

    fn attempt(&mut self, order: &Order) -> Result<Picture, RenderError> {
        // wgpu may panic after a device is lost.
        match catch_unwind(AssertUnwindSafe(|| self.draw(order))) {
            Ok(result) => result,
            Err(_) => {
                self.bench = None;
                Err(GpuError::Lost("the renderer panicked; the log says where".to_owned()).into())
            }
        }
    }

    /// The device, with the scene on it and its parts arranged.
    fn prepare(
        &mut self,
        scene: &Arc<Scene>,
        number: u64,
        arrangement: &Arrangement,
    ) -> Result<&mut Bench, RenderError> {
        if self.bench.is_none() {
            // A new device knows none.
            self.shaders = Arc::default();
            let gpu = Gpu::new(&GpuOptions::default())?;
            let software = gpu.facts().device_type == "Cpu";
            let mut renderer = Renderer::new(gpu)?;
            renderer.cancel = Some(Arc::clone(&self.cancel));
            renderer.keeps_layers = true;
            if self.kind == Kind::Exact && software {
                // Passes one by one: they can be cancelled in between, and their times are right.
                renderer.timing = Timing::Serial;
            } else if software {
                // Of passes at once no times are known there.
                renderer.timing = Timing::Off;
            }
            self.bench = Some(Bench { renderer, software, scene: None, model: None, ahead: None, warm: None });
        }
        let Some(bench) = &mut self.bench else {
            return Err(RenderError::Cancelled);
        };
        if bench.scene.as_ref().is_none_or(|s| s.number != number) {
            (bench.scene, bench.model, bench.ahead) = (None, None, None);
            let coarse = if self.kind == Kind::Preview && bench.software {
                simplified(scene, SOFTWARE_TRIANGLES).map(Arc::new)
            } else {
                None
            };
            let source = coarse.unwrap_or_else(|| Arc::clone(scene));
            bench.scene = Some(Uploaded::new(&mut bench.renderer, &source, number)?);
            lock(&self.pace).restart();
        }
        if let Some(uploaded) = &mut bench.scene {
            uploaded.arrange(&mut bench.renderer, arrangement)?;
        }
        Ok(bench)
    }

    /// Draws an order for nothing but the layers, which previews of other light will keep. What fails is left to the exact
    /// picture to say.
    fn draw_ahead(&mut self, order: &Order) {
        match catch_unwind(AssertUnwindSafe(|| self.try_ahead(order))) {
            Ok(Ok(()) | Err(RenderError::Cancelled)) => {}
            Ok(Err(error)) => {
                tracing::debug!("nothing is drawn ahead: {error}");
                if matches!(error, RenderError::Gpu(_)) {
                    self.bench = None;
                }
            }
            Err(_) => self.bench = None,
        }
    }

    fn try_ahead(&mut self, order: &Order) -> Result<(), RenderError> {
        let pace = Arc::clone(&self.pace);
        self.prepare(&order.scene, order.scene_number, &order.seen.arrangement)?;
        self.take_shaders(&order.extras.shaders);
        let cancel = Arc::clone(&self.cancel);
        let bench = self.prepare(&order.scene, order.scene_number, &order.seen.arrangement)?;
        let is_simpler = bench.scene.as_ref().is_none_or(|s| !Arc::ptr_eq(&s.source, &order.scene));
        if is_simpler {
            if order.scene.triangle_count() > MOST_AHEAD {
                return Ok(());
            }
            if bench.model.is_none() {
                bench.model = Some(Uploaded::new(&mut bench.renderer, &order.scene, order.scene_number)?);
            }
            if let Some(model) = &mut bench.model {
                model.arrange(&mut bench.renderer, &order.seen.arrangement)?;
            }
        }
        let (mut sizes, mut refined, mut may_refine) = (0, false, true);
        // Rehearsed until the size is one that will do: a hand that drags is not to wait for another capture.
        lock(&pace).of(Change::Light).rests();
        while let Some(fastest) = bench.rehearse(order, &pace, &cancel)? {
            sizes += 1;
            let mut pace = lock(&pace);
            let pace = pace.of(Change::Light);
            let before = pace.divisor();
            let changes = pace.rehearsed(fastest, may_refine && sizes < MOST_REHEARSED);
            if !changes {
                break;
            }
            // Once a finer one was too slow, none is tried again.
            let is_finer = pace.divisor() < before;
            (refined, may_refine) = (refined || is_finer, may_refine && (is_finer || !refined));
        }
        // Something else came up before the last size was tried.
        if let Some(ahead) = bench.ahead {
            lock(&pace).of(Change::Light).settle(order.size, ahead.size);
        }
        Ok(())
    }

    /// The layers under a pixel. What fails is said, and nothing is picked. A device that failed is given up and another one
    /// tried, once.
    fn pick(&mut self, order: &PickOrder) -> Option<Delivery> {
        for _ in 0..2 {
            let result = catch_unwind(AssertUnwindSafe(|| {
                let bench = self.prepare(&order.scene, order.scene_number, &order.seen.arrangement)?;
                let Some(uploaded) = &bench.scene else {
                    return Ok(Vec::new());
                };
                let Seen { camera, settings, .. } = &order.seen;
                bench.renderer.pick(&uploaded.scene, camera, settings, order.size, order.pixel)
            }));
            match result {
                Ok(Ok(layers)) => {
                    return Some(Delivery::Picked(Picked {
                        scene_number: order.scene_number,
                        wish: order.wish,
                        pixel: order.pixel,
                        of: order.seen.camera,
                        layers,
                    }));
                }
                Ok(Err(RenderError::Cancelled)) => return None,
                Ok(Err(error)) => {
                    tracing::warn!("nothing could be picked: {error}");
                    if !matches!(error, RenderError::Gpu(_)) {
                        return None;
                    }
                    self.bench = None;
                }
                Err(_) => self.bench = None,
            }
        }
        None
    }

    fn draw(&mut self, order: &Order) -> Result<Picture, RenderError> {
        let (kind, pace) = (self.kind, Arc::clone(&self.pace));
        self.prepare(&order.scene, order.scene_number, &order.seen.arrangement)?;
        self.take_shaders(&order.extras.shaders);
        let bench = self.prepare(&order.scene, order.scene_number, &order.seen.arrangement)?;
        let begin = Instant::now();
        // Whatever else is drawn, its layers are kept no longer.
        let ahead = bench.ahead.take();
        let (settings, size, ahead, is_paced) = match kind {
            Kind::Exact => (order.seen.settings.clone(), order.size, None, false),
            Kind::Preview => {
                let paced = lock(&pace).of(order.change).size(order.size);
                let is_light = |a: &Ahead| order.change == Change::Light && a.viewport == order.size;
                let ahead = ahead.filter(is_light).and_then(|a| a.at(paced));
                let size = ahead.map_or(paced, |a| a.size);
                let settings = lowered(&order.seen.settings, divisor(order.size, size));
                let is_simpler = bench.scene.as_ref().is_some_and(|s| !Arc::ptr_eq(&s.source, &order.scene));
                // While settings are changed, what they do is shown, for better or worse.
                let settings = match &order.extras.transfer {
                    Some(transfer) if is_simpler && ahead.is_none() && order.same_settings => {
                        see_through(&settings, transfer)
                    }
                    _ => settings,
                };
                (settings, size, ahead, size == paced)
            }
        };
        if ahead.is_some()
            && let Some(model) = &mut bench.model
        {
            model.arrange(&mut bench.renderer, &order.seen.arrangement)?;
        }
        let Some(Uploaded { scene, .. }) = ahead.and(bench.model.as_ref()).or(bench.scene.as_ref()) else {
            return Err(RenderError::Cancelled);
        };
        let frame = render(&mut bench.renderer, scene, order, &settings, size)?;
        let background = parse_background(&settings.image.background).unwrap_or_default();
        let rgba = rgba8(&frame.image, background);
        let milliseconds = begin.elapsed().as_secs_f64() * 1e3;
        let kept = frame.report.kept;
        tracing::debug!("{} {}: {size:?} in {milliseconds:.1} ms, kept: {kept:?}", kind.name(), order.number);
        // A part of a frame says nothing about how long a whole one takes, nor a whole one about a part.
        let expected = if order.change == Change::Light { Kept::Features } else { Kept::Nothing };
        if is_paced && kept == expected {
            let mut paces = lock(&pace);
            let pace = paces.of(order.change);
            // Another size of the model itself is another capture: a finer one waits for the next rest.
            if ahead.is_some() { pace.held(milliseconds) } else { pace.measured(milliseconds) }
        }
        // Light that asks for other layers has captured them: not once more, if that takes long.
        bench.ahead = ahead.filter(|a| kept == Kept::Features || a.milliseconds <= LONGEST_AGAIN);
        Ok(Picture {
            number: order.number,
            kind,
            scene_number: order.scene_number,
            viewport: order.size,
            size,
            rgba,
            linear: (kind == Kind::Exact).then(|| Arc::new(frame.image)),
            background,
            milliseconds,
            software: bench.software,
            report: frame.report,
            seen: order.seen.clone(),
        })
    }
}
